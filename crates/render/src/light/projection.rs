//! Layouts of images over the sphere of directions.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use sahl_math::{Vec2, Vec3, safe_acos, safe_sqrt};

/// How an image covers the sphere. Image coordinates run from the upper left corner, (0, 0), to the lower right one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SphereMap {
    /// A square in which equal areas are equal solid angles: an octahedron about z, opened along −z.
    ///
    /// Source: Clarberg, *Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD*, JGT 13(3), 2008; pbrt-v4's layout.
    EqualArea,
    /// Latitude by longitude: the top row is +y, the middle column looks along −z, columns to the right turn right.
    LatLong,
}

impl SphereMap {
    /// The unit direction at `uv`.
    #[inline]
    pub(crate) fn direction(self, uv: Vec2) -> Vec3 {
        match self {
            Self::EqualArea => equal_area_direction(uv),
            Self::LatLong => {
                let (sin_theta, cos_theta) = (PI * uv.y).sin_cos();
                let (sin_phi, cos_phi) = (TAU * (uv.x - 0.5)).sin_cos();
                Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
            }
        }
    }

    /// The coordinates of a unit direction, in [0, 1]².
    #[inline]
    pub(crate) fn uv(self, w: Vec3) -> Vec2 {
        match self {
            Self::EqualArea => equal_area_uv(w),
            Self::LatLong => Vec2::new(w.x.atan2(-w.z) / TAU + 0.5, safe_acos(w.y) / PI),
        }
    }

    /// Solid angle per area of the image at `uv`.
    #[inline]
    pub(crate) fn solid_angle(self, uv: Vec2) -> f32 {
        match self {
            Self::EqualArea => 4.0 * PI,
            Self::LatLong => 2.0 * PI * PI * (PI * uv.y).sin(),
        }
    }
}

fn equal_area_direction(uv: Vec2) -> Vec3 {
    let (u, v) = (2.0 * uv.x - 1.0, 2.0 * uv.y - 1.0);
    let (up, vp) = (u.abs(), v.abs());
    // Along a line parallel to the diagonal the radius is constant; d tells the hemisphere.
    let d = 1.0 - (up + vp);
    let r = 1.0 - d.abs();
    let phi = if r == 0.0 { PI / 4.0 } else { ((vp - up) / r + 1.0) * (PI / 4.0) };
    let z = (1.0 - r * r).copysign(d);
    let (sin, cos) = phi.sin_cos();
    let radius = r * safe_sqrt(2.0 - r * r);
    Vec3::new((cos * radius).copysign(u), (sin * radius).copysign(v), z)
}

fn equal_area_uv(w: Vec3) -> Vec2 {
    let (x, y) = (w.x.abs(), w.y.abs());
    // 1 − |z| from the other components, which do not cancel near the poles.
    let r = ((x * x + y * y) / (1.0 + w.z.abs())).sqrt().min(1.0);
    let turn = if x == 0.0 && y == 0.0 { 0.0 } else { y.atan2(x) / FRAC_PI_2 };
    let v = turn * r;
    let u = r - v;
    let (u, v) = if w.z < 0.0 { (1.0 - v, 1.0 - u) } else { (u, v) };
    Vec2::new((u.copysign(w.x) + 1.0) * 0.5, (v.copysign(w.y) + 1.0) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> impl Iterator<Item = Vec2> {
        (0..40 * 40).map(|i| Vec2::new((i % 40) as f32 + 0.37, (i / 40) as f32 + 0.61) / 40.0)
    }

    #[test]
    fn both_maps_invert() {
        for map in [SphereMap::EqualArea, SphereMap::LatLong] {
            for uv in grid() {
                let w = map.direction(uv);
                assert!((w.length() - 1.0).abs() < 1e-5, "{map:?} {uv:?} {w:?}");
                assert!((map.uv(w) - uv).length() < 1e-4, "{map:?} {uv:?} {:?}", map.uv(w));
            }
        }
    }

    #[test]
    fn solid_angles_are_those_of_the_map() {
        for map in [SphereMap::EqualArea, SphereMap::LatLong] {
            for uv in grid() {
                let h = 1e-3;
                let (du, dv) = (Vec2::new(h, 0.0), Vec2::new(0.0, h));
                let across = map.direction(uv + du) - map.direction(uv - du);
                let down = map.direction(uv + dv) - map.direction(uv - dv);
                let found = across.cross(down).length() / (4.0 * h * h);
                let expected = map.solid_angle(uv);
                // The equal-area map has creases on its axes and diagonals.
                let smooth = [uv.x - 0.5, uv.y - 0.5, uv.x + uv.y - 1.0, uv.x - uv.y, uv.x + uv.y - 0.5]
                    .iter()
                    .chain(&[uv.x + uv.y - 1.5, uv.x - uv.y - 0.5, uv.x - uv.y + 0.5])
                    .all(|distance| distance.abs() > 5e-3);
                assert!(
                    !smooth || (found / expected - 1.0).abs() < 0.02,
                    "{map:?} {uv:?} {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn known_directions_are_where_the_layouts_put_them() {
        let close = |a: Vec3, b: Vec3| (a - b).length() < 1e-6;
        let (equal, lat) = (SphereMap::EqualArea, SphereMap::LatLong);
        assert!(close(equal.direction(Vec2::splat(0.5)), Vec3::Z));
        assert!(close(equal.direction(Vec2::ZERO), -Vec3::Z));
        assert!(close(equal.direction(Vec2::new(1.0, 0.5)), Vec3::X));
        assert!(close(equal.direction(Vec2::new(0.5, 1.0)), Vec3::Y));
        assert!(close(lat.direction(Vec2::splat(0.5)), -Vec3::Z));
        assert!(close(lat.direction(Vec2::new(0.75, 0.5)), Vec3::X));
        assert!(close(lat.direction(Vec2::new(0.3, 0.0)), Vec3::Y));
        for w in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z] {
            for map in [equal, lat] {
                let uv = map.uv(w);
                assert!((0.0..=1.0).contains(&uv.x) && (0.0..=1.0).contains(&uv.y), "{map:?} {w:?} {uv:?}");
                assert!(close(map.direction(uv), w), "{map:?} {w:?} {uv:?}");
            }
        }
    }
}
