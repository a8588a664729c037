//! No ray slips between primitives that share an edge, and none hits the surface it starts from.

mod common;

use common::meshes::{Body, blob, grid_cube, torus};
use common::watertight::{Aim, Tally, shoot};
use common::{Random, build, world_of};
use sahl_accel::{Accel, Builder, Geometry, Instance, World};
use sahl_math::Transform;

const SCALES: [f32; 3] = [1e-3, 1.0, 1e4];

fn bodies() -> [Body; 3] {
    [blob(4), grid_cube(16), torus(48, 24)]
}

fn check(what: &str, accel: &Accel, body: &Body, aim: Aim, curved: bool) {
    let tally = shoot(accel, body, aim, 9_000, curved, &mut Random(7));
    let expected = Tally { rays: tally.rays, ..Tally::default() };
    assert_eq!(tally, expected, "{what}: {}", body.name);
    assert!(tally.rays > 5_000, "{what}: only {} rays", tally.rays);
}

#[test]
fn triangles_are_watertight_at_all_scales() {
    for scale in SCALES {
        for body in bodies() {
            let body = body.scaled(scale);
            let world = world_of(vec![Geometry::Triangles(body.triangle_mesh())]);
            for builder in [Builder::BinnedSah, Builder::Median] {
                let accel = build(&world, builder);
                check(&format!("{builder:?} at {scale}"), &accel, &body, Aim::Targets, false);
                if body.name == "grid cube" {
                    check(
                        &format!("axis-parallel, {builder:?} at {scale}"),
                        &accel,
                        &body,
                        Aim::AxisParallel,
                        false,
                    );
                }
            }
        }
    }
}

#[test]
fn patches_are_watertight_at_all_scales() {
    for scale in SCALES {
        for body in [grid_cube(16), torus(48, 24)] {
            let body = body.scaled(scale);
            let accel = build(&world_of(vec![Geometry::Patches(body.patch_mesh())]), Builder::BinnedSah);
            let curved = body.name == "torus";
            check(&format!("patches at {scale}"), &accel, &body, Aim::Targets, curved);
            if !curved {
                check(&format!("axis-parallel patches at {scale}"), &accel, &body, Aim::AxisParallel, false);
            }
        }
    }
}

#[test]
fn triangles_and_patches_that_share_edges_are_watertight() {
    for scale in SCALES {
        for (body, curved) in [(grid_cube(16), false), (torus(48, 24), true)] {
            let mut body = body.scaled(scale);
            // Every other quadrilateral as a patch, the rest as triangles.
            let every_quad = body.quads.clone();
            body.triangles = body.triangles.chunks(2).skip(1).step_by(2).flatten().copied().collect();
            body.quads = every_quad.iter().step_by(2).copied().collect();
            let (triangles, patches) = (body.triangle_mesh(), body.patch_mesh());
            let accel = build(
                &world_of(vec![Geometry::Triangles(triangles), Geometry::Patches(patches)]),
                Builder::BinnedSah,
            );
            body.quads = every_quad;
            check(&format!("mixed at {scale}"), &accel, &body, Aim::Targets, curved);
        }
    }
}

#[test]
fn instances_are_watertight() {
    let moved = Transform::translate(3.0, -700.0, 20.0).unwrap();
    let turned = Transform::rotate(0.8, [1.0, 2.0, 3.0]).unwrap();
    let scaled = Transform::scale(2.5, -0.7, 1.3).unwrap();
    let to_world = moved.after(&turned.after(&scaled).unwrap()).unwrap();
    for mut body in bodies() {
        let world = World {
            geometries: vec![Geometry::Triangles(body.triangle_mesh())],
            groups: vec![vec![0]],
            instances: vec![Instance { group: 0, to_world }],
            ..World::default()
        };
        let accel = build(&world, Builder::BinnedSah);
        for p in body.positions.iter_mut().chain(&mut body.inside) {
            *p = to_world.point(*p);
        }
        check("instance", &accel, &body, Aim::Targets, false);
    }
}
