//! Light transport algorithms.
//!
//! Design decision: an integrator is its settings and one method, the radiance along a camera ray; what is needed
//! to compute it (scene, sampler, count of rays) is a [`Tracer`]. One that is faster with many samples at once has a second method, and
//! gives the same numbers. The scene holds the integrator as a [`TileRenderer`], so that there is one dynamic call a tile, and everything
//! below it is compiled for the integrator at hand.
//!
//! Deliberately absent: loops over pixels (the tile), and anything that outlives a sample.

mod ambient_occlusion;
mod direct;
mod normals;
mod path;
mod tracer;
mod whitted;

use std::fmt::Debug;
use std::ops::Range;

use sahl_math::{Ray, Vec2};
use sahl_scene::{ColorMode, PathTracer};

use crate::Aov;
use crate::aov::Features;
use crate::camera::CameraRay;
use crate::film::{SampleId, Tile};
use crate::light::{Light, LightSelection};
use crate::scene::SceneData;
use crate::spectrum::{HeroWavelengths, Spectrum, Wavelengths};

use ambient_occlusion::AmbientOcclusion;
use normals::Normals;
use path::Path;
use whitted::Whitted;

pub(crate) use whitted::MOST_DEPTH as MOST_WHITTED_DEPTH;

pub(crate) use tracer::Tracer;

/// A light transport algorithm.
pub(crate) trait Integrator: Debug + Send + Sync {
    /// Radiance that arrives along `ray`, estimated with one sample.
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: Ray) -> Spectrum;

    /// [`Self::radiance`] of many samples that have begun, the same to the last bit, for integrators that are faster together.
    fn radiances(&self, samples: &mut [CameraSample<'_>]) {
        one_by_one(self, samples);
    }
}

/// [`Integrator::radiances`] by [`Integrator::radiance`].
fn one_by_one(integrator: &(impl Integrator + ?Sized), samples: &mut [CameraSample<'_>]) {
    for sample in samples.iter_mut().filter(|sample| sample.reaches_scene()) {
        sample.radiance = integrator.radiance(&mut sample.tracer, sample.ray);
    }
}

/// What a tile is to be given: samples of these numbers to each pixel.
#[derive(Clone, Debug)]
pub(crate) struct Pass {
    pub(crate) number: u32,
    pub(crate) samples: Range<u32>,
}

/// An integrator behind the one dynamic call of a tile.
pub(crate) trait TileRenderer: Debug + Send + Sync {
    /// Adds the samples of `pass` to every pixel of `tile`; returns how many rays it took.
    fn render_tile(&self, scene: &SceneData, aovs: &[Aov], tile: &mut Tile, pass: &Pass) -> u64;

    /// Sample `index` of `pixel`, as the tile gets it.
    fn sample<'s>(&self, scene: &'s SceneData, pixel: [u32; 2], index: u32) -> CameraSample<'s>;
}

/// One sample of a pixel: where it begins, and what it comes to.
pub(crate) struct CameraSample<'s> {
    ray: Ray,
    /// What the camera lets through of the radiance.
    throughput: f32,
    pub(crate) radiance: Spectrum,
    /// With the sampler where the integrator goes on, and what the lanes of the radiance mean.
    pub(crate) tracer: Tracer<'s>,
    /// Of the pixel's filter.
    pub(crate) weight: f32,
}

/// Samples that are computed together: enough that queries of all their rays are worth it, and few enough to stay near the processor.
const TOGETHER: usize = 256;

