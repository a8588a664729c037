//! Nodes and blocks against one ray.

use sahl_math::{Ray, Vec3};

use super::super::isa::{Isa, Lanes, Row, Task};
use super::super::watertight::BlockHit;
use super::super::{
    BLOCK_ROWS, BLOCK_WIDTH, Crossed, EMPTY_BLOCK, EXIT_WIDENING, NODE_ROWS, Node, PreparedRay,
    TriangleBlock, WIDTH, set_triangle,
};
use super::{Random, agreed, bits};
use crate::geometry::triangle;

#[derive(Clone, Copy)]
struct NodeInterval<'a> {
    node: &'a [Row; NODE_ROWS],
    ray: &'a Ray,
    reach: f32,
}

/// Where each box is entered and left.
type Intervals = [[u32; WIDTH]; 2];

impl Task for NodeInterval<'_> {
    type Output = Intervals;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Intervals {
        let found = Node(self.node).interval(isa, &PreparedRay::of_usable(self.ray), self.reach);
        [found.enter.to_array().map(bits), found.exit.to_array().map(bits)]
    }
}

/// A node of boxes with these coordinates; inverted where they are not in order.
pub(super) fn node(random: &mut Random, mut coordinate: impl FnMut(&mut Random) -> f32) -> [Row; NODE_ROWS] {
    let mut rows = [Row::splat(0.0); NODE_ROWS];
    for lane in 0..WIDTH {
        let (p, q) = (random.vector(&mut coordinate), random.vector(&mut coordinate));
        for axis in 0..3 {
            (rows[axis].0[lane], rows[axis + 3].0[lane]) = (p[axis].min(q[axis]), p[axis].max(q[axis]));
        }
        rows[6].0[lane] = f32::from_bits(random.bits() as u32);
    }
    rows
}

#[test]
fn intervals_of_nasty_boxes_agree() {
    let mut random = Random(11);
    for _ in 0..20_000 {
        let node = node(&mut random, Random::nasty);
        let origin = random.vector(Random::nasty);
        let direction = random.vector(Random::nasty);
        let ray = Ray { t_min: random.nasty(), ..Ray::new(origin, direction) };
        let reach = random.nasty();
        agreed(&NodeInterval { node: &node, ray: &ray, reach }, &format!("{ray:?}"));
    }
}

/// The parameters between which a ray is in a box, in double precision; an empty interval if it misses it.
fn exact_interval(node: &[Row; NODE_ROWS], lane: usize, ray: &Ray) -> [f64; 2] {
    let [mut enter, mut exit] = [f64::from(ray.t_min), f64::from(ray.t_max)];
    for axis in 0..3 {
        let relative = |row: usize| f64::from(node[row].0[lane]) - f64::from(ray.origin[axis]);
        let (low, high, d) = (relative(axis), relative(axis + 3), f64::from(ray.direction[axis]));
        if d == 0.0 {
            if low > 0.0 || high < 0.0 {
                return [1.0, 0.0];
            }
            continue;
        }
        let (p, q) = (low / d, high / d);
        (enter, exit) = (enter.max(p.min(q)), exit.min(p.max(q)));
    }
    [enter, exit]
}

#[test]
fn a_box_that_is_met_is_never_missed() {
    let mut random = Random(12);
    let (mut met, mut missed) = (0, 0);
    for i in 0..20_000 {
        let scale = 10.0_f32.powi(i % 13 - 6);
        let grid = i % 2 == 0;
        let mut coordinate =
            move |random: &mut Random| scale * if grid { random.on_grid() } else { random.signed() };
        let node = node(&mut random, &mut coordinate);
        let origin = random.vector(&mut coordinate);
        let mut direction = random.vector(&mut coordinate);
        if i % 3 == 0 {
            // At the corner of a box.
            let corner = [0, 1, 2].map(|axis| node[axis + 3 * random.below(2)].0[random.below(WIDTH)]);
            direction = Vec3::from(corner) - origin;
        }
        if direction == Vec3::ZERO {
            continue;
        }
        let ray = Ray { t_max: if i % 5 == 0 { 1.0 } else { 1e30 }, ..Ray::new(origin, direction) };
        let reach = ray.t_max * EXIT_WIDENING;
        let [enter, exit] = agreed(&NodeInterval { node: &node, ray: &ray, reach }, "")
            .map(|lanes| lanes.map(f32::from_bits));
        for lane in 0..WIDTH {
            let [exact_enter, exact_exit] = exact_interval(&node, lane, &ray);
            let is_met = enter[lane] <= exit[lane];
            assert!(is_met || exact_enter > exact_exit, "{ray:?} misses box {lane} of {node:?}");
            met += u32::from(is_met);
            missed += u32::from(!is_met);
        }
    }
    assert!(met > 10_000 && missed > 10_000, "{met} met, {missed} missed");
}

