//! The Cornell box in both modes of colour.

use sahl::image::Image;
use sahl::scene::{ColorMode, SamplerKind, SceneDesc};
use sahl_testkit::stats::{Running, per_test, welch};

/// Width of the image, and of the squares whose means are compared.
const SIZE: u32 = 32;
const TILE: usize = 8;

/// Independent renders in each mode.
const RENDERS: u64 = 24;

/// The mean luminance of each tile.
fn luminances(image: &Image) -> Vec<f64> {
    let tiles = SIZE as usize / TILE;
    let mut sums = vec![0.0; tiles * tiles];
    for y in 0..image.height {
        for x in 0..image.width {
            let [r, g, b, _] = image.pixel(x, y);
            let luminance = image.color_space.luminance([r, g, b]);
            sums[y / TILE * tiles + x / TILE] += f64::from(luminance) / (TILE * TILE) as f64;
        }
    }
    sums
}

/// Statistics of each tile over independent renders.
fn tiles(scene: &SceneDesc, color: ColorMode) -> Vec<Running> {
    let mut scene = SceneDesc { color, ..scene.clone() };
    scene.film.resolution = [SIZE; 2];
    scene.sampler.kind = SamplerKind::Independent;
    scene.sampler.samples = 16;
    let mut tiles = vec![Running::default(); (SIZE as usize / TILE).pow(2)];
    for seed in 0..RENDERS {
        scene.sampler.seed = seed;
        let built = sahl::build(&scene).unwrap_or_else(|error| panic!("{error}"));
        let image = sahl::develop(&sahl::render(&built));
        for (tile, luminance) in tiles.iter_mut().zip(luminances(&image)) {
            tile.add(luminance);
        }
    }
    tiles
}

#[test]
fn both_modes_see_the_same_luminance_in_the_cornell_box() {
    let scene = sahl::cornell_box().scene;
    let (rgb, spectral) = (tiles(&scene, ColorMode::Rgb), tiles(&scene, ColorMode::Spectral));
    let alpha = per_test(0.01, rgb.len());
    for (tile, (a, b)) in rgb.iter().zip(&spectral).enumerate() {
        let p = welch(a, b);
        assert!(p >= alpha, "tile {tile}: {} in RGB, {} in spectral mode, p = {p:.1e}", a.mean(), b.mean());
    }
}
