//! Quick trees for previews: neighbours on a space-filling curve become blocks, and the surface area heuristic divides the blocks,
//! which are a sixth as many as the primitives.
//!
//! Source: Lauterbach, Garland, Sengupta, Luebke, Manocha, *Fast BVH Construction on GPUs*, Computer Graphics Forum 28(2), 2009.
//! Deviations: there the curve divides the top of the tree and the heuristic what is below, here it is the other way round; and the
//! leaves of the binary tree are as many blocks as a wide node holds, since which of them stand together is all that matters then.

use rayon::prelude::*;

use super::binning::Binning;
use super::curve::{self, Key};
use super::reference::{Box8, Extent, Reference};
use super::split::{Halves, Range, Splitter, build_nodes};
use super::{BinaryTree, MAX_LEAF, sah, spare, sweep};
use crate::kernel::WIDTH;

/// A block may be made smaller, down to so many, to end where a cell of the curve ends.
const MIN_BLOCK: usize = MAX_LEAF / 2;

/// How many primitives one task puts into blocks.
const CHUNK: usize = 1 << 14;

/// Builds a tree over at least one primitive.
pub(super) fn build(references: Vec<Reference>, extent: &Extent, binning: Binning) -> BinaryTree {
    let mut keys = curve::sorted(&references, &extent.centers);
    let chunks = keys.par_chunks_mut(CHUNK).enumerate();
    let mut groups: Vec<Reference> =
        chunks.flat_map_iter(|(i, keys)| groups(i * CHUNK, keys, &references)).collect();
    let count = groups.len();
    let range = Range { slots: &mut groups, count, divisible: 0, extent: Extent::around(extent.bounds) };
    let nodes = build_nodes(range, &OfGroups { binning }).concat();
    BinaryTree { nodes, primitives: keys, groups, spare: spare(references) }
}

/// Divides groups until a wide node has lanes for all.
struct OfGroups {
    binning: Binning,
}

impl Splitter for OfGroups {
    const LEAVES_OF_ONE_KIND: bool = false;

    fn split(&self, range: &mut Range<'_>) -> Option<Halves> {
        if range.count <= WIDTH {
            return None;
        }
        let split = if range.count <= sweep::MAX_COUNT {
            let cut = sweep::best_cut_of_groups(self.binning.machine, range.references());
            cut.map(|cut| cut.apply(range.references()))
        } else {
            self.binning.split(range)
        };
        Some(split.unwrap_or_else(|| sah::split_in_the_middle(range)))
    }
}

/// Cuts what the keys stand for into groups, the first of which begins at `first`, lists these, and replaces each key by that of what
/// it stands for.
fn groups(mut first: usize, keys: &mut [Key], references: &[Reference]) -> Vec<Reference> {
    let mut groups = Vec::with_capacity(keys.len() / MIN_BLOCK);
    let mut keys = keys;
    while !keys.is_empty() {
        let mut found = [Reference::NONE; MAX_LEAF];
        for (reference, key) in found.iter_mut().zip(&*keys) {
            *reference = references[key.place()];
        }
        let count = size_of_group(keys, &found[..keys.len().min(MAX_LEAF)]);
        let (own, after) = keys.split_at_mut(count);
        let mut bounds = Box8::EMPTY;
        for (key, reference) in own.iter_mut().zip(&found) {
            *key = Key::of_reference(reference);
            bounds = bounds.union(*reference.bounds());
        }
        groups.push(Reference::group(&bounds, first, count));
        keys = after;
        first += count;
    }
    groups
}

/// How many primitives the next group holds: up to where the largest cell ends, if that lies between [`MIN_BLOCK`] and
/// [`MAX_LEAF`]; never anything beside a primitive that is not a triangle.
fn size_of_group(keys: &[Key], references: &[Reference]) -> usize {
    let triangles = references.iter().take_while(|reference| reference.is_triangle()).count();
    if triangles < references.len() {
        return triangles.max(1);
    }
    if keys.len() <= MAX_LEAF {
        return keys.len();
    }
    let border = |size: &usize| keys[size - 1].code() ^ keys[*size].code();
    (MIN_BLOCK..=MAX_LEAF).max_by_key(|size| border(size).checked_ilog2()).unwrap_or(MAX_LEAF)
}
