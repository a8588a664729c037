//! From a point of a surface to a point of texture space, and how far a pixel of the picture reaches there.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 10.2. Deviation: pbrt-v4's
//! spherical map takes the derivatives of s for those of t and the other way round; here they belong together.

use std::f32::consts::{FRAC_1_PI, PI};

use sahl_math::{Transform, Vec2, Vec3, safe_acos, safe_sqrt};
use sahl_scene::{TextureMapping, UvMapping};

use super::TexturePoint;

/// 1 / 2π.
const PER_TURN: f32 = 0.5 * FRAC_1_PI;

/// A map to the two coordinates (s, t) of texture space.
#[derive(Clone, Debug)]
pub(super) enum Mapping {
    Uv(UvMapping),
    Spherical(Box<Transform>),
    Cylindrical(Box<Transform>),
    Planar(Box<Plane>),
}

/// s and t as affine functions of the point in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    s: Vec3,
    t: Vec3,
    offset: Vec2,
}

/// The change of (s, t) from a pixel of the picture to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Differentials {
    pub(super) dx: Vec2,
    pub(super) dy: Vec2,
}

impl Mapping {
    pub(super) fn new(mapping: &TextureMapping) -> Self {
        match mapping {
            TextureMapping::Uv(uv) => Self::Uv(*uv),
            TextureMapping::Spherical { world_to_texture } => Self::Spherical(Box::new(*world_to_texture)),
            TextureMapping::Cylindrical { world_to_texture } => {
                Self::Cylindrical(Box::new(*world_to_texture))
            }
            TextureMapping::Planar { world_to_texture, s, t, offset } => {
                Self::Planar(Box::new(Plane::new(world_to_texture, [*s, *t], *offset)))
            }
        }
    }

    /// (s, t) at a point.
    #[inline]
    pub(super) fn map(&self, at: &TexturePoint) -> Vec2 {
        match self {
            Self::Uv(UvMapping { scale, offset }) => {
                Vec2::new(scale[0] * at.uv.x + offset[0], scale[1] * at.uv.y + offset[1])
            }
            Self::Spherical(to_texture) => {
                let p = to_texture.point(at.p);
                let turn = p.y.atan2(p.x) * PER_TURN;
                let turn = if turn < 0.0 { turn + 1.0 } else { turn };
                Vec2::new(safe_acos(p.z / p.length()) * FRAC_1_PI, turn)
            }
            Self::Cylindrical(to_texture) => {
                let p = to_texture.point(at.p);
                Vec2::new((PI + p.y.atan2(p.x)) * PER_TURN, p.z)
            }
            Self::Planar(plane) => {
                Vec2::new(plane.offset.x + at.p.dot(plane.s), plane.offset.y + at.p.dot(plane.t))
            }
        }
    }

    /// How (s, t) changes over the footprint of a pixel: the Jacobian times the change of the point. Zero where it is not
    /// finite: on the axis of a sphere or a cylinder.
    pub(super) fn differentials(&self, at: &TexturePoint) -> Differentials {
        let footprint = &at.footprint;
        let along = |ds: Vec3, dt: Vec3, dp: Vec3| Vec2::new(ds.dot(dp), dt.dot(dp));
        let (dx, dy) = match self {
            Self::Uv(UvMapping { scale: [su, sv], .. }) => {
                let scale = |d: Vec2| Vec2::new(su * d.x, sv * d.y);
                (scale(footprint.duv_dx), scale(footprint.duv_dy))
            }
            Self::Spherical(to_texture) => {
                let p = to_texture.point(at.p);
                let rho2 = p.x * p.x + p.y * p.y;
                let rho = safe_sqrt(rho2);
                let ds = Vec3::new(p.x * p.z / rho, p.y * p.z / rho, -rho) * (FRAC_1_PI / (rho2 + p.z * p.z));
                let dt = Vec3::new(-p.y, p.x, 0.0) * (PER_TURN / rho2);
                let moved = |dp| along(ds, dt, to_texture.vector(dp));
                (moved(footprint.dp_dx), moved(footprint.dp_dy))
            }
            Self::Cylindrical(to_texture) => {
                let p = to_texture.point(at.p);
                let ds = Vec3::new(-p.y, p.x, 0.0) * (PER_TURN / (p.x * p.x + p.y * p.y));
                let moved = |dp| along(ds, Vec3::Z, to_texture.vector(dp));
                (moved(footprint.dp_dx), moved(footprint.dp_dy))
            }
            Self::Planar(plane) => {
                (along(plane.s, plane.t, footprint.dp_dx), along(plane.s, plane.t, footprint.dp_dy))
            }
        };
        let known = |d: Vec2| if d.is_finite() { d } else { Vec2::ZERO };
        Differentials { dx: known(dx), dy: known(dy) }
    }
}

