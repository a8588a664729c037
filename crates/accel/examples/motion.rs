//! A blade that turns while the shutter is open, and a tent whose tip sinks: the same rays at several times.
#![expect(clippy::print_stdout, reason = "an example shows what it finds")]

use std::f64::consts::FRAC_PI_2;

use sahl_accel::{
    Accel, BuildOptions, Geometry, Instance, MovingTriangleMesh, Placement, TriangleMesh, World,
};
use sahl_math::{AnimatedTransform, Ray, Transform, Vec3};

fn main() {
    // Motion of vertices: where they are when the shutter opens, and when it closes.
    let tent =
        |height: f32| [Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 0.0, height)];
    let sinking =
        MovingTriangleMesh { indices: [[0, 1, 2]].into(), positions: [tent(2.0).into(), tent(0.5).into()] };
    // Motion of an instance: a transform for each end, parted into what turns, scales and moves.
    let blade = TriangleMesh {
        indices: [[0, 1, 2]].into(),
        positions: [Vec3::ZERO, Vec3::new(3.0, -0.4, 0.0), Vec3::new(3.0, 0.4, 0.0)].into(),
    };
    let quarter_turn = Transform::rotate(FRAC_PI_2, [0.0, 0.0, 1.0]).expect("the axis has a length");
    let to_world = AnimatedTransform::new(Transform::IDENTITY, quarter_turn, [0.0, 1.0])
        .map_or(Placement::from(Transform::IDENTITY), Placement::from);
    let world = World {
        geometries: vec![Geometry::MovingTriangles(sinking), Geometry::Triangles(blade)],
        world: vec![0],
        groups: vec![vec![1]],
        instances: vec![Instance { group: 0, to_world }],
        ..World::default()
    };
    let accel = Accel::build(world, &BuildOptions::default());

    // A ray meets everything where it is at the time of the ray, from 0, the shutter opens, to 1, it closes.
    let down = |x: f32, y: f32, time: f32| Ray::new(Vec3::new(x, y, 5.0), -Vec3::Z).with_time(time);
    for step in 0..=4 {
        let time = step as f32 / 4.0;
        let tip = accel.intersect(&down(0.0, -0.05, time)).map(|hit| 5.0 - hit.t);
        let is_under_blade = accel.occluded(&down(1.5, 1.5, time));
        println!(
            "time {time}: the tent is {tip:.2?} high, and the blade {} overhead",
            if is_under_blade { "is" } else { "is not" }
        );
    }
}
