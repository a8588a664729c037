//! Rays at the vertices and edges of closed bodies: none may get out, none may hit the surface it starts from.

use sahl_accel::{Accel, Hit};
use sahl_math::{Ray, Vec3};

use super::Random;
use super::meshes::Body;

/// What went wrong, and how much was tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub(crate) rays: u64,
    /// Rays from inside that hit nothing.
    pub(crate) escaped: u64,
    /// Rays spawned from a hit that hit the same primitive again, where they started.
    pub(crate) hit_origin: u64,
    /// Rays spawned from a hit back to the inside that hit nothing.
    pub(crate) leaked_back: u64,
}

impl Tally {
    pub(crate) fn failures(&self) -> u64 {
        self.escaped + self.hit_origin + self.leaked_back
    }
}

/// How the rays are aimed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Aim {
    /// From points inside exactly at vertices and edge middles.
    Targets,
    /// Along the axes, through points that share two coordinates with a vertex or edge middle; for bodies that hold the
    /// segment from the origin of all rays, a point inside, to the target's projection: the cube.
    AxisParallel,
}

/// Shoots `count` primary rays, each followed by spawned ones, in a world that consists of the body.
///
/// `curved` says that a primitive may meet a straight ray twice, so that only hits next to the origin are wrong.
pub(crate) fn shoot(
    accel: &Accel,
    body: &Body,
    aim: Aim,
    count: u64,
    curved: bool,
    random: &mut Random,
) -> Tally {
    let targets = body.targets();
    let mut tally = Tally::default();
    for _ in 0..count {
        let target = targets[random.below(targets.len())];
        let mut origin = body.inside[random.below(body.inside.len())];
        let mut direction = target - origin;
        if aim == Aim::AxisParallel {
            let axis = target.max_axis();
            (origin[(axis + 1) % 3], origin[(axis + 2) % 3]) =
                (target[(axis + 1) % 3], target[(axis + 2) % 3]);
            direction = Vec3::ZERO;
            direction[axis] = target[axis].signum() * random.range(0.1, 3.0);
            // A border of the face lies in the plane of another face, from which no inside can be told.
            if origin.abs().max_component() >= target.abs().max_component() {
                continue;
            }
        }
        tally.rays += 1;
        let ray = Ray::new(origin, direction);
        let Some(hit) = accel.intersect(&ray) else {
            tally.escaped += 1;
            continue;
        };
        follow(accel, &ray, &hit, curved, random, &mut tally);
    }
    tally
}

/// Spawns rays from a hit: onwards, back, and in random directions on both sides.
fn follow(accel: &Accel, ray: &Ray, hit: &Hit, curved: bool, random: &mut Random, tally: &mut Tally) {
    let point = accel.surface_point(ray, hit);
    let spawn = |direction: Vec3| Ray::spawn(point.p, point.p_error, point.n, direction);
    let back = spawn(ray.origin - point.p);
    tally.leaked_back += u64::from(accel.intersect(&back).is_none());
    let reflected = ray.direction - point.n * (2.0 * ray.direction.dot(point.n));
    for spawned in [back, spawn(ray.direction), spawn(reflected), spawn(random.direction())] {
        let Some(next) = accel.intersect(&spawned) else { continue };
        let same =
            (next.instance, next.geometry, next.primitive) == (hit.instance, hit.geometry, hit.primitive);
        let distance = next.t * spawned.direction.length();
        let close = distance <= 1e-4 * (ray.origin - point.p).length();
        tally.hit_origin += u64::from(same && (close || !curved));
    }
}
