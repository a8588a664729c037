//! Building ends, drops what it must, and stays within its bounds, whatever it is given.

mod common;

use common::agreement::{TREES, agree, check_queries, compare, every_accel, tiers};
use common::worlds::{camera_rays, loose_triangles, nasty_rays, rays, rays_at, soup};
use common::{Random, build, world_of};
use proptest::prelude::*;
use sahl_accel::{
    Accel, BuildOptions, Builder, Geometry, Hit, Instance, PatchMesh, Sphere, Tier, TriangleMesh, World,
};
use sahl_math::{Ray, Transform, Vec3};

/// No tree is deeper, in wide nodes: the bound of the binary tree, and four levels for a leaf of other primitives.
const DEPTH_LIMIT: u32 = 68;

fn triangles(positions: Vec<Vec3>) -> World {
    world_of(vec![Geometry::Triangles(loose_triangles(positions))])
}

/// Builds with every builder, and returns the greatest depth.
fn depth(world: &World) -> u32 {
    let depths = TREES.map(|builder| build(world, builder).stats().depth);
    let deepest = depths.into_iter().max().unwrap_or(0);
    assert!(deepest <= DEPTH_LIMIT, "{deepest}");
    deepest
}

#[test]
fn a_hundred_thousand_identical_triangles() {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let indices = vec![[0, 1, 2]; 100_000];
    let mesh = TriangleMesh { indices: indices.into(), positions: positions.into() };
    let world = world_of(vec![Geometry::Triangles(mesh)]);
    assert!(depth(&world) < 12);
    let mut rays = camera_rays(Vec3::new(0.3, 0.2, 2.0), Vec3::new(0.3, 0.3, 0.0), 1, 0.5);
    rays.truncate(6);
    rays.extend(rays_at(&mut Random(1), &loose_triangles(positions.to_vec()), 4, 1.0));
    let oracle = build(&world, Builder::BruteForce);
    let expected: Vec<Option<Hit>> = rays.iter().map(|ray| oracle.intersect(ray)).collect();
    assert!(expected.iter().flatten().all(|hit| hit.primitive == 0) && expected.iter().flatten().count() > 4);
    for (options, accel) in every_accel(&world) {
        assert_eq!(accel.stats().primitives, 100_000);
        check_queries(&format!("{options:?}"), &accel, &rays, &expected);
    }
}

#[test]
fn triangles_within_triangles() {
    let corner = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    // All about one point, the smallest a billion times smaller; then the same one behind the other.
    for step in [0.0, 1e-3] {
        let positions = (0..300)
            .flat_map(|i| corner.map(|p| p * 0.93_f32.powi(i) + Vec3::Z * (step * i as f32)))
            .collect();
        let world = triangles(positions);
        depth(&world);
        let mut aimed: Vec<Ray> = (0..200)
            .map(|i| {
                Ray::new(Vec3::new(0.1, 0.2, 2.0), corner[i % 3] * 0.93_f32.powi(i as i32) - Vec3::Z * 2.0)
            })
            .collect();
        aimed.extend(rays(&mut Random(2), 200, 1.2));
        assert!(agree(&world, &aimed) > 100);
    }
}

#[test]
fn distances_that_grow_exponentially() {
    for (base, count, flat) in [(1.15_f32, 240, false), (1.5, 64, false), (2.0, 80, true), (1.02, 900, true)]
    {
        let mut positions = Vec::new();
        for i in 0..count {
            let x = 1e-6 * base.powi(i);
            let (y, z) = if flat { (0.0, 1.0) } else { (x, x) };
            positions.extend([Vec3::new(x, -y, -z), Vec3::new(x * 1.01, y, -z), Vec3::new(x, 0.0, z)]);
        }
        let mesh = loose_triangles(positions);
        let world = world_of(vec![Geometry::Triangles(mesh.clone())]);
        depth(&world);
        let mut random = Random(3);
        let rays = rays_at(&mut random, &mesh, 400, 1.0);
        assert!(compare(&world, &rays) > 30);
        // The same on the other axes, and backwards.
        let turned = mesh.positions.iter().map(|p| Vec3::new(p.z, -p.x, p.y)).collect();
        depth(&triangles(turned));
    }
}

