//! Path tracing.
//!
//! Source: Kajiya, *The Rendering Equation*, SIGGRAPH 1986; Veach, *Robust Monte Carlo Methods for Light Transport
//! Simulation*, 1997, chapter 9 for the combination of both ways to find a light. What happens in media is told in
//! [`volume`].
//!
//! In a scene file: `Integrator "path" "integer maxdepth" 8`, or `"volpath"` for scenes with media.

mod below;
mod together;
mod volume;

use sahl_accel::Hit;
use sahl_math::Ray;
use sahl_scene::PathTracer;

use super::direct::{Scattering, Unshadowed};
use super::{CameraSample, Integrator, Tracer, one_by_one};
use crate::bsdf::{BsdfRoom, Reach};
use crate::interaction::Interaction;
use crate::light::{LightSelection, Vantage};
use crate::mis::power_heuristic;
use crate::spectrum::{HeroWavelengths, Spectrum};

use volume::{Flight, Vertex, Volume};

/// Path tracing with next-event estimation, multiple importance sampling and Russian roulette.
///
/// `MEDIA`: whether there are any; `TAMED`: whether anything makes the image differ from the physics of the scene, for less noise
/// or for surfaces that look smooth. Scenes without either have an
/// integrator of their own that knows nothing of it.
#[derive(Debug)]
pub(crate) struct Path<const MEDIA: bool, const TAMED: bool> {
    max_depth: u32,
    selection: LightSelection,
    regularize: bool,
    clamp_indirect: f32,
    smooth_terminator: bool,
}

/// From this depth on every path ends some time, however bright it is: light can be caught in glass without loss.
const MAX_SURE_DEPTH: u32 = 32;

/// The chance to go on from there.
const LATE_SURVIVAL: f32 = 0.95;

/// A path on its way from the camera into the scene.
struct Walk {
    /// The ray that it follows now.
    ray: Ray,
    /// What it has found.
    radiance: Spectrum,
    /// What its next find is multiplied by.
    throughput: Spectrum,
    /// The product of squared indices that the radiance was divided by: it comes back where the path leaves the glass.
    eta_scale: f32,
    /// The part of the throughput's largest lane that is brightness: a quarter where the first lane stands for all.
    lane_share: f32,
    arrival: Arrival,
    /// Bounces so far.
    depth: u32,
    /// Whether one of them spread the light, so that it is looked at through no more than a blur.
    spread: bool,
    /// What only scenes with media need.
    volume: Volume,
}

/// What happened to a path at a surface.
struct Bounce<'s> {
    /// Whether it goes on.
    goes_on: bool,
    /// Light from a light that it finds there, unless that is in shadow.
    direct: Option<Unshadowed<'s>>,
}

/// How a path came to where it is.
#[derive(Clone, Copy)]
struct Arrival {
    /// The point that the last ray left, as lights are chosen from it.
    from: Vantage,
    /// The density with which its direction was sampled; `None` where no light could have been sampled instead: from
    /// the camera and after a delta lobe.
    pdf: Option<f32>,
}

impl Walk {
    /// The path goes on with the first lane alone, which stands for all: nothing if it does so already. What it has found stays.
    #[inline(never)]
    fn follow_first(&mut self) {
        if self.lane_share == 1.0 {
            self.lane_share = 0.25;
            self.throughput *= HeroWavelengths::FIRST_FOR_ALL;
            self.volume.ratios.follow_first();
        }
    }
}

impl<const MEDIA: bool, const TAMED: bool> Path<MEDIA, TAMED> {
    /// Paths with the given settings, and with lights chosen by `selection`.
    pub(crate) fn new(settings: &PathTracer, selection: LightSelection) -> Self {
        let PathTracer { max_depth, regularize, clamp_indirect, smooth_terminator, .. } = *settings;
        let clamp_indirect = clamp_indirect.unwrap_or(f32::INFINITY);
        Self { max_depth, selection, regularize, clamp_indirect, smooth_terminator }
    }

    /// What the path adds to the sample for light that it found.
    ///
    /// Light that was scattered more than once is limited where the settings say so: the whole contribution is scaled, so
    /// that it keeps its colour.
    #[inline]
    fn contribution(&self, path: &Walk, found: Spectrum) -> Spectrum {
        let light = path.throughput * found;
        if !TAMED || path.depth < 2 {
            return light;
        }
        let largest = light.max_component() * path.lane_share;
        if largest > self.clamp_indirect { light * (self.clamp_indirect / largest) } else { light }
    }

