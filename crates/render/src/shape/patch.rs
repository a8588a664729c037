//! Emitting bilinear patches.

use sahl_math::{Bounds3, Vec2, Vec3, gamma};

use super::rectangle::{Rectangle, SphericalRectangle};
use super::{EmitterPoint, per_solid_angle};
use crate::light::Cone;
use crate::warp;

/// Rectangles that appear smaller than this are sampled by area: that has as little noise there, and costs less. The
/// solid angle, a sum of four angles in `f32`, has an error of about 4e-7 steradians.
const MIN_SOLID_ANGLE: f32 = 0.1;

/// A bilinear patch. Rectangles are sampled by solid angle, or by area where they appear small; others with a density per
/// parameter square that is the bilinear interpolation of the area elements at the corners.
#[derive(Clone, Debug)]
pub(crate) struct PatchEmitter {
    /// At (u, v) = (0,0), (1,0), (0,1), (1,1).
    corners: [Vec3; 4],
    rectangle: Option<Rectangle>,
    flip: bool,
    /// |∂p/∂u × ∂p/∂v| at the corners.
    weights: [f32; 4],
    area: f32,
    center: Vec3,
    /// The largest absolute value of each coordinate.
    reach: Vec3,
    /// Shading normals, which decide the side.
    normals: Option<[Vec3; 4]>,
}

impl PatchEmitter {
    /// The patch with the given corners. Its normal is ∂p/∂u × ∂p/∂v, turned round if `flip`, and then to the side of
    /// the interpolated shading normals if there are any.
    pub(crate) fn new(corners: [Vec3; 4], flip: bool, normals: Option<[Vec3; 4]>) -> Self {
        let rectangle = Rectangle::new(corners);
        let center = corners.iter().fold(Vec3::ZERO, |sum, &corner| sum + corner * 0.25);
        let reach = corners.iter().fold(Vec3::ZERO, |reach, corner| reach.max(corner.abs()));
        let mut patch =
            Self { corners, rectangle, flip, weights: [0.0; 4], area: 0.0, center, reach, normals };
        let element = |u: f32, v: f32| {
            let (_, du, dv) = patch.point(Vec2::new(u, v));
            du.cross(dv).length()
        };
        let weights = [element(0.0, 0.0), element(1.0, 0.0), element(0.0, 1.0), element(1.0, 1.0)];
        let area = mean_over_square(element);
        patch.weights = weights;
        patch.area = area;
        patch
    }

    pub(crate) fn area(&self) -> f32 {
        self.area
    }

    /// Whether the corners lie in a plane, but for their rounding.
    pub(super) fn is_flat(&self) -> bool {
        let [p00, p10, p01, p11] = self.corners;
        let n = (p11 - p00).cross(p01 - p10);
        self.rectangle.is_some() || n.dot(p10 - p00).abs() <= n.abs().dot(self.reach) * gamma(8)
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        Bounds3::from_points(self.corners)
    }

