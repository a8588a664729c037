//! Quick trees for previews: neighbours on a space-filling curve become leaves, and the surface area heuristic divides the leaves,
//! which are a sixth as many as the primitives.
//!
//! Source: Lauterbach, Garland, Sengupta, Luebke, Manocha, *Fast BVH Construction on GPUs*, Computer Graphics Forum 28(2), 2009.
//! Deviation: there the curve divides the top of the tree and the heuristic what is below; here it is the other way round.

use rayon::prelude::*;

use super::bins::Binning;
use super::reference::{Box8, Extent, Reference};
use super::split::{Halves, Range, Splitter, build_nodes};
use super::{BinaryTree, MAX_LEAF, Order, sah, sweep};
use crate::primitive::Item;

/// A leaf may be made smaller, down to so many, to end where a cell of the curve ends.
const MIN_LEAF: usize = MAX_LEAF / 2;

/// Cells an axis of the finest grid, less a little for rounding.
const CELLS: f32 = 1023.99;

/// Codes are put into buckets by all bits but these.
const BUCKET_SHIFT: u32 = 20;
const BUCKETS: usize = 1 << 10;

/// Bits by which a bucket is sorted in one pass.
const DIGIT_BITS: u32 = 10;

/// Smaller buckets are sorted by comparison.
const RADIX_SORTED: usize = 1 << 10;

/// How many references one task puts into leaves.
const CHUNK: usize = 1 << 14;

/// Builds a tree over at least one primitive.
pub(super) fn build(references: &[Reference], extent: &Extent, binning: Binning) -> BinaryTree {
    let sorted: Vec<Keyed> = sort(keyed(references, extent));
    let mut items = vec![Item::Triangle(0); sorted.len()];
    let chunks = sorted.par_chunks(CHUNK).zip(items.par_chunks_mut(CHUNK)).enumerate();
    let leaves: Vec<Leaf> =
        chunks.flat_map_iter(|(i, (keys, items))| leaves(i * CHUNK, keys, references, items)).collect();
    let as_references =
        |(place, leaf): (usize, &Leaf)| Reference::new(&leaf.bounds.bounds(), Item::Triangle(place as u32));
    let mut slots: Vec<Reference> = leaves.par_iter().enumerate().map(as_references).collect();
    let count = slots.len();
    let range = Range { slots: &mut slots, count, divisible: 0, extent: Extent::around(extent.bounds) };
    let mut nodes = build_nodes(range, &OfLeaves { binning });
    for node in nodes.iter_mut().filter(|node| node.is_leaf()) {
        let leaf = &leaves[slots[node.range().start].place() as usize];
        node.set_range(leaf.first, leaf.count);
    }
    BinaryTree { nodes, order: Order::Items(items) }
}

/// A reference's place on the curve, and in the lower half its place among the references.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Keyed(u64);

impl Keyed {
    fn code(self) -> u32 {
        (self.0 >> 32) as u32
    }

    fn place(self) -> usize {
        self.0 as u32 as usize
    }
}

/// What becomes a leaf.
struct Leaf {
    bounds: Box8,
    first: usize,
    count: usize,
}

/// Divides leaves until each is alone.
struct OfLeaves {
    binning: Binning,
}

impl Splitter for OfLeaves {
    fn split(&self, range: &mut Range<'_>) -> Option<Halves> {
        if range.count <= sweep::MAX_COUNT {
            let cut = sweep::best_cut_of_leaves(self.binning.machine, range.references());
            return Some(match cut {
                Some(cut) => cut.apply(range.references()),
                None => sah::split_in_the_middle(range),
            });
        }
        let split = self.binning.split(range).map(|split| split.halves);
        Some(split.unwrap_or_else(|| sah::split_in_the_middle(range)))
    }
}

/// The places of the references' centres on the curve of Morton through a grid over all of them.
fn keyed(references: &[Reference], extent: &Extent) -> Vec<Keyed> {
    let [x, y, z, _] = extent.centers.min();
    let [dx, dy, dz] = extent.centers.diagonal();
    let scale = CELLS / dx.max(dy).max(dz);
    // All centres at one place, or extents beyond the range of `f32`.
    let scale = if scale.is_finite() { scale } else { 0.0 };
    let key = |(place, reference): (usize, &Reference)| {
        let center = reference.doubled_center();
        let cell = |axis: usize, origin: f32| spread(((center[axis] - origin) * scale) as u32);
        let code = cell(0, x) | cell(1, y) << 1 | cell(2, z) << 2;
        Keyed(u64::from(code) << 32 | place as u64)
    };
    references.par_iter().with_min_len(CHUNK).enumerate().map(key).collect()
}

