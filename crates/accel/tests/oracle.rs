//! Every builder against the brute-force list, on worlds made to be awkward.

mod common;

use std::f32::consts::TAU;

use common::{Random, build, world_of};
use proptest::prelude::*;
use sahl_accel::{
    Accel, BuildOptions, Builder, Cylinder, Disk, Geometry, Hit, Instance, PatchMesh, Sphere, TraversalCount,
    TriangleMesh, World,
};
use sahl_math::{Ray, Transform, Vec3};

const TREES: [Builder; 2] = [Builder::BinnedSah, Builder::Median];

/// Compares all queries; returns how many rays hit.
fn compare(world: &World, rays: &[Ray]) -> usize {
    let oracle = build(world, Builder::BruteForce);
    let expected: Vec<Option<Hit>> = rays.iter().map(|ray| oracle.intersect(ray)).collect();
    for builder in TREES {
        let accel = build(world, builder);
        assert_eq!(accel.stats().dropped, oracle.stats().dropped);
        assert_eq!(accel.bounds(), oracle.bounds());
        let mut batch = vec![None; rays.len()];
        accel.intersect_batch(rays, &mut batch);
        let mut occluded = vec![false; rays.len()];
        accel.occluded_batch(rays, &mut occluded);
        for (i, ray) in rays.iter().enumerate() {
            let hit = accel.intersect(ray);
            assert_eq!(hit, expected[i], "{builder:?} {ray:?}");
            assert_eq!(hit, batch[i], "{builder:?} batch {ray:?}");
            assert_eq!(hit.is_some(), occluded[i], "{builder:?} occluded batch {ray:?}");
            assert_eq!(hit.is_some(), accel.occluded(ray), "{builder:?} occluded {ray:?}");
            assert_eq!(hit.is_some(), oracle.occluded(ray), "oracle occluded {ray:?}");
            let mut count = TraversalCount::default();
            assert_eq!(hit, accel.intersect_counted(ray, &mut count), "{builder:?} counted {ray:?}");
            assert!(hit.is_none() || count.nodes > 0 && count.primitives > 0);
        }
    }
    expected.iter().flatten().count()
}

fn rays(random: &mut Random, count: usize, half: f32) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let origin = random.point(half);
            let direction = match i % 4 {
                0 => [Vec3::X, -Vec3::Y, Vec3::Z][i / 4 % 3],
                1 => Vec3::new(random.range(-1.0, 1.0), 0.0, random.range(-1.0, 1.0)),
                _ => random.direction() * random.range(0.01, 10.0),
            };
            let ray = Ray::new(origin, direction);
            if i % 3 == 0 { Ray { t_min: 0.1, t_max: random.range(0.0, 2.0 * half), ..ray } } else { ray }
        })
        .collect()
}

fn soup(random: &mut Random, count: usize, size: f32) -> TriangleMesh {
    let mut positions = Vec::new();
    for _ in 0..count {
        let center = random.point(1.0);
        positions.extend((0..3).map(|_| center + random.point(size)));
    }
    let indices: Vec<[u32; 3]> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh { indices: indices.into(), positions: positions.into() }
}

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
    let indices: Vec<[u32; 3]> = (0..600).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = TriangleMesh { indices: indices.into(), positions: positions.into() };
    assert!(compare(&world_of(vec![Geometry::Triangles(mesh)]), &rays(&mut random, 4000, 1.5)) > 1000);
}

#[test]
fn duplicates_and_coplanar_triangles_give_the_lowest_primitive() {
    let positions: Vec<Vec3> = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X + Vec3::Y];
    let indices = vec![[0, 1, 2]; 100];
    let mesh = || TriangleMesh { indices: indices.as_slice().into(), positions: positions.as_slice().into() };
    let mut world = world_of(vec![Geometry::Triangles(mesh()), Geometry::Triangles(mesh())]);
    world.world = vec![1, 0, 1];
    let mut random = Random(3);
    compare(&world, &rays(&mut random, 500, 1.0));
    let hit =
        build(&world, Builder::BinnedSah).intersect(&Ray::new(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z)).unwrap();
    assert_eq!((hit.instance, hit.geometry, hit.primitive), (Hit::NO_INSTANCE, 0, 0));
}

