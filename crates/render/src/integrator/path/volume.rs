//! What media add to path tracing: flights through them, and shadow rays through them.
//!
//! Design decision: the lanes of a path see different matter but share its vertices, which one lane, the hero, chose.
//! [`Rescaled`] keeps for each lane how likely it would have made the same path, over how likely the hero did. The mean over
//! lanes is the density with which the path was found by any of four heroes, and what divides its contribution: a balance
//! heuristic over lanes, and over light and phase sampling at the same time. With colours in RGB the hero is drawn anew for
//! each camera ray; four wavelengths are drawn at random already, and the first is the hero.
//!
//! Source: Miller, Georgiev, Jarosz, *A Null-Scattering Path Integral Formulation of Light Transport*, SIGGRAPH 2019;
//! Wilkie et al., *Hero Wavelength Spectral Sampling*, EGSR 2014; Pharr, Jakob, Humphreys, *Physically Based Rendering*,
//! 4th ed., 2023, section 14.2. Deviations: Beer and Lambert's law gives the transmittance of homogeneous media to lights;
//! paths in media are subject to Russian roulette as those at surfaces are; emission of a medium is shown at the greatest
//! depth as well, as that of surfaces is.

use sahl_accel::Hit;
use sahl_math::{Ray, Vec3};

use super::{Arrival, Path, Walk};
use crate::integrator::Tracer;
use crate::integrator::direct::Scattering;
use crate::interaction::Interaction;
use crate::light::{Light, LightSample, Vantage};
use crate::medium::{Collision, HenyeyGreenstein, Medium, Next, Way};
use crate::sampler::Stream;
use crate::scene::SceneData;
use crate::shape::Border;
use crate::spectrum::{Spectrum, Wavelengths};

/// What a path knows of the media about it.
pub(super) struct Volume {
    /// Number of the medium in which it is, or [`Border::VACUUM`].
    medium: u32,
    hero: usize,
    stream: Stream,
    pub(super) ratios: Rescaled,
}

/// For each lane, the density of the path over that with which the hero chose it.
#[derive(Clone, Copy)]
pub(super) struct Rescaled {
    /// With directions sampled by BSDF and phase function.
    path: Spectrum,
    /// With the last direction sampled by light instead; the density of that, which is not known yet, left out.
    light: Spectrum,
}

/// How a flight through a medium ended.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Flight {
    /// At the surface at its end.
    Passed,
    /// By scattering: the path has a new ray.
    Scattered,
    /// The path is over.
    Ended,
}

/// Where light is scattered along the path.
pub(super) enum Vertex<'a> {
    /// At a surface.
    Surface(&'a Scattering<'a>, &'a Hit),
    /// In the medium about the path, at the time of its rays.
    Medium { p: Vec3, wo: Vec3, phase: HenyeyGreenstein, time: f32 },
}

/// Transmittance of the way to a light, with the densities of the collisions on it.
struct Passage {
    transmittance: Spectrum,
    ratios: Rescaled,
}

impl Rescaled {
    const ONE: Self = Self { path: Spectrum::ONE, light: Spectrum::ONE };

    /// What light that the path found is multiplied by, beside the sampling of that light: chosen with probability `pmf`,
    /// where zero stands for never, and then with density `pdf`.
    #[inline]
    pub(super) fn weight(&self, pmf: f32, pdf: impl FnOnce() -> f32) -> f32 {
        let beside = if pmf == 0.0 { self.path } else { self.path + self.light * (pmf * pdf()) };
        1.0 / beside.average()
    }

    /// The path goes on with the first lane alone, which is its hero: no other would have made it.
    pub(super) fn follow_first(&mut self) {
        self.path = Spectrum::splat(self.path.lanes()[0]);
        self.light = Spectrum::splat(self.light.lanes()[0]);
    }

    /// A direction was sampled with density `pdf`.
    #[inline]
    pub(super) fn scatter(&mut self, pdf: f32) {
        self.light = self.path / pdf;
    }
}

