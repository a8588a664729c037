//! Statements to a scene.

use std::collections::BTreeMap;
use std::rc::Rc;

use sahl_math::Transform;
use sahl_scene::{Diagnostic, Diagnostics, SceneDesc, Shape, Sources, Span, Spectrum};

use super::context::{Context, Files};
use super::inclusion::Inclusion;
use super::materials::NamedMaterials;
use super::objects::Objects;
use super::reader::{Reader, with_choices};
use super::report::{Report, quote};
use super::scope::Scopes;
use super::state::{CATEGORIES, Category, CurrentMaterial, State};
use super::statement::{Block, Directive, Name, Statement};
use super::translate::{self, FilmSettings, Options};
use crate::AssetSource;

/// Carries out statements in order.
pub(super) struct Interpreter<'a> {
    pub(super) cx: Context<'a>,
    pub(super) state: State,
    pub(super) scopes: Scopes,
    pub(super) inclusion: Inclusion,
    pub(super) materials: NamedMaterials,
    pub(super) objects: Objects,
    /// Named coordinate systems: the transforms that were in force.
    coordinate_systems: BTreeMap<String, [Transform; 2]>,
    /// Media by name, and where `MediumInterface` names some.
    media: BTreeMap<String, Span>,
    medium_uses: Vec<Name>,
    options: Options,
    /// Sensitivity of the film.
    iso: f32,
    sampler_has_seed: bool,
    /// Where the world begins, once it has.
    world: Option<Span>,
    /// Whether a directive of the world stood before it.
    world_is_missing: bool,
    /// Where directives stand that count once.
    seen: BTreeMap<&'static str, Span>,
}

impl<'a> Interpreter<'a> {
    /// An interpreter of the scene whose first file is called `name`.
    pub(super) fn new(name: &str, assets: &'a dyn AssetSource) -> Self {
        let identity = [Transform::IDENTITY; 2];
        let cx = Context {
            report: Rc::new(Report::default()),
            scene: SceneDesc::default(),
            files: Files::beside(name, assets),
            float_textures: BTreeMap::new(),
            spectrum_textures: BTreeMap::new(),
            images: Default::default(),
            meshes: BTreeMap::new(),
        };
        Self {
            cx,
            state: State::default(),
            scopes: Scopes::default(),
            inclusion: Inclusion::default(),
            materials: NamedMaterials::default(),
            objects: Objects::default(),
            coordinate_systems: BTreeMap::from([
                ("world".to_owned(), identity),
                ("camera".to_owned(), identity),
            ]),
            media: BTreeMap::new(),
            medium_uses: Vec::new(),
            options: Options::default(),
            iso: 100.0,
            sampler_has_seed: false,
            world: None,
            world_is_missing: false,
            seen: BTreeMap::new(),
        }
    }

    /// Where messages go.
    pub(super) fn report(&self) -> &Report {
        &self.cx.report
    }

    /// Carries out one statement.
    pub(super) fn execute(&mut self, mut statement: Statement) {
        if !self.is_allowed(&statement) {
            return;
        }
        for parameter in &mut statement.parameters {
            parameter.color_space = self.state.color_space;
        }
        use Directive as D;
        match statement.rule.directive {
            D::Identity
            | D::Translate
            | D::Scale
            | D::Rotate
            | D::LookAt
            | D::Transform
            | D::ConcatTransform => {
                self.transform(&statement);
            }
            D::ActiveTransform => self.active_transform(&statement),
            D::CoordinateSystem => self.coordinate_system(&statement),
            D::CoordSysTransform => self.coordinate_system_transform(&statement),
            D::TransformTimes => self.transform_times(&statement),
            D::ReverseOrientation => self.state.reverse_orientation = !self.state.reverse_orientation,
            D::ColorSpace => self.color_space(&statement),
            D::Attribute => self.attribute(statement),
            D::AttributeBegin | D::TransformBegin => self.begin_scope(&statement),
            D::AttributeEnd | D::TransformEnd => self.end_scope(&statement),
            D::ObjectBegin => self.begin_object(&statement),
            D::ObjectEnd => self.end_object(&statement),
            D::ObjectInstance => self.instance(&statement),
            D::Include => self.include(&statement, false),
            D::Import => self.include(&statement, true),
            D::WorldBegin => self.begin_world(&statement),
            D::Option => {
                if let [name, value] = &statement.names[..] {
                    translate::option(&mut self.options, name, value, &self.cx.report);
                }
            }
            D::Camera | D::Film | D::Sampler | D::PixelFilter | D::Integrator | D::Accelerator => {
                self.option_plugin(&statement);
            }
            D::MakeNamedMedium => self.medium(&statement),
            D::MediumInterface => self.medium_interface(statement),
            D::Material => self.material(&statement),
            D::MakeNamedMaterial => self.make_named_material(&statement),
            D::NamedMaterial => self.named_material(&statement),
            D::Texture => self.texture(&statement),
            D::LightSource => self.light(&statement),
            D::AreaLightSource => self.area_light(&statement),
            D::Shape => self.shape(&statement),
        }
    }

