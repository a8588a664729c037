//! Rays that go nearly the same way: the boxes that any of them may meet, and which of them meet one box.

mod frustum;
mod triangles;

use sahl_math::{Ray, Vec3};

use super::WIDTH;
use super::beam::Beam;
use super::eight_rays::{EightRays, filled_up};
use super::isa::{BundleRow, Isa, Lanes, Octant};
use super::node::EXIT_WIDENING;
use crate::geometry::triangle::{Axis, Shear};
pub(crate) use frustum::Frustum;
pub(crate) use triangles::{BundledBlock, CrossedPairs};

/// Rays of a bundle.
pub(crate) const BUNDLE_RAYS: usize = 64;

const ROWS: usize = BUNDLE_RAYS / WIDTH;

/// Up to [`BUNDLE_RAYS`] rays of one octant, as a structure of arrays. Places without a ray meet nothing.
#[derive(Clone, Debug)]
pub(crate) struct RayBundle {
    origin: [BundleRow; 3],
    reciprocal: [BundleRow; 3],
    widened: [BundleRow; 3],
    direction: [BundleRow; 3],
    t_min: BundleRow,
    /// The largest parameter that counts; negative for rays that meet nothing.
    limit: BundleRow,
    /// [`super::EXIT_WIDENING`] times that.
    reach: BundleRow,
    /// What is hit at the limit; [`NOTHING`] for rays that have hit nothing.
    id: BundleRow,
    instance: BundleRow,
    weights: [BundleRow; 2],
    /// The shear, if all rays are longest along the same axis.
    shear: Option<BundleShear>,
}

/// The bits that stand for no primitive and no instance.
const NOTHING: BundleRow = BundleRow::splat(f32::from_bits(u32::MAX));

/// The shears of rays that are longest along the same axis.
#[derive(Clone, Copy, Debug)]
struct BundleShear {
    axes: [Axis; 3],
    factors: [BundleRow; 3],
}

/// What [`RayBundle::load`] has made of rays; one bit each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Loaded {
    pub(crate) members: u64,
    /// Rays that could be members of another bundle.
    pub(crate) others: u64,
    /// The bounds of the members.
    pub(crate) frustum: Frustum,
    /// Their slopes, if they start at one point and are longest along the same axis.
    pub(crate) beam: Option<Beam>,
}

/// What a ray has hit so far; `id` is `u32::MAX`, and `t` the largest parameter that counts, if it has hit nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestHit {
    pub(crate) t: f32,
    pub(crate) id: u32,
    pub(crate) instance: u32,
    pub(crate) weights: [f32; 2],
}

impl RayBundle {
    /// No rays.
    pub(crate) const EMPTY: Self = {
        let zero = BundleRow::splat(0.0);
        Self {
            origin: [zero; 3],
            reciprocal: [zero; 3],
            widened: [zero; 3],
            direction: [zero; 3],
            t_min: zero,
            limit: zero,
            reach: zero,
            id: NOTHING,
            instance: NOTHING,
            weights: [zero; 2],
            shear: None,
        }
    };

    /// Replaces the rays by some of up to [`BUNDLE_RAYS`] others, one bit each in `wanted`.
    ///
    /// Not members are rays in another octant than the first member, along an axis, or that hit nothing.
    #[inline(always)]
    pub(crate) fn load<I: Isa>(&mut self, isa: I, rays: &[Ray], wanted: u64) -> Option<Loaded> {
        self.copy(isa, rays);
        let (mut usable, mut negative) = (0, [0; 3]);
        for group in 0..BUNDLE_RAYS / I::WIDE {
            let lanes = self.prepare_group(isa, group);
            usable |= u64::from(lanes.usable) << (group * I::WIDE);
            for (all, part) in negative.iter_mut().zip(lanes.negative) {
                *all |= u64::from(part) << (group * I::WIDE);
            }
        }
        if rays.len() < BUNDLE_RAYS {
            usable &= (1 << rays.len()) - 1;
        }
        usable &= wanted;
        if usable == 0 {
            return None;
        }
        let first = usable.trailing_zeros() as usize % BUNDLE_RAYS;
        let octant = Octant::new(negative.map(|bits| bits >> first & 1 == 1));
        let mut members = usable;
        for bits in negative {
            members &= if bits >> first & 1 == 1 { bits } else { !bits };
        }
        self.exclude(!members, first);
        self.id = NOTHING;
        self.instance = NOTHING;
        self.shear = self.common_shear(isa, first);
        let [x, y, z] = &self.origin;
        let origins = [range(isa, x), range(isa, y), range(isa, z)];
        let (frustum, beam) = (self.frustum(isa, octant, &origins), self.beam(isa, &origins));
        Some(Loaded { members, others: usable & !members, frustum, beam })
    }

