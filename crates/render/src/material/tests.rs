use sahl_scene::{
    FloatParam, Handle, Origin, SceneDesc, Spectrum as Color, SpectrumParam, Texture, TextureMapping,
};

use super::*;
use crate::bsdf::microfacet::SMOOTH_ALPHA;
use sahl_math::Vec3;

fn constant(value: f32) -> SpectrumParam {
    SpectrumParam::Constant(Color::Constant(value))
}

fn roughness(u: f32, v: f32, remap: bool) -> sahl_scene::Roughness {
    sahl_scene::Roughness { u: FloatParam::Constant(u), v: FloatParam::Constant(v), remap }
}

fn bsdf(material: &sahl_scene::Material) -> Bsdf {
    let textures = Textures::default();
    let mut diagnostics = Diagnostics::default();
    let material = Material::new(material, &textures, None, &mut diagnostics);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    material.bsdf(&textures, &TexturePoint::default(), &Wavelengths::Rgb)
}

#[test]
fn albedos_end_at_one() {
    for (given, kept) in [(0.25, 0.25), (3.0, 1.0), (-1.0, 0.0)] {
        let diffuse = bsdf(&sahl_scene::Material::Diffuse { reflectance: constant(given) });
        assert_eq!(diffuse, Diffuse::new(Spectrum::splat(kept)).into());
    }
}

#[test]
fn roughness_is_remapped_and_ends_in_smoothness() {
    let conductor = |roughness| {
        bsdf(&sahl_scene::Material::Conductor {
            reflectance: sahl_scene::ConductorReflectance::Index { eta: constant(0.2), k: constant(3.0) },
            roughness,
        })
    };
    let metal = |alpha| Conductor::new(Spectrum::splat(0.2), Spectrum::splat(3.0), alpha).into();
    assert_eq!(conductor(roughness(0.25, 0.04, true)), metal([0.5, 0.2]));
    assert_eq!(conductor(roughness(0.25, 0.04, false)), metal([0.25, 0.04]));
    // The limit is one of α, after remapping: the root of 1e-5 is above it.
    assert!(!conductor(roughness(1e-5, 1e-5, true)).is_specular());
    assert!(conductor(roughness(0.99 * SMOOTH_ALPHA, 1e-9, false)).is_specular());
    assert!(conductor(roughness(-4.0, 0.0, true)).is_specular());
}

#[test]
fn the_colour_of_a_metal_is_its_reflectance() {
    let metal = bsdf(&sahl_scene::Material::Conductor {
        reflectance: sahl_scene::ConductorReflectance::Normal(SpectrumParam::Constant(Color::srgb([
            0.9, 0.5, 0.1,
        ]))),
        roughness: sahl_scene::Roughness::SMOOTH,
    });
    let [r, g, b] = metal.albedo(Vec3::Z).to_rgb();
    assert!((r - 0.9).abs() < 1e-4 && (g - 0.5).abs() < 1e-4 && (b - 0.1).abs() < 1e-4, "{r} {g} {b}");
}

#[test]
fn glass_has_its_index() {
    let glass =
        |eta, roughness| bsdf(&sahl_scene::Material::Dielectric { eta: Color::Constant(eta), roughness });
    assert_eq!(glass(1.33, roughness(0.09, 0.09, true)), Dielectric::new(1.33, [0.3, 0.3]).into());
    assert!(glass(1.33, sahl_scene::Roughness::SMOOTH).is_specular());
}

#[test]
fn parameters_vary_over_the_surface() {
    let mut scene = SceneDesc::default();
    let checker = scene.textures.push(
        Texture::Checkerboard {
            mapping: TextureMapping::default(),
            even: constant(0.04),
            odd: constant(0.36),
        },
        Origin::default(),
    );
    assert_eq!(checker, Handle::new(0));
    let mut diagnostics = Diagnostics::default();
    let textures = Textures::new(&scene, &mut diagnostics);
    let material = sahl_scene::Material::Dielectric {
        eta: Color::Constant(1.5),
        roughness: sahl_scene::Roughness {
            u: FloatParam::Texture(checker),
            v: FloatParam::Constant(0.01),
            remap: true,
        },
    };
    let material = Material::new(&material, &textures, None, &mut diagnostics);
    let diffuse = Material::new(
        &sahl_scene::Material::Diffuse { reflectance: SpectrumParam::Texture(checker) },
        &textures,
        None,
        &mut diagnostics,
    );
    assert!(diagnostics.is_empty());
    for (u, alpha, albedo) in [(0.5, 0.2, 0.04), (1.5, 0.6, 0.36)] {
        let at = TexturePoint { uv: sahl_math::Vec2::new(u, 0.5), ..Default::default() };
        let wavelengths = Wavelengths::Rgb;
        assert_eq!(material.bsdf(&textures, &at, &wavelengths), Dielectric::new(1.5, [alpha, 0.1]).into());
        assert_eq!(diffuse.bsdf(&textures, &at, &wavelengths), Diffuse::new(Spectrum::splat(albedo)).into());
    }
}
