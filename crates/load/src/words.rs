//! Lines and words of the formats that Wavefront made: one statement a line, words apart by blanks, `#` before a comment,
//! `\` at the end of a line that goes on.

use std::collections::{BTreeMap, BTreeSet};

use sahl_scene::{Diagnostic, Diagnostics, FileId, Severity, Span};

/// A word and where it starts in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Word<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) start: usize,
}

impl Word<'_> {
    /// The word as text, cut to a length that fits a message.
    pub(crate) fn quoted(&self) -> String {
        const LONGEST: usize = 60;
        format!("`{}`", String::from_utf8_lossy(&self.bytes[..self.bytes.len().min(LONGEST)]))
    }

    /// The word as a number, which need not be finite.
    pub(crate) fn number(&self) -> Option<f32> {
        std::str::from_utf8(self.bytes).ok()?.parse().ok()
    }

    /// The place of the word in `file`.
    pub(crate) fn span(&self, file: FileId) -> Span {
        span(file, self.start, self.start + self.bytes.len())
    }
}

/// A range of bytes of `file`; what lies beyond 4 GiB is counted as there.
pub(crate) fn span(file: FileId, start: usize, end: usize) -> Span {
    let offset = |offset: usize| u32::try_from(offset).unwrap_or(u32::MAX);
    Span { file, start: offset(start), end: offset(end) }
}

/// A statement: a line, or several that are joined by `\`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<'a> {
    bytes: &'a [u8],
    start: usize,
}

impl<'a> Line<'a> {
    /// The words up to a comment.
    pub(crate) fn words(&self) -> Words<'a> {
        Words { bytes: self.bytes, start: self.start, at: 0 }
    }
}

/// The words of a line.
#[derive(Clone, Debug)]
pub(crate) struct Words<'a> {
    bytes: &'a [u8],
    start: usize,
    at: usize,
}

impl<'a> Words<'a> {
    /// What is left of the line up to a comment, as one word: a name may contain blanks. `None` if nothing is left.
    pub(crate) fn rest(&mut self) -> Option<Word<'a>> {
        let first = self.next()?;
        let mut end = first.start + first.bytes.len();
        for word in self.by_ref() {
            end = word.start + word.bytes.len();
        }
        let bytes = &self.bytes[first.start - self.start..end - self.start];
        Some(Word { bytes, start: first.start })
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = Word<'a>;

    #[inline]
    fn next(&mut self) -> Option<Word<'a>> {
        loop {
            let rest = &self.bytes[self.at..];
            let blanks = rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            let rest = &rest[blanks..];
            let length = rest.iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
            if length == 0 || rest[0] == b'#' {
                self.at = self.bytes.len();
                return None;
            }
            let start = self.start + self.at + blanks;
            self.at += blanks + length;
            // A backslash alone joins two lines.
            if rest[..length] != *b"\\" {
                return Some(Word { bytes: &rest[..length], start });
            }
        }
    }
}

/// The statements of a text.
pub(crate) struct Lines<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        if self.at >= self.text.len() {
            return None;
        }
        let (start, mut at) = (self.at, self.at);
        let end = loop {
            let Some(length) = self.text[at..].iter().position(|&byte| byte == b'\n') else {
                self.at = self.text.len();
                break self.text.len();
            };
            let end = at + length;
            at = end + 1;
            self.at = at;
            let line = self.text[start..end].strip_suffix(b"\r").unwrap_or(&self.text[start..end]);
            // Only a backslash apart from other words joins lines: names may end in one.
            if !(line.ends_with(b" \\") || line.ends_with(b"\t\\") || line == b"\\") {
                break end;
            }
        };
        Some(Line { bytes: &self.text[start..end], start })
    }
}

/// The messages about one file. After the first few of a kind they are counted.
pub(crate) struct Messages {
    pub(crate) file: FileId,
    told: Diagnostics,
    counts: BTreeMap<(&'static str, Severity), usize>,
    said_once: BTreeSet<(&'static str, String)>,
}

/// Messages of a kind that are told one by one.
const LIMIT: usize = 8;

impl Messages {
    pub(crate) fn new(file: FileId) -> Self {
        Self { file, told: Diagnostics::default(), counts: BTreeMap::new(), said_once: BTreeSet::new() }
    }

    /// Adds an error about a word.
    pub(crate) fn error(&mut self, code: &'static str, word: Word<'_>, message: impl FnOnce() -> String) {
        if self.admit(code, Severity::Error) {
            self.told.push(Diagnostic::error(code, word.span(self.file), message()));
        }
    }

    /// Adds a warning about a word.
    pub(crate) fn warn(&mut self, code: &'static str, word: Word<'_>, message: impl FnOnce() -> String) {
        if self.admit(code, Severity::Warning) {
            self.told.push(Diagnostic::warning(code, word.span(self.file), message()));
        }
    }

    /// Adds a warning about a word, the first time that this is said about `what`, one of a few things.
    pub(crate) fn warn_once(&mut self, code: &'static str, what: &str, word: Word<'_>, message: String) {
        if self.said_once.insert((code, what.to_owned())) {
            self.told.push(Diagnostic::warning(code, word.span(self.file), message));
        }
    }

    fn admit(&mut self, code: &'static str, severity: Severity) -> bool {
        let count = self.counts.entry((code, severity)).or_default();
        *count += 1;
        *count <= LIMIT
    }

    /// Adds any message.
    pub(crate) fn push(&mut self, diagnostic: Diagnostic) {
        self.told.push(diagnostic);
    }

    /// Whether there is an error among them.
    pub(crate) fn has_errors(&self) -> bool {
        self.told.has_errors()
    }

    /// The messages, with the numbers of those that were not told.
    pub(crate) fn finish(mut self) -> Diagnostics {
        for ((code, severity), count) in self.counts {
            if count > LIMIT {
                let message = format!("{} more messages of this kind", count - LIMIT);
                let rest = Diagnostic::warning(code, Span::of_file(self.file), message);
                self.told.push(Diagnostic { severity, ..rest });
            }
        }
        self.told
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<Vec<&str>> {
        let word = |word: Word<'_>| &text[word.start..word.start + word.bytes.len()];
        Lines::new(text.as_bytes()).map(|line| line.words().map(word).collect()).collect()
    }

    #[test]
    fn words_end_at_blanks_and_comments() {
        assert_eq!(
            words("v 1\t2 # three\r\n\n#x\nf 1/2 a#b"),
            [vec!["v", "1", "2"], vec![], vec![], vec!["f", "1/2", "a#b"]]
        );
    }

    #[test]
    fn a_backslash_joins_lines_unless_it_ends_a_name() {
        assert_eq!(
            words("f 1 \\\n 2 \\\r\n3\nmap_Kd dir\\\nv"),
            [vec!["f", "1", "2", "3"], vec!["map_Kd", "dir\\"], vec!["v"]]
        );
        assert_eq!(words("f 1 \\"), [vec!["f", "1"]]);
    }

    #[test]
    fn a_name_may_contain_blanks() {
        let mut words = Lines::new(b"usemtl  dark  red # comment").next().unwrap().words();
        words.next();
        let name = words.rest().unwrap();
        assert_eq!((name.bytes, name.start), (b"dark  red".as_slice(), 8));
        assert_eq!(words.rest(), None);
    }
}