impl Volume {
    /// For paths that know nothing of media.
    pub(super) const EMPTY: Self =
        Self { medium: Border::VACUUM, hero: 0, stream: Stream::EMPTY, ratios: Rescaled::ONE };

    /// At the camera.
    pub(super) fn start(tracer: &mut Tracer<'_>) -> Self {
        let stream = Stream::new(tracer.sampler.next_2d());
        let hero = match tracer.wavelengths {
            Wavelengths::Rgb => (4.0 * tracer.sampler.next_1d()) as usize,
            Wavelengths::Sampled(_) => 0,
        };
        Self { medium: tracer.scene.camera_medium, hero, stream, ratios: Rescaled::ONE }
    }

    /// Leaves the surface at `at` along `direction`.
    pub(super) fn leave(&mut self, scene: &SceneData, at: &Interaction, hit: &Hit, direction: Vec3) {
        self.medium = scene.medium_beyond(hit, at, direction, self.medium);
    }

    fn way(&self, tracer: &Tracer<'_>, ray: Ray, length: f32) -> Way {
        Way { ray, length, hero: self.hero, wavelengths: tracer.wavelengths }
    }
}

impl Walk {
    /// Crosses the border of a medium, which is no bounce.
    pub(super) fn cross(&mut self, scene: &SceneData, at: &Interaction, hit: &Hit) {
        self.volume.leave(scene, at, hit, self.ray.direction);
        self.ray = at.spawn(self.ray.direction);
    }

    /// Takes a step whose density is `density`, lane by lane.
    fn rescale(&mut self, density: Spectrum) {
        let ratio = density / density.lanes()[self.volume.hero];
        self.throughput *= ratio;
        self.volume.ratios.path *= ratio;
    }
}

impl Vertex<'_> {
    /// How light from `wi` is scattered along the path, and the density with which `wi` would be sampled.
    fn eval(&self, wi: Vec3) -> (Spectrum, f32) {
        match self {
            Self::Surface(scattering, _) if !scattering.at.sides_agree(scattering.wo, wi) => {
                (Spectrum::ZERO, 0.0)
            }
            Self::Surface(scattering, _) => scattering.eval(wi),
            Self::Medium { wo, phase, .. } => {
                let pdf = phase.eval(*wo, wi);
                (Spectrum::splat(pdf), pdf)
            }
        }
    }

    /// The way to a light; parameters of the ray run to its `t_max`.
    fn ray_to(&self, sample: &LightSample) -> Ray {
        match (self, sample.end) {
            (Self::Surface(Scattering { at, .. }, _), Some(end)) => at.spawn_to(end),
            (Self::Surface(Scattering { at, .. }, _), None) => at.spawn(sample.wi),
            (Self::Medium { p, time, .. }, Some(end)) => {
                Ray::spawn_to((*p, Vec3::ZERO, Vec3::ZERO), end).with_time(*time)
            }
            (Self::Medium { p, time, .. }, None) => Ray::new(*p, sample.wi).with_time(*time),
        }
    }
}

impl<const MEDIA: bool, const TAMED: bool> Path<MEDIA, TAMED> {
    /// Goes from where the path is to the surface that `hit` found, or to infinity, through the medium in which it is.
    pub(super) fn fly(&self, tracer: &mut Tracer<'_>, path: &mut Walk, hit: Option<&Hit>) -> Flight {
        let scene = tracer.scene;
        let Some(medium) = scene.media.get(path.volume.medium as usize) else { return Flight::Passed };
        let way = path.volume.way(tracer, path.ray, hit.map_or(f32::INFINITY, |hit| hit.t));
        let mut flight = Flight::Passed;
        let mut vertex = Vec3::ZERO;
        let mut stream = path.volume.stream;
        let rest = medium.walk(&way, tracer.sampler.next_1d(), &mut stream, |collision| {
            vertex = collision.p;
            self.collide(path, collision, &mut flight)
        });
        path.volume.stream = stream;
        match flight {
            Flight::Ended => {}
            Flight::Scattered => flight = self.scatter(tracer, path, medium, vertex),
            Flight::Passed => {
                // Sampling a light asks how much passes, not whether light passes: by law, or by a walk like this one.
                let by_law = medium.transmittance(&way).is_some();
                let asked = if by_law { Spectrum::ONE } else { rest };
                path.volume.ratios.light *= asked / rest.lanes()[path.volume.hero];
                path.rescale(rest);
            }
        }
        flight
    }

