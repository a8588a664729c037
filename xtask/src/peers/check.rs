//! Whether Embree is called as it wants to be: its answers against a search of all triangles in `f64`.

use std::sync::Arc;

use sahl_accel::{Accel, BuildOptions, TriangleMesh};
use sahl_math::{Ray, Vec3};

use super::models::closed::blob;
use super::rays::Random;
use super::traversal::{NEAREST, OCCLUSION};
use super::world;
use crate::Result;
use crate::embree::{self, Draft, Embree, INVALID, Isa, Quality, RayHit, Scene, Settings};

/// Rays that are compared.
const RAYS: usize = 4_096;
/// Of so many answers, one may differ: a ray at an edge may be taken for hitting either side.
const ONE_OF: usize = 500;

/// An answer, from whomever.
#[derive(Clone, Copy, Debug)]
struct Answer {
    t: f64,
    u: f64,
    v: f64,
    primitive: u32,
}

/// Asks Embree in every configuration, and Sahl, and returns what to tell of it.
///
/// # Errors
/// The answers differ, so that nothing measured would mean anything.
pub(crate) fn check(embree: &Embree) -> Result<String> {
    let mesh = blob(6).mesh();
    let rays = rays();
    let expected: Vec<Option<Answer>> = rays.iter().map(|ray| nearest(&mesh, ray)).collect();
    let mut widths = Vec::new();
    for isa in [Isa::Avx2, Isa::Avx512] {
        let settings = Settings { isa, threads: 1, counts_memory: false };
        let Some(device) = embree.device(settings)? else { continue };
        let (device, version) = (Arc::new(device), "4.4");
        let (major, minor) = device.version();
        if format!("{major}.{minor}") != version {
            return Err(format!("Embree is {major}.{minor}, expected {version}").into());
        }
        for (quality, robust) in [(Quality::Medium, false), (Quality::High, false), (Quality::Medium, true)] {
            let scene = Draft::new(&device, &mesh, quality, robust)?.commit()?;
            check_scene(&scene, &rays, &expected)
                .map_err(|error| format!("Embree, {isa:?}, {quality:?}: {error}"))?;
        }
        widths.push(if device.is_512_bits_wide() { "AVX-512" } else { "AVX2" });
    }
    if widths.is_empty() {
        return Err("the processor has neither AVX2 nor AVX-512: nothing to compare with".into());
    }
    check_sahl(&Accel::build(world(&mesh), &BuildOptions::default()), &rays, &expected)?;
    Ok(format!("Embree 4.4 with {}; answers checked against a search of all triangles", widths.join(" and ")))
}

fn check_scene(scene: &Scene, rays: &[Ray], expected: &[Option<Answer>]) -> Result<()> {
    let mut singles: Vec<RayHit> = rays.iter().map(RayHit::new).collect();
    embree::intersect(scene, &mut singles);
    let answers = singles.iter().map(|RayHit { ray, hit }| {
        let ids = [hit.geometry, hit.instance, hit.instance_primitive];
        answer(ids, (ray.tfar, hit.u, hit.v, hit.primitive))
    });
    compare(&answers.collect::<Result<Vec<_>>>()?, expected)
        .map_err(|error| format!("single rays: {error}"))?;
    for coherent in [false, true] {
        let mut packets = embree::pack(rays);
        embree::intersect_packets(scene, &mut packets, coherent);
        let answers = packets.iter().flat_map(|p| {
            (0..16).map(|i| {
                let ids = [p.geometry[i], p.instance[i], p.instance_primitive[i]];
                answer(ids, (p.tfar[i], p.u[i], p.v[i], p.primitive[i]))
            })
        });
        compare(&answers.collect::<Result<Vec<_>>>()?, expected)
            .map_err(|error| format!("packets: {error}"))?;
    }
    let mut segments: Vec<embree::Ray> = rays.iter().map(embree::single).collect();
    embree::occluded(scene, &mut segments);
    compare_occlusion(segments.iter().map(|ray| ray.tfar == f32::NEG_INFINITY), expected)
}

