//! Queries for many rays give what the queries for one give, whatever the rays and however many.

mod common;

use common::agreement::{STALE, bits, every_accel, intersect_batch, intersect_coherent, occluded_batch};
use common::meshes::{blob, grid_cube};
use common::worlds::{camera_rays, nasty_rays, rays, rays_at, zoo};
use common::{Random, world_of};
use sahl_accel::{Accel, BuildOptions, Geometry, Hit, World};
use sahl_math::{Ray, Vec3};

/// Rays that hit something, in an order without any coherence: of all kinds.
fn mixed(random: &mut Random, world: &World, count: usize) -> Vec<Ray> {
    let mut all = rays(random, count, 1.5);
    all.extend(nasty_rays(random, count / 2, 1.5));
    if let Some(Geometry::Triangles(mesh)) = world.geometries.first() {
        all.extend(rays_at(random, mesh, count, 1.5));
    }
    for i in (1..all.len()).rev() {
        all.swap(i, random.below(i + 1));
    }
    all
}

fn shells() -> World {
    let inner = Geometry::Triangles(blob(2).triangle_mesh());
    let outer = Geometry::Triangles(grid_cube(3).scaled(1.3).triangle_mesh());
    world_of(vec![inner, outer])
}

/// Compares the three queries for many on one slice with those for one.
fn check(context: &str, accel: &Accel, rays: &[Ray], expected: &[Option<[u32; 6]>]) {
    let found: Vec<_> = intersect_batch(accel, rays).into_iter().map(bits).collect();
    assert_eq!(found, expected, "{context}: batch of {}", rays.len());
    let found: Vec<_> = intersect_coherent(accel, rays).into_iter().map(bits).collect();
    assert_eq!(found, expected, "{context}: coherent, {}", rays.len());
    let found = occluded_batch(accel, rays);
    let expected: Vec<bool> = expected.iter().map(Option::is_some).collect();
    assert_eq!(found, expected, "{context}: occluded batch of {}", rays.len());
}

fn alone(accel: &Accel, rays: &[Ray]) -> Vec<Option<[u32; 6]>> {
    rays.iter().map(|ray| bits(accel.intersect(ray))).collect()
}

#[test]
fn batches_of_every_length() {
    let mut random = Random(1);
    for world in [shells(), zoo(&mut random)] {
        let mut rays = mixed(&mut random, &world, 400);
        rays.extend(camera_rays(Vec3::new(2.0, 1.5, 3.0), Vec3::ZERO, 4, 3.0));
        for (options, accel) in every_accel(&world) {
            let (expected, context) = (alone(&accel, &rays), format!("{options:?}"));
            let mut start = 0;
            for length in 0..=200 {
                start = (start + 37) % (rays.len() - 200);
                let range = start..start + length;
                check(&context, &accel, &rays[range.clone()], &expected[range]);
            }
            check(&context, &accel, &rays, &expected);
        }
    }
}

