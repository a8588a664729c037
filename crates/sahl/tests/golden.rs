//! Renders of `scenes/tests/golden` against their references: by z-test where there is noise, by value where not.

use std::path::{Path, PathBuf};

use sahl::image::{Image, Pixels};
use sahl::render::{Aov, BuildOptions, Film, RenderOptions};
use sahl::scene::{ColorMode, SamplerKind, SceneDesc};
use sahl_testkit::golden::{BLESS, Golden, Tolerance};
use sahl_testkit::ztest::ImageTest;

const SCENES: [&str; 5] =
    ["ambient-occlusion", "diffuse-box", "lights-and-shapes", "metals-and-glass", "whitted"];

/// Samples a pixel of a render that is judged.
const SAMPLES: u32 = 256;

/// Samples a pixel of a reference.
const REFERENCE_SAMPLES: u32 = 8192;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/tests/golden")
}

/// The references are of RGB mode.
fn scene(name: &str) -> SceneDesc {
    let path = folder().join(format!("{name}.pbrt"));
    let scene = sahl::load(path).unwrap_or_else(|error| panic!("{error}")).scene;
    SceneDesc { color: ColorMode::Rgb, ..scene }
}

fn render(description: &SceneDesc, aovs: Vec<Aov>) -> Film {
    let (scene, diagnostics) = sahl::render::build(description, &BuildOptions::default());
    let scene = scene.unwrap_or_else(|| panic!("{diagnostics:?}"));
    sahl::render::render(&scene, &RenderOptions { aovs, ..RenderOptions::default() }, &()).film
}

/// The variance that a render of [`SAMPLES`] is expected to have, from that of the reference.
///
/// Its own estimate would be zero in a pixel whose rare bright samples it has not met.
#[expect(clippy::unwrap_used, reason = "clippy's exception for tests ends at helper functions")]
fn expected_variance(name: &str) -> Image {
    let path = folder().join(format!("{name}.var.exr"));
    let mut image = sahl::image::read(&std::fs::read(path).unwrap(), name).unwrap();
    if let Pixels::F32(values) = &mut image.pixels {
        let factor = REFERENCE_SAMPLES as f32 / SAMPLES as f32;
        values.iter_mut().for_each(|value| *value *= factor);
    }
    image
}

/// References are made of independent samples with a seed of their own.
fn check_all(kind: SamplerKind) {
    let blessing = std::env::var_os(BLESS).is_some();
    let test = ImageTest { samples: REFERENCE_SAMPLES, tests: 2 * SCENES.len(), ..ImageTest::default() };
    let golden = Golden { test, ..Golden::default() };
    let failures: Vec<String> = SCENES
        .iter()
        .filter_map(|name| {
            let mut description = scene(name);
            description.sampler.kind = kind;
            (description.sampler.samples, description.sampler.seed) =
                if blessing { (REFERENCE_SAMPLES, 1) } else { (SAMPLES, 2) };
            let film = render(&description, Vec::new());
            let variance = if blessing { film.variance() } else { expected_variance(name) };
            golden.check(name, &folder(), &film.develop(), &variance).err()
        })
        .map(|failure| failure.to_string())
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn independent_samples_agree_with_the_references() {
    check_all(SamplerKind::Independent);
}

#[test]
fn sobol_samples_agree_with_the_references() {
    // The references come from independent samples alone.
    if std::env::var_os(BLESS).is_none() {
        check_all(SamplerKind::Sobol);
    }
}

#[test]
fn features_of_the_first_surface_are_exact() {
    let mut description = scene("diffuse-box");
    description.sampler.samples = 1;
    let features = [
        ("albedo", Aov::Albedo),
        ("normal", Aov::Normal),
        ("geometric-normal", Aov::GeometricNormal),
        ("depth", Aov::Depth),
        ("position", Aov::Position),
        ("uv", Aov::Uv),
    ];
    let film = render(&description, features.map(|(_, aov)| aov).to_vec());
    let layers = film.layers();
    assert_eq!(layers.len(), 1 + features.len());
    // Pixels on an edge may see the other side of it where arithmetic differs between processors.
    let tolerance = Tolerance { outliers: 0.005, ..Tolerance::default() };
    let failures: Vec<String> = (features.iter().zip(&layers[1..]))
        .filter_map(|((feature, _), layer)| {
            let name = format!("diffuse-box.{feature}");
            Golden::default().check_exact(&name, &folder(), &layer.image, tolerance).err()
        })
        .map(|failure| failure.to_string())
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
