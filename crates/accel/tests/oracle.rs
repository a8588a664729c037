//! Every query of every builder on every tier against the brute-force list, on worlds made to be awkward.

mod common;

use std::f32::consts::TAU;

use common::agreement::{check_queries, compare, every_accel};
use common::meshes::{blob, grid_cube, torus};
use common::worlds::{camera_rays, loose_triangles, nasty_rays, rays, rays_at, soup, zoo};
use common::{Random, build, world_of};
use proptest::prelude::*;
use sahl_accel::{
    Accel, BuildOptions, Builder, Cylinder, Disk, Geometry, Instance, PatchMesh, Sphere, TriangleMesh, World,
};
use sahl_math::{Ray, Transform, Vec3};

#[test]
fn triangle_soups_of_every_small_size() {
    let mut random = Random(1);
    for count in (0..40).chain([63, 64, 65, 257, 1000]) {
        let world = world_of(vec![Geometry::Triangles(soup(&mut random, count, 0.5))]);
        let hits = compare(&world, &rays(&mut random, 200, 1.5));
        assert!(count < 63 || hits > 5, "{count} triangles, {hits} hits");
    }
}

#[test]
fn uneven_sizes_and_needles() {
    let mut random = Random(2);
    let mut positions = Vec::new();
    for i in 0..600 {
        let size = 10.0_f32.powi(-(i % 7));
        let center = random.point(1.0);
        let stretched = Vec3::new(1.0, 1e-3, 1e-6);
        positions.extend(
            (0..3).map(|_| center + random.point(size) * if i % 3 == 0 { stretched } else { Vec3::ONE }),
        );
    }
    let mesh = loose_triangles(positions);
    let mut rays = rays(&mut random, 2000, 1.5);
    rays.extend(rays_at(&mut random, &mesh, 1000, 1.5));
    assert!(compare(&world_of(vec![Geometry::Triangles(mesh)]), &rays) > 1000);
}

#[test]
fn meshes_by_rays_at_vertices_and_edges() {
    let mut random = Random(3);
    for body in [blob(2), grid_cube(4), torus(12, 8)] {
        let mesh = body.triangle_mesh();
        let mut rays = rays_at(&mut random, &mesh, 1200, 2.0);
        rays.extend(nasty_rays(&mut random, 800, 2.0));
        let hits = compare(&world_of(vec![Geometry::Triangles(mesh)]), &rays);
        assert!(hits > 1000, "{}: {hits} hits", body.name);
        if !body.quads.is_empty() {
            let patches = world_of(vec![Geometry::Patches(body.patch_mesh())]);
            assert!(compare(&patches, &rays) > 1000);
        }
    }
}

#[test]
fn the_largest_and_the_smallest_scales() {
    let mut random = Random(4);
    for scale in [1e-9, 1e6, 1e12] {
        for body in [blob(1), grid_cube(2)].map(|body| body.scaled(scale)) {
            let mesh = body.triangle_mesh();
            let rays = rays_at(&mut random, &mesh, 600, 2.0 * scale);
            let hits = compare(&world_of(vec![Geometry::Triangles(mesh)]), &rays);
            assert!(hits > 200, "{} at {scale}: {hits} hits", body.name);
        }
    }
}

#[test]
fn directions_whose_reciprocals_leave_the_range() {
    let mut random = Random(5);
    let world = world_of(vec![Geometry::Triangles(soup(&mut random, 200, 0.4))]);
    // Origins so near zero that the ray leaves them along an axis by less than the smallest normal number.
    let rays: Vec<Ray> = (0..2000)
        .map(|i| {
            let mut ray = Ray::new(random.point(1.0), random.direction());
            let axis = i % 3;
            ray.direction[axis] = random.range(-1e-38, 1e-38);
            if i % 2 == 0 {
                ray.origin[axis] = random.range(-1e-38, 1e-38);
            }
            ray
        })
        .collect();
    assert!(compare(&world, &rays) > 500);
}

