//! OpenPBR surfaces, an addition to pbrt's materials.

use sahl_load::{MemoryAssets, load_pbrt};
use sahl_scene::{Diagnostics, FloatParam, Material, OpenPbr, SceneDesc, Spectrum, SpectrumParam};

fn read(parameters: &str) -> (SceneDesc, Diagnostics) {
    let text = format!("WorldBegin Material \"openpbr\" {parameters}");
    let loaded = load_pbrt("test.pbrt", text.into_bytes(), &MemoryAssets::default());
    (loaded.scene, loaded.diagnostics)
}

fn silent(parameters: &str) -> OpenPbr {
    let (scene, diagnostics) = read(parameters);
    assert!(diagnostics.is_empty(), "{parameters}: {diagnostics:?}");
    let [Material::OpenPbr(surface)] = scene.materials.values() else { panic!("{:?}", scene.materials) };
    (**surface).clone()
}

#[test]
fn parameters_have_the_names_and_defaults_of_the_specification() {
    assert_eq!(silent(""), OpenPbr::default());
    let number = FloatParam::Constant;
    for (name, default) in OpenPbr::default().numbers() {
        let found = silent(&format!("\"float {name}\" 0.25"));
        for (other, value) in found.numbers() {
            let expected = if other == name { Some(number(0.25)) } else { default_of(other) };
            assert_eq!(Some(value), expected, "{other} where {name} is given");
        }
        assert_ne!(default, number(0.25), "{name}");
    }
    let red = SpectrumParam::Constant(Spectrum::srgb([0.75, 0.25, 0.125]));
    for (name, _) in OpenPbr::default().colors() {
        let found = silent(&format!("\"rgb {name}\" [ 0.75 0.25 0.125 ]"));
        assert!(found.colors().iter().any(|(other, value)| *other == name && **value == red), "{name}");
    }
    assert!(silent("\"bool geometry_thin_walled\" true").geometry_thin_walled);
    let lamp = silent("\"float emission_luminance\" 40");
    assert!(lamp.emits() && lamp.emission_luminance == 40.0);
}

fn default_of(name: &str) -> Option<FloatParam> {
    OpenPbr::default().numbers().into_iter().find_map(|(other, value)| (other == name).then_some(value))
}

#[test]
fn what_is_unknown_is_reported_with_its_place() {
    for (parameters, name) in [
        ("\"float thin_film_wieght\" 1", "thin_film_wieght"),
        ("\"float transmission_depth\" 1", "transmission_depth"),
    ] {
        let (_, diagnostics) = read(parameters);
        let [found] = diagnostics.iter().collect::<Vec<_>>()[..] else { panic!("{diagnostics:?}") };
        assert!(found.message.contains(name) && found.span.is_some(), "{found:?}");
        assert!(!diagnostics.has_errors());
    }
}
