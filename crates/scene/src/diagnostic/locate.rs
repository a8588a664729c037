//! Lines and columns of many places in large files.

use crate::{FileId, Location, SourceFile, Sources, Span};

/// Bytes between two checkpoints.
const STRIDE: usize = 4096;

/// What is known about the byte at a multiple of [`STRIDE`].
#[derive(Clone, Copy)]
struct Checkpoint {
    /// Lines before it, from zero.
    line: usize,
    /// Offset of the first byte of its line.
    line_start: usize,
    /// Characters of its line before it.
    column: usize,
}

impl Checkpoint {
    /// What is known `text` farther on; `offset` is where `text` starts.
    fn after(mut self, text: &[u8], offset: usize) -> Self {
        for (at, &byte) in text.iter().enumerate() {
            if byte == b'\n' {
                self = Self { line: self.line + 1, line_start: offset + at + 1, column: 0 };
            } else {
                // Bytes 0x80 to 0xBF continue a UTF-8 character.
                self.column += usize::from(byte & 0xC0 != 0x80);
            }
        }
        self
    }
}

/// A place in a file: what people call it, and where its line starts.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// Line and column from one.
    pub(super) location: Location,
    /// Offset of the first byte of the line.
    pub(super) line_start: usize,
}

/// Finds lines and columns in the files of a [`Sources`] by at most [`STRIDE`] bytes of reading each, after one pass
/// over each file that is asked about: neither many messages nor a line of many megabytes costs more.
pub(super) struct Locator<'a> {
    sources: &'a Sources,
    checkpoints: Vec<Option<Vec<Checkpoint>>>,
}

impl<'a> Locator<'a> {
    pub(super) fn new(sources: &'a Sources) -> Self {
        Self { sources, checkpoints: vec![None; sources.files().len()] }
    }

    /// The file of a span, or `None` if the span comes from other sources.
    pub(super) fn file(&self, span: Span) -> Option<&'a SourceFile> {
        self.sources.files().get(span.file.index())
    }

    /// The place of byte `offset`; `None` if the text kept of the file does not reach that far.
    pub(super) fn place(&mut self, file: FileId, offset: u32) -> Option<Place> {
        let text = &self.sources.files().get(file.index())?.text;
        let offset = offset as usize;
        if text.is_empty() || offset > text.len() {
            return None;
        }
        let checkpoints = self.checkpoints[file.index()].get_or_insert_with(|| checkpoints(text));
        let start = offset / STRIDE * STRIDE;
        let found = checkpoints[offset / STRIDE].after(&text[start..offset], start);
        let location = Location { line: found.line + 1, column: found.column + 1 };
        Some(Place { location, line_start: found.line_start })
    }
}

/// The checkpoints of a text: one at every multiple of [`STRIDE`] that is not beyond its end.
fn checkpoints(text: &[u8]) -> Vec<Checkpoint> {
    let mut checkpoints = vec![Checkpoint { line: 0, line_start: 0, column: 0 }];
    for (index, block) in text.chunks_exact(STRIDE).enumerate() {
        checkpoints.push(checkpoints[index].after(block, index * STRIDE));
    }
    checkpoints
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_agree_with_a_plain_count() {
        let mut sources = Sources::default();
        let line = "ü is two bytes\n".repeat(700) + &"x".repeat(9000) + "\n\nend";
        let file = sources.add("a.pbrt", line.as_bytes());
        let mut locator = Locator::new(&sources);
        for offset in 0..=line.len() as u32 {
            let place = locator.place(file, offset).unwrap();
            assert_eq!(place.location, sources.location(file, offset), "at {offset}");
            assert!(place.line_start == 0 || line.as_bytes()[place.line_start - 1] == b'\n');
        }
        assert!(locator.place(file, line.len() as u32 + 1).is_none());
    }

    #[test]
    fn a_text_of_whole_strides_has_a_place_at_its_end() {
        let mut sources = Sources::default();
        let file = sources.add("a", vec![b'x'; 2 * STRIDE]);
        let place = Locator::new(&sources).place(file, 2 * STRIDE as u32).unwrap();
        assert_eq!(place.location, Location { line: 1, column: 2 * STRIDE + 1 });
    }
}
