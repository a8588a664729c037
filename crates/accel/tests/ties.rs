//! Of equally near hits every query gives the one with the lowest name.

mod common;

use common::agreement::{compare, every_accel, intersect_batch, intersect_coherent};
use common::worlds::{camera_rays, rays, soup};
use common::{Random, world_of};
use sahl_accel::{Accel, Geometry, Hit, Instance, TriangleMesh, World};
use sahl_math::{Ray, Transform, Vec3};

/// The hits of each query for many hits.
fn by_every_query(accel: &Accel, rays: &[Ray]) -> [Vec<Option<Hit>>; 3] {
    let single = rays.iter().map(|ray| accel.intersect(ray)).collect();
    [single, intersect_batch(accel, rays), intersect_coherent(accel, rays)]
}

/// The names of all hits of all queries on all tiers.
fn names(world: &World, rays: &[Ray]) -> Vec<(u32, u32, u32)> {
    let mut names = Vec::new();
    for (_, accel) in every_accel(world) {
        for hits in by_every_query(&accel, rays) {
            names.extend(hits.iter().flatten().map(|hit| (hit.instance, hit.geometry, hit.primitive)));
        }
    }
    names
}

/// Rays at the unit square from both sides, as packets and in disorder.
fn rays_at_square(random: &mut Random) -> Vec<Ray> {
    let mut all = camera_rays(Vec3::new(0.4, 0.3, 3.0), Vec3::new(0.5, 0.5, 0.0), 2, 1.0);
    all.extend(camera_rays(Vec3::new(0.4, 0.3, -2.0), Vec3::new(0.5, 0.5, 0.0), 2, 1.0));
    all.extend(rays(random, 300, 1.0));
    all
}

#[test]
fn coincident_triangles_give_the_lowest_primitive() {
    let positions: Vec<Vec3> = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X + Vec3::Y];
    let indices = vec![[0, 1, 2]; 100];
    let mesh = || TriangleMesh { indices: indices.as_slice().into(), positions: positions.as_slice().into() };
    let mut world = world_of(vec![Geometry::Triangles(mesh()), Geometry::Triangles(mesh())]);
    world.world = vec![1, 0, 1];
    let rays = rays_at_square(&mut Random(3));
    assert!(compare(&world, &rays) > 100);
    let found = names(&world, &rays);
    assert!(found.len() > 1000 && found.iter().all(|&name| name == (Hit::NO_INSTANCE, 0, 0)));
}

#[test]
fn a_shared_edge_belongs_to_one_triangle() {
    // A fan about a vertex that every ray meets, listed in falling order of angle.
    let rim = (0..16).map(|i| (i as f32 * -0.4).sin_cos()).map(|(y, x)| Vec3::new(x, y, 0.0));
    let positions: Vec<Vec3> = [Vec3::ZERO].into_iter().chain(rim).collect();
    let indices: Vec<[u32; 3]> = (1..16).map(|i| [0, i, i + 1]).collect();
    let world = world_of(vec![Geometry::Triangles(TriangleMesh {
        indices: indices.into(),
        positions: positions.into(),
    })]);
    let mut random = Random(5);
    let rays: Vec<Ray> = (0..256)
        .map(|_| {
            let origin = random.point(1.0);
            Ray::new(origin, -origin)
        })
        .collect();
    // Every one of them holds the vertex; their parameters differ by rounding.
    assert!(compare(&world, &rays) >= 250);
}

#[test]
fn an_instance_goes_before_the_world_at_the_same_place() {
    let mut random = Random(4);
    let mut world = world_of(vec![Geometry::Triangles(soup(&mut random, 50, 0.5))]);
    world.groups = vec![vec![0]];
    world.instances = vec![Instance { group: 0, to_world: Transform::IDENTITY.into() }; 3];
    let mut rays = rays(&mut random, 500, 1.5);
    rays.extend(camera_rays(Vec3::new(2.0, 1.0, 3.0), Vec3::ZERO, 2, 3.0));
    assert!(compare(&world, &rays) > 100);
    let found = names(&world, &rays);
    assert!(found.len() > 1000 && found.iter().all(|name| name.0 == 0));
}

#[test]
fn groups_of_the_same_triangles_under_other_names() {
    let mut random = Random(6);
    let mesh = soup(&mut random, 40, 0.5);
    let copy = || Geometry::Triangles(mesh.clone());
    let world = World {
        geometries: vec![copy(), copy(), copy()],
        world: vec![2, 1, 0],
        groups: vec![vec![2, 1], vec![0, 2]],
        instances: [0, 1].map(|group| Instance { group, to_world: Transform::IDENTITY.into() }).into(),
        ..World::default()
    };
    let mut rays = rays(&mut random, 500, 1.5);
    rays.extend(camera_rays(Vec3::new(2.0, 1.0, 3.0), Vec3::ZERO, 2, 3.0));
    assert!(compare(&world, &rays) > 100);
    let found = names(&world, &rays);
    assert!(found.len() > 1000 && found.iter().all(|name| (name.0, name.1) == (0, 1)));
}
