//! What a filter rejects is as if it were not there: for every query of every tree on every tier.

mod common;

use std::cell::Cell;

use common::agreement::{STALE, TREES, bits, every_accel};
use common::meshes::{blob, torus};
use common::moving::{at_any_time, moving_zoo};
use common::worlds::{nasty_rays, rays, rays_at, soup};
use common::{Random, build, world_of};
use sahl_accel::{Accel, Builder, Geometry, Hit, Sphere, TriangleMesh, World};
use sahl_math::{Ray, Transform, Vec3};

/// Lets about half of all hits through, as an image of holes would: by where they are on their primitive.
fn is_solid(hit: &Hit) -> bool {
    let cell = |x: f32| (x * 4.0) as u32;
    let mixed = [hit.geometry, hit.primitive, hit.instance, cell(hit.u), cell(hit.v)]
        .into_iter()
        .fold(7_u32, |mixed, part| (mixed ^ part).wrapping_mul(0x9e37_79b1).rotate_left(13));
    mixed & 4 == 0
}

/// The nearest hit by asking for one after the other without a filter, and where those are that were passed.
fn step_by_step(oracle: &Accel, filtered: &[u32], ray: &Ray) -> (Option<Hit>, Vec<f32>) {
    let mut passed = Vec::new();
    let mut rest = *ray;
    while let Some(hit) = oracle.intersect(&rest) {
        if !filtered.contains(&hit.geometry) || is_solid(&hit) {
            return (Some(hit), passed);
        }
        passed.push(hit.t);
        rest.t_min = hit.t;
    }
    (None, passed)
}

/// Compares all filtered queries with those of brute force; returns how many hits the filter has moved.
fn check(world: &World, rays: &[Ray]) -> usize {
    let oracle = build(world, Builder::BruteForce);
    let expected: Vec<Option<Hit>> =
        rays.iter().map(|ray| oracle.intersect_filtered(ray, is_solid)).collect();
    let mut moved = 0;
    for (ray, expected) in rays.iter().zip(&expected) {
        let (by_steps, passed) = step_by_step(&oracle, &world.filtered, ray);
        let agree = match (by_steps, expected) {
            (None, None) => true,
            // Where two primitives are equally near, going on from one of them passes the other.
            (None, Some(hit)) => passed.contains(&hit.t),
            // The parameter of what lies on both sides of where a ray begins is found in other ways.
            (Some(later), Some(hit)) => hit.t <= later.t * (1.0 + 1e-5),
            (Some(_), None) => false,
        };
        assert!(agree, "{ray:?}: {by_steps:?}, {expected:?}");
        moved += usize::from(bits(*expected) != bits(oracle.intersect(ray)));
    }
    check_one(&oracle, rays, &expected, "oracle");
    for (options, accel) in every_accel(world) {
        check_one(&accel, rays, &expected, &format!("{options:?}"));
    }
    moved
}

fn check_one(accel: &Accel, rays: &[Ray], expected: &[Option<Hit>], context: &str) {
    let mut batch = vec![STALE; rays.len()];
    accel.intersect_batch_filtered(rays, &mut batch, |_, hit| is_solid(hit));
    let mut occluded: Vec<bool> = (0..rays.len()).map(|i| i % 2 == 0).collect();
    accel.occluded_batch_filtered(rays, &mut occluded, |_, hit| is_solid(hit));
    for (i, ray) in rays.iter().enumerate() {
        let wanted = bits(expected[i]);
        assert_eq!(bits(accel.intersect_filtered(ray, is_solid)), wanted, "{context}: {ray:?}");
        assert_eq!(bits(batch[i]), wanted, "{context}, batch: {ray:?}");
        assert_eq!(accel.occluded_filtered(ray, is_solid), wanted.is_some(), "{context}, occluded: {ray:?}");
        assert_eq!(occluded[i], wanted.is_some(), "{context}, occluded batch: {ray:?}");
    }
}

#[test]
fn all_shapes_with_holes() {
    for seed in 0..2 {
        let mut random = Random(300 + seed);
        let mut world = moving_zoo(&mut random);
        world.filtered = (0..world.geometries.len() as u32).collect();
        let mut all = rays(&mut random, 600, 1.5);
        all.extend(nasty_rays(&mut random, 200, 1.5));
        let all = at_any_time(&mut random, all);
        let moved = check(&world, &all);
        assert!(moved > 100, "{moved} moved");
        // Some of them, one twice, and one that is not there.
        let last = world.geometries.len() as u32 - 1;
        world.filtered = vec![3, last, 3, last - 3, 900];
        assert!(check(&world, &all) > 10);
    }
}

