//! After edits the hits are those of a new build.

mod common;

use common::agreement::{check_queries, every_accel, tiers};
use common::meshes::torus;
use common::moving::{at_any_time, motion, moving_zoo};
use common::worlds::{nasty_rays, placement, rays, rays_at, soup};
use common::{Random, build, world_of};
use sahl_accel::{
    Accel, BuildOptions, Builder, Edit, Geometry, Hit, Instance, PatchMesh, Refit, Stats, TriangleMesh,
    UnfitEdit, World,
};
use sahl_math::{Ray, Transform, Vec3};

/// The world after edits that fit.
fn edited(world: &World, edits: &[Edit]) -> World {
    let mut world = world.clone();
    for edit in edits.iter().cloned() {
        match edit {
            Edit::Positions { geometry, positions } => match &mut world.geometries[geometry as usize] {
                Geometry::Triangles(mesh) => mesh.positions = positions,
                Geometry::Patches(mesh) => mesh.positions = positions,
                other => panic!("{other:?}"),
            },
            Edit::MovingPositions { geometry, positions } => match &mut world.geometries[geometry as usize] {
                Geometry::MovingTriangles(mesh) => mesh.positions = positions,
                other => panic!("{other:?}"),
            },
            Edit::Placement { instance, to_world } => world.instances[instance as usize].to_world = to_world,
        }
    }
    world
}

/// The counts, which do not depend on the shape of the trees.
fn counts(stats: Stats) -> (u64, u64) {
    (stats.primitives, stats.dropped)
}

/// Makes rounds of edits on every tree on every tier, and compares with brute force after each; returns what came of them.
fn check(world: &World, rounds: &[Vec<Edit>], rays: &[Ray]) -> Vec<Refit> {
    let mut worlds = vec![world.clone()];
    for round in rounds {
        worlds.push(edited(&worlds[worlds.len() - 1], round));
    }
    let oracles: Vec<Accel> = worlds.iter().map(|world| build(world, Builder::BruteForce)).collect();
    let expected: Vec<Vec<Option<Hit>>> =
        oracles.iter().map(|oracle| rays.iter().map(|ray| oracle.intersect(ray)).collect()).collect();
    let mut outcomes = Vec::new();
    for (options, mut accel) in every_accel(world) {
        for (round, edits) in rounds.iter().enumerate() {
            let outcome = accel.refit(edits.clone()).expect("edits that fit");
            let context = format!("{options:?}, round {round}, {outcome:?}");
            let oracle = &oracles[round + 1];
            assert_eq!(accel.bounds(), oracle.bounds(), "{context}");
            assert_eq!(counts(accel.stats()), counts(oracle.stats()), "{context}");
            check_queries(&context, &accel, rays, &expected[round + 1]);
            assert!(outcome.cost_ratio >= 0.0 && outcome.cost_ratio.is_finite(), "{context}");
            outcomes.push(outcome);
        }
    }
    outcomes
}

fn positions_of(world: &World, geometry: u32) -> Vec<Vec3> {
    match &world.geometries[geometry as usize] {
        Geometry::Triangles(mesh) => mesh.positions.to_vec(),
        Geometry::Patches(mesh) => mesh.positions.to_vec(),
        Geometry::MovingTriangles(mesh) => mesh.positions[0].to_vec(),
        other => panic!("{other:?}"),
    }
}

fn jittered(random: &mut Random, positions: &[Vec3], by: f32) -> Vec<Vec3> {
    positions.iter().map(|&p| p + random.point(by)).collect()
}

