//! The memory of nodes and blocks.
#![expect(
    unsafe_code,
    reason = "comparisons and branches at each step cost a twentieth of the time of a batch"
)]

use rayon::prelude::*;

use super::block::{BLOCK_ROWS, TriangleBlock};
use super::isa::{Isa, Row};
use super::node::{NODE_ROWS, Node};
use super::pages::prefer_large_pages;

/// Rows that stand behind the last node or block, so that whatever begins at a row in use can be read in full.
const PADDING: usize = BLOCK_ROWS;

const _: () = assert!(NODE_ROWS <= PADDING);

/// Rows of a line of the processor's cache.
pub(crate) const LINE_ROWS: usize = 2;

/// Nodes and blocks in a list of rows.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    rows: Vec<Row>,
    /// How many are in use: [`PADDING`] less than there are.
    len: usize,
}

impl Default for Rows {
    fn default() -> Self {
        Self { rows: vec![Row::splat(0.0); PADDING], len: 0 }
    }
}

impl Rows {
    /// How many rows are in use.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The memory in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        size_of_val(self.rows.as_slice()) as u64
    }

    /// Takes so many more rows into use, whatever they hold, and gives them to be written. The first ones are made of `spare` memory if it
    /// is enough: the system takes longer to give new memory than rows to be written there.
    pub(crate) fn append(&mut self, count: usize, spare: Vec<Row>) -> &mut [Row] {
        let start = self.len;
        let needed = start + count + PADDING;
        if start == 0 && needed <= spare.capacity() {
            self.rows = spare;
            self.rows.truncate(needed);
        } else {
            // Many trees after each other are not copied for each.
            let additional = needed - self.rows.len();
            if start == 0 {
                self.rows.reserve_exact(additional);
            } else {
                self.rows.reserve(additional);
            }
            prefer_large_pages(&self.rows);
        }
        self.rows.par_extend(rayon::iter::repeat_n(Row::splat(0.0), needed - self.rows.len()));
        self.len += count;
        &mut self.rows[start..start + count]
    }

    /// The rows from one to before another, to be written anew.
    pub(crate) fn between(&mut self, start: u32, end: u32) -> &mut [Row] {
        &mut self.rows[start as usize..end as usize]
    }

    /// The nodes and blocks, to be read.
    #[inline(always)]
    pub(crate) fn view(&self) -> RowsView<'_> {
        RowsView { rows: &self.rows, end: self.len << REFERENCE_SHIFT }
    }
}

/// How many of the lowest bits of a reference to a row are its owner's: the row is what lies above them.
pub(crate) const REFERENCE_SHIFT: u32 = 2;

/// The step from one reference to the next, in bytes of rows.
const BYTES_A_STEP: usize = size_of::<Row>() >> REFERENCE_SHIFT;

const _: () = assert!(BYTES_A_STEP << REFERENCE_SHIFT == size_of::<Row>());

/// Nodes and blocks that are read.
///
/// What a traversal holds: it fits registers, where a reference to [`Rows`] would be followed at each step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowsView<'a> {
    rows: &'a [Row],
    /// The reference behind the last row in use; there are [`PADDING`] rows more.
    end: usize,
}

impl<'a> RowsView<'a> {
    /// The node to whose first row this refers.
    #[inline(always)]
    pub(crate) fn node(self, reference: u32) -> Node<'a> {
        Node(self.chunk(reference))
    }

    /// The block to whose first row this refers.
    #[inline(always)]
    pub(crate) fn block(self, reference: u32) -> TriangleBlock<'a> {
        TriangleBlock(self.chunk(reference))
    }

    /// Some rows from one on.
    #[inline(always)]
    fn chunk<const N: usize>(self, reference: u32) -> &'a [Row; N] {
        const { assert!(N <= PADDING) };
        const IGNORED: usize = (1 << REFERENCE_SHIFT) - 1;
        let reference = reference as usize & !IGNORED;
        assert!(reference <= self.end, "references are to rows in use");
        // SAFETY: without the ignored bits a whole number of rows, as is asserted above, and so aligned; no more than are in use.
        // There are `PADDING` more, as only `Rows::view` makes views, and `N` is no more.
        unsafe { &*self.rows.as_ptr().byte_add(reference * BYTES_A_STEP).cast() }
    }

    /// Asks for the memory of the node or block to which this refers. Any reference is allowed.
    #[inline(always)]
    pub(crate) fn prefetch<I: Isa>(self, isa: I, reference: u32) {
        let first = self.address(reference);
        for row in (0..BLOCK_ROWS).step_by(LINE_ROWS) {
            isa.prefetch(first.wrapping_add(row));
        }
    }

    /// Where about a row lies: somewhere in the line of the cache in which it begins.
    #[inline(always)]
    fn address(self, reference: u32) -> *const Row {
        self.rows.as_ptr().wrapping_byte_add((reference as usize).wrapping_mul(BYTES_A_STEP))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn appended_rows_follow_each_other_and_are_read_back() {
        let mut rows = Rows::default();
        for (count, value) in [(NODE_ROWS, 1.0), (BLOCK_ROWS, 2.0), (0, 3.0)] {
            let appended = rows.append(count, Vec::new());
            assert_eq!(appended.len(), count);
            appended.fill(Row::splat(value));
        }
        assert_eq!(rows.len(), NODE_ROWS + BLOCK_ROWS);
        assert_eq!(rows.bytes(), (32 * (NODE_ROWS + BLOCK_ROWS + PADDING)) as u64);
        assert!(rows.view().node(0).0.iter().all(|&row| row == Row::splat(1.0)));
        assert!(
            rows.view()
                .block((NODE_ROWS as u32) << REFERENCE_SHIFT)
                .0
                .iter()
                .all(|&row| row == Row::splat(2.0))
        );
    }

    #[test]
    fn the_first_rows_are_made_of_spare_memory() {
        for room in [0, 20, 40, 50, 100] {
            let mut rows = Rows::default();
            let mut spare = Vec::with_capacity(room);
            spare.resize(room * 3 / 4, Row::splat(7.0));
            for (count, value) in [(30, 1.0), (15, 2.0)] {
                rows.append(count, std::mem::take(&mut spare)).fill(Row::splat(value));
            }
            assert_eq!((rows.len(), rows.bytes()), (45, 32 * (45 + PADDING) as u64));
            assert!(rows.view().node(0).0.iter().all(|&row| row == Row::splat(1.0)));
            assert!(rows.view().block(30 << REFERENCE_SHIFT).0.iter().all(|&row| row == Row::splat(2.0)));
        }
    }

    #[test]
    fn the_lowest_bits_of_references_are_ignored() {
        let mut rows = Rows::default();
        for (row, place) in rows.append(30, Vec::new()).iter_mut().zip(0_u8..) {
            *row = Row::splat(place.into());
        }
        let view = rows.view();
        for (row, bits) in (0..30).flat_map(|row| (0..4).map(move |bits| (row, bits))) {
            let reference = row << REFERENCE_SHIFT | bits;
            assert_eq!(view.block(reference).0[0], Row::splat(row as f32));
            let row = view.address(row << REFERENCE_SHIFT).addr();
            assert!((row..row + size_of::<Row>()).contains(&view.address(reference).addr()));
        }
    }

    #[test]
    #[should_panic(expected = "rows in use")]
    fn rows_that_are_not_there_are_not_read() {
        Rows::default().view().node(1 << REFERENCE_SHIFT | 3);
    }
}
