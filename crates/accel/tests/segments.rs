//! A segment between two surface points hits neither of the surfaces that it joins.

mod common;

use common::meshes::{Body, blob, grid_cube, torus};
use common::{Random, build, world_of};
use sahl_accel::{Accel, Builder, Geometry, Hit, SurfacePoint};
use sahl_math::{Ray, Vec3};

/// A point where a random ray from within the body hits it.
fn surface_point(accel: &Accel, body: &Body, random: &mut Random) -> Option<(Hit, SurfacePoint)> {
    let ray = Ray::new(body.inside[random.below(body.inside.len())], random.direction());
    let hit = accel.intersect(&ray)?;
    Some((hit, accel.surface_point(&ray, &hit)))
}

/// How many of `count` segments there are between two primitives, and how many of these hit one that they start from or lead to.
fn blocked_by_an_end(accel: &Accel, body: &Body, count: u32) -> (u32, u32) {
    let mut random = Random(11);
    let (mut segments, mut blocked) = (0, 0);
    for _ in 0..count {
        let ends = (surface_point(accel, body, &mut random), surface_point(accel, body, &mut random));
        let (Some((first, from)), Some((last, to))) = ends else { continue };
        if first.primitive == last.primitive {
            continue;
        }
        segments += 1;
        let segment = Ray::spawn_to((from.p, from.p_error, from.n), (to.p, to.p_error, to.n));
        let hit = accel.intersect(&segment);
        blocked +=
            u32::from(hit.is_some_and(|hit| [first.primitive, last.primitive].contains(&hit.primitive)));
    }
    (segments, blocked)
}

#[test]
fn no_end_of_a_segment_blocks_it() {
    for scale in [1e-3, 1.0, 1e4] {
        for offset in [0.0, 30.0] {
            for mut body in [blob(4), grid_cube(4), torus(48, 24)].map(|body| body.scaled(scale)) {
                for p in body.positions.iter_mut().chain(&mut body.inside) {
                    *p += Vec3::new(offset, -0.3 * offset, 2.0 * offset) * scale;
                }
                let triangles = world_of(vec![Geometry::Triangles(body.triangle_mesh())]);
                let accel = build(&triangles, Builder::BinnedSah);
                let (segments, blocked) = blocked_by_an_end(&accel, &body, 20_000);
                assert!(segments > 15_000, "{segments} segments");
                assert_eq!(blocked, 0, "{} at scale {scale}, offset {offset}", body.name);
            }
        }
    }
}
