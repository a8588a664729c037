//! What moves is met where it is at the ray's time: by every query of every tree on every tier.

mod common;

use common::agreement::{TREES, bits, check_queries, compare, every_accel, tiers};
use common::meshes::{Body, blob, grid_cube, torus};
use common::moving::{at_any_time, frozen, motion, moving, moving_zoo};
use common::watertight::{Aim, Queries, Tally, Volley, shoot};
use common::worlds::{camera_rays, loose_triangles, nasty_rays, rays, rays_at, soup};
use common::{Random, build, world_of};
use sahl_accel::{
    Accel, BuildOptions, Builder, Geometry, Hit, Instance, MovingTriangleMesh, Placement, World,
};
use sahl_math::{AnimatedTransform, Ray, Transform, Vec3};

#[test]
fn moving_shapes_of_all_kinds_by_every_query() {
    for seed in 0..3 {
        let mut random = Random(200 + seed);
        let world = moving_zoo(&mut random);
        let mut rays = rays(&mut random, 800, 1.5);
        rays.extend(nasty_rays(&mut random, 300, 1.5));
        rays.extend(camera_rays(Vec3::new(2.0, 1.0, 3.0), Vec3::ZERO, 2, 3.0));
        let hits = compare(&world, &at_any_time(&mut random, rays));
        assert!(hits > 300, "{hits} hits");
    }
}

#[test]
fn moving_meshes_by_rays_at_vertices_and_edges() {
    let mut random = Random(210);
    for body in [blob(2), grid_cube(4), torus(12, 8)] {
        let still = body.triangle_mesh();
        let turned = Transform::rotate(1.9, [0.3, 1.0, -0.4]).unwrap();
        let mesh = moving(&still, |p| turned.point(p) + Vec3::new(0.5, -0.2, 0.1));
        let mut all = Vec::new();
        for time in [0.0, 0.3, 0.71, 1.0] {
            let aimed = rays_at(&mut random, &frozen(&mesh, time), 300, 2.0);
            all.extend(aimed.into_iter().map(|ray| ray.with_time(time)));
        }
        let hits = compare(&world_of(vec![Geometry::MovingTriangles(mesh)]), &all);
        assert!(hits > 800, "{}: {hits} hits", body.name);
    }
}

/// The world as it stands at a time.
fn frozen_world(world: &World, time: f32) -> World {
    let freeze = |geometry: &Geometry| match geometry {
        Geometry::MovingTriangles(mesh) => Geometry::Triangles(frozen(mesh, time)),
        other => other.clone(),
    };
    let still = |instance: &Instance| Instance {
        group: instance.group,
        to_world: instance.to_world.at(time).into_owned().into(),
    };
    World {
        geometries: world.geometries.iter().map(freeze).collect(),
        instances: world.instances.iter().map(still).collect(),
        ..world.clone()
    }
}

#[test]
fn at_any_time_the_world_is_what_stands_there_then() {
    let mut random = Random(220);
    let world = moving_zoo(&mut random);
    let moving = build(&world, Builder::BinnedSah);
    for time in [0.0, 0.125, 0.3, 0.77, 1.0] {
        let still = build(&frozen_world(&world, time), Builder::BruteForce);
        let mut all = rays(&mut random, 500, 1.5);
        all.extend(nasty_rays(&mut random, 100, 1.5));
        let mut hits = 0;
        for ray in &all {
            let expected = still.intersect(ray);
            let ray = ray.with_time(time);
            assert_eq!(bits(moving.intersect(&ray)), bits(expected), "{ray:?}");
            if let Some(hit) = expected {
                assert_eq!(moving.surface_point(&ray, &hit), still.surface_point(&ray, &hit), "{ray:?}");
                hits += 1;
            }
        }
        assert!(hits > 100, "{hits} hits");
    }
}

