//! Samplers and accelerators.

use sahl_scene::{Sampler, SamplerKind};

use super::super::reader::Reader;
use super::lookup;

/// Samples a pixel that a scene may ask for.
const SAMPLE_LIMIT: i32 = 1 << 24;

/// Reads one kind of sampler.
type Read = fn(&Reader<'_>) -> Sampler;

const SAMPLERS: &[(&str, Read)] = &[
    ("independent", |p| sampler_of(p, SamplerKind::Independent, 4)),
    ("sobol", |p| scrambled(p, &["permutedigits", "none"])),
    ("paddedsobol", |p| scrambled(p, &["permutedigits", "none"])),
    ("zsobol", |p| scrambled(p, &["permutedigits", "none"])),
    ("halton", |p| scrambled(p, &["none"])),
    ("pmj02bn", |p| sampler_of(p, SamplerKind::Sobol, 16)),
    ("stratified", stratified),
];

/// The sampler called `name`.
pub(in super::super) fn sampler(name: &str, p: &Reader<'_>) -> Option<Sampler> {
    lookup(SAMPLERS, name, p).map(|read| read(p))
}

fn sampler_of(p: &Reader<'_>, kind: SamplerKind, samples: i32) -> Sampler {
    Sampler {
        kind,
        samples: p.integer("pixelsamples", samples, 1, SAMPLE_LIMIT).unsigned_abs(),
        seed: seed(p),
    }
}

fn seed(p: &Reader<'_>) -> u64 {
    u64::from(p.count("seed", 0))
}

/// A low-discrepancy sampler: Owen-scrambled points stand for all of them, since their images converge to the same and
/// their noise is at most the same. Only randomisations that leave structure in the noise on purpose are told.
fn scrambled(p: &Reader<'_>, structured: &[&str]) -> Sampler {
    let known =
        [("none", "none"), ("permutedigits", "permutedigits"), ("fastowen", "owen"), ("owen", "owen")];
    let randomization = p.choice("randomization", &known, "owen");
    if structured.contains(&randomization) && p.string("randomization").is_some() {
        p.unsupported(&["randomization"], "points are Owen-scrambled");
    }
    sampler_of(p, SamplerKind::Sobol, 16)
}

fn stratified(p: &Reader<'_>) -> Sampler {
    let side = |name| p.integer(name, 4, 1, 1 << 12).unsigned_abs();
    let samples = (side("xsamples") * side("ysamples")).min(SAMPLE_LIMIT.unsigned_abs());
    if !p.bool("jitter", true) {
        p.unsupported(&["jitter"], "points are Owen-scrambled");
    }
    Sampler { kind: SamplerKind::Sobol, samples, seed: seed(p) }
}

/// Reads one kind of accelerator.
type ReadAccelerator = fn(&Reader<'_>);

const ACCELERATORS: &[(&str, ReadAccelerator)] = &[("bvh", bvh), ("kdtree", kdtree)];

/// The accelerator called `name`. None of them changes the image.
pub(in super::super) fn accelerator(name: &str, p: &Reader<'_>) {
    if let Some(read) = lookup(ACCELERATORS, name, p) {
        read(p);
    }
}

fn bvh(p: &Reader<'_>) {
    let methods = [("sah", true), ("middle", false), ("equal", false), ("hlbvh", false)];
    if !p.choice("splitmethod", &methods, true) {
        p.unsupported(&["splitmethod"], "the tree is split by the surface area heuristic");
    }
    p.unsupported(&["maxnodeprims"], "the size of a leaf follows from its cost");
}

fn kdtree(p: &Reader<'_>) {
    p.without_effect(&["intersectcost", "traversalcost", "emptybonus", "maxprims", "maxdepth"]);
    p.unsupported_plugin("unsupported-accelerator", "a `bvh` is used");
}
