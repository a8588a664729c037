//! Worlds that move.

use sahl_accel::{Geometry, Instance, MovingTriangleMesh, TriangleMesh, World};
use sahl_math::{AnimatedTransform, Ray, Vec3};

use super::Random;
use super::meshes::torus;
use super::worlds::{placement, soup, zoo};

/// Times that matter, and others.
const TIMES: [f32; 8] = [0.0, 1.0, 0.5, f32::MIN_POSITIVE, 0.999_999_94, -0.5, 2.0, f32::NAN];

/// The rays, each at a time of its own.
pub(crate) fn at_any_time(random: &mut Random, rays: Vec<Ray>) -> Vec<Ray> {
    let time = |(i, ray): (usize, Ray)| match i % 4 {
        0 => ray.with_time(TIMES[random.below(TIMES.len())]),
        _ => ray.with_time(random.unit()),
    };
    rays.into_iter().enumerate().map(time).collect()
}

/// The mesh moving to where a map puts its vertices.
pub(crate) fn moving(mesh: &TriangleMesh, to: impl Fn(Vec3) -> Vec3) -> MovingTriangleMesh {
    let end: Vec<Vec3> = mesh.positions.iter().map(|&p| to(p)).collect();
    MovingTriangleMesh { indices: mesh.indices.clone(), positions: [mesh.positions.clone(), end.into()] }
}

/// The mesh as it is at a time.
pub(crate) fn frozen(mesh: &MovingTriangleMesh, time: f32) -> TriangleMesh {
    let mut positions = Vec::new();
    for triangle in 0..mesh.indices.len() as u32 {
        positions.extend(mesh.triangle_at(triangle, time).unwrap_or([Vec3::ZERO; 3]));
    }
    super::worlds::loose_triangles(positions)
}

/// A motion between two placements, both of which mirror.
pub(crate) fn motion(random: &mut Random) -> AnimatedTransform {
    let times = [[0.0, 1.0], [0.25, 0.5], [-1.0, 3.0]][random.below(3)];
    AnimatedTransform::new(placement(random), placement(random), times).expect("both mirror")
}

/// All kinds of shapes, moving meshes, and instances of both that move and stand still.
pub(crate) fn moving_zoo(random: &mut Random) -> World {
    let mut world = zoo(random);
    let first = world.geometries.len() as u32;
    let loose = soup(random, 150, 0.3);
    let ends = soup(random, 150, 0.3).positions;
    world.geometries.push(Geometry::MovingTriangles(MovingTriangleMesh {
        indices: loose.indices,
        positions: [loose.positions, ends],
    }));
    let ring = torus(24, 12).triangle_mesh();
    let turn = motion(random).at(1.0);
    world.geometries.push(Geometry::MovingTriangles(moving(&ring, |p| turn.point(p))));
    world.world.extend([first, first + 1]);
    world.groups[0].push(first);
    world.groups[1].push(first + 1);
    world.groups.push(vec![first, first + 1]);
    for group in 0..9 {
        world.instances.push(Instance { group: group % 3, to_world: motion(random).into() });
    }
    world
}
