//! Which child of a node stands in which lane.
//!
//! A traversal may visit the lanes `k ^ o` for ascending `k`, where `o` has a bit set for each axis along which the ray's
//! direction is negative. Children are placed so that this is about the order from near to far.
//!
//! Source: Ylitie, Karras, Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, High Performance
//! Graphics 2017, section 3.2. Deviation: the assignment is improved by exchanging pairs instead of an auction.

use crate::build::Box8;
use crate::kernel::{Isa, Lanes, Machine, Row, Task, WIDTH};

/// More rounds are not made; two or three are enough nearly always.
const MAX_ROUNDS: u32 = 8;

/// The lane of each of up to eight boxes.
///
/// The sum of the distances along the lanes' diagonals, from the middle of the boxes' middles, is the largest that exchanging two
/// lanes finds.
pub(super) fn assign(machine: Machine, boxes: &[Box8]) -> [usize; WIDTH] {
    let mut middle = [0.0; 3];
    for one in boxes {
        let center = one.doubled_center();
        middle = std::array::from_fn(|axis| middle[axis] + center[axis]);
    }
    let share = 1.0 / boxes.len() as f32;
    // Lanes without a child hold a place without extent.
    let mut offsets = [Row::splat(0.0); 3];
    for (place, one) in boxes.iter().enumerate().take(WIDTH) {
        let center = one.doubled_center();
        for axis in 0..3 {
            offsets[axis].0[place] = center[axis] - middle[axis] * share;
        }
    }
    let occupants = machine.run(Exchanges { offsets });
    let mut assigned = [0; WIDTH];
    for (lane, &occupant) in occupants.iter().enumerate() {
        assigned[occupant % WIDTH] = lane;
    }
    assigned
}

/// Exchanges the occupants of two lanes wherever that helps, again and again; yields the occupant of each lane.
struct Exchanges {
    /// Where the occupants of the lanes are, a row an axis.
    offsets: [Row; 3],
}

impl Task for Exchanges {
    type Output = [usize; WIDTH];

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> [usize; WIDTH] {
        let Self { mut offsets } = self;
        let mut occupants: [usize; WIDTH] = std::array::from_fn(|lane| lane);
        for _ in 0..MAX_ROUNDS {
            let mut improved = false;
            for a in 0..WIDTH {
                let mut better = gains(isa, &offsets, a) & after(a);
                while better != 0 {
                    let b = better.trailing_zeros() as usize % WIDTH;
                    occupants.swap(a, b);
                    for row in &mut offsets {
                        row.0.swap(a, b);
                    }
                    improved = true;
                    better = gains(isa, &offsets, a) & after(b);
                }
            }
            if !improved {
                break;
            }
        }
        occupants
    }
}

/// One bit for each lane with whose occupant that of lane `a` had better be exchanged.
#[inline(always)]
fn gains<I: Isa>(isa: I, offsets: &[Row; 3], a: usize) -> u32 {
    let (mut gains, along) = (isa.splat(0.0), &ALONG[a % WIDTH]);
    for (offsets, along) in offsets.iter().zip(along) {
        let apart = isa.splat(offsets.0[a % WIDTH]) - isa.load(offsets);
        gains = gains + apart * isa.load(along);
    }
    isa.splat(0.0).less(gains)
}

/// The lanes after a lane, one bit each.
#[inline(always)]
fn after(lane: usize) -> u32 {
    u32::MAX << 1 << lane
}

/// For each lane and axis, which way from there to each lane: moving gains along the axes whose bits the other lane alone has.
static ALONG: [[Row; 3]; WIDTH] = {
    let mut along = [[Row::splat(0.0); 3]; WIDTH];
    let mut place = 0;
    while place < WIDTH * 3 * WIDTH {
        let (a, axis, b) = (place / (3 * WIDTH), place / WIDTH % 3, place % WIDTH);
        along[a][axis].0[b] = ((b >> axis & 1) as i32 - (a >> axis & 1) as i32) as f32;
        place += 1;
    }
    along
};

#[cfg(test)]
mod tests {
    use sahl_math::{Bounds3, Vec3};

    use super::*;
    use crate::kernel::Tier;

    fn unit_box(x: f32, y: f32, z: f32) -> Box8 {
        let min = Vec3::new(x, y, z);
        Box8::new(&Bounds3 { min, max: min + Vec3::ONE })
    }

    /// The sum of the distances along the lanes' diagonals.
    fn gain(boxes: &[Box8], lanes: &[usize; WIDTH]) -> f32 {
        let along = |lane: usize, axis: usize| if lane >> axis & 1 == 1 { 0.5 } else { -0.5 };
        let of_box = |(one, &lane): (&Box8, &usize)| {
            let center = one.doubled_center();
            (0..3).map(|axis| center[axis] * along(lane, axis)).sum::<f32>()
        };
        boxes.iter().zip(lanes).map(of_box).sum()
    }

    #[test]
    fn boxes_in_the_corners_of_a_cube_get_the_lanes_of_these() {
        let corner = |lane: usize| [0, 1, 2].map(|axis| (lane >> axis & 1) as f32 * 3.0);
        // In any order: here every third one.
        let order: [usize; WIDTH] = std::array::from_fn(|place| place * 3 % WIDTH);
        let boxes = order.map(corner).map(|[x, y, z]| unit_box(x, y, z));
        for tier in Tier::ALL.into_iter().filter(|tier| tier.is_available()) {
            assert_eq!(assign(Machine::choose(Some(tier)), &boxes), order, "{tier:?}");
        }
    }

    #[test]
    fn no_exchange_of_two_lanes_helps_any_more_on_any_tier() {
        for count in 1..=WIDTH {
            let place = |i: usize, k: usize| (i * k % 17) as f32;
            let boxes: Vec<Box8> =
                (1..=count).map(|i| unit_box(place(i, 7), place(i, 11), place(i, 5))).collect();
            let assigned = assign(Machine::choose(Some(Tier::Scalar)), &boxes);
            let mut sorted = assigned;
            sorted[..count].sort_unstable();
            assert!(sorted[..count].windows(2).all(|pair| pair[0] < pair[1]), "{assigned:?}");
            for tier in Tier::ALL.into_iter().filter(|tier| tier.is_available()) {
                assert_eq!(assign(Machine::choose(Some(tier)), &boxes), assigned, "{tier:?}");
            }
            let best = gain(&boxes, &assigned);
            for (a, b) in (0..count).flat_map(|a| (0..a).map(move |b| (a, b))) {
                let mut exchanged = assigned;
                exchanged.swap(a, b);
                assert!(gain(&boxes, &exchanged) <= best + 1e-3, "{count} boxes, {a} and {b}");
            }
        }
    }
}