#[test]
fn what_does_not_move_is_as_if_it_stood_still() {
    let mut random = Random(230);
    let mesh = soup(&mut random, 300, 0.3);
    let at_rest = Transform::rotate(0.5, [1.0, 0.2, 0.0]).unwrap();
    let rest = AnimatedTransform::new(at_rest, at_rest, [0.0, 1.0]).unwrap();
    let world = |geometry: Geometry, to_world: Placement| World {
        groups: vec![vec![0]],
        instances: vec![Instance { group: 0, to_world }],
        ..world_of(vec![geometry])
    };
    let still = build(&world(Geometry::Triangles(mesh.clone()), at_rest.into()), Builder::BinnedSah);
    let same = Geometry::MovingTriangles(moving(&mesh, |p| p));
    let rays = rays(&mut random, 600, 1.5);
    let rays = at_any_time(&mut random, rays);
    let expected: Vec<Option<Hit>> = rays.iter().map(|ray| still.intersect(&ray.with_time(0.0))).collect();
    let mut checked = 0;
    for (options, accel) in every_accel(&world(same, rest.into())) {
        for (ray, expected) in rays.iter().zip(&expected) {
            // Elsewhere on the way the weights may not sum to one, and the middle of the turn is rounded.
            if ray.time == 0.0 || ray.time == 1.0 {
                assert_eq!(bits(accel.intersect(ray)), bits(*expected), "{options:?} {ray:?}");
                checked += 1;
            }
        }
    }
    assert!(checked > 100, "{checked} checked");
}

#[test]
fn moving_meshes_are_watertight_at_any_time() {
    let turned = Transform::rotate(1.3, [1.0, 2.0, 3.0]).unwrap();
    let deformed = turned.after(&Transform::scale(1.5, 0.7, 1.1).unwrap()).unwrap();
    for scale in [1e-3, 1.0, 1e4] {
        let [x, y, z] = [0.4, -2.0, 1.0].map(|x| x * f64::from(scale));
        let map = Transform::translate(x, y, z).unwrap().after(&deformed).unwrap();
        for body in [blob(4), grid_cube(16), torus(48, 24)].map(|body| body.scaled(scale)) {
            let mesh = moving(&body.triangle_mesh(), |p| map.point(p));
            let world = world_of(vec![Geometry::MovingTriangles(mesh.clone())]);
            for time in [0.0, 0.2, 0.5, 0.83, 1.0] {
                // A mixture of a map with the identity maps what is inside to what is inside.
                let at_time = body_at(&body, &mesh, &map, time);
                for builder in [Builder::BinnedSah, Builder::Fast] {
                    check_watertight(&world, builder, &at_time, time);
                }
            }
        }
    }
}

/// The body where the motion has brought it.
fn body_at(body: &Body, mesh: &MovingTriangleMesh, map: &Transform, time: f32) -> Body {
    let mut body = body.clone();
    for (triangle, indices) in (0..).zip(mesh.indices.iter()) {
        for (&index, vertex) in indices.iter().zip(mesh.triangle_at(triangle, time).expect("a triangle")) {
            body.positions[index as usize] = vertex;
        }
    }
    let mix = |p: Vec3| p * (1.0 - time) + map.point(p) * time;
    body.inside.iter_mut().for_each(|p| *p = mix(*p));
    body.center = mix(body.center);
    body
}

fn check_watertight(world: &World, builder: Builder, body: &Body, time: f32) {
    for (number, tier) in tiers().enumerate() {
        let options = BuildOptions { builder, tier: Some(tier), ..BuildOptions::default() };
        let accel = Accel::build(world.clone(), &options);
        for queries in Queries::ALL {
            let count = 6000 / (3 * tiers().count() as u64);
            let volley = Volley { aim: Aim::Targets, queries, time, count };
            let tally = shoot(&accel, body, &volley, &mut Random(7 + number as u64));
            let expected = Tally { rays: tally.rays, ..Tally::default() };
            assert_eq!(tally, expected, "{}, {builder:?}, {tier:?}, {volley:?}", body.name);
        }
    }
}

#[test]
fn moving_instances_are_watertight() {
    let mut random = Random(240);
    for body in [blob(4), grid_cube(16), torus(48, 24)] {
        let motion = motion(&mut random);
        let world = World {
            geometries: vec![Geometry::Triangles(body.triangle_mesh())],
            groups: vec![vec![0]],
            instances: vec![Instance { group: 0, to_world: motion.clone().into() }],
            ..World::default()
        };
        for time in [0.0, 0.3, 0.9] {
            let map = motion.at(time);
            let mut body = body.clone();
            for p in body.positions.iter_mut().chain(&mut body.inside) {
                *p = map.point(*p);
            }
            check_watertight(&world, Builder::BinnedSah, &body, time);
        }
    }
}