    /// Whether the statement stands where it may; reports it otherwise.
    fn is_allowed(&mut self, statement: &Statement) -> bool {
        let name = statement.rule.name;
        match statement.rule.block {
            Block::Options if self.world.is_some() => {
                let message = format!("`{name}` must stand before `WorldBegin`");
                self.report().error("misplaced-directive", statement.span, message);
                false
            }
            Block::World if self.world.is_none() => {
                // Told once; what follows is read as if the world had begun, to find what else is wrong.
                if !self.world_is_missing {
                    let message = format!("`{name}` must stand after `WorldBegin`");
                    self.report().push(
                        Diagnostic::error("misplaced-directive", statement.span, message).with_help(
                            "`WorldBegin` ends the part that describes camera, film and integrator",
                        ),
                    );
                    self.world_is_missing = true;
                }
                true
            }
            _ => true,
        }
    }

    fn begin_world(&mut self, statement: &Statement) {
        if let Some(first) = self.world {
            let note = format!("the first is in {}", self.report().place(first));
            self.report().push(
                Diagnostic::error("repeated-directive", statement.span, "`WorldBegin` stands twice")
                    .with_note(note),
            );
            return;
        }
        self.world = Some(statement.span);
        self.state.transforms = [Transform::IDENTITY; 2];
        self.state.active = [true; 2];
        self.coordinate_systems.insert("world".to_owned(), self.state.transforms);
    }

    fn transform(&mut self, statement: &Statement) {
        let n = &statement.numbers[..];
        let after = |change: Option<Transform>| move |current: &Transform| current.after(&change?);
        let changed = match (statement.rule.directive, n) {
            (Directive::Identity, _) => self.state.change(|_| Some(Transform::IDENTITY)),
            (Directive::Translate, &[x, y, z]) => self.state.change(after(Transform::translate(x, y, z))),
            (Directive::Scale, &[x, y, z]) => self.state.change(after(Transform::scale(x, y, z))),
            (Directive::Rotate, &[degrees, x, y, z]) => {
                self.state.change(after(Transform::rotate(degrees.to_radians(), [x, y, z])))
            }
            (Directive::LookAt, &[ex, ey, ez, lx, ly, lz, ux, uy, uz]) => {
                self.state.change(after(Transform::look_at([ex, ey, ez], [lx, ly, lz], [ux, uy, uz])))
            }
            (directive, numbers) => {
                let matrix = <[f64; 16]>::try_from(numbers).ok().and_then(Transform::from_columns);
                match directive {
                    Directive::Transform => self.state.change(|_| matrix),
                    _ => self.state.change(after(matrix)),
                }
            }
        };
        if changed.is_none() {
            self.bad_transform(statement);
        }
    }

    fn bad_transform(&self, statement: &Statement) {
        let reason = match statement.rule.directive {
            Directive::Scale => "a factor is zero, or makes the transform too large or too small",
            Directive::Rotate => "its axis has no direction",
            Directive::LookAt => "eye, target and up direction do not span a view",
            Directive::Translate => "the transform becomes too large",
            _ => "the matrix is singular, projective or too large",
        };
        let message = format!("`{}` can't be applied: {reason}", statement.rule.name);
        self.report().error("singular-transform", statement.span, message);
    }

    fn active_transform(&mut self, statement: &Statement) {
        const TIMES: &[(&str, [bool; 2])] =
            &[("StartTime", [true, false]), ("EndTime", [false, true]), ("All", [true, true])];
        let [word] = &statement.names[..] else { return };
        match TIMES.iter().find(|(name, _)| *name == word.text) {
            Some((_, active)) => self.state.active = *active,
            None => {
                let message = format!("unknown time {}", quote(word.text.as_bytes()));
                let diagnostic = Diagnostic::error("unknown-value", word.span, message);
                self.report().push(with_choices(diagnostic, &word.text, TIMES.iter().map(|(name, _)| *name)));
            }
        }
    }

