//! Maps from the unit square or interval to the domains that are sampled, with their densities and inverses.
//!
//! Design decision: pure functions of numbers uniform in [0, 1). Each map is continuous wherever its domain allows it,
//! so that the stratification of the points survives, and each has a density (`_pdf`, with respect to the measure named
//! there) and an inverse (`_inverse`), by which the tests check all three against each other.
//!
//! Deliberately absent: distributions given by tables (`distribution`) and those of shapes and materials.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI, TAU};

use sahl_math::{Vec2, Vec3, lerp, safe_sqrt};

/// Sine and cosine of `turns` full turns, for |`turns`| < 2²⁰; off by less than 1.5e-7.
///
/// The standard library's functions differ from one platform to another in the last digit, and images with them. These
/// are polynomials, and take no angle in radians, which would have to be rounded first.
#[inline]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    // Adding 1.5 × 2²³ rounds to an integer, whose last bits are then those of the mantissa.
    const ROUND: f32 = 12_582_912.0;
    let rounded = 4.0 * turns + ROUND;
    let (sin, cos) = sin_cos_eighth(turns - 0.25 * (rounded - ROUND));
    let quarter = rounded.to_bits();
    let (a, b) = if quarter & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let negate_if = |x: f32, bits: u32| f32::from_bits(x.to_bits() ^ (bits << 30 & 1 << 31));
    (negate_if(a, quarter), negate_if(b, quarter.wrapping_add(1)))
}

/// Sine and cosine of up to an eighth of a turn to either side: polynomials fitted at Chebyshev nodes.
#[inline]
fn sin_cos_eighth(turns: f32) -> (f32, f32) {
    let z = turns * turns;
    let sin = turns * (6.283_185_5 + z * (-41.341_663 + z * (81.592_545 + z * -75.401_84)));
    let cos = 1.0 + z * (-19.739_208 + z * (64.939_316 + z * (-85.442_85 + z * 59.220_287)));
    (sin, cos)
}

/// A point uniform in the disk of radius one about the origin.
///
/// Concentric squares become concentric circles: areas and neighbourhoods are kept. Source: Shirley, Chiu, *A Low
/// Distortion Map Between Disk and Square*, JGT 2(3), 1997.
#[inline]
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let (x, y) = (2.0 * u.x - 1.0, 2.0 * u.y - 1.0);
    let near_x = x.abs() > y.abs();
    let (large, small) = if near_x { (x, y) } else { (y, x) };
    if large == 0.0 {
        return Vec2::ZERO;
    }
    // The angle from the nearer axis is an eighth of a turn times the ratio of the coordinates.
    let (sin, cos) = sin_cos_eighth(0.125 * (small / large));
    let (along, across) = (large * cos, large * sin);
    if near_x { Vec2::new(along, across) } else { Vec2::new(across, along) }
}

/// Density of [`concentric_disk`] per area.
pub const CONCENTRIC_DISK_PDF: f32 = FRAC_1_PI;

/// The point of the unit square that [`concentric_disk`] maps to `p`.
pub fn concentric_disk_inverse(p: Vec2) -> Vec2 {
    let radius = p.length();
    let (x, y) = if p.x.abs() > p.y.abs() {
        let x = radius.copysign(p.x);
        (x, x * (p.y / p.x).atan() / FRAC_PI_4)
    } else if p.y != 0.0 {
        let y = radius.copysign(p.y);
        (y * (p.x / p.y).atan() / FRAC_PI_4, y)
    } else {
        (0.0, 0.0)
    };
    Vec2::new(0.5 * (x + 1.0), 0.5 * (y + 1.0))
}

/// A direction of the hemisphere about +z, in proportion to its cosine: a disk raised to the sphere (Malley).
#[inline]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let p = concentric_disk(u);
    Vec3::new(p.x, p.y, safe_sqrt(1.0 - p.x * p.x - p.y * p.y))
}

/// Density of [`cosine_hemisphere`] per steradian: cos θ / π above the horizon.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// The point of the unit square that [`cosine_hemisphere`] maps to `w`.
pub fn cosine_hemisphere_inverse(w: Vec3) -> Vec2 {
    concentric_disk_inverse(Vec2::new(w.x, w.y))
}

