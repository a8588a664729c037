//! Media whose light is known: slabs, furnaces, single scattering.

use std::f32::consts::PI;

use crate::common::*;
use sahl_image::ColorSpace;
use sahl_math::{Bounds3, Transform, Vec3};
use sahl_scene::{
    Coefficients, ColorMode, Emission, Grid, GridEmission, GridMedium, GridSource, Handle, Integrator, Light,
    Material, Medium, MediumInterface, Origin, PathTracer, Region, RgbGridMedium, SceneDesc, Spectrum,
    TemperatureScale,
};

fn homogeneous(sigma_a: [f32; 3], sigma_s: [f32; 3], g: f32) -> Medium {
    let (sigma_a, sigma_s) = (Spectrum::srgb(sigma_a), Spectrum::srgb(sigma_s));
    Medium::Homogeneous { coefficients: Coefficients { sigma_a, sigma_s, scale: 1.0, g }, emission: None }
}

/// Fills the space between z = 0 and z = `height`, for |x|, |y| below 50.
fn slab(scene: &mut SceneDesc, medium: Medium, height: f32) -> Handle<Medium> {
    let medium = scene.media.push(medium, Origin::default());
    let border = scene.materials.push(Material::Interface, Origin::default());
    for (z, turned) in [(height, false), (0.0, true)] {
        let geometry = quad(scene, square(50.0, z));
        let shape = add(scene, geometry, border);
        scene.shapes[shape].reverse_orientation = turned;
        scene.shapes[shape].media = Some(MediumInterface { inside: Some(medium), outside: None });
    }
    medium
}

/// Looks straight down on the slab from above.
fn above(samples: u32) -> SceneDesc {
    let mut scene = empty(16, samples);
    look_down(&mut scene, 4.0, 1.0);
    scene
}

/// Light straight from above that makes the irradiance `e` on the ground.
fn sun(scene: &mut SceneDesc, e: f32) {
    let direction = Vec3::new(0.0, 0.0, -1.0);
    let light = Light::Distant { radiance: grey(e), scale: 1.0, illuminance: None, direction };
    scene.lights.push(light, Origin::default());
}

#[test]
fn a_slab_absorbs_by_the_law_of_beer_and_lambert() {
    let mut scene = above(1024);
    sky(&mut scene, grey(1.0));
    slab(&mut scene, homogeneous([0.2, 0.9, 3.0], [0.0; 3], 0.0), 1.5);
    for (channel, sigma) in [0.2, 0.9, 3.0_f64].into_iter().enumerate() {
        expect_channel(&scene, channel, (-1.5 * sigma).exp(), 0.02, &format!("absorption {sigma}"));
    }
}

#[test]
fn a_slab_of_its_own_light_is_as_bright_as_a_wall_where_it_is_dense() {
    for (sigma, height) in [(0.3_f32, 1.0_f32), (2.0, 1.5)] {
        let mut scene = above(1024);
        let mut medium = homogeneous([sigma, 2.0 * sigma, sigma], [0.0; 3], 0.0);
        if let Medium::Homogeneous { emission, .. } = &mut medium {
            *emission = Some(Emission { radiance: Spectrum::srgb([1.0, 1.0, 0.5]), scale: 2.0 });
        }
        slab(&mut scene, medium, height);
        for (channel, (radiance, factor)) in [(2.0, 1.0), (2.0, 2.0), (1.0, 1.0)].into_iter().enumerate() {
            let expected = radiance * (1.0 - (-factor * f64::from(sigma * height)).exp());
            expect_channel(&scene, channel, expected, 0.02, &format!("channel {channel} of {sigma}"));
        }
    }
}

