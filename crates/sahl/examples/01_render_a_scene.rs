//! Four calls from a scene to a picture: load, build, render, develop.
//!
//! `cargo run --release -p sahl --example 01_render_a_scene [SCENE] [PICTURE]`
#![expect(clippy::print_stdout, reason = "an example shows what it found")]

use std::error::Error;

use sahl::image::{EncodeOptions, Format};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let loaded = match arguments.next() {
        Some(path) => sahl::load(path)?,
        None => sahl::cornell_box(),
    };
    let picture = arguments.next().unwrap_or_else(|| "01_render_a_scene.png".to_owned());

    // The description is plain data: change what you like before it is built.
    let mut description = loaded.scene;
    description.film.resolution = [256, 256];
    description.sampler.samples = 16;

    let scene = sahl::build(&description)?;
    let film = sahl::render(&scene);
    let image = sahl::develop(&film);

    std::fs::write(&picture, image.encode(Format::Png, &EncodeOptions::default())?)?;
    println!("{picture}: {} x {} pixels", image.width, image.height);
    Ok(())
}
