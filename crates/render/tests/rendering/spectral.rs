//! Spectral mode: what RGB mode shows too is shown alike, and glass disperses.

use crate::common::*;
use sahl_image::Image;
use sahl_math::Transform;
use sahl_render::{BuildOptions, build};
use sahl_scene::{
    ColorMode, Integrator, Light, Material, Origin, Projection, Roughness, SceneDesc, Spectrum, SpectrumParam,
};

/// Mean of each channel over the image.
fn means(image: &Image) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pixel in values(image).chunks_exact(3) {
        for (sum, &value) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(value);
        }
    }
    sum.map(|x| x / (values(image).len() / 3) as f64)
}

/// Checks that each channel of the mean is as expected, within `tolerance` of the largest.
fn expect_color(scene: &SceneDesc, expected: [f64; 3], tolerance: f64, what: &str) {
    let found = means(&rendered(scene).film.develop());
    let largest = expected.into_iter().fold(0.0, f64::max);
    for (a, b) in found.into_iter().zip(expected) {
        assert!((a - b).abs() <= tolerance * largest, "{what}: {found:?}, not {expected:?}");
    }
}

fn spectral(scene: SceneDesc) -> SceneDesc {
    SceneDesc { color: ColorMode::Spectral, ..scene }
}

fn named_glass(scene: &mut SceneDesc, name: &str) -> sahl_scene::Handle<Material> {
    let eta = Spectrum::Named(name.to_owned());
    scene.materials.push(Material::Dielectric { eta, roughness: Roughness::SMOOTH }, Origin::default())
}

#[test]
fn a_convex_body_in_a_white_sky_shows_its_albedo() {
    let mut scene = spectral(empty(8, 256));
    let material = diffuse(&mut scene, 0.6);
    add(&mut scene, sphere(1.0), material);
    look_down(&mut scene, 3.0, 0.6);
    sky(&mut scene, grey(2.0));
    for kind in SAMPLERS {
        scene.sampler.kind = kind;
        scene.integrator = path(4);
        expect_mean(&scene, 1.2, 0.02, "red");
        expect_color(&scene, [1.2; 3], 0.02, "path");
    }
}

#[test]
fn glass_in_a_white_sky_is_invisible_whether_it_disperses_or_not() {
    for name in [None, Some("glass-BK7"), Some("glass-F11")] {
        let mut scene = spectral(empty(8, 512));
        let material = match name {
            Some(name) => named_glass(&mut scene, name),
            None => glass(&mut scene),
        };
        add(&mut scene, sphere(1.0), material);
        look_down(&mut scene, 3.0, 0.99);
        sky(&mut scene, grey(1.0));
        for integrator in [path(200), Integrator::Whitted { max_depth: 60 }] {
            scene.integrator = integrator;
            expect_color(&scene, [1.0; 3], 0.02, name.unwrap_or("eta 1.5"));
        }
    }
}

#[test]
fn colours_under_coloured_light_are_those_of_rgb_mode() {
    // One bounce of white light off a colour, and coloured light off a grey, are the same in both modes.
    for (albedo, light) in [([0.7, 0.2, 0.05], [1.0; 3]), ([0.5; 3], [0.3, 2.0, 0.6])] {
        let mut scene = empty(4, 1024);
        let reflectance = SpectrumParam::Constant(Spectrum::srgb(albedo));
        let material = scene.materials.push(Material::Diffuse { reflectance }, Origin::default());
        let floor = patch(&mut scene, square(50.0, 0.0));
        add(&mut scene, floor, material);
        look_down(&mut scene, 0.5, 0.1);
        let position = sahl_math::Vec3::new(0.0, 0.0, 2.0);
        let intensity = Spectrum::srgb(light);
        scene.lights.push(Light::Point { intensity, scale: 7.0, power: None, position }, Origin::default());
        let expected = means(&rendered(&scene).film.develop());
        expect_color(&spectral(scene), expected, 0.02, "point light");
    }
}

