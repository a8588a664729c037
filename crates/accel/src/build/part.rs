//! Parting a range at a plane.

use super::bins::Plane;
use super::mapping::{Mapping, border_of};
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

/// What is added to a reference for the box about the left side, or, one place further, for that about the right side: the first place if
/// it goes left, and the second if it goes right. Infinity removes it from every minimum.
pub(super) static REMOVED: [Row; 3] = [Row::splat(0.0), Row::splat(f32::INFINITY), Row::splat(0.0)];

impl<const BOUNDS: bool> Task for Partition<'_, BOUNDS> {
    type Output = Parted;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Parted {
        let Self { references, mapping, plane } = self;
        let axis = plane.axis % 3;
        let mapping = mapping.on(axis);
        let border = border_of(plane.bin);
        let mut boxes = [isa.splat(f32::INFINITY); 2];
        let mut left_count = 0_usize;
        for i in 0..references.len() {
            let position = references[i].doubled_center_at(axis);
            let goes_right = usize::from(mapping.rounded(position) > border);
            let reference = references[i];
            let own =
                if BOUNDS { isa.load(reference.bounds().row()) } else { reference.doubled_center_on(isa) };
            let left = own + isa.load(&REMOVED[goes_right]);
            let right = own + isa.load(&REMOVED[goes_right + 1]);
            boxes = [boxes[0].min(left), boxes[1].min(right)];
            references[i] = references[left_count];
            references[left_count] = reference;
            left_count += 1 - goes_right;
        }
        Parted { left_count, boxes: boxes.map(|lanes| Box8::from_row(Row(lanes.to_array()))) }
    }
}