    /// The times matter only to transforms that change, which are reported where they are used.
    fn transform_times(&mut self, statement: &Statement) {
        if let [start, end] = statement.numbers[..]
            && start > end
        {
            let message = format!("transforms start at {start} and end before that, at {end}");
            self.report().error("invalid-value", statement.span, message);
        }
    }

    fn coordinate_system(&mut self, statement: &Statement) {
        for name in &statement.names {
            self.coordinate_systems.insert(name.text.clone(), self.state.transforms);
        }
    }

    fn coordinate_system_transform(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        if let Some(transforms) = self.coordinate_systems.get(&name.text) {
            self.state.transforms = *transforms;
            return;
        }
        let message = format!("there is no coordinate system called {}", quote(name.text.as_bytes()));
        let diagnostic = Diagnostic::error("unknown-coordinate-system", name.span, message);
        let names = self.coordinate_systems.keys().map(String::as_str);
        self.report().push(with_choices(diagnostic, &name.text, names));
    }

    fn color_space(&mut self, statement: &Statement) {
        use sahl_image::ColorSpace;
        let [name] = &statement.names[..] else { return };
        match ColorSpace::from_name(&name.text) {
            Some(space) => self.state.color_space = space,
            None => {
                let message = format!("unknown colour space {}", quote(name.text.as_bytes()));
                let diagnostic = Diagnostic::error("unknown-value", name.span, message);
                let names = ColorSpace::ALL.iter().map(|space| space.name());
                self.report().push(with_choices(diagnostic, &name.text, names));
            }
        }
    }

    fn attribute(&mut self, statement: Statement) {
        let [name] = &statement.names[..] else { return };
        match CATEGORIES.iter().find(|(category, _)| *category == name.text) {
            Some((_, category)) => self.state.add_defaults(*category, statement.parameters),
            None => {
                let message = format!("`Attribute` has no category {}", quote(name.text.as_bytes()));
                let diagnostic = Diagnostic::error("unknown-value", name.span, message);
                let names = CATEGORIES.iter().map(|(category, _)| *category);
                self.report().push(with_choices(diagnostic, &name.text, names));
            }
        }
    }

