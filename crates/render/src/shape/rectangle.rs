//! Rectangles, sampled uniformly by the solid angle that they fill.
//!
//! Source: Ureña, Fajardo, King, *An Area-Preserving Parametrization for Spherical Rectangles*, Computer Graphics Forum
//! 32(4), 2013.

use std::f32::consts::TAU;

use sahl_math::{Vec2, Vec3};

/// A rectangle in the world.
#[derive(Clone, Debug)]
pub(crate) struct Rectangle {
    corner: Vec3,
    /// Unit axes along the edges.
    x: Vec3,
    y: Vec3,
    /// The unit vector x × y.
    pub(super) z: Vec3,
    lengths: [f32; 2],
}

impl Rectangle {
    /// The rectangle with the given corners, at (u, v) = (0,0), (1,0), (0,1), (1,1); `None` if they do not span one, but
    /// for rounding.
    pub(super) fn new([p00, p10, p01, p11]: [Vec3; 4]) -> Option<Self> {
        const TOLERANCE: f32 = 1e-5;
        let edges = [p10 - p00, p01 - p00];
        let lengths = edges.map(Vec3::length);
        let (x, y) = (edges[0].try_normalize()?, edges[1].try_normalize()?);
        let is_parallelogram =
            (p00 + edges[0] + edges[1] - p11).length() <= TOLERANCE * (lengths[0] + lengths[1]);
        (is_parallelogram && x.dot(y).abs() <= TOLERANCE).then(|| {
            let z = x.cross(y).normalize();
            Self { corner: p00, x, y, z, lengths }
        })
    }
}

/// A rectangle as it appears from a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphericalRectangle<'a> {
    rectangle: &'a Rectangle,
    origin: Vec3,
    /// The borders and the plane along the rectangle's axes, relative to the point.
    x0: f32,
    x1: f32,
    y0: f32,
    y1: f32,
    z0: f32,
    /// Components along z, on the side away from the rectangle, of the unit normals of the planes through the point and
    /// the edges at y0 and y1.
    b0: f32,
    b1: f32,
    /// 2π minus the two inner angles at x0.
    k: f32,
    solid_angle: f32,
}

impl<'a> SphericalRectangle<'a> {
    /// `rectangle` as it appears from `from`.
    #[inline]
    pub(crate) fn new(rectangle: &'a Rectangle, from: Vec3) -> Self {
        let d = rectangle.corner - from;
        let (x0, y0, z0) = (d.dot(rectangle.x), d.dot(rectangle.y), d.dot(rectangle.z));
        let (x1, y1) = (x0 + rectangle.lengths[0], y0 + rectangle.lengths[1]);
        // The planes through the point and the edges; of each unit normal only z is needed.
        let z2 = z0 * z0;
        let b0 = -y0 / (y0 * y0 + z2).sqrt();
        let n1 = x1 / (x1 * x1 + z2).sqrt();
        let b1 = y1 / (y1 * y1 + z2).sqrt();
        let n3 = -x0 / (x0 * x0 + z2).sqrt();
        // Inner angles minus π/2: their sum is the excess, and small ones keep their digits.
        let excess = |a: f32, b: f32| (a * b).clamp(-1.0, 1.0).asin();
        let (g2, g3) = (excess(b1, n3), excess(n3, b0));
        let solid_angle = excess(b0, n1) + excess(n1, b1) + g2 + g3;
        let k = 0.5 * TAU - g2 - g3;
        Self { rectangle, origin: from, x0, x1, y0, y1, z0, b0, b1, k, solid_angle }
    }

    /// The solid angle in steradians; NaN or about zero if the point lies in the plane.
    #[inline]
    pub(crate) fn solid_angle(&self) -> f32 {
        self.solid_angle
    }

