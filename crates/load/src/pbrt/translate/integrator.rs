//! Integrators.

use sahl_scene::{Integrator, LightSampler, PathTracer};

use super::super::reader::Reader;
use super::lookup;

/// Reads one kind of integrator.
type Read = fn(&Reader<'_>) -> Integrator;

const INTEGRATORS: &[(&str, Read)] = &[
    ("path", |p| Integrator::Path(path(p, Space::Empty))),
    ("volpath", |p| Integrator::Path(path(p, Space::Filled))),
    ("simplepath", |p| {
        instead_of(p, &["samplelights", "samplebsdf"], Space::Empty, "which converges to the same image")
    }),
    ("simplevolpath", |p| instead_of(p, &[], Space::Filled, "which converges to the same image")),
    ("randomwalk", |p| instead_of(p, &[], Space::Empty, "which converges to the same image")),
    ("lightpath", |p| instead_of(p, &[], Space::Empty, "which converges to the same image")),
    ("bdpt", |p| {
        let own = ["visualizestrategies", "visualizeweights"];
        instead_of(p, &own, Space::Filled, "whose caustics may be noisier")
    }),
    ("mlt", |p| instead_of(p, MLT, Space::Filled, "whose hard paths may be noisier")),
    ("sppm", |p| {
        let own = ["photonsperiteration", "radius", "seed"];
        instead_of(p, &own, Space::Empty, "whose caustics may be noisier")
    }),
    ("function", |p| {
        let own = ["function", "filename", "skipbad", "imagefilename"];
        instead_of(p, &own, Space::Empty, "which renders the scene")
    }),
    ("ambientocclusion", ambient_occlusion),
    ("whitted", |p| Integrator::Whitted { max_depth: p.count("maxdepth", 5) }),
    ("normals", |_| Integrator::Normals),
];

const MLT: &[&str] = &["bootstrapsamples", "chains", "mutationsperpixel", "largestepprobability", "sigma"];

/// Whether an integrator of pbrt knows media.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Space {
    /// It leaves them out.
    Empty,
    /// It renders them.
    Filled,
}

/// The integrator called `name`: one of pbrt's, or Sahl's own `whitted` and `normals`.
pub(in super::super) fn integrator(name: &str, p: &Reader<'_>) -> Option<Integrator> {
    lookup(INTEGRATORS, name, p).map(|read| read(p))
}

fn path(p: &Reader<'_>, space: Space) -> PathTracer {
    let samplers = [
        ("bvh", Some(LightSampler::Tree)),
        ("power", Some(LightSampler::Power)),
        ("uniform", Some(LightSampler::Uniform)),
        ("exhaustive", None),
    ];
    let chosen = p.choice("lightsampler", &samplers, Some(LightSampler::default()));
    if chosen.is_none() {
        p.unsupported(&["lightsampler"], "`bvh` is used, which converges to the same image");
    }
    PathTracer {
        max_depth: p.count("maxdepth", 5),
        light_sampler: chosen.unwrap_or_default(),
        media: space == Space::Filled,
        regularize: p.bool("regularize", false),
        clamp_indirect: None,
        smooth_terminator: false,
    }
}

/// Path tracing instead of another integrator, whose own parameters are `own`.
fn instead_of(p: &Reader<'_>, own: &[&'static str], space: Space, remark: &str) -> Integrator {
    p.without_effect(own);
    p.unsupported_plugin("unsupported-integrator", &format!("`path` is used, {remark}"));
    Integrator::Path(path(p, space))
}

fn ambient_occlusion(p: &Reader<'_>) -> Integrator {
    if !p.bool("cossample", true) {
        p.unsupported(
            &["cossample"],
            "directions are sampled by the cosine, which converges to the same image",
        );
    }
    Integrator::Ao { max_distance: p.float_or_infinity("maxdistance") }
}