    /// Camera, film and the like: the last of a kind counts.
    fn option_plugin(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        let directive = statement.rule.name;
        if let Some(first) = self.seen.insert(directive, statement.span) {
            let note = format!("the one before is in {}", self.report().place(first));
            let message = format!("`{directive}` stands twice: the last is used");
            self.report()
                .push(Diagnostic::warning("repeated-directive", statement.span, message).with_note(note));
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
        self.warn_of_motion(p.span(), "the camera");
        if let Some(camera) = translate::camera(name, p, &self.state.transform()) {
            self.cx.scene.camera = camera;
        }
        let to_world = self.state.transforms.map(|transform| transform.inverse());
        self.coordinate_systems.insert("camera".to_owned(), to_world);
    }

    /// Warns if the transform in force changes with time.
    pub(super) fn warn_of_motion(&self, span: Span, what: &str) {
        if self.state.moves() {
            let message = format!("motion is not supported: {what} stays where it is at the start");
            self.report().warning("unsupported-motion", span, message);
        }
    }

    fn medium(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        if self.media.insert(name.text.clone(), name.span).is_some() {
            let message = format!("medium {} is defined twice", quote(name.text.as_bytes()));
            self.report().error("redefinition", name.span, message);
        }
        let report = Rc::clone(&self.cx.report);
        if let Some(kind) = self.plugin_type(statement) {
            let defaults = self.state.defaults(Category::Medium);
            let p = reader("medium", &kind, statement, &defaults, &report);
            p.without_effect(&["type"]);
            translate::medium(&kind.text, &p);
            p.finish();
        }
    }

    fn medium_interface(&mut self, statement: Statement) {
        let named: Vec<Name> = statement.names.into_iter().filter(|name| !name.text.is_empty()).collect();
        if !named.is_empty() {
            let message = "participating media are not supported: both sides are empty space";
            self.report().warning("unsupported-medium", statement.span, message);
        }
        self.medium_uses.extend(named);
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

    fn texture(&mut self, statement: &Statement) {
        let [.., plugin] = &statement.names[..] else { return };
        let (report, defaults) = (Rc::clone(&self.cx.report), self.state.defaults(Category::Texture));
        let p = reader("texture", plugin, statement, &defaults, &report);
        translate::texture(&mut self.cx, statement, &p);
        p.finish();
    }

    /// White of the colour space in force.
    fn white(&self) -> Spectrum {
        Spectrum::Rgb { rgb: [1.0; 3], space: self.state.color_space }
    }

    fn light(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        self.warn_of_motion(statement.span, "the light");
        let (report, defaults) = (Rc::clone(&self.cx.report), self.state.defaults(Category::Light));
        let p = reader("light", name, statement, &defaults, &report);
        let frame = translate::LightFrame { to_world: self.state.transform(), white: self.white() };
        translate::light(&mut self.cx, &name.text, &p, &frame);
        p.finish();
    }

    fn area_light(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        let (report, defaults) = (Rc::clone(&self.cx.report), self.state.defaults(Category::Light));
        let p = reader("area light", name, statement, &defaults, &report);
        let white = self.white();
        self.state.area_light = translate::area_light(&mut self.cx, &name.text, &p, white).map(Rc::new);
        p.finish();
    }

    fn shape(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        let (report, defaults) = (Rc::clone(&self.cx.report), self.state.defaults(Category::Shape));
        let p = reader("shape", name, statement, &defaults, &report);
        let geometries = translate::shape(&mut self.cx, &name.text, &p);
        p.finish();
        self.warn_of_motion(statement.span, "the shape");
        let material = match self.state.material {
            CurrentMaterial::Given(material) => material,
            CurrentMaterial::Default => self.materials.default_material(&mut self.cx.scene),
            CurrentMaterial::Interface => {
                if self.state.area_light.is_some() {
                    let message = "the light of a shape without a surface is left out, as in pbrt-v4";
                    self.report().warning("dropped-light", statement.span, message);
                }
                return;
            }
        };
        let area_light = self.area_light_of_shape(statement.span);
        for geometry in geometries {
            let shape = Shape {
                geometry,
                shape_to_world: self.state.transform(),
                reverse_orientation: self.state.reverse_orientation,
                material,
                area_light: area_light.as_deref().cloned(),
            };
            self.add_shape(shape, statement.span);
        }
    }

    /// What is left to check when all statements are carried out; then the scene, the messages and the texts.
    pub(super) fn finish(mut self) -> (SceneDesc, Diagnostics, Sources) {
        self.close_scopes(0);
        self.resolve_instances();
        self.materials.resolve(&mut self.cx.scene, &self.cx.report);
        self.check_media();
        self.check_world();
        if let (Some(seed), false) = (self.options.seed, self.sampler_has_seed) {
            self.cx.scene.sampler.seed = u64::from(seed);
        }
        self.expose_film();
        let Context { report, scene, .. } = self.cx;
        let report =
            Rc::into_inner(report).expect("readers, which share the report, live as long as a statement");
        let (diagnostics, sources) = report.finish();
        (scene, diagnostics, sources)
    }

    fn check_media(&self) {
        for name in self.medium_uses.iter().filter(|name| !self.media.contains_key(&name.text)) {
            let message = format!("there is no medium called {}", quote(name.text.as_bytes()));
            let diagnostic = Diagnostic::error("unknown-medium", name.span, message);
            self.report().push(with_choices(diagnostic, &name.text, self.media.keys().map(String::as_str)));
        }
    }

    fn check_world(&self) {
        if self.world.is_none() && !self.world_is_missing {
            let end = self.inclusion.end_of_first();
            let message = "the scene has no `WorldBegin`";
            self.report().push(
                Diagnostic::error("missing-world", end, message)
                    .with_help("shapes and lights follow `WorldBegin`; see whether the file is complete"),
            );
        }
    }

    /// The exposure is the shutter's time at a sensitivity of 100.
    fn expose_film(&mut self) {
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
    defaults: &'p [super::parameter::Parameter],
    report: &'p Report,
) -> Reader<'p> {
    let what = format!("{kind} {}", quote(name.text.as_bytes()));
    // The name of the plugin may follow among the parameters.
    let span = if statement.names.contains(name) { statement.span } else { name.span };
    Reader::new(what, span, &statement.parameters, defaults, report)
}
