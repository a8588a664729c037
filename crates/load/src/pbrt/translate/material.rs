//! Materials.

use sahl_scene::{ConductorReflectance, FloatParam, Material, Roughness, Spectrum, SpectrumParam};

use super::super::context::Context;
use super::super::reader::Reader;
use super::super::statement::Name;
use super::lookup;
use super::spectrum::{
    Role, float_or_spectrum, float_param, optional_float_param, optional_spectrum_param, spectrum_param,
};

/// What a material directive asks for.
#[derive(Clone, Debug)]
pub(in super::super) enum MaterialKind {
    /// A surface.
    Surface(Material),
    /// Another material, by name.
    Alias(Name),
    /// No surface, but a boundary between media.
    Interface,
}

/// Reads one kind of material.
type Read = fn(&Context<'_>, &Reader<'_>) -> MaterialKind;

const MATERIALS: &[(&str, Read)] = &[
    ("diffuse", diffuse),
    ("conductor", conductor),
    ("dielectric", dielectric),
    ("coateddiffuse", coated_diffuse),
    ("coatedconductor", coated_conductor),
    ("thindielectric", thin_dielectric),
    ("diffusetransmission", diffuse_transmission),
    ("hair", hair),
    ("subsurface", subsurface),
    ("measured", measured),
    ("mix", mix),
    ("interface", interface),
    ("", interface),
    ("none", interface),
];

/// The material called `name`; `None`, reported, if there is no such.
pub(in super::super) fn material(cx: &Context<'_>, name: &str, p: &Reader<'_>) -> Option<MaterialKind> {
    let material = lookup(MATERIALS, name, p)?(cx, p);
    p.unsupported(&["displacement"], "the surface stays smooth");
    p.unsupported(&["normalmap"], "the surface keeps its normals");
    Some(material)
}

fn grey(value: f32) -> SpectrumParam {
    SpectrumParam::Constant(Spectrum::Constant(value))
}

fn reflectance(cx: &Context<'_>, p: &Reader<'_>, default: f32) -> MaterialKind {
    let reflectance = spectrum_param(cx, p, "reflectance", Role::Albedo, grey(default));
    MaterialKind::Surface(Material::Diffuse { reflectance })
}

fn diffuse(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    reflectance(cx, p, 0.5)
}

