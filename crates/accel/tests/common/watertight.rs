//! Rays at the vertices and edges of closed bodies: none may get out, none may hit the surface it starts from.

use sahl_accel::{Accel, Geometry, Hit};
use sahl_math::{Ray, Vec3, solve_quadratic};

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
    /// When all rays are there.
    pub(crate) time: f32,
    /// How many primary rays, each followed by four spawned ones; somewhat fewer where the aim leaves some out.
    pub(crate) count: u64,
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
        follow(accel, (&rays, &hits), volley, random, &mut tally);
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
        rays.extend(aimed(body, volley.aim, origin, target, random).map(|ray| ray.with_time(volley.time)));
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
    (rays, hits): (&[Ray], &[Option<Hit>]),
    volley: &Volley,
    random: &mut Random,
    tally: &mut Tally,
) {
    let mut spawned = [const { Vec::new() }; 4];
    let mut sources = Vec::with_capacity(rays.len());
    for (ray, hit) in rays.iter().zip(hits) {
        let Some(hit) = hit else { continue };
        let point = accel.surface_point(ray, hit);
        let spawn =
            |direction: Vec3| Ray::spawn(point.p, point.p_error, point.n, direction).with_time(ray.time);
        let reflected = ray.direction - point.n * (2.0 * ray.direction.dot(point.n));
        let directions = [ray.origin - point.p, ray.direction, reflected, random.direction()];
        for (rays, direction) in spawned.iter_mut().zip(directions) {
            rays.push(spawn(direction));
        }
        sources.push(hit);
    }
    for (kind, rays) in spawned.iter().enumerate() {
        let next = volley.queries.nearest(accel, rays);
        for ((ray, next), hit) in rays.iter().zip(next).zip(&sources) {
            match next {
                Some(next) => tally.hit_origin += u64::from(is_own_origin(accel, ray, hit, &next)),
                None => tally.leaked_back += u64::from(kind == 0),
            }
        }
    }
}

/// Whether a ray that was spawned from a hit wrongly hits what it was spawned from.
pub(crate) fn is_own_origin(accel: &Accel, ray: &Ray, hit: &Hit, next: &Hit) -> bool {
    let name = |hit: &Hit| (hit.instance, hit.geometry, hit.primitive);
    if name(next) != name(hit) {
        return false;
    }
    // Only a patch that is not flat may meet a straight ray twice.
    match accel.geometry(hit.geometry) {
        Geometry::Patches(mesh) if hit.instance == Hit::NO_INSTANCE => {
            let corners = mesh.indices[hit.primitive as usize].map(|index| mesh.positions[index as usize]);
            !meets_again(&corners, ray, next.t)
        }
        _ => true,
    }
}

/// Whether a ray that starts next to a patch, on the side to which it goes, crosses it at `t`: by `f64`, in coordinates in which
/// the patch is `z = x y`.
fn meets_again(corners: &[Vec3; 4], ray: &Ray, t: f32) -> bool {
    let double = |v: Vec3| [v.x, v.y, v.z].map(f64::from);
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let [p00, p10, p01, p11] = corners.map(double);
    let (a, b) = (minus(p10, p00), minus(p01, p00));
    let twist = minus(minus(p11, p10), b);
    // A flat patch has no such coordinates: they are not finite, and no comparison holds.
    let volume = dot(a, cross(b, twist));
    let coordinates = |v: [f64; 3]| {
        [dot(v, cross(b, twist)), dot(v, cross(twist, a)), dot(v, cross(a, b))].map(|x| x / volume)
    };
    let [x, y, z] = coordinates(minus(double(ray.origin), p00));
    let [dx, dy, dz] = coordinates(double(ray.direction));
    let (c0, c1, c2) = (x * y - z, x * dy + dx * y - dz, dx * dy);
    // How far it is off the surface grows at first.
    let starts_outside = c0 * c1 > 0.0;
    let t = f64::from(t);
    let is_root = |root: f64| (root - t).abs() <= 1e-3 * t;
    starts_outside && solve_quadratic(c2, c1, c0).is_some_and(|(low, high)| is_root(low) || is_root(high))
}