    /// A cone about the normals.
    ///
    /// ∂p/∂u × ∂p/∂v is bilinear, so that every normal lies between those of the corners.
    pub(super) fn facing(&self) -> Cone {
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| {
            let (_, du, dv) = self.point(Vec2::new(u, v));
            du.cross(dv).try_normalize().map_or(Vec3::ZERO, |n| if self.flip { -n } else { n })
        });
        let cone = Cone::about(&corners);
        // The shading normals may turn it round, as a whole or in parts.
        let normals = self.normals.as_ref().map_or(&[][..], |normals| normals);
        let all = |sign: f32| corners.iter().all(|n| normals.iter().all(|ns| sign * n.dot(*ns) > 0.0));
        match (all(1.0), all(-1.0)) {
            (true, _) => cone,
            (false, true) => Cone { axis: -cone.axis, ..cone },
            (false, false) => Cone::ALL,
        }
    }

    #[inline]
    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> (EmitterPoint, f32) {
        if let Some(seen) = self.seen_as_rectangle(from) {
            let (p, uv) = seen.sample(u);
            // The sum runs over vectors as long as the way to the rectangle.
            let p_error = (p.abs() + from.abs() + Vec3::splat((p - from).length())) * gamma(8);
            return (self.emitter_point(p, p_error, uv), 1.0 / seen.solid_angle());
        }
        let uv = if self.rectangle.is_some() { u } else { warp::bilinear(u, self.weights) };
        let (p, du, dv) = self.point(uv);
        let point = self.emitter_point(p, self.reach * gamma(6), uv);
        (point, self.parametric_pdf(uv, du, dv, from, &point))
    }

    #[inline]
    pub(super) fn pdf(&self, from: Vec3, point: &EmitterPoint) -> f32 {
        if let Some(seen) = self.seen_as_rectangle(from) {
            return 1.0 / seen.solid_angle();
        }
        let (_, du, dv) = self.point(point.uv);
        self.parametric_pdf(point.uv, du, dv, from, point)
    }

    /// The rectangle from `from`, if it is one and appears large there.
    ///
    /// Its size is judged by its area and its centre, A |cos θ| / d², and squared to spare a root; what matters is that
    /// sampling and density judge alike.
    #[inline]
    fn seen_as_rectangle(&self, from: Vec3) -> Option<SphericalRectangle<'_>> {
        let rectangle = self.rectangle.as_ref()?;
        let d = self.center - from;
        let (d2, projected) = (d.length_squared(), self.area * d.dot(rectangle.z));
        (projected * projected > MIN_SOLID_ANGLE * MIN_SOLID_ANGLE * (d2 * d2 * d2))
            .then(|| SphericalRectangle::new(rectangle, from))
    }

    #[inline]
    fn parametric_pdf(&self, uv: Vec2, du: Vec3, dv: Vec3, from: Vec3, point: &EmitterPoint) -> f32 {
        let pdf_area = match self.rectangle {
            Some(_) => 1.0 / self.area,
            None => warp::bilinear_pdf(uv, self.weights) / du.cross(dv).length(),
        };
        per_solid_angle(pdf_area, from, point.p, point.n)
    }

    /// The point at `uv` and its derivatives.
    #[inline]
    fn point(&self, uv: Vec2) -> (Vec3, Vec3, Vec3) {
        let [p00, p10, p01, p11] = self.corners;
        let (u0, u1) = (p00 * (1.0 - uv.y) + p01 * uv.y, p10 * (1.0 - uv.y) + p11 * uv.y);
        let dv = (p01 - p00) * (1.0 - uv.x) + (p11 - p10) * uv.x;
        (u0 * (1.0 - uv.x) + u1 * uv.x, u1 - u0, dv)
    }

    #[inline]
    fn emitter_point(&self, p: Vec3, p_error: Vec3, uv: Vec2) -> EmitterPoint {
        let n = match &self.rectangle {
            Some(rectangle) => rectangle.z,
            None => {
                let (_, du, dv) = self.point(uv);
                du.cross(dv).try_normalize().unwrap_or(Vec3::ZERO)
            }
        };
        let n = if self.flip { -n } else { n };
        let n = match &self.normals {
            Some([n00, n10, n01, n11]) => {
                let low = *n00 * (1.0 - uv.x) + *n10 * uv.x;
                let high = *n01 * (1.0 - uv.x) + *n11 * uv.x;
                n.face_forward(low * (1.0 - uv.y) + high * uv.y)
            }
            None => n,
        };
        EmitterPoint { p, p_error, n, uv }
    }
}

/// The mean of `f` over the unit square.
///
/// Simpson's rule on 8 × 8 cells: exact where `f` is a polynomial of low degree, as for planar patches.
pub(super) fn mean_over_square(f: impl Fn(f32, f32) -> f32) -> f32 {
    const CELLS: usize = 8;
    let weight = |i: usize| match i {
        0 | 16 => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let mut sum = 0.0;
    for i in 0..=2 * CELLS {
        for j in 0..=2 * CELLS {
            let at = |i: usize| i as f32 / (2 * CELLS) as f32;
            sum += weight(i) * weight(j) * f64::from(f(at(i), at(j)));
        }
    }
    (sum / (6.0 * CELLS as f64).powi(2)) as f32
}
