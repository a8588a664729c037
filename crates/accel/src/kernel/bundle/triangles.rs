//! Triangles against groups of a bundle's rays: the watertight test with a ray in every lane.

use sahl_math::{Ray, Vec3};

use super::super::WIDTH;
use super::super::beam::{BeamVertices, MAX_GROUPS};
use super::super::block::TriangleBlock;
use super::super::isa::{BundleRow, Isa, Lanes};
use super::super::node::EXIT_WIDENING;
use super::super::watertight::{EdgeFunctions, RayLanes, Relative, SolvedArrays};
use super::{NearestHit, RayBundle};
use crate::geometry::triangle::Axis;

/// Pairs of a group of rays and a triangle: as many as a block has with the narrowest groups.
const MOST_PAIRS: usize = MAX_GROUPS * WIDTH;

/// The pairs of a group of rays and a triangle of a block through which the line of one of the rays passes.
///
/// Found for all pairs before any is looked at more closely: whether a line passes cannot be predicted, and a branch on it would make
/// the processor wait for each edge function.
pub(crate) struct CrossedPairs<F> {
    edges: [EdgeFunctions<F>; MOST_PAIRS],
    /// The rays whose lines pass, one bit each.
    inside: [u32; MOST_PAIRS],
    pairs: [Pair; MOST_PAIRS],
    count: usize,
}

#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    group: u8,
    triangle: u8,
}

impl<F: Lanes> CrossedPairs<F> {
    /// None, but with memory for them.
    #[inline(always)]
    pub(crate) fn none<I: Isa<Wide = F>>(isa: I) -> Self {
        let any = isa.load_wide(&BundleRow::splat(0.0), 0);
        Self {
            edges: [EdgeFunctions { u: any, v: any, w: any }; MOST_PAIRS],
            inside: [0; MOST_PAIRS],
            pairs: [Pair::default(); MOST_PAIRS],
            count: 0,
        }
    }

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }
}

