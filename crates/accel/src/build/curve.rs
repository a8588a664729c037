//! The order of primitives on a space-filling curve.
//!
//! Source: Morton, *A Computer Oriented Geodetic Data Base and a New Technique in File Sequencing*, IBM 1966.

use rayon::prelude::*;

use super::reference::{Box8, Reference};
use crate::primitive::Item;

/// Cells an axis of the finest grid, less a little for rounding.
const CELLS: f32 = 1023.99;

/// Keys are put into buckets by the highest ten bits of their codes.
const BUCKET_SHIFT: u32 = 20;
const BUCKETS: usize = 1 << 10;

/// Bits by which a bucket is sorted in one pass.
const DIGIT_BITS: u32 = 10;

/// Smaller buckets are sorted by comparison.
const RADIX_SORTED: usize = 1 << 10;

/// How many keys one task puts into buckets: with their copy they stay in a cache of a megabyte.
const CHUNK: usize = 1 << 16;

/// Two words in one: in the upper half a primitive's place on the curve, in the lower half that among the references; or what kind of
/// primitive it is and its place among those.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Key(u64);

impl Key {
    const NONE: Self = Self(0);

    fn new(code: u32, place: usize) -> Self {
        Self(u64::from(code) << 32 | place as u64)
    }

    /// What primitive a reference refers to, instead of where.
    #[inline]
    pub(super) fn of_reference(reference: &Reference) -> Self {
        let (kind, place) = reference.key();
        Self(u64::from(kind) << 32 | u64::from(place))
    }

    /// The primitive of a key that [`Self::of_reference`] made.
    #[inline]
    pub(crate) fn item(self) -> Item {
        Item::decode((self.0 >> 32) as u32, self.0 as u32)
    }

    #[inline]
    pub(super) fn code(self) -> u32 {
        (self.0 >> 32) as u32
    }

    #[inline]
    pub(super) fn place(self) -> usize {
        self.0 as u32 as usize
    }
}

/// The keys of references in the order of the curve of Morton through a grid over all centres; `centers` is the box about these, doubled.
pub(super) fn sorted(references: &[Reference], centers: &Box8) -> Vec<Key> {
    let grid = Grid::new(centers);
    let chunks: Vec<Bucketed> = (references.par_chunks(CHUNK).enumerate())
        .map(|(i, references)| Bucketed::new(&grid, i * CHUNK, references))
        .collect();
    let mut sorted = vec![Key::NONE; references.len()];
    let mut rest = sorted.as_mut_slice();
    let mut buckets = Vec::with_capacity(BUCKETS);
    for bucket in 0..BUCKETS {
        let count = chunks.iter().map(|chunk| chunk.bucket(bucket).len()).sum();
        let (keys, after) = rest.split_at_mut(count);
        if count > 0 {
            buckets.push((bucket, keys));
        }
        rest = after;
    }
    buckets.into_par_iter().for_each(|(bucket, keys)| {
        let mut rest = &mut *keys;
        for chunk in &chunks {
            let found = chunk.bucket(bucket);
            let (own, after) = rest.split_at_mut(found.len());
            own.copy_from_slice(found);
            rest = after;
        }
        sort(keys);
    });
    sorted
}

/// The cells that codes are given to.
struct Grid {
    origin: [f32; 3],
    scale: f32,
}

impl Grid {
    fn new(centers: &Box8) -> Self {
        let [x, y, z, _] = centers.min();
        let [dx, dy, dz] = centers.diagonal();
        let scale = CELLS / dx.max(dy).max(dz);
        // All centres at one place, or extents beyond the range of `f32`.
        Self { origin: [x, y, z], scale: if scale.is_finite() { scale } else { 0.0 } }
    }

    /// The code of a reference's centre.
    #[inline]
    fn code(&self, reference: &Reference) -> u32 {
        let center = reference.doubled_center();
        let cell = |axis: usize| spread(((center[axis] - self.origin[axis]) * self.scale) as u32);
        cell(0) | cell(1) << 1 | cell(2) << 2
    }
}

/// Ten bits with two empty ones between each two of them.
#[inline]
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// The keys of some references by buckets; within one in the order of the references.
struct Bucketed {
    keys: Vec<Key>,
    /// Where each bucket ends.
    ends: [u32; BUCKETS],
}