#[test]
fn meshes_that_are_bent_and_scattered() {
    let mut random = Random(400);
    let geometries = vec![
        Geometry::Triangles(torus(24, 12).triangle_mesh()),
        Geometry::Triangles(soup(&mut random, 300, 0.3)),
    ];
    let world = world_of(geometries);
    let edit = |geometry, positions: Vec<Vec3>| Edit::Positions { geometry, positions: positions.into() };
    let bent = jittered(&mut random, &positions_of(&world, 0), 0.05);
    let scattered = jittered(&mut random, &positions_of(&world, 1), 3.0);
    let rounds = [
        vec![edit(0, bent)],
        vec![edit(1, scattered), edit(0, positions_of(&world, 0))],
        vec![edit(1, positions_of(&world, 1))],
    ];
    let mut all = rays(&mut random, 500, 2.0);
    all.extend(nasty_rays(&mut random, 100, 2.0));
    if let Geometry::Triangles(mesh) = &world.geometries[0] {
        all.extend(rays_at(&mut random, mesh, 300, 2.0));
    }
    let outcomes = check(&world, &rounds, &all);
    assert!(outcomes.iter().all(|outcome| !outcome.rebuilt));
    // Scattering makes the trees worse, and going back makes them as good as they were, but for cuts.
    for rounds in outcomes.chunks(3) {
        assert!(rounds[1].cost_ratio > 1.3, "{rounds:?}");
        assert!(rounds[2].cost_ratio < rounds[1].cost_ratio.min(2.0), "{rounds:?}");
    }
}

#[test]
fn everything_at_once() {
    let mut random = Random(410);
    let world = moving_zoo(&mut random);
    // The patches stay of their kinds: of these, only the flat ones are moved, as a whole.
    let moved =
        |positions: Vec<Vec3>, by: Vec3| -> Vec<Vec3> { positions.into_iter().map(|p| p + by).collect() };
    let mut rounds = Vec::new();
    for round in 0..3 {
        let mut edits = Vec::new();
        for (geometry, shape) in (0..).zip(&world.geometries) {
            let positions = |random: &mut Random| jittered(random, &positions_of(&world, geometry), 0.3);
            match shape {
                Geometry::Triangles(_) => {
                    edits.push(Edit::Positions { geometry, positions: positions(&mut random).into() });
                }
                Geometry::Patches(_) => {
                    let positions = moved(positions_of(&world, geometry), Vec3::new(0.25, 0.5, -0.25));
                    edits.push(Edit::Positions { geometry, positions: positions.into() });
                }
                Geometry::MovingTriangles(_) => edits.push(Edit::MovingPositions {
                    geometry,
                    positions: [positions(&mut random).into(), positions(&mut random).into()],
                }),
                _ => {}
            }
        }
        for instance in (0..world.instances.len() as u32).skip(round).step_by(2) {
            // What stood still may move, and the other way round.
            let to_world =
                if random.below(2) == 0 { placement(&mut random).into() } else { motion(&mut random).into() };
            edits.push(Edit::Placement { instance, to_world });
        }
        rounds.push(edits);
    }
    // Each by itself as well.
    rounds.extend(rounds[0].clone().into_iter().map(|edit| vec![edit]).take(4));
    let all = rays(&mut random, 400, 2.0);
    check(&world, &rounds, &at_any_time(&mut random, all));
}

#[test]
fn what_is_edited_away_hits_nothing_and_may_come_back() {
    let mut random = Random(420);
    let world = world_of(vec![Geometry::Triangles(soup(&mut random, 120, 0.5))]);
    let good = positions_of(&world, 0);
    let mut bad = good.clone();
    for (i, p) in bad.iter_mut().enumerate() {
        match i % 12 {
            0 => p.x = f32::NAN,
            3 => p.y = f32::INFINITY,
            6 => p.z = 1e30,
            _ => {}
        }
        if i % 36 < 9 {
            *p = Vec3::ONE;
        }
    }
    let edit = |positions: &[Vec3]| vec![Edit::Positions { geometry: 0, positions: positions.into() }];
    let nothing = vec![Vec3::splat(f32::NAN); good.len()];
    let rounds = [edit(&bad), edit(&good), edit(&nothing), edit(&good[..100]), edit(&good)];
    let all = rays(&mut random, 400, 1.5);
    let outcomes = check(&world, &rounds, &all);
    assert!(outcomes.iter().all(|outcome| !outcome.rebuilt));
}

