//! The ways to say how light spreads.

use sahl_load::{MemoryAssets, load_pbrt};
use sahl_scene::{
    Diagnostics, FloatParam, Material, SceneDesc, Spectrum, SpectrumParam, Subsurface, SubsurfaceScattering,
};

fn read(parameters: &str) -> (SceneDesc, Diagnostics) {
    let text = format!("WorldBegin Material \"subsurface\" {parameters}");
    let loaded = load_pbrt("test.pbrt", text.into_bytes(), &MemoryAssets::default());
    (loaded.scene, loaded.diagnostics)
}

fn silent(parameters: &str) -> Subsurface {
    let (scene, diagnostics) = read(parameters);
    assert!(diagnostics.is_empty(), "{parameters}: {diagnostics:?}");
    let [Material::Subsurface(subsurface)] = scene.materials.values() else {
        panic!("{:?}", scene.materials)
    };
    (**subsurface).clone()
}

fn message(parameters: &str) -> String {
    let (_, diagnostics) = read(parameters);
    let messages: Vec<&str> = diagnostics.iter().map(|entry| entry.message.as_str()).collect();
    assert_eq!(messages.len(), 1, "{parameters}: {messages:?}");
    messages[0].to_owned()
}

fn rgb(rgb: [f32; 3]) -> SpectrumParam {
    SpectrumParam::Constant(Spectrum::srgb(rgb))
}

#[test]
fn light_spreads_by_name_by_coefficients_by_colour_or_as_in_milk() {
    let milk = silent("");
    let (sigma_a, sigma_s) = (rgb([0.0011, 0.0024, 0.014]), rgb([2.55, 3.21, 3.77]));
    assert_eq!(milk.scattering, SubsurfaceScattering::Coefficients { sigma_a, sigma_s, scale: 1.0 });
    assert_eq!((milk.eta, milk.g), (1.33, 0.0));
    let named =
        silent("\"string name\" \"Wholemilk\" \"float scale\" 10 \"float eta\" 1.5 \"float roughness\" .2");
    let (sigma_a, sigma_s) = (rgb([0.0011, 0.0024, 0.014]), rgb([2.55, 3.21, 3.77]));
    assert_eq!(named.scattering, SubsurfaceScattering::Coefficients { sigma_a, sigma_s, scale: 10.0 });
    assert_eq!((named.eta, named.roughness.u), (1.5, FloatParam::Constant(0.2)));
    let given = silent("\"rgb sigma_a\" [ 1 2 3 ] \"rgb sigma_s\" [ 4 5 6 ] \"float g\" .5");
    let (sigma_a, sigma_s) = (rgb([1.0, 2.0, 3.0]), rgb([4.0, 5.0, 6.0]));
    assert_eq!(given.scattering, SubsurfaceScattering::Coefficients { sigma_a, sigma_s, scale: 1.0 });
    assert_eq!(given.g, 0.5);
    let colored = silent("\"rgb reflectance\" [ .5 .1 .1 ] \"rgb mfp\" [ 1 2 3 ]");
    let (reflectance, mean_free_path) = (rgb([0.5, 0.1, 0.1]), rgb([1.0, 2.0, 3.0]));
    assert_eq!(
        colored.scattering,
        SubsurfaceScattering::Reflectance { reflectance, mean_free_path, scale: 1.0 }
    );
}

#[test]
fn contradictions_are_told() {
    assert!(
        message("\"string name\" \"Wholemlk\"").contains("there are no measured coefficients of `Wholemlk`")
    );
    assert!(message("\"rgb sigma_a\" [ 1 2 3 ]").contains("needs `sigma_s` beside it"));
    assert!(message("\"rgb sigma_s\" [ 1 2 3 ]").contains("needs `sigma_a` beside it"));
    assert!(message("\"string name\" \"Skin1\" \"float g\" .3").contains("for which it is 0"));
    assert!(message("\"string name\" \"Skin1\" \"rgb mfp\" [ 1 1 1 ]").contains("`mfp`"));
    assert!(message("\"float g\" 1").contains("greater than -1 and less than 1"));
}