    /// A point of the rectangle, uniform by solid angle, and its parameters in the unit square.
    #[inline]
    pub(crate) fn sample(&self, u: Vec2) -> (Vec3, Vec2) {
        // The line parallel to y that leaves the share u.x of the solid angle to its left.
        let (sin, cos) = (u.x * self.solid_angle + self.k).sin_cos();
        let fu = (cos * self.b0 - self.b1) / sin;
        // The paper's c = ±1 / √(f² + b²) and x = c |z| / √(1 − c²) in one.
        let tan2 = (fu * fu + self.b0 * self.b0 - 1.0).max(f32::MIN_POSITIVE);
        let xu = (self.z0.abs() / tan2.sqrt()).copysign(fu).clamp(self.x0, self.x1);
        // The place on it, uniform on the sphere.
        let d2 = xu * xu + self.z0 * self.z0;
        let sine = |y: f32| y / (d2 + y * y).sqrt();
        let (h0, h1) = (sine(self.y0), sine(self.y1));
        let h = h0 + u.y * (h1 - h0);
        let yv = (h * (d2 / (1.0 - h * h).max(f32::MIN_POSITIVE)).sqrt()).clamp(self.y0, self.y1);
        let Rectangle { x, y, z, lengths, .. } = self.rectangle;
        let parameters = Vec2::new((xu - self.x0) / lengths[0], (yv - self.y0) / lengths[1]);
        (self.origin + *x * xu + *y * yv + *z * self.z0, parameters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(corner: Vec3, [a, b]: [Vec3; 2]) -> Rectangle {
        Rectangle::new([corner, corner + a, corner + b, corner + a + b]).unwrap()
    }

    #[test]
    fn other_patches_are_no_rectangles() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)];
        assert!(Rectangle::new(corners).is_some());
        assert!(Rectangle::new([Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.1)]).is_none());
        let sheared = [Vec3::ZERO, Vec3::X, Vec3::new(0.5, 1.0, 0.0), Vec3::new(1.5, 1.0, 0.0)];
        assert!(Rectangle::new(sheared).is_none());
        assert!(Rectangle::new([Vec3::ZERO; 4]).is_none());
    }

    #[test]
    fn a_face_of_a_cube_fills_a_sixth_of_the_sphere() {
        for axis in 0..3 {
            let mut corner = Vec3::splat(-1.0);
            let (mut ex, mut ey) = (Vec3::ZERO, Vec3::ZERO);
            corner[axis] = 1.0;
            ex[(axis + 1) % 3] = 2.0;
            ey[(axis + 2) % 3] = 2.0;
            let rectangle = rectangle(corner, [ex, ey]);
            let seen = SphericalRectangle::new(&rectangle, Vec3::ZERO);
            assert!((seen.solid_angle() - TAU / 3.0).abs() < 1e-5, "{}", seen.solid_angle());
        }
    }

    #[test]
    fn a_distant_rectangle_fills_its_area_over_the_squared_distance() {
        let rectangle = rectangle(Vec3::new(-1.0, -1.5, 40.0), [Vec3::X * 2.0, Vec3::Y * 3.0]);
        let seen = SphericalRectangle::new(&rectangle, Vec3::ZERO);
        assert!((seen.solid_angle() / (6.0 / 1600.0) - 1.0).abs() < 4e-3, "{}", seen.solid_angle());
    }

    #[test]
    fn samples_lie_on_the_rectangle_at_its_corners_too() {
        let (corner, edges) = (Vec3::new(0.5, -2.0, 0.3), [Vec3::Y * 3.0, Vec3::X * 0.7]);
        let from = Vec3::new(0.1, 0.2, -0.6);
        let rectangle = rectangle(corner, edges);
        let seen = SphericalRectangle::new(&rectangle, from);
        for (u, expected) in [
            (Vec2::new(0.0, 0.0), corner),
            (Vec2::new(1.0, 0.0), corner + edges[0]),
            (Vec2::new(0.0, 1.0), corner + edges[1]),
            (Vec2::new(1.0, 1.0), corner + edges[0] + edges[1]),
        ] {
            let (p, parameters) = seen.sample(u);
            assert!((p - expected).length() < 2e-3 && (parameters - u).length() < 2e-3, "{u:?}: {p:?}");
        }
        for i in 0..1000 {
            let u = Vec2::new((i as f32 * 0.618_034) % 1.0, (i as f32 * 0.414_214) % 1.0);
            let (p, _) = seen.sample(u);
            assert!(
                (p.z - 0.3).abs() < 1e-6 && (-2.0..=1.0).contains(&p.y) && p.x > 0.499 && p.x < 1.201,
                "{p:?}"
            );
        }
    }

    #[test]
    fn every_part_gets_its_share_of_the_samples() {
        let (corner, edges) = (Vec3::new(-1.0, -0.7, 1.0), [Vec3::X * 2.0, Vec3::Y * 1.4]);
        for from in [Vec3::ZERO, Vec3::new(0.3, 0.5, 0.2), Vec3::new(1.5, 0.9, 0.4), Vec3::new(0.5, 0.2, 1.7)]
        {
            let whole = rectangle(corner, edges);
            let seen = SphericalRectangle::new(&whole, from);
            for [x, y] in [[0.5, 0.5], [0.2, 0.9], [1.0, 0.3], [0.1, 1.0]] {
                let part = rectangle(corner, [edges[0] * x, edges[1] * y]);
                let expected = SphericalRectangle::new(&part, from).solid_angle() / seen.solid_angle();
                let is_inside = |i: usize| {
                    let u = Vec2::new((i % 200) as f32 + 0.5, (i / 200) as f32 + 0.5) / 200.0;
                    let (_, at) = seen.sample(u);
                    at.x < x && at.y < y
                };
                let found = (0..40_000).filter(|&i| is_inside(i)).count() as f32 / 40_000.0;
                assert!((found - expected).abs() < 0.01, "{from:?} {x} {y}: {found} and {expected}");
            }
        }
    }
}