impl<I: Integrator> TileRenderer for I {
    fn render_tile(&self, scene: &SceneData, aovs: &[Aov], tile: &mut Tile, pass: &Pass) -> u64 {
        let mut rays = 0;
        let mut samples = Vec::with_capacity(TOGETHER);
        let mut ids = tile
            .pixels()
            .flat_map(|(place, pixel)| pass.samples.clone().map(move |index| (place, pixel, index)))
            .peekable();
        while ids.peek().is_some() {
            let taken: Vec<_> = ids.by_ref().take(TOGETHER).collect();
            samples.clear();
            samples.extend(taken.iter().map(|&(_, pixel, index)| CameraSample::begin(scene, pixel, index)));
            finish(self, &mut samples);
            for (sample, (place, pixel, index)) in samples.iter_mut().zip(taken) {
                let taken = SampleId { pass: pass.number, pixel, index };
                let kept = tile.add(place, sample.radiance, &sample.tracer.wavelengths, sample.weight, taken);
                if kept && !aovs.is_empty() {
                    let features = Features::of(&mut sample.tracer, &sample.ray, aovs);
                    tile.add_features(place, features.values());
                }
                rays += sample.tracer.rays;
            }
        }
        rays
    }

    fn sample<'s>(&self, scene: &'s SceneData, pixel: [u32; 2], index: u32) -> CameraSample<'s> {
        let mut sample = [CameraSample::begin(scene, pixel, index)];
        finish(self, &mut sample);
        let [sample] = sample;
        sample
    }
}

/// Finds the radiances of samples that have begun.
fn finish(integrator: &impl Integrator, samples: &mut [CameraSample<'_>]) {
    integrator.radiances(samples);
    for sample in samples {
        sample.radiance *= sample.throughput;
    }
}

impl<'s> CameraSample<'s> {
    /// Sample `index` of `pixel`: a function of nothing else. The order of dimensions is fixed: filter, lens, the
    /// time if anything moves, in spectral mode the wavelengths, then the integrator's.
    #[inline]
    fn begin(scene: &'s SceneData, pixel: [u32; 2], index: u32) -> Self {
        let mut tracer = Tracer::new(scene);
        tracer.sampler.start(pixel, index, 0);
        let filtered = scene.filter.sample(tracer.sampler.pixel_2d());
        let film = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5) + filtered.offset;
        let lens = tracer.sampler.next_2d();
        let time = if scene.moves { tracer.sampler.next_1d() } else { 0.0 };
        let CameraRay { ray, weight: throughput } = scene.camera.ray(film, lens, time);
        tracer.wavelengths = match scene.color {
            ColorMode::Rgb => Wavelengths::Rgb,
            ColorMode::Spectral => Wavelengths::Sampled(HeroWavelengths::sample(tracer.sampler.next_1d())),
        };
        Self { ray, throughput, radiance: Spectrum::ZERO, tracer, weight: filtered.weight }
    }

    /// Whether the camera lets the ray through; otherwise there is none.
    #[inline]
    fn reaches_scene(&self) -> bool {
        self.throughput > 0.0
    }
}

/// Whether the settings ask for anything that makes the image differ from the physics of the scene.
fn is_tamed(settings: &PathTracer) -> bool {
    settings.regularize || settings.clamp_indirect.is_some() || settings.smooth_terminator
}

/// The integrator that `description` asks for, in a scene with the given lights and radius; `media` tells whether there are
/// any that it must know of.
pub(crate) fn new(
    description: &sahl_scene::Integrator,
    lights: &[Light],
    scene_radius: f32,
    media: bool,
) -> Box<dyn TileRenderer> {
    match *description {
        sahl_scene::Integrator::Path(settings) => {
            let selection = LightSelection::new(settings.light_sampler, lights, scene_radius);
            match (media, is_tamed(&settings)) {
                (false, false) => Box::new(Path::<false, false>::new(&settings, selection)),
                (false, true) => Box::new(Path::<false, true>::new(&settings, selection)),
                (true, false) => Box::new(Path::<true, false>::new(&settings, selection)),
                (true, true) => Box::new(Path::<true, true>::new(&settings, selection)),
            }
        }
        sahl_scene::Integrator::Whitted { max_depth } => Box::new(Whitted::new(max_depth)),
        sahl_scene::Integrator::Ao { max_distance } => Box::new(AmbientOcclusion::new(max_distance)),
        sahl_scene::Integrator::Normals => Box::new(Normals),
    }
}
