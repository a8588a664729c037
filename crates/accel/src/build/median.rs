//! The textbook builder: halve the primitives at the median of their centres along the longest axis.

use super::split::{Extent, Halves, Reference, Splitter, build_tree};
use super::{BinaryTree, BuildInput};

/// Leaves hold up to this many primitives: what one block of triangles tests at once.
const LEAF_SIZE: usize = 4;

/// Builds by object median.
pub(super) fn build(input: BuildInput<'_>) -> BinaryTree {
    build_tree(input, &Median)
}

struct Median;

impl Splitter for Median {
    fn split(&self, references: &mut [Reference], extent: &Extent) -> Option<Halves> {
        (references.len() > LEAF_SIZE).then(|| halve(references, extent))
    }
}

/// Splits at the median along the axis on which the centres spread most; ties are in the order of the input.
pub(super) fn halve(references: &mut [Reference], extent: &Extent) -> Halves {
    let axis = extent.centers.diagonal().max_axis();
    let middle = references.len().div_ceil(2);
    references.select_nth_unstable_by(middle, |a, b| {
        a.center[axis].total_cmp(&b.center[axis]).then(a.place.cmp(&b.place))
    });
    Halves::of(references, middle)
}
