//! Which of the rays in flight wait for what.

use super::stream::SLOTS;
use crate::layout::Stage;

/// The slots that wait, as sets of bits.
///
/// In a register: queues in memory would make every step wait for the last, because the processor could not tell whether the
/// place that one writes is the place that the other reads.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Waiting {
    /// Those before a node in the lower half, those before a block in the upper; and there also some of those that are `rare`.
    likely: u64,
    /// Those before other primitives, and those that are done.
    rare: u32,
}

const _: () = assert!(SLOTS == 32);
const _: () = assert!(Stage::Node as u32 == 0 && Stage::Block as u32 == 1);
const _: () = assert!(Stage::Other as u32 == 2 && Stage::Done as u32 == 3);

impl Waiting {
    #[inline(always)]
    pub(super) fn join(&mut self, child: u32, slot: usize) {
        // The two lowest bits are the stage: the lower one is the half, as what is above it falls out of the modulo, and the higher one tells the
        // rare from the likely.
        self.likely |= 1 << ((child << 5 | slot as u32) % u64::BITS);
        self.rare |= (child >> 1 & 1) << slot;
    }

    /// Those before a node, none of which waits any more.
    #[inline(always)]
    pub(super) fn take_nodes(&mut self) -> SlotSet {
        let set = self.likely as u32 & !self.rare;
        self.likely &= !u64::from(u32::MAX);
        SlotSet(set)
    }

    /// Those before a block, none of which waits any more.
    #[inline(always)]
    pub(super) fn take_blocks(&mut self) -> SlotSet {
        let set = (self.likely >> 32) as u32 & !self.rare;
        self.likely &= u64::from(u32::MAX);
        SlotSet(set)
    }

    /// The others, none of which waits any more.
    #[inline(always)]
    pub(super) fn take_rare(&mut self) -> SlotSet {
        let set = self.rare;
        self.likely &= !(u64::from(set) | u64::from(set) << 32);
        self.rare = 0;
        SlotSet(set)
    }
}

/// Slots, as a set of bits; iterated in ascending order.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct SlotSet(u32);

impl SlotSet {
    #[inline(always)]
    pub(super) fn insert_if(&mut self, condition: bool, slot: usize) {
        self.0 |= u32::from(condition) << slot;
    }

    #[inline(always)]
    pub(super) fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }
}

impl Iterator for SlotSet {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let slot = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(slot % SLOTS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Child;

    #[test]
    fn waiting_slots_are_taken_once_whatever_is_taken_first() {
        let stages = [
            Child::Node(7),
            Child::Block(1 << 29),
            Child::Instance(5),
            Child::Node(1 << 29),
            Child::Curve(9),
        ];
        for first in 0..3 {
            let mut waiting = Waiting::default();
            for (slot, child) in stages.iter().enumerate() {
                waiting.join(child.encode(), slot);
            }
            waiting.join(Child::NOTHING, 31);
            let mut taken = [SlotSet::default(); 3];
            for kind in (first..first + 3).map(|kind| kind % 3) {
                taken[kind] = match kind {
                    0 => waiting.take_nodes(),
                    1 => waiting.take_blocks(),
                    _ => waiting.take_rare(),
                };
            }
            assert!(waiting == Waiting::default());
            assert_eq!(taken.map(|set| set.0), [0b01001, 0b00010, 0b10100 | 1 << 31]);
            waiting.join(Child::Block(3).encode(), 31);
            assert_eq!(
                [waiting.take_nodes().0, waiting.take_rare().0, waiting.take_blocks().0],
                [0, 0, 1 << 31]
            );
        }
    }
}
