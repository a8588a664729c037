//! Rays that go nearly the same way: the boxes that any of them may meet, and which of them meet one box.

use sahl_math::{Ray, Vec3};

use super::WIDTH;
use super::isa::{Interval, Isa, Lanes, Octant, Row};
use super::node::{EXIT_WIDENING, Node, Planes};
use super::watertight::{RayLanes, Relative, Solved};
use crate::geometry::triangle::{Axis, Shear};

/// Rays of a bundle.
pub(crate) const BUNDLE_RAYS: usize = 64;

/// Groups of [`WIDTH`] rays, which are tested at once.
pub(crate) const BUNDLE_GROUPS: usize = BUNDLE_RAYS / WIDTH;

/// Up to [`BUNDLE_RAYS`] rays of one octant, as a structure of arrays. Places without a ray meet nothing.
#[derive(Clone, Debug)]
pub(crate) struct RayBundle {
    origin: [[Row; BUNDLE_GROUPS]; 3],
    reciprocal: [[Row; BUNDLE_GROUPS]; 3],
    widened: [[Row; BUNDLE_GROUPS]; 3],
    direction: [[Row; BUNDLE_GROUPS]; 3],
    t_min: [Row; BUNDLE_GROUPS],
    /// The largest parameter that counts; negative for rays that meet nothing.
    limit: [Row; BUNDLE_GROUPS],
    /// [`super::EXIT_WIDENING`] times that.
    reach: [Row; BUNDLE_GROUPS],
    /// The shear, if all rays are longest along the same axis.
    shear: Option<BundleShear>,
}

/// The shears of rays that are longest along the same axis.
#[derive(Clone, Copy, Debug)]
struct BundleShear {
    axes: [Axis; 3],
    factors: [[Row; BUNDLE_GROUPS]; 3],
}

/// The bounds of a bundle: each number is the least or the greatest among its rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frustum {
    /// What gives the lowest parameter at a plane where rays enter, one an axis.
    enter_origin: [f32; 3],
    reciprocal: [[f32; 3]; 2],
    /// What gives the highest parameter at a plane where rays leave.
    exit_origin: [f32; 3],
    widened: [[f32; 3]; 2],
    enter: [Planes; 3],
    exit: [Planes; 3],
    pub(crate) octant: Octant,
    t_min: f32,
}

impl Frustum {
    /// For each child, the lowest parameter at which any ray enters its box, and the highest at which any leaves it.
    ///
    /// Rounding is monotonic: what holds of exact products of bounds holds of rounded ones.
    #[inline(always)]
    pub(crate) fn interval<I: Isa>(&self, isa: I, node: Node<'_>, reach: f32) -> Interval<I::F32> {
        let enter = self.lowest(isa, node, 2).max(isa.splat(self.t_min));
        let enter = self.lowest(isa, node, 0).max(self.lowest(isa, node, 1).max(enter));
        let exit = self.highest(isa, node, 2).min(isa.splat(reach));
        let exit = self.highest(isa, node, 0).min(self.highest(isa, node, 1).min(exit));
        Interval { enter, exit }
    }

    #[inline(always)]
    fn lowest<I: Isa>(&self, isa: I, node: Node<'_>, axis: usize) -> I::F32 {
        let offset = isa.load(node.planes(self.enter[axis])) - isa.splat(self.enter_origin[axis]);
        let [low, high] = &self.reciprocal;
        (offset * isa.splat(low[axis])).min(offset * isa.splat(high[axis]))
    }

    #[inline(always)]
    fn highest<I: Isa>(&self, isa: I, node: Node<'_>, axis: usize) -> I::F32 {
        let offset = isa.load(node.planes(self.exit[axis])) - isa.splat(self.exit_origin[axis]);
        let [low, high] = &self.widened;
        (offset * isa.splat(low[axis])).max(offset * isa.splat(high[axis]))
    }

