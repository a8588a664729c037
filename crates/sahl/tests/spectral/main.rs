//! The Cornell box in both modes of colour.
//!
//! Three numbers tell all of neutral reflectances, and of coloured ones under the white of the colour space: there both modes see the same
//! luminance. They do not tell what a coloured wall makes of a warm lamp's light, or of what another wall has coloured: a tile before the red
//! wall of the box is 4 % darker in spectral mode. That this is what the spectra make of it, and no error, is found without spectral
//! rendering: RGB mode renders the box as it is at three wavelengths at a time, whose values come from [`observer`].

mod observer;

use observer::Observer;
use sahl::image::{ColorSpace, Image};
use sahl::load::{MemoryAssets, load_pbrt};
use sahl::scene::{ColorMode, SamplerKind, SceneDesc};
use sahl_testkit::stats::{Running, per_test, welch};

/// Width of the image, and of the squares whose means are compared.
const SIZE: u32 = 32;
const TILE: usize = 8;

/// Independent renders in each mode.
const RENDERS: u64 = 24;

/// The lamp, and the walls as they are written in the files of the scene.
const LAMP: [f64; 3] = [47.8348, 38.5664, 31.0808];
const WALLS: [[f64; 3]; 3] = [[0.725, 0.71, 0.68], [0.63, 0.065, 0.05], [0.14, 0.45, 0.091]];

/// The mean of `value` over each tile, and last over the image.
fn means(image: &Image, value: impl Fn([f32; 3]) -> f32) -> Vec<f64> {
    let tiles = SIZE as usize / TILE;
    let mut sums = vec![0.0; tiles * tiles];
    for y in 0..image.height {
        for x in 0..image.width {
            let [r, g, b, _] = image.pixel(x, y);
            sums[y / TILE * tiles + x / TILE] += f64::from(value([r, g, b])) / (TILE * TILE) as f64;
        }
    }
    sums.push(sums.iter().sum::<f64>() / sums.len() as f64);
    sums
}

/// An image of the scene.
fn image(scene: &SceneDesc, color: ColorMode, seed: u64) -> Image {
    let mut scene = SceneDesc { color, ..scene.clone() };
    scene.film.resolution = [SIZE; 2];
    scene.sampler.kind = SamplerKind::Independent;
    scene.sampler.samples = 16;
    scene.sampler.seed = seed;
    let built = sahl::build(&scene).unwrap_or_else(|error| panic!("{error}"));
    sahl::develop(&sahl::render(&built))
}

/// Statistics of what `render` finds for some seeds.
fn over_seeds(seeds: std::ops::Range<u64>, render: impl Fn(u64) -> Vec<f64>) -> Vec<Running> {
    let mut all = Vec::new();
    for seed in seeds {
        let found = render(seed);
        all.resize(found.len(), Running::default());
        for (running, value) in all.iter_mut().zip(found) {
            running.add(value);
        }
    }
    all
}

/// Statistics of the luminance of each tile and of the image over independent renders.
fn luminances(scene: &SceneDesc, color: ColorMode) -> Vec<Running> {
    over_seeds(0..RENDERS, |seed| {
        let image = image(scene, color, seed);
        means(&image, |rgb| image.color_space.luminance(rgb))
    })
}

/// The box with other lines in its files.
fn changed(changes: &[(&str, &str)]) -> SceneDesc {
    let edit = |text: &str| {
        changes.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to)).into_bytes()
    };
    let mut assets = MemoryAssets::default();
    assets.insert(
        "cornell-box/room.pbrt",
        edit(include_str!("../../../../scenes/gallery/cornell-box/room.pbrt")),
    );
    let scene = edit(include_str!("../../../../scenes/gallery/cornell-box.pbrt"));
    let loaded = load_pbrt("cornell-box.pbrt", scene, &assets);
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
    let (new, old) = (format!("{:?}", loaded.scene), format!("{:?}", sahl::cornell_box().scene));
    assert!(new != old, "nothing was changed");
    loaded.scene
}

