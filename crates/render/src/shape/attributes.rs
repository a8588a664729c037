//! What rendering knows of a geometry beside its positions.

use std::sync::Arc;

use sahl_accel::{Accel, CurveSet, Geometry, Hit, SurfacePoint};
use sahl_math::{Frame, Ray, Transform, Vec2, Vec3};
use sahl_scene::{Handle, Medium, MediumInterface};

use crate::interaction::{Interaction, Place};
use crate::texture::FloatSource;

/// Orientation, vertex attributes, material and lights of a geometry of the accelerator.
#[derive(Clone, Debug)]
pub(crate) struct Attributes {
    /// Whether the front is the side opposite to the geometric normal of the accelerator.
    pub(crate) flip: bool,
    /// Index of the material.
    pub(crate) material: u32,
    /// The share of the surface that is there; `None` for all of it.
    pub(crate) alpha: Option<FloatSource>,
    /// Whether the material asks for tangents along ∂p/∂u.
    pub(crate) needs_tangent: bool,
    /// Whether the material is made of others.
    pub(crate) is_composed: bool,
    /// Unit shading normals of a mesh's vertices, in the space of its positions and on the front.
    pub(crate) normals: Option<Arc<[Vec3]>>,
    /// Shading tangents of a mesh's vertices, of any length, in the space of its positions.
    pub(crate) tangents: Option<Arc<[Vec3]>>,
    /// Texture coordinates of a mesh's vertices.
    pub(crate) uvs: Option<Arc<[Vec2]>>,
    /// The number of each primitive of a mesh among the faces of face textures.
    pub(crate) face_indices: Option<Arc<[u32]>>,
    /// The light that each primitive is, if the geometry emits.
    pub(crate) lights: Option<Box<[u32]>>,
    /// The media that the surface parts.
    pub(crate) border: Border,
}

/// What a surface is to the media about it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Border {
    /// The media inside and outside, by number or [`Border::VACUUM`]; `None` if the surface parts none.
    pub(crate) sides: Option<[u32; 2]>,
    /// Whether there is nothing but the border, so that light passes unchanged.
    pub(crate) is_open: bool,
}

impl Border {
    /// Stands for empty space among the numbers of media.
    pub(crate) const VACUUM: u32 = u32::MAX;

    /// The border that `shape` is; without media in the scene it parts none.
    pub(crate) fn new(shape: &sahl_scene::Shape, is_open: bool) -> Self {
        let number = |medium: Option<Handle<Medium>>| medium.map_or(Self::VACUUM, |m| m.index() as u32);
        let media = shape.media.filter(MediumInterface::is_transition);
        Self { sides: media.map(|media| [number(media.inside), number(media.outside)]), is_open }
    }
}

/// The place of a hit on a mesh: vertices and their weights.
#[derive(Clone, Copy)]
pub(super) enum Corners {
    Triangle([u32; 3], [f32; 3]),
    Patch([u32; 4], [f32; 4]),
}

impl Attributes {
    /// What integrators need to know of `hit`, found by `ray`; `is_leaky` is [`Interaction::is_leaky`].
    #[inline]
    pub(crate) fn interaction(&self, accel: &Accel, ray: &Ray, hit: &Hit, is_leaky: bool) -> Interaction {
        let SurfacePoint { p, p_error, n } = accel.surface_point(ray, hit);
        let placement =
            (hit.instance != Hit::NO_INSTANCE).then(|| accel.instance(hit.instance).to_world.at(ray.time));
        let to_world = placement.as_deref();
        let geometry = accel.geometry(hit.geometry);
        let corners = corners(geometry, hit);
        let mut ng = if self.flip { -n } else { n };
        let ns = match self.shading_normal(corners, to_world) {
            Some(ns) => {
                ng = ng.face_forward(ns);
                ns
            }
            None => ng,
        };
        // Where a coarse mesh shows a side whose interpolated normal looks away, the surface itself has to do: by the
        // shading normal it would scatter the light of its other side. Leaky normals do: see `Quirks::leaky_normals`.
        let seen_from_behind = ns.dot(ray.direction) * ng.dot(ray.direction) <= 0.0;
        let ns = if seen_from_behind && !is_leaky { ng } else { ns };
        let shading = if self.needs_tangent {
            let tangent = self.tangent(geometry, corners, (hit, ray.time), p, to_world);
            Frame::from_z_and_tangent(ns, tangent)
        } else {
            Frame::from_z(ns)
        };
        Interaction {
            p,
            time: ray.time,
            p_error,
            ng,
            shading,
            uv: self.uv(corners, hit),
            parameters: Vec2::new(hit.u, hit.v),
            place: Place { geometry: hit.geometry, primitive: hit.primitive, instance: hit.instance },
            material: self.material,
            light: self.light(hit),
            is_leaky,
        }
    }

