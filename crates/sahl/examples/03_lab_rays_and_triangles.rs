//! Lab 1: camera rays against triangles, and a picture with Whitted's shading.
//!
//! First a square of two triangles is hit along the edge that they share: the textbook test of Möller and Trumbore
//! loses rays there, the watertight test of Woop, Benthin and Wald loses none. Then the lab's scene is rendered.
//!
//! `cargo run --release -p sahl --example 03_lab_rays_and_triangles`
#![expect(clippy::print_stdout, reason = "an example shows what it found")]

use std::error::Error;

use sahl::image::{EncodeOptions, Format};
use sahl::math::{Ray, Vec3};
use sahl::render::accel::triangle;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/labs/1-rays-and-triangles.pbrt");

fn main() -> Result<(), Box<dyn Error>> {
    let corner = |x, y| Vec3::new(x, y, -7.0 - 0.3 * x + 0.2 * y);
    let (a, b, c, d) = (corner(-1.3, -1.1), corner(1.7, -0.9), corner(1.9, 1.4), corner(-1.2, 1.6));
    let square = [[a, b, c], [a, c, d]];

    let rays = 100_000;
    let (mut textbook, mut watertight) = (0, 0);
    for i in 0..rays {
        // A pinhole camera at the origin: the ray's direction is the point that it looks at.
        let target = a + (c - a) * ((i as f32 + 0.5) / rays as f32);
        let ray = Ray::new(Vec3::ZERO, target);
        textbook +=
            usize::from(square.iter().all(|corners| triangle::moller_trumbore(&ray, *corners).is_none()));
        watertight += usize::from(square.iter().all(|corners| triangle::intersect(&ray, *corners).is_none()));
    }
    println!("rays through the shared edge: {rays}");
    println!("lost by Möller and Trumbore:  {textbook}");
    println!("lost by the watertight test:  {watertight}");

    let mut description = sahl::load(SCENE)?.scene;
    description.film.resolution = [640, 480];
    let image = sahl::develop(&sahl::render(&sahl::build(&description)?));
    std::fs::write("03_lab_rays_and_triangles.png", image.encode(Format::Png, &EncodeOptions::default())?)?;
    Ok(())
}
