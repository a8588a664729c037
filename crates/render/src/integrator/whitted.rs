//! Whitted's ray tracer.
//!
//! Source: Whitted, *An Improved Illumination Model for Shaded Display*, CACM 23(6), 1980; Hall, Greenberg, *A Testbed for
//! Realistic Image Synthesis*, IEEE CG&A 3(8), 1983, for ending branches that no longer count.
//!
//! In a scene file: `Integrator "whitted" "integer maxdepth" 5`.

use sahl_math::{Ray, Vec2};

use super::direct::Scattering;
use super::{Integrator, Tracer};
use crate::bsdf::BsdfRoom;
use crate::spectrum::{HeroWavelengths, Spectrum};

/// Direct light of every light, and mirror reflections and refractions followed as a tree.
///
/// Light that arrives any other way is left out: rough surfaces see lights, not each other.
#[derive(Debug)]
pub(crate) struct Whitted {
    max_depth: u32,
}

/// Branches that add less than this share to the pixel are not followed: a tree of glass would double at every hit.
const LEAST_SHARE: f32 = 1.0 / 4096.0;

/// Reflections and refractions in a row are followed by recursion, which must fit on the stack of a thread.
pub(crate) const MOST_DEPTH: u32 = 256;

/// The largest number below one: the end of the range in which a lobe is chosen.
const LAST_LOBE: f32 = 1.0 - f32::EPSILON / 2.0;

impl Whitted {
    /// At most `max_depth` reflections and refractions in a row, and at most [`MOST_DEPTH`].
    pub(crate) fn new(max_depth: u32) -> Self {
        Self { max_depth: max_depth.min(MOST_DEPTH) }
    }

    fn trace(&self, tracer: &mut Tracer<'_>, ray: &Ray, share: Spectrum, depth: u32) -> Spectrum {
        let Some(at) = tracer.nearest(ray) else { return tracer.escaped(ray) };
        let wo = -ray.direction;
        let mut radiance = tracer.emitted(&at, wo);
        // Other branches of the tree go on with all wavelengths where this one goes on with the first.
        let wavelengths = tracer.wavelengths;
        let mut room = BsdfRoom::default();
        let bsdf = tracer.bsdf(&at, false, &mut room);
        let follows_first = tracer.wavelengths.is_terminated() && !wavelengths.is_terminated();
        let lanes = if follows_first { HeroWavelengths::FIRST_FOR_ALL } else { Spectrum::ONE };
        let scattering = Scattering { at: &at, bsdf: &bsdf, wo };

        if !bsdf.is_specular() {
            // Add the light of every light.
            let scene = tracer.scene;
            let from = scattering.vantage().p;
            for light in &scene.lights {
                let Some(lit) = scattering.light_from(light, from, tracer, |_, _| 1.0) else { continue };
                if !tracer.is_in_shadow(&lit.ray, light) {
                    radiance += lanes * lit.radiance;
                }
            }
        } else if depth < self.max_depth {
            // Follow reflection and refraction: the two ends of the range of lobes.
            let local_wo = at.shading.to_local(wo);
            let mut first_kind = None;
            for u_lobe in [0.0, LAST_LOBE] {
                let Some(sample) = bsdf.sample(local_wo, u_lobe, Vec2::splat(0.5)) else { continue };
                if first_kind.replace(sample.kind) == Some(sample.kind) {
                    continue;
                }
                let wi = at.shading.to_world(sample.wi);
                // Both lobes are followed, so that neither is divided by the probability to choose it.
                let weight = sample.weight * sample.pdf;
                let share = share * weight;
                if share.max_component() >= LEAST_SHARE && at.sides_agree(wo, wi) {
                    radiance += lanes * weight * self.trace(tracer, &at.spawn(wi), share, depth + 1);
                }
            }
        }
        tracer.wavelengths = wavelengths;
        radiance
    }
}

impl Integrator for Whitted {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: Ray) -> Spectrum {
        self.trace(tracer, &ray, Spectrum::ONE, 0)
    }
}
