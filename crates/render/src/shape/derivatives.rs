//! How a surface changes along its coordinates, for materials that give it relief.

use std::f32::consts::TAU;

use sahl_accel::{Accel, Geometry, Hit};
use sahl_math::{Transform, Vec2, Vec3, difference_of_products, safe_acos};

use super::attributes::{Attributes, Corners, blend, blend_uv, corners};
use super::clamp_heights;
use crate::interaction::Interaction;

/// Derivatives of the position and of the unit shading normal by the texture coordinates; in world space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Derivatives {
    /// ∂p/∂u.
    pub(crate) dp_du: Vec3,
    /// ∂p/∂v.
    pub(crate) dp_dv: Vec3,
    /// ∂n/∂u.
    pub(crate) dn_du: Vec3,
    /// ∂n/∂v.
    pub(crate) dn_dv: Vec3,
}

/// Derivatives by the parameters of a triangle or patch; of the texture coordinates, too.
struct ByParameters {
    p: [Vec3; 2],
    n: [Vec3; 2],
    uv: [Vec2; 2],
}

impl Attributes {
    /// Derivatives where `hit` met the surface at `at`; zero where texture coordinates don't change along the surface.
    ///
    /// Fibres have none.
    pub(crate) fn derivatives(&self, accel: &Accel, hit: &Hit, at: &Interaction) -> Derivatives {
        let geometry = accel.geometry(hit.geometry);
        let placement =
            (hit.instance != Hit::NO_INSTANCE).then(|| accel.instance(hit.instance).to_world.at(at.time));
        let to_world = placement.as_deref();
        let in_parent = to_world.map_or(at.p, |to_world| to_world.inverse().point(at.p));
        let along = |positions: &[Vec3], corners: Corners| {
            corners.differences(hit.u, hit.v).map(|weights| weights.blend(positions))
        };
        let parent = match (geometry, corners(geometry, hit)) {
            (Geometry::Triangles(mesh), Some(corners @ Corners::Triangle(..))) => {
                self.of_mesh(along(&mesh.positions, corners), corners, hit)
            }
            (Geometry::MovingTriangles(mesh), Some(corners @ Corners::Triangle(..))) => {
                let [start, end] = mesh.positions.each_ref().map(|positions| along(positions, corners));
                let change = [0, 1].map(|i| start[i] * (1.0 - at.time) + end[i] * at.time);
                self.of_mesh(change, corners, hit)
            }
            (Geometry::Patches(mesh), Some(corners @ Corners::Patch(..))) => {
                self.of_mesh(along(&mesh.positions, corners), corners, hit)
            }
            _ => self.of_quadric(geometry, in_parent),
        };
        match to_world {
            None => parent,
            Some(to_world) => {
                let n = self.parent_normal(geometry, hit, to_world, at);
                parent.transformed(to_world, n)
            }
        }
    }

    /// The shading normal in the space of an instance's object.
    fn parent_normal(&self, geometry: &Geometry, hit: &Hit, to_world: &Transform, at: &Interaction) -> Vec3 {
        let interpolated = self.normals.as_ref().zip(corners(geometry, hit));
        let n = interpolated.and_then(|(normals, corners)| corners.blend(normals).try_normalize());
        n.or_else(|| to_world.inverse().normal(at.shading.z).try_normalize()).unwrap_or(Vec3::Z)
    }

    /// Those of a mesh whose points change with the parameters of the hit by `p`.
    fn of_mesh(&self, p: [Vec3; 2], corners: Corners, hit: &Hit) -> Derivatives {
        let change = self.by_parameters(p, corners, hit);
        let [uv_a, uv_b] = change.uv;
        let determinant = difference_of_products(uv_a.x, uv_b.y, uv_a.y, uv_b.x);
        if determinant == 0.0 || !determinant.is_finite() {
            return Derivatives::default();
        }
        let inverse = 1.0 / determinant;
        let by_u = |[a, b]: [Vec3; 2]| (a * uv_b.y - b * uv_a.y) * inverse;
        let by_v = |[a, b]: [Vec3; 2]| (b * uv_a.x - a * uv_b.x) * inverse;
        let found = Derivatives {
            dp_du: by_u(change.p),
            dp_dv: by_v(change.p),
            dn_du: by_u(change.n),
            dn_dv: by_v(change.n),
        };
        found.finite()
    }