fn check_sahl(accel: &Accel, rays: &[Ray], expected: &[Option<Answer>]) -> Result<()> {
    for query in NEAREST {
        let mut hits = vec![None; rays.len()];
        (query.run)(accel, rays, &mut hits);
        let answers = hits.iter().map(|hit| {
            let hit = (*hit)?;
            Some(Answer { t: hit.t.into(), u: hit.u.into(), v: hit.v.into(), primitive: hit.primitive })
        });
        compare(&answers.collect::<Vec<_>>(), expected)
            .map_err(|error| format!("Sahl {}: {error}", query.name))?;
    }
    for query in OCCLUSION {
        let mut occluded = vec![false; rays.len()];
        (query.run)(accel, rays, &mut occluded);
        compare_occlusion(occluded.into_iter(), expected)
            .map_err(|error| format!("Sahl {}: {error}", query.name))?;
    }
    Ok(())
}

/// Embree's answer, which must name the only geometry and no instance; the latter's two fields are written last.
fn answer(ids: [u32; 3], hit: (f32, f32, f32, u32)) -> Result<Option<Answer>> {
    let (t, u, v, primitive) = hit;
    match ids {
        [INVALID, ..] => Ok(None),
        [0, INVALID, INVALID] => Ok(Some(Answer { t: t.into(), u: u.into(), v: v.into(), primitive })),
        _ => Err(format!("a hit of geometry, instance and its primitive {ids:?}").into()),
    }
}

fn compare(answers: &[Option<Answer>], expected: &[Option<Answer>]) -> Result<()> {
    let alike = |(a, b): &(&Option<Answer>, &Option<Answer>)| match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            a.primitive == b.primitive
                && (a.t - b.t).abs() < 1e-4 * b.t
                && (a.u - b.u).abs().max((a.v - b.v).abs()) < 1e-3
        }
        _ => false,
    };
    judge(answers.iter().zip(expected).filter(|pair| !alike(pair)).count(), answers.len(), expected.len())
}

fn compare_occlusion(
    answers: impl ExactSizeIterator<Item = bool>,
    expected: &[Option<Answer>],
) -> Result<()> {
    let count = answers.len();
    let differing =
        answers.zip(expected).filter(|(occluded, expected)| *occluded != expected.is_some()).count();
    judge(differing, count, expected.len()).map_err(|error| format!("occlusion: {error}").into())
}

fn judge(differing: usize, answers: usize, expected: usize) -> Result<()> {
    if answers != expected || differing * ONE_OF > expected {
        return Err(format!("{differing} of {expected} answers are wrong").into());
    }
    Ok(())
}

/// Rays from a sphere about the body to points about its middle, half of which end within it.
fn rays() -> Vec<Ray> {
    let mut random = Random::new(2);
    (0..RAYS)
        .map(|i| {
            let origin = random.direction() * 3.0;
            let target = random.direction() * (1.5 * random.unit());
            let t_max = if i % 2 == 0 { f32::INFINITY } else { 1.0 };
            Ray::new(origin, target - origin).with_t_max(t_max)
        })
        .collect()
}

/// The nearest hit by Möller and Trumbore's test of all triangles in `f64`.
///
/// Source: Möller, Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997.
fn nearest(mesh: &TriangleMesh, ray: &Ray) -> Option<Answer> {
    let double = |v: Vec3| <[f32; 3]>::from(v).map(f64::from);
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let (origin, direction) = (double(ray.origin), double(ray.direction));
    let hit = |(primitive, triangle): (u32, &[u32; 3])| {
        let [a, b, c] = triangle.map(|vertex| double(mesh.positions[vertex as usize]));
        let (ab, ac, ao) = (minus(b, a), minus(c, a), minus(origin, a));
        let p = cross(direction, ac);
        let determinant = dot(ab, p);
        let q = cross(ao, ab);
        let (u, v) = (dot(ao, p) / determinant, dot(direction, q) / determinant);
        let t = dot(ac, q) / determinant;
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < f64::from(ray.t_max);
        inside.then_some(Answer { t, u, v, primitive })
    };
    (0..).zip(mesh.indices.iter()).filter_map(hit).min_by(|a, b| a.t.total_cmp(&b.t))
}