#[test]
fn trees_too_deep_for_a_small_stack() {
    // Each split takes one kind of primitive off; instances of a group that is as deep make two stacks at once.
    let mut random = Random(4);
    let mut geometries = Vec::new();
    for i in 0..90 {
        let radius = 1.35_f32.powi(i) * 1e-6;
        let to_parent = Transform::translate(3.0 * f64::from(radius), 0.0, 0.0).expect("a regular matrix");
        let sphere = Sphere { radius, z_min: -radius, z_max: radius, phi_max: 7.0, to_parent };
        geometries.push(Geometry::Sphere(sphere));
    }
    geometries.push(Geometry::Triangles(soup(&mut random, 200, 0.01)));
    let all: Vec<u32> = (0..91).collect();
    let moved = |x: f64| Transform::translate(x, 0.1, 0.2).expect("a regular matrix");
    let instances =
        (0..30).map(|i| Instance { group: 0, to_world: moved(f64::from(i).exp2() * 1e-6).into() }).collect();
    let world = World { world: all.clone(), groups: vec![all], instances, geometries, ..World::default() };
    assert!(depth(&world) > 7, "{}", depth(&world));
    let mut rays = rays(&mut random, 300, 2.0);
    rays.extend((0..100).map(|i| {
        let target = Vec3::new(1.1_f32.powi(i % 100) * 1e-5, 0.0, 0.0);
        Ray::new(Vec3::new(-0.5, 0.3, 0.2), target - Vec3::new(-0.5, 0.3, 0.2))
    }));
    rays.extend(camera_rays(Vec3::new(-1.0, 0.3, 0.5), Vec3::new(0.2, 0.0, 0.0), 1, 2.0));
    assert!(compare(&world, &rays) > 50);
}

#[test]
fn everything_in_a_line_or_a_plane_or_a_point() {
    let mut random = Random(5);
    let flat = |random: &mut Random, scale: Vec3| {
        let positions = (0..900).map(|_| random.point(1.0) * scale).collect();
        loose_triangles(positions)
    };
    for scale in [Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 1.0, 1e-30), Vec3::new(1.0, 1e-6, 1e-6)] {
        let mesh = flat(&mut random, scale);
        let rays = rays_at(&mut random, &mesh, 500, 1.5);
        let world = world_of(vec![Geometry::Triangles(mesh)]);
        assert!(depth(&world) < 20);
        agree(&world, &rays);
    }
    // Triangles on a line have no surface.
    let world = world_of(vec![Geometry::Triangles(flat(&mut random, Vec3::X))]);
    for builder in TREES {
        let accel = build(&world, builder);
        assert_eq!((accel.stats().dropped, accel.stats().nodes), (300, 0));
        assert!(accel.bounds().is_empty());
    }
    compare(&world, &rays(&mut random, 100, 1.0));
}

#[test]
fn what_is_not_finite_or_out_of_range_is_dropped() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 2e18, -1e30];
    let mut positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    for value in odd {
        for axis in 0..3 {
            let mut p = Vec3::ONE;
            p[axis] = value;
            positions.push(p);
        }
    }
    let last = positions.len() as u32;
    let mut faces: Vec<[u32; 3]> =
        (4..last).flat_map(|bad| [[bad, 0, 1], [1, bad, 2], [2, 3, bad]]).collect();
    faces.extend([[0, 1, last], [u32::MAX, 1, 2], [0, 1, 1], [3, 3, 3]]);
    let bad = faces.len() as u64;
    // Good ones between them.
    let good = [[0, 1, 2], [1, 2, 3], [0, 2, 3]];
    let faces: Vec<[u32; 3]> = faces.into_iter().enumerate().flat_map(|(i, f)| [good[i % 3], f]).collect();
    let mesh = TriangleMesh { indices: faces.into(), positions: positions.as_slice().into() };
    let quads: Vec<[u32; 4]> = (4..last).map(|bad| [0, 1, 2, bad]).chain([[0, 1, 2, last]]).collect();
    let bad_patches = quads.len() as u64;
    let patches = PatchMesh { indices: quads.into(), positions: positions.into() };
    let world = world_of(vec![Geometry::Triangles(mesh), Geometry::Patches(patches)]);
    for builder in TREES.into_iter().chain([Builder::BruteForce]) {
        let stats = build(&world, builder).stats();
        assert_eq!((stats.dropped, stats.primitives), (bad + bad_patches, bad), "{builder:?}");
    }
    let mut random = Random(6);
    let mut rays = rays(&mut random, 300, 1.0);
    rays.extend(nasty_rays(&mut random, 200, 1.0));
    let hits = compare(&world, &rays);
    assert!(hits > 20, "{hits} hits");
}

#[test]
fn groups_and_instances_of_nothing() {
    let mut random = Random(7);
    let mesh = Geometry::Triangles(soup(&mut random, 30, 0.5));
    let empty = Geometry::Triangles(TriangleMesh { indices: [].into(), positions: [].into() });
    let place = |x: f64| Transform::translate(x, 0.0, 0.0).expect("a regular matrix");
    let far = Transform::translate(1e30, 0.0, 0.0).expect("a regular matrix");
    let instance = |group, to_world: Transform| Instance { group, to_world: to_world.into() };
    let world = World {
        geometries: vec![mesh, empty],
        world: vec![1, 1, 9],
        groups: vec![vec![], vec![1], vec![0], vec![5, 6]],
        instances: vec![
            instance(0, place(0.0)),
            instance(1, place(0.0)),
            instance(2, place(0.5)),
            instance(3, place(0.0)),
            instance(4, place(0.0)),
            instance(u32::MAX, place(0.0)),
            instance(2, far),
        ],
        ..World::default()
    };
    // Of the world's geometries and the last group's three are not there; five instances hold nothing, one is too far.
    assert_eq!(build(&world, Builder::BinnedSah).stats().dropped, 3 + 6);
    let rays = rays(&mut random, 300, 1.5);
    assert!(compare(&world, &rays) > 20);
    let nothing = World { instances: world.instances[..2].to_vec(), world: vec![], ..world };
    assert_eq!(compare(&nothing, &rays), 0);
    assert!(build(&nothing, Builder::BinnedSah).bounds().is_empty());
}

