//! Integrators.

use sahl_scene::{Integrator, LightSampler};

use super::super::reader::Reader;
use super::lookup;

/// Reads one kind of integrator.
type Read = fn(&Reader<'_>) -> Integrator;

const INTEGRATORS: &[(&str, Read)] = &[
    ("path", path),
    ("volpath", |p| instead_of(p, &[], "which leaves out participating media")),
    ("simplepath", |p| instead_of(p, &["samplelights", "samplebsdf"], "which converges to the same image")),
    ("simplevolpath", |p| instead_of(p, &[], "which leaves out participating media")),
    ("randomwalk", |p| instead_of(p, &[], "which converges to the same image")),
    ("lightpath", |p| instead_of(p, &[], "which converges to the same image")),
    ("bdpt", |p| {
        instead_of(p, &["visualizestrategies", "visualizeweights"], "whose caustics may be noisier")
    }),
    ("mlt", |p| instead_of(p, MLT, "whose hard paths may be noisier")),
    ("sppm", |p| instead_of(p, &["photonsperiteration", "radius", "seed"], "whose caustics may be noisier")),
    ("function", |p| {
        instead_of(p, &["function", "filename", "skipbad", "imagefilename"], "which renders the scene")
    }),
    ("ambientocclusion", ambient_occlusion),
    ("whitted", |p| Integrator::Whitted { max_depth: p.count("maxdepth", 5) }),
    ("normals", |_| Integrator::Normals),
];

const MLT: &[&str] = &["bootstrapsamples", "chains", "mutationsperpixel", "largestepprobability", "sigma"];

/// The integrator called `name`: one of pbrt's, or Sahl's own `whitted` and `normals`.
pub(in super::super) fn integrator(name: &str, p: &Reader<'_>) -> Option<Integrator> {
    lookup(INTEGRATORS, name, p).map(|read| read(p))
}

fn path(p: &Reader<'_>) -> Integrator {
    if p.bool("regularize", false) {
        p.unsupported(&["regularize"], "rough surfaces are not made rougher after the first bounce");
    }
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
    Integrator::Path { max_depth: p.count("maxdepth", 5), light_sampler: chosen.unwrap_or_default() }
}

/// Path tracing instead of another integrator, whose own parameters are `own`.
fn instead_of(p: &Reader<'_>, own: &[&'static str], remark: &str) -> Integrator {
    p.without_effect(own);
    p.unsupported_plugin("unsupported-integrator", &format!("`path` is used, {remark}"));
    path(p)
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