    /// The planes of a child's box where the rays enter, and those where they leave.
    #[inline(always)]
    pub(crate) fn child_planes(&self, node: Node<'_>, lane: usize) -> [[f32; 3]; 2] {
        let lane = lane % WIDTH;
        let [x, y, z] = self.enter;
        let enter = [node.planes(x).0[lane], node.planes(y).0[lane], node.planes(z).0[lane]];
        let [x, y, z] = self.exit;
        [enter, [node.planes(x).0[lane], node.planes(y).0[lane], node.planes(z).0[lane]]]
    }
}

impl RayBundle {
    /// No rays.
    pub(crate) const EMPTY: Self = {
        let zero = [Row::splat(0.0); BUNDLE_GROUPS];
        Self {
            origin: [zero; 3],
            reciprocal: [zero; 3],
            widened: [zero; 3],
            direction: [zero; 3],
            t_min: zero,
            limit: zero,
            reach: zero,
            shear: None,
        }
    };

    /// Replaces the rays by up to [`BUNDLE_RAYS`] others.
    ///
    /// Returns which of them are members, one bit each, with their bounds. Not members are rays in another octant than the first
    /// member, along an axis, or that hit nothing.
    #[inline(always)]
    pub(crate) fn load<I: Isa>(&mut self, isa: I, rays: &[Ray]) -> Option<(u64, Frustum)> {
        let mut usable = 0;
        let mut negative = [0; 3];
        for (group, rays) in rays.chunks(WIDTH).enumerate().take(BUNDLE_GROUPS) {
            let lanes = self.load_group(isa, group, rays);
            usable |= u64::from(lanes.usable) << (group * WIDTH);
            for (all, part) in negative.iter_mut().zip(lanes.negative) {
                *all |= u64::from(part) << (group * WIDTH);
            }
        }
        if usable == 0 {
            return None;
        }
        let first = usable.trailing_zeros() as usize % BUNDLE_RAYS;
        let octant = Octant::new(negative.map(|bits| bits >> first & 1 == 1));
        let same = |bits: u64| if bits >> first & 1 == 1 { bits } else { !bits };
        let members = negative.into_iter().fold(usable, |members, bits| members & same(bits));
        self.exclude(!members, first);
        self.shear = self.common_shear(isa);
        Some((members, self.frustum(isa, octant)))
    }

