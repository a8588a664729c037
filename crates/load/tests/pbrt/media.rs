//! Media, and the shapes that bound them.

use sahl_load::{MemoryAssets, load_pbrt};
use sahl_math::Vec3;
use sahl_scene::{
    Coefficients, Diagnostics, Emission, GridEmission, GridSource, Integrator, Material, Medium,
    MediumInterface, PathTracer, SceneDesc, Spectrum,
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
    let scene = silent("Integrator \"volpath\" \"bool regularize\" true WorldBegin");
    assert!(matches!(scene.integrator, Integrator::Path(PathTracer { regularize: true, .. })));
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
    // What was used before it was defined is filled in.
    let filled =
        |medium: &Medium| matches!(medium, Medium::Homogeneous { coefficients, .. } if coefficients.g == 0.1);
    assert!(filled(&scene.media.values()[1]));
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

#[test]
fn a_grid_has_a_value_for_each_cell() {
    let scene = silent(
        r#"WorldBegin Translate 1 2 3
        MakeNamedMedium "smoke" "string type" "uniformgrid" "integer nx" 2 "integer ny" 1 "integer nz" 2
            "float density" [ 0 1 2 3 ] "point3 p0" [ 1 1 1 ] "point3 p1" [ -1 0 2 ] "float g" .25
        MakeNamedMedium "fire" "string type" "uniformgrid" "float density" 1 "float temperature" 2000
            "float Lescale" 4 "float temperatureoffset" 100 "float temperaturescale" 2
        MakeNamedMedium "glow" "string type" "uniformgrid" "float density" 1 "blackbody Le" 3000
        MakeNamedMedium "haze" "string type" "rgbgrid" "integer ny" 2 "rgb sigma_s" [ 1 2 3  4 5 6 ]
            "rgb sigma_a" [ 0 0 1  0 1 0 ] "rgb Le" [ 1 1 1  2 2 2 ] "float scale" 5
        MakeNamedMedium "cumulus" "string type" "cloud" "float density" 2 "float frequency" 3"#,
    );
    let [
        Medium::Grid(smoke),
        Medium::Grid(fire),
        Medium::Grid(glow),
        Medium::RgbGrid(haze),
        Medium::Cloud(cloud),
    ] = scene.media.values()
    else {
        panic!("{:?}", scene.media)
    };
    assert_eq!((smoke.density.resolution, &*smoke.density.values), ([2, 1, 2], &[0.0, 1.0, 2.0, 3.0][..]));
    assert_eq!(
        (smoke.region.bounds.min, smoke.region.bounds.max),
        (Vec3::new(-1.0, 0.0, 1.0), Vec3::new(1.0, 1.0, 2.0))
    );
    assert_eq!(smoke.region.medium_to_world.point(Vec3::ZERO), Vec3::new(1.0, 2.0, 3.0));
    assert_eq!((smoke.coefficients.g, &smoke.emission), (0.25, &None));
    let emission = fire.emission.as_ref().unwrap();
    let GridSource::Temperature(grid, scale) = &emission.source else { panic!("{emission:?}") };
    assert_eq!((grid.values[0], scale.kelvin(2000.0)), (2000.0, 3800.0));
    assert_eq!(emission.scales.as_ref().map(|grid| grid.values[0]), Some(4.0));
    // Without pbrt's photometric normalisation.
    assert!((emission.scale - 106.857).abs() < 1e-3);
    let source = GridSource::Spectrum(Spectrum::Blackbody(3000.0));
    assert_eq!(glow.emission, Some(GridEmission { source, scale: 1.0, scales: None }));
    let sigma_s = haze.sigma_s.as_ref().unwrap();
    assert_eq!((sigma_s.resolution, &*sigma_s.values), ([1, 2, 1], &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]][..]));
    assert!(haze.sigma_a.is_some() && haze.emission.is_some() && haze.scale == 5.0);
    assert_eq!((cloud.density, cloud.wispiness, cloud.frequency), (2.0, 1.0, 3.0));
}

#[test]
fn grids_that_do_not_fit_are_errors() {
    let codes = |medium: &str| {
        let (_, diagnostics) = read(&format!("WorldBegin MakeNamedMedium \"m\" \"string type\" {medium}"));
        diagnostics.iter().map(|diagnostic| diagnostic.code).collect::<Vec<_>>()
    };
    assert_eq!(codes("\"uniformgrid\" \"integer nx\" 3 \"float density\" [ 1 2 ]"), ["wrong-count"]);
    assert_eq!(codes("\"uniformgrid\""), ["missing-parameter"]);
    assert_eq!(codes("\"uniformgrid\" \"float density\" -1"), ["negative-density"]);
    let both = "\"uniformgrid\" \"float density\" 1 \"float temperature\" 1 \"rgb Le\" [ 1 1 1 ]";
    assert_eq!(codes(both), ["invalid-value"]);
    assert_eq!(codes("\"rgbgrid\""), ["missing-parameter"]);
    assert_eq!(codes("\"rgbgrid\" \"rgb sigma_s\" [ 1 1 -1 ]"), ["invalid-value"]);
    assert_eq!(codes("\"rgbgrid\" \"rgb sigma_s\" [ 1 1 1 ] \"rgb Le\" [ 1 1 1 ]"), ["missing-parameter"]);
    assert_eq!(codes("\"nanovdb\""), ["missing-parameter"]);
    assert_eq!(codes("\"nanovdb\" \"string filename\" \"a.nvdb\""), ["unreadable-file"]);
}

#[test]
fn a_file_that_is_no_volume_is_told() {
    let mut assets = MemoryAssets::default();
    assets.insert("a.nvdb", *b"not a volume at all");
    let text = "WorldBegin MakeNamedMedium \"m\" \"string type\" \"nanovdb\" \"string filename\" \"a.nvdb\"";
    let loaded = load_pbrt("test.pbrt", text.as_bytes().to_vec(), &assets);
    let messages: Vec<&str> = loaded.diagnostics.iter().map(|entry| entry.message.as_str()).collect();
    assert_eq!(messages, ["can't read the volume `a.nvdb`: it is not a NanoVDB file"]);
}