#[test]
fn camera_rays_of_every_query() {
    let mut random = Random(7);
    let world = zoo(&mut random);
    let mut mesh = world_of(vec![Geometry::Triangles(blob(3).triangle_mesh())]);
    mesh.geometries.push(Geometry::Triangles(grid_cube(8).scaled(1.5).triangle_mesh()));
    mesh.world.push(1);
    for (world, width) in [(world, 3.0), (mesh, 5.0)] {
        for origin in [Vec3::new(3.0, 2.0, 4.0), Vec3::new(0.1, 0.1, -5.0), Vec3::new(0.01, 0.02, 0.03)] {
            let rays = camera_rays(origin, Vec3::new(0.1, 0.0, 0.2), 2, width);
            assert!(compare(&world, &rays) > 80);
        }
    }
}

#[test]
fn bad_primitives_are_dropped_and_counted() {
    let nan = Vec3::splat(f32::NAN);
    let infinite = Vec3::splat(f32::INFINITY);
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, nan, infinite, Vec3::Z];
    let indices = vec![[0, 1, 2], [0, 1, 3], [0, 4, 2], [0, 1, 1], [0, 1, 9], [u32::MAX, 0, 1], [0, 5, 1]];
    let mesh = TriangleMesh { indices: indices.into(), positions: positions.as_slice().into() };
    let patches = PatchMesh {
        indices: vec![[0, 1, 2, 5], [0, 1, 2, 3], [0, 0, 0, 0], [0, 1, 2, 77], [0, 1, 0, 1]].into(),
        positions: positions.into(),
    };
    let sphere = |radius, z_min, z_max, phi_max| {
        Geometry::Sphere(Sphere { radius, z_min, z_max, phi_max, to_parent: Transform::IDENTITY })
    };
    let disk = |height, radius, inner_radius, phi_max| {
        Geometry::Disk(Disk { height, radius, inner_radius, phi_max, to_parent: Transform::IDENTITY })
    };
    let cylinder = |radius, z_min, z_max, phi_max| {
        Geometry::Cylinder(Cylinder { radius, z_min, z_max, phi_max, to_parent: Transform::IDENTITY })
    };
    let mut world = world_of(vec![
        Geometry::Triangles(mesh),
        Geometry::Patches(patches),
        sphere(0.0, -1.0, 1.0, TAU),
        sphere(f32::NAN, -1.0, 1.0, TAU),
        sphere(1.0, f32::NAN, 1.0, TAU),
        sphere(1.0, -1.0, 1.0, 0.0),
        sphere(1.0, 0.5, 0.5, TAU),
        sphere(f32::INFINITY, -1.0, 1.0, TAU),
        disk(0.0, 1.0, 1.0, TAU),
        disk(f32::INFINITY, 1.0, 0.0, TAU),
        disk(0.0, 1.0, f32::NAN, TAU),
        cylinder(1.0, 2.0, 2.0, TAU),
        cylinder(-1.0, 0.0, 2.0, TAU),
        cylinder(1.0, 0.0, 2.0, f32::NAN),
    ]);
    world.world.push(99);
    world.groups = vec![vec![], vec![2, 55]];
    world.instances = [0, 1, 7].map(|group| Instance { group, to_world: Transform::IDENTITY.into() }).into();
    // Five triangles, four patches, twelve quadrics, one geometry; in the groups two; three instances of nothing.
    assert_eq!(build(&world, Builder::BinnedSah).stats().dropped, 5 + 4 + 12 + 1 + 2 + 3);
    compare(&world, &rays(&mut Random(5), 300, 1.5));
}

#[test]
fn an_empty_world_is_never_hit() {
    let accel = Accel::build(World::default(), &BuildOptions::default());
    assert!(accel.bounds().is_empty());
    assert_eq!(accel.intersect(&Ray::new(Vec3::ZERO, Vec3::X)), None);
    assert_eq!(accel.stats().nodes, 0);
}

