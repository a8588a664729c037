//! Diagnostics as text for people, in the manner of rustc, and as JSON for programs.
//!
//! Design decision: the crate `annotate-snippets` draws, but sees only a window of one line, at most [`WINDOW`]
//! characters on either side of the start of the span, in which every control character is replaced by a visible one.
//! A scene file may be binary garbage, or have a line of many megabytes; neither reaches the terminal. Of a span over
//! several lines the first is shown.

use std::borrow::Cow;

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use serde_json::json;

use super::locate::{Locator, Place};
use super::{Diagnostic, Diagnostics, Severity};
use crate::{Sources, Span};

/// Most characters shown before and after the start of the span.
const WINDOW: usize = 60;
/// Longer messages lose their middle.
const LONGEST_MESSAGE: usize = 1200;

impl Diagnostics {
    /// The messages as text, in the manner of rustc: `error[code]: message`, the place as file:line:column, the line
    /// with the span underlined, notes and help. A blank line follows each message.
    ///
    /// A message without a span stands alone; one whose span lies outside the text that is kept of its file (a binary
    /// file) names the file. With `color`, ANSI escapes colour the output; nothing that comes from a file can add to
    /// them.
    pub fn render_text(&self, sources: &Sources, color: bool) -> String {
        let renderer = if color { Renderer::styled() } else { Renderer::plain() };
        let mut locator = Locator::new(sources);
        let mut text = String::new();
        for diagnostic in self.iter() {
            text.push_str(&render_one(diagnostic, &mut locator, &renderer));
            text.push_str("\n\n");
        }
        text
    }

    /// The messages as NDJSON: one object a line with `severity` (`"error"`, `"warning"`), `code`, `file`, `line`,
    /// `column`, `endLine`, `endColumn`, `message`, `notes` (an array) and `help`.
    ///
    /// Lines and columns count from one, columns in characters; the end is exclusive. What is not known is null.
    pub fn render_json(&self, sources: &Sources) -> String {
        let mut locator = Locator::new(sources);
        let mut text = String::new();
        for diagnostic in self.iter() {
            let start = diagnostic.span.and_then(|span| locator.place(span.file, span.start));
            let end = start
                .and(diagnostic.span)
                .and_then(|span| locator.place(span.file, span.end.max(span.start)));
            let end = end.or(start);
            let object = json!({
                "severity": diagnostic.severity,
                "code": diagnostic.code,
                "file": diagnostic.span.and_then(|span| locator.file(span)).map(|file| &file.name),
                "line": start.map(|place| place.location.line),
                "column": start.map(|place| place.location.column),
                "endLine": end.map(|place| place.location.line),
                "endColumn": end.map(|place| place.location.column),
                "message": diagnostic.message,
                "notes": diagnostic.notes,
                "help": diagnostic.help,
            });
            text.push_str(&object.to_string());
            text.push('\n');
        }
        text
    }
}

fn render_one(diagnostic: &Diagnostic, locator: &mut Locator<'_>, renderer: &Renderer) -> String {
    let level = match diagnostic.severity {
        Severity::Warning => Level::WARNING,
        Severity::Error => Level::ERROR,
    };
    let mut group = Group::with_title(level.primary_title(message(&diagnostic.message)).id(diagnostic.code));
    if let Some((span, file)) = diagnostic.span.and_then(|span| Some((span, locator.file(span)?))) {
        let origin = Origin::path(message(&file.name));
        match locator.place(span.file, span.start) {
            Some(place) => {
                let (line, column) = (place.location.line, place.location.column);
                let excerpt = Excerpt::new(&file.text, span, place);
                group = group.element(origin.line(line).char_column(column)).element(
                    Snippet::source(excerpt.text)
                        .line_start(line)
                        .annotation(AnnotationKind::Primary.span(excerpt.start..excerpt.end)),
                );
            }
            None => group = group.element(origin),
        }
    }
    let notes = diagnostic.notes.iter().map(|note| Level::NOTE.message(message(note)));
    let help = diagnostic.help.iter().map(|help| Level::HELP.message(message(help)));
    let rendered = renderer.render(&[group.elements(notes.chain(help))]);
    rendered.split('\n').filter(|line| !is_continuation(line)).collect::<Vec<_>>().join("\n")
}

