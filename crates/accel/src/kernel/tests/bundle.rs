//! Bundles against their rays alone.

use sahl_math::{Ray, Vec3};

use super::super::isa::{Isa, Lanes, Row, Task};
use super::super::{
    BLOCK_ROWS, BUNDLE_RAYS, Beam, BeamEdges, BundledBlock, CrossedPairs, EMPTY_BLOCK, EXIT_WIDENING, Loaded,
    MAX_GROUPS, NODE_ROWS, NearestHit, Node, RayBundle, TriangleBlock, WIDTH, set_triangle,
};
use super::queries::node;
use super::{Random, agreed};
use crate::geometry::triangle;
use crate::traverse::PreparedRay;

/// Rays and what they are held against.
struct Case {
    rays: Vec<Ray>,
    wanted: u64,
    nodes: Vec<[Row; NODE_ROWS]>,
    triangles: Vec<[Vec3; 3]>,
    /// What is hit before the triangles are tested; left alone where `None`.
    before: Vec<Option<NearestHit>>,
}

/// A bundle that has other rays in it, so that what is left of them shows.
fn used<I: Isa>(isa: I, case: &Case) -> RayBundle {
    let mut bundle = RayBundle::EMPTY;
    let others: Vec<Ray> = (0..BUNDLE_RAYS)
        .map(|i| Ray { t_min: 5.0, ..Ray::new(Vec3::splat(-1e6 * i as f32), Vec3::new(1.0, -1e-9, 1e9)) })
        .collect();
    bundle.load(isa, &others, !0);
    for (place, ray) in case.rays.iter().enumerate() {
        bundle.set_nearest(place, NearestHit { t: ray.t_min, id: 3, instance: 4, weights: [5.0, 6.0] });
    }
    bundle
}

#[derive(Clone, Copy)]
struct Boxes<'a>(&'a Case);

/// What a bundle says of the boxes of one node.
#[derive(Debug, PartialEq)]
struct Met {
    /// The lanes that the frustum meets.
    frustum: u32,
    /// The rays that meet each box.
    rays: [u64; WIDTH],
}

impl Task for Boxes<'_> {
    type Output = Option<(u64, u64, Vec<Met>)>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Self::Output {
        let mut bundle = used(isa, self.0);
        let Loaded { members, others, frustum, .. } = bundle.load(isa, &self.0.rays, self.0.wanted)?;
        let reach = bundle.greatest_reach(isa);
        let meet = |rows: &[Row; NODE_ROWS]| {
            let interval = frustum.interval(isa, Node(rows), reach);
            let mut met = Met { frustum: interval.enter.less_or_equal(interval.exit), rays: [0; WIDTH] };
            for (lane, rays) in met.rays.iter_mut().enumerate() {
                let planes = frustum.child_planes(Node(rows), lane);
                for group in 0..BUNDLE_RAYS / I::WIDE {
                    *rays |= u64::from(bundle.meet(isa, group, &planes)) << (group * I::WIDE);
                }
            }
            met
        };
        Some((members, others, self.0.nodes.iter().map(meet).collect()))
    }
}

/// The boxes of a node that one ray meets.
struct Alone<'a>(&'a PreparedRay, &'a [Row; NODE_ROWS]);

impl Clone for Alone<'_> {
    fn clone(&self) -> Self {
        Self(self.0, self.1)
    }
}

impl Task for Alone<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> u32 {
        let interval = Node(self.1).interval(isa, self.0, self.0.limit() * EXIT_WIDENING);
        interval.enter.less_or_equal(interval.exit)
    }
}

/// The octant of a ray that may be a member.
fn octant(ray: &Ray) -> Option<[bool; 3]> {
    let prepared = PreparedRay::new(ray)?;
    let reciprocal: [f32; 3] = prepared.ray().direction.map(|x| 1.0 / x).into();
    let finite = reciprocal.iter().all(|x| (x * EXIT_WIDENING).is_finite());
    finite.then(|| reciprocal.map(|x| x < 0.0))
}

/// Members and others by their definition.
fn defined_members(case: &Case) -> Option<(u64, u64)> {
    let octants: Vec<_> = case.rays.iter().map(octant).collect();
    let wanted = |place: usize| case.wanted >> place & 1 == 1;
    let first = (0..octants.len()).find_map(|place| octants[place].filter(|_| wanted(place)))?;
    let (mut members, mut others) = (0, 0);
    for (place, octant) in octants.iter().enumerate() {
        if let Some(octant) = octant.filter(|_| wanted(place)) {
            *(if octant == first { &mut members } else { &mut others }) |= 1 << place;
        }
    }
    Some((members, others))
}