#[test]
fn light_that_is_scattered_once_follows_the_formula() {
    // Light comes from behind the camera and goes back to it.
    for (g, sigma_a, sigma_s) in [(0.0_f32, 0.1_f32, 0.4_f32), (-0.4, 0.5, 1.0), (0.5, 0.0, 2.0)] {
        let mut scene = above(256);
        sun(&mut scene, 3.0);
        scene.integrator = path(1);
        let height = 1.25;
        slab(&mut scene, homogeneous([sigma_a; 3], [sigma_s; 3], g), height);
        let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g + 2.0 * g).powf(1.5));
        let sigma_t = sigma_a + sigma_s;
        let expected = 3.0 * phase * sigma_s * (1.0 - (-2.0 * sigma_t * height).exp()) / (2.0 * sigma_t);
        expect_mean(&scene, f64::from(expected), 0.01, &format!("g = {g}"));
    }
}

#[test]
fn lanes_share_a_path_without_bias() {
    let mut scene = above(1024);
    sun(&mut scene, 1.0);
    scene.integrator = path(1);
    let (sigma_a, sigma_s) = ([0.0, 0.2, 2.0], [0.1, 1.0, 6.0]);
    slab(&mut scene, homogeneous(sigma_a, sigma_s, 0.0), 1.0);
    for channel in 0..3 {
        let (sigma_s, sigma_t) =
            (f64::from(sigma_s[channel]), f64::from(sigma_a[channel] + sigma_s[channel]));
        let expected =
            sigma_s / (4.0 * std::f64::consts::PI) * (1.0 - (-2.0 * sigma_t).exp()) / (2.0 * sigma_t);
        expect_channel(&scene, channel, expected, 0.03, &format!("channel {channel}"));
    }
}

#[test]
fn shadow_rays_lose_what_camera_rays_lose() {
    // Down through the slab to a floor and back, with light that a lamp, the sun or the sky sends.
    for kind in ["sun", "lamp", "sky"] {
        let floor_under = |medium: Option<Medium>| {
            let mut scene = above(512);
            let paper = diffuse(&mut scene, 0.5);
            let geometry = quad(&mut scene, square(50.0, -0.5));
            add(&mut scene, geometry, paper);
            match kind {
                "sun" => sun(&mut scene, 2.0),
                "sky" => sky(&mut scene, grey(1.0)),
                _ => {
                    let geometry = quad(&mut scene, square(0.2, 5.0));
                    let lamp = add(&mut scene, geometry, paper);
                    scene.shapes[lamp].reverse_orientation = true;
                    emit(&mut scene, lamp, 100.0);
                }
            }
            scene.integrator = path(1);
            if let Some(medium) = medium {
                slab(&mut scene, medium, 1e-3);
            }
            scene
        };
        // A slab without thickness changes nothing but the estimator.
        let (bare, deviation) = mean(&floor_under(None));
        let thin = floor_under(Some(homogeneous([1e-3; 3], [0.0; 3], 0.0)));
        let (thin, thin_deviation) = mean(&thin);
        let noise = deviation.hypot(thin_deviation) + 1e-5 * bare;
        assert!((bare - thin).abs() < 4.5 * noise, "{kind}: {thin} for {bare}");
        if kind == "sun" {
            let medium = homogeneous([400.0; 3], [0.0; 3], 0.0);
            let expected = f64::from(2.0 * 0.5 / PI) * (-0.8_f64).exp();
            expect_mean(&floor_under(Some(medium)), expected, 0.02, "absorbing film");
        }
    }
}

/// A ball of matter that loses nothing, under a sky that is the same everywhere: it can't be seen.
fn furnace(material: Option<Material>, sigma_s: [f32; 3], g: f32, max_depth: u32) -> SceneDesc {
    let mut scene = empty(8, 512);
    look_down(&mut scene, 4.0, 0.65);
    sky(&mut scene, grey(1.0));
    let medium = scene.media.push(homogeneous([0.0; 3], sigma_s, g), Origin::default());
    let material = scene.materials.push(material.unwrap_or(Material::Interface), Origin::default());
    let ball = add(&mut scene, sphere(1.0), material);
    scene.shapes[ball].media = Some(MediumInterface { inside: Some(medium), outside: None });
    scene.integrator = path(max_depth);
    scene
}

