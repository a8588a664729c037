//! Objects and their instances.

use std::collections::BTreeMap;
use std::rc::Rc;

use sahl_scene::{AreaLight, Diagnostic, Handle, Instance, Object, Origin, Shape, Span};

use super::interpreter::Interpreter;
use super::motion::{Mover, Placed};
use super::report::quote;
use super::scope::ScopeKind;
use super::statement::{Name, Statement};

/// The objects by name, the one being defined, and the instances.
#[derive(Debug, Default)]
pub(super) struct Objects {
    named: BTreeMap<String, Handle<Object>>,
    current: Option<Definition>,
    /// Instances; their objects may be defined later.
    instances: Vec<(Name, Placed)>,
}

/// An object that is being defined.
#[derive(Debug)]
struct Definition {
    name: Name,
    shapes: Vec<Handle<Shape>>,
}

impl Interpreter<'_> {
    pub(super) fn begin_object(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        if let Some(outer) = &self.objects.current {
            let message = "an object can't be defined inside another";
            let diagnostic = Diagnostic::error("nested-object", statement.span, message);
            self.report().push_with_place(diagnostic, "the object around it begins in", outer.name.span);
            return;
        }
        if self.push_scope(ScopeKind::Object, statement.span) {
            self.objects.current = Some(Definition { name: name.clone(), shapes: Vec::new() });
        }
    }

    pub(super) fn end_object(&mut self, statement: &Statement) {
        if !self.pop_scope(ScopeKind::Object, statement) {
            return;
        }
        let Some(Definition { name, shapes }) = self.objects.current.take() else { return };
        let origin = Origin::named(name.text.clone(), name.span);
        if let Some(former) = self.objects.named.get(&name.text) {
            let message = format!("object {} is defined twice", quote(name.text.as_bytes()));
            let diagnostic = Diagnostic::error("redefinition", name.span, message);
            let first = self.cx.scene.objects.origin(*former).span.unwrap_or(name.span);
            self.report().push_with_place(diagnostic, "the first is in", first);
            return;
        }
        let object = self.cx.scene.objects.push(Object { shapes }, origin);
        self.objects.named.insert(name.text, object);
    }

    pub(super) fn instance(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        if self.objects.current.is_some() {
            let message = "an object can't hold an instance";
            self.report().error("nested-object", statement.span, message);
            return;
        }
        let mover = Mover { what: "the instance", span: statement.span, pivot: self.camera_middle };
        let placed = self.placement(mover);
        self.objects.instances.push((name.clone(), placed));
    }

    /// The emission of a shape to be added; objects have none, as in pbrt.
    pub(super) fn area_light_of_shape(&self, span: Span) -> Option<Rc<AreaLight>> {
        let light = self.state.area_light.clone();
        if light.is_some() && self.objects.current.is_some() {
            let message = "area lights in objects are not supported: the shape emits nothing, as in pbrt-v4";
            self.report().warning("dropped-light", span, message);
            return None;
        }
        light
    }

    /// Adds a shape to the object being defined, or to the world.
    pub(super) fn add_shape(&mut self, shape: Shape, span: Span) {
        let shape = self.cx.scene.shapes.push(shape, Origin::at(span));
        match &mut self.objects.current {
            Some(object) => object.shapes.push(shape),
            None => self.cx.scene.world.push(shape),
        }
    }

    /// Turns the names of instances into objects.
    pub(super) fn resolve_instances(&mut self) {
        for (name, (object_to_world, motion)) in std::mem::take(&mut self.objects.instances) {
            match self.objects.named.get(&name.text) {
                Some(&object) => {
                    let instance = Instance { object, object_to_world, motion };
                    self.cx.scene.instances.push(instance, Origin::at(name.span));
                }
                None => {
                    let message = format!("there is no object called {}", quote(name.text.as_bytes()));
                    let diagnostic = Diagnostic::error("unknown-object", name.span, message);
                    let names = self.objects.named.keys().map(String::as_str);
                    self.report().push_with_choices(diagnostic, &name.text, names);
                }
            }
        }
    }
}
