//! Directives that name a plugin: each hands its parameters to [`super::translate`].

use std::rc::Rc;

use sahl_math::Vec3;
use sahl_scene::{Camera, Diagnostic, Geometry, MediumInterface, Shape, Spectrum};

use super::interpreter::Interpreter;
use super::motion::{self, Mover};
use super::parameter::Parameter;
use super::reader::Reader;
use super::report::{Report, quote};
use super::state::{Category, CurrentMaterial};
use super::statement::{Directive, Name, Statement};
use super::translate::{self, FilmSettings, Surfaces};

impl Interpreter<'_> {
    /// Camera, film and the like: the last of a kind counts.
    pub(super) fn option_plugin(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        let directive = statement.rule.name;
        if let Some(first) = self.seen.insert(directive, statement.span) {
            let message = format!("`{directive}` stands twice: the last is used");
            let diagnostic = Diagnostic::warning("repeated-directive", statement.span, message);
            self.report().push_with_place(diagnostic, "the one before is in", first);
        }
        let report = Rc::clone(&self.cx.report);
        let kind =
            if directive == "PixelFilter" { "pixel filter".to_owned() } else { directive.to_lowercase() };
        let p = reader(&kind, name, statement, &[], &report);
        let scene = &mut self.cx.scene;
        match statement.rule.directive {
            Directive::Camera => self.camera(&name.text, &p),
            Directive::Film => {
                if let Some(FilmSettings { film, iso }) =
                    translate::film(&name.text, &p, self.state.color_space)
                {
                    scene.film = film;
                    self.iso = iso;
                }
            }
            Directive::Sampler => {
                if let Some(sampler) = translate::sampler(&name.text, &p) {
                    scene.sampler = sampler;
                    self.sampler_has_seed = p.has("seed");
                }
            }
            Directive::PixelFilter => {
                scene.filter = translate::filter(&name.text, &p).unwrap_or(scene.filter);
            }
            Directive::Integrator => {
                scene.integrator = translate::integrator(&name.text, &p).unwrap_or(scene.integrator);
            }
            _ => translate::accelerator(&name.text, &p),
        }
        p.finish();
    }

    fn camera(&mut self, name: &str, p: &Reader<'_>) {
        let to_world = self.state.transforms.map(|transform| transform.inverse());
        if let Some(mut camera) = translate::camera(&mut self.cx, name, p) {
            let mover = Mover { what: "the camera", span: p.span(), pivot: Vec3::ZERO };
            (camera.camera_to_world, camera.motion) = self.placed(mover, to_world, camera.shutter);
            self.camera_middle = motion::middle_of_camera(to_world);
            self.cx.scene.camera = Camera { medium: self.state.media.outside, ..camera };
        }
        self.coordinate_systems.insert("camera".to_owned(), to_world);
    }

    /// The plugin that `"string type"` names, for directives that define something by name.
    pub(super) fn plugin_type(&self, statement: &Statement) -> Option<Name> {
        let what = format!("`{}`", statement.rule.name);
        let p = Reader::new(what, statement.span, &statement.parameters, &[], self.report());
        let name = p.string("type");
        if name.is_none() && !p.has("type") {
            let message = format!("{} needs a `string type`", p.what());
            self.report().error("missing-parameter", statement.span, message);
        }
        name.cloned()
    }

    pub(super) fn texture(&mut self, statement: &Statement) {
        let [.., plugin] = &statement.names[..] else { return };
        let (report, defaults) = (Rc::clone(&self.cx.report), self.state.defaults(Category::Texture));
        let p = reader("texture", plugin, statement, &defaults, &report);
        translate::texture(&mut self.cx, statement, &p, &self.state.transform());
        p.finish();
    }

    /// White of the colour space in force.
    fn white(&self) -> Spectrum {
        Spectrum::Rgb { rgb: [1.0; 3], space: self.state.color_space }
    }

    pub(super) fn light(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        if self.state.moves() {
            let message = "lights don't move, as in pbrt-v4: this one stays where it is at the start";
            self.report().warning("unsupported-motion", statement.span, message);
        }
        let (report, defaults) = (Rc::clone(&self.cx.report), self.state.defaults(Category::Light));
        let p = reader("light", name, statement, &defaults, &report);
        let frame = translate::LightFrame { to_world: self.state.transform(), white: self.white() };
        translate::light(&mut self.cx, &name.text, &p, &frame);
        p.finish();
    }

    pub(super) fn area_light(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        let (report, defaults) = (Rc::clone(&self.cx.report), self.state.defaults(Category::Light));
        let p = reader("area light", name, statement, &defaults, &report);
        let white = self.white();
        self.state.area_light = translate::area_light(&mut self.cx, &name.text, &p, white).map(Rc::new);
        p.finish();
    }

    pub(super) fn shape(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        let (report, defaults) = (Rc::clone(&self.cx.report), self.state.defaults(Category::Shape));
        let p = reader("shape", name, statement, &defaults, &report);
        let Surfaces { geometries, alpha } = translate::shape(&mut self.cx, &name.text, &p);
        p.finish();
        let material = match self.state.material {
            CurrentMaterial::Given(material) => material,
            CurrentMaterial::Default => self.materials.default_material(&mut self.cx.scene),
            CurrentMaterial::Interface => {
                if self.state.area_light.is_some() {
                    let message = "the light of a shape without a surface is left out, as in pbrt-v4";
                    self.report().warning("dropped-light", statement.span, message);
                }
                self.materials.interface(&mut self.cx.scene)
            }
        };
        let area_light = match self.state.material {
            CurrentMaterial::Interface => None,
            _ => self.area_light_of_shape(statement.span),
        };
        let (shape_to_world, motion) =
            self.placement(Mover { what: "the shape", span: statement.span, pivot: Vec3::ZERO });
        let media = Some(self.state.media).filter(MediumInterface::is_transition);
        for mut geometry in geometries {
            if let Geometry::Displaced { edge_length, .. } = &mut geometry {
                *edge_length *= self.options.edge_scale.unwrap_or(1.0);
            }
            let shape = Shape {
                reverse_orientation: self.state.reverse_orientation,
                area_light: area_light.as_deref().cloned(),
                media,
                alpha,
                motion: motion.clone(),
                ..Shape::new(geometry, shape_to_world, material)
            };
            self.add_shape(shape, statement.span);
        }
    }

    /// The exposure is the shutter's time at a sensitivity of 100.
    pub(super) fn expose_film(&mut self) {
        let [open, close] = self.cx.scene.camera.shutter;
        let exposure = (close - open) * self.iso / 100.0;
        if exposure > 0.0 && exposure.is_finite() {
            self.cx.scene.film.exposure = exposure;
            return;
        }
        let span = self.seen.get("Camera").copied();
        let message = format!("an exposure of {exposure} shows nothing: an exposure of 1 is used");
        self.report().push(Diagnostic::warning("exposure-range", span, message));
    }
}

/// A reader of the parameters of `statement`, whose plugin is called `name`.
pub(super) fn reader<'p>(
    kind: &str,
    name: &Name,
    statement: &'p Statement,
    defaults: &'p [Rc<Parameter>],
    report: &'p Report,
) -> Reader<'p> {
    let what = format!("{kind} {}", quote(name.text.as_bytes()));
    // The name of the plugin may follow among the parameters.
    let span = if statement.names.contains(name) { statement.span } else { name.span };
    Reader::new(what, span, &statement.parameters, defaults, report)
}
