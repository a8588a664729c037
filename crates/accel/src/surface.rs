//! From a hit to the point on the surface.
//!
//! The point is computed from the surface, not from the ray: in `f64`, and rounded once. The error is then the
//! rounding itself, and what instances and later rays add to it.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 6.8. Deviation: the bounds there are those
//! of `f32` arithmetic; here the arithmetic is `f64` and the bounds are those of the final rounding.

use sahl_math::Ray;

use crate::accel::Accel;
use crate::geometry::curve::CurveHit;
use crate::geometry::double::DVec3;
use crate::geometry::quadric::ANY_NORMAL;
use crate::geometry::{patch, triangle};
use crate::hit::{Hit, SurfacePoint};
use crate::instance;
use crate::primitive::vertices;
use crate::world::Geometry;

/// A point, the absolute error of its coordinates, and the normal in the space of a tree.
#[derive(Clone, Copy)]
struct TreePoint {
    p: DVec3,
    error: DVec3,
    n: DVec3,
}

const EXACT: DVec3 = DVec3::new(0.0, 0.0, 0.0);

impl Accel {
    /// The point of a hit in world space at the ray's time with its error, and the geometric normal there.
    ///
    /// The normal is `(p₁−p₀) × (p₂−p₀)` for triangles and `dp/du × dp/dv` for others, in the space in which the
    /// shape is given: a quadric's own, a group's, or the world's. From there it is transformed as a normal, by the
    /// transposed inverse, and flipped by nothing: not by mirroring maps, and not towards the ray.
    ///
    /// `hit` must come from a query of this structure with this ray; only its interval may have changed. Any other gives a meaningless point, or the
    /// ray's own at `hit.t`, but no panic.
    pub fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let placed = self.placed_at(hit.instance);
        let ray = Ray { t_min: ray.t_min.max(0.0), ..*ray };
        let local_ray = placed.map_or(ray, |placed| placed.local_ray_at_time(&ray));
        let local = self.tree_point(&local_ray, hit);
        let (point, error, n) = match placed {
            Some(placed) => {
                let map = placed.map_at(ray.time);
                (map.point(local.p), instance::error(&map, local.p, local.error), map.normal(local.n))
            }
            None => (local.p, local.error, local.n),
        };
        let (p, p_error) = point.round_with_error(error);
        SurfacePoint { p, p_error, n: n.unit_or(ANY_NORMAL) }
    }

    fn tree_point(&self, ray: &Ray, hit: &Hit) -> TreePoint {
        let point = match self.world_geometry(hit.geometry) {
            Some(Geometry::Triangles(mesh)) => mesh
                .indices
                .get(hit.primitive as usize)
                .and_then(|&indices| vertices(&mesh.positions, indices))
                .map(|vertices| triangle::surface(vertices, hit.u, hit.v)),
            Some(Geometry::MovingTriangles(mesh)) => mesh
                .triangle_at(hit.primitive, ray.time)
                .map(|vertices| triangle::surface(vertices, hit.u, hit.v)),
            Some(Geometry::Patches(_)) => self.corners(hit.geometry, hit.primitive).map(|corners| {
                let kind = self.primitives.patch_kind(hit.geometry, hit.primitive);
                patch::surface(&corners, kind, hit.u, hit.v)
            }),
            _ => None,
        };
        if let Some((p, n)) = point {
            return TreePoint { p, error: EXACT, n };
        }
        if let Some(curves) = self.primitives.curves(hit.geometry) {
            let place = CurveHit { t: hit.t, u: hit.u, v: hit.v };
            if let Some(surface) = curves.surface(ray, hit.primitive, place) {
                return TreePoint { p: surface.p, error: surface.error, n: surface.n };
            }
        }
        match self.primitives.quadric(hit.geometry) {
            Some(quadric) => {
                let surface = quadric.surface(ray, hit.t);
                TreePoint { p: surface.p, error: surface.error, n: surface.n }
            }
            None => TreePoint { p: ray.at(hit.t).into(), error: EXACT, n: EXACT },
        }
    }
}
