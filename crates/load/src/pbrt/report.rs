//! The messages of one load, and the texts that they point into.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use sahl_scene::{Diagnostic, Diagnostics, FileId, Severity, Sources, Span, suggest};

use super::lexer::{Lexer, TokenKind};

/// Messages with the same text that are told one by one; further ones are counted.
const SAME_MESSAGE_LIMIT: usize = 4;
/// Messages with the same code that are told one by one; further ones are counted.
const SAME_CODE_LIMIT: usize = 64;
/// Messages are not told one by one after this many in all.
const TOTAL_LIMIT: usize = 1024;
/// Characters of input that a message quotes.
const QUOTE_LIMIT: usize = 40;

/// Collects messages, so that a file full of one mistake gives a few messages and a number.
///
/// Shared by everything that reads a scene, and written through a shared reference: who reads a parameter can complain
/// about it while the scene is being changed.
#[derive(Debug, Default)]
pub(super) struct Report {
    sources: RefCell<Sources>,
    log: RefCell<Log>,
}

#[derive(Debug, Default)]
struct Log {
    told: Diagnostics,
    count: usize,
    messages: BTreeMap<(&'static str, Severity, String), Tally>,
    codes: BTreeMap<(&'static str, Severity), Tally>,
}

/// How often something was said.
#[derive(Debug, Default)]
struct Tally {
    told: usize,
    withheld: usize,
    /// The first that was not told.
    first_withheld: Option<Span>,
}

impl Tally {
    /// Whether one more may be told; counts it either way.
    fn admit(&mut self, limit: usize, span: Option<Span>) -> bool {
        let admitted = self.told < limit;
        if admitted {
            self.told += 1;
        } else {
            self.withheld += 1;
            self.first_withheld = self.first_withheld.or(span);
        }
        admitted
    }
}

impl Report {
    /// Adds a message, or counts it if there are many like it.
    pub(super) fn push(&self, diagnostic: Diagnostic) {
        self.push_with(diagnostic, |diagnostic| diagnostic);
    }

    /// Adds a message with what `complete` says besides, which may take long to find and is asked only if the message is
    /// told: a file can hold a mistake a million times.
    pub(super) fn push_with(&self, diagnostic: Diagnostic, complete: impl FnOnce(Diagnostic) -> Diagnostic) {
        let log = &mut *self.log.borrow_mut();
        let code = log.codes.entry((diagnostic.code, diagnostic.severity)).or_default();
        // The limit of the code comes first: it bounds the number of texts that are remembered.
        let limit = if log.count < TOTAL_LIMIT { SAME_CODE_LIMIT } else { 0 };
        if code.told >= limit {
            code.admit(0, diagnostic.span);
            return;
        }
        let key = (diagnostic.code, diagnostic.severity, diagnostic.message.clone());
        let message = log.messages.entry(key).or_default();
        if message.admit(SAME_MESSAGE_LIMIT, diagnostic.span) {
            code.told += 1;
            log.count += 1;
            log.told.push(complete(diagnostic));
        }
    }

    /// Adds an error.
    pub(super) fn error(&self, code: &'static str, span: Span, message: impl Into<String>) {
        self.push(Diagnostic::error(code, span, message));
    }

    /// Adds a warning.
    pub(super) fn warning(&self, code: &'static str, span: Span, message: impl Into<String>) {
        self.push(Diagnostic::warning(code, span, message));
    }

    /// Adds a source file.
    pub(super) fn add_source(&self, name: String, text: Vec<u8>) -> FileId {
        self.sources.borrow_mut().add(name, text)
    }

    /// The text of a file.
    pub(super) fn text(&self, file: FileId) -> Arc<[u8]> {
        Arc::clone(&self.sources.borrow().file(file).text)
    }

    /// Adds a message about the unknown name `found` with the nearest of `names`, or all of them if none is near and
    /// they are few.
    pub(super) fn push_with_choices<'a>(
        &self,
        diagnostic: Diagnostic,
        found: &str,
        names: impl Iterator<Item = &'a str> + Clone,
    ) {
        self.push_with(diagnostic, |diagnostic| with_choices(diagnostic, found, names));
    }

    /// Adds a message with a note about a second place, which follows `note`.
    pub(super) fn push_with_place(&self, diagnostic: Diagnostic, note: &str, place: Span) {
        self.push_with(diagnostic, |diagnostic| {
            diagnostic.with_note(format!("{note} {}", self.place(place)))
        });
    }

    /// `name:line` of the start of `span`. Takes time in proportion to the text.
    fn place(&self, span: Span) -> String {
        let sources = self.sources.borrow();
        format!("{}:{}", sources.file(span.file).name, sources.location(span.file, span.start).line)
    }

    /// The span of value number `index` of the values written at `values`.
    pub(super) fn value_span(&self, values: Span, index: usize) -> Span {
        let text = self.text(values.file);
        let mut lexer =
            Lexer::new(&text[..text.len().min(values.end as usize)], values.file, values.start as usize);
        let mut remaining = index;
        loop {
            let token = lexer.next();
            match token.kind {
                TokenKind::Open | TokenKind::Close => {}
                TokenKind::End => return values,
                _ if remaining == 0 => return lexer.span(token),
                _ => remaining -= 1,
            }
        }
    }

    /// The messages in the order in which they were found, then the numbers of those that were withheld; and the texts.
    pub(super) fn finish(self) -> (Diagnostics, Sources) {
        let log = self.log.into_inner();
        let mut told = log.told;
        for ((code, severity, message), tally) in log.messages {
            told.extend(more_like_this(severity, code, &tally, &format!("“{message}”")));
        }
        for ((code, severity), tally) in log.codes {
            told.extend(more_like_this(severity, code, &tally, &format!("of the kind `{code}`")));
        }
        (told, self.sources.into_inner())
    }
}

/// The message that stands for those that were withheld.
fn more_like_this(severity: Severity, code: &'static str, tally: &Tally, what: &str) -> Option<Diagnostic> {
    let message = format!("and {} more {what}", tally.withheld);
    let diagnostic = match severity {
        Severity::Error => Diagnostic::error(code, tally.first_withheld, message),
        Severity::Warning => Diagnostic::warning(code, tally.first_withheld, message),
    };
    (tally.withheld > 0).then_some(diagnostic)
}

/// Adds the nearest of `names` to a message about `found`, or all of them if none is near and they are few.
fn with_choices<'a>(
    diagnostic: Diagnostic,
    found: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Diagnostic {
    /// More names than this are not listed.
    const LISTED: usize = 24;
    if let Some(nearest) = suggest::nearest(found, names.clone()) {
        return diagnostic.with_help(format!("did you mean `{nearest}`?"));
    }
    let listed: Vec<String> = names.take(LISTED + 1).map(|name| format!("`{name}`")).collect();
    if listed.is_empty() || listed.len() > LISTED {
        return diagnostic;
    }
    diagnostic.with_help(format!("known: {}", listed.join(", ")))
}

/// A piece of input as messages quote it: in backticks, on one line, cut short.
pub(super) fn quote(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(&text[..text.len().min(4 * QUOTE_LIMIT)]);
    let mut quoted: String = text.chars().take(QUOTE_LIMIT).flat_map(printable).collect();
    if text.chars().count() > QUOTE_LIMIT {
        quoted.push('…');
    }
    format!("`{quoted}`")
}

/// The character, or the replacement character for one that would disturb a terminal.
fn printable(character: char) -> Option<char> {
    Some(if character.is_control() { char::REPLACEMENT_CHARACTER } else { character })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_messages_are_counted() {
        let report = Report::default();
        let file = report.add_source("a".to_owned(), vec![b' '; 100]);
        for start in 0..100 {
            report.warning("unsupported-shape", Span { file, start, end: start + 1 }, "no curves");
        }
        let (told, _) = report.finish();
        let last = told.iter().last().unwrap();
        assert_eq!(told.iter().count(), SAME_MESSAGE_LIMIT + 1);
        assert_eq!(last.message, "and 96 more “no curves”");
        assert_eq!(last.span.unwrap().start, SAME_MESSAGE_LIMIT as u32);
    }

    #[test]
    fn different_messages_of_a_kind_are_counted() {
        let report = Report::default();
        let file = report.add_source("a".to_owned(), Vec::new());
        for i in 0..100_000 {
            report.error("unknown-directive", Span { file, start: 0, end: 0 }, format!("{i}"));
        }
        let log = report.log.borrow();
        assert!(log.messages.len() <= SAME_CODE_LIMIT);
        drop(log);
        let (told, _) = report.finish();
        assert_eq!(told.iter().count(), SAME_CODE_LIMIT + 1);
        assert!(told.iter().all(|entry| entry.severity == Severity::Error));
    }

    #[test]
    fn quotations_stay_on_one_line() {
        assert_eq!(quote(b"a\x1b[1mb"), "`a\u{fffd}[1mb`");
        assert!(quote(&[b'x'; 1000]).chars().count() < 50);
    }
}