impl Plane {
    /// `axes` are those of s and t in the space into which `world_to_texture` leads.
    fn new(world_to_texture: &Transform, axes: [Vec3; 2], offset: [f32; 2]) -> Self {
        let rows = world_to_texture.to_rows();
        // The axis times the matrix: the axis as the world sees it, and what the translation adds.
        let pulled = |axis: Vec3| -> [f64; 4] {
            let axis = [axis.x, axis.y, axis.z].map(f64::from);
            std::array::from_fn(|column| (0..3).map(|row| axis[row] * rows[row][column]).sum())
        };
        let [s, t] = axes.map(pulled);
        let direction = |row: [f64; 4]| Vec3::new(row[0] as f32, row[1] as f32, row[2] as f32);
        let offset = Vec2::new(offset[0] + s[3] as f32, offset[1] + t[3] as f32);
        Self { s: direction(s), t: direction(t), offset }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Footprint;

    fn placed() -> Transform {
        let turned = Transform::rotate(0.4, [1.0, 2.0, 0.5]).unwrap();
        Transform::translate(0.3, -0.2, 1.0).unwrap().after(&turned).unwrap()
    }

    fn every() -> [TextureMapping; 4] {
        let world_to_texture = placed();
        [
            TextureMapping::Uv(UvMapping { scale: [3.0, -2.0], offset: [0.5, 0.25] }),
            TextureMapping::Spherical { world_to_texture },
            TextureMapping::Cylindrical { world_to_texture },
            TextureMapping::Planar {
                world_to_texture,
                s: Vec3::new(1.0, 0.5, 0.0),
                t: Vec3::new(0.0, 2.0, -1.0),
                offset: [0.1, 0.2],
            },
        ]
    }

    #[test]
    fn known_points_have_known_coordinates() {
        let world_to_texture = Transform::IDENTITY;
        let at = |mapping: TextureMapping, p: Vec3| {
            Mapping::new(&mapping).map(&TexturePoint { p, uv: Vec2::new(0.25, 0.5), ..Default::default() })
        };
        let close = |a: Vec2, x: f32, y: f32| (a - Vec2::new(x, y)).length() < 1e-6;
        let spherical = TextureMapping::Spherical { world_to_texture };
        assert!(close(at(spherical, Vec3::new(0.0, 0.0, 2.0)), 0.0, 0.0));
        assert!(close(at(spherical, Vec3::new(0.0, 3.0, 0.0)), 0.5, 0.25));
        assert!(close(at(spherical, Vec3::new(0.0, -1.0, -1.0)), 0.75, 0.75));
        let cylindrical = TextureMapping::Cylindrical { world_to_texture };
        assert!(close(at(cylindrical, Vec3::new(2.0, 0.0, 5.0)), 0.5, 5.0));
        assert!(close(at(cylindrical, Vec3::new(0.0, -2.0, -1.0)), 0.25, -1.0));
        let [uv, .., planar] = every();
        assert!(close(at(uv, Vec3::ZERO), 1.25, -0.75));
        let p = placed().point(Vec3::new(1.0, -2.0, 0.5));
        let st = at(planar, Vec3::new(1.0, -2.0, 0.5));
        assert!(close(st, 0.1 + p.x + 0.5 * p.y, 0.2 + 2.0 * p.y - p.z), "{st:?}");
    }

    #[test]
    fn differentials_are_those_of_the_map() {
        let (p, uv) = (Vec3::new(0.7, 0.4, -0.3), Vec2::new(0.3, 0.6));
        let footprint = Footprint {
            dp_dx: Vec3::new(1e-3, 2e-3, -5e-4),
            dp_dy: Vec3::new(-2e-3, 1e-3, 1e-3),
            duv_dx: Vec2::new(1e-3, -2e-3),
            duv_dy: Vec2::new(5e-4, 3e-3),
        };
        for description in every() {
            let mapping = Mapping::new(&description);
            let at = |p, uv| mapping.map(&TexturePoint { p, uv, ..Default::default() });
            let found = mapping.differentials(&TexturePoint { p, uv, footprint, ..Default::default() });
            let dx = at(p + footprint.dp_dx, uv + footprint.duv_dx) - at(p, uv);
            let dy = at(p + footprint.dp_dy, uv + footprint.duv_dy) - at(p, uv);
            assert!((found.dx - dx).length() < 2e-5 && (found.dy - dy).length() < 2e-5, "{description:?}");
        }
    }

    #[test]
    fn the_axis_has_no_footprint() {
        let footprint = Footprint { dp_dx: Vec3::X, dp_dy: Vec3::Y, ..Default::default() };
        let axis = TexturePoint { p: Vec3::Z, footprint, ..Default::default() };
        for mapping in [
            TextureMapping::Spherical { world_to_texture: Transform::IDENTITY },
            TextureMapping::Cylindrical { world_to_texture: Transform::IDENTITY },
        ] {
            let none = Differentials { dx: Vec2::ZERO, dy: Vec2::ZERO };
            assert_eq!(Mapping::new(&mapping).differentials(&axis), none);
        }
    }
}
