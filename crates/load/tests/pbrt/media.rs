//! Media, and the shapes that bound them.

use sahl_load::{MemoryAssets, load_pbrt};
use sahl_scene::{
    Coefficients, Diagnostics, Emission, Integrator, Material, Medium, MediumInterface, PathTracer,
    SceneDesc, Spectrum,
};

fn read(text: &str) -> (SceneDesc, Diagnostics) {
    let loaded = load_pbrt("test.pbrt", text.as_bytes().to_vec(), &MemoryAssets::default());
    (loaded.scene, loaded.diagnostics)
}

/// Reads a scene that must give no message.
fn silent(text: &str) -> SceneDesc {
    let (scene, diagnostics) = read(text);
    assert!(diagnostics.is_empty(), "{text}: {diagnostics:?}");
    scene
}

#[test]
fn only_the_integrators_of_pbrt_that_know_media_render_them() {
    for (name, expected) in [("path", false), ("volpath", true)] {
        let scene = silent(&format!("Integrator \"{name}\" \"integer maxdepth\" 7 WorldBegin"));
        let Integrator::Path(PathTracer { media, max_depth: 7, .. }) = scene.integrator else {
            panic!("{:?}", scene.integrator)
        };
        assert_eq!(media, expected, "{name}");
    }
    assert!(matches!(silent("WorldBegin").integrator, Integrator::Path(PathTracer { media: true, .. })));
}

#[test]
fn a_homogeneous_medium_has_coefficients_and_emission() {
    let scene = silent(
        r#"WorldBegin
        MakeNamedMedium "plain" "string type" "homogeneous"
        MakeNamedMedium "full" "string type" "homogeneous" "rgb sigma_a" [ 1 2 3 ] "spectrum sigma_s" [ 300 1 800 2 ]
            "float scale" 10 "float g" -.5 "rgb Le" [ 1 1 0 ] "float Lescale" 4
        MakeNamedMedium "milk" "string type" "homogeneous" "string preset" "Wholemilk" "float scale" 2"#,
    );
    let [plain, full, milk] = scene.media.values() else { panic!("{:?}", scene.media) };
    let one = Spectrum::Constant(1.0);
    let coefficients = Coefficients { sigma_a: one.clone(), sigma_s: one, scale: 1.0, g: 0.0 };
    assert_eq!(*plain, Medium::Homogeneous { coefficients, emission: None });
    let coefficients = Coefficients {
        sigma_a: Spectrum::srgb([1.0, 2.0, 3.0]),
        sigma_s: Spectrum::Sampled(vec![(300.0, 1.0), (800.0, 2.0)]),
        scale: 10.0,
        g: -0.5,
    };
    let emission = Some(Emission { radiance: Spectrum::srgb([1.0, 1.0, 0.0]), scale: 4.0 });
    assert_eq!(*full, Medium::Homogeneous { coefficients, emission });
    let coefficients = Coefficients {
        sigma_a: Spectrum::srgb([0.0011, 0.0024, 0.014]),
        sigma_s: Spectrum::srgb([2.55, 3.21, 3.77]),
        scale: 2.0,
        g: 0.0,
    };
    assert_eq!(*milk, Medium::Homogeneous { coefficients, emission: None });
}

#[test]
fn interfaces_hold_until_their_block_ends_and_names_may_come_later() {
    let scene = silent(
        r#"MediumInterface "" "air"
        Camera "perspective"
        WorldBegin
        AttributeBegin
            MediumInterface "milk" "air"
            Shape "sphere"
            Material "interface"
            MediumInterface "milk"
            Shape "sphere"
            MediumInterface "milk" ""
            Shape "sphere"
        AttributeEnd
        Shape "sphere"
        MakeNamedMedium "milk" "string type" "homogeneous" "float g" .1
        MakeNamedMedium "air" "string type" "homogeneous" "float g" .2"#,
    );
    let names = |medium| scene.media.origin(medium).name.as_deref();
    assert_eq!(scene.camera.medium.and_then(names), Some("air"));
    let sides = |interface: Option<MediumInterface>| {
        interface.map(|MediumInterface { inside, outside }| [inside.and_then(names), outside.and_then(names)])
    };
    let found: Vec<_> = scene.shapes.values().iter().map(|shape| sides(shape.media)).collect();
    let expected = [
        Some([Some("milk"), Some("air")]),
        // One name stands for both sides: nothing ends there.
        None,
        Some([Some("milk"), None]),
        Some([None, Some("air")]),
    ];
    assert_eq!(found, expected);
    let is_open =
        |index: usize| scene.materials[scene.shapes.values()[index].material] == Material::Interface;
    assert_eq!([0, 1, 2, 3].map(is_open), [false, true, true, false]);
    let Medium::Homogeneous { coefficients, .. } = &scene.media.values()[1];
    assert_eq!(coefficients.g, 0.1, "what was used before it was defined is filled in");
}

#[test]
fn an_unknown_preset_is_an_error_with_the_nearest_name() {
    let (_, diagnostics) = read(
        "WorldBegin MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"string preset\" \"Wholemlk\"",
    );
    let error = diagnostics.iter().next().unwrap();
    assert_eq!((error.code, error.help.as_deref()), ("unknown-preset", Some("did you mean `Wholemilk`?")));
    let (_, diagnostics) =
        read("WorldBegin MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"float g\" 1");
    assert!(diagnostics.has_errors());
}

#[test]
fn the_light_of_an_interface_is_dropped() {
    let (scene, diagnostics) =
        read("WorldBegin Material \"interface\" AreaLightSource \"diffuse\" Shape \"sphere\"");
    let codes: Vec<&str> = diagnostics.iter().map(|diagnostic| diagnostic.code).collect();
    assert_eq!(codes, ["dropped-light"]);
    assert_eq!(scene.shapes.values()[0].area_light, None);
}
