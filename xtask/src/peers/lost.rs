//! Rays at vertices and at the middles of edges of closed bodies: all must hit, there or before.
//!
//! If all triangles about a vertex or edge clearly turn the same side to the origin of a ray, they cover the place it is aimed at
//! whatever rounding does to it: the ray ends shortly behind its target and must hit all the same. From inside, a ray at any other
//! vertex or edge has no end, and must hit something.

use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use sahl_math::{Bounds3, Ray, Vec3};

use super::models::{Body, lattice};
use super::rays::Random;

/// Rays of a turn of a thread.
const TURN: u64 = 4_096;
/// How much a triangle must face a ray: the cosine. The rounding of a ray moves it by less than this on any triangle.
const FACING: f32 = 0.05;
/// Where rays end that must hit at their target or before, which is at 1: more than rounding can move a hit at that angle.
const END: f32 = 1.0001;
/// Points that are tried before a ray from outside is given up.
const TRIALS: u32 = 1_000;

/// Counts the rays of a slice that hit nothing.
pub(crate) type Tracer<'a> = Box<dyn Fn(&[Ray]) -> u64 + Sync + 'a>;

/// Shoots rays at a body; returns how many, and how many each tracer lost.
///
/// The rays are the same for any number of threads.
pub(crate) fn shoot(body: &Body, count: u64, threads: usize, tracers: &[Tracer<'_>]) -> (u64, Vec<u64>) {
    let range = Range::new(body);
    let (next, shot) = (AtomicU64::new(0), AtomicU64::new(0));
    let lost: Vec<AtomicU64> = tracers.iter().map(|_| AtomicU64::new(0)).collect();
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let turn = next.fetch_add(1, Ordering::Relaxed);
                    if turn * TURN >= count {
                        break;
                    }
                    let mut random = Random::new(turn);
                    let rays = TURN.min(count - turn * TURN);
                    let rays: Vec<Ray> = (0..rays).filter_map(|_| range.ray(&mut random)).collect();
                    shot.fetch_add(rays.len() as u64, Ordering::Relaxed);
                    for (trace, lost) in tracers.iter().zip(&lost) {
                        lost.fetch_add(trace(&rays), Ordering::Relaxed);
                    }
                }
            });
        }
    });
    (shot.into_inner(), lost.into_iter().map(AtomicU64::into_inner).collect())
}

/// A body, and which triangles meet at its vertices.
struct Range<'a> {
    body: &'a Body,
    /// Where the triangles of each vertex begin in `fans`.
    starts: Vec<u32>,
    fans: Vec<u32>,
    center: Vec3,
    radius: f32,
}

