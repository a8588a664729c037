//! The scenes of the labs: that they load, that their meshes are what their program makes, and that lab 1 has no speckle.

#[path = "../examples/make_lab_meshes/shapes.rs"]
mod shapes;

use std::path::{Path, PathBuf};

use sahl::image::Image;
use sahl::math::Vec2;
use sahl::render::Scene;
use sahl::scene::{ColorMode, Light, Material, SceneDesc, Spectrum, SpectrumParam};

fn lab(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/labs").join(name)
}

fn load(name: &str) -> SceneDesc {
    let loaded = sahl::load(lab(name)).unwrap_or_else(|error| panic!("{error}"));
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics.render_text(&loaded.sources, false));
    loaded.scene
}

#[test]
fn every_lab_and_the_built_in_scene_load_without_a_warning() {
    for name in [
        "1-rays-and-triangles.pbrt",
        "2-acceleration-even.pbrt",
        "2-acceleration-uneven.pbrt",
        "3-path-tracing.pbrt",
    ] {
        let scene = load(name);
        assert!(sahl::build(&scene).is_ok(), "{name}");
    }
    let cornell_box = sahl::cornell_box();
    assert!(cornell_box.diagnostics.is_empty());
    assert!(sahl::build(&cornell_box.scene).is_ok());
}

#[test]
fn the_meshes_are_what_their_program_makes() {
    for (name, expected) in [
        ("meshes/bumpy-sphere.ply.gz", shapes::bumpy_sphere(6)),
        ("meshes/stadium.ply.gz", shapes::stadium()),
    ] {
        let scene = load(name);
        let mesh = &scene.triangle_meshes.values()[0];
        assert!(mesh.indices[..] == expected.indices[..], "{name}: indices");
        assert!(mesh.positions[..] == expected.positions[..], "{name}: positions");
    }
}

/// Lab 1 in RGB, without what is seen behind it, whose light would be noise in the shadows, and with a floor of one colour.
fn lab_without_noise() -> SceneDesc {
    let mut scene = load("1-rays-and-triangles.pbrt");
    let mut lights = sahl::scene::Arena::default();
    for (handle, light) in scene.lights.iter() {
        if !matches!(light, Light::Infinite { .. }) {
            lights.push(light.clone(), scene.lights.origin(handle).clone());
        }
    }
    scene.lights = lights;
    for shape in scene.world.clone() {
        let material = scene.shapes[shape].material;
        if let Material::Diffuse { reflectance: reflectance @ SpectrumParam::Texture(_) } =
            &mut scene.materials[material]
        {
            *reflectance = SpectrumParam::Constant(Spectrum::Constant(0.5));
        }
    }
    scene.film.resolution = [640, 480];
    scene.sampler.samples = 1;
    scene.color = ColorMode::Rgb;
    scene
}

/// Pixels that differ by more than a twentieth from neighbours that agree among themselves.
fn speckles(image: &Image, is_judged: impl Fn(u32, u32) -> bool) -> Vec<[usize; 2]> {
    let value = |x: usize, y: usize| image.pixel(x, y)[1];
    let differ = |a: f32, b: f32| (a - b).abs() > 0.05 * a.max(b);
    let mut found = Vec::new();
    for y in 1..image.height - 1 {
        for x in 1..image.width - 1 {
            let around = [(0, 0), (1, 0), (2, 0), (0, 1), (2, 1), (0, 2), (1, 2), (2, 2)];
            let neighbours = around.map(|(dx, dy)| value(x + dx - 1, y + dy - 1));
            let agree = neighbours.iter().all(|&neighbour| !differ(neighbour, neighbours[0]));
            if agree && differ(value(x, y), neighbours[0]) && is_judged(x as u32, y as u32) {
                found.push([x, y]);
            }
        }
    }
    found
}

/// Whether the pixel shows a diffuse surface: glass shows far things small, down to less than a pixel.
fn shows_diffuse(scene: &Scene, diffuse: &[bool], x: u32, y: u32) -> bool {
    let ray = scene.camera_ray(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
    let hit = scene.accel().intersect(&ray);
    hit.is_some_and(|hit| diffuse[hit.geometry as usize])
}

#[test]
fn no_isolated_pixel_in_lab_1() {
    let description = lab_without_noise();
    let diffuse: Vec<bool> = description
        .shapes
        .values()
        .iter()
        .map(|shape| matches!(description.materials[shape.material], Material::Diffuse { .. }))
        .collect();
    let scene = sahl::build(&description).unwrap();
    let mut image = sahl::develop(&sahl::render(&scene));
    let judged = |x, y| shows_diffuse(&scene, &diffuse, x, y);
    assert_eq!(speckles(&image, judged), Vec::<[usize; 2]>::new());

    // Both the lit and the shadowed floor are there to be judged.
    let floor: Vec<f32> = (0..640).map(|x| image.pixel(x, 330)[1]).filter(|value| *value > 0.0).collect();
    let brightest = floor.iter().fold(0.0_f32, |most, &value| most.max(value));
    assert!(floor.iter().any(|&value| value < 0.7 * brightest), "no shadow crosses row 330");

    // The detector finds a wrong pixel where there is one.
    let (x, y) = (0..640).map(|x| (x, 330)).find(|&(x, y)| judged(x, y)).unwrap();
    let at = image.index(x as usize + 20, y as usize);
    let sahl::image::Pixels::F32(values) = &mut image.pixels else { panic!("films develop to floats") };
    values[at..at + 3].fill(0.0);
    assert_eq!(speckles(&image, judged), [[x as usize + 20, y as usize]]);
}