#[test]
fn triangles_that_are_bad_at_one_end_are_dropped_and_others_are_not() {
    let start = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(f32::NAN)];
    let mut end = start;
    // The first triangle turns over on the way; the last is a line until it moves.
    (end[1], end[2]) = (Vec3::Y, Vec3::X);
    end[3] = Vec3::splat(1e30);
    let start_positions: Vec<Vec3> = start.iter().copied().chain([Vec3::X * 2.0]).collect();
    let end_positions: Vec<Vec3> = end.iter().copied().chain([Vec3::X * 3.0]).collect();
    let indices = vec![[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 1], [0, 1, 9], [0, 1, 5]];
    let mesh = MovingTriangleMesh {
        indices: indices.into(),
        positions: [start_positions.into(), end_positions.into()],
    };
    assert_eq!(mesh.triangle_at(4, 0.5), None);
    let world = world_of(vec![Geometry::MovingTriangles(mesh)]);
    for builder in TREES.into_iter().chain([Builder::BruteForce]) {
        let stats = build(&world, builder).stats();
        assert_eq!((stats.primitives, stats.dropped), (2, 4), "{builder:?}");
    }
    let mut random = Random(250);
    let all = rays(&mut random, 600, 1.0);
    assert!(compare(&world, &at_any_time(&mut random, all)) > 20);
    let short =
        MovingTriangleMesh { indices: [[0, 1, 2]].into(), positions: [start.into(), [Vec3::ZERO].into()] };
    assert_eq!(
        build(&world_of(vec![Geometry::MovingTriangles(short)]), Builder::BinnedSah).stats().dropped,
        1
    );
}

#[test]
fn far_and_fast_motions_stay_in_their_boxes() {
    let mut random = Random(260);
    let mut positions = Vec::new();
    for i in 0..200 {
        let center = random.point(1.0) * 10.0_f32.powi(i % 5 - 2);
        positions.extend((0..3).map(|_| center + random.point(0.2) * center.length()));
    }
    let mesh = loose_triangles(positions);
    let fast = moving(&mesh, |p| Vec3::new(-p.y, p.x, p.z) * 3.0 + Vec3::new(700.0, -300.0, 0.5));
    let whirl = AnimatedTransform::new(
        Transform::IDENTITY,
        Transform::translate(50.0, 0.0, 0.0)
            .unwrap()
            .after(&Transform::rotate(3.0, [0.0, 1.0, 0.1]).unwrap())
            .unwrap()
            .after(&Transform::scale(5.0, 0.1, 2.0).unwrap())
            .unwrap(),
        [0.0, 1.0],
    )
    .unwrap();
    let world = World {
        groups: vec![vec![0]],
        instances: vec![Instance { group: 0, to_world: whirl.into() }],
        ..world_of(vec![Geometry::MovingTriangles(fast.clone())])
    };
    let oracle = build(&world, Builder::BruteForce);
    let mut all = Vec::new();
    for _ in 0..1500 {
        let time = random.unit();
        let triangle = fast.triangle_at(random.below(200) as u32, time).unwrap();
        // Well inside, and from no nearer than the triangle is large.
        let [a, b, c] = triangle;
        let target = a * 0.4 + b * 0.35 + c * 0.25;
        let size = (b - a).length().max((c - a).length());
        let origin = target + random.direction() * (size * random.range(1.0, 10.0));
        all.push(Ray::new(origin, target - origin).with_time(time));
    }
    let hits = all.iter().filter(|ray| oracle.occluded(ray)).count();
    assert!(hits > 700, "{hits} hits");
    for (options, accel) in every_accel(&world) {
        let expected: Vec<Option<Hit>> = all.iter().map(|ray| accel.intersect(ray)).collect();
        for (ray, hit) in all.iter().zip(&expected) {
            assert_eq!(hit.is_some(), oracle.occluded(ray), "{options:?} {ray:?}");
        }
        check_queries(&format!("{options:?}"), &accel, &all, &expected);
    }
}