#[test]
fn rays_that_are_not_rays_hit_nothing() {
    let world = world_of(vec![Geometry::Triangles(soup(&mut Random(6), 100, 1.0))]);
    let (nan, infinite) = (Vec3::new(0.0, f32::NAN, 0.0), Vec3::new(f32::INFINITY, 0.0, 0.0));
    let good = Ray::new(Vec3::ZERO, Vec3::X);
    let rays = [
        Ray::new(nan, Vec3::X),
        Ray::new(Vec3::ZERO, nan),
        Ray::new(infinite, Vec3::X),
        Ray::new(Vec3::ZERO, infinite),
        Ray::new(Vec3::ZERO, Vec3::ZERO),
        Ray::new(Vec3::ZERO, -Vec3::ZERO),
        good.with_t_max(0.0),
        good.with_t_max(-1.0),
        good.with_t_max(f32::NAN),
        Ray { t_min: 5.0, t_max: 4.0, ..good },
        Ray { t_min: f32::INFINITY, ..good },
    ];
    let unusual = [Ray { t_min: f32::NAN, ..good }, Ray { t_min: -7.0, ..good }, Ray { t_min: -0.0, ..good }];
    for (options, accel) in every_accel(&world) {
        let context = format!("{options:?}");
        check_queries(&context, &accel, &rays, &[None; 11]);
        let hit = accel.intersect(&good);
        assert!(hit.is_some());
        check_queries(&context, &accel, &unusual, &[hit; 3]);
    }
    compare(&world, &unusual);
}

#[test]
fn all_shapes_and_instances_together() {
    for seed in 0..4 {
        let mut random = Random(100 + seed);
        let world = zoo(&mut random);
        let mut rays = rays(&mut random, 1000, 1.5);
        rays.extend(nasty_rays(&mut random, 400, 1.5));
        let hits = compare(&world, &rays);
        assert!(hits > 250, "{hits} hits");
    }
}

/// Coordinates that break careless code, all of them finite or not.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => (-4_i8..5).prop_map(|x| f32::from(x) * 0.5),
        4 => -2.0_f32..2.0,
        1 => prop::sample::select(vec![1e-30, -1e-30, 1e-6, 1e6, -0.0, 1e18, f32::MIN_POSITIVE]),
        1 => prop::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN]),
    ]
}

fn vector() -> impl Strategy<Value = Vec3> {
    (coordinate(), coordinate(), coordinate()).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: prop::test_runner::RngSeed::Fixed(11),
        ..ProptestConfig::with_cases(300) })]

    #[test]
    fn nasty_triangles(
        positions in prop::collection::vec(vector(), 1..40),
        faces in prop::collection::vec((0_u32..42, 0_u32..42, 0_u32..42), 0..60),
        origins in prop::collection::vec((vector(), vector()), 20),
    ) {
        let indices: Vec<[u32; 3]> = faces.into_iter().map(|(a, b, c)| [a, b, c]).collect();
        let mesh = TriangleMesh { indices: indices.into(), positions: positions.into() };
        let rays: Vec<Ray> = origins.into_iter().map(|(o, d)| Ray::new(o, d)).collect();
        compare(&world_of(vec![Geometry::Triangles(mesh)]), &rays);
    }

    #[test]
    fn nasty_patches(
        positions in prop::collection::vec(vector(), 1..20),
        faces in prop::collection::vec((0_u32..20, 0_u32..20, 0_u32..20, 0_u32..20), 0..30),
        origins in prop::collection::vec((vector(), vector()), 20),
    ) {
        let indices: Vec<[u32; 4]> = faces.into_iter().map(|(a, b, c, d)| [a, b, c, d]).collect();
        let mesh = PatchMesh { indices: indices.into(), positions: positions.into() };
        let rays: Vec<Ray> = origins.into_iter().map(|(o, d)| Ray::new(o, d)).collect();
        compare(&world_of(vec![Geometry::Patches(mesh)]), &rays);
    }
}