    #[inline(always)]
    fn load_group<I: Isa>(&mut self, isa: I, group: usize, rays: &[Ray]) -> GroupLanes {
        let mut t_max = Row::splat(0.0);
        for (lane, ray) in rays.iter().enumerate().take(WIDTH) {
            let (o, d): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.direction.into());
            for axis in 0..3 {
                self.origin[axis][group].0[lane] = o[axis];
                self.direction[axis][group].0[lane] = d[axis];
            }
            self.t_min[group].0[lane] = ray.t_min;
            t_max.0[lane] = ray.t_max;
            self.limit[group].0[lane] = ray.t_max.next_down();
        }
        let zero = isa.splat(0.0);
        let t_min = isa.load(&self.t_min[group]).max(zero);
        let reach = isa.load(&self.limit[group]) * isa.splat(EXIT_WIDENING);
        let mut lanes = GroupLanes { usable: t_min.less(isa.load(&t_max)), negative: [0; 3] };
        for axis in 0..3 {
            let (o, d) = (isa.load(&self.origin[axis][group]), isa.load(&self.direction[axis][group]));
            let reciprocal = d.reciprocal();
            let widened = reciprocal * isa.splat(EXIT_WIDENING);
            // Zero times what is infinite or NaN is NaN.
            lanes.usable &= (o * zero + d * zero).equal(zero);
            lanes.usable &= widened.abs().less_or_equal(isa.splat(f32::MAX));
            lanes.negative[axis] = reciprocal.less(zero);
            self.reciprocal[axis][group] = Row(reciprocal.to_array());
            self.widened[axis][group] = Row(widened.to_array());
        }
        // Places without a ray have an empty interval.
        self.t_min[group] = Row(t_min.to_array());
        self.reach[group] = Row(reach.to_array());
        lanes.usable &= (1 << rays.len()) - 1;
        lanes
    }

    /// Makes rays meet nothing, and repeats another in their places, which moves no bounds.
    #[inline(always)]
    fn exclude(&mut self, mut places: u64, other: usize) {
        let (other_group, other_lane) = (other / WIDTH % BUNDLE_GROUPS, other % WIDTH);
        while places != 0 {
            let place = places.trailing_zeros() as usize;
            places &= places - 1;
            let (group, lane) = (place / WIDTH % BUNDLE_GROUPS, place % WIDTH);
            for rows in self
                .origin
                .iter_mut()
                .chain(&mut self.reciprocal)
                .chain(&mut self.widened)
                .chain(&mut self.direction)
            {
                rows[group].0[lane] = rows[other_group].0[other_lane];
            }
            self.t_min[group].0[lane] = self.t_min[other_group].0[other_lane];
            self.set_limit(place, f32::NEG_INFINITY);
        }
    }

    /// The shear of each ray, as [`Shear::new`] gives it.
    #[inline(always)]
    fn common_shear<I: Isa>(&self, isa: I) -> Option<BundleShear> {
        let axes = self.ray_axes(0);
        let [x, y, z] = axes.map(|axis| axis as usize);
        let mut longest = 0xff;
        let mut factors = [[Row::splat(0.0); BUNDLE_GROUPS]; 3];
        for group in 0..BUNDLE_GROUPS {
            let [dx, dy, dz] = [x, y, z].map(|axis| &self.direction[axis][group]);
            let (dx, dy, dz) = (isa.load(dx), isa.load(dy), isa.load(dz));
            // Strictly: of equally long axes each ray takes the first.
            longest &= dx.abs().less(dz.abs()) & dy.abs().less(dz.abs());
            let scale = isa.load(&self.reciprocal[z][group]);
            factors[0][group] = Row((dx * scale).to_array());
            factors[1][group] = Row((dy * scale).to_array());
            factors[2][group] = Row(scale.to_array());
        }
        (longest == 0xff).then_some(BundleShear { axes, factors })
    }

    #[inline(always)]
    fn ray_axes(&self, place: usize) -> [Axis; 3] {
        let (group, lane) = (place / WIDTH % BUNDLE_GROUPS, place % WIDTH);
        let [x, y, z] = &self.direction;
        Shear::new(Vec3::new(x[group].0[lane], y[group].0[lane], z[group].0[lane])).axes
    }

    /// Whether triangles can be tested against groups of rays.
    #[inline(always)]
    pub(crate) fn has_common_axis(&self) -> bool {
        self.shear.is_some()
    }

    /// The hits of some of a group's rays with a triangle; rays must have a common axis.
    #[inline(always)]
    pub(crate) fn solve<I: Isa>(&self, isa: I, group: usize, vertices: &[Vec3; 3]) -> Option<Solved> {
        let shear = self.shear.as_ref()?;
        let group = group % BUNDLE_GROUPS;
        let [x, y, z] = shear.axes;
        let relative = Relative {
            x: self.relative(isa, group, (x, vertices)),
            y: self.relative(isa, group, (y, vertices)),
            z: self.relative(isa, group, (z, vertices)),
        };
        let [sx, sy, sz] = &shear.factors;
        let rays = RayLanes {
            factors: [isa.load(&sx[group]), isa.load(&sy[group]), isa.load(&sz[group])],
            t_min: isa.load(&self.t_min[group]),
            limit: isa.load(&self.limit[group]),
        };
        Some(relative.solve(isa, &rays))
    }

    #[inline(always)]
    fn relative<I: Isa>(
        &self,
        isa: I,
        group: usize,
        (axis, [p0, p1, p2]): (Axis, &[Vec3; 3]),
    ) -> [I::F32; 3] {
        let origin = isa.load(&self.origin[axis as usize][group]);
        let [p0, p1, p2]: [[f32; 3]; 3] = [(*p0).into(), (*p1).into(), (*p2).into()];
        let axis = axis as usize;
        [isa.splat(p0[axis]) - origin, isa.splat(p1[axis]) - origin, isa.splat(p2[axis]) - origin]
    }

    #[inline(always)]
    fn frustum<I: Isa>(&self, isa: I, octant: Octant) -> Frustum {
        let (mut frustum_origin, mut reciprocal, mut widened) = ([[0.0; 3]; 2], [[0.0; 3]; 2], [[0.0; 3]; 2]);
        for axis in 0..3 {
            let [low, high] = range(isa, &self.origin[axis]);
            let negative = octant.index() >> axis & 1 == 1;
            // From the highest origin a plane ahead is nearest.
            let [enter, exit] = if negative { [low, high] } else { [high, low] };
            (frustum_origin[0][axis], frustum_origin[1][axis]) = (enter, exit);
            [reciprocal[0][axis], reciprocal[1][axis]] = range(isa, &self.reciprocal[axis]);
            [widened[0][axis], widened[1][axis]] = range(isa, &self.widened[axis]);
        }
        let [t_min, _] = range(isa, &self.t_min);
        let (enter, exit) = Planes::of(octant);
        let [enter_origin, exit_origin] = frustum_origin;
        Frustum { enter_origin, reciprocal, exit_origin, widened, enter, exit, octant, t_min }
    }

    /// The largest parameter that counts for a ray.
    #[inline(always)]
    pub(crate) fn limit(&self, place: usize) -> f32 {
        self.limit[place / WIDTH % BUNDLE_GROUPS].0[place % WIDTH]
    }

    /// Sets the largest parameter that counts for a ray.
    #[inline(always)]
    pub(crate) fn set_limit(&mut self, place: usize, limit: f32) {
        let (group, lane) = (place / WIDTH % BUNDLE_GROUPS, place % WIDTH);
        self.limit[group].0[lane] = limit;
        self.reach[group].0[lane] = limit * EXIT_WIDENING;
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
        let group = group % BUNDLE_GROUPS;
        let enter =
            self.crossing(isa, &self.reciprocal, group, (2, near[2])).max(isa.load(&self.t_min[group]));
        let enter = self.crossing(isa, &self.reciprocal, group, (1, near[1])).max(enter);
        let enter = self.crossing(isa, &self.reciprocal, group, (0, near[0])).max(enter);
        let exit = self.crossing(isa, &self.widened, group, (2, far[2])).min(isa.load(&self.reach[group]));
        let exit = self.crossing(isa, &self.widened, group, (1, far[1])).min(exit);
        let exit = self.crossing(isa, &self.widened, group, (0, far[0])).min(exit);
        enter.less_or_equal(exit)
    }

    #[inline(always)]
    fn crossing<I: Isa>(
        &self,
        isa: I,
        reciprocal: &[[Row; BUNDLE_GROUPS]; 3],
        group: usize,
        (axis, plane): (usize, f32),
    ) -> I::F32 {
        (isa.splat(plane) - isa.load(&self.origin[axis][group])) * isa.load(&reciprocal[axis][group])
    }
}

/// What is known of a group of rays; one bit a lane.
struct GroupLanes {
    usable: u32,
    /// Whether the direction is negative, one an axis.
    negative: [u32; 3],
}

/// The least and the greatest of all numbers in the rows.
#[inline(always)]
fn range<I: Isa>(isa: I, rows: &[Row; BUNDLE_GROUPS]) -> [f32; 2] {
    let first = isa.load(&rows[0]);
    let (mut low, mut high) = (first, first);
    for row in &rows[1..] {
        let row = isa.load(row);
        (low, high) = (low.min(row), high.max(row));
    }
    let least = low.to_array().into_iter().fold(f32::INFINITY, f32::min);
    [least, high.to_array().into_iter().fold(f32::NEG_INFINITY, f32::max)]
}
