//! Files in files: `Include` and `Import`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use sahl_scene::{Diagnostic, FileId, Span};

use super::interpreter::Interpreter;
use super::parser::Parser;
use super::report::quote;
use super::state::State;
use super::statement::{Directive, Name, Statement};
use crate::assets::normalized;

/// Files that may be open at once.
const DEPTH_LIMIT: usize = 64;
/// Times that files may be included in all: each of a chain that includes the next twice doubles the number.
const INCLUSION_LIMIT: usize = 100_000;
/// Bytes of files that were read before and may be read again: what they hold is made anew each time.
const REPETITION_LIMIT: usize = 256 << 20;
/// Larger texts have places that a [`Span`] can't tell.
const TEXT_LIMIT: usize = u32::MAX as usize - 1;

/// The open files, and those that were read.
#[derive(Debug, Default)]
pub(super) struct Inclusion {
    open: Vec<Frame>,
    /// Texts by path, so that a file included often is read once.
    texts: BTreeMap<PathBuf, FileId>,
    count: usize,
    /// Bytes of texts that were read before.
    repeated: usize,
    told_limit: bool,
    first: Option<Span>,
}

/// A file that is being read.
#[derive(Debug)]
struct Frame {
    path: PathBuf,
    file: FileId,
    text: Arc<[u8]>,
    /// The next byte.
    at: usize,
    /// For an import: what is restored at its end.
    import: Option<Box<Import>>,
}

/// What an import leaves untouched.
#[derive(Debug)]
struct Import {
    state: State,
    /// The open blocks, which the file can't close.
    depth: usize,
}

impl Inclusion {
    /// The number of blocks that the file being read can't close.
    pub(super) fn scope_base(&self) -> usize {
        self.open.iter().rev().find_map(|frame| frame.import.as_ref()).map_or(0, |import| import.depth)
    }

    /// Whether no further file may be opened.
    fn exceeds_limits(&self) -> bool {
        self.open.len() >= DEPTH_LIMIT || self.count > INCLUSION_LIMIT || self.repeated > REPETITION_LIMIT
    }

    /// The end of the first file.
    pub(super) fn end_of_first(&self) -> Option<Span> {
        self.first
    }
}

impl Interpreter<'_> {
    /// Reads the first file and whatever it includes.
    pub(super) fn run(&mut self, name: &str, text: Vec<u8>) {
        if text.len() > TEXT_LIMIT {
            let message = format!("can't read {}: it is larger than 4 GiB", quote(name.as_bytes()));
            self.report().push(Diagnostic::error("unreadable-file", None, message));
            return;
        }
        let end = text.len() as u32;
        let path = normalized(Path::new(name));
        let file = self.cx.report.add_source(name.to_owned(), text);
        self.inclusion.texts.insert(path.clone(), file);
        self.inclusion.first = Some(Span { file, start: end, end });
        self.open(path, file, None);
        while let Some(frame) = self.inclusion.open.last() {
            let (text, file, at) = (Arc::clone(&frame.text), frame.file, frame.at);
            self.read_frame(&text, file, at);
        }
    }

    /// Carries out the statements of the innermost file, until it ends or opens another.
    fn read_frame(&mut self, text: &[u8], file: FileId, at: usize) {
        let report = Rc::clone(&self.cx.report);
        let mut parser = Parser::new(text, file, at, &report);
        while let Some(statement) = parser.next_statement() {
            let opens = matches!(statement.rule.directive, Directive::Include | Directive::Import);
            if opens && let Some(frame) = self.inclusion.open.last_mut() {
                frame.at = parser.position();
            }
            self.execute(statement);
            if opens {
                return;
            }
        }
        self.close();
    }

    fn open(&mut self, path: PathBuf, file: FileId, import: Option<Box<Import>>) {
        let text = self.cx.report.text(file);
        self.inclusion.open.push(Frame { path, file, text, at: 0, import });
    }

    fn close(&mut self) {
        if let Some(Frame { import: Some(import), .. }) = self.inclusion.open.pop() {
            self.close_scopes(import.depth);
            self.state = import.state;
        }
    }

    /// Opens the file that an `Include` or `Import` names.
    pub(super) fn include(&mut self, statement: &Statement, import: bool) {
        let [name] = &statement.names[..] else { return };
        self.inclusion.count += 1;
        if self.inclusion.exceeds_limits() {
            if !std::mem::replace(&mut self.inclusion.told_limit, true) {
                let message = format!(
                    "too much is included: {DEPTH_LIMIT} files at once, {INCLUSION_LIMIT} in all and {} MiB of files \
                     read before are the limits",
                    REPETITION_LIMIT >> 20
                );
                self.report().error("inclusion-limit", name.span, message);
            }
            return;
        }
        let Some((path, file)) = self.source(name) else { return };
        if self.inclusion.open.iter().any(|frame| frame.path == path) {
            let message = format!("{} includes itself", quote(name.text.as_bytes()));
            let chain: Vec<String> =
                self.inclusion.open.iter().map(|frame| frame.path.display().to_string()).collect();
            self.report().push(
                Diagnostic::error("cyclic-include", name.span, message)
                    .with_note(format!("the open files are {}", chain.join(", "))),
            );
            return;
        }
        let import =
            import.then(|| Box::new(Import { state: self.state.clone(), depth: self.scopes.depth() }));
        self.open(path, file, import);
    }

    /// The text that `name` names.
    fn source(&mut self, name: &Name) -> Option<(PathBuf, FileId)> {
        for path in self.cx.files.candidates(&name.text) {
            if let Some(&file) = self.inclusion.texts.get(&path) {
                self.inclusion.repeated += self.cx.report.text(file).len();
                return Some((path, file));
            }
        }
        let (path, text) = self.cx.read_file(name)?;
        if text.len() > TEXT_LIMIT {
            self.cx.unreadable(name.span, &name.text, "it is larger than 4 GiB");
            return None;
        }
        let file = self.cx.report.add_source(path.display().to_string(), text);
        self.inclusion.texts.insert(path.clone(), file);
        Some((path, file))
    }
}
