//! The bounds of a bundle: which boxes any of its rays may meet, and between which slopes they lie.

use super::super::beam::{Beam, MAX_GROUPS, SLOPE_ERROR, SlopeRange};
use super::super::isa::{Interval, Isa, Lanes, Octant};
use super::super::node::{EXIT_WIDENING, Node, PlaneRows};
use super::super::{BUNDLE_RAYS, WIDTH};
use super::{BundleShear, RayBundle, range};

/// The bounds of a bundle: each number is the least or the greatest among its rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frustum {
    /// What gives the lowest parameter at a plane where rays enter, one an axis.
    enter_origin: [f32; 3],
    reciprocal: [[f32; 3]; 2],
    /// What gives the highest parameter at a plane where rays leave.
    exit_origin: [f32; 3],
    widened: [[f32; 3]; 2],
    rows: PlaneRows,
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
        let offset = isa.load(node.planes(self.rows.enter[axis])) - isa.splat(self.enter_origin[axis]);
        let [low, high] = &self.reciprocal;
        (offset * isa.splat(low[axis])).min(offset * isa.splat(high[axis]))
    }

    #[inline(always)]
    fn highest<I: Isa>(&self, isa: I, node: Node<'_>, axis: usize) -> I::F32 {
        let offset = isa.load(node.planes(self.rows.exit[axis])) - isa.splat(self.exit_origin[axis]);
        let [low, high] = &self.widened;
        (offset * isa.splat(low[axis])).max(offset * isa.splat(high[axis]))
    }

    /// The planes of a child's box where the rays enter, and those where they leave.
    #[inline(always)]
    pub(crate) fn child_planes(&self, node: Node<'_>, lane: usize) -> [[f32; 3]; 2] {
        let lane = lane % WIDTH;
        let [x, y, z] = self.rows.enter;
        let enter = [node.planes(x).0[lane], node.planes(y).0[lane], node.planes(z).0[lane]];
        let [x, y, z] = self.rows.exit;
        [enter, [node.planes(x).0[lane], node.planes(y).0[lane], node.planes(z).0[lane]]]
    }
}

impl RayBundle {
    /// The bounds of the rays; `origins` are the least and the greatest coordinate of their origins on each axis.
    #[inline(always)]
    pub(super) fn frustum<I: Isa>(&self, isa: I, octant: Octant, origins: &[[f32; 2]; 3]) -> Frustum {
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
        let [enter_origin, exit_origin] = frustum_origin;
        Frustum { enter_origin, reciprocal, exit_origin, widened, rows: PlaneRows::of(octant), octant, t_min }
    }

    /// The slopes of rays that start at one point; `None` for others, and without a common axis.
    #[inline(always)]
    pub(super) fn beam<I: Isa>(&self, isa: I, origins: &[[f32; 2]; 3]) -> Option<Beam> {
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
}
