//! Statements to a scene.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use sahl_math::{Transform, Vec3};
use sahl_scene::{ColorMode, Diagnostic, Diagnostics, Quirks, SceneDesc, Sources, Span};

use super::context::{Context, Files};
use super::inclusion::Inclusion;
use super::materials::NamedMaterials;
use super::media::NamedMedia;
use super::objects::Objects;
use super::report::{Report, quote};
use super::scope::Scopes;
use super::state::{CATEGORIES, State};
use super::statement::{Block, Directive, Statement};
use super::translate::{self, Options};
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
    pub(super) coordinate_systems: BTreeMap<String, [Transform; 2]>,
    /// When motions begin and end, in seconds.
    pub(super) transform_times: [f32; 2],
    /// Where the camera is halfway through its motion: instances move about it.
    pub(super) camera_middle: Vec3,
    pub(super) media: NamedMedia,
    pub(super) options: Options,
    /// Sensitivity of the film.
    pub(super) iso: f32,
    pub(super) sampler_has_seed: bool,
    /// Where the world begins, once it has.
    world: Option<Span>,
    /// Whether a directive of the world stood before it.
    world_is_missing: bool,
    /// Where directives stand that count once.
    pub(super) seen: BTreeMap<&'static str, Span>,
}

impl<'a> Interpreter<'a> {
    /// An interpreter of the scene whose first file is called `name`.
    pub(super) fn new(name: &str, assets: &'a dyn AssetSource) -> Self {
        let identity = [Transform::IDENTITY; 2];
        let cx = Context {
            report: Rc::new(Report::default()),
            // pbrt-v4 renders spectra, and its scenes mean them.
            scene: SceneDesc { color: ColorMode::Spectral, quirks: Quirks::PBRT_V4, ..SceneDesc::default() },
            files: Files::beside(name, assets),
            float_textures: BTreeMap::new(),
            spectrum_textures: BTreeMap::new(),
            images: Default::default(),
            meshes: BTreeMap::new(),
            measurements: RefCell::default(),
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
            transform_times: [0.0, 1.0],
            camera_middle: Vec3::ZERO,
            media: NamedMedia::default(),
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
            D::MediumInterface => self.medium_interface(&statement),
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
            let diagnostic =
                Diagnostic::error("repeated-directive", statement.span, "`WorldBegin` stands twice");
            self.report().push_with_place(diagnostic, "the first is in", first);
            return;
        }
        self.world = Some(statement.span);
        self.state.transforms = [Transform::IDENTITY; 2];
        self.state.active = [true; 2];
        self.coordinate_systems.insert("world".to_owned(), self.state.transforms);
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
                self.report().push_with_choices(diagnostic, &name.text, names);
            }
        }
    }

    fn attribute(&mut self, statement: Statement) {
        let [name] = &statement.names[..] else { return };
        match CATEGORIES.iter().find(|(category, _)| *category == name.text) {
            Some((_, category)) => {
                if let Err(parameter) = self.state.add_defaults(*category, statement.parameters) {
                    let message =
                        format!("{} is more than `Attribute` can hold", quote(parameter.name.as_bytes()));
                    self.report().error("too-many-parameters", parameter.declaration, message);
                }
            }
            None => {
                let message = format!("`Attribute` has no category {}", quote(name.text.as_bytes()));
                let diagnostic = Diagnostic::error("unknown-value", name.span, message);
                let names = CATEGORIES.iter().map(|(category, _)| *category);
                self.report().push_with_choices(diagnostic, &name.text, names);
            }
        }
    }

    /// What is left to check when all statements are carried out; then the scene, the messages and the texts.
    pub(super) fn finish(mut self) -> (SceneDesc, Diagnostics, Sources) {
        self.close_scopes(0);
        self.resolve_instances();
        self.materials.check(&self.cx.scene, &self.cx.report);
        self.media.check(&self.cx.report);
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
}
