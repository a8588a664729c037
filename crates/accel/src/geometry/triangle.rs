//! Ray against triangle: the watertight test that Sahl renders with, and the textbook test beside it.
//!
//! [`intersect`] is the definition. The traversal runs the same arithmetic on eight triangles at a time and has to agree
//! with it to the last bit.

use sahl_math::{Ray, Vec3};

use super::double::DVec3;

/// The parameter `t` that the `f32` arithmetic gives is off by at most `m |s| (MARGIN_DEPTH + MARGIN_DETERMINANT m² / |det|)`,
/// where `m` bounds the vertices' coordinates relative to the origin and `s` is the scale of the depth.
///
/// With the unit roundoff ε: a sheared coordinate is below `2 m` and off by `7 ε m`, an edge function by `56 ε m²` from these and
/// `16 ε m²` from its own rounding. Three of them, as weights and in the determinant, move `t` by `6 · 72 ε m³ |s| / |det|`;
/// rounding the depths and the last operations adds less than `16 ε m |s|`.
pub(crate) const MARGIN_DETERMINANT: f32 = 450.0 * 0.5 * f32::EPSILON;
/// See [`MARGIN_DETERMINANT`].
pub(crate) const MARGIN_DEPTH: f32 = 16.0 * 0.5 * f32::EPSILON;

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// The ray's parameter.
    pub t: f32,
    /// The barycentric weight of vertex 1.
    pub b1: f32,
    /// The barycentric weight of vertex 2; that of vertex 0 is `1 − b1 − b2`.
    pub b2: f32,
}

/// An axis of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// The axes in turn, this one last.
    #[inline(always)]
    pub(crate) const fn after_others(self) -> &'static [Self; 3] {
        // In memory: made where it is used, it would be written to the stack and read back.
        const AXES: [[Axis; 3]; 3] =
            [[Axis::Y, Axis::Z, Axis::X], [Axis::Z, Axis::X, Axis::Y], [Axis::X, Axis::Y, Axis::Z]];
        &AXES[self as usize]
    }
}

/// The shear that takes a ray's direction to the unit vector of its dominant axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shear {
    /// Which axes become x, y and z; z is the one along which the direction is longest.
    pub(crate) axes: [Axis; 3],
    /// Shear of x along z, of y along z, and the scale of z.
    pub(crate) factors: [f32; 3],
}

impl Shear {
    /// The shear of a direction other than zero.
    #[inline]
    pub(crate) fn new(direction: Vec3) -> Self {
        Self::with_reciprocal(direction, direction.map(|x| 1.0 / x))
    }

    /// As [`Self::new`], given one over each coordinate of the direction.
    #[inline(always)]
    pub(crate) fn with_reciprocal(direction: Vec3, reciprocal: Vec3) -> Self {
        // Selections, not branches: which axis dominates cannot be predicted.
        let d: [f32; 3] = direction.into();
        let [x, y, z] = d.map(f32::abs);
        let (larger, axis) = if y > x { (y, Axis::Y) } else { (x, Axis::X) };
        let axis = if z > larger { Axis::Z } else { axis };
        let axes = *axis.after_others();
        // Arrays are read at an index, vectors by branches.
        let reciprocal: [f32; 3] = reciprocal.into();
        let scale = reciprocal[axis as usize];
        Self { axes, factors: [d[axes[0] as usize] * scale, d[axes[1] as usize] * scale, scale] }
    }

    /// A vertex, relative to the ray's origin, in the sheared space: the ray runs from zero along +z.
    #[inline]
    pub(crate) fn apply(&self, relative: Vec3) -> [f32; 3] {
        let [x, y, z] = self.axes.map(|axis| relative[axis as usize]);
        let [sx, sy, sz] = self.factors;
        [x - sx * z, y - sy * z, sz * z]
    }
}