    /// Copies what is given of the rays; `reach` holds the ends of their intervals until [`Self::prepare_group`].
    #[inline(always)]
    fn copy<I: Isa>(&mut self, isa: I, rays: &[Ray]) {
        let (rows, rest) = rays.as_chunks();
        for (row, rays) in rows.iter().enumerate().take(ROWS) {
            self.copy_row(row, &EightRays::load(isa, rays));
        }
        if !rest.is_empty() {
            self.copy_row(rows.len() % ROWS, &EightRays::load(isa, &filled_up(rest)));
        }
    }

    #[inline(always)]
    fn copy_row<F: Lanes<Array = [f32; WIDTH]>>(&mut self, row: usize, rays: &EightRays<F>) {
        for axis in 0..3 {
            set_row(&mut self.origin[axis], row, rays.origin[axis].to_array());
            set_row(&mut self.direction[axis], row, rays.direction[axis].to_array());
        }
        set_row(&mut self.t_min, row, rays.t_min.to_array());
        let t_max = rays.t_max.to_array();
        set_row(&mut self.reach, row, t_max);
        // The number before `t_max`: of members that is positive.
        let limit = t_max.map(|t_max| f32::from_bits(t_max.to_bits().wrapping_sub(1)));
        set_row(&mut self.limit, row, limit);
    }

    #[inline(always)]
    fn prepare_group<I: Isa>(&mut self, isa: I, group: usize) -> GroupLanes {
        let t_max = isa.load_wide(&self.reach, group);
        let zero = t_max.splat(0.0);
        let t_min = isa.load_wide(&self.t_min, group);
        let widening = zero.splat(EXIT_WIDENING);
        let mut lanes = GroupLanes { usable: t_min.less(t_max), negative: [0; 3] };
        for axis in 0..3 {
            let origin = isa.load_wide(&self.origin[axis], group);
            let direction = isa.load_wide(&self.direction[axis], group);
            let reciprocal = direction.reciprocal();
            let widened = reciprocal * widening;
            // Zero times what is infinite or NaN is NaN.
            lanes.usable &= (origin * zero + direction * zero).equal(zero);
            lanes.usable &= widened.abs().less_or_equal(zero.splat(f32::MAX));
            lanes.negative[axis] = reciprocal.less(zero);
            isa.store_wide(reciprocal, &mut self.reciprocal[axis], group);
            isa.store_wide(widened, &mut self.widened[axis], group);
        }
        isa.store_wide(isa.load_wide(&self.limit, group) * widening, &mut self.reach, group);
        lanes
    }

    /// Makes rays meet nothing, and repeats another in their places, which moves no bounds.
    #[inline(always)]
    fn exclude(&mut self, mut places: u64, other: usize) {
        let other = other % BUNDLE_RAYS;
        while places != 0 {
            let place = places.trailing_zeros() as usize % BUNDLE_RAYS;
            places &= places - 1;
            for rows in self
                .origin
                .iter_mut()
                .chain(&mut self.reciprocal)
                .chain(&mut self.widened)
                .chain(&mut self.direction)
            {
                rows.0[place] = rows.0[other];
            }
            self.t_min.0[place] = self.t_min.0[other];
            self.set_limit(place, f32::NEG_INFINITY);
        }
    }

    /// The shear of each ray, as [`Shear::new`] gives it.
    #[inline(always)]
    fn common_shear<I: Isa>(&self, isa: I, first: usize) -> Option<BundleShear> {
        let axes = self.ray_axes(first);
        let [x, y, z] = axes.map(|axis| axis as usize);
        let mut longest = true;
        let mut factors = [BundleRow::splat(0.0); 3];
        for group in 0..BUNDLE_RAYS / I::WIDE {
            let dx = isa.load_wide(&self.direction[x], group);
            let dy = isa.load_wide(&self.direction[y], group);
            let dz = isa.load_wide(&self.direction[z], group);
            // Strictly: of equally long axes each ray takes the first.
            let lanes = dx.abs().less(dz.abs()) & dy.abs().less(dz.abs());
            longest &= lanes.count_ones() as usize == I::WIDE;
            let scale = isa.load_wide(&self.reciprocal[z], group);
            isa.store_wide(dx * scale, &mut factors[0], group);
            isa.store_wide(dy * scale, &mut factors[1], group);
            isa.store_wide(scale, &mut factors[2], group);
        }
        longest.then_some(BundleShear { axes, factors })
    }