impl RayBundle {
    /// Adds a triangle and some rays of a group, one bit each, if the line of one of them passes through it.
    #[inline(always)]
    pub(crate) fn cross<I: Isa>(
        &self,
        isa: I,
        (group, lanes): (usize, u32),
        (block, triangle): (BundledBlock<'_, I>, usize),
        crossed: &mut CrossedPairs<I::Wide>,
    ) {
        let triangle = triangle % WIDTH;
        let Some((relative, rays)) = self.prepare(isa, group, (block, triangle)) else { return };
        let [sx, sy, _] = rays.factors;
        let edges = relative.edge_functions([sx, sy]);
        let inside = lanes & edges.inside(rays.t_min.splat(0.0));
        let place = crossed.count % MOST_PAIRS;
        crossed.edges[place] = edges;
        crossed.inside[place] = inside;
        crossed.pairs[place] = Pair { group: group as u8, triangle: triangle as u8 };
        crossed.count += usize::from(inside != 0);
    }

    /// Tests the triangles of pairs of a block; returns whether any ray hits one of them before what it has hit.
    ///
    /// `rays` are those from which the bundle was loaded.
    #[inline(always)]
    pub(crate) fn intersect<I: Isa>(
        &mut self,
        isa: I,
        (block, crossed): (BundledBlock<'_, I>, &CrossedPairs<I::Wide>),
        rays: &[Ray],
    ) -> bool {
        let mut changed = false;
        for place in 0..crossed.count.min(MOST_PAIRS) {
            changed |= self.intersect_pair(isa, block, (crossed, place), rays);
        }
        changed
    }

    #[inline(always)]
    fn intersect_pair<I: Isa>(
        &mut self,
        isa: I,
        block: BundledBlock<'_, I>,
        (crossed, place): (&CrossedPairs<I::Wide>, usize),
        rays: &[Ray],
    ) -> bool {
        let Pair { group, triangle } = crossed.pairs[place];
        let (group, triangle) = (group.into(), usize::from(triangle) % WIDTH);
        let Some((relative, ray_lanes)) = self.prepare(isa, group, (block, triangle)) else { return false };
        let block = block.block;
        let solved = relative.solve_inside(&ray_lanes, (&crossed.edges[place], crossed.inside[place]));
        let (limit, id) = (ray_lanes.limit, block.id(triangle));
        // What is as near as what was hit is decided by names, one by one.
        let special = solved.special | solved.certain & solved.t.equal(limit);
        let nearer = solved.certain & solved.t.less(limit);
        replace(isa, &mut self.limit, (group, nearer), solved.t);
        let reach = isa.load_wide(&self.limit, group) * limit.splat(EXIT_WIDENING);
        isa.store_wide(reach, &mut self.reach, group);
        replace(isa, &mut self.id, (group, nearer), limit.splat(f32::from_bits(id)));
        replace(isa, &mut self.instance, (group, nearer), limit.splat(f32::from_bits(u32::MAX)));
        replace(isa, &mut self.weights[0], (group, nearer), solved.b1);
        replace(isa, &mut self.weights[1], (group, nearer), solved.b2);
        let first = group * I::WIDE;
        let decided = special != 0 && {
            let named = (id, &block.vertices(triangle));
            self.decide((first, special), &solved.to_arrays(), named, rays)
        };
        nearer != 0 || decided
    }

    /// Looks closer at some lanes of a group.
    #[inline(never)]
    fn decide<A: AsRef<[f32]>>(
        &mut self,
        (first, mut lanes): (usize, u32),
        solved: &SolvedArrays<A>,
        (id, vertices): (u32, &[Vec3; 3]),
        rays: &[Ray],
    ) -> bool {
        let mut changed = false;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let place = first + lane;
            let before = self.nearest(place);
            let Some(hit) = solved.hit(lane, &rays[place], before.t, (id, || *vertices)) else { continue };
            let comes_first =
                hit.t < before.t || hit.t == before.t && (u32::MAX, hit.id) < (before.instance, before.id);
            if comes_first {
                let weights = [hit.b1, hit.b2];
                self.set_nearest(place, NearestHit { t: hit.t, id: hit.id, weights, instance: u32::MAX });
                changed = true;
            }
        }
        changed
    }

    #[inline(always)]
    fn prepare<I: Isa>(
        &self,
        isa: I,
        group: usize,
        (BundledBlock { block, vertices }, triangle): (BundledBlock<'_, I>, usize),
    ) -> Option<Prepared<I::Wide>> {
        let shear = self.shear.as_ref()?;
        let [sx, sy, sz] = &shear.factors;
        let rays = RayLanes {
            factors: [isa.load_wide(sx, group), isa.load_wide(sy, group), isa.load_wide(sz, group)],
            t_min: isa.load_wide(&self.t_min, group),
            limit: isa.load_wide(&self.limit, group),
        };
        if let Some(vertices) = vertices {
            return Some((vertices.triangle(triangle, rays.t_min), rays));
        }
        let [x, y, z] = shear.axes;
        let relative = Relative {
            x: self.relative(isa, group, (x, (block, triangle))),
            y: self.relative(isa, group, (y, (block, triangle))),
            z: self.relative(isa, group, (z, (block, triangle))),
        };
        Some((relative, rays))
    }

    #[inline(always)]
    fn relative<I: Isa>(
        &self,
        isa: I,
        group: usize,
        (axis, (block, triangle)): (Axis, (TriangleBlock<'_>, usize)),
    ) -> [I::Wide; 3] {
        let origin = isa.load_wide(&self.origin[axis as usize], group);
        let [p0, p1, p2] = block.rows_of(axis);
        let (p0, p1, p2) = (p0.0[triangle], p1.0[triangle], p2.0[triangle]);
        [origin.splat(p0) - origin, origin.splat(p1) - origin, origin.splat(p2) - origin]
    }
}

/// Replaces some lanes of a group.
#[inline(always)]
fn replace<I: Isa>(isa: I, rows: &mut BundleRow, (group, lanes): (usize, u32), by: I::Wide) {
    isa.store_wide(by.select(lanes, isa.load_wide(rows, group)), rows, group);
}

/// A block, and its vertices as the rays see them if these start at one point.
pub(crate) struct BundledBlock<'a, I: Isa> {
    pub(crate) block: TriangleBlock<'a>,
    pub(crate) vertices: &'a Option<BeamVertices<<I::F32 as Lanes>::Array>>,
}

impl<I: Isa> Clone for BundledBlock<'_, I> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<I: Isa> Copy for BundledBlock<'_, I> {}

/// A triangle relative to a group of rays, and the rays.
type Prepared<F> = (Relative<F>, RayLanes<F>);
