//! Matter in which light spreads, where the light that comes back is known.

use crate::common::*;
use sahl_math::{Transform, Vec3};
use sahl_scene::{
    FloatParam, Handle, Integrator, Light, Material, Origin, PathTracer, Roughness, SceneDesc, Spectrum,
    SpectrumParam, Subsurface, SubsurfaceScattering,
};

const ETA: f32 = 1.33;

fn matter(scene: &mut SceneDesc, scattering: SubsurfaceScattering) -> Handle<Material> {
    let subsurface = Subsurface { scattering, eta: ETA, g: 0.0, roughness: Roughness::SMOOTH };
    scene.materials.push(Material::Subsurface(Box::new(subsurface)), Origin::default())
}

/// Matter of the given colour, in which light goes as far as `mean_free_path`.
fn colored(reflectance: [f32; 3], mean_free_path: [f32; 3]) -> SubsurfaceScattering {
    let param = |rgb| SpectrumParam::Constant(Spectrum::srgb(rgb));
    SubsurfaceScattering::Reflectance {
        reflectance: param(reflectance),
        mean_free_path: param(mean_free_path),
        scale: 1.0,
    }
}

/// Reflectance of the surface at right angles.
fn mirrored() -> f64 {
    f64::from(((ETA - 1.0) / (ETA + 1.0)).powi(2))
}

/// Looks straight down on a half space.
fn half_space(scattering: SubsurfaceScattering, samples: u32) -> SceneDesc {
    let mut scene = empty(16, samples);
    look_down(&mut scene, 4.0, 0.5);
    let material = matter(&mut scene, scattering);
    let geometry = quad(&mut scene, square(60.0, 0.0));
    add(&mut scene, geometry, material);
    scene
}

#[test]
fn a_half_space_in_the_light_of_a_sky_has_its_reflectance() {
    // Lanes that spread light differently far: what one draws, the others see.
    let mut scene = half_space(colored([0.8, 0.5, 0.2], [0.2, 0.1, 0.02]), 512);
    sky(&mut scene, grey(1.0));
    for media in [false, true] {
        scene.integrator = Integrator::Path(PathTracer { max_depth: 5, media, ..PathTracer::default() });
        for (channel, reflectance) in [0.8, 0.5, 0.2].into_iter().enumerate() {
            let expected = mirrored() + (1.0 - mirrored()) * reflectance;
            let (found, deviation) = mean_of(&scene, channel);
            assert!(deviation < 0.01 * expected, "too noisy: {deviation}");
            // A thousandth of the light leaves farther away than probes reach.
            let slack = 2e-3 * expected + 4.5 * deviation;
            assert!((found - expected).abs() < slack, "{channel}: {found} ± {deviation}, not {expected}");
        }
    }
}

#[test]
fn a_half_space_in_the_light_of_a_lamp_has_its_reflectance() {
    // The sun from above makes the irradiance one; the factor 1 − F(0) over its mean is what enters.
    let mut scene = half_space(colored([0.6; 3], [0.1; 3]), 512);
    let direction = Vec3::new(0.0, 0.0, -1.0);
    scene.lights.push(
        Light::Distant { radiance: grey(1.0), scale: 1.0, illuminance: None, direction },
        Origin::default(),
    );
    // The mean reflectance of diffuse light from outside, for an index of 1.33.
    let steps = 10_000;
    let diffuse: f64 = (0..steps)
        .map(|i| {
            let cos = (f64::from(i) + 0.5) / f64::from(steps);
            let f = sahl_render::bsdf::fresnel::dielectric(cos as f32, ETA).reflectance;
            2.0 * cos * f64::from(f) / f64::from(steps)
        })
        .sum();
    let passed = 1.0 - mirrored();
    let expected = passed * 0.6 * passed / (1.0 - diffuse) / std::f64::consts::PI;
    let (found, deviation) = mean(&scene);
    assert!(deviation < 0.01 * expected, "too noisy: {deviation}");
    let slack = 2e-3 * expected + 4.5 * deviation;
    assert!((found - expected).abs() < slack, "{found} ± {deviation}, not {expected}");
}

#[test]
fn no_ball_in_a_furnace_is_brighter_than_the_furnace() {
    for size in [0.02, 0.3, 3.0] {
        let mut scene = empty(16, 128);
        look_down(&mut scene, 4.0, 0.9);
        sky(&mut scene, grey(1.0));
        let one = |value| SpectrumParam::Constant(Spectrum::Constant(value));
        let scattering =
            SubsurfaceScattering::Coefficients { sigma_a: one(0.0), sigma_s: one(1.0 / size), scale: 1.0 };
        let material = matter(&mut scene, scattering);
        add(&mut scene, sphere(1.0), material);
        let (found, deviation) = mean(&scene);
        assert!(found < 1.0 + 4.5 * deviation, "{size}: {found} ± {deviation}");
        // Diffusion in a half space knows nothing of the ball's other side: small ones lose light.
        assert!(found > if size < 0.1 { 0.8 } else { 0.1 }, "{size}: {found} ± {deviation}");
    }
}

#[test]
fn light_comes_through_what_is_thin_and_not_through_what_is_thick() {
    // A rough plate lit from behind alone.
    let through = |thickness: f32| {
        let mut scene = empty(8, 256);
        look_down(&mut scene, 4.0, 0.3);
        // Diffuse light falls off by e in about three mean free paths here.
        let scattering = colored([0.5; 3], [0.1; 3]);
        let subsurface = Subsurface {
            scattering,
            eta: ETA,
            g: 0.0,
            roughness: Roughness { u: FloatParam::Constant(0.3), v: FloatParam::Constant(0.3), remap: false },
        };
        let material = scene.materials.push(Material::Subsurface(Box::new(subsurface)), Origin::default());
        for (z, turned) in [(0.0, false), (-thickness, true)] {
            let geometry = quad(&mut scene, square(30.0, z));
            let shape = add_placed(&mut scene, geometry, material, Transform::IDENTITY);
            scene.shapes[shape].reverse_orientation = turned;
        }
        let direction = Vec3::new(0.0, 0.0, 1.0);
        scene.lights.push(
            Light::Distant { radiance: grey(1.0), scale: 1.0, illuminance: None, direction },
            Origin::default(),
        );
        mean(&scene).0
    };
    let (thin, thick) = (through(0.05), through(5.0));
    assert!(thin > 0.01 && thick < 1e-4, "{thin} {thick}");
}
