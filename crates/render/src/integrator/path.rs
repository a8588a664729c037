//! Path tracing.
//!
//! Source: Kajiya, *The Rendering Equation*, SIGGRAPH 1986; Veach, *Robust Monte Carlo Methods for Light Transport
//! Simulation*, 1997, chapter 9 for the combination of both ways to find a light.
//!
//! In a scene file: `Integrator "path" "integer maxdepth" 8`.

use sahl_math::{Ray, Vec3};

use super::direct::Scattering;
use super::{Integrator, Tracer};
use crate::interaction::Interaction;
use crate::light::{LightSelection, Vantage};
use crate::spectrum::Spectrum;

/// Path tracing with next-event estimation, multiple importance sampling and Russian roulette.
#[derive(Debug)]
pub(crate) struct Path {
    max_depth: u32,
    selection: LightSelection,
}

/// From this depth on every path ends some time, however bright it is: light can be caught in glass without loss.
const MAX_SURE_DEPTH: u32 = 32;

/// The chance to go on from there.
const LATE_SURVIVAL: f32 = 0.95;

/// How a path came to where it is.
#[derive(Clone, Copy)]
struct Arrival {
    /// The point that the last ray left, as lights are chosen from it.
    from: Vantage,
    /// The density with which its direction was sampled; `None` where no light could have been sampled instead: from
    /// the camera and after a delta lobe.
    pdf: Option<f32>,
}

impl Path {
    /// Paths of at most `max_depth` bounces, with lights chosen by `selection`.
    pub(crate) fn new(max_depth: u32, selection: LightSelection) -> Self {
        Self { max_depth, selection }
    }

    /// The weight of light that a BSDF sample found, beside the sampling of that light with density `light_pdf`.
    #[inline]
    fn weight_of_bsdf(&self, arrival: &Arrival, light: u32, light_pdf: impl FnOnce() -> f32) -> f32 {
        let Some(pdf) = arrival.pdf else { return 1.0 };
        let pmf = self.selection.pmf(&arrival.from, light);
        if pmf == 0.0 { 1.0 } else { power_heuristic(pdf, pmf * light_pdf()) }
    }

    /// Radiance of lights at infinity along a ray that left the scene.
    fn escaped(&self, tracer: &Tracer<'_>, ray: &Ray, arrival: &Arrival) -> Spectrum {
        let mut radiance = Spectrum::ZERO;
        for &index in &tracer.scene.environments {
            let light = &tracer.scene.lights[index as usize];
            let weight = self.weight_of_bsdf(arrival, index, || light.escaped_pdf(ray.direction));
            radiance += light.escaped(ray.direction, &tracer.wavelengths) * weight;
        }
        radiance
    }

    /// Radiance that the surface emits back along the path.
    #[inline]
    fn emitted(&self, tracer: &Tracer<'_>, at: &Interaction, wo: Vec3, arrival: &Arrival) -> Spectrum {
        let Some(light) = tracer.scene.light(at) else { return Spectrum::ZERO };
        let emitted = light.emitted(at, wo, &tracer.wavelengths);
        if emitted.is_zero() {
            return emitted;
        }
        emitted * self.weight_of_bsdf(arrival, at.light, || light.pdf(arrival.from.p, at))
    }

    /// Light from one light, chosen at random, that the surface scatters along the path.
    #[inline]
    fn direct(&self, tracer: &mut Tracer<'_>, scattering: &Scattering<'_>, from: &Vantage) -> Spectrum {
        let Some(choice) = self.selection.choose(from, tracer.sampler.next_1d()) else {
            return Spectrum::ZERO;
        };
        let scene = tracer.scene;
        let light = &scene.lights[choice.light as usize];
        scattering.light_from(light, tracer, |sample, bsdf_pdf| {
            let light_pdf = choice.pmf * sample.pdf;
            let weight = if sample.is_delta { 1.0 } else { power_heuristic(light_pdf, bsdf_pdf) };
            weight / choice.pmf
        })
    }
}

impl Integrator for Path {
    fn radiance(&self, tracer: &mut Tracer<'_>, mut ray: Ray) -> Spectrum {
        let mut radiance = Spectrum::ZERO;
        let mut throughput = Spectrum::ONE;
        // The product of squared indices that the radiance was divided by: it comes back where the path leaves the glass.
        let mut eta_scale = 1.0;
        let mut arrival = Arrival { from: Vantage::in_space(ray.origin), pdf: None };
        let mut depth = 0;
        loop {
            // Find the next surface, or end with the light of the sky.
            let Some(at) = tracer.nearest(&ray) else {
                return radiance + throughput * self.escaped(tracer, &ray, &arrival);
            };
            let wo = -ray.direction;

            // Add what the surface emits.
            radiance += throughput * self.emitted(tracer, &at, wo, &arrival);

            // End at the greatest depth.
            if depth == self.max_depth {
                return radiance;
            }
            depth += 1;

            // Add light that comes straight from a light.
            let bsdf = tracer.bsdf(&at);
            let vantage = Vantage::on_surface(&at, wo, bsdf.reach());
            if !bsdf.is_specular() && !self.selection.is_empty() {
                radiance +=
                    throughput * self.direct(tracer, &Scattering { at: &at, bsdf: &bsdf, wo }, &vantage);
            }

            // Sample the direction from which the rest of the light comes.
            let (u_lobe, u) = (tracer.sampler.next_1d(), tracer.sampler.next_2d());
            let Some(sample) = bsdf.sample(at.shading.to_local(wo), u_lobe, u) else { return radiance };
            let wi = at.shading.to_world(sample.wi);
            if !at.sides_agree(wo, wi) {
                return radiance;
            }
            throughput *= sample.weight;
            eta_scale *= sample.eta * sample.eta;
            arrival = Arrival { from: vantage, pdf: (!sample.kind.is_specular()).then_some(sample.pdf) };
            ray = at.spawn(wi);

            // End dim paths at random, and make up for them with the others.
            let longest = if depth > MAX_SURE_DEPTH { LATE_SURVIVAL } else { 1.0 };
            let survival = (throughput * eta_scale).max_component().min(longest);
            if depth > 1 && survival < 1.0 {
                if tracer.sampler.next_1d() >= survival {
                    return radiance;
                }
                throughput = throughput / survival;
            }
        }
    }
}

/// How much a sample found with density `pdf` counts beside another way of density `other`.
///
/// The power heuristic with exponent two: Veach 1997, equation 9.13. The ratio is squared, not the densities, which could
/// overflow.
#[inline]
fn power_heuristic(pdf: f32, other: f32) -> f32 {
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}
