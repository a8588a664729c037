//! The standard error stream: messages, in colour where that is welcome, or as JSON.

use std::io::{self, IsTerminal, Write};

use sahl::scene::{Diagnostics, Severity, Sources};
use serde_json::{Value, json};

use crate::args::{DiagnosticsForm, MessageArgs};
use crate::failure::Failure;

/// Where everything goes that is not a result.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Console {
    color: bool,
    quiet: bool,
    json: bool,
}

impl Console {
    /// `json` asks for one JSON object a message, as `--diagnostics json` does.
    pub(crate) fn new(messages: &MessageArgs, json: bool) -> Self {
        let json = json || messages.diagnostics == DiagnosticsForm::Json;
        Self { color: !json && color_is_welcome(), quiet: messages.quiet, json }
    }

    /// For commands that read no scene.
    pub(crate) fn plain() -> Self {
        Self { color: color_is_welcome(), quiet: false, json: false }
    }

    /// Whether only errors are printed.
    pub(crate) fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// One line for people.
    pub(crate) fn line(&self, text: &str) {
        // A closed standard error is no reason to stop a render.
        let _ = writeln!(io::stderr(), "{text}");
    }

    /// One JSON object.
    pub(crate) fn event(&self, event: &Value) {
        self.line(&event.to_string());
    }

    /// What is wrong with a scene. Quiet consoles keep warnings to themselves, never errors.
    pub(crate) fn diagnostics(&self, diagnostics: &Diagnostics, sources: &Sources) {
        let shown = if self.quiet { errors_of(diagnostics) } else { diagnostics.clone() };
        if shown.is_empty() {
            return;
        }
        if !self.json {
            self.line(shown.render_text(sources, self.color).trim_end_matches('\n'));
            return;
        }
        for line in shown.render_json(sources).lines() {
            match serde_json::from_str::<Value>(line) {
                Ok(Value::Object(mut object)) => {
                    object.insert("event".to_owned(), json!("diagnostic"));
                    self.event(&Value::Object(object));
                }
                _ => self.line(line),
            }
        }
    }

    /// Why the command ends.
    pub(crate) fn failure(&self, failure: &Failure) {
        if failure.message.is_empty() {
            return;
        }
        if self.json {
            self.event(&json!({
                "event": "error",
                "exit_code": failure.reason.code(),
                "message": failure.message,
                "help": failure.help,
            }));
            return;
        }
        let (red, cyan, plain) =
            if self.color { ("\x1b[1;31m", "\x1b[1;36m", "\x1b[0m") } else { ("", "", "") };
        self.line(&format!("{red}error{plain}: {}", failure.message));
        if let Some(help) = &failure.help {
            self.line(&format!("  {cyan}help{plain}: {help}"));
        }
    }
}

fn errors_of(diagnostics: &Diagnostics) -> Diagnostics {
    let mut errors = Diagnostics::default();
    errors.extend(diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).cloned());
    errors
}

/// Colour is for terminals that know it, unless the environment says otherwise (no-color.org, bixense.com/clicolors).
fn color_is_welcome() -> bool {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty());
    if set("NO_COLOR").is_some() {
        return false;
    }
    if set("CLICOLOR_FORCE").is_some_and(|value| value != "0") {
        return true;
    }
    io::stderr().is_terminal() && set("TERM").is_none_or(|value| value != "dumb")
}
