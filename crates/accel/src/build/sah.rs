//! Surface area heuristic: bins for large ranges, for small ones every cut into leaves, the middle where costs do not tell.

use super::binning::Binning;
use super::split::{Halves, Range};
use super::{MAX_LEAF, median, sweep};

/// The halves of a range of at most [`sweep::MAX_COUNT`] references; `None` if it had better be a leaf.
pub(super) fn split_small(binning: &Binning, range: &mut Range<'_>) -> Option<Halves> {
    let extent = range.extent;
    match sweep::best_cut(binning.machine, range.references(), &extent) {
        Some(cut) => Some(cut.apply(range.references())),
        None => (range.count > MAX_LEAF).then(|| split_in_the_middle(range)),
    }
}

pub(super) fn split_in_the_middle(range: &mut Range<'_>) -> Halves {
    let extent = range.extent;
    median::halve(range.references(), &extent)
}
