//! Rays that go nearly the same way: the boxes that any of them may meet, and which of them meet one box.

use sahl_math::{Ray, Vec3};

use super::WIDTH;
use super::beam::{Beam, BeamVertices, MAX_GROUPS, SLOPE_ERROR, SlopeRange};
use super::block::TriangleBlock;
use super::isa::{BundleRow, Interval, Isa, Lanes, Octant, Row};
use super::node::{EXIT_WIDENING, Node, Planes};
use super::watertight::{RayLanes, Relative, SolvedArrays};
use crate::geometry::triangle::{Axis, Shear};

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
const NOTHING: Row = Row::splat(f32::from_bits(u32::MAX));

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
        let zero = [Row::splat(0.0); ROWS];
        Self {
            origin: [zero; 3],
            reciprocal: [zero; 3],
            widened: [zero; 3],
            direction: [zero; 3],
            t_min: zero,
            limit: zero,
            reach: zero,
            id: [NOTHING; ROWS],
            instance: [NOTHING; ROWS],
            weights: [zero; 2],
            shear: None,
        }
    };

    /// Replaces the rays by some of up to [`BUNDLE_RAYS`] others, one bit each in `wanted`.
    ///
    /// Not members are rays in another octant than the first member, along an axis, or that hit nothing.
    #[inline(always)]
    pub(crate) fn load<I: Isa>(&mut self, isa: I, rays: &[Ray], wanted: u64) -> Option<Loaded> {
        self.copy(rays);
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
        self.id = [NOTHING; ROWS];
        self.instance = [NOTHING; ROWS];
        self.shear = self.common_shear(isa, first);
        let [x, y, z] = &self.origin;
        let origins = [range(isa, x), range(isa, y), range(isa, z)];
        let (frustum, beam) = (self.frustum(isa, octant, &origins), self.beam(isa, &origins));
        Some(Loaded { members, others: usable & !members, frustum, beam })
    }

    /// Copies what is given of the rays; `reach` holds the ends of their intervals until [`Self::prepare_group`].
    #[inline(always)]
    fn copy(&mut self, rays: &[Ray]) {
        for (row, rays) in rays.chunks(WIDTH).enumerate().take(ROWS) {
            for (lane, ray) in rays.iter().enumerate() {
                let (o, d): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.direction.into());
                for axis in 0..3 {
                    self.origin[axis][row].0[lane] = o[axis];
                    self.direction[axis][row].0[lane] = d[axis];
                }
                self.t_min[row].0[lane] = ray.t_min;
                self.reach[row].0[lane] = ray.t_max;
                // The number before `t_max`: of members that is positive.
                self.limit[row].0[lane] = f32::from_bits(ray.t_max.to_bits().wrapping_sub(1));
            }
        }
    }

    #[inline(always)]
    fn prepare_group<I: Isa>(&mut self, isa: I, group: usize) -> GroupLanes {
        let t_max = isa.load_wide(&self.reach, group);
        let zero = t_max.splat(0.0);
        let t_min = isa.load_wide(&self.t_min, group).max(zero);
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
        isa.store_wide(t_min, &mut self.t_min, group);
        isa.store_wide(isa.load_wide(&self.limit, group) * widening, &mut self.reach, group);
        lanes
    }

    /// Makes rays meet nothing, and repeats another in their places, which moves no bounds.
    #[inline(always)]
    fn exclude(&mut self, mut places: u64, other: usize) {
        let (other_group, other_lane) = (other / WIDTH % ROWS, other % WIDTH);
        while places != 0 {
            let place = places.trailing_zeros() as usize;
            places &= places - 1;
            let (group, lane) = (place / WIDTH % ROWS, place % WIDTH);
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
    fn common_shear<I: Isa>(&self, isa: I, first: usize) -> Option<BundleShear> {
        let axes = self.ray_axes(first);
        let [x, y, z] = axes.map(|axis| axis as usize);
        let mut longest = true;
        let mut factors = [[Row::splat(0.0); ROWS]; 3];
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
        let (group, lane) = (place / WIDTH % ROWS, place % WIDTH);
        let [x, y, z] = &self.direction;
        Shear::new(Vec3::new(x[group].0[lane], y[group].0[lane], z[group].0[lane])).axes
    }

    /// Whether triangles can be tested against groups of rays.
    #[inline(always)]
    pub(crate) fn has_common_axis(&self) -> bool {
        self.shear.is_some()
    }

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

    #[inline(always)]
    fn frustum<I: Isa>(&self, isa: I, octant: Octant, origins: &[[f32; 2]; 3]) -> Frustum {
        let (mut frustum_origin, mut reciprocal, mut widened) = ([[0.0; 3]; 2], [[0.0; 3]; 2], [[0.0; 3]; 2]);
        for axis in 0..3 {
            let [low, high] = origins[axis];
            let negative = octant.index() >> axis & 1 == 1;
            // From the highest origin a plane ahead is nearest.
            let [enter, exit] = if negative { [low, high] } else { [high, low] };
            (frustum_origin[0][axis], frustum_origin[1][axis]) = (enter, exit);
            [reciprocal[0][axis], reciprocal[1][axis]] = range(isa, &self.reciprocal[axis]);
            // As each ray's is made of its reciprocal: rounding is monotonic.
            [widened[0][axis], widened[1][axis]] =
                [reciprocal[0][axis] * EXIT_WIDENING, reciprocal[1][axis] * EXIT_WIDENING];
        }
        let [t_min, _] = range(isa, &self.t_min);
        let (enter, exit) = Planes::of(octant);
        let [enter_origin, exit_origin] = frustum_origin;
        Frustum { enter_origin, reciprocal, exit_origin, widened, enter, exit, octant, t_min }
    }

    #[inline(always)]
    fn beam<I: Isa>(&self, isa: I, origins: &[[f32; 2]; 3]) -> Option<Beam> {
        let BundleShear { axes, factors: [sx, sy, _] } = self.shear.as_ref()?;
        let mut origin = [0.0; 3];
        for (coordinate, &axis) in origin.iter_mut().zip(axes) {
            let [low, high] = origins[axis as usize];
            if low != high {
                return None;
            }
            *coordinate = low;
        }
        let ([low_x, high_x], [low_y, high_y]) = (range(isa, sx), range(isa, sy));
        let middle = [0.5 * low_x + 0.5 * high_x, 0.5 * low_y + 0.5 * high_y];
        let mut groups = [SlopeRange::default(); MAX_GROUPS];
        let mut spread = 0.0_f32;
        for (place, group) in groups.iter_mut().take(BUNDLE_RAYS / I::WIDE).enumerate() {
            for (axis, slopes) in [sx, sy].into_iter().enumerate() {
                let lanes = isa.load_wide(slopes, place);
                let (low, high) = (lanes.least() - middle[axis], lanes.greatest() - middle[axis]);
                group.center[axis] = 0.5 * low + 0.5 * high;
                group.radius[axis] = 0.5 * (high - low) + SLOPE_ERROR;
                spread = spread.max(low.abs()).max(high.abs());
            }
        }
        Some(Beam { origin, axes: *axes, middle, spread: spread + SLOPE_ERROR, groups })
    }

    /// What a ray has hit.
    #[inline(always)]
    pub(crate) fn nearest(&self, place: usize) -> NearestHit {
        let (group, lane) = (place / WIDTH % ROWS, place % WIDTH);
        NearestHit {
            t: self.limit[group].0[lane],
            id: self.id[group].0[lane].to_bits(),
            instance: self.instance[group].0[lane].to_bits(),
            weights: [self.weights[0][group].0[lane], self.weights[1][group].0[lane]],
        }
    }

    /// Replaces what a ray has hit.
    #[inline(always)]
    pub(crate) fn set_nearest(&mut self, place: usize, hit: NearestHit) {
        let (group, lane) = (place / WIDTH % ROWS, place % WIDTH);
        self.set_limit(place, hit.t);
        self.id[group].0[lane] = f32::from_bits(hit.id);
        self.instance[group].0[lane] = f32::from_bits(hit.instance);
        for (rows, weight) in self.weights.iter_mut().zip(hit.weights) {
            rows[group].0[lane] = weight;
        }
    }

    /// Sets the largest parameter that counts for a ray.
    #[inline(always)]
    fn set_limit(&mut self, place: usize, limit: f32) {
        let (group, lane) = (place / WIDTH % ROWS, place % WIDTH);
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