/// Whether a line holds nothing but the mark `:::`, which `annotate-snippets` draws wherever it is told the place apart
/// from the excerpt. It has to be told: from the excerpt, a part of a line, it would count the wrong column.
fn is_continuation(line: &str) -> bool {
    let mut rest = line.trim_start();
    while let Some((_, after)) = rest.strip_prefix("\x1b[").and_then(|escape| escape.split_once('m')) {
        rest = after.trim_start();
    }
    rest.starts_with(":::")
}

/// A part of one line that can be shown.
struct Excerpt {
    text: String,
    /// Offset in `text` of the start of the span.
    start: usize,
    /// Offset in `text` of the end of the span, or of what is shown of it.
    end: usize,
}

impl Excerpt {
    fn new(file: &[u8], span: Span, place: Place) -> Self {
        let start = span.start as usize;
        let end = file.len().min((span.end as usize).max(start));
        // A character has at most four bytes, so that so many more than `WINDOW` lie in any window this wide.
        let from = place.line_start.max(start.saturating_sub(4 * WINDOW));
        let to = file.len().min(start + 4 * WINDOW);
        let line_end = file[start..to].iter().position(|&byte| byte == b'\n').map_or(to, |at| start + at);
        let clipped = line_end == start + 4 * WINDOW;
        // Windows ends its lines with two bytes.
        let line_end = if file[start..line_end].ends_with(b"\r") { line_end - 1 } else { line_end };
        let end = end.min(line_end);

        let before = visible(&file[from..start]);
        let skipped = before.chars().count().saturating_sub(WINDOW);
        let before: String = before.chars().skip(skipped).collect();
        let inside = visible(&file[start..end]);
        let after = visible(&file[end..line_end]);

        let mut text = String::new();
        if from > place.line_start || skipped > 0 {
            text.push_str("...");
        }
        text.push_str(&before);
        let excerpt_start = text.len();
        text.extend(inside.chars().take(WINDOW));
        let excerpt_end = text.len();
        let room = WINDOW.saturating_sub(inside.chars().count());
        text.extend(after.chars().take(room));
        if inside.chars().count() > WINDOW || after.chars().count() > room || clipped {
            text.push_str("...");
        }
        Self { text, start: excerpt_start, end: excerpt_end }
    }
}

/// Bytes as text in which each character can be seen.
fn visible(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).chars().map(visible_character).collect()
}

/// The character, or one that stands for it if it would not be seen or would move others: the control pictures for
/// ASCII's control characters, the replacement character for the others and for marks of writing direction.
fn visible_character(character: char) -> char {
    match character {
        '\t' => ' ',
        '\0'..='\u{1F}' => char::from_u32(0x2400 + character as u32).unwrap_or('\u{FFFD}'),
        '\u{7F}' => '\u{2421}',
        '\u{80}'..='\u{9F}' | '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{206F}' => {
            '\u{FFFD}'
        }
        '\u{FEFF}' => '\u{FFFD}',
        _ => character,
    }
}

/// A message in which each character can be seen and that is not too long to read.
fn message(text: &str) -> Cow<'_, str> {
    let plain = text.chars().all(|character| visible_character(character) == character);
    if plain && text.len() <= LONGEST_MESSAGE {
        return Cow::Borrowed(text);
    }
    let count = text.chars().count();
    if count <= LONGEST_MESSAGE {
        return text.chars().map(visible_character).collect();
    }
    let half = LONGEST_MESSAGE / 2;
    let ends = |character: &(usize, char)| character.0 < half || character.0 >= count - half;
    let mut shown: Vec<char> =
        text.chars().enumerate().filter(ends).map(|(_, character)| visible_character(character)).collect();
    shown.splice(half..half, " ... ".chars());
    shown.into_iter().collect()
}

#[cfg(test)]
mod tests;
