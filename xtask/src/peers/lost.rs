//! Rays at vertices and at the middles of edges of closed bodies: all must hit.
//!
//! From inside every ray hits. From outside a ray hits if all triangles about the vertex or edge face it: whatever rounding does
//! to the ray, it meets one of them or something in front.

use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use sahl_math::{Bounds3, Ray, Vec3};

use super::models::Body;
use super::rays::Random;

/// Rays of a turn of a thread.
const TURN: u64 = 4_096;
/// How much a triangle must face a ray: the cosine. The rounding of a ray moves it by less than this on any triangle.
const FACING: f32 = 0.05;
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
        let origin = if self.body.on_grid { origin.map(|x| (x * 16.0).round() / 16.0) } else { origin };
        (0..TRIALS).find_map(|_| {
            let triangle = self.body.triangles[random.below(self.body.triangles.len())];
            let corner = random.below(3);
            let (a, b) = (triangle[corner], triangle[(corner + 1) % 3]);
            let middle = random.below(2) == 0;
            let p = |vertex: u32| self.body.positions[vertex as usize];
            let target = if middle { (p(a) + p(b)) * 0.5 } else { p(a) };
            let mut fan = self.fan(a).filter(|triangle| !middle || triangle.contains(&b));
            let seen = from_inside || fan.all(|triangle| faces(triangle.map(p), origin));
            seen.then(|| Ray::new(origin, target - origin))
        })
    }

    /// The triangles about a vertex.
    fn fan(&self, vertex: u32) -> impl Iterator<Item = [u32; 3]> {
        let [from, to] = [0, 1].map(|i| self.starts[vertex as usize + i] as usize);
        self.fans[from..to].iter().map(|&triangle| self.body.triangles[triangle as usize])
    }
}

/// Whether a triangle clearly turns its outer side to a point.
fn faces([a, b, c]: [Vec3; 3], point: Vec3) -> bool {
    let (n, direction) = ((b - a).cross(c - a), point - a);
    n.dot(direction) > FACING * n.length() * direction.length()
}

#[cfg(test)]
mod tests {
    use super::super::models::bodies;
    use super::*;

    /// Whether a ray meets a triangle, by signed volumes in `f64`, borders included.
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
        inside && volume(a, b, c) * sides.iter().sum::<f64>() > 0.0
    }

    #[test]
    fn all_rays_hit() {
        for body in bodies(None).unwrap().into_iter().filter(|body| body.triangles.len() < 20_000) {
            let range = Range::new(&body);
            let mut random = Random::new(5);
            for _ in 0..300 {
                let ray = range.ray(&mut random).unwrap();
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
