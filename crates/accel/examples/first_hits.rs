//! Builds a world of two instances of a pyramid over a disk, and prints what a row of rays hits first.
#![expect(clippy::print_stdout, reason = "an example shows what it finds")]

use sahl_accel::{Accel, BuildOptions, Disk, Geometry, Hit, Instance, TriangleMesh, World};
use sahl_math::{Ray, Transform, Vec3};

fn main() {
    let pyramid = TriangleMesh {
        indices: [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]].into(),
        positions: [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 2.0]]
            .map(Vec3::from)
            .into(),
    };
    let floor = Disk {
        height: 0.0,
        radius: 5.0,
        inner_radius: 0.0,
        phi_max: std::f32::consts::TAU,
        to_parent: Transform::IDENTITY,
    };
    let placements = [Transform::translate(-2.0, 0.0, 0.0), Transform::translate(2.0, 0.0, 0.0)];
    let world = World {
        geometries: vec![Geometry::Triangles(pyramid), Geometry::Disk(floor)],
        world: vec![1],
        groups: vec![vec![0]],
        instances: placements.into_iter().flatten().map(|to_world| Instance { group: 0, to_world }).collect(),
    };
    let accel = Accel::build(world, &BuildOptions::default());
    for i in -6..=6 {
        let ray = Ray::new(Vec3::new(i as f32, 0.3, 10.0), -Vec3::Z);
        let Some(hit) = accel.intersect(&ray) else {
            println!("x = {i:2}: nothing");
            continue;
        };
        let point = accel.surface_point(&ray, &hit);
        let what = if hit.instance == Hit::NO_INSTANCE { "the floor" } else { "a pyramid" };
        println!("x = {i:2}: {what} at height {:.3}, normal {:?}", point.p.z, <[f32; 3]>::from(point.n));
    }
}
