//! What becomes of a material; the table is in the module's documentation.

use sahl_scene::{
    AreaLight, ConductorReflectance, FloatParam, Handle, Material, Roughness, Span, Spectrum, SpectrumParam,
    Texture,
};

use super::statement::{Color, Statements};

/// Opacities below this are glass.
const GLASS_OPACITY: f32 = 0.5;
/// Metalness from which on a material is a metal.
const METAL: f32 = 0.5;
/// Index of refraction of glass, where the file says none.
const GLASS_ETA: f32 = 1.5;

/// The material and the emission of `entry`, with the texture of `map_Kd` if it could be read. Adds to `unheeded` what
/// this kind of material has no place for.
pub(super) fn translate(
    entry: &Statements,
    texture: Option<Handle<Texture>>,
    unheeded: &mut Vec<(&'static str, Span)>,
) -> (Material, Option<AreaLight>) {
    let area_light = entry.ke.filter(|ke| ke.max() > 0.0).map(|ke| AreaLight {
        radiance: SpectrumParam::Constant(Spectrum::srgb(ke.rgb)),
        scale: 1.0,
        two_sided: true,
        power: None,
    });
    let material = if is_glass(entry) {
        if let Some(tf) = entry.tf.filter(|tf| tf.rgb != [1.0; 3] && tf.rgb != [0.0; 3]) {
            unheeded.push(("coloured glass (`Tf`) is not honoured: glass is clear", tf.span));
        }
        let eta = entry.ni.filter(|&ni| ni > 1.0).unwrap_or(GLASS_ETA);
        Material::Dielectric { eta: Spectrum::Constant(eta), roughness: Roughness::SMOOTH }
    } else {
        if let Some((_, span)) = entry.opacity.filter(|(opacity, _)| *opacity < 1.0) {
            unheeded.push(("partial opacity (`d`, `Tr`) is not honoured: surfaces are opaque", span));
        }
        metal(entry, texture).unwrap_or_else(|| diffuse(entry, texture, unheeded))
    };
    (material, area_light)
}

fn is_glass(entry: &Statements) -> bool {
    let by_model = entry.illum.is_some_and(|illum| [4.0, 6.0, 7.0, 9.0].contains(&illum));
    by_model || entry.opacity.is_some_and(|(opacity, _)| opacity < GLASS_OPACITY)
}

fn metal(entry: &Statements, texture: Option<Handle<Texture>>) -> Option<Material> {
    let kd = entry.kd.map_or([0.5; 3], |kd| kd.rgb);
    if entry.pm.is_some_and(|metalness| metalness >= METAL) {
        let base = texture.map_or(SpectrumParam::Constant(Spectrum::srgb(kd)), SpectrumParam::Texture);
        let roughness = entry.pr.unwrap_or(0.0).clamp(0.0, 1.0);
        return Some(conductor(base, roughness * roughness));
    }
    let is_mirror = entry.illum.is_some_and(|illum| illum == 3.0 || illum == 5.0);
    let ks = entry.ks.filter(|ks| is_mirror && ks.max() > 0.0 && ks.max() >= diffuse_brightness(entry))?;
    let alpha = entry.ns.map_or(0.0, |ns| (2.0 / (ns.max(0.0) + 2.0)).sqrt());
    Some(conductor(SpectrumParam::Constant(Spectrum::srgb(ks.rgb)), alpha))
}

/// How bright the diffuse part is at most; a texture alone counts as white.
fn diffuse_brightness(entry: &Statements) -> f32 {
    entry.kd.as_ref().map_or(if entry.map_kd.is_some() { 1.0 } else { 0.0 }, Color::max)
}

fn conductor(reflectance: SpectrumParam, alpha: f32) -> Material {
    let alpha = FloatParam::Constant(alpha);
    Material::Conductor {
        reflectance: ConductorReflectance::Normal(reflectance),
        roughness: Roughness { u: alpha, v: alpha, remap: false },
    }
}

fn diffuse(
    entry: &Statements,
    texture: Option<Handle<Texture>>,
    unheeded: &mut Vec<(&'static str, Span)>,
) -> Material {
    if let Some(ks) = entry.ks.filter(|ks| ks.max() > 0.0) {
        unheeded.push(("highlights (`Ks`) of diffuse materials are not honoured", ks.span));
    }
    let reflectance = match (texture, entry.kd) {
        (Some(texture), _) => SpectrumParam::Texture(texture),
        (None, Some(kd)) => SpectrumParam::Constant(Spectrum::srgb(kd.rgb)),
        (None, None) => SpectrumParam::Constant(Spectrum::Constant(0.5)),
    };
    Material::Diffuse { reflectance }
}
