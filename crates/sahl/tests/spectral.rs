//! The Cornell box in both modes of colour.
//!
//! Three numbers tell all of neutral reflectances, and of coloured ones under the white of the colour space: there both modes see the same
//! luminance. They do not tell what a coloured wall makes of a warm lamp's light, or of what another wall has coloured: in the box as it
//! is, the luminance of a tile before the red wall is 4 % lower in spectral mode.

use sahl::image::Image;
use sahl::load::{MemoryAssets, load_pbrt};
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

/// The box with other lines in its files.
fn changed(changes: &[(&str, &str)]) -> SceneDesc {
    let edit = |text: &str| {
        changes.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to)).into_bytes()
    };
    let mut assets = MemoryAssets::default();
    assets
        .insert("cornell-box/room.pbrt", edit(include_str!("../../../scenes/gallery/cornell-box/room.pbrt")));
    let scene = edit(include_str!("../../../scenes/gallery/cornell-box.pbrt"));
    let loaded = load_pbrt("cornell-box.pbrt", scene, &assets);
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
    let (new, old) = (format!("{:?}", loaded.scene), format!("{:?}", sahl::cornell_box().scene));
    assert!(new != old, "nothing was changed");
    loaded.scene
}

fn assert_equally_bright(scene: &SceneDesc) {
    let (rgb, spectral) = (tiles(scene, ColorMode::Rgb), tiles(scene, ColorMode::Spectral));
    let alpha = per_test(0.01, rgb.len());
    for (tile, (a, b)) in rgb.iter().zip(&spectral).enumerate() {
        let p = welch(a, b);
        assert!(p >= alpha, "tile {tile}: {} in RGB, {} in spectral mode, p = {p:.1e}", a.mean(), b.mean());
    }
}

#[test]
fn neutral_walls_are_equally_bright_in_both_modes() {
    let neutral = [
        ("[ 0.725 0.71 0.68 ]", "[ 0.7 0.7 0.7 ]"),
        ("[ 0.63 0.065 0.05 ]", "[ 0.3 0.3 0.3 ]"),
        ("[ 0.14 0.45 0.091 ]", "[ 0.5 0.5 0.5 ]"),
    ];
    assert_equally_bright(&changed(&neutral));
}

#[test]
fn coloured_walls_under_white_light_are_equally_bright_in_both_modes() {
    let direct = [
        ("[ 47.8348 38.5664 31.0808 ]", "[ 40 40 40 ]"),
        ("\"integer maxdepth\" 8", "\"integer maxdepth\" 1"),
    ];
    assert_equally_bright(&changed(&direct));
}