    /// The weight of light that the path found by scattering, beside the sampling of that light with density
    /// `light_pdf`.
    #[inline]
    fn weight_of_found(&self, path: &Walk, light: u32, light_pdf: impl FnOnce() -> f32) -> f32 {
        let pmf =
            if path.arrival.pdf.is_some() { self.selection.pmf(&path.arrival.from, light) } else { 0.0 };
        match path.arrival.pdf {
            _ if MEDIA => path.volume.ratios.weight(pmf, light_pdf),
            Some(pdf) if pmf != 0.0 => power_heuristic(pdf, pmf * light_pdf()),
            _ => 1.0,
        }
    }

    /// Radiance of lights at infinity along a ray that left the scene.
    fn escaped(&self, tracer: &Tracer<'_>, path: &Walk) -> Spectrum {
        let mut radiance = Spectrum::ZERO;
        // Seen from where the path was last scattered: it may have crossed borders of media since.
        let (from, direction) = (path.arrival.from.p, path.ray.direction);
        for &index in &tracer.scene.environments {
            let light = &tracer.scene.lights[index as usize];
            let weight = self.weight_of_found(path, index, || light.escaped_pdf(from, direction));
            radiance += light.escaped(from, direction, &tracer.wavelengths) * weight;
        }
        radiance
    }

    /// Radiance that the surface emits back along the path.
    #[inline]
    fn emitted(&self, tracer: &Tracer<'_>, at: &Interaction, path: &Walk) -> Spectrum {
        let Some(light) = tracer.scene.light(at) else { return Spectrum::ZERO };
        let wo = -path.ray.direction;
        let emitted = light.emitted(at, wo, &tracer.scene.textures, &tracer.wavelengths);
        if emitted.is_zero() {
            return emitted;
        }
        emitted * self.weight_of_found(path, at.light, || light.pdf(path.arrival.from.p, at))
    }