#[test]
fn a_furnace_keeps_its_energy_in_matter() {
    expect_mean(&furnace(None, [2.0, 3.0, 1.0], 0.0, 400), 1.0, 0.01, "isotropic");
    expect_mean(&furnace(None, [4.0; 3], 0.8, 400), 1.0, 0.01, "forward");
    expect_mean(&furnace(None, [0.5, 4.0, 8.0], -0.5, 400), 1.0, 0.01, "back, by colour");
}

#[test]
fn a_furnace_keeps_its_energy_in_matter_behind_glass() {
    let roughness = sahl_scene::Roughness::SMOOTH;
    let glass = Material::Dielectric { eta: Spectrum::Constant(1.5), roughness };
    expect_mean(&furnace(Some(glass), [1.5, 3.0, 1.0], 0.3, 1000), 1.0, 0.02, "glass");
}

#[test]
fn a_camera_stands_in_a_medium() {
    // The floor shines; all that is between is absorbing.
    let mut scene = above(1024);
    let paper = diffuse(&mut scene, 0.0);
    let geometry = quad(&mut scene, square(50.0, 0.0));
    let floor = add(&mut scene, geometry, paper);
    emit(&mut scene, floor, 3.0);
    scene.camera.medium =
        Some(scene.media.push(homogeneous([0.2, 0.1, 0.5], [0.0; 3], 0.0), Origin::default()));
    for (channel, sigma) in [0.2, 0.1, 0.5_f64].into_iter().enumerate() {
        expect_channel(&scene, channel, 3.0 * (-4.0 * sigma).exp(), 0.02, &format!("absorption {sigma}"));
    }
}

#[test]
fn without_media_the_integrator_is_the_one_that_knows_none() {
    let mut scene = above(16);
    sky(&mut scene, grey(1.0));
    let paper = diffuse(&mut scene, 0.5);
    let geometry = quad(&mut scene, square(1.5, 0.0));
    add(&mut scene, geometry, paper);
    let bits = |scene: &SceneDesc| -> Vec<u32> {
        values(&rendered(scene).film.develop()).iter().map(|value| value.to_bits()).collect()
    };
    let bare = bits(&scene);
    // A medium that nothing uses, and borders that part none, change not a bit.
    scene.media.push(homogeneous([1.0; 3], [1.0; 3], 0.0), Origin::default());
    let border = scene.materials.push(Material::Interface, Origin::default());
    add(&mut scene, sphere(0.5), border);
    assert!(bare == bits(&scene));
    // Neither do media that the integrator leaves out.
    slab(&mut scene, homogeneous([1.0; 3], [1.0; 3], 0.0), 1.0);
    assert!(bare != bits(&scene));
    let settings = PathTracer { media: false, ..PathTracer::default() };
    scene.integrator = Integrator::Path(settings);
    assert!(bare == bits(&scene));
}

/// A box in whose middle a slab lies, and three cells a side: between their centres equal values stay the same.
fn grid_region() -> Region {
    let bounds = Bounds3 { min: Vec3::splat(-60.0), max: Vec3::splat(60.0) };
    Region { bounds, medium_to_world: Transform::IDENTITY }
}

fn same_everywhere(value: f32) -> Grid<f32> {
    Grid { resolution: [3; 3], values: [value; 27].into() }
}

#[test]
fn a_furnace_keeps_its_energy_in_uneven_matter() {
    let values: Vec<f32> = (0..64).map(|i: i32| (i * i % 7) as f32).collect();
    let colors = values.iter().map(|&x| [x, 0.5 * x, 2.0]).collect();
    let none = Grid { resolution: [1; 3], values: [[0.0; 3]].into() };
    let bounds = Bounds3 { min: Vec3::splat(-1.0), max: Vec3::ONE };
    let region = Region { bounds, medium_to_world: Transform::IDENTITY };
    let grid = Medium::Grid(GridMedium {
        coefficients: Coefficients {
            sigma_a: Spectrum::Constant(0.0),
            sigma_s: Spectrum::srgb([1.0, 0.5, 2.0]),
            scale: 1.0,
            g: 0.4,
        },
        region,
        density: Grid { resolution: [4; 3], values: values.into() },
        emission: None,
    });
    let rgb = Medium::RgbGrid(RgbGridMedium {
        region,
        space: ColorSpace::Srgb,
        sigma_a: Some(Grid { resolution: [4; 3], values: vec![none.values[0]; 64].into() }),
        sigma_s: Some(Grid { resolution: [4; 3], values: colors }),
        scale: 1.0,
        g: 0.0,
        emission: None,
        emission_scale: 1.0,
    });
    for medium in [grid, rgb] {
        let mut scene = furnace(None, [1.0; 3], 0.0, 400);
        scene.media[Handle::new(0)] = medium;
        for channel in 0..3 {
            expect_channel(&scene, channel, 1.0, 0.02, "uneven");
        }
    }
}

