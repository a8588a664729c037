//! Rays at the vertices and edges of closed bodies: none may get out, none may hit the surface it starts from.

use sahl_accel::{Accel, Hit};
use sahl_math::{Ray, Vec3};

use super::Random;
use super::meshes::Body;

/// Rays that are asked together.
const CHUNK: usize = 128;

/// What went wrong, and how much was tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub(crate) rays: u64,
    /// Rays from inside that hit nothing.
    pub(crate) escaped: u64,
    /// Rays from inside that nothing occludes.
    pub(crate) unoccluded: u64,
    /// Rays spawned from a hit that hit the same primitive again, where they started.
    pub(crate) hit_origin: u64,
    /// Rays spawned from a hit back to the inside that hit nothing.
    pub(crate) leaked_back: u64,
}

impl Tally {
    pub(crate) fn failures(&self) -> u64 {
        self.escaped + self.unoccluded + self.hit_origin + self.leaked_back
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.rays += other.rays;
        self.escaped += other.escaped;
        self.unoccluded += other.unoccluded;
        self.hit_origin += other.hit_origin;
        self.leaked_back += other.leaked_back;
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
    /// In planes across an axis through vertices and edge middles, so that they meet the cube on lines of its grid.
    GridLines,
}

/// By which queries the rays are answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Queries {
    /// One ray at a time.
    Single,
    /// [`Accel::intersect_batch`] and [`Accel::occluded_batch`].
    Batch,
    /// [`Accel::intersect_coherent`]; each 64 rays start at one point and go to neighbouring targets.
    Coherent,
}

impl Queries {
    pub(crate) const ALL: [Self; 3] = [Self::Single, Self::Batch, Self::Coherent];

    fn nearest(self, accel: &Accel, rays: &[Ray]) -> Vec<Option<Hit>> {
        let mut hits = vec![None; rays.len()];
        match self {
            Self::Single => hits = rays.iter().map(|ray| accel.intersect(ray)).collect(),
            Self::Batch => accel.intersect_batch(rays, &mut hits),
            Self::Coherent => accel.intersect_coherent(rays, &mut hits),
        }
        hits
    }

    fn unoccluded(self, accel: &Accel, rays: &[Ray]) -> u64 {
        let mut occluded = vec![false; rays.len()];
        if self == Self::Single {
            occluded = rays.iter().map(|ray| accel.occluded(ray)).collect();
        } else {
            accel.occluded_batch(rays, &mut occluded);
        }
        occluded.iter().filter(|&&is| !is).count() as u64
    }
}

/// What is shot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Volley {
    pub(crate) aim: Aim,
    pub(crate) queries: Queries,
    /// How many primary rays, each followed by four spawned ones; somewhat fewer where the aim leaves some out.
    pub(crate) count: u64,
    /// A primitive may meet a straight ray twice, so that only hits next to the origin are wrong.
    pub(crate) curved: bool,
}

/// Shoots a volley in a world that consists of the body.
pub(crate) fn shoot(accel: &Accel, body: &Body, volley: &Volley, random: &mut Random) -> Tally {
    let targets = body.targets();
    let mut tally = Tally::default();
    let mut shot = 0;
    while shot < volley.count {
        let count = CHUNK.min((volley.count - shot) as usize);
        shot += count as u64;
        let rays = primary_rays(body, &targets, (volley, count), random);
        tally.rays += rays.len() as u64;
        tally.unoccluded += volley.queries.unoccluded(accel, &rays);
        let hits = volley.queries.nearest(accel, &rays);
        tally.escaped += hits.iter().filter(|hit| hit.is_none()).count() as u64;
        follow(accel, &rays, &hits, volley, random, &mut tally);
    }
    tally
}

fn primary_rays(
    body: &Body,
    targets: &[Vec3],
    (volley, count): (&Volley, usize),
    random: &mut Random,
) -> Vec<Ray> {
    let mut rays = Vec::with_capacity(count);
    let (mut first, mut origin) = (0, Vec3::ZERO);
    for i in 0..count {
        if volley.queries != Queries::Coherent || i % 64 == 0 {
            first = random.below(targets.len());
            origin = body.inside[random.below(body.inside.len())];
        }
        let target = targets[(first + i % 64) % targets.len()];
        rays.extend(aimed(body, volley.aim, origin, target, random));
    }
    rays
}

/// A ray from a point inside at a target; `None` if the aim does not allow it.
fn aimed(body: &Body, aim: Aim, mut origin: Vec3, target: Vec3, random: &mut Random) -> Option<Ray> {
    let outwards = target - body.center;
    let axis = outwards.max_axis();
    let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
    match aim {
        Aim::Targets => return Some(Ray::new(origin, target - origin)),
        Aim::AxisParallel => (origin[second], origin[third]) = (target[second], target[third]),
        Aim::GridLines => origin[second] = target[second],
    }
    // A border of the face lies in the plane of another face, from which no inside can be told.
    if (origin - body.center).abs().max_component() >= outwards.abs().max_component() {
        return None;
    }
    let direction = if aim == Aim::AxisParallel {
        let mut direction = Vec3::ZERO;
        direction[axis] = outwards[axis].signum() * random.range(0.1, 3.0);
        direction
    } else {
        target - origin
    };
    Some(Ray::new(origin, direction))
}

/// Spawns rays from hits: onwards, back, and in random directions on both sides.
fn follow(
    accel: &Accel,
    rays: &[Ray],
    hits: &[Option<Hit>],
    volley: &Volley,
    random: &mut Random,
    tally: &mut Tally,
) {
    let mut spawned = [const { Vec::new() }; 4];
    let mut sources = Vec::with_capacity(rays.len());
    for (ray, hit) in rays.iter().zip(hits) {
        let Some(hit) = hit else { continue };
        let point = accel.surface_point(ray, hit);
        let spawn = |direction: Vec3| Ray::spawn(point.p, point.p_error, point.n, direction);
        let reflected = ray.direction - point.n * (2.0 * ray.direction.dot(point.n));
        let directions = [ray.origin - point.p, ray.direction, reflected, random.direction()];
        for (rays, direction) in spawned.iter_mut().zip(directions) {
            rays.push(spawn(direction));
        }
        sources.push((hit, (ray.origin - point.p).length()));
    }
    for (kind, rays) in spawned.iter().enumerate() {
        let next = volley.queries.nearest(accel, rays);
        for ((ray, next), (hit, distance)) in rays.iter().zip(next).zip(&sources) {
            let Some(next) = next else {
                tally.leaked_back += u64::from(kind == 0);
                continue;
            };
            let same =
                (next.instance, next.geometry, next.primitive) == (hit.instance, hit.geometry, hit.primitive);
            let close = next.t * ray.direction.length() <= 1e-4 * distance;
            tally.hit_origin += u64::from(same && (close || !volley.curved));
        }
    }
}
