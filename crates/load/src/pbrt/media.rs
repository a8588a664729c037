//! Media by name. A name may be used before it is defined, as in pbrt.

use std::collections::BTreeMap;
use std::rc::Rc;

use sahl_scene::{
    Coefficients, Diagnostic, Handle, Medium, MediumInterface, Origin, SceneDesc, Span, Spectrum,
};

use super::interpreter::Interpreter;
use super::plugins::reader;
use super::report::{Report, quote};
use super::state::Category;
use super::statement::{Name, Statement};
use super::translate;

/// The media by name.
#[derive(Debug, Default)]
pub(super) struct NamedMedia {
    named: BTreeMap<String, Entry>,
}

/// A name that is defined, used, or both.
#[derive(Debug)]
struct Entry {
    handle: Handle<Medium>,
    /// Where it is defined.
    defined: Option<Span>,
    /// Where it is met first.
    met: Span,
}

/// What stands in for a medium until it is defined, and where it can't be read.
fn emptiness() -> Medium {
    let none = Spectrum::Constant(0.0);
    let coefficients = Coefficients { sigma_a: none.clone(), sigma_s: none, scale: 1.0, g: 0.0 };
    Medium::Homogeneous { coefficients, emission: None }
}

impl NamedMedia {
    /// The medium called `name`; an empty one for now if it is not defined yet.
    fn entry(&mut self, scene: &mut SceneDesc, name: &Name) -> &mut Entry {
        self.named.entry(name.text.clone()).or_insert_with(|| {
            let origin = Origin::named(name.text.clone(), name.span);
            Entry { handle: scene.media.push(emptiness(), origin), defined: None, met: name.span }
        })
    }

    /// Reports the names that are used but never defined.
    pub(super) fn check(&self, report: &Report) {
        for (name, entry) in self.named.iter().filter(|(_, entry)| entry.defined.is_none()) {
            let message = format!("there is no medium called {}", quote(name.as_bytes()));
            let diagnostic = Diagnostic::error("unknown-medium", entry.met, message);
            let defined = self.named.iter().filter(|(_, entry)| entry.defined.is_some());
            report.push_with_choices(diagnostic, name, defined.map(|(name, _)| name.as_str()));
        }
    }
}

impl Interpreter<'_> {
    pub(super) fn medium(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        // A medium that can't be read is defined all the same: its uses are no errors.
        let medium = self.read_medium(statement);
        let entry = self.media.entry(&mut self.cx.scene, name);
        if entry.defined.replace(name.span).is_some() {
            let message = format!("medium {} is defined twice", quote(name.text.as_bytes()));
            self.report().error("redefinition", name.span, message);
            return;
        }
        if let Some(medium) = medium {
            self.cx.scene.media[entry.handle] = medium;
        }
    }

    fn read_medium(&mut self, statement: &Statement) -> Option<Medium> {
        let kind = self.plugin_type(statement)?;
        let (report, defaults) = (Rc::clone(&self.cx.report), self.state.defaults(Category::Medium));
        let p = reader("medium", &kind, statement, &defaults, &report);
        p.without_effect(&["type"]);
        let medium = translate::medium(&self.cx, &kind.text, &p, &self.state.transform());
        p.finish();
        medium
    }

    /// The media of shapes to come, and of the camera; one name stands for both sides, an empty one for empty space.
    pub(super) fn medium_interface(&mut self, statement: &Statement) {
        let (Some(inside), Some(outside)) = (statement.names.first(), statement.names.last()) else { return };
        let mut medium =
            |name: &Name| (!name.text.is_empty()).then(|| self.media.entry(&mut self.cx.scene, name).handle);
        self.state.media = MediumInterface { inside: medium(inside), outside: medium(outside) };
    }
}
