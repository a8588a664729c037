//! Many paths side by side, a bounce at a time: their rays are asked together, which hides the latency of one behind the work of
//! the others.
//!
//! Each path does what it does alone, in the same order and with the same numbers, so that the image is the same to the last bit.
//!
//! Source: Laine, Karras, Aila, *Megakernels Considered Harmful*, High Performance Graphics 2013, for processors of another kind.

use sahl_accel::Hit;
use sahl_math::Ray;

use super::{Bounce, Path, Walk};
use crate::integrator::CameraSample;
use crate::light::Light;
use crate::scene::SceneData;
use crate::spectrum::Spectrum;

/// Paths that are so few are followed one by one.
const FEW: usize = 12;

/// Paths side by side, and the queries of their next bounce.
struct Paths<'s> {
    walks: Vec<Walk>,
    /// The places of those that go on.
    active: Vec<u32>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    shadows: Shadows<'s>,
}

/// Rays to lights, and what they are for.
#[derive(Default)]
struct Shadows<'s> {
    rays: Vec<Ray>,
    /// The path that gains the radiance if nothing lies on the ray.
    gains: Vec<(u32, &'s Light, Spectrum)>,
    occluded: Vec<bool>,
}

impl<const MEDIA: bool, const TAMED: bool> Path<MEDIA, TAMED> {
    /// Follows the paths of all samples to their ends.
    pub(super) fn follow_together(&self, samples: &mut [CameraSample<'_>]) {
        let Some(scene) = samples.first().map(|sample| sample.tracer.scene) else { return };
        let active: Vec<u32> = (0..)
            .zip(samples.iter())
            .filter(|(_, sample)| sample.reaches_scene())
            .map(|(place, _)| place)
            .collect();
        let walks = samples.iter_mut().map(|sample| Self::begin(&mut sample.tracer, sample.ray)).collect();
        let mut paths = Paths {
            walks,
            active,
            rays: Vec::with_capacity(samples.len()),
            hits: vec![None; samples.len()],
            shadows: Shadows::default(),
        };
        let mut from_camera = true;
        while paths.active.len() > FEW {
            paths.find_hits(scene, from_camera);
            self.bounce_all(samples, &mut paths);
            paths.add_direct_light(scene, samples);
            from_camera = false;
        }
        for (sample, walk) in samples.iter_mut().zip(&paths.walks) {
            sample.radiance = walk.radiance;
        }
        for place in paths.active {
            let (sample, walk) = (&mut samples[place as usize], &mut paths.walks[place as usize]);
            sample.radiance = self.follow(&mut sample.tracer, walk);
        }
    }

    /// Scatters every path that meets a surface, and ends the others with the light of the sky.
    fn bounce_all<'s>(&self, samples: &mut [CameraSample<'s>], paths: &mut Paths<'s>) {
        let Paths { walks, active, hits, shadows, .. } = paths;
        shadows.rays.clear();
        shadows.gains.clear();
        let mut hits = hits.iter();
        active.retain(|&place| {
            let (tracer, path) = (&mut samples[place as usize].tracer, &mut walks[place as usize]);
            tracer.rays += 1;
            let Some(Some(hit)) = hits.next() else {
                path.radiance += self.contribution(path, self.escaped(tracer, path));
                return false;
            };
            let at = tracer.scene.interaction(&path.ray, hit);
            let Bounce { goes_on, direct } = self.bounce(tracer, path, &at, hit);
            if let Some(light) = direct {
                shadows.rays.push(light.ray);
                shadows.gains.push((place, light.light, light.radiance));
            }
            goes_on
        });
    }
}

impl Paths<'_> {
    /// Finds what the paths that go on meet next.
    fn find_hits(&mut self, scene: &SceneData, from_camera: bool) {
        let Self { walks, active, rays, hits, .. } = self;
        rays.clear();
        rays.extend(active.iter().map(|&place| walks[place as usize].ray));
        hits.truncate(rays.len());
        scene.first_hits(rays, hits, from_camera);
    }

    /// Adds the light that is not in shadow.
    fn add_direct_light(&mut self, scene: &SceneData, samples: &mut [CameraSample<'_>]) {
        let Shadows { rays, gains, occluded } = &mut self.shadows;
        occluded.resize(rays.len(), false);
        scene.are_occluded(rays, occluded);
        for ((&(place, light, radiance), ray), &occluded) in
            gains.iter().zip(rays.iter()).zip(occluded.iter())
        {
            let tracer = &mut samples[place as usize].tracer;
            tracer.rays += 1;
            if !occluded || tracer.ends_at(ray, light) {
                self.walks[place as usize].radiance += radiance;
            }
        }
    }
}
