//! The nearest hit against Möller–Trumbore in double precision, which shares no arithmetic with what is tested.
//!
//! Compared are rays about which `f32` can tell: those that pass every triangle's edges, and separate the two nearest hits, by
//! more than the error that `triangle.rs` derives. With ε half of `f32::EPSILON`, `m` the largest coordinate relative to the
//! origin, `d` the largest of the direction, and `n` the product of two sides, an edge function is known to within
//! `72 ε m²`, of a triangle whose projected area is `|n·direction| / d`; a parameter to within
//! `m / d (16 ε + 450 ε m² d / |n·direction|)`.

mod common;

use common::agreement::{every_accel, intersect_batch, intersect_coherent, occluded_batch};
use common::meshes::{blob, grid_cube, torus};
use common::worlds::{camera_rays, rays_at, soup};
use common::{Random, world_of};
use sahl_accel::{Geometry, TriangleMesh};
use sahl_math::{Ray, Vec3};

const ROUNDOFF: f64 = 0.5 * f32::EPSILON as f64;

type D3 = [f64; 3];

fn d(v: Vec3) -> D3 {
    [v.x, v.y, v.z].map(f64::from)
}

fn sub(a: D3, b: D3) -> D3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: D3, b: D3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: D3, b: D3) -> D3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn largest(v: D3) -> f64 {
    v.iter().fold(0.0, |largest, x| x.abs().max(largest))
}

/// What double precision says of a ray and a triangle.
enum Verdict {
    Miss,
    /// The parameter, and the error that `f32` may make in it.
    Hit(f64, f64),
    /// `f32` may decide either way.
    Unclear,
}

fn moller_trumbore(ray: &Ray, vertices: [Vec3; 3]) -> Verdict {
    let (origin, direction) = (d(ray.origin), d(ray.direction));
    let [p0, p1, p2] = vertices.map(|vertex| sub(d(vertex), origin));
    let (e1, e2) = (sub(p1, p0), sub(p2, p0));
    let p = cross(direction, e2);
    let determinant = dot(e1, p);
    let reach = largest(p0).max(largest(p1)).max(largest(p2));
    let longest = largest(direction);
    let edge_error = 72.0 * ROUNDOFF * reach * reach * longest / determinant.abs();
    let s = sub([0.0; 3], p0);
    let (b1, q) = (dot(s, p) / determinant, cross(s, e1));
    let (b2, t) = (dot(direction, q) / determinant, dot(e2, q) / determinant);
    let t_error = reach / longest * ROUNDOFF * (16.0 + 450.0 * reach * reach * longest / determinant.abs());
    let margin = b1.min(b2).min(1.0 - b1 - b2);
    let (after, before) = (t - f64::from(ray.t_min), f64::from(ray.t_max) - t);
    // Not a number where the triangle is seen edge-on: then it is not clear either.
    let is_clear = margin.abs() > edge_error;
    if !is_clear {
        // Even so it is missed if it lies behind.
        let behind = [p0, p1, p2].iter().all(|&p| dot(p, direction) < 0.0);
        return if behind { Verdict::Miss } else { Verdict::Unclear };
    }
    if margin < 0.0 || after < -t_error || before < -t_error {
        Verdict::Miss
    } else if after <= t_error || before <= t_error {
        Verdict::Unclear
    } else {
        Verdict::Hit(t, t_error)
    }
}

/// The nearest hit with its primitive; `Err` if `f32` may find another.
fn nearest(ray: &Ray, mesh: &TriangleMesh) -> Result<Option<(u32, f64, f64)>, ()> {
    let mut hits = Vec::new();
    for (primitive, face) in (0..).zip(mesh.indices.iter()) {
        match moller_trumbore(ray, face.map(|vertex| mesh.positions[vertex as usize])) {
            Verdict::Miss => {}
            Verdict::Hit(t, error) => hits.push((primitive, t, error)),
            Verdict::Unclear => return Err(()),
        }
    }
    hits.sort_by(|a, b| a.1.total_cmp(&b.1));
    let Some(&first) = hits.first() else { return Ok(None) };
    let is_apart = hits[1..].iter().all(|other| other.1 - first.1 > first.2 + other.2);
    if is_apart { Ok(Some(first)) } else { Err(()) }
}

/// Compares all queries; returns how many rays could be compared, and how many of these hit.
fn check(mesh: &TriangleMesh, rays: &[Ray]) -> [usize; 2] {
    let mut expected = Vec::new();
    let mut clear = Vec::new();
    for ray in rays {
        if let Ok(hit) = nearest(ray, mesh) {
            clear.push(*ray);
            expected.push(hit);
        }
    }
    for (options, accel) in every_accel(&world_of(vec![Geometry::Triangles(mesh.clone())])) {
        let single: Vec<_> = clear.iter().map(|ray| accel.intersect(ray)).collect();
        for hits in [single, intersect_batch(&accel, &clear), intersect_coherent(&accel, &clear)] {
            for ((ray, expected), hit) in clear.iter().zip(&expected).zip(hits) {
                let found = hit.map(|hit| hit.primitive);
                assert_eq!(found, expected.map(|(primitive, ..)| primitive), "{options:?} {ray:?}");
                if let (Some(hit), Some((_, t, error))) = (hit, expected) {
                    let off = (f64::from(hit.t) - t).abs();
                    assert!(
                        off <= *error,
                        "{options:?} {ray:?}: {} is off by {off:e}, beyond {error:e}",
                        hit.t
                    );
                }
            }
        }
        let occluded = occluded_batch(&accel, &clear);
        for ((ray, expected), occluded) in clear.iter().zip(&expected).zip(occluded) {
            assert_eq!([occluded, accel.occluded(ray)], [expected.is_some(); 2], "{options:?} {ray:?}");
        }
    }
    [clear.len(), expected.iter().flatten().count()]
}

fn random_rays(random: &mut Random, count: usize, half: f32) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let ray = Ray::new(random.point(half), random.direction() * random.range(0.1, 10.0));
            if i % 3 == 0 { Ray { t_min: 0.1 * half, t_max: half, ..ray } } else { ray }
        })
        .collect()
}

#[test]
fn soups_agree_with_double_precision() {
    let mut random = Random(1);
    let mut total = [0, 0];
    for (count, size) in [(30, 0.8), (200, 0.3), (400, 0.2)] {
        let mesh = soup(&mut random, count, size);
        let mut rays = random_rays(&mut random, 2500, 1.5);
        rays.extend(camera_rays(Vec3::new(2.0, 1.0, 3.0), Vec3::ZERO, 3, 4.0));
        let compared = check(&mesh, &rays);
        total = [total[0] + compared[0], total[1] + compared[1]];
    }
    assert!(total[0] > 4000 && total[1] > 1500, "{total:?} compared and hit");
}

#[test]
fn meshes_at_all_scales_agree_with_double_precision() {
    let mut random = Random(2);
    for scale in [1e-9, 1e-3, 1.0, 1e4, 1e9] {
        let mut total = [0, 0];
        for body in [blob(2), grid_cube(5), torus(16, 8)].map(|body| body.scaled(scale)) {
            let mesh = body.triangle_mesh();
            let mut rays = random_rays(&mut random, 300, 1.5 * scale);
            rays.extend(rays_at(&mut random, &mesh, 100, 1.5 * scale));
            let compared = check(&mesh, &rays);
            total = [total[0] + compared[0], total[1] + compared[1]];
        }
        assert!(total[0] > 700 && total[1] > 200, "at {scale}: {total:?} compared and hit");
    }
}
