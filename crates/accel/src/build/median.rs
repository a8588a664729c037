//! The textbook builder: halve the primitives at the median of their centres along the longest axis.

use super::reference::{Extent, Reference};
use super::split::{Halves, Splitter, build_tree};
use super::{BinaryTree, MAX_LEAF};

/// Builds by object median.
pub(super) fn build(references: Vec<Reference>) -> BinaryTree {
    build_tree(references, &Median)
}

struct Median;

impl Splitter for Median {
    fn split(&self, references: &mut [Reference], extent: &Extent) -> Option<Halves> {
        (references.len() > MAX_LEAF).then(|| halve(references, extent))
    }
}

/// Splits at the median along the axis on which the centres spread most; ties are in the order of the input.
pub(super) fn halve(references: &mut [Reference], extent: &Extent) -> Halves {
    let [x, y, z] = extent.centers.diagonal();
    let axis = if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) };
    let middle = references.len().div_ceil(2);
    references.select_nth_unstable_by(middle, |a, b| {
        let (p, q) = (a.doubled_center()[axis], b.doubled_center()[axis]);
        p.total_cmp(&q).then_with(|| a.key().cmp(&b.key()))
    });
    Halves::of(references, middle)
}
