//! The textbook builder: halve the primitives at the median of their centres along the longest axis.

use super::reference::{Extent, Reference};
use super::split::{Halves, Range, Splitter, build_tree};
use super::{BinaryTree, MAX_LEAF};

/// Builds by object median.
pub(super) fn build(references: Vec<Reference>, extent: Extent) -> BinaryTree {
    build_tree(references, extent, &Median)
}

struct Median;

impl Splitter for Median {
    fn split(&self, range: &mut Range<'_>) -> Option<Halves> {
        let extent = range.extent;
        (range.count > MAX_LEAF).then(|| halve(range.references(), &extent))
    }
}

/// Splits at the median along the axis on which the centres spread most; ties are in the order of the input.
pub(super) fn halve(references: &mut [Reference], extent: &Extent) -> Halves {
    let axis = extent.centers.longest_axis();
    let middle = references.len().div_ceil(2);
    references.select_nth_unstable_by(middle, |a, b| {
        let (p, q) = (a.doubled_center_at(axis), b.doubled_center_at(axis));
        p.total_cmp(&q).then_with(|| a.key().cmp(&b.key()))
    });
    Halves::of(references, middle)
}