/// A direction uniform on the unit sphere.
#[inline]
pub fn uniform_sphere(u: Vec2) -> Vec3 {
    from_height_and_turn(1.0 - 2.0 * u.x, u.y)
}

/// Density of [`uniform_sphere`] per steradian.
pub const UNIFORM_SPHERE_PDF: f32 = FRAC_1_PI / 4.0;

/// The point of the unit square that [`uniform_sphere`] maps to `w`.
pub fn uniform_sphere_inverse(w: Vec3) -> Vec2 {
    Vec2::new(0.5 * (1.0 - w.z), turn(w))
}

/// A direction uniform on the hemisphere about +z.
#[inline]
pub fn uniform_hemisphere(u: Vec2) -> Vec3 {
    from_height_and_turn(u.x, u.y)
}

/// Density of [`uniform_hemisphere`] per steradian.
pub const UNIFORM_HEMISPHERE_PDF: f32 = FRAC_1_PI / 2.0;

/// The point of the unit square that [`uniform_hemisphere`] maps to `w`.
pub fn uniform_hemisphere_inverse(w: Vec3) -> Vec2 {
    Vec2::new(w.z, turn(w))
}

/// A direction uniform in the cone about +z whose half angle has one minus its cosine equal to `one_minus_cos`.
///
/// The complement is what keeps its digits in narrow cones, where the cosine rounds to one; sin² θ / (1 + cos θ) gives
/// it without cancellation. The sine of the result is accurate for the same reason.
#[inline]
pub fn uniform_cone(u: Vec2, one_minus_cos: f32) -> Vec3 {
    let depth = u.x * one_minus_cos;
    let radius = safe_sqrt(depth * (2.0 - depth));
    let (sin, cos) = sin_cos_turns(u.y);
    Vec3::new(radius * cos, radius * sin, 1.0 - depth)
}

/// Density of [`uniform_cone`] per steradian, inside the cone: 1 / (2π (1 − cos θ)).
#[inline]
pub fn uniform_cone_pdf(one_minus_cos: f32) -> f32 {
    1.0 / (TAU * one_minus_cos)
}

/// The point of the unit square that [`uniform_cone`] maps to `w`.
pub fn uniform_cone_inverse(w: Vec3, one_minus_cos: f32) -> Vec2 {
    let sin2 = w.x * w.x + w.y * w.y;
    let depth = if w.z > 0.0 { sin2 / (1.0 + w.z) } else { 1.0 - w.z };
    Vec2::new(depth / one_minus_cos, turn(w))
}

/// Barycentric coordinates of vertices 0 and 1, uniform over a triangle; vertex 2 has the rest.
///
/// The square is folded along its diagonal, half of the excess going to either coordinate, which distorts less than the
/// square-root map. Source: Heitz, *A Low-Distortion Map Between Triangle and Square*, 2019.
#[inline]
pub fn uniform_triangle(u: Vec2) -> [f32; 2] {
    if u.x < u.y {
        let b0 = 0.5 * u.x;
        [b0, u.y - b0]
    } else {
        let b1 = 0.5 * u.y;
        [u.x - b1, b1]
    }
}

/// The point of the unit square that [`uniform_triangle`] maps to `b`.
pub fn uniform_triangle_inverse(b: [f32; 2]) -> Vec2 {
    if b[0] < b[1] { Vec2::new(2.0 * b[0], b[0] + b[1]) } else { Vec2::new(b[0] + b[1], 2.0 * b[1]) }
}

/// A number in (−1, 1) with density 1 − |x|.
#[inline]
pub fn tent(u: f32) -> f32 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).sqrt() }
}

/// Density of [`tent`].
#[inline]
pub fn tent_pdf(x: f32) -> f32 {
    (1.0 - x.abs()).max(0.0)
}

/// The number that [`tent`] maps to `x`.
pub fn tent_inverse(x: f32) -> f32 {
    let tail = 0.5 * (1.0 - x.abs()) * (1.0 - x.abs());
    if x < 0.0 { tail } else { 1.0 - tail }
}

