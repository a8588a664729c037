//! Blocks: `AttributeBegin` to `AttributeEnd`, and objects.

use sahl_scene::{Diagnostic, Span};

use super::interpreter::Interpreter;
use super::state::State;
use super::statement::{Directive, Statement};

/// Blocks that may stand in each other; scenes need a few dozen.
const DEPTH_LIMIT: usize = 1000;

/// The open blocks.
#[derive(Debug, Default)]
pub(super) struct Scopes {
    stack: Vec<Scope>,
    /// Blocks beyond the limit: counted, so that their ends match.
    excess: usize,
    /// Whether the old names were told.
    told_old_name: bool,
}

/// An open block.
#[derive(Debug)]
struct Scope {
    kind: ScopeKind,
    /// Where it was opened.
    opened: Span,
    /// What is restored at its end.
    state: State,
}

/// The kinds of block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScopeKind {
    Attributes,
    Object,
}

impl ScopeKind {
    fn begin(self) -> &'static str {
        match self {
            Self::Attributes => "AttributeBegin",
            Self::Object => "ObjectBegin",
        }
    }
}

impl Scopes {
    /// How many are open.
    pub(super) fn depth(&self) -> usize {
        self.stack.len()
    }
}

impl Interpreter<'_> {
    pub(super) fn begin_scope(&mut self, statement: &Statement) {
        self.warn_of_old_name(statement);
        self.push_scope(ScopeKind::Attributes, statement.span);
    }

    pub(super) fn end_scope(&mut self, statement: &Statement) {
        self.warn_of_old_name(statement);
        self.pop_scope(ScopeKind::Attributes, statement);
    }

    fn warn_of_old_name(&mut self, statement: &Statement) {
        let current = match statement.rule.directive {
            Directive::TransformBegin => "AttributeBegin",
            Directive::TransformEnd => "AttributeEnd",
            _ => return,
        };
        if !self.scopes.told_old_name {
            self.scopes.told_old_name = true;
            let message = format!("`{}` is an old name of `{current}`", statement.rule.name);
            self.report().warning("deprecated", statement.span, message);
        }
    }

    /// Opens a block; `false` if there are too many, which is reported.
    pub(super) fn push_scope(&mut self, kind: ScopeKind, opened: Span) -> bool {
        if self.scopes.stack.len() >= DEPTH_LIMIT {
            if self.scopes.excess == 0 {
                let message = format!("more than {DEPTH_LIMIT} blocks stand in each other");
                self.report().error("nesting-depth", opened, message);
            }
            self.scopes.excess += 1;
            return false;
        }
        self.scopes.stack.push(Scope { kind, opened, state: self.state.clone() });
        true
    }

    /// Closes the innermost block, which must be of this kind; `false` if there is none, which is reported.
    pub(super) fn pop_scope(&mut self, kind: ScopeKind, statement: &Statement) -> bool {
        if self.scopes.excess > 0 {
            self.scopes.excess -= 1;
            return false;
        }
        let base = self.inclusion.scope_base();
        let innermost = self.scopes.stack.get(base..).and_then(<[Scope]>::last);
        let name = statement.rule.name;
        let begin = kind.begin();
        match innermost {
            Some(scope) if scope.kind == kind => {
                self.restore_innermost();
                true
            }
            Some(scope) if kind == ScopeKind::Attributes => {
                let diagnostic =
                    Diagnostic::error("unmatched-end", statement.span, format!("`{name}` without `{begin}`"));
                let note = format!("the innermost block is `{}` in", scope.kind.begin());
                self.report().push_with_place(diagnostic, &note, scope.opened);
                false
            }
            _ => {
                // An object may end while blocks inside it are open: those are what is wrong.
                let object = self.scopes.stack.iter().skip(base).rposition(|scope| scope.kind == kind);
                match object {
                    Some(depth) => {
                        self.close_scopes(base + depth + 1);
                        self.restore_innermost();
                        true
                    }
                    None => {
                        self.report().error(
                            "unmatched-end",
                            statement.span,
                            format!("`{name}` without `{begin}`"),
                        );
                        false
                    }
                }
            }
        }
    }

    fn restore_innermost(&mut self) {
        if let Some(scope) = self.scopes.stack.pop() {
            self.state = scope.state;
        }
    }

    /// Reports the blocks that are open beyond the first `depth`, and closes them.
    pub(super) fn close_scopes(&mut self, depth: usize) {
        let open = self.scopes.stack.len().saturating_sub(depth);
        if depth == 0 {
            self.scopes.excess = 0;
        }
        // The outermost is where the mistake begins.
        if let Some(scope) = self.scopes.stack.get(depth) {
            let begin = scope.kind.begin();
            let message = format!("this `{begin}` is never closed");
            let mut diagnostic = Diagnostic::error("unclosed-block", scope.opened, message);
            if open > 1 {
                diagnostic = diagnostic.with_note(format!("{} blocks inside it are open as well", open - 1));
            }
            self.report().push(diagnostic);
        }
        if let Some(scope) = self.scopes.stack.drain(depth.min(self.scopes.stack.len())..).next() {
            self.state = scope.state;
        }
    }
}
