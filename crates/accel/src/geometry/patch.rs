//! The bilinear patch.
//!
//! A patch whose corners lie in a plane and make a convex outline is the union of two triangles, `p₀₀ p₁₀ p₁₁` and
//! `p₀₀ p₁₁ p₀₁`; it is traced as these, by the fast watertight test, and `(u, v)` are found afterwards. All others are
//! solved as what they are, doubly ruled surfaces.
//!
//! Both ways decide at the patch's borders by the edge functions of the watertight triangle test, so that patches
//! and triangles that share an edge leave no gap.

use sahl_math::{Bounds3, Ray, Vec3};

use super::double::DVec3;
use super::triangle::Shear;

/// Corners in the order `(u, v)` = 00, 10, 01, 11.
pub(crate) type Corners = [Vec3; 4];

/// How a patch is traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PatchKind {
    /// No surface to hit.
    Degenerate,
    /// Two triangles cover it, and `(u, v)` are affine on both.
    Parallelogram,
    /// Two triangles cover it.
    Planar,
    /// A ruled surface.
    Curved,
}

/// Where a ray meets a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PatchHit {
    pub(crate) t: f32,
    pub(crate) u: f32,
    pub(crate) v: f32,
}

/// How far from its plane, relative to its diagonals, a planar patch may lie: what rounding of the corners to a scene
/// file's six digits leaves. The two triangles then differ from the ruled surface by at most a quarter of it.
const PLANARITY: f64 = 1e-6;

/// Parameters this far outside count as on the border, where `f32` cannot tell the difference: the slack covers the error of
/// the roots, so that neighbours overlap by a rounding error and never leave a gap.
const BORDER: f64 = f32::EPSILON as f64 * 0.5;

/// Which way to trace the patch.
pub(crate) fn classify(corners: &Corners) -> PatchKind {
    let [p00, p10, p01, p11] = corners.map(DVec3::from);
    let n = (p11 - p00).cross(p01 - p10);
    let size = (p11 - p00).length().max((p01 - p10).length());
    let off_plane = n.dot(p10 - p00).abs() / n.length();
    let planar = off_plane <= PLANARITY * size;
    if !planar {
        let area = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).length();
        let covered = area(p00, p10, p11) + area(p00, p11, p01) + area(p00, p10, p01);
        return if covered > 0.0 { PatchKind::Curved } else { PatchKind::Degenerate };
    }
    // The outline turns one way at every corner: the patch does not fold over itself.
    let outline = [p00, p10, p11, p01];
    let turns: [f64; 4] = std::array::from_fn(|i| {
        let (before, at, after) = (outline[(i + 3) % 4], outline[i], outline[(i + 1) % 4]);
        (at - before).cross(after - at).dot(n)
    });
    if turns.iter().any(|&turn| turn < 0.0) {
        PatchKind::Curved
    } else if fold(corners).length() <= PLANARITY * size {
        PatchKind::Parallelogram
    } else {
        PatchKind::Planar
    }
}

/// How far the fourth corner lies from completing a parallelogram.
fn fold(corners: &Corners) -> DVec3 {
    let [p00, p10, p01, p11] = corners.map(DVec3::from);
    (p11 - p10) - (p01 - p00)
}

/// The box about a curved patch, with the slack that [`intersect`] leaves at the border.
pub(crate) fn curved_bounds(corners: &Corners) -> Bounds3 {
    let tight = Bounds3::from_points(*corners);
    let slack = Vec3::splat(tight.diagonal().max_component() * (4.0 * BORDER as f32));
    Bounds3 { min: tight.min - slack, max: tight.max + slack }
}

/// The two triangles that cover a planar patch.
#[inline]
pub(crate) fn halves(corners: &Corners) -> [[Vec3; 3]; 2] {
    let [p00, p10, p01, p11] = *corners;
    [[p00, p10, p11], [p00, p11, p01]]
}

/// `(u, v)` of a parallelogram at barycentric weights of one of its [`halves`].
#[inline]
pub(crate) fn affine_parameters(upper: bool, [b1, b2]: [f32; 2]) -> [f32; 2] {
    let sum = (b1 + b2).min(1.0);
    if upper { [b1, sum] } else { [sum, b2] }
}

/// `(u, v)` of a planar patch at barycentric weights of one of its [`halves`].
pub(crate) fn planar_parameters(corners: &Corners, upper: bool, weights: [f32; 2]) -> [f32; 2] {
    let [p00, p10, p01, p11] = corners.map(DVec3::from);
    let [b1, b2] = weights.map(f64::from);
    let (e1, e2) = if upper { (p11 - p00, p01 - p00) } else { (p10 - p00, p11 - p00) };
    let guess = affine_parameters(upper, weights).map(f64::from);
    let [u, v] = invert(p10 - p00, p01 - p00, fold(corners), e1 * b1 + e2 * b2, guess);
    [clamp_unit(u), clamp_unit(v)]
}

/// Solves `a u + b v + c u v = p` in the plane of the vectors; `guess` where it has no solution.
fn invert(a: DVec3, b: DVec3, c: DVec3, p: DVec3, guess: [f64; 2]) -> [f64; 2] {
    let n = a.cross(b) + a.cross(c) + c.cross(b);
    // Crossing with (b + c u): (p − a u) × (b + c u) = 0, a quadratic in u.
    let cross = |x: DVec3, y: DVec3| x.cross(y).dot(n);
    let (c0, c1, c2) = (cross(p, b), cross(p, c) - cross(a, b), -cross(a, c));
    let off = |u: f64| (u - 0.5).abs();
    let [u0, u1] = roots(c2, c1, c0);
    let u = if off(u1) < off(u0) || u0.is_nan() { u1 } else { u0 };
    let along = b + c * u;
    let v = (p - a * u).dot(along) / along.dot(along);
    if u.is_finite() && v.is_finite() { [u, v] } else { guess }
}