#[test]
fn power_and_illuminance_are_luminous_in_both_modes() {
    for spectrum in [Spectrum::Blackbody(3000.0), Spectrum::Named("stdillum-F4".to_owned())] {
        let mut scene = empty(4, 4096);
        let material = diffuse(&mut scene, 0.5);
        let floor = patch(&mut scene, square(50.0, 0.0));
        add(&mut scene, floor, material);
        look_down(&mut scene, 0.5, 0.1);
        let direction = -sahl_math::Vec3::Z;
        let light = Light::Distant { radiance: spectrum, scale: 1.0, illuminance: Some(10.0), direction };
        scene.lights.push(light, Origin::default());
        let rgb = means(&rendered(&scene).film.develop());
        let luminance = 0.212_639 * rgb[0] + 0.715_169 * rgb[1] + 0.072_192 * rgb[2];
        assert!((luminance - 5.0 / std::f64::consts::PI).abs() < 1e-3, "{luminance}");
        expect_color(&spectral(scene), rgb, 0.02, "distant light");
    }
}

/// Looks from air at 60 degrees into `material`, through a plane at z = 0, at a light on z = −1 that ends at x = 0.
fn look_into(material: &str) -> SceneDesc {
    // One wavelength a path behind glass: colours are noisy.
    let mut scene = empty(16, 16384);
    scene.film.resolution = [16, 1];
    let glass = named_glass(&mut scene, material);
    let surface = patch(&mut scene, square(50.0, 0.0));
    add(&mut scene, surface, glass);
    let black = diffuse(&mut scene, 0.0);
    let lamp =
        patch(&mut scene, [[-50.0, -50.0, -1.0], [0.0, -50.0, -1.0], [-50.0, 50.0, -1.0], [0.0, 50.0, -1.0]]);
    let lamp = add(&mut scene, lamp, black);
    emit(&mut scene, lamp, 1.0);
    let (sin, cos) = (0.75_f64.sqrt(), 0.5);
    // Columns: image right, image up and the direction of view; then a place from which the edge is in the middle.
    let (across, depth) = (-0.547, 1.0);
    let rows = [[cos, 0.0, sin, across - depth * sin], [0.0, 1.0, 0.0, 0.0], [sin, 0.0, -cos, depth * cos]];
    scene.camera.camera_to_world = Transform::from_rows(rows).unwrap();
    scene.camera.projection = Projection::Orthographic;
    scene.camera.screen_window = Some([-0.02, 0.02, -0.001, 0.001]);
    scene
}

#[test]
fn glass_disperses_in_spectral_mode_alone() {
    let scene = look_into("glass-F11");
    let colors = |scene: &SceneDesc| -> Vec<[f32; 3]> {
        let image = rendered(scene).film.develop();
        values(&image).chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()
    };
    let rgb = colors(&scene);
    for [r, g, b] in rgb {
        assert!((r - g).abs() < 1e-3 && (g - b).abs() < 1e-3, "no colour in RGB mode");
    }
    let shown = colors(&spectral(scene));
    let (first, last) = (shown[0], shown[15]);
    let white = first[1];
    assert!(white > 0.05 && last.iter().all(|&x| x.abs() < 1e-3), "from light to dark: {shown:?}");
    assert!(first.iter().all(|&x| (x - white).abs() < 0.1 * white), "white first: {first:?}");
    // Blue bends most and so meets the light longest: the border is blue where red has ended.
    assert!(shown.iter().any(|&[r, _, b]| b > 0.3 * white && r < 0.3 * b), "a blue border: {shown:?}");
}

#[test]
fn normals_and_occlusion_do_not_know_wavelengths() {
    let mut scene = empty(6, 4);
    let material = diffuse(&mut scene, 0.6);
    add(&mut scene, sphere(1.0), material);
    look_down(&mut scene, 3.0, 1.2);
    for integrator in [Integrator::Normals, Integrator::Ao { max_distance: 2.0 }] {
        scene.integrator = integrator;
        let expected = rendered(&scene).film.develop();
        assert_eq!(rendered(&spectral(scene.clone())).film.develop(), expected);
    }
}

#[test]
fn only_rgb_mode_warns_of_what_it_approximates() {
    let mut scene = empty(2, 1);
    let material = named_glass(&mut scene, "glass-BK7");
    add(&mut scene, sphere(1.0), material);
    let warnings = |scene: &SceneDesc| build(scene, &BuildOptions::default()).1;
    let codes: Vec<_> = warnings(&scene).iter().map(|diagnostic| diagnostic.code).collect();
    assert_eq!(codes, ["no-light", "spectrum-approximated"]);
    let codes: Vec<_> = warnings(&spectral(scene)).iter().map(|diagnostic| diagnostic.code).collect();
    assert_eq!(codes, ["no-light"]);
}
