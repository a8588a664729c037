//! From a description to a scene that can be rendered.
//!
//! Design decision: positions of meshes are moved into the world (or into the space of their object) once, so that a hit
//! transforms nothing; a mesh that stands there already is shared with the description. What moves is placed by instances
//! (`placement`). What the description says and rendering does not honour becomes a diagnostic.
//!
//! Deliberately absent: files. Images come decoded.

mod displacement;
mod geometry;
mod lights;
mod media;
mod placement;

use std::sync::Arc;

use sahl_accel::{Accel, Geometry, Instance, Placement, World};
use sahl_scene::{ColorMode, Diagnostic, Diagnostics, Integrator, SceneDesc};

use crate::camera::Camera;
use crate::filter::PixelFilter;
use crate::integrator::{self, MOST_WHITTED_DEPTH};
use crate::material::{Material, SharedTables};
use crate::sampler::Sampler;
use crate::scene::{Scene, SceneData, SceneStats};
use crate::shape::Border;
use crate::spectrum::RGB_MODE_CODES;
use crate::texture::Textures;

use geometry::GeometryBuilder;
use lights::LightBuilder;

/// Settings of [`build`] that do not change the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildOptions {
    /// How the acceleration structure is built.
    pub accel: sahl_accel::BuildOptions,
}

/// Builds the scene that `description` describes.
///
/// The result is `None` if and only if there are errors among the diagnostics. Warnings tell what will be rendered
/// differently from what the description says.
pub fn build(description: &SceneDesc, options: &BuildOptions) -> (Option<Scene>, Diagnostics) {
    let mut diagnostics = description.validate();
    if diagnostics.has_errors() {
        return (None, diagnostics);
    }
    if let Integrator::Whitted { max_depth } = description.integrator
        && max_depth > MOST_WHITTED_DEPTH
    {
        let message = format!("`whitted` follows {MOST_WHITTED_DEPTH} reflections in a row, not {max_depth}");
        diagnostics.push(Diagnostic::warning("depth-limited", None, message));
    }
    media::warn_of_absence(description, &mut diagnostics);
    media::warn_of_solidity(description, &mut diagnostics);
    let textures = Textures::new(description, &mut diagnostics);
    let materials = materials(description, &textures, &mut diagnostics);
    let mut lights = LightBuilder::new(description, &textures, &mut diagnostics);
    let has_media = media::are_honoured(description);
    let geometry = GeometryBuilder::new(description, &textures, has_media).build(&mut lights);
    lights.add_lights();
    let lights = lights.lights;
    let media = if has_media { media::media(description, &mut diagnostics) } else { Vec::new() };
    if description.color == ColorMode::Spectral {
        diagnostics.retain(|diagnostic| !RGB_MODE_CODES.contains(&diagnostic.code));
    }
    let camera = Camera::new(description, &mut diagnostics);
    let Some(camera) = camera.filter(|_| !diagnostics.has_errors()) else { return (None, diagnostics) };

    let moves = camera.moves() || moves(&geometry.world);
    let counts = geometry.counts;
    let accel = Accel::build(geometry.world, &options.accel);
    let radius = accel.bounds().bounding_sphere().map_or(0.0, |(_, radius)| radius);
    let stats = SceneStats {
        materials: materials.len() as u64,
        textures: description.textures.len() as u64,
        images: description.images.len() as u64,
        lights: lights.len() as u64,
        data_bytes: counts.data_bytes + image_bytes(description) + textures.pyramid_bytes(),
        accel: accel.stats(),
        ..counts
    };
    let environments = (0..lights.len() as u32).filter(|&i| lights[i as usize].is_environment()).collect();
    let data = SceneData {
        color: color_mode(description),
        quirks: description.quirks,
        integrator: integrator::new(&description.integrator, &lights, radius, has_media),
        accel,
        has_alpha: geometry.attributes.iter().any(|attributes| attributes.alpha.is_some()),
        attributes: geometry.attributes,
        materials,
        textures,
        media,
        camera_medium: description.camera.medium.map_or(Border::VACUUM, |medium| medium.index() as u32),
        lights,
        environments,
        camera,
        film: description.film.clone(),
        filter: PixelFilter::new(&description.filter),
        sampler: Sampler::new(&description.sampler, description.film.resolution),
        moves,
        footprint_scale: footprint_scale(description.sampler.samples),
        samples: description.sampler.samples.max(1),
        stats,
    };
    (Some(Scene { data: Arc::new(data) }), diagnostics)
}

/// What the lanes of paths mean. Integrators whose result is no light compute in RGB: a share of the hemisphere or a normal has
/// no wavelength.
fn color_mode(description: &SceneDesc) -> ColorMode {
    match description.integrator {
        Integrator::Ao { .. } | Integrator::Normals => ColorMode::Rgb,
        Integrator::Path { .. } | Integrator::Whitted { .. } => description.color,
    }
}

/// Whether a surface moves while the shutter is open.
fn moves(world: &World) -> bool {
    let mesh_moves = |geometry: &Geometry| matches!(geometry, Geometry::MovingTriangles(_));
    let instance_moves = |instance: &Instance| matches!(instance.to_world, Placement::Moving(_));
    world.geometries.iter().any(mesh_moves) || world.instances.iter().any(instance_moves)
}

/// The side of the part of a pixel that one of `samples` stands for. Not less than an eighth: the finest levels of images are
/// seldom worth their aliasing (pbrt-v4's rule).
fn footprint_scale(samples: u32) -> f32 {
    (1.0 / (samples.max(1) as f32).sqrt()).max(0.125)
}

fn materials(description: &SceneDesc, textures: &Textures, diagnostics: &mut Diagnostics) -> Vec<Material> {
    let mut shared = SharedTables::default();
    description
        .materials
        .iter()
        .map(|(handle, material)| {
            Material::new(
                material,
                (description, textures),
                &mut shared,
                description.materials.origin(handle).span,
                diagnostics,
            )
        })
        .collect()
}

fn image_bytes(description: &SceneDesc) -> u64 {
    let bytes = |image: &Arc<sahl_image::Image>| match &image.pixels {
        sahl_image::Pixels::U8(values) => values.len(),
        sahl_image::Pixels::F32(values) => size_of_val(values.as_slice()),
    };
    description.images.values().iter().map(|image| bytes(image) as u64).sum()
}
