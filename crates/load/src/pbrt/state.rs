//! What directives change until the block around them ends.

use std::rc::Rc;

use sahl_image::ColorSpace;
use sahl_math::Transform;
use sahl_scene::{AreaLight, Handle, Material, MediumInterface};

use super::parameter::Parameter;

/// Parameters that `Attribute` may set for a category.
const PARAMETER_LIMIT: usize = 64;
/// Values that such a parameter may have: a spectrum, but no mesh.
const VALUE_LIMIT: usize = 2048;
/// The same for shapes, of which there are many.
const SHAPE_VALUE_LIMIT: usize = 64;

/// The graphics state.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// The current transforms at the start and at the end of the shutter's time.
    pub(super) transforms: [Transform; 2],
    /// Which of them transform directives change.
    pub(super) active: [bool; 2],
    pub(super) reverse_orientation: bool,
    pub(super) material: CurrentMaterial,
    pub(super) area_light: Option<Rc<AreaLight>>,
    /// The media about shapes and the camera.
    pub(super) media: MediumInterface,
    /// The space of RGB values.
    pub(super) color_space: ColorSpace,
    /// What `Attribute` sets, by [`Category`].
    pub(super) defaults: [Rc<Vec<Rc<Parameter>>>; 5],
}

/// The material of shapes to come.
#[derive(Clone, Copy, Debug)]
pub(super) enum CurrentMaterial {
    /// None was given.
    Default,
    /// One of the scene.
    Given(Handle<Material>),
    /// Shapes bound media only.
    Interface,
}

/// What the parameters of `Attribute` are for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Category {
    Shape,
    Light,
    Material,
    Medium,
    Texture,
}

/// The names of the categories.
pub(super) const CATEGORIES: &[(&str, Category)] = &[
    ("shape", Category::Shape),
    ("light", Category::Light),
    ("material", Category::Material),
    ("medium", Category::Medium),
    ("texture", Category::Texture),
];

impl Default for State {
    fn default() -> Self {
        Self {
            transforms: [Transform::IDENTITY; 2],
            active: [true; 2],
            reverse_orientation: false,
            material: CurrentMaterial::Default,
            area_light: None,
            media: MediumInterface::default(),
            color_space: ColorSpace::Srgb,
            defaults: Default::default(),
        }
    }
}

impl State {
    /// The transform at the start of the shutter's time.
    pub(super) fn transform(&self) -> Transform {
        self.transforms[0]
    }

    /// Whether the transform changes while the shutter is open.
    pub(super) fn moves(&self) -> bool {
        self.transforms[0] != self.transforms[1]
    }

    /// Replaces each active transform by what `change` makes of it, unless it makes nothing of one of them.
    pub(super) fn change(&mut self, change: impl Fn(&Transform) -> Option<Transform>) -> Option<()> {
        let mut changed = self.transforms;
        for (transform, active) in changed.iter_mut().zip(self.active) {
            if active {
                *transform = change(transform)?;
            }
        }
        self.transforms = changed;
        Some(())
    }

    /// The parameters that `Attribute` set for a category.
    pub(super) fn defaults(&self, category: Category) -> Rc<Vec<Rc<Parameter>>> {
        Rc::clone(&self.defaults[category as usize])
    }

    /// Adds to the parameters of a category; of two with the same name the later counts.
    ///
    /// # Errors
    /// The first parameter for which there is no room: everything that follows would copy it, so that a few lines
    /// could ask for any amount of memory.
    pub(super) fn add_defaults(
        &mut self,
        category: Category,
        parameters: Vec<Parameter>,
    ) -> Result<(), Parameter> {
        let list = Rc::make_mut(&mut self.defaults[category as usize]);
        let most_values = if matches!(category, Category::Shape) { SHAPE_VALUE_LIMIT } else { VALUE_LIMIT };
        for parameter in parameters {
            list.retain(|old| old.name != parameter.name);
            if list.len() == PARAMETER_LIMIT || parameter.values.len() > most_values {
                return Err(parameter);
            }
            list.push(Rc::new(parameter));
        }
        Ok(())
    }
}