/// Packets of 64 whose rays belong together less and less.
fn packets(random: &mut Random) -> Vec<(&'static str, Vec<Ray>)> {
    let camera = |origin: Vec3| camera_rays(origin, Vec3::new(0.1, -0.2, 0.0), 1, 1.5);
    let base = camera(Vec3::new(2.0, 1.5, 3.0));
    let every = |f: &mut dyn FnMut(usize, Ray) -> Ray| -> Vec<Ray> {
        base.iter().enumerate().map(|(i, &ray)| f(i, ray)).collect()
    };
    vec![
        ("one octant", base.clone()),
        ("four octants", camera_rays(Vec3::new(0.1, -0.2, 4.0), Vec3::new(0.1, -0.2, 0.0), 1, 2.0)),
        ("from within, all octants", every(&mut |_, ray| Ray::new(ray.at(1.0) * 0.1, random.direction()))),
        (
            "both ways",
            every(&mut |i, ray| if i % 2 == 0 { ray } else { Ray::new(-ray.origin, ray.direction) }),
        ),
        (
            "backwards",
            every(&mut |i, ray| if i % 3 == 0 { ray } else { Ray::new(ray.at(2.0), -ray.direction) }),
        ),
        (
            "parallel to an axis",
            every(&mut |i, ray| Ray::new(ray.origin, [Vec3::X, -Vec3::Z, -Vec3::Y][i % 3])),
        ),
        ("in a plane", every(&mut |_, ray| Ray { direction: Vec3 { y: 0.0, ..ray.direction }, ..ray })),
        (
            "one along an axis",
            every(&mut |i, ray| if i == 13 { Ray::new(ray.origin, -Vec3::Z) } else { ray }),
        ),
        ("some none", every(&mut |i, ray| if i % 5 == 0 { ray.with_t_max(-1.0) } else { ray })),
        ("only one", every(&mut |i, ray| if i == 40 { ray } else { Ray::new(ray.origin, Vec3::ZERO) })),
        ("short", every(&mut |i, ray| ray.with_t_max(i as f32 * 0.02))),
        ("late", every(&mut |i, ray| Ray { t_min: i as f32 * 0.02, ..ray })),
        (
            "one far away",
            every(&mut |i, ray| if i == 3 { Ray::new(ray.origin * 1e6, ray.direction) } else { ray }),
        ),
        ("all the same", every(&mut |_, _| base[20])),
        (
            "not finite",
            every(&mut |i, ray| {
                if i % 7 == 0 { Ray::new(ray.origin * f32::NAN, ray.direction) } else { ray }
            }),
        ),
        (
            "nearly flat",
            every(&mut |i, ray| Ray { direction: Vec3 { y: 1e-39 * i as f32, ..ray.direction }, ..ray }),
        ),
        (
            "of all lengths",
            every(&mut |i, ray| Ray { direction: ray.direction * 10.0_f32.powi(i as i32 % 20 - 10), ..ray }),
        ),
        ("at vertices", rays_at(random, &blob(2).triangle_mesh(), 64, 1.5)),
    ]
}

#[test]
fn packets_of_rays_that_do_not_belong_together() {
    let mut random = Random(2);
    for world in [shells(), zoo(&mut random)] {
        for (options, accel) in every_accel(&world) {
            // One after the other, so that what is left of a packet meets the next; and each also cut short.
            let mut all = Vec::new();
            for (name, rays) in packets(&mut Random(3)) {
                let expected = alone(&accel, &rays);
                check(&format!("{name}, {options:?}"), &accel, &rays, &expected);
                check(&format!("{name}, cut, {options:?}"), &accel, &rays[..41], &expected[..41]);
                all.extend(rays);
            }
            check(&format!("all, {options:?}"), &accel, &all, &alone(&accel, &all));
        }
    }
}

/// A query for the nearest hits of many rays.
type NearestQuery = fn(&Accel, &[Ray], &mut [Option<Hit>]);

#[test]
fn slices_of_different_lengths() {
    let world = shells();
    let rays = rays(&mut Random(4), 100, 0.5);
    let accel = Accel::build(world, &BuildOptions::default());
    let expected = alone(&accel, &rays);
    for (some, places) in [(0, 100), (100, 0), (30, 100), (100, 30), (65, 66), (1, 64)] {
        let common = some.min(places);
        for query in [Accel::intersect_batch as NearestQuery, Accel::intersect_coherent] {
            let mut hits = vec![STALE; places];
            query(&accel, &rays[..some], &mut hits);
            assert!(hits[..common].iter().map(|&hit| bits(hit)).eq(expected[..common].iter().copied()));
            assert!(hits[common..].iter().all(|&hit| hit == STALE), "the excess is left alone");
        }
        let mut occluded = vec![true; places];
        accel.occluded_batch(&rays[..some], &mut occluded);
        assert!(occluded[..common].iter().copied().eq(expected[..common].iter().map(Option::is_some)));
        assert!(occluded[common..].iter().all(|&is| is), "the excess is left alone");
    }
}
