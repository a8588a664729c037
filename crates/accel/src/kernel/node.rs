//! A node with the boxes of eight children, and the test of a ray against all eight.

use sahl_math::{Bounds3, gamma};

use super::isa::{Interval, Isa, Lanes, Octant, Row};
use super::prepared::PreparedRay;

/// Rows of a node.
pub(crate) const NODE_ROWS: usize = 7;

/// How much later than computed a ray may leave a box.
///
/// A plane's parameter comes out of three rounded operations, and the triangle test shifts the ray against the triangle by
/// four more; both planes of an interval may err. Widening the exit by 2 γ₇ makes the test conservative for the
/// triangle test, not only for exact geometry. Source: Ize, *Robust BVH Ray Traversal*, JCGT 2(2), 2013.
pub(crate) const EXIT_WIDENING: f32 = 1.0 + 2.0 * gamma(7);

/// Eight boxes as a structure of arrays, and what they hold.
///
/// Rows: smallest x, y, z, then largest x, y, z, then the bits of the encoded references, see [`crate::layout`]; one lane a child. A
/// lane without a child holds an empty box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node<'a>(pub(crate) &'a [Row; NODE_ROWS]);

/// A node without children.
pub(crate) const EMPTY_NODE: [Row; NODE_ROWS] = {
    let (low, high) = (Row::splat(f32::INFINITY), Row::splat(f32::NEG_INFINITY));
    [low, low, low, high, high, high, Row::splat(0.0)]
};

/// Writes a child into a lane of a node.
pub(crate) fn set_child(node: &mut [Row; NODE_ROWS], lane: usize, bounds: &Bounds3, child: u32) {
    for axis in 0..3 {
        node[axis].0[lane] = bounds.min[axis];
        node[axis + 3].0[lane] = bounds.max[axis];
    }
    node[CHILDREN].0[lane] = f32::from_bits(child);
}

/// A row of planes, as the distance in bytes from the beginning of the node.
#[derive(Clone, Copy, Debug)]
#[repr(u8)]
pub(super) enum Planes {
    MinX = 0,
    MinY = 32,
    MinZ = 64,
    MaxX = 96,
    MaxY = 128,
    MaxZ = 160,
}

/// Rows of planes, one an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaneRows {
    /// Those where the ray enters.
    pub(super) enter: [Planes; 3],
    /// Those where it leaves.
    pub(super) exit: [Planes; 3],
}

impl PlaneRows {
    /// Those of rays of an octant.
    pub(super) const fn of(octant: Octant) -> Self {
        use Planes::{MaxX, MaxY, MaxZ, MinX, MinY, MinZ};
        let (min, max) = ([MinX, MinY, MinZ], [MaxX, MaxY, MaxZ]);
        let mut rows = Self { enter: min, exit: max };
        let mut axis = 0;
        while axis < 3 {
            if octant.index() >> axis & 1 == 1 {
                (rows.enter[axis], rows.exit[axis]) = (max[axis], min[axis]);
            }
            axis += 1;
        }
        rows
    }
}

const _: () = assert!(Planes::MaxZ as usize == 5 * size_of::<Row>());

const CHILDREN: usize = 6;