#[test]
fn a_tier_that_the_processor_lacks_is_replaced() {
    let world = world_of(vec![Geometry::Triangles(soup(&mut Random(8), 50, 0.5))]);
    let mut rays = rays(&mut Random(9), 100, 1.5);
    rays.truncate(100);
    let oracle = build(&world, Builder::BruteForce);
    let expected: Vec<Option<Hit>> = rays.iter().map(|ray| oracle.intersect(ray)).collect();
    for tier in Tier::ALL {
        let options = BuildOptions { tier: Some(tier), ..BuildOptions::default() };
        check_queries(&format!("{tier:?}"), &Accel::build(world.clone(), &options), &rays, &expected);
    }
    assert!(tiers().any(|tier| tier == Tier::Scalar));
}

#[test]
fn every_number_of_bins_builds() {
    let mut random = Random(10);
    let world = world_of(vec![Geometry::Triangles(soup(&mut random, 3000, 0.05))]);
    let rays = rays(&mut random, 100, 1.5);
    let expected: Vec<_> = rays.iter().map(|ray| build(&world, Builder::Median).intersect(ray)).collect();
    for bins in [0, 1, 2, 3, 31, 32, 33, u32::MAX] {
        let accel = Accel::build(world.clone(), &BuildOptions { bins, ..BuildOptions::default() });
        check_queries(&format!("{bins} bins"), &accel, &rays, &expected);
    }
}

/// A number of any magnitude that is kept.
fn magnitude() -> impl Strategy<Value = f32> {
    prop_oneof![
        3 => (-30.0_f32..4.0, any::<bool>()).prop_map(|(e, negative)| {
            let x = 10.0_f32.powf(e);
            if negative { -x } else { x }
        }),
        1 => Just(0.0),
        1 => -1.0_f32..1.0,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: prop::test_runner::RngSeed::Fixed(12),
        ..ProptestConfig::with_cases(60) })]

    #[test]
    fn extents_of_any_magnitude(
        coordinates in prop::collection::vec((magnitude(), magnitude(), magnitude()), 3..900),
        copies in 1_usize..4,
    ) {
        let mut positions = Vec::new();
        for _ in 0..copies {
            positions.extend(coordinates.iter().map(|&(x, y, z)| Vec3::new(x, y, z)));
        }
        let world = triangles(positions);
        depth(&world);
        let oracle = build(&world, Builder::BruteForce);
        for builder in TREES {
            let accel = build(&world, builder);
            prop_assert_eq!(accel.stats().primitives, oracle.stats().primitives);
            prop_assert_eq!(accel.stats().dropped, oracle.stats().dropped);
            prop_assert_eq!(accel.bounds(), oracle.bounds());
        }
    }
}

#[test]
fn a_direction_with_a_subnormal_component_misses_no_box() {
    let positions = [[10.0, 5e-39, -1.0], [10.0, 1.0, -1.0], [10.0, 5e-39, 1.0]].map(Vec3::from);
    let mesh = TriangleMesh { indices: [[0, 1, 2]].into(), positions: positions.into() };
    let world = world_of(vec![Geometry::Triangles(mesh)]);
    let ray = Ray::new(Vec3::ZERO, Vec3::new(1.0, 1e-39, -0.01));
    let expected = build(&world, Builder::BruteForce).intersect(&ray);
    assert!(expected.is_some());
    for builder in [Builder::Median, Builder::BinnedSah] {
        assert_eq!(build(&world, builder).intersect(&ray), expected, "{builder:?}");
    }
}

#[test]
fn the_parameter_of_a_quadric_lies_beyond_the_interval_after_rounding() {
    let sphere = Sphere {
        radius: 1.0,
        z_min: -1.0,
        z_max: 1.0,
        phi_max: std::f32::consts::TAU,
        to_parent: Transform::IDENTITY,
    };
    let world = world_of(vec![Geometry::Sphere(sphere)]);
    let ray = Ray::new(Vec3::new(0.0, 0.0, -1.0_f32.next_up()), Vec3::new(0.0, 0.0, 3e38));
    for builder in [Builder::BruteForce, Builder::BinnedSah] {
        let hit = build(&world, builder).intersect(&ray);
        assert!(hit.is_none_or(|hit| hit.t > 0.0), "{builder:?} {hit:?}");
    }
}
