//! Light transport algorithms.
//!
//! Design decision: an integrator is its settings and one method, the radiance along a camera ray; what a thread needs
//! to compute it (scene, sampler, count of rays) is a [`Tracer`]. The scene holds the integrator as a [`TileRenderer`],
//! so that there is one dynamic call a tile, and everything below it is compiled for the integrator at hand.
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
use sahl_scene::ColorMode;

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
    fn sample(&self, scene: &SceneData, pixel: [u32; 2], index: u32) -> CameraSample;
}

/// What one sample of a pixel comes to.
pub(crate) struct CameraSample {
    ray: Ray,
    pub(crate) radiance: Spectrum,
    /// What its lanes mean.
    pub(crate) wavelengths: Wavelengths,
    /// Of the pixel's filter.
    pub(crate) weight: f32,
}

impl<I: Integrator> TileRenderer for I {
    fn render_tile(&self, scene: &SceneData, aovs: &[Aov], tile: &mut Tile, pass: &Pass) -> u64 {
        let mut tracer = Tracer::new(scene);
        for (place, pixel) in tile.pixels() {
            for index in pass.samples.clone() {
                let sample = camera_sample(self, &mut tracer, pixel, index);
                let taken = SampleId { pass: pass.number, pixel, index };
                let kept = tile.add(place, sample.radiance, &sample.wavelengths, sample.weight, taken);
                if kept && !aovs.is_empty() {
                    tile.add_features(place, Features::of(&mut tracer, &sample.ray, aovs).values());
                }
            }
        }
        tracer.rays
    }

    fn sample(&self, scene: &SceneData, pixel: [u32; 2], index: u32) -> CameraSample {
        camera_sample(self, &mut Tracer::new(scene), pixel, index)
    }
}

/// Sample `index` of `pixel`: a function of nothing else. The order of dimensions is fixed: filter, lens, in
/// spectral mode the wavelengths, then the integrator's.
#[inline]
fn camera_sample(
    integrator: &impl Integrator,
    tracer: &mut Tracer<'_>,
    pixel: [u32; 2],
    index: u32,
) -> CameraSample {
    tracer.sampler.start(pixel, index, 0);
    let filtered = tracer.scene.filter.sample(tracer.sampler.pixel_2d());
    let film = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5) + filtered.offset;
    let CameraRay { ray, weight } = tracer.scene.camera.ray(film, tracer.sampler.next_2d());
    tracer.wavelengths = match tracer.scene.color {
        ColorMode::Rgb => Wavelengths::Rgb,
        ColorMode::Spectral => Wavelengths::Sampled(HeroWavelengths::sample(tracer.sampler.next_1d())),
    };
    let radiance = if weight > 0.0 { integrator.radiance(tracer, ray) * weight } else { Spectrum::ZERO };
    // Read after the path, which may have dropped some.
    CameraSample { ray, radiance, wavelengths: tracer.wavelengths, weight: filtered.weight }
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
            match (media, settings.regularize || settings.clamp_indirect.is_some()) {
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