    /// The number of a primitive among the faces of face textures; as in pbrt-v4, zero where nothing says it.
    pub(crate) fn face(&self, primitive: u32) -> u32 {
        let numbers = self.face_indices.as_ref();
        numbers.and_then(|numbers| numbers.get(primitive as usize)).copied().unwrap_or(0)
    }

    #[inline]
    fn light(&self, hit: &Hit) -> u32 {
        match &self.lights {
            Some(lights) => lights.get(hit.primitive as usize).copied().unwrap_or(Interaction::NO_LIGHT),
            None => Interaction::NO_LIGHT,
        }
    }

    /// The interpolated shading normal in the world; `None` where the mesh has none or they cancel.
    #[inline]
    fn shading_normal(&self, corners: Option<Corners>, to_world: Option<&Transform>) -> Option<Vec3> {
        let (normals, corners) = (self.normals.as_ref()?, corners?);
        let n = match corners {
            Corners::Triangle(indices, weights) => blend(normals, indices, weights),
            Corners::Patch(indices, weights) => blend(normals, indices, weights),
        };
        to_world.map_or(n, |to_world| to_world.normal(n)).try_normalize()
    }

    #[inline]
    fn uv(&self, corners: Option<Corners>, hit: &Hit) -> Vec2 {
        match (&self.uvs, corners) {
            (Some(uvs), Some(Corners::Triangle(indices, weights))) => blend_uv(uvs, indices, weights),
            (Some(uvs), Some(Corners::Patch(indices, weights))) => blend_uv(uvs, indices, weights),
            // The default coordinates of a triangle are (0,0), (1,0), (1,1).
            (None, Some(Corners::Triangle(..))) => Vec2::new(hit.u + hit.v, hit.v),
            _ => Vec2::new(hit.u, hit.v),
        }
    }

    /// ∂p/∂u of the texture coordinates in the world, up to a positive factor; zero where it has no direction.
    fn tangent(
        &self,
        geometry: &Geometry,
        corners: Option<Corners>,
        (hit, time): (&Hit, f32),
        p: Vec3,
        to_world: Option<&Transform>,
    ) -> Vec3 {
        let sweep = |to_parent: &Transform| {
            let in_parent = to_world.map_or(p, |to_world| to_world.inverse().point(p));
            let local = to_parent.inverse().point(in_parent);
            to_parent.vector(Vec3::new(-local.y, local.x, 0.0))
        };
        let given = corners.and_then(|corners| self.given_tangent(corners));
        let tangent = given.unwrap_or_else(|| match (geometry, corners) {
            (Geometry::Triangles(mesh), Some(Corners::Triangle(indices, _))) => {
                self.triangle_tangent(indices.map(|i| mesh.positions[i as usize]), indices)
            }
            (Geometry::MovingTriangles(mesh), Some(Corners::Triangle(indices, _))) => mesh
                .triangle_at(hit.primitive, time)
                .map_or(Vec3::ZERO, |vertices| self.triangle_tangent(vertices, indices)),
            (Geometry::Patches(mesh), Some(Corners::Patch(indices, _))) => {
                self.patch_tangent(indices.map(|i| mesh.positions[i as usize]), indices, [hit.u, hit.v])
            }
            (Geometry::Sphere(sphere), _) => sweep(&sphere.to_parent),
            (Geometry::Disk(disk), _) => sweep(&disk.to_parent),
            (Geometry::Cylinder(cylinder), _) => sweep(&cylinder.to_parent),
            (Geometry::Curves(curves), _) => curves.to_parent.vector(axis_tangent(curves, hit)),
            _ => Vec3::ZERO,
        });
        to_world.map_or(tangent, |to_world| to_world.vector(tangent))
    }

