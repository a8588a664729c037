//! Shoots rays exactly at the vertices and edge middles of closed bodies, and counts what goes wrong: `watertight [RAYS]`.
#![expect(clippy::print_stdout, reason = "the counts are the result")]

#[path = "../tests/common/mod.rs"]
mod common;

use common::meshes::{Body, blob, grid_cube, torus};
use common::watertight::{Aim, shoot};
use common::{Random, build, world_of};
use sahl_accel::{Builder, Geometry};

fn main() {
    let rays: u64 = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(10_000_000);
    let bodies = || -> [(Body, Aim, bool); 6] {
        [
            (blob(5), Aim::Targets, false),
            (grid_cube(32), Aim::Targets, false),
            (grid_cube(32), Aim::AxisParallel, false),
            (torus(96, 48), Aim::Targets, false),
            (grid_cube(32), Aim::AxisParallel, true),
            (torus(96, 48), Aim::Targets, true),
        ]
    };
    let scales = [1e-3, 1.0, 1e4];
    let share = rays / (bodies().len() * scales.len()) as u64;
    let mut failures = 0;
    for scale in scales {
        for (body, aim, patches) in bodies() {
            let body = body.scaled(scale);
            let geometry = if patches {
                Geometry::Patches(body.patch_mesh())
            } else {
                Geometry::Triangles(body.triangle_mesh())
            };
            let accel = build(&world_of(vec![geometry]), Builder::BinnedSah);
            let curved = patches && body.name == "torus";
            let tally = shoot(&accel, &body, aim, share, curved, &mut Random(1));
            let kind = if patches { "patches" } else { "triangles" };
            println!("{:9} of {kind:9} at {scale:5}, {aim:?}: {tally:?}", body.name);
            failures += tally.failures();
        }
    }
    println!("{failures} failures");
}
