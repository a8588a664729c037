//! Ambient occlusion.
//!
//! In a scene file: `Integrator "ambientocclusion" "float maxdistance" 2`.

use sahl_math::{Frame, Ray};

use super::{Integrator, Tracer};
use crate::spectrum::Spectrum;
use crate::warp;

/// The share of the hemisphere about the geometric normal that is open within a distance, weighted by the cosine. Black
/// where the camera sees nothing, as in pbrt-v4.
#[derive(Debug)]
pub(crate) struct AmbientOcclusion {
    max_distance: f32,
}

impl AmbientOcclusion {
    /// Occluders farther away than `max_distance` do not count.
    pub(crate) fn new(max_distance: f32) -> Self {
        Self { max_distance }
    }
}

impl Integrator for AmbientOcclusion {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: Ray) -> Spectrum {
        let Some(at) = tracer.nearest(&ray) else { return Spectrum::ZERO };
        let frame = Frame::from_z(at.ng.face_forward(-ray.direction));
        let direction = frame.to_world(warp::cosine_hemisphere(tracer.sampler.next_2d()));
        // Directions have length one, so that parameters are distances.
        let probe = at.spawn(direction).with_t_max(self.max_distance);
        if tracer.is_occluded(&probe) { Spectrum::ZERO } else { Spectrum::ONE }
    }
}
