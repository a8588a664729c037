//! What Sahl lacks is told, with what is used instead: never silence, and never an error.

use sahl_load::{MemoryAssets, load_pbrt};
use sahl_scene::{
    Diagnostics, Film, Filter, Integrator, Light, LightSampler, Material, PathTracer, SceneDesc, Spectrum,
    SpectrumParam,
};

fn read(text: &str) -> (SceneDesc, Diagnostics) {
    let loaded = load_pbrt("test.pbrt", text.as_bytes().to_vec(), &MemoryAssets::default());
    (loaded.scene, loaded.diagnostics)
}

/// Reads a scene whose only message must be one warning that contains `expected`.
fn warned(text: &str, expected: &str) -> SceneDesc {
    let (scene, diagnostics) = read(text);
    assert!(!diagnostics.has_errors(), "{text}: {diagnostics:?}");
    let messages: Vec<&str> = diagnostics.iter().map(|entry| entry.message.as_str()).collect();
    assert_eq!(messages.len(), 1, "{text}: {messages:?}");
    assert!(messages[0].contains(expected), "{text}: {messages:?}");
    assert!(diagnostics.iter().all(|entry| entry.span.is_some()));
    scene
}

/// Reads a scene that must give no message.
fn silent(text: &str) -> SceneDesc {
    let (scene, diagnostics) = read(text);
    assert!(diagnostics.is_empty(), "{text}: {diagnostics:?}");
    scene
}

#[test]
fn a_roughness_for_both_directions_is_corrected_once() {
    for material in ["conductor", "dielectric"] {
        let text =
            format!("WorldBegin\nMaterial \"{material}\"\n\"float roughness\" [-0.5]\nShape \"sphere\"");
        warned(&text, "a roughness of -0.5 is taken for 0");
        let (_, diagnostics) = read(&text);
        let place = diagnostics.iter().next().and_then(|entry| entry.span).expect("it has a place");
        assert_eq!(&text[place.start as usize..][..6], "[-0.5]");
    }
}

#[test]
fn integrators() {
    let used = [("simplepath", false), ("simplevolpath", true), ("randomwalk", false), ("lightpath", false)];
    for (name, media) in used.into_iter().chain([("bdpt", true), ("mlt", true), ("sppm", false)]) {
        let scene =
            warned(&format!("Integrator \"{name}\" \"integer maxdepth\" 9\nWorldBegin"), "`path` is used");
        let Integrator::Path(PathTracer { max_depth: 9, media: found, .. }) = scene.integrator else {
            panic!("{name}: {:?}", scene.integrator)
        };
        assert_eq!(found, media, "{name}");
    }
    let scene = silent("Integrator \"ambientocclusion\" \"float maxdistance\" 2 WorldBegin");
    assert_eq!(scene.integrator, Integrator::Ao { max_distance: 2.0 });
    let scene = silent("Integrator \"whitted\" \"integer maxdepth\" 3 WorldBegin");
    assert_eq!(scene.integrator, Integrator::Whitted { max_depth: 3 });
    assert_eq!(silent("Integrator \"normals\" WorldBegin").integrator, Integrator::Normals);
}

#[test]
fn samplers_filters_films_and_cameras() {
    for name in ["sobol", "paddedsobol", "zsobol", "halton", "pmj02bn", "independent"] {
        let scene =
            silent(&format!("Sampler \"{name}\" \"integer pixelsamples\" 8 \"integer seed\" 3 WorldBegin"));
        assert_eq!((scene.sampler.samples, scene.sampler.seed), (8, 3), "{name}");
    }
    let scene = silent("Sampler \"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 5 WorldBegin");
    assert_eq!(scene.sampler.samples, 15);
    warned("Sampler \"zsobol\" \"string randomization\" \"none\" WorldBegin", "Owen-scrambled");
    warned("Sampler \"stratified\" \"bool jitter\" false WorldBegin", "Owen-scrambled");
    let scene = silent("PixelFilter \"sinc\" \"float xradius\" 3 WorldBegin");
    assert_eq!(scene.filter, Filter::Sinc { radius: [3.0, 4.0], tau: 3.0 });
    warned("Film \"gbuffer\" WorldBegin", "`rgb` film");
    warned("Film \"spectral\" \"integer nbuckets\" 8 WorldBegin", "`rgb` film");
    warned("Film \"rgb\" \"string sensor\" \"nikon_d810\" WorldBegin", "`cie1931`");
    warned("Film \"rgb\" \"float whitebalance\" 5000 WorldBegin", "not balanced");
    warned("Accelerator \"kdtree\" WorldBegin", "`bvh`");
    silent("Accelerator \"bvh\" \"string splitmethod\" \"sah\" WorldBegin");
    assert_eq!(silent("WorldBegin").film, Film::default());
}

#[test]
fn lights_media_and_motion() {
    let scene = warned("WorldBegin LightSource \"goniometric\"", "alike in all directions");
    assert!(matches!(scene.lights.values(), [Light::Point { .. }]));
    let sampler = |name| format!("Integrator \"path\" \"string lightsampler\" \"{name}\" WorldBegin");
    for (name, expected) in
        [("bvh", LightSampler::Tree), ("power", LightSampler::Power), ("uniform", LightSampler::Uniform)]
    {
        let scene = silent(&sampler(name));
        assert!(
            matches!(scene.integrator, Integrator::Path(PathTracer { light_sampler, .. }) if light_sampler == expected)
        );
    }
    warned(&sampler("exhaustive"), "`bvh` is used");
    warned("WorldBegin ActiveTransform EndTime Scale -1 1 1 Shape \"sphere\"", "singular");
    warned("WorldBegin ActiveTransform EndTime Translate 1 0 0 LightSource \"point\"", "lights don't move");
    silent("WorldBegin ActiveTransform EndTime Translate 1 0 0 Shape \"sphere\"");
    silent("WorldBegin ActiveTransform All Translate 1 0 0 Shape \"sphere\"");
    warned("Option \"forcediffuse\" true WorldBegin", "stay as they are");
    silent("Option \"forcediffuse\" false Option \"seed\" 3 WorldBegin");
}

#[test]
fn area_lights_in_objects_are_dropped() {
    let text = "WorldBegin ObjectBegin \"o\" AreaLightSource \"diffuse\" Shape \"sphere\" ObjectEnd ObjectInstance \"o\"";
    let scene = warned(text, "emits nothing");
    assert_eq!(scene.shapes.values()[0].area_light, None);
}

#[test]
fn colours_out_of_range_are_clamped() {
    let scene = warned("WorldBegin Material \"diffuse\" \"rgb reflectance\" [ 1.5 0.5 -1 ]", "from 0 to 1");
    let expected = SpectrumParam::Constant(Spectrum::srgb([1.0, 0.5, 0.0]));
    assert_eq!(scene.materials.values(), [Material::Diffuse { reflectance: expected }]);
    silent("WorldBegin LightSource \"point\" \"rgb I\" [ 15 0.5 0 ]");
    warned("WorldBegin LightSource \"point\" \"rgb I\" [ 15 0.5 -1 ]", "not negative");
}

#[test]
fn unknown_parameters_get_the_nearest_name() {
    let (_, diagnostics) = read("WorldBegin Shape \"sphere\" \"float raduis\" 2");
    let warning = diagnostics.iter().next().unwrap();
    assert_eq!(warning.code, "unknown-parameter");
    assert_eq!(warning.help.as_deref(), Some("did you mean `radius`?"));
    // What `Attribute` sets is meant for some of the shapes that follow.
    silent(
        "WorldBegin Attribute \"shape\" \"float radius\" 2 Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]",
    );
}