#[derive(Clone, Copy)]
struct BlockHits<'a> {
    block: &'a [Row; BLOCK_ROWS],
    ray: &'a Ray,
    limit: f32,
    /// How many hits are taken before the query is told to end.
    wanted: usize,
}

/// Id and bits of parameter and weights.
type HitBits = [u32; 4];

fn hit_bits(hit: &BlockHit) -> HitBits {
    [hit.id, hit.t.to_bits(), hit.b1.to_bits(), hit.b2.to_bits()]
}

impl Task for BlockHits<'_> {
    type Output = (Vec<HitBits>, bool);

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Self::Output {
        let (block, ray) = (TriangleBlock(self.block), PreparedRay::of_usable(self.ray));
        let mut hits = Vec::new();
        let ended = block.intersect(isa, &ray, self.limit, |hit| {
            hits.push(hit_bits(&hit));
            hits.len() == self.wanted
        });
        // In two steps, as batches do.
        let (mut again, mut crossed) = (Vec::new(), Crossed::NONE);
        let ended_again = block.cross(isa, &ray, &mut crossed)
            && block.intersect_crossed(isa, &ray, (&crossed, self.limit), |hit| {
                again.push(hit_bits(&hit));
                again.len() == self.wanted
            });
        assert_eq!((&again, ended_again), (&hits, ended));
        (hits, ended)
    }
}

/// A block of up to eight triangles, the rest of which is padding.
pub(super) fn block(triangles: &[[Vec3; 3]]) -> [Row; BLOCK_ROWS] {
    let mut block = EMPTY_BLOCK;
    for (lane, &vertices) in triangles.iter().enumerate() {
        set_triangle(&mut block, lane, vertices, 100 + lane as u32);
    }
    block
}

/// All hits by the definition.
fn defined_hits(triangles: &[[Vec3; 3]], ray: &Ray, limit: f32) -> Vec<HitBits> {
    let mut hits = Vec::new();
    for (lane, &vertices) in triangles.iter().enumerate() {
        let shear = triangle::Shear::new(ray.direction);
        if let Some(hit) = triangle::intersect_sheared(ray, &shear, vertices)
            && hit.t <= limit
        {
            hits.push([100 + lane as u32, hit.t.to_bits(), hit.b1.to_bits(), hit.b2.to_bits()]);
        }
    }
    hits
}

fn check_block(triangles: &[[Vec3; 3]], ray: &Ray, limit: f32) -> usize {
    let rows = block(triangles);
    assert_eq!(TriangleBlock(&rows).len(), triangles.len() as u64);
    let context = format!("{ray:?} {triangles:?}");
    let (hits, ended) = agreed(&BlockHits { block: &rows, ray, limit, wanted: usize::MAX }, &context);
    assert_eq!(hits, defined_hits(triangles, ray, limit), "{context}");
    assert!(!ended);
    let (first, ended) = agreed(&BlockHits { block: &rows, ray, limit, wanted: 1 }, &context);
    assert_eq!((first.as_slice(), ended), (&hits[..hits.len().min(1)], !hits.is_empty()));
    hits.len()
}

