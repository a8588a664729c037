//! What matter in which light spreads adds to path tracing: see [`crate::subsurface`].
//!
//! Out of line: scenes without such matter pay one question at each refraction.

use sahl_accel::Hit;
use sahl_math::{Ray, Vec3};

use super::volume::Vertex;
use super::{Arrival, Path, Walk};
use crate::bsdf::Bsdf;
use crate::integrator::Tracer;
use crate::integrator::direct::Scattering;
use crate::interaction::Interaction;
use crate::material::{Query, SubsurfaceSource};
use crate::sampler::Stream;
use crate::subsurface::Probe;

/// A point at which light may have entered, one of several.
struct Entrance {
    at: Interaction,
    hit: Hit,
    /// How many there were to choose from.
    count: u32,
}

impl<const MEDIA: bool, const TAMED: bool> Path<MEDIA, TAMED> {
    /// Goes on at a point where light entered that leaves at `at` along the path; whether it goes on.
    #[inline(never)]
    pub(super) fn spread_below(
        &self,
        tracer: &mut Tracer<'_>,
        path: &mut Walk,
        at: &Interaction,
        source: &SubsurfaceSource,
    ) -> bool {
        let scene = tracer.scene;

        // Choose where light entered.
        let point = scene.texture_point(at);
        let mut wavelengths = tracer.wavelengths;
        let query =
            Query { textures: &scene.textures, at: &point, wavelengths: &mut wavelengths, regularize: false };
        let bssrdf = source.bssrdf(at, &query);
        let (u_choice, u) = (tracer.sampler.next_1d(), tracer.sampler.next_2d());
        let mut stream = Stream::new(tracer.sampler.next_2d());
        let Some(probe) = bssrdf.probe(u_choice, u) else { return false };
        let Some(Entrance { at: entry, hit, count }) = entrance(tracer, at, &probe, &mut stream) else {
            return false;
        };
        let pdf = bssrdf.pdf(entry.p, entry.ng) / count as f32;
        let weight = bssrdf.value(entry.p) / pdf;
        if !(pdf > 0.0 && weight.is_finite()) {
            return false;
        }
        // Radiance that was divided by the square of the index on its way in gets it back.
        let eta2 = bssrdf.eta * bssrdf.eta;
        path.throughput *= weight * eta2;
        path.eta_scale /= eta2;
        path.spread |= TAMED;

        // Add light that comes there straight from a light.
        let (bsdf, wo) = (Bsdf::from(source.entry()), entry.shading.z);
        let scattering = Scattering { at: &entry, bsdf: &bsdf, wo };
        let vantage = scattering.vantage();
        if !self.selection.is_empty() {
            if MEDIA {
                let vertex = Vertex::Surface(&scattering, &hit);
                let light = self.direct_through_media(tracer, &mut path.volume, &vertex, &vantage);
                path.radiance += self.contribution(path, light);
            } else if let Some(light) = self.direct(tracer, &scattering, &vantage)
                && !tracer.is_in_shadow(&light.ray, light.light)
            {
                path.radiance += self.contribution(path, light.radiance);
            }
        }

        // Sample the direction from which the rest of the light comes.
        let (u_lobe, u) = (tracer.sampler.next_1d(), tracer.sampler.next_2d());
        let Some(sample) = bsdf.sample(Vec3::Z, u_lobe, u) else { return false };
        let wi = entry.shading.to_world(sample.wi);
        if !entry.sides_agree(wo, wi) {
            return false;
        }
        path.throughput *= sample.weight;
        path.arrival = Arrival { from: vantage, pdf: Some(sample.pdf) };
        path.ray = entry.spawn(wi);
        if MEDIA {
            path.volume.leave(scene, &entry, &hit, wi);
            path.volume.ratios.scatter(sample.pdf);
        }
        self.survives(tracer, path)
    }
}

/// One of the points where `probe` meets the same matter as that below `at`, each as likely as the others.
fn entrance(
    tracer: &mut Tracer<'_>,
    at: &Interaction,
    probe: &Probe,
    stream: &mut Stream,
) -> Option<Entrance> {
    let (scene, forward) = (tracer.scene, probe.end - probe.start);
    let end = (probe.end, Vec3::ZERO, Vec3::ZERO);
    let mut ray = Ray::new(probe.start, forward).with_t_max(1.0).with_time(at.time);
    let mut found: Option<Entrance> = None;
    while ray.direction.dot(forward) > 0.0
        && let Some(hit) = tracer.hit(&ray)
    {
        let here = scene.interaction(&ray, &hit);
        ray = Ray::spawn_to((here.p, here.p_error, here.ng), end).with_time(at.time);
        if here.material != at.material {
            continue;
        }
        let count = found.as_ref().map_or(0, |entrance| entrance.count) + 1;
        if stream.next_1d() * (count as f32) < 1.0 {
            found = Some(Entrance { at: here, hit, count });
        } else if let Some(entrance) = &mut found {
            entrance.count = count;
        }
    }
    found
}