    fn by_parameters(&self, p: [Vec3; 2], corners: Corners, hit: &Hit) -> ByParameters {
        let differences = corners.differences(hit.u, hit.v);
        let along = |values: &[Vec3]| differences.map(|weights| weights.blend(values));
        let n = match &self.normals {
            None => [Vec3::ZERO; 2],
            Some(normals) => {
                let n = corners.blend(normals);
                along(normals).map(|change| change_of_unit(n, change))
            }
        };
        let uv = match (&self.uvs, corners) {
            (Some(uvs), _) => differences.map(|weights| weights.blend_uv(uvs)),
            // The coordinates of triangles without any: see `Attributes::uv`.
            (None, Corners::Triangle(..)) => [Vec2::new(1.0, 0.0), Vec2::ONE],
            (None, Corners::Patch(..)) => [Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)],
        };
        ByParameters { p, n, uv }
    }

    fn of_quadric(&self, geometry: &Geometry, in_parent: Vec3) -> Derivatives {
        let sign = if self.flip { -1.0 } else { 1.0 };
        let local = |to_parent: &Transform| to_parent.inverse().point(in_parent);
        let turn = |p: Vec3, phi_max: f32| Vec3::new(-p.y, p.x, 0.0) * phi_max.clamp(0.0, TAU);
        match geometry {
            Geometry::Sphere(sphere) => {
                let p = local(&sphere.to_parent);
                let (z_min, z_max) = clamp_heights(sphere.z_min, sphere.z_max, sphere.radius);
                let sweep = safe_acos(z_max / sphere.radius) - safe_acos(z_min / sphere.radius);
                let distance = p.x.hypot(p.y);
                let outward =
                    if distance > 0.0 { Vec2::new(p.x, p.y) * (1.0 / distance) } else { Vec2::new(1.0, 0.0) };
                let dp_dv = Vec3::new(p.z * outward.x, p.z * outward.y, -distance) * sweep;
                let dp_du = turn(p, sphere.phi_max);
                let curvature = sign / sphere.radius;
                Derivatives { dp_du, dp_dv, dn_du: dp_du * curvature, dn_dv: dp_dv * curvature }
                    .transformed(&sphere.to_parent, p * curvature)
            }
            Geometry::Cylinder(cylinder) => {
                let p = local(&cylinder.to_parent);
                let dp_du = turn(p, cylinder.phi_max);
                let dp_dv = Vec3::new(0.0, 0.0, cylinder.z_max - cylinder.z_min);
                let curvature = sign / cylinder.radius;
                Derivatives { dp_du, dp_dv, dn_du: dp_du * curvature, dn_dv: Vec3::ZERO }
                    .transformed(&cylinder.to_parent, Vec3::new(p.x, p.y, 0.0) * curvature)
            }
            Geometry::Disk(disk) => {
                let p = local(&disk.to_parent);
                let distance = p.x.hypot(p.y);
                let inward = (disk.inner_radius - disk.radius) / distance;
                let dp_dv = Vec3::new(p.x, p.y, 0.0) * if inward.is_finite() { inward } else { 0.0 };
                let flat = Derivatives { dp_du: turn(p, disk.phi_max), dp_dv, ..Derivatives::default() };
                flat.transformed(&disk.to_parent, Vec3::Z * sign)
            }
            _ => Derivatives::default(),
        }
    }
}

impl Derivatives {
    /// The change of (u, v) that moves the point by `dp`, as well as the plane of both derivatives allows: least squares. Zero
    /// where they are parallel. Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 10.1.1.
    pub(crate) fn coordinates(&self, dp: Vec3) -> Vec2 {
        let (uu, uv, vv) =
            (self.dp_du.dot(self.dp_du), self.dp_du.dot(self.dp_dv), self.dp_dv.dot(self.dp_dv));
        let (u, v) = (self.dp_du.dot(dp), self.dp_dv.dot(dp));
        let determinant = difference_of_products(uu, vv, uv, uv);
        let solved = Vec2::new(difference_of_products(vv, u, uv, v), difference_of_products(uu, v, uv, u))
            / determinant;
        if solved.is_finite() { solved } else { Vec2::ZERO }
    }

    /// These in the space into which `transform` leads; `n` is the unit normal before.
    fn transformed(&self, transform: &Transform, n: Vec3) -> Self {
        let normal = transform.normal(n);
        let change = |dn: Vec3| change_of_unit(normal, transform.normal(dn));
        let moved = Self {
            dp_du: transform.vector(self.dp_du),
            dp_dv: transform.vector(self.dp_dv),
            dn_du: change(self.dn_du),
            dn_dv: change(self.dn_dv),
        };
        moved.finite()
    }

    /// These, or none if rounding went too far.
    fn finite(self) -> Self {
        let all = [self.dp_du, self.dp_dv, self.dn_du, self.dn_dv];
        if all.iter().all(|v| v.is_finite()) { self } else { Self::default() }
    }
}

/// How n / |n| changes when `n` changes by `dn`.
fn change_of_unit(n: Vec3, dn: Vec3) -> Vec3 {
    let length = n.length();
    if length == 0.0 {
        return Vec3::ZERO;
    }
    let unit = n * (1.0 / length);
    (dn - unit * unit.dot(dn)) * (1.0 / length)
}

impl Corners {
    fn blend(self, values: &[Vec3]) -> Vec3 {
        match self {
            Self::Triangle(indices, weights) => blend(values, indices, weights),
            Self::Patch(indices, weights) => blend(values, indices, weights),
        }
    }

    fn blend_uv(self, values: &[Vec2]) -> Vec2 {
        match self {
            Self::Triangle(indices, weights) => blend_uv(values, indices, weights),
            Self::Patch(indices, weights) => blend_uv(values, indices, weights),
        }
    }

    /// The corners with the derivatives of their weights by the two parameters.
    fn differences(self, u: f32, v: f32) -> [Self; 2] {
        match self {
            Self::Triangle(indices, _) => {
                [[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]].map(|weights| Self::Triangle(indices, weights))
            }
            Self::Patch(indices, _) => [[v - 1.0, 1.0 - v, -v, v], [u - 1.0, -u, 1.0 - u, u]]
                .map(|weights| Self::Patch(indices, weights)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_undo_the_derivatives() {
        let skew = Derivatives {
            dp_du: Vec3::new(2.0, 0.5, 0.1),
            dp_dv: Vec3::new(-0.3, 1.5, 0.7),
            ..Derivatives::default()
        };
        let n = skew.dp_du.cross(skew.dp_dv);
        // What leaves the surface does not count.
        let moved = skew.dp_du * 0.25 - skew.dp_dv * 0.5 + n * 3.0;
        assert!((skew.coordinates(moved) - Vec2::new(0.25, -0.5)).length() < 1e-6);
        let flat = Derivatives { dp_du: Vec3::X, dp_dv: Vec3::X * 2.0, ..Derivatives::default() };
        assert_eq!(flat.coordinates(Vec3::Y), Vec2::ZERO);
    }
}
