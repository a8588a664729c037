//! Source files and places in them.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// One of the files in a [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct FileId(u32);

impl FileId {
    /// The position in [`Sources::files`].
    #[inline]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// A range of bytes in a source file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Span {
    /// The file.
    pub file: FileId,
    /// Offset of the first byte.
    pub start: u32,
    /// Offset after the last byte.
    pub end: u32,
}

impl Span {
    /// The file as a whole: messages with this span name the file and no place in it.
    pub const fn of_file(file: FileId) -> Self {
        Self { file, start: u32::MAX, end: u32::MAX }
    }

    /// From the start of this span to the end of `other`, which lies in the same file.
    pub fn to(self, other: Span) -> Self {
        Self { end: other.end, ..self }
    }
}

/// A place for people: counted from one, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Location {
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

/// A file that was read, kept for as long as diagnostics may quote it.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// The path as the user wrote it.
    pub name: String,
    /// Its text, after decompression; of a binary file, the part that is text (a header), or nothing.
    pub text: Arc<[u8]>,
}

/// The files of one load.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<SourceFile>,
}

impl Sources {
    /// Adds a file.
    ///
    /// # Panics
    /// If there are already 2³² files.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<Arc<[u8]>>) -> FileId {
        let id = u32::try_from(self.files.len()).expect("fewer than 2^32 files");
        self.files.push(SourceFile { name: name.into(), text: text.into() });
        FileId(id)
    }

    /// The file.
    pub fn file(&self, id: FileId) -> &SourceFile {
        &self.files[id.index()]
    }

    /// Every file, in the order of reading.
    pub fn files(&self) -> &[SourceFile] {
        &self.files
    }

    /// Line and column of byte `offset` of `file`; offsets beyond the text count as its end.
    pub fn location(&self, file: FileId, offset: u32) -> Location {
        let text = &self.file(file).text;
        let before = &text[..text.len().min(offset as usize)];
        let line_start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |newline| newline + 1);
        let is_char_start = |byte: &&u8| **byte & 0xC0 != 0x80;
        Location {
            line: before.iter().filter(|&&byte| byte == b'\n').count() + 1,
            column: before[line_start..].iter().filter(is_char_start).count() + 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locations_count_lines_and_characters_from_one() {
        let mut sources = Sources::default();
        let file = sources.add("a.pbrt", "ab\nü x\n".as_bytes());
        let at = |offset| sources.location(file, offset);
        assert_eq!(at(0), Location { line: 1, column: 1 });
        assert_eq!(at(2), Location { line: 1, column: 3 });
        assert_eq!(at(3), Location { line: 2, column: 1 });
        assert_eq!(at(6), Location { line: 2, column: 3 });
        assert_eq!(at(900), Location { line: 3, column: 1 });
    }
}