#[test]
fn hot_matter_has_the_colour_of_its_temperature() {
    let light = |emission: GridEmission| {
        let mut scene = above(256);
        let medium = Medium::Grid(GridMedium {
            coefficients: Coefficients {
                sigma_a: Spectrum::Constant(1.0),
                sigma_s: Spectrum::Constant(0.0),
                scale: 20.0,
                g: 0.0,
            },
            region: grid_region(),
            density: same_everywhere(1.0),
            emission: Some(emission),
        });
        slab(&mut scene, medium, 1.0);
        [0, 1, 2].map(|channel| mean_of(&scene, channel))
    };
    // Half as hot as the values say.
    let grid = same_everywhere(5712.0);
    let source = GridSource::Temperature(grid, TemperatureScale { offset: 0.0, scale: 0.5 });
    let hot = light(GridEmission { source, scale: 3.0, scales: None });
    // The same as a spectrum, whose luminance is one.
    let source = GridSource::Spectrum(Spectrum::Blackbody(2856.0));
    let same = light(GridEmission { source, scale: 1.0, scales: None });
    let ratio = hot[1].0 / same[1].0;
    for (hot, same) in hot.into_iter().zip(same) {
        let noise = 4.5 * (hot.1 / ratio).hypot(same.1) + 2e-3 * same.0;
        assert!((hot.0 / ratio - same.0).abs() < noise, "{hot:?} for {same:?} times {ratio}");
    }
}

/// Sunlight that is scattered once or twice in matter which is dense for one end of the spectrum and thin for the other, over glass.
fn haze_over_glass(eta: Spectrum) -> SceneDesc {
    let mut scene = SceneDesc { color: ColorMode::Spectral, ..above(1024) };
    scene.integrator = path(2);
    sun(&mut scene, 1.0);
    slab(&mut scene, homogeneous([0.0; 3], [0.1, 1.0, 6.0], 0.0), 1.0);
    let roughness = sahl_scene::Roughness::SMOOTH;
    let glass = scene.materials.push(Material::Dielectric { eta, roughness }, Origin::default());
    let geometry = quad(&mut scene, square(50.0, -0.5));
    add(&mut scene, geometry, glass);
    scene
}

#[test]
fn glass_that_disperses_leaves_the_light_before_it_as_it_was() {
    // How light is refracted does not matter where nothing lies below; about as much is reflected at all wavelengths.
    for (name, index) in [("glass-BK7", 1.5168), ("glass-F11", 1.6206)] {
        let dispersive = haze_over_glass(Spectrum::Named(name.to_owned()));
        let plain = haze_over_glass(Spectrum::Constant(index));
        for channel in 0..3 {
            let (found, deviation) = mean_of(&dispersive, channel);
            let (expected, expected_deviation) = mean_of(&plain, channel);
            let noise = deviation.hypot(expected_deviation);
            assert!(
                (found - expected).abs() < 4.5 * noise,
                "{name}, channel {channel}: {found}, not {expected} ± {noise}"
            );
            // Nor is it much noisier: all four wavelengths of a path count up to the glass.
            let ratio = deviation / expected_deviation;
            assert!(ratio < 1.2, "{name}, channel {channel}: deviation {deviation} for {expected_deviation}");
        }
    }
}
