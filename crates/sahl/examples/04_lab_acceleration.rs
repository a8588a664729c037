//! Lab 2: what a tree saves, and what a better tree saves on top.
//!
//! Sends the rays of a small picture through a plain list, a median tree and a SAH tree of the same triangles, and
//! counts steps: nodes visited and primitives tested.
//!
//! `cargo run --release -p sahl --example 04_lab_acceleration`
#![expect(clippy::print_stdout, reason = "an example shows what it found")]

use std::error::Error;
use std::time::Instant;

use sahl::math::Vec2;
use sahl::render::accel::{self, Builder, TraversalCount};
use sahl::render::{BuildOptions, build};

const LABS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/labs");

fn main() -> Result<(), Box<dyn Error>> {
    for name in ["even", "uneven"] {
        let mut description = sahl::load(format!("{LABS}/2-acceleration-{name}.pbrt"))?.scene;
        description.film.resolution = [32, 32];
        println!("{name}        nodes/ray   primitives/ray   seconds");
        for builder in [Builder::BruteForce, Builder::Median, Builder::BinnedSah] {
            let accel = accel::BuildOptions { builder, ..accel::BuildOptions::default() };
            let (scene, _) = build(&description, &BuildOptions { accel });
            let scene = scene.ok_or("the scene can't be built")?;
            let mut count = TraversalCount::default();
            let start = Instant::now();
            for pixel in 0..32 * 32 {
                let ray = scene.camera_ray(Vec2::new((pixel % 32) as f32 + 0.5, (pixel / 32) as f32 + 0.5));
                scene.accel().intersect_counted(&ray, &mut count);
            }
            let seconds = start.elapsed().as_secs_f64();
            let a_ray = |steps: u64| steps as f64 / f64::from(32 * 32);
            let (nodes, primitives) = (a_ray(count.nodes), a_ray(count.primitives));
            println!("{:12} {nodes:9.2}   {primitives:14.2}   {seconds:7.4}", format!("{builder:?}"));
        }
    }
    Ok(())
}