    #[inline(always)]
    fn ray_axes(&self, place: usize) -> [Axis; 3] {
        let place = place % BUNDLE_RAYS;
        let [x, y, z] = &self.direction;
        Shear::new(Vec3::new(x.0[place], y.0[place], z.0[place])).axes
    }

    /// Whether triangles can be tested against groups of rays.
    #[inline(always)]
    pub(crate) fn has_common_axis(&self) -> bool {
        self.shear.is_some()
    }

    /// What a ray has hit.
    #[inline(always)]
    pub(crate) fn nearest(&self, place: usize) -> NearestHit {
        let place = place % BUNDLE_RAYS;
        NearestHit {
            t: self.limit.0[place],
            id: self.id.0[place].to_bits(),
            instance: self.instance.0[place].to_bits(),
            weights: [self.weights[0].0[place], self.weights[1].0[place]],
        }
    }

    /// Replaces what a ray has hit.
    #[inline(always)]
    pub(crate) fn set_nearest(&mut self, place: usize, hit: NearestHit) {
        let place = place % BUNDLE_RAYS;
        self.set_limit(place, hit.t);
        self.id.0[place] = f32::from_bits(hit.id);
        self.instance.0[place] = f32::from_bits(hit.instance);
        for (rows, weight) in self.weights.iter_mut().zip(hit.weights) {
            rows.0[place] = weight;
        }
    }

    /// Sets the largest parameter that counts for a ray.
    #[inline(always)]
    fn set_limit(&mut self, place: usize, limit: f32) {
        let place = place % BUNDLE_RAYS;
        self.limit.0[place] = limit;
        self.reach.0[place] = limit * EXIT_WIDENING;
    }

    /// The greatest reach of any ray.
    #[inline(always)]
    pub(crate) fn greatest_reach<I: Isa>(&self, isa: I) -> f32 {
        let [_, greatest] = range(isa, &self.reach);
        greatest
    }

    /// Which of a group's rays meet a box, one bit each: the arithmetic of [`Node::interval`].
    #[inline(always)]
    pub(crate) fn meet<I: Isa>(&self, isa: I, group: usize, [near, far]: &[[f32; 3]; 2]) -> u32 {
        let (t_min, reach) = (isa.load_wide(&self.t_min, group), isa.load_wide(&self.reach, group));
        let [x, y, z] = [
            self.crossing(isa, &self.reciprocal, group, (0, near[0])),
            self.crossing(isa, &self.reciprocal, group, (1, near[1])),
            self.crossing(isa, &self.reciprocal, group, (2, near[2])),
        ];
        let enter = x.max(y).max(z.max(t_min));
        let [x, y, z] = [
            self.crossing(isa, &self.widened, group, (0, far[0])),
            self.crossing(isa, &self.widened, group, (1, far[1])),
            self.crossing(isa, &self.widened, group, (2, far[2])),
        ];
        let exit = x.min(y).min(z.min(reach));
        enter.less_or_equal(exit)
    }

    #[inline(always)]
    fn crossing<I: Isa>(
        &self,
        isa: I,
        reciprocal: &[BundleRow; 3],
        group: usize,
        (axis, plane): (usize, f32),
    ) -> I::Wide {
        let origin = isa.load_wide(&self.origin[axis], group);
        (origin.splat(plane) - origin) * isa.load_wide(&reciprocal[axis], group)
    }
}

/// Replaces eight numbers that stand together.
#[inline(always)]
fn set_row(rows: &mut BundleRow, row: usize, numbers: [f32; WIDTH]) {
    rows.0.as_chunks_mut().0[row % ROWS] = numbers;
}

/// What is known of a group of rays; one bit a lane.
struct GroupLanes {
    usable: u32,
    /// Whether the direction is negative, one an axis.
    negative: [u32; 3],
}

/// The least and the greatest of all numbers in the rows.
#[inline(always)]
fn range<I: Isa>(isa: I, rows: &BundleRow) -> [f32; 2] {
    let first = isa.load_wide(rows, 0);
    let (mut low, mut high) = (first, first);
    for group in 1..BUNDLE_RAYS / I::WIDE {
        let lanes = isa.load_wide(rows, group);
        (low, high) = (low.min(lanes), high.max(lanes));
    }
    [low.least(), high.greatest()]
}