impl<'a> Node<'a> {
    #[inline(always)]
    #[expect(unsafe_code, reason = "six multiplications and comparisons a node cost a tenth of the time")]
    pub(super) fn planes(self, planes: Planes) -> &'a Row {
        // SAFETY: each value is the distance of one of the first six of seven rows.
        unsafe { &*self.0.as_ptr().byte_add(planes as usize) }
    }

    /// The bits of the encoded references.
    #[inline(always)]
    pub(crate) fn children(self) -> &'a Row {
        &self.0[CHILDREN]
    }

    /// Where the ray enters and leaves the children's boxes before `reach`, which is [`EXIT_WIDENING`] times the largest
    /// parameter that counts: where `enter <= exit`, it meets them.
    #[inline(always)]
    pub(crate) fn interval<I: Isa>(self, isa: I, ray: &PreparedRay, reach: f32) -> Interval<I::F32> {
        let PlaneRows { enter: [enter_x, enter_y, enter_z], exit: [exit_x, exit_y, exit_z] } =
            ray.orientation().planes;
        let ([ox, oy, oz], [rx, ry, rz], [wx, wy, wz]) = (ray.origin(), ray.reciprocal(), ray.widened());
        // A plane that holds the origin of a ray along it and ends the box gives NaN, and the operand after it is taken:
        // such a plane bounds nothing, nor does the one before it. In pairs, which are a step less to wait for than a chain.
        let [x, y, z] = [
            self.crossing(isa, enter_x, (ox, rx)),
            self.crossing(isa, enter_y, (oy, ry)),
            self.crossing(isa, enter_z, (oz, rz)),
        ];
        let enter = x.max(y).max(z.max(isa.splat(ray.t_min())));
        let [x, y, z] = [
            self.crossing(isa, exit_x, (ox, wx)),
            self.crossing(isa, exit_y, (oy, wy)),
            self.crossing(isa, exit_z, (oz, wz)),
        ];
        let exit = x.min(y).min(z.min(isa.splat(reach)));
        Interval { enter, exit }
    }

    /// Where the ray crosses a row of planes.
    #[inline(always)]
    fn crossing<I: Isa>(self, isa: I, row: Planes, (origin, reciprocal): (f32, f32)) -> I::F32 {
        (isa.load(self.planes(row)) - isa.splat(origin)) * isa.splat(reciprocal)
    }
}

#[cfg(test)]
mod tests {
    use sahl_math::{Ray, Vec3};

    use super::*;
    use crate::kernel::scalar::Scalar;

    fn node(boxes: &[Bounds3]) -> [Row; NODE_ROWS] {
        let mut node = EMPTY_NODE;
        for (lane, bounds) in boxes.iter().enumerate() {
            set_child(&mut node, lane, bounds, lane as u32);
        }
        node
    }

    fn mask(node: &[Row; NODE_ROWS], origin: Vec3, direction: Vec3) -> u32 {
        mask_before(node, origin, direction, f32::MAX)
    }

    fn mask_before(node: &[Row; NODE_ROWS], origin: Vec3, direction: Vec3, t_max: f32) -> u32 {
        let Interval { enter, exit } =
            Node(node).interval(Scalar, &PreparedRay::of_usable(&Ray::new(origin, direction)), t_max);
        enter.less_or_equal(exit)
    }

    #[test]
    fn rays_along_faces_edges_and_through_corners_meet_the_box() {
        let unit = Bounds3 { min: Vec3::ZERO, max: Vec3::ONE };
        let node = node(&[unit]);
        for negative in [false, true] {
            for axis in 0..3 {
                for (s, t) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.5), (1.0, 0.5)] {
                    let (mut origin, mut direction) = (Vec3::ZERO, Vec3::ZERO);
                    origin[axis] = if negative { 3.0 } else { -2.0 };
                    origin[(axis + 1) % 3] = s;
                    origin[(axis + 2) % 3] = t;
                    direction[axis] = if negative { -0.1 } else { 0.1 };
                    assert_eq!(mask(&node, origin, direction), 1, "{origin:?} {direction:?}");
                    direction[(axis + 1) % 3] = -0.0;
                    assert_eq!(mask(&node, origin, direction), 1, "{origin:?} {direction:?}");
                    origin[(axis + 1) % 3] = 1.0_f32.next_up();
                    assert_eq!(mask(&node, origin, direction), 0, "{origin:?} {direction:?}");
                }
            }
        }
        for corner in unit.corners() {
            let origin = Vec3::new(-7.3, 5.1, 3.77);
            assert_eq!(mask(&node, origin, corner - origin), 1, "{corner:?}");
        }
    }

    #[test]
    fn flat_boxes_are_met_and_empty_lanes_never() {
        let flat = Bounds3 { min: Vec3::ZERO, max: Vec3::new(1.0, 0.0, 1.0) };
        let node = node(&[flat, flat, flat]);
        assert_eq!(mask(&node, Vec3::new(0.3, 2.0, 0.4), -Vec3::Y), 0b0111);
        assert_eq!(mask(&node, Vec3::new(-0.3, 0.0, 0.4), Vec3::X), 0b0111);
        assert_eq!(mask(&node, Vec3::new(0.3, 2.0, 0.4), Vec3::Y), 0);
        let before = mask_before(&node, Vec3::new(0.3, 2.0, 0.4), -Vec3::Y, 1.5);
        assert_eq!(before, 0, "the interval ends before the box");
    }
}