    /// Decides what happens at a tentative collision, and adds what the medium emits there.
    fn collide(&self, path: &mut Walk, collision: &Collision, flight: &mut Flight) -> Next {
        let hero = path.volume.hero;
        let Collision { properties, majorant, transmittance, u, .. } = *collision;
        let lane = |spectrum: Spectrum| spectrum.lanes()[hero];

        // Add emission, as if light had been absorbed here for certain.
        if !properties.emission.is_zero() {
            let tentative = transmittance * majorant / lane(transmittance * majorant);
            let density = (path.volume.ratios.path * tentative).average();
            let found =
                transmittance / lane(transmittance * majorant) * properties.sigma_a * properties.emission;
            path.radiance += self.contribution(path, found / density);
        }

        // Choose between absorption, scattering, and that no matter was there.
        let (absorbed, scattered) = (lane(properties.sigma_a), lane(properties.sigma_s));
        let chosen = u * lane(majorant);
        if chosen < absorbed || chosen < absorbed + scattered && path.depth == self.max_depth {
            *flight = Flight::Ended;
            return Next::Stop;
        }
        if chosen < absorbed + scattered {
            path.depth += 1;
            path.rescale(transmittance * properties.sigma_s);
            *flight = Flight::Scattered;
            return Next::Stop;
        }
        let nothing = (majorant - properties.sigma_a - properties.sigma_s).clamp(0.0, f32::MAX);
        if lane(nothing) == 0.0 {
            // Rounding alone leads here.
            *flight = Flight::Ended;
            return Next::Stop;
        }
        path.volume.ratios.light *= transmittance * majorant / lane(transmittance * nothing);
        path.rescale(transmittance * nothing);
        Next::Walk
    }

    /// Scatters the path at the point `p` of a medium.
    fn scatter(&self, tracer: &mut Tracer<'_>, path: &mut Walk, medium: &Medium, p: Vec3) -> Flight {
        let (wo, phase, from) = (-path.ray.direction, medium.phase(), Vantage::in_space(p));
        if !self.selection.is_empty() {
            let vertex = Vertex::Medium { p, wo, phase, time: path.ray.time };
            let direct = self.direct_through_media(tracer, &mut path.volume, &vertex, &from);
            path.radiance += self.contribution(path, direct);
        }
        let sample = phase.sample(wo, tracer.sampler.next_2d());
        path.volume.ratios.scatter(sample.pdf);
        path.arrival = Arrival { from, pdf: Some(sample.pdf) };
        path.ray = Ray::new(p, sample.wi).with_time(path.ray.time);
        path.spread |= TAMED;
        if self.survives(tracer, path) { Flight::Scattered } else { Flight::Ended }
    }

    /// Light from one light, chosen at random, that is scattered at `vertex` along the path.
    pub(super) fn direct_through_media(
        &self,
        tracer: &mut Tracer<'_>,
        volume: &mut Volume,
        vertex: &Vertex<'_>,
        from: &Vantage,
    ) -> Spectrum {
        let scene = tracer.scene;
        let Some(choice) = self.selection.choose(from, tracer.sampler.next_1d()) else {
            return Spectrum::ZERO;
        };
        let light = &scene.lights[choice.light as usize];
        let u = tracer.sampler.next_2d();
        let Some(sample) = light.sample(from.p, u, &scene.textures, &tracer.wavelengths) else {
            return Spectrum::ZERO;
        };
        let (f, scattering_pdf) = vertex.eval(sample.wi);
        if f.is_zero() {
            return Spectrum::ZERO;
        }
        let Some(Passage { transmittance, ratios }) = volume.passage(tracer, vertex, (light, &sample)) else {
            return Spectrum::ZERO;
        };
        let mut density = ratios.light * (choice.pmf * sample.pdf);
        if !sample.is_delta {
            density += ratios.path * scattering_pdf;
        }
        f * sample.radiance * transmittance / (volume.ratios.path * density).average()
    }
}