#[test]
fn meshes_with_holes_by_rays_at_vertices_and_edges() {
    let mut random = Random(310);
    let mesh = torus(12, 8).triangle_mesh();
    let rays = rays_at(&mut random, &mesh, 800, 2.0);
    let geometries = vec![Geometry::Triangles(mesh), Geometry::Triangles(blob(2).triangle_mesh())];
    let world = World { filtered: vec![0], ..world_of(geometries) };
    assert!(check(&world, &rays) > 100);
    // Against triangles that are each alone in the world: no other can be in the way of one, or hide it by being equally near.
    let Geometry::Triangles(mesh) = &world.geometries[0] else { panic!("the torus comes first") };
    let alone = |indices: &[u32; 3]| {
        let mesh = TriangleMesh { indices: [*indices].into(), positions: mesh.positions.clone() };
        build(&world_of(vec![Geometry::Triangles(mesh)]), Builder::BruteForce)
    };
    let triangles: Vec<Accel> = mesh.indices.iter().map(alone).collect();
    let opaque = build(&world_of(vec![world.geometries[1].clone()]), Builder::BruteForce);
    let oracle = build(&world, Builder::BruteForce);
    for ray in &rays {
        let solid = (0..).zip(&triangles).filter_map(|(primitive, accel)| {
            accel.intersect(ray).map(|hit| Hit { primitive, ..hit }).filter(is_solid)
        });
        let opaque = opaque.intersect(ray).map(|hit| Hit { geometry: 1, ..hit });
        let nearest = solid.chain(opaque).min_by(|a, b| {
            a.t.total_cmp(&b.t).then((a.geometry, a.primitive).cmp(&(b.geometry, b.primitive)))
        });
        assert_eq!(bits(oracle.intersect_filtered(ray, is_solid)), bits(nearest), "{ray:?}");
    }
}

#[test]
fn coincident_triangles_are_asked_one_by_one() {
    // The lowest primitive that is let through is found, whichever are rejected before it.
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = TriangleMesh { indices: vec![[0, 1, 2]; 50].into(), positions: positions.into() };
    let world = World { filtered: vec![0], ..world_of(vec![Geometry::Triangles(mesh)]) };
    let ray = Ray::new(Vec3::new(0.2, 0.3, 1.0), -Vec3::Z);
    for (options, accel) in every_accel(&world) {
        let hit = accel.intersect_filtered(&ray, |hit| hit.primitive >= 17);
        assert_eq!(hit.map(|hit| hit.primitive), Some(17), "{options:?}");
        assert!(accel.occluded_filtered(&ray, |hit| hit.primitive == 49), "{options:?}");
        assert!(!accel.occluded_filtered(&ray, |_| false), "{options:?}");
    }
}

#[test]
fn the_far_side_shows_through_a_hole_in_the_near_one() {
    let sphere =
        Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0, phi_max: 7.0, to_parent: Transform::IDENTITY };
    let world = World { filtered: vec![0], ..world_of(vec![Geometry::Sphere(sphere)]) };
    let ray = Ray::new(Vec3::new(0.0, 0.3, 4.0), -Vec3::Z);
    for (options, accel) in every_accel(&world) {
        let near = accel.intersect(&ray).unwrap();
        let far = accel.intersect_filtered(&ray, |hit| hit.t > near.t).unwrap();
        assert!(far.t > 4.0 && far.v < 0.5 && near.v > 0.5, "{options:?}: {near:?} {far:?}");
        let point = accel.surface_point(&ray, &far);
        assert!((point.p - ray.at(far.t)).length() < 1e-6 && point.p.z < 0.0, "{options:?}: {point:?}");
    }
}

#[test]
fn only_what_is_marked_is_asked_about() {
    let mut random = Random(320);
    let soups = (0..3).map(|_| Geometry::Triangles(soup(&mut random, 100, 0.4))).collect();
    let mut world = world_of(soups);
    let rays = rays(&mut random, 300, 1.5);
    for filtered in [vec![], vec![1], vec![0, 2]] {
        world.filtered.clone_from(&filtered);
        for builder in TREES {
            let accel = build(&world, builder);
            let asked = Cell::new(0);
            let filter = |hit: &Hit| {
                assert!(filtered.contains(&hit.geometry), "{hit:?}");
                asked.set(asked.get() + 1);
                true
            };
            for ray in &rays {
                assert_eq!(bits(accel.intersect_filtered(ray, filter)), bits(accel.intersect(ray)));
                assert_eq!(accel.occluded_filtered(ray, filter), accel.occluded(ray));
            }
            assert_eq!(asked.get() > 0, !filtered.is_empty());
        }
    }
}

#[test]
fn batches_tell_the_place_of_the_ray() {
    let mut random = Random(330);
    let world =
        World { filtered: vec![0], ..world_of(vec![Geometry::Triangles(soup(&mut random, 200, 0.5))]) };
    let rays = rays(&mut random, 200, 1.5);
    for (options, accel) in every_accel(&world) {
        // Every third ray sees nothing of it.
        let mut hits = vec![None; rays.len()];
        accel.intersect_batch_filtered(&rays, &mut hits, |place, _| place % 3 != 0);
        let mut occluded = vec![true; rays.len()];
        accel.occluded_batch_filtered(&rays, &mut occluded, |place, _| place % 3 != 0);
        for (place, ray) in rays.iter().enumerate() {
            let expected = accel.intersect(ray).filter(|_| place % 3 != 0);
            assert_eq!(bits(hits[place]), bits(expected), "{options:?}: {place}");
            assert_eq!(occluded[place], expected.is_some(), "{options:?}: {place}");
        }
    }
}
