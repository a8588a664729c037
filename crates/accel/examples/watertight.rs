//! Shoots rays exactly at the vertices and edges of closed bodies, and counts what goes wrong on every tier by every query:
//! `watertight [RAYS]`.
#![expect(clippy::print_stdout, reason = "the counts are the result")]

#[path = "../tests/common/mod.rs"]
mod common;

use common::agreement::tiers;
use common::meshes::{Body, blob, grid_cube, torus};
use common::watertight::{Aim, Queries, Tally, Volley, shoot};
use common::{Random, world_of};
use sahl_accel::{Accel, BuildOptions, Geometry, World};
use sahl_math::Vec3;

/// A body with how it is shot at.
struct Trial {
    body: Body,
    aim: Aim,
    patches: bool,
}

fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    let mut add = |body: Body, aim, patches| trials.push(Trial { body, aim, patches });
    for scale in [1e-3, 1.0, 1e4] {
        for patches in [false, true] {
            add(torus(96, 48).scaled(scale), Aim::Targets, patches);
            for aim in [Aim::Targets, Aim::AxisParallel, Aim::GridLines] {
                add(grid_cube(32).scaled(scale), aim, patches);
            }
        }
        add(blob(5).scaled(scale), Aim::Targets, false);
    }
    for distance in [1e3, 1e5] {
        let offset = Vec3::new(1.0, -0.75, 0.5) * distance;
        add(torus(12, 6).moved(offset), Aim::Targets, false);
        add(blob(1).moved(offset), Aim::Targets, false);
        add(grid_cube(8).moved(offset), Aim::GridLines, false);
    }
    trials
}

fn world(trial: &Trial) -> World {
    world_of(vec![if trial.patches {
        Geometry::Patches(trial.body.patch_mesh())
    } else {
        Geometry::Triangles(trial.body.triangle_mesh())
    }])
}

fn main() {
    let rays: u64 = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(10_000_000);
    let trials = trials();
    let share = rays.div_ceil((trials.len() * tiers().count() * Queries::ALL.len()) as u64);
    let mut total = Tally::default();
    for tier in tiers() {
        let mut tallies = [Tally::default(); Queries::ALL.len()];
        for trial in &trials {
            let options = BuildOptions { tier: Some(tier), ..BuildOptions::default() };
            let accel = Accel::build(world(trial), &options);
            for (queries, tally) in Queries::ALL.into_iter().zip(&mut tallies) {
                let volley = Volley { aim: trial.aim, queries, time: 0.0, count: share };
                let shot = shoot(&accel, &trial.body, &volley, &mut Random(1));
                if shot.failures() > 0 {
                    println!("{} about {:?}, {volley:?}: {shot:?}", trial.body.name, trial.body.center);
                }
                tally.add(&shot);
            }
        }
        for (queries, tally) in Queries::ALL.into_iter().zip(tallies) {
            println!("{:7} {:9} {tally:?}", format!("{tier:?}"), format!("{queries:?}"));
            total.add(&tally);
        }
    }
    println!("{} failures in {} rays and the four that each spawns", total.failures(), total.rays);
}
