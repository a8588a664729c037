//! Materials by name. A name may be used before it is defined, as in pbrt.

use std::collections::BTreeMap;
use std::rc::Rc;

use sahl_scene::{Diagnostic, Handle, Material, Origin, SceneDesc, Span};

use super::interpreter::Interpreter;
use super::plugins::reader;
use super::report::{Report, quote};
use super::state::{Category, CurrentMaterial};
use super::statement::{Directive, Name, Statement};
use super::translate::{self, MaterialKind};

/// The materials by name.
#[derive(Debug, Default)]
pub(super) struct NamedMaterials {
    named: BTreeMap<String, Entry>,
    default: Option<Handle<Material>>,
    interface: Option<Handle<Material>>,
}

/// A name that is defined, used, or both.
#[derive(Debug)]
struct Entry {
    handle: Handle<Material>,
    /// Where it is defined.
    defined: Option<Span>,
    /// Where it is used first, if that is before.
    used: Option<Span>,
    interface: bool,
}

impl NamedMaterials {
    /// The material of shapes for which none is given.
    pub(super) fn default_material(&mut self, scene: &mut SceneDesc) -> Handle<Material> {
        *self.default.get_or_insert_with(|| scene.materials.push(Material::default(), Origin::default()))
    }

    /// The material of shapes that bound media only.
    pub(super) fn interface(&mut self, scene: &mut SceneDesc) -> Handle<Material> {
        *self.interface.get_or_insert_with(|| scene.materials.push(Material::Interface, Origin::default()))
    }

    /// The material called `name`; an empty place for it if it is not defined yet.
    fn entry(&mut self, scene: &mut SceneDesc, name: &Name) -> &mut Entry {
        self.named.entry(name.text.clone()).or_insert_with(|| Entry {
            handle: scene.materials.push(Material::default(), Origin::named(name.text.clone(), name.span)),
            defined: None,
            used: Some(name.span),
            interface: false,
        })
    }

    /// Reports materials that were used and never defined, and those that are mixed of themselves.
    pub(super) fn check(&self, scene: &SceneDesc, report: &Report) {
        for (text, entry) in &self.named {
            let (None, Some(used)) = (entry.defined, entry.used) else { continue };
            let message = format!("there is no material called {}", quote(text.as_bytes()));
            let diagnostic = Diagnostic::error("unknown-material", used, message);
            let defined = self.named.iter().filter(|(_, entry)| entry.defined.is_some());
            report.push_with_choices(diagnostic, text, defined.map(|(name, _)| name.as_str()));
        }
        for handle in scene.cyclic_materials() {
            // Only materials that a file names can be part of others.
            let Some(span) = scene.materials.origin(handle).span else { continue };
            report.error("cyclic-material", span, "this material is mixed of itself");
        }
    }
}

impl Interpreter<'_> {
    pub(super) fn material(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        let Some(kind) = self.read_material(name, statement) else { return };
        if let MaterialKind::Interface = kind {
            self.state.material = CurrentMaterial::Interface;
            return;
        }
        let handle = self.cx.scene.materials.push(Material::default(), Origin::at(statement.span));
        self.fill_material(handle, kind);
        self.state.material = CurrentMaterial::Given(handle);
    }

    fn read_material(&mut self, plugin: &Name, statement: &Statement) -> Option<MaterialKind> {
        let (report, defaults) = (Rc::clone(&self.cx.report), self.state.defaults(Category::Material));
        let p = reader("material", plugin, statement, &defaults, &report);
        if statement.rule.directive == Directive::MakeNamedMaterial {
            p.without_effect(&["type"]);
        }
        let material = translate::material(&mut self.cx, &plugin.text, &p);
        p.finish();
        material
    }

    /// Puts what a directive asks for into the place of a material.
    fn fill_material(&mut self, handle: Handle<Material>, kind: MaterialKind) {
        match kind {
            MaterialKind::Surface(material) => self.cx.scene.materials[handle] = material,
            MaterialKind::Shaped(material, relief) => {
                let origin = self.cx.scene.materials.origin(handle).clone();
                let material = self.cx.scene.materials.push(material, origin);
                self.cx.scene.materials[handle] = Material::Relief { material, relief };
            }
            MaterialKind::Mix(names, amount) => {
                let materials = names.map(|name| {
                    let part = self.materials.entry(&mut self.cx.scene, &name);
                    if part.interface {
                        let message = "an `interface` can't be part of a mix";
                        self.cx.report.error("invalid-value", name.span, message);
                    }
                    part.handle
                });
                self.cx.scene.materials[handle] = Material::Mix { materials, amount };
            }
            MaterialKind::Interface => {}
        }
    }

    pub(super) fn make_named_material(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        // A material that can't be read is defined all the same: its uses are no errors.
        let kind = self.plugin_type(statement).and_then(|plugin| self.read_material(&plugin, statement));
        let entry = self.materials.entry(&mut self.cx.scene, name);
        if let Some(former) = entry.defined {
            let message = format!("material {} is defined twice", quote(name.text.as_bytes()));
            let diagnostic = Diagnostic::error("redefinition", name.span, message);
            self.report().push_with_place(diagnostic, "the first is in", former);
            return;
        }
        entry.defined = Some(name.span);
        let handle = entry.handle;
        let Some(kind) = kind else { return };
        if let MaterialKind::Interface = kind {
            if let Some(used) = entry.used.filter(|used| *used != name.span) {
                let message = "this `interface` is used before it is defined: shapes up to here are solid";
                let diagnostic = Diagnostic::warning("unsupported-material", name.span, message);
                self.report().push_with_place(diagnostic, "it is used in", used);
            }
            if let Some(entry) = self.materials.named.get_mut(&name.text) {
                entry.interface = true;
            }
        }
        self.fill_material(handle, kind);
    }

    pub(super) fn named_material(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        let entry = self.materials.entry(&mut self.cx.scene, name);
        self.state.material = match entry.interface {
            true => CurrentMaterial::Interface,
            false => CurrentMaterial::Given(entry.handle),
        };
    }
}
