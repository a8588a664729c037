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

fn made(
    material: &sahl_scene::Material,
    scene: &SceneDesc,
    textures: &Textures,
    diagnostics: &mut Diagnostics,
) -> Material {
    Material::new(material, (scene, textures), &mut SharedTables::default(), None, diagnostics)
}

fn bsdf(material: &sahl_scene::Material) -> Bsdf<'static> {
    let textures = Textures::default();
    let mut diagnostics = Diagnostics::default();
    let material = made(material, &SceneDesc::default(), &textures, &mut diagnostics);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    at_point(Box::leak(Box::new(material)), &textures, &TexturePoint::default(), false)
}

fn at_point<'m>(
    material: &'m Material,
    textures: &Textures,
    at: &TexturePoint,
    regularize: bool,
) -> Bsdf<'m> {
    let mut query = Query { textures, at, wavelengths: &mut Wavelengths::Rgb, regularize };
    material.bsdf(&mut query, Box::leak(Box::default()))
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
    let material = made(&material, &scene, &textures, &mut diagnostics);
    let diffuse = sahl_scene::Material::Diffuse { reflectance: SpectrumParam::Texture(checker) };
    let diffuse = made(&diffuse, &scene, &textures, &mut diagnostics);
    assert!(diagnostics.is_empty());
    for (u, alpha, albedo) in [(0.5, 0.2, 0.04), (1.5, 0.6, 0.36)] {
        let at = TexturePoint { uv: sahl_math::Vec2::new(u, 0.5), ..TexturePoint::default() };
        let dielectric = at_point(&material, &textures, &at, false);
        assert_eq!(dielectric, Dielectric::new(1.5, [alpha, 0.1]).into());
        let diffuse = at_point(&diffuse, &textures, &at, false);
        assert_eq!(diffuse, Diffuse::new(Spectrum::splat(albedo)).into());
    }
}

#[test]
fn regularisation_roughens_what_is_nearly_smooth() {
    let mut diagnostics = Diagnostics::default();
    let textures = Textures::default();
    for (given, seen) in [(0.0, 0.1), (0.08, 0.16), (0.2, 0.3), (0.31, 0.31)] {
        let glass = sahl_scene::Material::Dielectric {
            eta: Color::Constant(1.5),
            roughness: roughness(given, given, false),
        };
        let glass = made(&glass, &SceneDesc::default(), &textures, &mut diagnostics);
        let found = at_point(&glass, &textures, &TexturePoint::default(), true);
        assert_eq!(found, Dielectric::new(1.5, [seen; 2]).into(), "{given}");
    }
}

#[test]
fn a_metal_below_a_coat_has_an_index_relative_to_it() {
    let coat = sahl_scene::Coat { eta: Color::Constant(1.25), ..sahl_scene::Coat::default() };
    let metal = bsdf(&sahl_scene::Material::CoatedConductor {
        reflectance: sahl_scene::ConductorReflectance::Index { eta: constant(0.5), k: constant(2.5) },
        roughness: sahl_scene::Roughness::SMOOTH,
        coat,
    });
    let sample = metal.sample(Vec3::Z, 0.5, sahl_math::Vec2::splat(0.5)).unwrap();
    assert!(metal.is_specular() && sample.kind.is_specular());
    let inside = fresnel::conductor(1.0, Spectrum::splat(0.4), Spectrum::splat(2.0)).max_component();
    // Twice through the matter, whose depth is 0.01.
    let expected = inside * (-0.02_f32).exp();
    assert!((sample.weight.max_component() - expected).abs() < 1e-5, "{sample:?} {expected}");
}

#[test]
fn a_mix_is_its_parts_in_their_proportion() {
    let mut scene = SceneDesc::default();
    let part = |scene: &mut SceneDesc, value| {
        scene
            .materials
            .push(sahl_scene::Material::Diffuse { reflectance: constant(value) }, Origin::default())
    };
    let [a, b, c] = [0.1, 0.2, 0.3].map(|value| part(&mut scene, value));
    let mix =
        |materials, amount| sahl_scene::Material::Mix { materials, amount: FloatParam::Constant(amount) };
    let inner = scene.materials.push(mix([b, c], 0.5), Origin::default());
    let outer = scene.materials.push(mix([a, inner], 0.6), Origin::default());
    let textures = Textures::default();
    let mut diagnostics = Diagnostics::default();
    let materials: Vec<Material> = scene
        .materials
        .values()
        .iter()
        .map(|material| made(material, &scene, &textures, &mut diagnostics))
        .collect();
    let mut counts = [0; 3];
    for i in 0..30_000 {
        let p = Vec3::new(i as f32 * 1e-3, 0.5, -3.0);
        let at = TexturePoint { p, ..TexturePoint::default() };
        let query =
            Query { textures: &textures, at: &at, wavelengths: &mut Wavelengths::Rgb, regularize: false };
        counts[Composition::resolve(&materials, outer.index() as u32, &query, |_| {}) as usize] += 1;
    }
    assert_eq!((a.index(), b.index(), c.index()), (0, 1, 2));
    for (count, share) in counts.into_iter().zip([0.4, 0.3, 0.3]) {
        assert!((f64::from(count) / 30_000.0 - share).abs() < 0.012, "{counts:?}");
    }
    assert!(traits(&scene, outer).is_composed && !traits(&scene, a).is_composed);
}