    /// Light from one light, chosen at random, that the surface scatters along the path where it is not in shadow.
    #[inline]
    fn direct<'s>(
        &self,
        tracer: &mut Tracer<'s>,
        scattering: &Scattering<'_>,
        from: &Vantage,
    ) -> Option<Unshadowed<'s>> {
        let choice = self.selection.choose(from, tracer.sampler.next_1d())?;
        let scene = tracer.scene;
        let light = &scene.lights[choice.light as usize];
        scattering.light_from(light, from.p, tracer, |sample, bsdf_pdf| {
            let light_pdf = choice.pmf * sample.pdf;
            let weight = if sample.is_delta { 1.0 } else { power_heuristic(light_pdf, bsdf_pdf) };
            weight / choice.pmf
        })
    }

    /// Ends dim paths at random, and makes up for them with the others; whether this one goes on.
    #[inline]
    fn survives(&self, tracer: &mut Tracer<'_>, path: &mut Walk) -> bool {
        let longest = if path.depth > MAX_SURE_DEPTH { LATE_SURVIVAL } else { 1.0 };
        let mut carried = path.throughput * (path.eta_scale * path.lane_share);
        if MEDIA {
            carried *= path.volume.ratios.weight(0.0, || 0.0);
        }
        let survival = carried.max_component().min(longest);
        if path.depth > 1 && survival < 1.0 {
            if tracer.sampler.next_1d() >= survival {
                return false;
            }
            path.throughput = path.throughput / survival;
        }
        true
    }

    /// Adds the light of a surface to the path, but for what may be in shadow, and scatters the path there.
    // The heart of both loops.
    #[inline(always)]
    fn bounce<'s>(
        &self,
        tracer: &mut Tracer<'s>,
        path: &mut Walk,
        at: &Interaction,
        hit: &Hit,
    ) -> Bounce<'s> {
        let wo = -path.ray.direction;

        // Add what the surface emits.
        path.radiance += self.contribution(path, self.emitted(tracer, at, path));

        // End at the greatest depth.
        if path.depth == self.max_depth {
            return Bounce { goes_on: false, direct: None };
        }
        path.depth += 1;

        // Find light that comes straight from a light.
        let mut room = BsdfRoom::default();
        let bsdf = tracer.bsdf(at, TAMED && self.regularize && path.spread, &mut room);
        if tracer.wavelengths.is_terminated() {
            path.follow_first();
        }
        let lifted;
        let at = if TAMED && self.smooth_terminator && bsdf.reach() == Reach::OneSide {
            lifted = tracer.lifted(at, wo);
            &lifted
        } else {
            at
        };
        let scattering = Scattering { at, bsdf: &bsdf, wo };
        let vantage = scattering.vantage();
        let mut direct = None;
        if !bsdf.is_specular() && !self.selection.is_empty() {
            if MEDIA {
                let vertex = Vertex::Surface(&scattering, hit);
                let light = self.direct_through_media(tracer, &mut path.volume, &vertex, &vantage);
                path.radiance += self.contribution(path, light);
            } else {
                direct = self.direct(tracer, &scattering, &vantage);
                if let Some(light) = &mut direct {
                    light.radiance = self.contribution(path, light.radiance);
                }
            }
        }

        // Sample the direction from which the rest of the light comes.
        let (u_lobe, u) = (tracer.sampler.next_1d(), tracer.sampler.next_2d());
        let Some(sample) = bsdf.sample(at.shading.to_local(wo), u_lobe, u) else {
            return Bounce { goes_on: false, direct };
        };
        let wi = at.shading.to_world(sample.wi);
        if !at.sides_agree(wo, wi) {
            return Bounce { goes_on: false, direct };
        }
        path.throughput *= sample.weight;
        path.eta_scale *= sample.eta * sample.eta;
        path.arrival = Arrival { from: vantage, pdf: (!sample.kind.is_specular()).then_some(sample.pdf) };
        path.ray = at.spawn(wi);
        path.spread |= TAMED && !sample.kind.is_specular();
        if sample.kind.is_transmission()
            && let Some(source) = tracer.scene.subsurface(at.material)
        {
            return Bounce { goes_on: self.spread_below(tracer, path, at, source), direct };
        }
        if MEDIA {
            path.volume.leave(tracer.scene, at, hit, wi);
            path.volume.ratios.scatter(sample.pdf);
        }
        Bounce { goes_on: self.survives(tracer, path), direct }
    }

    /// A path that begins with `ray`.
    #[inline]
    fn begin(tracer: &mut Tracer<'_>, ray: Ray) -> Walk {
        Walk {
            ray,
            radiance: Spectrum::ZERO,
            throughput: Spectrum::ONE,
            eta_scale: 1.0,
            lane_share: 1.0,
            arrival: Arrival { from: Vantage::in_space(ray.origin), pdf: None },
            depth: 0,
            spread: false,
            volume: if MEDIA { Volume::start(tracer) } else { Volume::EMPTY },
        }
    }

    /// Follows a path to its end; returns what it has found.
    fn follow(&self, tracer: &mut Tracer<'_>, path: &mut Walk) -> Spectrum {
        loop {
            // Find the next surface, and go through the medium before it.
            let hit = tracer.hit(&path.ray);
            if MEDIA {
                match self.fly(tracer, path, hit.as_ref()) {
                    Flight::Passed => {}
                    Flight::Scattered => continue,
                    Flight::Ended => return path.radiance,
                }
            }

            // End with the light of the sky where there is none.
            let Some(hit) = hit else {
                return path.radiance + self.contribution(path, self.escaped(tracer, path));
            };
            let at = tracer.scene.interaction(&path.ray, &hit);
            if MEDIA && tracer.scene.is_border(&hit) {
                path.cross(tracer.scene, &at, &hit);
                continue;
            }
            let Bounce { goes_on, direct } = self.bounce(tracer, path, &at, &hit);
            if let Some(light) = direct
                && !tracer.is_in_shadow(&light.ray, light.light)
            {
                path.radiance += light.radiance;
            }
            if !goes_on {
                return path.radiance;
            }
        }
    }
}

impl<const MEDIA: bool, const TAMED: bool> Integrator for Path<MEDIA, TAMED> {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: Ray) -> Spectrum {
        let mut path = Self::begin(tracer, ray);
        self.follow(tracer, &mut path)
    }

    fn radiances(&self, samples: &mut [CameraSample<'_>]) {
        if MEDIA {
            // What lies on the way is not found by one query a ray.
            one_by_one(self, samples);
        } else {
            self.follow_together(samples);
        }
    }
}