/// The hit of `ray` with the triangle, if its parameter lies in the open interval from `t_min` to `t_max`.
///
/// Watertight: of the triangles round a shared edge or vertex at least one is hit by a ray through it, whichever way
/// they are wound. Both sides count. Triangles without area and rays without direction give no hit; nor do triangles so
/// small, about 1e-19, that their area leaves the range of `f32`.
///
/// The sign of an edge function `a b − c d` in `f32` is right unless the result is zero, because rounding is monotonic;
/// where it is zero, all three are computed again in `f64`, in which the products are exact.
///
/// Source: Woop, Benthin, Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013. Deviations: no back-face culling;
/// where the triangle straddles the origin and the parameter is within its error of `t_min`, it is computed in `f64`, so
/// that a ray that starts next to the triangle neither hits it from behind nor misses it.
#[inline]
pub fn intersect(ray: &Ray, vertices: [Vec3; 3]) -> Option<TriangleHit> {
    let shear = Shear::new(ray.direction);
    intersect_sheared(ray, &shear, vertices).filter(|hit| hit.t < ray.t_max)
}

/// [`intersect`] with the shear prepared, and without an upper limit.
#[inline]
pub(crate) fn intersect_sheared(ray: &Ray, shear: &Shear, vertices: [Vec3; 3]) -> Option<TriangleHit> {
    let [a, b, c] = vertices.map(|vertex| shear.apply(vertex - ray.origin));
    let mut edges = edge_functions(a, b, c);
    if edges.contains(&0.0) {
        edges = exact_edge_functions(a, b, c);
    }
    let [u, v, w] = edges;
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let det = u + v + w;
    let nearest = smaller(smaller(a[2], b[2]), c[2]);
    let farthest = larger(larger(a[2], b[2]), c[2]);
    // The signs of the depths are exact. A triangle behind the origin cannot be hit; NaN ends here as well.
    if !(det != 0.0 && farthest > 0.0) {
        return None;
    }
    let reciprocal = 1.0 / det;
    let mut t = (u * a[2] + v * b[2] + w * c[2]) * reciprocal;
    if nearest <= 0.0 {
        let reach = vertices.map(|vertex| (vertex - ray.origin).abs().max_component());
        let reach = reach[0].max(reach[1]).max(reach[2]);
        let scale = MARGIN_DETERMINANT * (reach * reach) * reciprocal.abs();
        let margin = (scale + MARGIN_DEPTH) * (reach * shear.factors[2].abs());
        if (t - ray.t_min).abs() <= margin {
            t = plane_parameter(ray, vertices).unwrap_or(t);
        }
    }
    (t > ray.t_min && t.is_finite()).then_some(TriangleHit { t, b1: v * reciprocal, b2: w * reciprocal })
}

/// Twice the signed areas that the origin spans with the edges, each opposite to one vertex.
#[inline]
fn edge_functions(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]]
}

/// The same with exact products, so that the signs are right always.
#[inline]
pub(crate) fn exact_edge_functions(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    let difference =
        |p: f32, q: f32, r: f32, s: f32| (f64::from(p) * f64::from(q) - f64::from(r) * f64::from(s)) as f32;
    [
        difference(c[0], b[1], c[1], b[0]),
        difference(a[0], c[1], a[1], c[0]),
        difference(b[0], a[1], b[1], a[0]),
    ]
}

/// Where the ray meets the triangle's plane, in `f64`; `None` if they are parallel.
///
/// The origin may lie next to the plane: the sign of the result is right as long as `f64` can tell.
#[inline]
pub(crate) fn plane_parameter(ray: &Ray, vertices: [Vec3; 3]) -> Option<f32> {
    PlaneCrossing::new(ray, vertices).parameter()
}

/// The quotient of [`plane_parameter`].
pub(crate) struct PlaneCrossing {
    distance: f64,
    speed: f64,
}