impl<'a> Range<'a> {
    fn new(body: &'a Body) -> Self {
        let mut starts = vec![0_u32; body.positions.len() + 1];
        for &vertex in body.triangles.iter().flatten() {
            starts[vertex as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut places = starts.clone();
        let mut fans = vec![0; 3 * body.triangles.len()];
        for (triangle, vertices) in (0..).zip(&body.triangles) {
            for &vertex in vertices {
                fans[places[vertex as usize] as usize] = triangle;
                places[vertex as usize] += 1;
            }
        }
        let bounds = Bounds3::from_points(body.positions.iter().copied());
        let radius = bounds.diagonal().length() * 0.5;
        Self { body, starts, fans, center: bounds.center(), radius }
    }

    /// A ray that must hit: every other one from inside, if it is known where that is. `None` if too many points were looked at in
    /// vain.
    fn ray(&self, random: &mut Random) -> Option<Ray> {
        let from_inside = self.body.inside > 0.0 && random.below(2) == 0;
        let direction = random.direction();
        let origin = if from_inside {
            direction * (self.body.inside * random.unit())
        } else {
            self.center + direction * (2.0 * self.radius)
        };
        let origin = self.body.grid.map_or(origin, |n| lattice::nearest(origin, n));
        (0..TRIALS).find_map(|_| {
            let triangle = self.body.triangles[random.below(self.body.triangles.len())];
            let corner = random.below(3);
            let (a, b) = (triangle[corner], triangle[(corner + 1) % 3]);
            let middle = random.below(2) == 0;
            let p = |vertex: u32| self.body.positions[vertex as usize];
            let target = if middle { (p(a) + p(b)) * 0.5 } else { p(a) };
            let along_axis = self.body.grid.is_some() && random.below(2) == 0;
            let origin = if along_axis { project(origin, target) } else { origin };
            let ray = Ray::new(origin, target - origin);
            let mut fan = self.fan(a).filter(|triangle| !middle || triangle.contains(&b)).map(|t| t.map(p));
            if from_inside {
                let clear = fan.all(|triangle| facing(triangle, origin) < -FACING);
                // On the planes of the faces it is not known what is inside.
                let inside = !along_axis || clear;
                inside.then(|| if clear { ray.with_t_max(END) } else { ray })
            } else {
                fan.all(|triangle| facing(triangle, origin) > FACING).then(|| ray.with_t_max(END))
            }
        })
    }

    /// The triangles about a vertex.
    fn fan(&self, vertex: u32) -> impl Iterator<Item = [u32; 3]> {
        let [from, to] = [0, 1].map(|i| self.starts[vertex as usize + i] as usize);
        self.fans[from..to].iter().map(|&triangle| self.body.triangles[triangle as usize])
    }
}

/// The point moved at right angles to the axis along which the target lies farthest out, so that the way to the target is along it.
fn project(point: Vec3, target: Vec3) -> Vec3 {
    let axis = target.abs().max_axis();
    let mut projected = target;
    projected[axis] = point[axis];
    projected
}

/// The cosine of the angle between a triangle's normal and the way to a point; NaN if there is no angle.
fn facing([a, b, c]: [Vec3; 3], point: Vec3) -> f32 {
    let (n, direction) = ((b - a).cross(c - a), point - a);
    n.dot(direction) / (n.length() * direction.length())
}

#[cfg(test)]
mod tests {
    use super::super::models::bodies;
    use super::*;

    /// Whether a ray meets a triangle before its end, by signed volumes in `f64`, borders included.
    fn meets(ray: &Ray, triangle: [Vec3; 3]) -> bool {
        let double = |v: Vec3| <[f32; 3]>::from(v).map(f64::from);
        let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let volume = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        };
        let d = double(ray.direction);
        let [a, b, c] = triangle.map(|p| minus(double(p), double(ray.origin)));
        let sides = [volume(d, a, b), volume(d, b, c), volume(d, c, a)];
        let inside = sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0);
        let t = volume(a, b, c) / sides.iter().sum::<f64>();
        inside && t > 0.0 && t < f64::from(ray.t_max)
    }

    #[test]
    fn all_rays_hit_and_most_have_an_end() {
        for body in bodies(None).unwrap().into_iter().filter(|body| body.triangles.len() < 20_000) {
            let range = Range::new(&body);
            let mut random = Random::new(5);
            let rays: Vec<Ray> = (0..300).filter_map(|_| range.ray(&mut random)).collect();
            assert_eq!(rays.len(), 300, "{}", body.name);
            assert!(rays.iter().filter(|ray| ray.t_max == END).count() > 200, "{}", body.name);
            for ray in rays {
                let hit = body
                    .triangles
                    .iter()
                    .any(|triangle| meets(&ray, triangle.map(|vertex| body.positions[vertex as usize])));
                assert!(hit, "{}: {ray:?}", body.name);
            }
        }
    }

    #[test]
    fn rays_and_counts_do_not_depend_on_threads() {
        let body = &bodies(None).unwrap()[1];
        let sum = |rays: &[Ray]| rays.iter().map(|ray| u64::from(ray.direction.x.to_bits() & 0xff)).sum();
        let [one, three] = [1, 3].map(|threads| {
            shoot(body, 20_000, threads, &[Box::new(sum), Box::new(|rays: &[Ray]| rays.len() as u64)])
        });
        assert_eq!(one, three);
        assert_eq!((one.0, one.1[1]), (20_000, 20_000));
    }
}
