//! Parting a range at a plane.

use super::bins::Plane;
use super::mapping::Mapping;
use super::reference::{Box8, Reference};
use crate::kernel::{Isa, Lanes, Row, Task};

/// Moves what goes left to the front, without branches that cannot be predicted, and finds the boxes about both sides: about
/// the references if `BOUNDS`, and about their doubled centres otherwise.
pub(super) struct Partition<'a, const BOUNDS: bool> {
    pub(super) references: &'a mut [Reference],
    pub(super) mapping: &'a Mapping,
    pub(super) plane: Plane,
}

/// How references were parted.
pub(super) struct Parted {
    pub(super) left_count: usize,
    pub(super) boxes: [Box8; 2],
}

impl<const BOUNDS: bool> Task for Partition<'_, BOUNDS> {
    type Output = Parted;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Parted {
        let Self { references, mapping, plane } = self;
        let axis = plane.axis % 3;
        let mut boxes = [isa.splat(f32::INFINITY); 2];
        let mut left_count = 0_usize;
        for i in 0..references.len() {
            let bin = mapping.bin(references[i].doubled_center_at(axis), axis);
            let reference = references[i];
            // All bits set if it goes right. Infinity, added to a box, removes it from every minimum.
            let goes_right = (plane.bin as i32 - bin as i32) >> 31;
            let removed = |mask: i32| isa.splat(f32::from_bits(mask as u32 & f32::INFINITY.to_bits()));
            let own = if BOUNDS {
                isa.load(reference.bounds().row())
            } else {
                isa.load(&reference.doubled_center_row())
            };
            boxes = [boxes[0].min(own + removed(goes_right)), boxes[1].min(own + removed(!goes_right))];
            references[i] = references[left_count];
            references[left_count] = reference;
            left_count = (left_count + 1).wrapping_add_signed(goes_right as isize);
        }
        Parted { left_count, boxes: boxes.map(|lanes| Box8::from_row(Row(lanes.to_array()))) }
    }
}
