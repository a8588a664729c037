//! Lab 3: the noise of a path tracer falls with the square root of the number of samples, or faster where samples are
//! well spread.
//!
//! Renders a small Cornell box with 4, 16, 64 and 256 samples a pixel and two seeds each. Two images with different
//! seeds differ by noise alone, so half their mean squared difference is the variance of one of them.
//!
//! `cargo run --release -p sahl --example 05_lab_path_tracing`
#![expect(clippy::print_stdout, reason = "an example shows what it found")]

use std::error::Error;
use std::time::Instant;

use sahl::image::{Image, metrics};
use sahl::scene::SceneDesc;

fn render(description: &mut SceneDesc, samples: u32, seed: u64) -> Result<Image, Box<dyn Error>> {
    description.sampler.samples = samples;
    description.sampler.seed = seed;
    Ok(sahl::develop(&sahl::render(&sahl::build(description)?)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut description = sahl::cornell_box().scene;
    description.film.resolution = [64, 64];

    println!("samples   noise (RMSE)   noise x sqrt(samples)   seconds");
    for samples in [4, 16, 64, 256] {
        let start = Instant::now();
        let first = render(&mut description, samples, 1)?;
        let second = render(&mut description, samples, 2)?;
        let noise = (metrics::mse(&first, &second)? / 2.0).sqrt();
        let seconds = start.elapsed().as_secs_f64() / 2.0;
        println!("{samples:7}   {noise:12.5}   {:21.4}   {seconds:7.3}", noise * f64::from(samples).sqrt());
    }
    Ok(())
}
