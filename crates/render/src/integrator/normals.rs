//! Shading normals as colours.
//!
//! In a scene file: `Integrator "normals"`, which pbrt does not have.

use sahl_math::Ray;

use super::{Integrator, Tracer};
use crate::spectrum::Spectrum;

/// The shading normal n of the first surface, in the world, as the colour (n + 1) / 2; black where there is none.
#[derive(Debug)]
pub(crate) struct Normals;

impl Integrator for Normals {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: Ray) -> Spectrum {
        tracer.nearest(&ray).map_or(Spectrum::ZERO, |at| {
            Spectrum::from_rgb(<[f32; 3]>::from(at.shading.z).map(|n| 0.5 * (n + 1.0)))
        })
    }
}
