//! `sahl info`: what is in a scene.

use std::fmt::Write as _;
use std::process::ExitCode;

use sahl::image::Pixels;
use sahl::render::{BuildOptions, SceneStats};
use sahl::scene::{
    ColorMode, Filter, Geometry, Integrator, Light, Material, Medium, Origin, PathTracer, Projection,
    Radiance, SamplerKind, SceneDesc, SphereLayout, Texture,
};
use serde_json::{Value, json};

use crate::args::InfoArgs;
use crate::commands::print;
use crate::console::Console;
use crate::failure::Failure;
use crate::format;
use crate::source::Source;

/// Loads and builds the scene, and tells what it holds.
pub(crate) fn run(args: &InfoArgs, console: Console) -> Result<ExitCode, Failure> {
    let mut source = Source::load(&args.scenes)?;
    source.report(args.messages.strict, &console)?;
    let scene = source.build(&BuildOptions::default(), args.messages.strict, &console)?;
    let stats = scene.stats();
    if args.json {
        print(&format!("{:#}\n", json(&source, &stats)))?;
    } else {
        print(&text(&source, &stats))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Names with how often they occur, in the order of first occurrence.
#[derive(Default)]
struct Tally(Vec<(&'static str, usize)>);

impl Tally {
    fn of(names: impl IntoIterator<Item = &'static str>) -> Self {
        let mut tally = Self::default();
        for name in names {
            match tally.0.iter_mut().find(|(known, _)| *known == name) {
                Some((_, count)) => *count += 1,
                None => tally.0.push((name, 1)),
            }
        }
        tally
    }

    fn total(&self) -> usize {
        self.0.iter().map(|(_, count)| count).sum()
    }

    /// `5 (diffuse 4, conductor 1)`.
    fn text(&self) -> String {
        let parts: Vec<_> = self.0.iter().map(|(name, count)| format!("{name} {count}")).collect();
        if parts.is_empty() { "none".to_owned() } else { format!("{} ({})", self.total(), parts.join(", ")) }
    }

    fn json(&self) -> Value {
        Value::Object(self.0.iter().map(|&(name, count)| (name.to_owned(), json!(count))).collect())
    }
}

fn materials(scene: &SceneDesc) -> Tally {
    Tally::of(scene.materials.values().iter().map(|material| match material {
        Material::Diffuse { .. } => "diffuse",
        Material::Conductor { .. } => "conductor",
        Material::Dielectric { .. } => "dielectric",
        Material::ThinDielectric { .. } => "thin dielectric",
        Material::DiffuseTransmission { .. } => "diffuse transmission",
        Material::CoatedDiffuse { .. } => "coated diffuse",
        Material::CoatedConductor { .. } => "coated conductor",
        Material::Hair(_) => "hair",
        Material::OpenPbr(_) => "OpenPBR",
        Material::Subsurface(_) => "subsurface",
        Material::Measured(_) => "measured",
        Material::Mix { .. } => "mix",
        Material::Relief { .. } => "relief",
        Material::Interface => "interface",
    }))
}

fn textures(scene: &SceneDesc) -> Tally {
    Tally::of(scene.textures.values().iter().map(|texture| match texture {
        Texture::Constant(_) => "constant",
        Texture::Scale { .. } => "scale",
        Texture::Mix { .. } => "mix",
        Texture::DirectionMix { .. } => "directionmix",
        Texture::Bilerp { .. } => "bilerp",
        Texture::Checkerboard { .. } | Texture::SolidCheckerboard { .. } => "checkerboard",
        Texture::Dots { .. } => "dots",
        Texture::Fbm(_) => "fbm",
        Texture::Wrinkled(_) => "wrinkled",
        Texture::Windy { .. } => "windy",
        Texture::Marble { .. } => "marble",
        Texture::Image(_) => "image",
        Texture::Faces(_) => "faces",
    }))
}

fn media(scene: &SceneDesc) -> Tally {
    Tally::of(scene.media.values().iter().map(|medium| match medium {
        Medium::Homogeneous { .. } => "homogeneous",
        Medium::Grid(_) => "grid",
        Medium::RgbGrid(_) => "grid of colours",
        Medium::Cloud(_) => "cloud",
        Medium::Sparse(_) => "sparse grid",
    }))
}

fn lights(scene: &SceneDesc) -> Tally {
    let shapes =
        scene.shapes.values().iter().filter(|shape| shape.area_light.is_some()).map(|_| "emitting shape");
    let others = scene.lights.values().iter().map(|light| match light {
        Light::Point { .. } => "point",
        Light::Spot { .. } => "spot",
        Light::Goniometric { .. } => "goniometric",
        Light::Projection { .. } => "projection",
        Light::Distant { .. } => "distant",
        Light::Infinite { portal: Some(_), .. } => "infinite through a portal",
        Light::Infinite { radiance: Radiance::Constant(_), .. } => "infinite constant",
        Light::Infinite { .. } => "infinite image",
    });
    Tally::of(shapes.chain(others))
}

fn shapes(scene: &SceneDesc) -> Tally {
    Tally::of(scene.shapes.values().iter().map(|shape| match shape.geometry {
        Geometry::Triangles(_) => "triangle mesh",
        Geometry::Patches(_) => "patch mesh",
        Geometry::Sphere { .. } => "sphere",
        Geometry::Disk { .. } => "disk",
        Geometry::Cylinder { .. } => "cylinder",
        Geometry::Curves(_) => "curve",
        Geometry::Displaced { .. } => "displaced mesh",
    }))
}

fn integrator(scene: &SceneDesc) -> String {
    match scene.integrator {
        Integrator::Path(PathTracer { max_depth, .. }) => {
            format!("path, {} at most", format::plural(max_depth as usize, "bounce"))
        }
        Integrator::Whitted { max_depth } => {
            format!("whitted, {} at most", format::plural(max_depth as usize, "reflection"))
        }
        Integrator::Ao { max_distance } => format!("ambient occlusion within {max_distance}"),
        Integrator::Normals => "normals".to_owned(),
    }
}

fn color(scene: &SceneDesc) -> &'static str {
    match scene.color {
        ColorMode::Rgb => "rgb",
        ColorMode::Spectral => "spectral",
    }
}

fn camera(scene: &SceneDesc) -> String {
    let projection = match &scene.camera.projection {
        Projection::Perspective { fov } => format!("perspective, {} degrees", rounded(fov.to_degrees())),
        Projection::Orthographic => "orthographic".to_owned(),
        Projection::Spherical(SphereLayout::EqualArea) => "spherical, equal-area".to_owned(),
        Projection::Spherical(SphereLayout::Equirectangular) => "spherical, equirectangular".to_owned(),
        Projection::Realistic(lens) => format!(
            "{}, aperture of {} mm, focus at {}",
            format::plural(lens.elements.len(), "lens element"),
            rounded(lens.aperture_diameter * 1000.0),
            lens.focus_distance
        ),
    };
    let place = scene.camera.camera_to_world.point(sahl::math::Vec3::ZERO);
    let lens = match scene.camera.lens_radius {
        0.0 => String::new(),
        radius => format!(", lens radius {radius}, focus at {}", scene.camera.focal_distance),
    };
    format!("{projection}, at ({}, {}, {}){lens}", rounded(place.x), rounded(place.y), rounded(place.z))
}

/// To four digits after the point, which hides the rounding of transforms.
fn rounded(x: f32) -> f64 {
    (f64::from(x) * 1e4).round() / 1e4
}

fn sampling(scene: &SceneDesc) -> String {
    let kind = match scene.sampler.kind {
        SamplerKind::Sobol => "Sobol'",
        SamplerKind::Independent => "independent",
    };
    let filter = match scene.filter {
        Filter::Box { .. } => "box",
        Filter::Triangle { .. } => "triangle",
        Filter::Gaussian { .. } => "gaussian",
        Filter::Mitchell { .. } => "mitchell",
        Filter::Sinc { .. } => "sinc",
    };
    let samples = format::plural(scene.sampler.samples as usize, "sample");
    format!("{samples} a pixel, {kind}, seed {}, {filter} filter", scene.sampler.seed)
}

/// An image file with its size.
struct Picture {
    name: String,
    size: [usize; 3],
    bytes: usize,
}

fn pictures(scene: &SceneDesc) -> Vec<Picture> {
    let picture = |(handle, image): (_, &std::sync::Arc<sahl::image::Image>)| {
        let Origin { name, .. } = scene.images.origin(handle);
        let bytes = match &image.pixels {
            Pixels::U8(values) => values.len(),
            Pixels::F32(values) => values.len() * size_of::<f32>(),
        };
        let name = name.clone().unwrap_or_else(|| "unnamed".to_owned());
        Picture { name, size: [image.width, image.height, image.channels], bytes }
    };
    scene.images.iter().map(picture).collect()
}

fn text(source: &Source, stats: &SceneStats) -> String {
    let scene = &source.loaded.scene;
    let [width, height] = scene.film.resolution;
    let crop =
        scene.film.crop.map_or_else(String::new, |[x0, x1, y0, y1]| format!(", crop {x0},{x1},{y0},{y1}"));
    let tree = &stats.accel;
    let mut lines = vec![
        ("scene", source.name.clone()),
        ("image", format!("{width}x{height}{crop}")),
        ("sampling", sampling(scene)),
        ("camera", camera(scene)),
        ("integrator", integrator(scene)),
        ("colour", color(scene).to_owned()),
        ("shapes", shapes(scene).text()),
        (
            "primitives",
            format!(
                "{} triangles, {} patches, {} quadrics, {} curves",
                stats.triangles, stats.patches, stats.quadrics, stats.curves
            ),
        ),
        ("instances", format!("{} of {}", stats.instances, format::plural(scene.objects.len(), "object"))),
        ("materials", materials(scene).text()),
        ("textures", textures(scene).text()),
        ("media", media(scene).text()),
        ("lights", lights(scene).text()),
        (
            "tree",
            format!(
                "{} nodes, {} leaves, depth {}, SAH cost {:.1}, {}",
                tree.nodes,
                tree.leaves,
                tree.depth,
                tree.sah_cost,
                format::bytes(tree.bytes)
            ),
        ),
        ("memory", format!("{} of vertices and images", format::bytes(stats.data_bytes))),
        ("scene files", source.loaded.sources.files().len().to_string()),
        ("warnings", source.warnings.to_string()),
    ];
    for picture in pictures(scene) {
        let [width, height, channels] = picture.size;
        let size = format::bytes(picture.bytes as u64);
        lines.push((
            "texture file",
            format!("{}, {width}x{height}, {channels} channels, {size}", picture.name),
        ));
    }
    let mut text = String::new();
    for (label, value) in lines {
        let _ = writeln!(text, "{label:12}  {value}");
    }
    text
}

fn json(source: &Source, stats: &SceneStats) -> Value {
    let scene = &source.loaded.scene;
    let tree = &stats.accel;
    let images: Vec<_> = pictures(scene)
        .iter()
        .map(|picture| {
            let [width, height, channels] = picture.size;
            json!({ "name": picture.name, "width": width, "height": height, "channels": channels, "bytes": picture.bytes })
        })
        .collect();
    json!({
        "scene": source.name,
        "resolution": scene.film.resolution,
        "crop": scene.film.crop,
        "spp": scene.sampler.samples,
        "seed": scene.sampler.seed,
        "camera": camera(scene),
        "integrator": integrator(scene),
        "color": color(scene),
        "shapes": shapes(scene).json(),
        "primitives": { "triangles": stats.triangles, "patches": stats.patches, "quadrics": stats.quadrics, "curves": stats.curves },
        "objects": scene.objects.len(),
        "instances": stats.instances,
        "materials": materials(scene).json(),
        "textures": textures(scene).json(),
        "media": media(scene).json(),
        "lights": lights(scene).json(),
        "images": images,
        "tree": {
            "nodes": tree.nodes,
            "leaves": tree.leaves,
            "depth": tree.depth,
            "sah_cost": tree.sah_cost,
            "bytes": tree.bytes,
            "dropped": tree.dropped,
        },
        "data_bytes": stats.data_bytes,
        "scene_files": source.loaded.sources.files().iter().map(|file| file.name.clone()).collect::<Vec<_>>(),
        "warnings": source.warnings,
    })
}
