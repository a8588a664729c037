//! Which child of a node stands in which lane.
//!
//! A traversal may visit the lanes `k ^ o` for ascending `k`, where `o` has a bit set for each axis along which the ray's
//! direction is negative. Children are placed so that this is about the order from near to far.
//!
//! Source: Ylitie, Karras, Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, High Performance
//! Graphics 2017, section 3.2. Deviation: the assignment is improved by exchanging pairs instead of an auction.

use crate::build::Box8;
use crate::kernel::WIDTH;

/// More rounds are not made; two or three are enough nearly always.
const MAX_ROUNDS: u32 = 8;

/// The lane of each of up to eight boxes.
///
/// The sum of the distances along the lanes' diagonals, from the middle of the boxes' middles, is the largest that exchanging two
/// lanes finds.
pub(super) fn assign(boxes: &[Box8]) -> [usize; WIDTH] {
    let mut middle = [0.0; 3];
    for one in boxes {
        let center = one.doubled_center();
        middle = std::array::from_fn(|axis| middle[axis] + center[axis]);
    }
    let share = 1.0 / boxes.len() as f32;
    // Lanes without a child hold a place without extent.
    let mut offsets = [[0.0_f32; 3]; WIDTH];
    for (offset, one) in offsets.iter_mut().zip(boxes) {
        let center = one.doubled_center();
        *offset = std::array::from_fn(|axis| center[axis] - middle[axis] * share);
    }
    let mut occupants: [usize; WIDTH] = std::array::from_fn(|lane| lane);
    for _ in 0..MAX_ROUNDS {
        if !improve(&offsets, &mut occupants) {
            break;
        }
    }
    let mut assigned = [0; WIDTH];
    for (lane, &occupant) in occupants.iter().enumerate() {
        assigned[occupant % WIDTH] = lane;
    }
    assigned
}

/// Exchanges the occupants of two lanes wherever that helps; returns whether it did.
fn improve(offsets: &[[f32; 3]; WIDTH], occupants: &mut [usize; WIDTH]) -> bool {
    let mut improved = false;
    for a in 0..WIDTH {
        for b in a + 1..WIDTH {
            let [p, q] = [occupants[a], occupants[b]].map(|occupant| offsets[occupant % WIDTH]);
            // Moving from lane `a` to `b` gains along the axes whose bits `b` alone has.
            let along = |axis: usize| ((b >> axis & 1) as i32 - (a >> axis & 1) as i32) as f32;
            let gain: f32 = (0..3).map(|axis| (p[axis] - q[axis]) * along(axis)).sum();
            if gain > 0.0 {
                occupants.swap(a, b);
                improved = true;
            }
        }
    }
    improved
}
