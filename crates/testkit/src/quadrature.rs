//! Adaptive integration over rectangles and over the sphere, in `f64`.
//!
//! The rule is a product of two Gauss–Legendre rules of three points. A cell whose value changes too much when it is
//! cut in four is cut in four, and so on. That finds peaks and edges which one of the points has touched; what none has
//! touched is missed, which is why callers choose how finely a region is cut to begin with.

use std::f64::consts::{PI, TAU};

use sahl_math::Vec3;

/// Abscissae on [0, 1] and weights of the three-point Gauss–Legendre rule.
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
/// How many times a cell may be cut in four: enough for a peak of a thousandth of the cell.
const MAX_DEPTH: u32 = 10;

/// A rectangle of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Lower corner.
    pub low: [f64; 2],
    /// Upper corner.
    pub high: [f64; 2],
}

impl Cell {
    /// The cell in column `x` and row `y` of a grid of `counts` cells over this one.
    pub fn part(&self, [x, y]: [usize; 2], counts: [usize; 2]) -> Self {
        let at = |axis: usize, i: usize| {
            let t = i as f64 / counts[axis] as f64;
            self.low[axis] * (1.0 - t) + self.high[axis] * t
        };
        Self { low: [at(0, x), at(1, y)], high: [at(0, x + 1), at(1, y + 1)] }
    }

    /// The rule on this cell alone.
    fn rule(&self, f: &mut impl FnMut(f64, f64) -> f64) -> f64 {
        let size = [self.high[0] - self.low[0], self.high[1] - self.low[1]];
        let mut sum = 0.0;
        for (v, weight_v) in GAUSS {
            for (u, weight_u) in GAUSS {
                sum += weight_u * weight_v * f(self.low[0] + u * size[0], self.low[1] + v * size[1]);
            }
        }
        sum * size[0] * size[1]
    }
}

/// How an integral is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Each axis of the region is first cut into so many parts.
    pub cuts: usize,
    /// The error aimed at, in units of the result.
    pub absolute: f64,
}

/// The integral of `f(x, y)` over a rectangle.
///
/// The error is near `accuracy.absolute` for smooth integrands whose peaks the first cut resolves. Where an edge of the
/// integrand cuts off a corner that no point touches, it can be half a per cent of that cell. An integrand that is not
/// finite makes the result not finite.
pub fn integrate(mut f: impl FnMut(f64, f64) -> f64, region: Cell, accuracy: Accuracy) -> f64 {
    let cuts = accuracy.cuts.max(1);
    let tolerance = accuracy.absolute / (cuts * cuts) as f64;
    let mut sum = 0.0;
    for y in 0..cuts {
        for x in 0..cuts {
            let cell = region.part([x, y], [cuts, cuts]);
            let coarse = cell.rule(&mut f);
            sum += refine(&mut f, cell, coarse, tolerance, MAX_DEPTH);
        }
    }
    sum
}

/// The integral over `cell`, whose rule gave `coarse`, cutting it while cutting matters.
fn refine(f: &mut impl FnMut(f64, f64) -> f64, cell: Cell, coarse: f64, tolerance: f64, depth: u32) -> f64 {
    let parts = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|at| {
        let part = cell.part(at, [2, 2]);
        (part, part.rule(f))
    });
    let fine: f64 = parts.iter().map(|(_, value)| value).sum();
    // A NaN or an infinity would never settle: it ends the recursion through the negated comparison's other branch.
    if depth == 0 || !fine.is_finite() || (fine - coarse).abs() <= tolerance {
        return fine;
    }
    // The errors of the parts have either sign: half the tolerance each keeps the sum within it.
    parts.into_iter().map(|(part, value)| refine(f, part, value, tolerance * 0.5, depth - 1)).sum()
}

/// The unit vector at polar angle `theta` from +z and azimuth `phi` from +x.
pub fn spherical(theta: f64, phi: f64) -> Vec3 {
    let (sin_theta, cos_theta) = theta.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    Vec3::new((sin_theta * cos_phi) as f32, (sin_theta * sin_phi) as f32, cos_theta as f32)
}

/// The integral of `f` over the solid angle of a rectangle of `(theta, phi)`.
pub fn integrate_solid_angle(f: impl Fn(Vec3) -> f32, region: Cell, accuracy: Accuracy) -> f64 {
    integrate(|theta, phi| f64::from(f(spherical(theta, phi))) * theta.sin(), region, accuracy)
}

/// The integral of `f` over the whole sphere, to about `absolute`.
///
/// The sphere is first cut into 16 by 32 cells in `(theta, phi)`: the equator is an edge of cells, so that functions of
/// one hemisphere cost nothing extra.
pub fn integrate_sphere(f: impl Fn(Vec3) -> f32, absolute: f64) -> f64 {
    let sphere = Cell { low: [0.0, 0.0], high: [PI, TAU] };
    let counts = [16, 32];
    let accuracy = Accuracy { cuts: 1, absolute: absolute / (counts[0] * counts[1]) as f64 };
    let cells = (0..counts[1]).flat_map(|y| (0..counts[0]).map(move |x| [x, y]));
    cells.map(|at| integrate_solid_angle(&f, sphere.part(at, counts), accuracy)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Cell = Cell { low: [0.0, 0.0], high: [1.0, 1.0] };
    const FINE: Accuracy = Accuracy { cuts: 2, absolute: 1e-6 };

    #[test]
    fn polynomials_of_degree_five_are_exact() {
        let value = integrate(|x, y| 36.0 * x.powi(5) * y.powi(5), UNIT, Accuracy { cuts: 1, absolute: 1.0 });
        assert!((value - 1.0).abs() < 1e-14, "{value}");
    }

    #[test]
    fn edges_and_peaks_are_followed() {
        let disk =
            integrate(|x, y| f64::from(x * x + y * y < 1.0), UNIT, Accuracy { cuts: 16, absolute: 1e-5 });
        assert!((disk - PI / 4.0).abs() < 1e-4, "{disk}");
        let width = 0.003_f64;
        let peak = |x: f64, y: f64| (-((x - 0.4).powi(2) + (y - 0.7).powi(2)) / (2.0 * width * width)).exp();
        let value = integrate(peak, UNIT, Accuracy { cuts: 32, absolute: 1e-9 }) / (TAU * width * width);
        assert!((value - 1.0).abs() < 1e-3, "{value}");
    }

    #[test]
    fn the_sphere_has_its_area_and_the_cosine_its_integral() {
        assert!((integrate_sphere(|_| 1.0, 1e-5) - 4.0 * PI).abs() < 1e-5);
        assert!((integrate_sphere(|w| w.z.max(0.0), 1e-5) - PI).abs() < 1e-5);
        assert!((integrate_sphere(|w| w.x.max(0.0), 1e-5) - PI).abs() < 1e-4);
    }

    #[test]
    fn what_is_not_finite_shows() {
        assert!(!integrate(|x, _| if x > 0.5 { f64::NAN } else { 1.0 }, UNIT, FINE).is_finite());
        assert!(!integrate(|x, _| 1.0 / (x - x), UNIT, FINE).is_finite());
    }
}