#[test]
fn what_stands_in_no_tree_makes_a_new_build() {
    let mut random = Random(430);
    let all = rays(&mut random, 300, 1.5);
    let good = soup(&mut random, 60, 0.5);
    let mut bad = good.positions.to_vec();
    bad[30] = Vec3::splat(f32::NAN);
    let mesh = TriangleMesh { indices: good.indices.clone(), positions: bad.into() };
    let back = vec![Edit::Positions { geometry: 0, positions: good.positions.clone() }];
    let outcomes = check(&world_of(vec![Geometry::Triangles(mesh)]), &[back.clone(), back], &all);
    for rounds in outcomes.chunks(2) {
        assert_eq!((rounds[0].rebuilt, rounds[1].rebuilt), (true, false));
    }
    // A flat patch that becomes curved.
    let flat = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X + Vec3::Y];
    let patches = PatchMesh { indices: [[0, 1, 2, 3]].into(), positions: flat.into() };
    let curved = [flat[0], flat[1], flat[2], flat[3] + Vec3::Z];
    let moved = flat.map(|p| p * 2.0 - Vec3::ONE);
    let edit = |positions: [Vec3; 4]| vec![Edit::Positions { geometry: 0, positions: positions.into() }];
    let rounds = [edit(moved), edit(curved), edit(curved.map(|p| p - Vec3::Z))];
    let outcomes = check(&world_of(vec![Geometry::Patches(patches)]), &rounds, &all);
    for rounds in outcomes.chunks(3) {
        assert_eq!([0, 1, 2].map(|i| rounds[i].rebuilt), [false, true, false]);
    }
    // An instance too far away that comes near, and goes.
    let far = Transform::translate(1e30, 0.0, 0.0).unwrap();
    let world = World {
        groups: vec![vec![0]],
        instances: vec![Instance { group: 0, to_world: far.into() }],
        ..world_of(vec![Geometry::Triangles(good)])
    };
    let to = |to_world: Transform| vec![Edit::Placement { instance: 0, to_world: to_world.into() }];
    let near = Transform::translate(0.5, 0.0, 0.0).unwrap();
    let outcomes = check(&world, &[to(near), to(far), to(near)], &all);
    for rounds in outcomes.chunks(3) {
        assert_eq!([0, 1, 2].map(|i| rounds[i].rebuilt), [true, false, false]);
    }
}

#[test]
fn edits_that_do_not_fit_change_nothing() {
    let mut random = Random(440);
    let world = moving_zoo(&mut random);
    let mesh = (world.geometries.len() - 1) as u32;
    let positions: std::sync::Arc<[Vec3]> = [Vec3::ZERO].into();
    let fits = Edit::Placement { instance: 0, to_world: Transform::IDENTITY.into() };
    let rays = rays(&mut random, 200, 1.5);
    for builder in [Builder::BinnedSah, Builder::BruteForce] {
        let mut accel = build(&world, builder);
        let before: Vec<Option<Hit>> = rays.iter().map(|ray| accel.intersect(ray)).collect();
        for unfit in [
            Edit::Positions { geometry: 0, positions: positions.clone() },
            Edit::Positions { geometry: 999, positions: positions.clone() },
            Edit::Positions { geometry: mesh, positions: positions.clone() },
            Edit::MovingPositions { geometry: 24, positions: [positions.clone(), positions.clone()] },
            Edit::Placement { instance: 99, to_world: Transform::IDENTITY.into() },
        ] {
            assert_eq!(accel.refit(vec![fits.clone(), unfit]), Err(UnfitEdit { place: 1 }));
        }
        assert!(rays.iter().zip(&before).all(|(ray, hit)| accel.intersect(ray) == *hit));
        assert_eq!(accel.refit(Vec::new()).map(|refit| refit.cost_ratio), Ok(1.0));
    }
}

#[test]
fn a_tree_that_is_not_cut_costs_what_it_did() {
    // Large enough for several threads.
    let body = torus(400, 200);
    let world = world_of(vec![Geometry::Triangles(body.triangle_mesh())]);
    for tier in tiers() {
        let options = BuildOptions { builder: Builder::Fast, tier: Some(tier), ..BuildOptions::default() };
        let mut accel = Accel::build(world.clone(), &options);
        let (stats, bounds) = (accel.stats(), accel.bounds());
        let edit = Edit::Positions { geometry: 0, positions: body.positions.as_slice().into() };
        let refit = accel.refit(vec![edit]).unwrap();
        assert!((refit.cost_ratio - 1.0).abs() < 1e-2, "{refit:?}");
        assert_eq!((accel.bounds(), Stats { sah_cost: stats.sah_cost, ..accel.stats() }), (bounds, stats));
    }
}
