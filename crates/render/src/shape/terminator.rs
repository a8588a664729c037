//! Points of the smooth surface that a coarse mesh stands for.
//!
//! A mesh with shading normals looks smooth until light grazes it. There whole facets turn away from the light while their
//! normals do not, and the border of the light follows the edges of facets. The cause is where shadow rays start, not how the
//! surface scatters: started from the smooth surface, which lies above the facets where they bulge, they reach all of the light that
//! the normals see. So the point is lifted, for sampling lights and for the path's next ray alike, and BSDFs stay
//! as they are, reciprocal and conserving energy. `tests/rendering/terminator.rs` has a sphere
//! of 128 triangles that is lit as round ones are.
//!
//! Source: Hanika, *Hacking the Shadow Terminator*, in Ray Tracing Gems II, 2021. Deviations: the next ray of a path is lifted as shadow
//! rays are, so that both ways to find a light find the same; directions are refused by the interpolated normal instead of the
//! facet's; what stands closer to the facet than the lifted point keeps it down (`Tracer::lifted`).
//!
//! The alternative, Chiang, Li and Burley's *Taming the Shadow Terminator* (SIGGRAPH 2019 talks), multiplies the BSDF by a function of the light's
//! direction. It softens the border and leaves it on the facets' edges, darkens, and makes the BSDF differ by direction of transport.
//!
//! Deliberately absent: surfaces that let light through, whose rays leave on both sides; and the hollow side of a mesh, where the
//! smooth surface lies below the facets.
//!
//! On the command line: `--smooth-terminator`. pbrt-v4 has nothing like it, and its files do not ask for it.

use sahl_accel::{Accel, Geometry, Hit};
use sahl_math::{Vec3, gamma, offset_ray_origin};

use super::attributes::{Attributes, Corners, corners};
use crate::interaction::Interaction;

impl Attributes {
    /// The point of the smooth surface above `at`, a point of a facet that is seen from `wo`; `None` where the facet is the surface.
    ///
    /// With the facet's vertices vᵢ, their normals nᵢ on the side of `wo` and the weights bᵢ of the point p it is
    /// p − Σ bᵢ min(0, (p − vᵢ) · nᵢ) nᵢ: the mean of the projections of p to the planes that touch at the vertices, where p lies
    /// below them. Its geometric normal is the interpolated one.
    pub(crate) fn lifted(&self, accel: &Accel, at: &Interaction, wo: Vec3) -> Option<Interaction> {
        let side = 1.0_f32.copysign(wo.dot(at.ng));
        let (mut lift, mut normal) = (Vec3::ZERO, Vec3::ZERO);
        for (vertex, n, weight) in self.tangent_planes(accel, at)?.into_iter().flatten() {
            let below = ((at.p - vertex).dot(n) * side).min(0.0);
            lift -= n * (weight * below * side);
            normal += n * weight;
        }
        let normal = normal.try_normalize()?;
        // Where the facet shows a side that its normal does not, the facet is what is shaded, or, if normals are leaky, the other side.
        let seen_from_behind = wo.dot(normal) * side <= 0.0;
        if seen_from_behind || lift == Vec3::ZERO {
            return None;
        }
        let p = offset_ray_origin(at.p, at.p_error, at.ng, wo) + lift;
        Some(Interaction { p, p_error: p.abs() * gamma(2), ng: normal, ..*at })
    }

    /// Vertex, unit normal and weight of the corners of the facet at `at`, in the world; `None` for what is no mesh with normals.
    fn tangent_planes(&self, accel: &Accel, at: &Interaction) -> Option<[Option<(Vec3, Vec3, f32)>; 4]> {
        let normals = self.normals.as_deref()?;
        let hit = at.hit();
        let geometry = accel.geometry(hit.geometry);
        let placement =
            (hit.instance != Hit::NO_INSTANCE).then(|| accel.instance(hit.instance).to_world.at(at.time));
        let mut planes = [None; 4];
        let mut add = |vertices: &[Vec3], indices: &[u32], weights: &[f32]| {
            for (i, plane) in planes.iter_mut().enumerate().take(weights.len()) {
                let n = *normals.get(indices[i] as usize)?;
                let (vertex, n) = match placement.as_deref() {
                    Some(to_world) => (to_world.point(vertices[i]), to_world.normal(n)),
                    None => (vertices[i], n),
                };
                *plane = Some((vertex, n.try_normalize()?, weights[i]));
            }
            Some(())
        };
        match (geometry, corners(geometry, &hit)?) {
            (Geometry::Triangles(mesh), Corners::Triangle(indices, weights)) => {
                add(&indices.map(|i| mesh.positions[i as usize]), &indices, &weights)?;
            }
            (Geometry::MovingTriangles(mesh), Corners::Triangle(indices, weights)) => {
                add(&mesh.triangle_at(hit.primitive, at.time)?, &indices, &weights)?;
            }
            (Geometry::Patches(mesh), Corners::Patch(indices, weights)) => {
                add(&indices.map(|i| mesh.positions[i as usize]), &indices, &weights)?;
            }
            _ => return None,
        }
        Some(planes)
    }
}
