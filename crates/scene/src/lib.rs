//! A scene as plain data.
//!
//! Design decision: whatever file a scene comes from, it becomes a [`SceneDesc`]: values that refer to each other by
//! typed [`Handle`]s, that can be cloned, compared, serialised and edited, and that each know the [`Span`] of source
//! text they came from. What is wrong with a scene is told by [`Diagnostic`]s, which point at such spans.
//!
//! Deliberately absent: file access (the loaders do it), and anything computed for rendering (the renderer does it).
#![forbid(unsafe_code)]

mod arena;
mod camera;
mod diagnostic;
mod face_images;
mod film;
mod integrator;
mod light;
mod material;
mod measured;
mod medium;
mod open_pbr;
mod quirks;
mod shape;
mod source;
mod spectrum;
pub mod suggest;
mod texture;
mod validate;

use std::sync::Arc;

use sahl_image::Image;
use sahl_math::{AnimatedTransform, Transform};
use serde::{Deserialize, Serialize};

pub use arena::{Arena, Handle, Origin};
pub use camera::{Aperture, Camera, LensElement, LensSystem, Projection, SphereLayout};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use face_images::{Face, FaceImages, FaceTexels, Neighbor};
pub use film::{Film, Filter, Sampler, SamplerKind};
pub use integrator::{Integrator, LightSampler, PathTracer};
pub use light::{AreaLight, Light, Radiance};
pub use material::{
    Coat, ConductorReflectance, Hair, HairColor, Material, Relief, Roughness, Subsurface,
    SubsurfaceScattering,
};
pub use measured::{MeasuredBrdf, MeasuredGrid};
pub use medium::{
    CloudMedium, Coefficients, Emission, Grid, GridEmission, GridMedium, GridSource, Medium, MediumInterface,
    Region, RgbGridMedium, SparseGrid, SparseMedium, TemperatureScale,
};
pub use open_pbr::OpenPbr;
pub use quirks::Quirks;
pub use shape::{CurveKind, Curves, Geometry, Mesh, PatchMesh, Shape, TriangleMesh};
pub use source::{FileId, Location, SourceFile, Sources, Span};
pub use spectrum::{ColorMode, Spectrum};
pub use texture::{
    FaceTexture, FloatParam, ImageTexture, SolidNoise, SpectrumParam, Texture, TextureFilter, TextureMapping,
    UvMapping, Wrap,
};

/// Everything that is needed to render an image, and nothing that is computed from it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SceneDesc {
    /// The camera.
    pub camera: Camera,
    /// Resolution, crop and sensor of the image.
    pub film: Film,
    /// Reconstruction filter of the pixels.
    pub filter: Filter,
    /// Source of sample points.
    pub sampler: Sampler,
    /// Light transport algorithm.
    pub integrator: Integrator,
    /// How colour is carried.
    #[serde(default)]
    pub color: ColorMode,
    /// What is computed as the renderer does that the scene was made for.
    #[serde(default)]
    pub quirks: Quirks,
    /// Decoded image files, shared with whoever decoded them.
    pub images: Arena<Arc<Image>>,
    /// Functions over surfaces.
    pub textures: Arena<Texture>,
    /// Surface scattering.
    pub materials: Arena<Material>,
    /// What fills the space between surfaces.
    pub media: Arena<Medium>,
    /// Meshes of triangles.
    pub triangle_meshes: Arena<TriangleMesh>,
    /// Meshes of bilinear patches.
    pub patch_meshes: Arena<PatchMesh>,
    /// Sets of curves.
    pub curves: Arena<Curves>,
    /// Every shape, whether it stands in the world or in an object.
    pub shapes: Arena<Shape>,
    /// The shapes that stand in the world.
    pub world: Vec<Handle<Shape>>,
    /// Groups of shapes that are placed by instances.
    pub objects: Arena<Object>,
    /// The placements of objects.
    pub instances: Arena<Instance>,
    /// Lights other than emitting shapes.
    pub lights: Arena<Light>,
}

/// A group of shapes that is built once and placed many times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// The shapes of the group; their transforms lead to the object's space.
    pub shapes: Vec<Handle<Shape>>,
}

/// One placement of an [`Object`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instance {
    /// What is placed.
    pub object: Handle<Object>,
    /// From the object's space to the world.
    pub object_to_world: Transform,
    /// How it moves while the shutter is open. It takes the place of `object_to_world`, which is where it stands when the shutter opens.
    pub motion: Option<Box<AnimatedTransform>>,
}

impl Instance {
    /// A placement that stands still.
    pub fn new(object: Handle<Object>, object_to_world: Transform) -> Self {
        Self { object, object_to_world, motion: None }
    }
}