    /// The interpolated tangent of the mesh; `None` if it has none there.
    fn given_tangent(&self, corners: Corners) -> Option<Vec3> {
        let tangents = self.tangents.as_ref()?;
        let tangent = match corners {
            Corners::Triangle(indices, weights) => blend(tangents, indices, weights),
            Corners::Patch(indices, weights) => blend(tangents, indices, weights),
        };
        (tangent.length_squared() > 0.0).then_some(tangent)
    }

    fn triangle_tangent(&self, [p0, p1, p2]: [Vec3; 3], indices: [u32; 3]) -> Vec3 {
        let [uv0, uv1, uv2] = match &self.uvs {
            Some(uvs) => indices.map(|i| uvs[i as usize]),
            None => [Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::ONE],
        };
        let (a, b) = (uv0 - uv2, uv1 - uv2);
        let determinant = sahl_math::difference_of_products(a.x, b.y, a.y, b.x);
        ((p0 - p2) * b.y - (p1 - p2) * a.y) * 1.0_f32.copysign(determinant)
    }

    fn patch_tangent(&self, [p00, p10, p01, p11]: [Vec3; 4], indices: [u32; 4], [u, v]: [f32; 2]) -> Vec3 {
        let du = (p10 - p00) * (1.0 - v) + (p11 - p01) * v;
        let dv = (p01 - p00) * (1.0 - u) + (p11 - p10) * u;
        let Some(uvs) = &self.uvs else { return du };
        let [t00, t10, t01, t11] = indices.map(|i| uvs[i as usize]);
        let texture_du = (t10 - t00) * (1.0 - v) + (t11 - t01) * v;
        let texture_dv = (t01 - t00) * (1.0 - u) + (t11 - t10) * u;
        let determinant =
            sahl_math::difference_of_products(texture_du.x, texture_dv.y, texture_dv.x, texture_du.y);
        (du * texture_dv.y - dv * texture_du.y) * 1.0_f32.copysign(determinant)
    }
}

/// The derivative of a segment of a curve by its parameter, up to a positive factor.
fn axis_tangent(curves: &CurveSet, hit: &Hit) -> Vec3 {
    let Some(&[a, b, c, d]) = curves.points.get(hit.primitive as usize) else { return Vec3::ZERO };
    let u = hit.u;
    let tangent = (b - a) * ((1.0 - u) * (1.0 - u)) + (c - b) * (2.0 * u * (1.0 - u)) + (d - c) * (u * u);
    if tangent.length_squared() > 0.0 { tangent } else { d - a }
}

#[inline]
pub(super) fn corners(geometry: &Geometry, hit: &Hit) -> Option<Corners> {
    let (u, v) = (hit.u, hit.v);
    match geometry {
        Geometry::Triangles(mesh) => {
            Some(Corners::Triangle(mesh.indices[hit.primitive as usize], [1.0 - u - v, u, v]))
        }
        Geometry::MovingTriangles(mesh) => {
            Some(Corners::Triangle(mesh.indices[hit.primitive as usize], [1.0 - u - v, u, v]))
        }
        Geometry::Patches(mesh) => {
            let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
            Some(Corners::Patch(mesh.indices[hit.primitive as usize], weights))
        }
        Geometry::Sphere(_) | Geometry::Disk(_) | Geometry::Cylinder(_) | Geometry::Curves(_) => None,
    }
}

#[inline]
pub(super) fn blend<const N: usize>(values: &[Vec3], indices: [u32; N], weights: [f32; N]) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for (index, weight) in indices.into_iter().zip(weights) {
        sum += values[index as usize] * weight;
    }
    sum
}

#[inline]
pub(super) fn blend_uv<const N: usize>(values: &[Vec2], indices: [u32; N], weights: [f32; N]) -> Vec2 {
    let mut sum = Vec2::ZERO;
    for (index, weight) in indices.into_iter().zip(weights) {
        sum += values[index as usize] * weight;
    }
    sum
}