#[test]
fn blocks_hit_what_the_definition_hits() {
    let mut random = Random(13);
    let mut hits = 0;
    for i in 0..30_000 {
        let scale = 10.0_f32.powi(i % 13 - 6);
        let grid = i % 2 == 0;
        let mut coordinate =
            move |random: &mut Random| scale * if grid { random.on_grid() } else { random.signed() };
        let triangles: Vec<[Vec3; 3]> =
            (0..i % 9).map(|_| [(); 3].map(|()| random.vector(&mut coordinate))).collect();
        let origin = random.vector(&mut coordinate);
        let mut direction = random.vector(&mut coordinate);
        if let Some(triangle) = triangles.first() {
            let [p, q, r] = *triangle;
            match i % 7 {
                // Through a vertex, an edge, and the inside.
                0 => direction = p - origin,
                1 => direction = (p + q) * 0.5 - origin,
                2 => direction = p * 0.25 + q * 0.25 + r * 0.5 - origin,
                _ => {}
            }
        }
        if direction == Vec3::ZERO {
            continue;
        }
        let ray = Ray { t_min: if i % 4 == 0 { 0.3 } else { 0.0 }, ..Ray::new(origin, direction) };
        hits += check_block(&triangles, &ray, f32::MAX);
        // Where the limit is a hit itself, and where it is just before.
        if let Some([_, t, ..]) = defined_hits(&triangles, &ray, f32::MAX).first() {
            check_block(&triangles, &ray, f32::from_bits(*t));
            check_block(&triangles, &ray, f32::from_bits(*t).next_down());
            check_block(&triangles, &Ray { t_min: f32::from_bits(*t), ..ray }, f32::MAX);
            check_block(&triangles, &Ray { t_min: f32::from_bits(*t).next_down(), ..ray }, f32::MAX);
        }
    }
    assert!(hits > 10_000, "{hits} hits");
}

#[test]
fn triangles_that_are_none_give_no_other_hits() {
    let mut random = Random(14);
    for _ in 0..20_000 {
        let count = random.below(BLOCK_WIDTH + 1);
        let usable = |random: &mut Random| random.nasty().clamp(-1e18, 1e18);
        let triangles: Vec<[Vec3; 3]> = (0..count).map(|_| [(); 3].map(|()| random.vector(usable))).collect();
        let mut direction = random.vector(usable);
        if !(direction.abs().max_component() > 0.0 && direction.dot(Vec3::ONE).is_finite()) {
            direction = Vec3::X;
        }
        let mut origin = random.vector(usable);
        if !origin.dot(Vec3::ONE).is_finite() {
            origin = Vec3::ZERO;
        }
        check_block(&triangles, &Ray::new(origin, direction), f32::MAX);
    }
}

#[test]
fn origins_next_to_triangles_are_told_from_those_behind_as_by_the_definition() {
    let mut random = Random(15);
    let mut hits = [0; 2];
    for i in 0..40_000 {
        let scale = 10.0_f32.powi(i % 25 - 16);
        // Flat along an axis, slanted, and slivers.
        let stretch = [[1.0, 0.0, 1.0], [1.0; 3], [1.0, 1e-3, 1e-6]][random.below(3)].map(|x: f32| x * scale);
        let shift = [0.0, 1.0, 100.0][random.below(3)] * scale;
        let vertex =
            |random: &mut Random| Vec3::from(stretch) * random.vector(Random::signed) + Vec3::splat(shift);
        let triangles: Vec<_> = (0..8).map(|_| [(); 3].map(|()| vertex(&mut random))).collect();
        let [p, q, r] = triangles[random.below(8)];
        let mut origin = p + (q - p) * 0.3 + (r - p) * 0.4;
        let axis = random.below(3);
        for _ in 0..random.below(4) {
            origin[axis] = if i % 2 == 0 { origin[axis].next_up() } else { origin[axis].next_down() };
        }
        let mut direction = random.vector(Random::signed);
        if random.below(3) == 0 {
            // Nearly in the plane.
            direction = (q - p) * random.signed() + (r - p) * random.signed() + direction * (1e-6 * scale);
        }
        let ray = Ray::new(origin, direction);
        if ray.direction == Vec3::ZERO {
            continue;
        }
        hits[usize::from(check_block(&triangles, &ray, f32::MAX) > 0)] += 1;
    }
    assert!(hits[0] > 10_000 && hits[1] > 10_000, "{} without a hit, {} with one", hits[0], hits[1]);
}