impl Volume {
    /// The transmittance from `vertex` to a sample of a light, one estimate; `None` if a surface is in the way.
    fn passage(
        &mut self,
        tracer: &mut Tracer<'_>,
        vertex: &Vertex<'_>,
        (light, sample): (&Light, &LightSample),
    ) -> Option<Passage> {
        let scene = tracer.scene;
        let mut medium = match vertex {
            Vertex::Surface(scattering, hit) => {
                scene.medium_beyond(hit, scattering.at, sample.wi, self.medium)
            }
            Vertex::Medium { .. } => self.medium,
        };
        let mut ray = vertex.ray_to(sample);
        let forward = ray.direction;
        let mut passage = Passage { transmittance: Spectrum::ONE, ratios: Rescaled::ONE };
        loop {
            let hit = tracer.hit(&ray).filter(|hit| !tracer.is_target(&ray, hit, light));
            if hit.is_some_and(|hit| !scene.is_border(&hit)) {
                return None;
            }
            if let Some(medium) = scene.media.get(medium as usize) {
                let end = hit.map_or(ray.t_max, |hit| hit.t);
                self.pass(tracer, medium, (&ray, end), &mut passage);
                if passage.transmittance.is_zero() {
                    return None;
                }
            }
            let Some(hit) = hit else { return Some(passage) };
            let at = scene.interaction(&ray, &hit);
            medium = scene.medium_beyond(&hit, &at, ray.direction, medium);
            ray = match sample.end {
                Some(end) => at.spawn_to(end),
                None => at.spawn(ray.direction),
            };
            // A border so near to the light that its bounds of error meet is the last.
            if ray.direction.dot(forward) <= 0.0 {
                return Some(passage);
            }
        }
    }

    /// Passes one medium, to the parameter `end` of a ray of any length.
    fn pass(&mut self, tracer: &Tracer<'_>, medium: &Medium, (ray, end): (&Ray, f32), passage: &mut Passage) {
        let length = ray.direction.length();
        let way = self.way(tracer, Ray::new(ray.origin, ray.direction / length), end * length);
        if let Some(transmittance) = medium.transmittance(&way) {
            passage.transmittance *= transmittance;
            passage.ratios.path *= transmittance;
            return;
        }
        let hero = self.hero;
        let mut stream = self.stream;
        let u = stream.next_1d();
        let rest = medium.walk(&way, u, &mut stream, |collision| passage.collide(collision, hero));
        self.stream = stream;
        let ratio = rest / rest.lanes()[hero];
        passage.transmittance *= ratio;
        passage.ratios.path *= ratio;
        passage.ratios.light *= ratio;
    }
}

/// Below this share of what could pass, three walks of four end, and the fourth stands for them.
const DIM: f32 = 0.05;
const DIM_SURVIVAL: f32 = 0.25;

impl Passage {
    /// Passes a tentative collision: what is lost there is weighed, not drawn (ratio tracking).
    fn collide(&mut self, collision: &Collision, hero: usize) -> Next {
        let Collision { properties, majorant, transmittance, u, .. } = *collision;
        let nothing = (majorant - properties.sigma_a - properties.sigma_s).clamp(0.0, f32::MAX);
        let pdf = (transmittance * majorant).lanes()[hero];
        let kept = transmittance * nothing / pdf;
        self.transmittance *= kept;
        self.ratios.path *= kept;
        self.ratios.light *= transmittance * majorant / pdf;
        let estimate = self.transmittance * self.ratios.weight(1.0, || 1.0);
        if estimate.max_component() < DIM {
            if u >= DIM_SURVIVAL {
                self.transmittance = Spectrum::ZERO;
            } else {
                self.transmittance = self.transmittance / DIM_SURVIVAL;
            }
        }
        if self.transmittance.is_zero() { Next::Stop } else { Next::Walk }
    }
}