/// Compares a case; returns how often a ray met a box.
fn check_boxes(case: &Case) -> u32 {
    let found = agreed(&Boxes(case), &format!("{:?}", case.rays));
    assert_eq!(found.as_ref().map(|found| (found.0, found.1)), defined_members(case), "{:?}", case.rays);
    let Some((members, _, met)) = found else { return 0 };
    let mut total = 0;
    for (rows, met) in case.nodes.iter().zip(&met) {
        for place in 0..BUNDLE_RAYS {
            let ray = case.rays.get(place).filter(|_| members >> place & 1 == 1);
            let alone = ray.and_then(PreparedRay::new).map_or(0, |ray| agreed(&Alone(&ray, rows), ""));
            let together: u32 =
                (0..WIDTH).map(|lane| (met.rays[lane] >> place & 1) as u32 * (1 << lane)).sum();
            assert_eq!(together, alone, "ray {place} of {:?}", case.rays);
            assert_eq!(alone & !met.frustum, 0, "the frustum misses what ray {place} meets: {:?}", case.rays);
            total += alone.count_ones();
        }
    }
    total
}

/// Rays from nearly one point that go nearly one way.
fn coherent_rays(random: &mut Random, count: usize) -> Vec<Ray> {
    let base = random.vector(Random::signed);
    let origin = random.vector(Random::signed) * 3.0;
    let (spread, apart) = ([0.0, 1e-3, 0.3][random.below(3)], [0.0, 1e-2, 1.0][random.below(3)]);
    (0..count)
        .map(|_| {
            let moved = origin + random.vector(Random::signed) * apart;
            let ray = Ray::new(moved, base + random.vector(Random::signed) * spread);
            if random.below(4) == 0 { ray.with_t_max(random.signed() * 6.0) } else { ray }
        })
        .collect()
}

/// Rays that have nothing in common, of which some are none.
fn mixed_rays(random: &mut Random, count: usize) -> Vec<Ray> {
    (0..count)
        .map(|_| {
            let origin = random.vector(Random::on_grid);
            match random.below(8) {
                0 => Ray::new(origin, random.vector(Random::nasty)),
                1 => Ray { t_min: random.nasty(), t_max: random.nasty(), ..Ray::new(origin, Vec3::ONE) },
                2 => Ray::new(random.vector(Random::nasty), random.vector(Random::signed)),
                3 => Ray::new(origin, random.vector(Random::on_grid)),
                _ => Ray::new(origin, random.vector(Random::signed)),
            }
        })
        .collect()
}

fn case(random: &mut Random, number: usize) -> Case {
    let count = [BUNDLE_RAYS, random.below(BUNDLE_RAYS + 1)][number % 2];
    let rays =
        if number.is_multiple_of(3) { mixed_rays(random, count) } else { coherent_rays(random, count) };
    let wanted = if number.is_multiple_of(5) { random.bits() } else { !0 };
    let nodes = vec![node(random, Random::on_grid), node(random, |random| 2.0 * random.signed())];
    Case { rays, wanted, nodes, triangles: Vec::new(), before: Vec::new() }
}

#[test]
fn a_frustum_meets_what_its_rays_meet() {
    let mut random = Random(21);
    let met: u32 = (0..1500).map(|number| check_boxes(&case(&mut random, number))).sum();
    assert!(met > 20_000, "{met} boxes met");
}

#[derive(Clone, Copy)]
struct Triangles<'a>(&'a Case);

/// What each member has hit in the end.
type BundleHits = Vec<(usize, [u32; 5])>;

/// The triangles of a case in blocks; their ids begin with 100.
fn blocks(case: &Case) -> Vec<[Row; BLOCK_ROWS]> {
    let mut id = 100;
    let to_block = |triangles: &[[Vec3; 3]]| {
        let mut rows = EMPTY_BLOCK;
        for (lane, &vertices) in triangles.iter().enumerate() {
            set_triangle(&mut rows, lane, vertices, id);
            id += 1;
        }
        rows
    };
    case.triangles.chunks(WIDTH).map(to_block).collect()
}

/// What rays of the beam's groups may hit of a block, one bit each.
#[inline(always)]
fn may_hit<I: Isa>(isa: I, block: TriangleBlock<'_>, beam: Option<&Beam>) -> [u32; MAX_GROUPS] {
    let Some(beam) = beam else { return [block.all(isa); MAX_GROUPS] };
    let edges = BeamEdges::new(isa, block, beam);
    let mut found = [0; MAX_GROUPS];
    for (group, triangles) in found.iter_mut().take(BUNDLE_RAYS / I::WIDE).enumerate() {
        *triangles = edges.may_hit(isa, beam, group);
    }
    found
}

fn hit_bits(hit: &NearestHit) -> [u32; 5] {
    if hit.id == u32::MAX {
        // Where nothing is hit weights mean nothing.
        return [hit.t.to_bits(), hit.id, u32::MAX, 0, 0];
    }
    [hit.t.to_bits(), hit.id, hit.instance, hit.weights[0].to_bits(), hit.weights[1].to_bits()]
}