impl PlaneCrossing {
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, vertices: [Vec3; 3]) -> Self {
        let [p0, p1, p2] = vertices.map(DVec3::from);
        let n = (p1 - p0).cross(p2 - p0);
        Self { distance: n.dot(p0 - ray.origin.into()), speed: n.dot(ray.direction.into()) }
    }

    /// Whether the parameter is negative; without a division.
    #[inline(always)]
    pub(crate) fn is_behind(&self) -> bool {
        // Far from the ends of the range of `f64`, for coordinates in that of `f32`.
        self.distance * self.speed < 0.0
    }

    #[inline(always)]
    pub(crate) fn parameter(&self) -> Option<f32> {
        let t = self.distance / self.speed;
        t.is_finite().then_some(t as f32)
    }
}

/// The smaller of two; the second if either is NaN.
#[inline]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two; the second if either is NaN.
#[inline]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The textbook twin of [`intersect`]: short, and not watertight.
///
/// A ray through a shared edge may miss both triangles, since each rounds its own way. It serves lessons and
/// comparisons; there is no epsilon against which the determinant is held, which would lose small triangles.
///
/// Source: Möller, Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, Journal of Graphics Tools 2(1), 1997.
#[inline]
pub fn moller_trumbore(ray: &Ray, vertices: [Vec3; 3]) -> Option<TriangleHit> {
    let (e1, e2) = (vertices[1] - vertices[0], vertices[2] - vertices[0]);
    let p = plain_cross(ray.direction, e2);
    let det = e1.dot(p);
    if det == 0.0 {
        return None;
    }
    let reciprocal = 1.0 / det;
    let s = ray.origin - vertices[0];
    let b1 = s.dot(p) * reciprocal;
    if !(0.0..=1.0).contains(&b1) {
        return None;
    }
    let q = plain_cross(s, e1);
    let b2 = ray.direction.dot(q) * reciprocal;
    if !(b2 >= 0.0 && b1 + b2 <= 1.0) {
        return None;
    }
    let t = e2.dot(q) * reciprocal;
    (t > ray.t_min && t < ray.t_max).then_some(TriangleHit { t, b1, b2 })
}