fn assert_alike(found: &[Running], expected: &[Running]) {
    let alpha = per_test(0.01, expected.len());
    for (tile, (a, b)) in found.iter().zip(expected).enumerate() {
        let p = welch(a, b);
        assert!(p >= alpha, "tile {tile}: {}, not {}, p = {p:.1e}", a.mean(), b.mean());
    }
}

fn assert_equally_bright(scene: &SceneDesc) {
    assert_alike(&luminances(scene, ColorMode::Spectral), &luminances(scene, ColorMode::Rgb));
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

/// A colour as it is written in a scene file.
fn written(rgb: [f64; 3]) -> String {
    format!("[ {} {} {} ]", rgb[0], rgb[1], rgb[2])
}

/// The luminance of the box by tile and over the image: its light at one wavelength after the other, three a render of RGB mode.
fn by_wavelength(observer: &Observer) -> Vec<Running> {
    const WAVELENGTHS: usize = 24;
    let lamp = observer.light(LAMP);
    let walls = WALLS.map(|wall| observer.reflectance(wall));
    let (luminance, wavelengths) = observer.quantiles(&lamp, WAVELENGTHS);
    let scenes: Vec<SceneDesc> = (0..WAVELENGTHS / 3)
        .map(|i| {
            let three = [0, 1, 2].map(|j| wavelengths[i + j * WAVELENGTHS / 3]);
            let mut changes = vec![(written(LAMP), written([1.0; 3]))];
            changes.extend(
                WALLS
                    .iter()
                    .zip(&walls)
                    .map(|(&wall, spectrum)| (written(wall), written(three.map(spectrum)))),
            );
            let changes: Vec<_> = changes.iter().map(|(from, to)| (from.as_str(), to.as_str())).collect();
            changed(&changes)
        })
        .collect();
    over_seeds(1000..1000 + RENDERS, |seed| {
        let mut sums = Vec::new();
        for scene in &scenes {
            let means = means(&image(scene, ColorMode::Rgb, seed), |[r, g, b]| (r + g + b) / 3.0);
            sums.resize(means.len(), 0.0);
            for (sum, mean) in sums.iter_mut().zip(means) {
                *sum += luminance * mean / scenes.len() as f64;
            }
        }
        sums
    })
}

#[test]
fn the_box_is_what_its_spectra_make_of_it() {
    let scene = sahl::cornell_box().scene;
    let spectral = luminances(&scene, ColorMode::Spectral);
    assert_alike(&spectral, &by_wavelength(&Observer::load()));
    // Three numbers tell the mean over the image as well as it can be told from this many samples.
    let rgb = luminances(&scene, ColorMode::Rgb);
    let (a, b) = (spectral.last().unwrap(), rgb.last().unwrap());
    assert!(welch(a, b) >= 0.01, "{} in spectral mode, {} in RGB", a.mean(), b.mean());
}

#[test]
fn what_a_red_wall_makes_of_the_lamp_is_darker_than_three_numbers_say() {
    // The walls that light has met, white, red and green, and its luminance over that of the product of colours.
    let expected: [(&[usize], f64); 7] = [
        (&[], 1.0),
        (&[0], 0.9994),
        (&[1], 0.9609),
        (&[2], 1.0057),
        (&[0, 1], 0.9561),
        (&[1, 1], 0.8207),
        (&[1, 2], 1.1590),
    ];
    let observer = Observer::load();
    let lamp = observer.light(LAMP);
    let walls = WALLS.map(|wall| observer.reflectance(wall));
    for (met, expected) in expected {
        let spectrum = |nm: f64| met.iter().fold(lamp(nm), |light, &wall| light * walls[wall](nm));
        let product = [0, 1, 2].map(|c| met.iter().fold(LAMP[c], |light, &wall| light * WALLS[wall][c]));
        let ratio = luminance(observer.color(spectrum)) / luminance(product);
        assert!((ratio - expected).abs() < 1e-4, "{met:?}: {ratio}");
    }
}

/// Y of a colour in linear sRGB.
fn luminance(rgb: [f64; 3]) -> f64 {
    let row = ColorSpace::Srgb.rgb_to_xyz_matrix()[1];
    (0..3).map(|c| row[c] * rgb[c]).sum()
}
