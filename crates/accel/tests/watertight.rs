//! No ray slips between primitives that share an edge, and none hits the surface it starts from: on every tier, by every query.

mod common;

use common::agreement::{TREES, bits, every_accel, intersect_batch, intersect_coherent, tiers};
use common::meshes::{Body, blob, grid_cube, torus};
use common::watertight::{Aim, Queries, Tally, Volley, is_own_origin, shoot};
use common::{Random, world_of};
use sahl_accel::{Accel, BuildOptions, Builder, Geometry, Hit, Instance, PatchMesh, World};
use sahl_math::{Ray, Transform, Vec3};

const SCALES: [f32; 3] = [1e-3, 1.0, 1e4];

/// Shoots a share of `count` rays for each tier and kind of query.
fn check(what: &str, world: &World, (builder, body): (Builder, &Body), aim: Aim, count: u64) {
    for (number, tier) in tiers().enumerate() {
        let accel = Accel::build(
            world.clone(),
            &BuildOptions { builder, tier: Some(tier), ..BuildOptions::default() },
        );
        for queries in Queries::ALL {
            let volley = Volley { aim, queries, time: 0.0, count: count / (3 * tiers().count() as u64) };
            let tally = shoot(&accel, body, &volley, &mut Random(7 + number as u64));
            let expected = Tally { rays: tally.rays, ..Tally::default() };
            assert_eq!(tally, expected, "{what}: {}, {builder:?}, {tier:?}, {volley:?}", body.name);
            assert!(2 * tally.rays > volley.count, "{what}: only {} rays", tally.rays);
        }
    }
}

fn check_aims(what: &str, world: &World, (builder, body): (Builder, &Body), count: u64) {
    check(what, world, (builder, body), Aim::Targets, count);
    if body.name == "grid cube" {
        check(what, world, (builder, body), Aim::AxisParallel, count);
        check(what, world, (builder, body), Aim::GridLines, count);
    }
}

#[test]
fn triangles_are_watertight_at_all_scales() {
    for scale in SCALES {
        for body in [blob(4), grid_cube(16), torus(48, 24)].map(|body| body.scaled(scale)) {
            let world = world_of(vec![Geometry::Triangles(body.triangle_mesh())]);
            for builder in TREES {
                check_aims(&format!("triangles at {scale}"), &world, (builder, &body), 24_000);
            }
        }
    }
}

#[test]
fn triangles_far_from_the_origin_are_watertight() {
    for distance in [1e3, 1e4, 1e5] {
        // Coarser, so that rounding of the vertices leaves the bodies as they are.
        for body in [blob(1), grid_cube(8), torus(12, 6)] {
            let body = body.moved(Vec3::new(1.0, -0.75, 0.5) * distance);
            let world = world_of(vec![Geometry::Triangles(body.triangle_mesh())]);
            check_aims(&format!("triangles at {distance}"), &world, (Builder::BinnedSah, &body), 24_000);
        }
    }
}

#[test]
fn patches_are_watertight_at_all_scales() {
    for scale in SCALES {
        for (body, kind) in [(grid_cube(16), "flat"), (torus(48, 24), "curved")] {
            let body = body.scaled(scale);
            let world = world_of(vec![Geometry::Patches(body.patch_mesh())]);
            check_aims(&format!("{kind} patches at {scale}"), &world, (Builder::BinnedSah, &body), 12_000);
        }
    }
}

#[test]
fn triangles_and_patches_that_share_edges_are_watertight() {
    for scale in SCALES {
        for (body, kind) in [(grid_cube(16), "flat"), (torus(48, 24), "curved")] {
            let mut body = body.scaled(scale);
            // Every other quadrilateral as a patch, the rest as triangles.
            let every_quad = body.quads.clone();
            body.triangles = body.triangles.chunks(2).skip(1).step_by(2).flatten().copied().collect();
            body.quads = every_quad.iter().step_by(2).copied().collect();
            let shapes =
                vec![Geometry::Triangles(body.triangle_mesh()), Geometry::Patches(body.patch_mesh())];
            body.quads = every_quad;
            let what = format!("{kind} mixture at {scale}");
            check(&what, &world_of(shapes), (Builder::BinnedSah, &body), Aim::Targets, 12_000);
        }
    }
}

#[test]
fn instances_are_watertight() {
    let moved = Transform::translate(3.0, -700.0, 20.0).unwrap();
    let turned = Transform::rotate(0.8, [1.0, 2.0, 3.0]).unwrap();
    let scaled = Transform::scale(2.5, -0.7, 1.3).unwrap();
    let to_world = moved.after(&turned.after(&scaled).unwrap()).unwrap();
    for mut body in [blob(4), grid_cube(16), torus(48, 24)] {
        let world = World {
            geometries: vec![Geometry::Triangles(body.triangle_mesh())],
            groups: vec![vec![0]],
            instances: vec![Instance { group: 0, to_world: to_world.into() }],
            ..World::default()
        };
        for p in body.positions.iter_mut().chain(&mut body.inside) {
            *p = to_world.point(*p);
        }
        check("instance", &world, (Builder::BinnedSah, &body), Aim::Targets, 24_000);
    }
}

#[test]
fn a_grazing_ray_meets_a_curved_patch_twice_close_together() {
    // Spawned from the torus of the example; it crosses the patch it leaves once more after a ten-thousandth of its way there.
    let positions = [
        [-0.9519322, 1.2769775, 0.0034220517],
        [-1.0032057, 1.2366848, 0.001447022],
        [-0.9933535, 1.3087612, 0.0],
        [-1.0467017, 1.2657478, 0.0004197061],
    ]
    .map(Vec3::from);
    let mesh = PatchMesh { indices: [[0, 1, 2, 3]].into(), positions: positions.into() };
    let source =
        Hit { t: 1.0, u: 1.0, v: 0.499_998_36, geometry: 0, primitive: 0, instance: Hit::NO_INSTANCE };
    let ray = Ray::new(
        Vec3::new(-1.0249536, 1.2512163, 0.000_933_361_8),
        Vec3::new(-0.115_688_79, 0.993_251_14, -0.0082624),
    );
    // From the other side of the surface it crosses at once, and does not stay away from it.
    let wrong = Ray { origin: Vec3 { z: 0.000_933_366_2, ..ray.origin }, ..ray };
    for (options, accel) in every_accel(&world_of(vec![Geometry::Patches(mesh)])) {
        let hit = accel.intersect(&ray);
        for found in [intersect_batch(&accel, &[ray]), intersect_coherent(&accel, &[ray])] {
            assert_eq!(bits(found[0]), bits(hit), "{options:?}");
        }
        let second = hit.expect("the second crossing");
        assert!((second.t - 1.567_352_9e-4).abs() < 1e-8, "{options:?}: {second:?}");
        assert!(!is_own_origin(&accel, &ray, &source, &second), "{options:?}");
        let first = accel.intersect(&wrong).expect("the crossing next to the origin");
        assert!(is_own_origin(&accel, &wrong, &source, &first), "{options:?}: {first:?}");
    }
}