impl Bucketed {
    fn new(grid: &Grid, first: usize, references: &[Reference]) -> Self {
        let key = |(offset, reference): (usize, &Reference)| Key::new(grid.code(reference), first + offset);
        let found: Vec<Key> = references.iter().enumerate().map(key).collect();
        let mut keys = vec![Key::NONE; found.len()];
        let ends = sort_by_digit(&found, &mut keys, BUCKET_SHIFT);
        Self { keys, ends }
    }

    fn bucket(&self, bucket: usize) -> &[Key] {
        let start = if bucket == 0 { 0 } else { self.ends[bucket - 1] };
        &self.keys[start as usize..self.ends[bucket] as usize]
    }
}

/// Sorts the keys of a bucket.
fn sort(keys: &mut [Key]) {
    if keys.len() < RADIX_SORTED {
        keys.sort_unstable();
    } else {
        let mut copy = vec![Key::NONE; keys.len()];
        sort_by_digit(keys, &mut copy, 0);
        sort_by_digit(&copy, keys, DIGIT_BITS);
    }
}

/// Copies keys in the order of a digit, those with equal digits in the order in which they are; returns where each digit's end.
fn sort_by_digit(keys: &[Key], sorted: &mut [Key], shift: u32) -> [u32; 1 << DIGIT_BITS] {
    let digit = |key: Key| (key.code() >> shift) as usize % (1 << DIGIT_BITS);
    let mut places = [0_u32; 1 << DIGIT_BITS];
    for &key in keys {
        places[digit(key)] += 1;
    }
    let mut end = 0;
    for count in &mut places {
        end += std::mem::replace(count, end);
    }
    for &key in keys {
        let place = &mut places[digit(key)];
        sorted[*place as usize] = key;
        *place += 1;
    }
    places
}

#[cfg(test)]
mod tests {
    use sahl_math::{Bounds3, Vec3};

    use super::*;
    use crate::build::Extent;

    /// Points of which many fall into the same cells.
    fn points(count: u32) -> Vec<Reference> {
        let point = |i: u32| {
            let hash = i.wrapping_mul(0x9e37_79b9) ^ i.wrapping_mul(0x85eb_ca6b) >> 7;
            let spread = |shift: u32| (hash >> shift & 0xff) as f32;
            let p = Vec3::new(spread(0), spread(8), if i.is_multiple_of(3) { spread(16) } else { 5.0 });
            Reference::new(&Bounds3 { min: p, max: p }, Item::Triangle(i))
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn keys_ascend_and_stand_for_everything_once() {
        for count in [0, 1, 2, 1000, 70_000, 150_000] {
            let references = points(count);
            let centers = Extent::of(&references).centers;
            let keys = sorted(&references, &centers);
            assert!(keys.is_sorted());
            let mut places: Vec<usize> = keys.iter().map(|key| key.place()).collect();
            places.sort_unstable();
            assert!(places.into_iter().eq(0..count as usize));
            let grid = Grid::new(&centers);
            assert!(keys.iter().all(|key| key.code() == grid.code(&references[key.place()])));
        }
    }

    #[test]
    fn places_beside_each_other_share_the_coarse_bits() {
        let at = |x: f32, y: f32, z: f32| {
            let p = Vec3::new(x, y, z);
            Reference::new(&Bounds3 { min: p, max: p }, Item::Quadric(0))
        };
        let centers = Extent::of(&[at(0.0, 0.0, 0.0), at(1024.0, 10.0, 10.0)]).centers;
        let grid = Grid::new(&centers);
        assert_eq!(grid.code(&at(0.0, 0.0, 0.0)), 0);
        assert_eq!(grid.code(&at(1024.0, 0.0, 0.0)), spread(1023));
        assert_eq!(grid.code(&at(2.5, 1.5, 1.5)), 0b1110);
        assert_eq!(grid.code(&at(6.5, 5.5, 1.5)), 0b1100_1110);
    }

    #[test]
    fn items_survive_encoding() {
        for item in [Item::Triangle(u32::MAX - 1), Item::Patch(3), Item::Quadric(0), Item::Instance(7)] {
            assert_eq!(Key::of_reference(&Reference::new(&Bounds3::EMPTY, item)).item(), item);
        }
    }
}
