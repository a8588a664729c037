//! A scene without a file: values that refer to each other by handles.
//!
//! `cargo run --release -p sahl --example 02_build_a_scene_in_code`

use std::error::Error;

use sahl::image::{EncodeOptions, Format};
use sahl::math::Transform;
use sahl::scene::{
    Geometry, Light, Material, Origin, Projection, Radiance, SceneDesc, Shape, Spectrum, SpectrumParam,
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = SceneDesc::default();
    scene.film.resolution = [320, 240];
    scene.camera.projection = Projection::Perspective { fov: 40_f32.to_radians() };
    let world_to_camera = Transform::look_at([0.0, 1.5, -6.0], [0.0, 0.8, 0.0], [0.0, 1.0, 0.0]);
    scene.camera.camera_to_world = world_to_camera.ok_or("the camera looks along its own up")?.inverse();

    let sky = Spectrum::srgb([0.5, 0.7, 1.0]);
    let light = Light::Infinite {
        radiance: Radiance::Constant(sky),
        scale: 1.0,
        illuminance: None,
        light_to_world: Transform::IDENTITY,
        portal: None,
    };
    scene.lights.push(light, Origin::default());

    // Two balls on a third one, which is so big that it looks like the ground.
    for (rgb, radius, [x, y, z]) in [
        ([0.8, 0.3, 0.2], 1.0, [-1.1, 1.0, 0.0]),
        ([0.2, 0.5, 0.8], 0.7, [0.9, 0.7, -0.5]),
        ([0.6, 0.6, 0.5], 1000.0, [0.0, -1000.0, 0.0]),
    ] {
        let reflectance = SpectrumParam::Constant(Spectrum::srgb(rgb));
        let material = scene.materials.push(Material::Diffuse { reflectance }, Origin::default());
        let sphere =
            Geometry::Sphere { radius, z_min: -radius, z_max: radius, phi_max: std::f32::consts::TAU };
        let place = Transform::translate(x, y, z).ok_or("the place is not finite")?;
        let ball = Shape::new(sphere, place, material);
        let ball = scene.shapes.push(ball, Origin::default());
        scene.world.push(ball);
    }

    let image = sahl::develop(&sahl::render(&sahl::build(&scene)?));
    std::fs::write("02_build_a_scene_in_code.png", image.encode(Format::Png, &EncodeOptions::default())?)?;
    Ok(())
}