impl Task for Triangles<'_> {
    type Output = Option<BundleHits>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Self::Output {
        let case = self.0;
        let mut bundle = used(isa, case);
        let Loaded { members, beam, .. } = bundle.load(isa, &case.rays, case.wanted)?;
        let blocks = blocks(case);
        let places = || (0..case.rays.len()).filter(|place| members >> place & 1 == 1);
        for place in places() {
            if let Some(hit) = case.before[place] {
                bundle.set_nearest(place, hit);
            }
        }
        if !bundle.has_common_axis() {
            return None;
        }
        for (number, rows) in blocks.iter().enumerate() {
            let found = may_hit(isa, TriangleBlock(rows), beam.as_ref());
            for place in places() {
                let (_, alone) = defined_hit(case, place);
                let missed = (alone >> (WIDTH * number)) as u8 as u32 & !found[place / I::WIDE];
                assert_eq!(missed, 0, "the beam misses what {:?} hits", case.rays[place]);
            }
        }
        let mut crossed = CrossedPairs::none(isa);
        for (number, rows) in blocks.iter().enumerate() {
            let block = TriangleBlock(rows);
            // Every other one relative to each ray's origin, though they all start at one point.
            let beam = beam.as_ref().filter(|_| (number + case.rays.len()).is_multiple_of(2));
            let vertices = beam.map(|beam| BeamEdges::new(isa, block, beam).vertices());
            let block = BundledBlock { block, vertices: &vertices };
            let triangles = (case.triangles.len() - WIDTH * number).min(WIDTH);
            // Every other group is asked in two halves.
            for (even, odd) in [(u32::MAX, 0x5555), (0, 0xaaaa)] {
                crossed.clear();
                for group in 0..BUNDLE_RAYS / I::WIDE {
                    let all = (members >> (group * I::WIDE)) as u32 & ((1 << I::WIDE) - 1);
                    let lanes = all & if group % 2 == 0 { even } else { odd };
                    for triangle in 0..triangles {
                        bundle.cross(isa, (group, lanes), (block, triangle), &mut crossed);
                    }
                }
                let before: Vec<_> = places().map(|place| hit_bits(&bundle.nearest(place))).collect();
                let changed = bundle.intersect(isa, (block, &crossed), &case.rays);
                let after: Vec<_> = places().map(|place| hit_bits(&bundle.nearest(place))).collect();
                assert_eq!(changed, before != after);
            }
        }
        Some(places().map(|place| (place, hit_bits(&bundle.nearest(place)))).collect())
    }
}

/// What a ray hits of the triangles, and which it would hit alone; by the definition.
fn defined_hit(case: &Case, place: usize) -> ([u32; 5], u32) {
    let ray = PreparedRay::new(&case.rays[place]).expect("members are rays");
    let nothing = NearestHit { t: ray.limit(), id: u32::MAX, instance: u32::MAX, weights: [0.0; 2] };
    let mut nearest = case.before[place].unwrap_or(nothing);
    let mut candidates = 0;
    for (i, &vertices) in case.triangles.iter().enumerate() {
        let Some(hit) = triangle::intersect_sheared(&ray.ray(), &ray.shear(), vertices) else { continue };
        let id = 100 + i as u32;
        if hit.t <= ray.limit() {
            candidates |= 1 << i;
        }
        let comes_first =
            hit.t < nearest.t || hit.t == nearest.t && (u32::MAX, id) < (nearest.instance, nearest.id);
        if comes_first {
            nearest = NearestHit { t: hit.t, id, instance: u32::MAX, weights: [hit.b1, hit.b2] };
        }
    }
    (hit_bits(&nearest), candidates)
}

/// Triangles on a grid, some of them twice, and through what rays may hit before.
fn with_triangles(random: &mut Random, mut case: Case) -> Case {
    let vertex = |random: &mut Random| random.vector(Random::on_grid);
    case.triangles = (0..10).map(|_| [(); 3].map(|()| vertex(random))).collect();
    let [p, q, r] = case.triangles[0];
    case.triangles.extend([[p, q, r], [q, r, p]]);
    for ray in &mut case.rays {
        // At vertices, edges and insides.
        let weights = [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.25, 0.25, 0.5]][random.below(3)];
        let target = p * weights[0] + q * weights[1] + r * weights[2];
        if random.below(2) == 0 {
            ray.direction = target - ray.origin;
        }
    }
    let before = |ray: &Ray| {
        let prepared = PreparedRay::new(ray)?;
        let hit = triangle::intersect_sheared(&prepared.ray(), &prepared.shear(), case.triangles[0])?;
        let instance = [7, u32::MAX][random.below(2)];
        let id = 95 + random.below(10) as u32;
        let is_known = random.below(3) == 0 && hit.t <= prepared.limit();
        is_known.then_some(NearestHit { t: hit.t, id, instance, weights: [hit.b1, hit.b2] })
    };
    case.before = case.rays.iter().map(before).collect();
    case
}

#[test]
fn triangles_against_bundles_hit_what_the_definition_hits() {
    let mut random = Random(22);
    let (mut hits, mut bundles) = (0, 0);
    for number in 0..3000 {
        let case = case(&mut random, 1 + 3 * (number / 2) + number % 2);
        let case = with_triangles(&mut random, case);
        let Some(found) = agreed(&Triangles(&case), &format!("{:?}", case.rays)) else { continue };
        bundles += 1;
        for (place, found) in found {
            let (expected, _) = defined_hit(&case, place);
            assert_eq!(found, expected, "ray {:?} of {:?}", case.rays[place], case.triangles);
            hits += usize::from(found[1] != u32::MAX);
        }
    }
    assert!(bundles > 300 && hits > 5000, "{bundles} bundles, {hits} hits");
}
