//! Surfaces: what a hit is like to the renderer, and emitting shapes as targets of sampling.
//!
//! Design decision: intersection lives in `sahl_accel`, which knows positions only. This module adds what it does not
//! know: orientation, texture coordinates, shading normals and tangents, material and light. An [`Emitter`] is a copy
//! of a shape's geometry in world space that can be sampled from a point; its density is per solid angle, and is the
//! same function for a point it sampled and for one that a ray happened to hit.
//!
//! Deliberately absent: ray intersection, and sampling of shapes for anything but direct light.

mod attributes;
mod derivatives;
mod emitter;
mod patch;
mod quadric;
mod rectangle;
mod sphere;
mod surface_map;
mod terminator;
mod triangle;

pub(crate) use attributes::{Attributes, Border};
pub(crate) use derivatives::Derivatives;
pub(crate) use emitter::{Emitter, EmitterPoint};
pub(crate) use patch::PatchEmitter;
pub(crate) use quadric::{QuadricEmitter, QuadricShape, clamp_heights, clamp_sweep, uniform_scale};
pub(crate) use sphere::SphereEmitter;
pub(crate) use surface_map::SurfaceMap;
pub(crate) use triangle::TriangleEmitter;

use sahl_math::Vec3;

/// The density per solid angle, seen from `from`, of a density per area at the point `p` with unit normal `n`.
///
/// Zero where the surface is seen edge-on or from a point of itself.
#[inline]
fn per_solid_angle(pdf_area: f32, from: Vec3, p: Vec3, n: Vec3) -> f32 {
    let d = p - from;
    let distance2 = d.length_squared();
    let projected = n.dot(d).abs();
    // d² / cos θ = d³ / (n · d).
    if projected > 0.0 { pdf_area * distance2 * distance2.sqrt() / projected } else { 0.0 }
}