/// The names of the parameters of a conductor: alone, or under a coat.
struct ConductorNames {
    eta: &'static str,
    k: &'static str,
    roughness: [&'static str; 3],
}

fn conductor(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    let names = ConductorNames { eta: "eta", k: "k", roughness: ["roughness", "uroughness", "vroughness"] };
    conductor_named(cx, p, &names)
}

fn conductor_named(cx: &Context<'_>, p: &Reader<'_>, names: &ConductorNames) -> MaterialKind {
    let normal = optional_spectrum_param(cx, p, "reflectance", Role::Albedo);
    if normal.is_some() && (p.has(names.eta) || p.has(names.k)) {
        let message = format!("{} has both `reflectance` and `{}` or `{}`", p.what(), names.eta, names.k);
        p.report().error("contradiction", p.span(), message);
    }
    let named = |name: &str| SpectrumParam::Constant(Spectrum::Named(name.to_owned()));
    let reflectance = match normal {
        Some(color) => ConductorReflectance::Normal(color),
        None => ConductorReflectance::Index {
            eta: spectrum_param(cx, p, names.eta, Role::Unbounded, named("metal-Cu-eta")),
            k: spectrum_param(cx, p, names.k, Role::Unbounded, named("metal-Cu-k")),
        },
    };
    MaterialKind::Surface(Material::Conductor { reflectance, roughness: roughness(cx, p, names.roughness) })
}

/// The roughness from the parameters for both directions, the first, and the second.
fn roughness(cx: &Context<'_>, p: &Reader<'_>, [both, u, v]: [&'static str; 3]) -> Roughness {
    let both = float_param(cx, p, both, FloatParam::Constant(0.0));
    let one = |name: &'static str| {
        let given = optional_float_param(cx, p, name).unwrap_or(both);
        match given {
            FloatParam::Constant(value) if value < 0.0 => {
                p.report().warning(
                    "roughness-range",
                    p.find(name).map_or(p.span(), |parameter| parameter.value_span),
                    format!("a roughness of {value} is taken for 0"),
                );
                FloatParam::Constant(0.0)
            }
            given => given,
        }
    };
    Roughness { u: one(u), v: one(v), remap: p.bool("remaproughness", true) }
}

fn dielectric(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    let eta = float_or_spectrum(cx, p, "eta", 1.5);
    let roughness = roughness(cx, p, ["roughness", "uroughness", "vroughness"]);
    MaterialKind::Surface(Material::Dielectric { eta, roughness })
}

/// The parameters of a coat, which do not matter where there is none.
const COAT: &[&str] = &["thickness", "g", "albedo", "maxdepth", "nsamples"];

fn coated_diffuse(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    p.without_effect(COAT);
    p.without_effect(&["roughness", "uroughness", "vroughness", "remaproughness", "eta"]);
    p.unsupported_plugin("unsupported-material", "`diffuse` is used, without the coat");
    reflectance(cx, p, 0.5)
}

fn coated_conductor(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    p.without_effect(COAT);
    p.without_effect(&[
        "interface.roughness",
        "interface.uroughness",
        "interface.vroughness",
        "interface.eta",
    ]);
    p.unsupported_plugin("unsupported-material", "`conductor` is used, without the coat");
    let names = ConductorNames {
        eta: "conductor.eta",
        k: "conductor.k",
        roughness: ["conductor.roughness", "conductor.uroughness", "conductor.vroughness"],
    };
    conductor_named(cx, p, &names)
}

fn thin_dielectric(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    p.unsupported_plugin("unsupported-material", "a smooth `dielectric` is used, which refracts");
    let eta = float_or_spectrum(cx, p, "eta", 1.5);
    MaterialKind::Surface(Material::Dielectric { eta, roughness: Roughness::SMOOTH })
}

fn diffuse_transmission(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    p.without_effect(&["transmittance", "scale"]);
    p.unsupported_plugin("unsupported-material", "`diffuse` is used, which lets no light through");
    reflectance(cx, p, 0.25)
}

fn hair(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    p.without_effect(&["sigma_a", "eumelanin", "pheomelanin", "eta", "beta_m", "beta_n", "alpha"]);
    p.unsupported_plugin("unsupported-material", "`diffuse` is used");
    let color = optional_spectrum_param(cx, p, "color", Role::Albedo);
    let reflectance = spectrum_param(cx, p, "reflectance", Role::Albedo, color.unwrap_or(grey(0.2)));
    MaterialKind::Surface(Material::Diffuse { reflectance })
}

fn subsurface(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    p.without_effect(&["name", "sigma_a", "sigma_s", "mfp", "g", "eta", "scale"]);
    p.without_effect(&["roughness", "uroughness", "vroughness", "remaproughness"]);
    p.unsupported_plugin("unsupported-material", "`diffuse` is used, without light below the surface");
    reflectance(cx, p, 0.7)
}

fn measured(_: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    p.without_effect(&["filename"]);
    p.unsupported_plugin("unsupported-material", "`diffuse` with a reflectance of 0.5 is used");
    MaterialKind::Surface(Material::Diffuse { reflectance: grey(0.5) })
}

/// The material with the larger share; the first if a texture decides.
fn mix(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    let amount = float_param(cx, p, "amount", FloatParam::Constant(0.5));
    let second = matches!(amount, FloatParam::Constant(amount) if amount > 0.5);
    let Some(names) = p.strings("materials") else {
        if !p.has("materials") {
            p.report().error("missing-parameter", p.span(), "material `mix` needs two `string materials`");
        }
        return MaterialKind::Surface(Material::default());
    };
    let [first, last] = names else {
        p.invalid("materials", &format!("needs two names, found {}", names.len()));
        return MaterialKind::Surface(Material::default());
    };
    let chosen = if second { last } else { first };
    p.unsupported_plugin("unsupported-material", &format!("its material `{}` is used", chosen.text));
    MaterialKind::Alias(chosen.clone())
}

fn interface(_: &Context<'_>, _: &Reader<'_>) -> MaterialKind {
    MaterialKind::Interface
}