/// The vector product in `f32` throughout, as the textbook has it.
#[inline]
fn plain_cross(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// The point at barycentric weights `b1` and `b2` with its error, and the unit normal `(p₁−p₀) × (p₂−p₀)`.
#[inline]
pub(crate) fn surface(vertices: [Vec3; 3], b1: f32, b2: f32) -> (DVec3, DVec3) {
    let [p0, p1, p2] = vertices.map(DVec3::from);
    let (e1, e2) = (p1 - p0, p2 - p0);
    (p0 + e1 * f64::from(b1) + e2 * f64::from(b2), e1.cross(e2))
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    #[test]
    fn both_tests_give_parameter_and_weights() {
        let ray = Ray::new(Vec3::new(0.25, 0.5, 2.0), Vec3::new(0.0, 0.0, -4.0));
        let expected = TriangleHit { t: 0.5, b1: 0.25, b2: 0.5 };
        assert_eq!(intersect(&ray, UNIT), Some(expected));
        assert_eq!(moller_trumbore(&ray, UNIT), Some(expected));
        let [a, b, c] = UNIT;
        assert_eq!(intersect(&ray, [a, c, b]).map(|hit| (hit.b1, hit.b2)), Some((0.5, 0.25)));
    }

    #[test]
    fn the_interval_is_open() {
        let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), -Vec3::Z);
        assert_eq!(intersect(&ray.with_t_max(1.0), UNIT), None);
        assert!(intersect(&ray.with_t_max(1.0_f32.next_up()), UNIT).is_some());
        assert_eq!(intersect(&Ray { t_min: 1.0, ..ray }, UNIT), None);
        assert!(intersect(&Ray { t_min: 1.0_f32.next_down(), ..ray }, UNIT).is_some());
        assert_eq!(intersect(&Ray::new(Vec3::new(0.25, 0.25, 0.0), Vec3::Z), UNIT), None);
    }

    #[test]
    fn the_sign_of_the_parameter_is_right_next_to_the_plane() {
        // A slanted plane, and origins one unit in the last place to either side of it.
        let triangle = [Vec3::new(-3.0, -1.0, 0.3), Vec3::new(5.0, -2.0, 1.7), Vec3::new(0.7, 6.0, -0.9)];
        let [p0, p1, p2] = triangle.map(DVec3::from);
        let n = (p1 - p0).cross(p2 - p0);
        for i in 0..2000 {
            let weight = |x: f32| 0.05 + 0.4 * x.sin().abs();
            let (b1, b2) = (weight(i as f32 * 0.37), weight(i as f32 * 0.73));
            let near = surface(triangle, b1, b2).0.to_f32();
            let origin =
                Vec3::new(near.x, near.y, if i % 2 == 0 { near.z.next_up() } else { near.z.next_down() });
            let height = n.dot(p0 - origin.into());
            for direction in [Vec3::new(0.1, 0.2, 1.0), Vec3::new(0.3, -0.1, -1.0), Vec3::new(1.0, 0.2, 0.4)]
            {
                let ahead = height / n.dot(direction.into()) > 0.0;
                assert_eq!(intersect(&Ray::new(origin, direction), triangle).is_some(), ahead, "{origin:?}");
            }
        }
    }

    #[test]
    fn degenerate_input_gives_no_hit() {
        let ray = Ray::new(Vec3::new(0.0, 0.0, 1.0), -Vec3::Z);
        let nan = Vec3::splat(f32::NAN);
        assert_eq!(intersect(&ray, [Vec3::ZERO; 3]), None);
        assert_eq!(intersect(&ray, [Vec3::ZERO, Vec3::X, Vec3::X * 2.0]), None);
        assert_eq!(intersect(&ray, [Vec3::ZERO, nan, Vec3::Y]), None);
        assert_eq!(intersect(&Ray::new(Vec3::Z, Vec3::ZERO), UNIT), None);
        assert_eq!(moller_trumbore(&Ray::new(Vec3::Z, Vec3::ZERO), UNIT), None);
        assert_eq!(intersect(&Ray::new(nan, Vec3::X), UNIT), None);
    }

    #[test]
    fn edges_are_decided_as_by_exact_arithmetic() {
        // Corners and origins on a grid, so that i64 tells inside from outside; slivers, so that f32 often cannot.
        let mut state = 1_u64;
        let mut below = |limit: i64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as i64 % limit
        };
        let (mut zero_edges, mut hits) = (0, 0);
        for _ in 0..200_000 {
            let (px, py) = (below(1 << 23), below(1 << 23));
            let a = [-px, -py];
            let b = [px + below(3) - 1, py + below(3) - 1];
            let c = [below(3) - 1, below(3) - 1];
            let area = |p: [i64; 2], q: [i64; 2]| p[0] * q[1] - p[1] * q[0];
            let signs = [area(b, c), area(c, a), area(a, b)].map(i64::signum);
            let inside = (signs.iter().all(|&s| s >= 0) || signs.iter().all(|&s| s <= 0)) && signs != [0; 3];
            let vertices = [a, b, c].map(|p| Vec3::new(p[0] as f32, p[1] as f32, 1.0));
            let flat = vertices.map(|p| [p.x, p.y, p.z]);
            zero_edges +=
                u32::from(edge_functions(flat[0], flat[1], flat[2]).contains(&0.0) && signs != [0; 3]);
            let hit = intersect(&Ray::new(Vec3::ZERO, Vec3::Z), vertices);
            assert_eq!(hit.is_some(), inside, "{a:?} {b:?} {c:?}");
            hits += u32::from(inside);
        }
        assert!(zero_edges > 1000 && hits > 10_000, "{zero_edges} edges rounded to zero, {hits} hits");
    }
}
