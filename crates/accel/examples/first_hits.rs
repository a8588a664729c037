//! Builds a world of two instances of a pyramid over a disk, asks what one ray hits, and draws what a camera sees and where the
//! sun shines.
#![expect(clippy::print_stdout, reason = "an example shows what it finds")]

use sahl_accel::{Accel, BuildOptions, Disk, Geometry, Hit, Instance, TriangleMesh, World};
use sahl_math::{Ray, Transform, Vec3};

fn main() {
    let tip_and_base =
        [[0.0, 0.0, 2.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let pyramid = TriangleMesh {
        indices: [[1, 2, 0], [2, 3, 0], [3, 4, 0], [4, 1, 0]].into(),
        positions: tip_and_base.map(Vec3::from).into(),
    };
    let to_parent = Transform::IDENTITY;
    let floor =
        Disk { height: 0.0, radius: 5.0, inner_radius: 0.0, phi_max: std::f32::consts::TAU, to_parent };
    let placements = [Transform::translate(-2.0, 0.0, 0.0), Transform::translate(2.0, 0.0, 0.0)];
    let world = World {
        geometries: vec![Geometry::Triangles(pyramid), Geometry::Disk(floor)],
        world: vec![1],
        groups: vec![vec![0]],
        instances: placements
            .into_iter()
            .flatten()
            .map(|to_world| Instance { group: 0, to_world: to_world.into() })
            .collect(),
        ..World::default()
    };
    let accel = Accel::build(world, &BuildOptions::default());

    let down = Ray::new(Vec3::new(2.0, 0.3, 10.0), -Vec3::Z);
    if let Some(hit) = accel.intersect(&down) {
        let point = accel.surface_point(&down, &hit);
        println!(
            "instance {} at height {:.2}, normal {:.2?}",
            hit.instance,
            point.p.z,
            <[f32; 3]>::from(point.n)
        );
    }

    // The rays of a row go nearly the same way.
    let eye = Vec3::new(0.0, -12.0, 7.0);
    let pixel = |x: i32, y: i32| Vec3::new(0.16 * x as f32 - 5.0, 0.0, 4.0 - 0.36 * y as f32);
    for y in 0..20 {
        let rays: Vec<Ray> = (0..64).map(|x| Ray::new(eye, pixel(x, y) - eye)).collect();
        let mut hits = vec![None; rays.len()];
        accel.intersect_coherent(&rays, &mut hits);
        let points = |(ray, hit): (&Ray, &Option<Hit>)| hit.map(|hit| accel.surface_point(ray, &hit));
        let points: Vec<_> = rays.iter().zip(&hits).map(points).collect();
        // A ray that starts nowhere hits nothing.
        let sun = Vec3::new(2.0, -1.0, 2.0);
        let to_sun = points.iter().map(|point| match point {
            Some(point) => Ray::spawn(point.p, point.p_error, point.n, sun),
            None => Ray::new(Vec3::ZERO, Vec3::ZERO),
        });
        let mut shaded = vec![false; rays.len()];
        accel.occluded_batch(&to_sun.collect::<Vec<_>>(), &mut shaded);
        let mark = |(hit, shaded): (&Option<Hit>, &bool)| match (hit, shaded) {
            (None, _) => ' ',
            (Some(_), true) => '.',
            (Some(hit), false) => {
                if hit.instance == Hit::NO_INSTANCE {
                    '-'
                } else {
                    '#'
                }
            }
        };
        println!("{}", hits.iter().zip(&shaded).map(mark).collect::<String>());
    }
}
