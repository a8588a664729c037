//! A node with the boxes of four children, and the test of a ray against all four.

use sahl_math::{Bounds3, Ray, gamma};

use super::F32x4;

/// Children of a node.
pub(crate) const WIDTH: usize = 4;

/// How much later than computed a ray may leave a box.
///
/// A plane's parameter comes out of three rounded operations, and the triangle test shifts the ray against the triangle by
/// four more; both planes of an interval may err. Widening the exit by 2 γ₇ makes the test conservative for the
/// triangle test, not only for exact geometry. Source: Ize, *Robust BVH Ray Traversal*, JCGT 2(2), 2013.
pub(crate) const EXIT_WIDENING: f32 = 1.0 + 2.0 * gamma(7);

/// Four boxes as a structure of arrays, and what they hold.
#[derive(Clone, Debug)]
#[repr(C, align(16))]
pub(crate) struct Node {
    /// Rows: smallest x, y, z, then largest x, y, z; one lane a child. A lane without a child holds an empty box.
    planes: [[f32; WIDTH]; 6],
    /// Encoded references, see [`crate::layout`].
    pub(crate) children: [u32; WIDTH],
}

/// A ray prepared for [`Node::hits`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeRay {
    origin: [f32; 3],
    reciprocal: [f32; 3],
    /// Which rows hold the planes where the ray enters, one an axis.
    enter: [usize; 3],
    /// Which rows hold those where it leaves.
    exit: [usize; 3],
    t_min: f32,
}

/// Which children a ray meets, one bit each, and where it enters them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeHits {
    pub(crate) mask: u32,
    pub(crate) enter: F32x4,
}

impl Node {
    /// A node without children.
    pub(crate) fn empty() -> Self {
        let row = |value: f32| [value; WIDTH];
        let (low, high) = (row(f32::INFINITY), row(f32::NEG_INFINITY));
        Self { planes: [low, low, low, high, high, high], children: [u32::MAX; WIDTH] }
    }

    pub(crate) fn set(&mut self, lane: usize, bounds: &Bounds3, child: u32) {
        for axis in 0..3 {
            self.planes[axis][lane] = bounds.min[axis];
            self.planes[axis + 3][lane] = bounds.max[axis];
        }
        self.children[lane] = child;
    }

    /// The children whose boxes the ray meets before `t_max`.
    #[inline(always)]
    pub(crate) fn hits(&self, ray: &NodeRay, t_max: f32) -> NodeHits {
        let crossing = |row: usize, axis: usize| {
            (F32x4::load(&self.planes[row]) - F32x4::splat(ray.origin[axis]))
                * F32x4::splat(ray.reciprocal[axis])
        };
        let [enter_x, enter_y, enter_z] = ray.enter;
        let [exit_x, exit_y, exit_z] = ray.exit;
        // A plane that holds the origin of a ray along it gives NaN, and the operand after it is taken: such a
        // plane bounds nothing.
        let enter = crossing(enter_z, 2).max(F32x4::splat(ray.t_min));
        let enter = crossing(enter_x, 0).max(crossing(enter_y, 1).max(enter));
        let exit = crossing(exit_z, 2).min(F32x4::splat(t_max));
        let exit = crossing(exit_x, 0).min(crossing(exit_y, 1).min(exit));
        NodeHits { mask: enter.less_or_equal(exit * F32x4::splat(EXIT_WIDENING)), enter }
    }
}

impl NodeRay {
    #[inline]
    pub(crate) fn new(ray: &Ray) -> Self {
        let reciprocal: [f32; 3] = ray.direction.map(|x| 1.0 / x).into();
        let enter = std::array::from_fn(|axis| if reciprocal[axis] < 0.0 { axis + 3 } else { axis });
        let exit = std::array::from_fn(|axis| if reciprocal[axis] < 0.0 { axis } else { axis + 3 });
        Self { origin: ray.origin.into(), reciprocal, enter, exit, t_min: ray.t_min }
    }
}

#[cfg(test)]
mod tests {
    use sahl_math::Vec3;

    use super::*;

    fn node(boxes: &[Bounds3]) -> Node {
        let mut node = Node::empty();
        for (lane, bounds) in boxes.iter().enumerate() {
            node.set(lane, bounds, lane as u32);
        }
        node
    }

    fn mask(node: &Node, origin: Vec3, direction: Vec3) -> u32 {
        node.hits(&NodeRay::new(&Ray::new(origin, direction)), f32::MAX).mask
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
        let hits = node.hits(&NodeRay::new(&Ray::new(Vec3::new(0.3, 2.0, 0.4), -Vec3::Y)), 1.5);
        assert_eq!(hits.mask, 0, "the interval ends before the box");
    }
}