/// Ten bits with two empty ones between each two of them.
#[inline]
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Sorts: the coarse cells by counting, what lies in them on all cores.
fn sort(keys: Vec<Keyed>) -> Vec<Keyed> {
    let mut ends = [0_usize; BUCKETS];
    let bucket = |key: Keyed| (key.code() >> BUCKET_SHIFT) as usize % BUCKETS;
    for &key in &keys {
        ends[bucket(key)] += 1;
    }
    let counts = ends;
    let mut end = 0;
    for count in &mut ends {
        // Where the next of the bucket goes.
        end += std::mem::replace(count, end);
    }
    let mut sorted = vec![Keyed(0); keys.len()];
    for &key in &keys {
        let next = &mut ends[bucket(key)];
        sorted[*next] = key;
        *next += 1;
    }
    let mut scratch = keys;
    let (mut rest, mut rest_of_scratch) = (sorted.as_mut_slice(), scratch.as_mut_slice());
    let mut buckets = Vec::with_capacity(BUCKETS);
    for count in counts {
        let (bucket, after) = rest.split_at_mut(count);
        let (scratch, after_scratch) = rest_of_scratch.split_at_mut(count);
        buckets.push((bucket, scratch));
        (rest, rest_of_scratch) = (after, after_scratch);
    }
    buckets.into_par_iter().for_each(|(bucket, scratch)| sort_bucket(bucket, scratch));
    sorted
}

fn sort_bucket(keys: &mut [Keyed], scratch: &mut [Keyed]) {
    if keys.len() < RADIX_SORTED {
        keys.sort_unstable();
    } else {
        sort_by_digit(keys, scratch, 0);
        sort_by_digit(scratch, keys, DIGIT_BITS);
    }
}

/// Copies keys in the order of a digit, those with equal digits in the order in which they are.
fn sort_by_digit(keys: &[Keyed], sorted: &mut [Keyed], shift: u32) {
    let digit = |key: Keyed| (key.code() >> shift) as usize % (1 << DIGIT_BITS);
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
}

/// Cuts what the keys stand for into leaves, the first of which begins at `first`, and lists it.
fn leaves(mut first: usize, keys: &[Keyed], references: &[Reference], items: &mut [Item]) -> Vec<Leaf> {
    let mut leaves = Vec::with_capacity(keys.len() / MIN_LEAF);
    let (mut keys, mut items) = (keys, items);
    while !keys.is_empty() {
        let mut found = [Reference::NONE; MAX_LEAF + 1];
        for (reference, key) in found.iter_mut().zip(keys) {
            *reference = references[key.place()];
        }
        let count = leaf_size(keys, &found[..keys.len().min(MAX_LEAF)]);
        let (own, after) = items.split_at_mut(count);
        for (item, reference) in own.iter_mut().zip(&found) {
            *item = reference.item();
        }
        let bounds = found[..count].iter().fold(Box8::EMPTY, |all, one| all.union(*one.bounds()));
        leaves.push(Leaf { bounds, first, count });
        (keys, items) = (&keys[count..], after);
        first += count;
    }
    leaves
}

/// How many references the next leaf holds: up to where the largest cell ends, if that lies between [`MIN_LEAF`] and
/// [`MAX_LEAF`]; never anything beside a primitive that is not a triangle.
fn leaf_size(keys: &[Keyed], references: &[Reference]) -> usize {
    let triangles = references.iter().take_while(|reference| reference.is_triangle()).count();
    if triangles < references.len() {
        return triangles.max(1);
    }
    if keys.len() <= MAX_LEAF {
        return keys.len();
    }
    let border = |size: &usize| keys[size - 1].code() ^ keys[*size].code();
    (MIN_LEAF..=MAX_LEAF).max_by_key(|size| border(size).checked_ilog2()).unwrap_or(MAX_LEAF)
}