/// The roots of `a x² + b x + c`, without cancellation, in no order; NaN where there is none.
#[inline]
fn roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let discriminant = b * b - 4.0 * a * c;
    // The root of a negative number is NaN, and so is what follows.
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    if q == 0.0 { [if a == 0.0 { f64::NAN } else { 0.0 }; 2] } else { [c / q, q / a] }
}

fn clamp_unit(x: f64) -> f32 {
    (x as f32).clamp(0.0, 1.0)
}

/// The nearest hit with `t > ray.t_min` of a patch of any kind.
///
/// The corners are sheared as in the watertight triangle test, and the patch becomes a bilinear map of the plane. On the
/// ruling at `u` lies the origin where `f(u) = cross(lerp(p₀₀, p₁₀, u), lerp(p₀₁, p₁₁, u))` vanishes; `f(0)` and `f(1)` are
/// the edge functions. The solution is refined in space by one Newton step in `f64`, so that the sign of `t` is right
/// for an origin next to the surface.
///
/// Source: Ramsey, Potter, Hansen, *Ray Bilinear Patch Intersections*, Journal of Graphics Tools 9(3), 2004; Reshetov, *Cool
/// Patches: A Geometric Approach to Ray/Bilinear Patch Intersections*, in Ray Tracing Gems, 2019.
pub(crate) fn intersect(ray: &Ray, shear: &Shear, corners: &Corners) -> Option<PatchHit> {
    let flat = corners.map(|corner| shear.apply(corner - ray.origin).map(f64::from));
    let cross = |a: [f64; 3], b: [f64; 3]| a[0] * b[1] - a[1] * b[0];
    let [q00, q10, q01, q11] = flat;
    if !(q00[2] > 0.0 || q10[2] > 0.0 || q01[2] > 0.0 || q11[2] > 0.0) {
        return None;
    }
    let (f0, f1) = (cross(q00, q01), cross(q10, q11));
    let middle = cross(q00, q11) + cross(q10, q01);
    let mut best: Option<PatchHit> = None;
    for u in roots(f0 - middle + f1, middle - 2.0 * f0, f0) {
        if !(-BORDER..=1.0 + BORDER).contains(&u) {
            continue;
        }
        let along = |i: usize| [(1.0 - u) * q00[i] + u * q10[i], (1.0 - u) * q01[i] + u * q11[i]];
        let ([x0, x1], [y0, y1]) = (along(0), along(1));
        let (dx, dy) = (x0 - x1, y0 - y1);
        let v = (x0 * dx + y0 * dy) / (dx * dx + dy * dy);
        if !(-BORDER..=1.0 + BORDER).contains(&v) {
            continue;
        }
        let hit = refine(ray, corners, u, v);
        if hit.t > ray.t_min && hit.t.is_finite() && best.is_none_or(|best| hit.t < best.t) {
            best = Some(hit);
        }
    }
    best
}

/// One Newton step from the surface point at `(u, v)` towards the crossing of the ray and the surface.
fn refine(ray: &Ray, corners: &Corners, u: f64, v: f64) -> PatchHit {
    let origin = DVec3::from(ray.origin);
    let [p00, p10, p01, p11] = corners.map(|corner| DVec3::from(corner) - origin);
    let (low, high) = (p00 + (p10 - p00) * u, p01 + (p11 - p01) * u);
    let p = low + (high - low) * v;
    let du = (p10 - p00) * (1.0 - v) + (p11 - p01) * v;
    let dv = high - low;
    let d = DVec3::from(ray.direction);
    let n = du.cross(dv);
    let t = n.dot(p) / n.dot(d);
    if !t.is_finite() {
        // The ray runs along the plane that touches at p: its point nearest to p stands for the crossing.
        return PatchHit { t: (p.dot(d) / d.dot(d)) as f32, u: clamp_unit(u), v: clamp_unit(v) };
    }
    let off = d * t - p;
    let step_u = off.cross(dv).dot(n) / n.dot(n);
    let step_v = du.cross(off).dot(n) / n.dot(n);
    PatchHit { t: t as f32, u: clamp_unit(u + step_u), v: clamp_unit(v + step_v) }
}

/// The point at `(u, v)` and `dp/du × dp/dv`, not of unit length.
///
/// On a planar patch the point lies on the plane of the half that was hit, exactly as far as `f64` goes.
pub(crate) fn surface(corners: &Corners, kind: PatchKind, u: f32, v: f32) -> (DVec3, DVec3) {
    let [p00, p10, p01, p11] = corners.map(DVec3::from);
    let (u, v) = (f64::from(u), f64::from(v));
    let (low, high) = (p00 + (p10 - p00) * u, p01 + (p11 - p01) * u);
    let p = low + (high - low) * v;
    let diagonal = p11 - p00;
    if kind == PatchKind::Curved {
        let du = (p10 - p00) * (1.0 - v) + (p11 - p01) * v;
        let n = du.cross(high - low);
        // At a corner where two sides fall together the tangents are parallel; the middle of the patch speaks for it.
        return if n.dot(n) > 0.0 { (p, n) } else { (p, diagonal.cross(p01 - p10)) };
    }
    let half = |upper: bool| if upper { diagonal.cross(p01 - p00) } else { (p10 - p00).cross(diagonal) };
    let hit = half(v > u);
    let n = if hit.dot(hit) > 0.0 { hit } else { half(v <= u) };
    (p - n * (n.dot(p - p00) / n.dot(n)), n)
}