#[test]
fn an_instance_goes_before_the_world_at_the_same_place() {
    let mut random = Random(4);
    let mut world = world_of(vec![Geometry::Triangles(soup(&mut random, 50, 0.5))]);
    world.groups = vec![vec![0]];
    world.instances = vec![Instance { group: 0, to_world: Transform::IDENTITY }; 3];
    let rays = rays(&mut random, 500, 1.5);
    assert!(compare(&world, &rays) > 50);
    let accel = build(&world, Builder::BinnedSah);
    assert!(rays.iter().filter_map(|ray| accel.intersect(ray)).all(|hit| hit.instance == 0));
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
    world.instances = [0, 1, 7].map(|group| Instance { group, to_world: Transform::IDENTITY }).into();
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
    let accel =
        build(&world_of(vec![Geometry::Triangles(soup(&mut Random(6), 100, 1.0))]), Builder::BinnedSah);
    let (nan, infinite) = (Vec3::new(0.0, f32::NAN, 0.0), Vec3::new(f32::INFINITY, 0.0, 0.0));
    let good = Ray::new(Vec3::ZERO, Vec3::X);
    for ray in [
        Ray::new(nan, Vec3::X),
        Ray::new(Vec3::ZERO, nan),
        Ray::new(infinite, Vec3::X),
        Ray::new(Vec3::ZERO, infinite),
        Ray::new(Vec3::ZERO, Vec3::ZERO),
        good.with_t_max(0.0),
        good.with_t_max(-1.0),
        good.with_t_max(f32::NAN),
        Ray { t_min: 5.0, t_max: 4.0, ..good },
    ] {
        assert_eq!(accel.intersect(&ray), None, "{ray:?}");
        assert!(!accel.occluded(&ray), "{ray:?}");
    }
    assert!(accel.intersect(&good).is_some());
    assert_eq!(accel.intersect(&Ray { t_min: f32::NAN, ..good }), accel.intersect(&good));
    assert_eq!(accel.intersect(&Ray { t_min: -7.0, ..good }), accel.intersect(&good));
}

/// All kinds of shapes, two groups and instances of them.
fn zoo(random: &mut Random) -> World {
    let mut transform = || {
        let moved = random.point(1.0);
        let axis: [f32; 3] = random.direction().into();
        let scale = [random.range(0.1, 0.6), random.range(0.1, 0.6), random.range(-0.6, -0.1)].map(f64::from);
        let turned = Transform::rotate(f64::from(random.range(0.0, 6.0)), axis.map(f64::from))
            .expect("a regular matrix");
        let turned = turned
            .after(&Transform::scale(scale[0], scale[1], scale[2]).expect("a regular matrix"))
            .expect("a regular matrix");
        Transform::translate(f64::from(moved.x), f64::from(moved.y), f64::from(moved.z))
            .expect("a regular matrix")
            .after(&turned)
            .expect("a regular matrix")
    };
    let mut geometries = Vec::new();
    for i in 0..8 {
        let phi_max = if i % 2 == 0 { TAU } else { 2.5 };
        let (z_min, z_max) = if i % 3 == 0 { (-1.0, 1.0) } else { (0.7, -0.2) };
        geometries.push(Geometry::Sphere(Sphere {
            radius: 1.0,
            z_min,
            z_max,
            phi_max,
            to_parent: transform(),
        }));
        geometries.push(Geometry::Cylinder(Cylinder {
            radius: 0.8,
            z_min,
            z_max,
            phi_max,
            to_parent: transform(),
        }));
        let inner_radius = if i % 3 == 0 { 0.4 } else { 0.0 };
        geometries.push(Geometry::Disk(Disk {
            height: 0.1,
            radius: 1.0,
            inner_radius,
            phi_max,
            to_parent: transform(),
        }));
    }
    let instances = (0..12).map(|i| Instance { group: i % 2, to_world: transform() }).collect();
    geometries.push(Geometry::Triangles(soup(random, 60, 0.4)));
    let corners: Vec<Vec3> = (0..80).map(|_| random.point(1.0)).collect();
    let indices: Vec<[u32; 4]> = (0..20).map(|i| [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3]).collect();
    geometries.push(Geometry::Patches(PatchMesh { indices: indices.into(), positions: corners.into() }));
    let all: Vec<u32> = (0..geometries.len() as u32).collect();
    World { groups: vec![all[..10].to_vec(), all[10..].to_vec()], world: all, geometries, instances }
}

#[test]
fn all_shapes_and_instances_together() {
    for seed in 0..4 {
        let mut random = Random(100 + seed);
        let world = zoo(&mut random);
        let rays = rays(&mut random, 1500, 1.5);
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
