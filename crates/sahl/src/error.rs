//! Why a scene can't be rendered.

use std::fmt;

use crate::scene::{Diagnostics, Sources};

/// A scene that has errors.
///
/// Displayed, it is the text that the command line prints: each message with its file, line and excerpt.
#[derive(Clone, Debug)]
pub struct SceneError {
    diagnostics: Diagnostics,
    sources: Sources,
}

impl SceneError {
    pub(crate) fn new(diagnostics: Diagnostics, sources: Sources) -> Self {
        Self { diagnostics, sources }
    }

    /// All messages, warnings included.
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// The files that the messages point into.
    pub fn sources(&self) -> &Sources {
        &self.sources
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.diagnostics.render_text(&self.sources, false);
        f.write_str(text.trim_end())
    }
}

impl std::error::Error for SceneError {}
