//! Triangles against groups of a bundle's rays: the watertight test with a ray in every lane.

use sahl_math::{Ray, Vec3};

use super::super::WIDTH;
use super::super::beam::BeamVertices;
use super::super::block::TriangleBlock;
use super::super::isa::{BundleRow, Isa, Lanes};
use super::super::node::EXIT_WIDENING;
use super::super::watertight::{RayLanes, Relative, SolvedArrays};
use super::{NearestHit, RayBundle};
use crate::geometry::triangle::Axis;

impl RayBundle {
    /// Tests a triangle against some rays of a group, one bit each; returns whether any of them hits it before what it has hit.
    ///
    /// The rays must have a common axis. `rays` are those from which the bundle was loaded.
    #[inline(always)]
    pub(crate) fn intersect<I: Isa>(
        &mut self,
        isa: I,
        (group, lanes): (usize, u32),
        (block, triangle): (BundledBlock<'_, I>, usize),
        rays: &[Ray],
    ) -> bool {
        let triangle = triangle % WIDTH;
        let Some((relative, ray_lanes)) = self.prepare(isa, group, (block, triangle)) else { return false };
        let block = block.block;
        let Some(solved) = relative.solve_few(&ray_lanes, lanes) else { return false };
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
