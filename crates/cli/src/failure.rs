//! How a command ends when it does not end well.

use std::io;
use std::path::Path;
use std::process::ExitCode;

/// What the exit code tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    /// Rendering failed, or a comparison found a bias.
    Render,
    /// What was typed makes no sense.
    Usage,
    /// The scene has errors.
    Scene,
    /// A file can't be read or written.
    File,
    /// A signal asked for the end.
    Interrupted,
}

impl Reason {
    /// The number that the process ends with.
    pub(crate) fn code(self) -> u8 {
        match self {
            Self::Render => 1,
            Self::Usage => 2,
            Self::Scene => 3,
            Self::File => 4,
            Self::Interrupted => 130,
        }
    }
}

impl From<Reason> for ExitCode {
    fn from(reason: Reason) -> Self {
        Self::from(reason.code())
    }
}

/// Why a command could not do its work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Failure {
    /// What the exit code tells.
    pub(crate) reason: Reason,
    /// What is wrong, in lower case; empty if it was already said.
    pub(crate) message: String,
    /// What to do about it.
    pub(crate) help: Option<String>,
}

impl Failure {
    pub(crate) fn new(reason: Reason, message: impl Into<String>) -> Self {
        Self { reason, message: message.into(), help: None }
    }

    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self::new(Reason::Usage, message)
    }

    /// `action` is what could not be done, such as "can't read".
    pub(crate) fn file(action: &str, path: &Path, error: &io::Error) -> Self {
        Self::new(Reason::File, format!("{action} `{}`: {}", path.display(), plain(error)))
    }

    #[must_use]
    pub(crate) fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// The system's words without its error number.
fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or(&text);
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}