/// A number in [0, 1] with a density in proportion to a linear function: `a` at 0 and `b` at 1.
///
/// Neither may be negative; if both are zero the density is uniform.
#[inline]
pub fn linear(u: f32, a: f32, b: f32) -> f32 {
    if a + b <= 0.0 {
        return u;
    }
    // The root of the quadratic that does not cancel, for either sign of the slope.
    let x = u * (a + b) / (a + lerp(u, a * a, b * b).sqrt());
    if x.is_nan() { 0.0 } else { x.min(1.0) }
}

/// Density of [`linear`].
#[inline]
pub fn linear_pdf(x: f32, a: f32, b: f32) -> f32 {
    if !(0.0..=1.0).contains(&x) {
        0.0
    } else if a + b <= 0.0 {
        1.0
    } else {
        2.0 * lerp(x, a, b) / (a + b)
    }
}

/// The number that [`linear`] maps to `x`.
pub fn linear_inverse(x: f32, a: f32, b: f32) -> f32 {
    if a + b <= 0.0 { x } else { x * (a * (2.0 - x) + b * x) / (a + b) }
}

/// A point of the unit square with a density in proportion to a bilinear function.
///
/// `values` are those at (0, 0), (1, 0), (0, 1) and (1, 1). None may be negative; if all are zero the density is uniform.
#[inline]
pub fn bilinear(u: Vec2, values: [f32; 4]) -> Vec2 {
    let [v00, v10, v01, v11] = values;
    let y = linear(u.y, v00 + v10, v01 + v11);
    Vec2::new(linear(u.x, lerp(y, v00, v01), lerp(y, v10, v11)), y)
}

/// Density of [`bilinear`].
#[inline]
pub fn bilinear_pdf(p: Vec2, values: [f32; 4]) -> f32 {
    let inside = (0.0..=1.0).contains(&p.x) && (0.0..=1.0).contains(&p.y);
    let sum: f32 = values.iter().sum();
    if !inside {
        return 0.0;
    }
    if sum <= 0.0 {
        return 1.0;
    }
    let [v00, v10, v01, v11] = values;
    4.0 * lerp(p.y, lerp(p.x, v00, v10), lerp(p.x, v01, v11)) / sum
}

/// The point of the unit square that [`bilinear`] maps to `p`.
pub fn bilinear_inverse(p: Vec2, values: [f32; 4]) -> Vec2 {
    let [v00, v10, v01, v11] = values;
    Vec2::new(
        linear_inverse(p.x, lerp(p.y, v00, v01), lerp(p.y, v10, v11)),
        linear_inverse(p.y, v00 + v10, v01 + v11),
    )
}

/// The direction of height `z` whose azimuth is the fraction `turn` of a full turn from +x.
#[inline]
fn from_height_and_turn(z: f32, turn: f32) -> Vec3 {
    let radius = safe_sqrt(1.0 - z * z);
    let (sin, cos) = sin_cos_turns(turn);
    Vec3::new(radius * cos, radius * sin, z)
}

/// Azimuth of `w` as a fraction of a full turn, in [0, 1].
fn turn(w: Vec3) -> f32 {
    let phi = w.y.atan2(w.x);
    (if phi < 0.0 { phi + 2.0 * PI } else { phi }) / TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_are_those_of_the_angle() {
        let mut worst = 0.0_f64;
        for i in -40_000..=40_000 {
            let turns = i as f32 / 10_000.0;
            let (sin, cos) = sin_cos_turns(turns);
            let (exact_sin, exact_cos) = (f64::from(turns) * std::f64::consts::TAU).sin_cos();
            worst = worst.max((f64::from(sin) - exact_sin).abs()).max((f64::from(cos) - exact_cos).abs());
        }
        assert!(worst < 1.5e-7, "{worst}");
        assert_eq!(sin_cos_turns(0.0), (0.0, 1.0));
        assert_eq!(sin_cos_turns(0.25), (1.0, 0.0));
        assert_eq!(sin_cos_turns(0.5), (0.0, -1.0));
    }
}
