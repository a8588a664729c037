//! Materials.

use std::path::PathBuf;
use std::sync::Arc;

use sahl_image::Encoding;
use sahl_scene::{
    Coat, ConductorReflectance, FloatParam, Hair, HairColor, Material, MeasuredBrdf, Relief, Roughness,
    Spectrum, SpectrumParam, Subsurface, SubsurfaceScattering,
};

use super::super::context::Context;
use super::super::reader::Reader;
use super::super::report::quote;
use super::super::statement::Name;
use super::image::image;
use super::lookup;
use super::open_pbr::open_pbr;
use super::preset::{self, Measured};
use super::spectrum::{
    Role, float_or_spectrum, float_param, optional_float_param, optional_spectrum_param, spectrum_param,
};

/// What a material directive asks for.
#[derive(Clone, Debug)]
pub(in super::super) enum MaterialKind {
    /// A surface.
    Surface(Material),
    /// A surface with shading normals of its own.
    Shaped(Material, Relief),
    /// Two others by name, and the probability of the second.
    Mix([Name; 2], FloatParam),
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
    ("openpbr", |cx, p| MaterialKind::Surface(Material::OpenPbr(Box::new(open_pbr(cx, p))))),
    ("interface", interface),
    ("", interface),
    ("none", interface),
];

/// The material called `name`; `None`, reported, if there is no such.
pub(in super::super) fn material(cx: &mut Context<'_>, name: &str, p: &Reader<'_>) -> Option<MaterialKind> {
    Some(match lookup(MATERIALS, name, p)?(cx, p) {
        MaterialKind::Surface(material) => match relief(cx, p) {
            Some(relief) => MaterialKind::Shaped(material, relief),
            None => MaterialKind::Surface(material),
        },
        other => other,
    })
}

/// The shading normals that a material gives to surfaces; a map of normals goes before bumps, as in pbrt-v4.
fn relief(cx: &mut Context<'_>, p: &Reader<'_>) -> Option<Relief> {
    let bump = optional_float_param(cx, p, "displacement");
    let Some(name) = p.string("normalmap") else { return bump.map(Relief::Bump) };
    p.unsupported(&["displacement"], "the normal map is used alone, as in pbrt-v4");
    image(cx, name, Some(Encoding::Linear)).map(Relief::Normals)
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
    let (reflectance, roughness) = metal(cx, p, names);
    MaterialKind::Surface(Material::Conductor { reflectance, roughness })
}

fn metal(cx: &Context<'_>, p: &Reader<'_>, names: &ConductorNames) -> (ConductorReflectance, Roughness) {
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
    (reflectance, roughness(cx, p, names.roughness))
}

/// The roughness from the parameters for both directions, the first, and the second.
fn roughness(cx: &Context<'_>, p: &Reader<'_>, [both, u, v]: [&'static str; 3]) -> Roughness {
    let in_range = |name: &'static str, given: FloatParam| match given {
        FloatParam::Constant(value) if value < 0.0 => {
            p.report().warning(
                "roughness-range",
                p.find(name).map_or(p.span(), |parameter| parameter.value_span),
                format!("a roughness of {value} is taken for 0"),
            );
            FloatParam::Constant(0.0)
        }
        given => given,
    };
    let both = in_range(both, float_param(cx, p, both, FloatParam::Constant(0.0)));
    let one =
        |name: &'static str| optional_float_param(cx, p, name).map_or(both, |given| in_range(name, given));
    Roughness { u: one(u), v: one(v), remap: p.bool("remaproughness", true) }
}

fn dielectric(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    let eta = float_or_spectrum(cx, p, "eta", 1.5);
    let roughness = roughness(cx, p, ["roughness", "uroughness", "vroughness"]);
    MaterialKind::Surface(Material::Dielectric { eta, roughness })
}

/// Walks that an evaluation of a coat may take.
const MOST_WALKS: i32 = 1024;

/// A coat, with the names of its roughness and of its index.
fn coat(cx: &Context<'_>, p: &Reader<'_>, names: [&'static str; 3], eta: &'static str) -> Coat {
    let default = Coat::default();
    let g = float_param(cx, p, "g", default.g);
    if let FloatParam::Constant(g) = g
        && g.abs() >= 1.0
    {
        p.invalid("g", &format!("must be between -1 and 1, found {g}"));
    }
    Coat {
        roughness: roughness(cx, p, names),
        eta: float_or_spectrum(cx, p, eta, 1.5),
        thickness: match float_param(cx, p, "thickness", default.thickness) {
            FloatParam::Constant(thickness) if thickness < 0.0 => {
                p.invalid("thickness", &format!("must be at least zero, found {thickness}"));
                default.thickness
            }
            thickness => thickness,
        },
        g,
        albedo: spectrum_param(cx, p, "albedo", Role::Albedo, default.albedo),
        max_depth: p.count("maxdepth", default.max_depth),
        samples: p.integer("nsamples", 1, 1, MOST_WALKS).unsigned_abs(),
    }
}

fn coated_diffuse(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    let reflectance = spectrum_param(cx, p, "reflectance", Role::Albedo, grey(0.5));
    let coat = coat(cx, p, ["roughness", "uroughness", "vroughness"], "eta");
    MaterialKind::Surface(Material::CoatedDiffuse { reflectance, coat })
}

fn coated_conductor(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    let names = ConductorNames {
        eta: "conductor.eta",
        k: "conductor.k",
        roughness: ["conductor.roughness", "conductor.uroughness", "conductor.vroughness"],
    };
    let (reflectance, roughness) = metal(cx, p, &names);
    let interface = ["interface.roughness", "interface.uroughness", "interface.vroughness"];
    let coat = coat(cx, p, interface, "interface.eta");
    MaterialKind::Surface(Material::CoatedConductor { reflectance, roughness, coat })
}

fn thin_dielectric(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    MaterialKind::Surface(Material::ThinDielectric { eta: float_or_spectrum(cx, p, "eta", 1.5) })
}

fn diffuse_transmission(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    MaterialKind::Surface(Material::DiffuseTransmission {
        reflectance: spectrum_param(cx, p, "reflectance", Role::Albedo, grey(0.25)),
        transmittance: spectrum_param(cx, p, "transmittance", Role::Albedo, grey(0.25)),
        scale: p.non_negative("scale", 1.0),
    })
}

fn hair(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    let default = Hair::default();
    // What gives the colour, the strongest first, as in pbrt-v4.
    let sigma_a = optional_spectrum_param(cx, p, "sigma_a", Role::Unbounded).map(HairColor::Absorption);
    let reflectance = optional_spectrum_param(cx, p, "reflectance", Role::Albedo);
    let color = reflectance.or_else(|| optional_spectrum_param(cx, p, "color", Role::Albedo));
    let amount = |name| optional_float_param(cx, p, name);
    let melanin = match (amount("eumelanin"), amount("pheomelanin")) {
        (None, None) => None,
        (eumelanin, pheomelanin) => Some(HairColor::Melanin {
            eumelanin: eumelanin.unwrap_or(FloatParam::Constant(0.0)),
            pheomelanin: pheomelanin.unwrap_or(FloatParam::Constant(0.0)),
        }),
    };
    let (weaker, stronger): (&[&'static str], _) = match (&sigma_a, &color) {
        (Some(_), _) => (&["reflectance", "color", "eumelanin", "pheomelanin"], "`sigma_a`"),
        (None, Some(_)) => (&["eumelanin", "pheomelanin"], "the colour"),
        (None, None) => (&[], ""),
    };
    p.unsupported(weaker, &format!("{stronger} of the same hair is used"));
    let color = sigma_a.or(color.map(HairColor::Reflectance)).or(melanin).unwrap_or(default.color);
    let alpha = match float_param(cx, p, "alpha", FloatParam::Constant(2.0)) {
        FloatParam::Constant(degrees) => FloatParam::Constant(degrees.to_radians()),
        FloatParam::Texture(_) => {
            p.unsupported(&["alpha"], "the tilt of scales is the same everywhere, 2 degrees");
            default.alpha
        }
    };
    MaterialKind::Surface(Material::Hair(Hair {
        color,
        eta: float_param(cx, p, "eta", default.eta),
        beta_m: float_param(cx, p, "beta_m", default.beta_m),
        beta_n: float_param(cx, p, "beta_n", default.beta_n),
        alpha,
    }))
}

fn subsurface(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    let scale = p.non_negative("scale", 1.0);
    let mut g = p.float_where("g", 0.0, |g| g > -1.0 && g < 1.0, "greater than -1 and less than 1");
    // What tells how light spreads, the strongest first, as in pbrt-v4.
    let named = preset::named(p, "name");
    let coefficient = |name| optional_spectrum_param(cx, p, name, Role::Unbounded);
    let (sigma_a, sigma_s) = (coefficient("sigma_a"), coefficient("sigma_s"));
    let reflectance = optional_spectrum_param(cx, p, "reflectance", Role::Albedo);
    let mean_free_path = coefficient("mfp");
    let milk = Measured { sigma_s: [2.55, 3.21, 3.77], sigma_a: [0.0011, 0.0024, 0.014] };
    let of_measured = |Measured { sigma_s, sigma_a }| {
        let [sigma_a, sigma_s] = [sigma_a, sigma_s].map(|rgb| SpectrumParam::Constant(Spectrum::srgb(rgb)));
        SubsurfaceScattering::Coefficients { sigma_a, sigma_s, scale }
    };
    let one = || SpectrumParam::Constant(Spectrum::Constant(1.0));
    let (scattering, weaker): (_, &[&'static str]) = match (named, sigma_a, sigma_s, reflectance) {
        (Some(measured), ..) => {
            if g != 0.0 {
                p.unsupported(&["g"], "named coefficients are reduced ones, for which it is 0");
                g = 0.0;
            }
            (of_measured(measured), &["sigma_a", "sigma_s", "reflectance", "mfp"])
        }
        (None, Some(sigma_a), Some(sigma_s), _) => {
            (SubsurfaceScattering::Coefficients { sigma_a, sigma_s, scale }, &["reflectance", "mfp"])
        }
        (None, None, None, Some(reflectance)) => {
            let mean_free_path = mean_free_path.unwrap_or_else(one);
            (SubsurfaceScattering::Reflectance { reflectance, mean_free_path, scale }, &[])
        }
        (None, None, None, None) => (of_measured(milk), &["mfp"]),
        (None, given, ..) => {
            let (given, missing) =
                if given.is_some() { ("sigma_a", "sigma_s") } else { ("sigma_s", "sigma_a") };
            p.invalid(given, &format!("needs `{missing}` beside it"));
            (of_measured(milk), &[])
        }
    };
    p.unsupported(weaker, "what is given beside it tells how light spreads");
    MaterialKind::Surface(Material::Subsurface(Box::new(Subsurface {
        scattering,
        eta: p.positive("eta", 1.33),
        g,
        roughness: roughness(cx, p, ["roughness", "uroughness", "vroughness"]),
    })))
}

fn measured(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    let brdf = match p.string("filename") {
        Some(file) => measurement(cx, file),
        None => {
            if !p.has("filename") {
                p.report().error(
                    "missing-parameter",
                    p.span(),
                    "material `measured` needs a `string filename`",
                );
            }
            None
        }
    };
    MaterialKind::Surface(brdf.map_or_else(Material::default, Material::Measured))
}

/// The measurement in the file called `name`, read once; `None`, reported, if it can't be read or makes no sense.
fn measurement(cx: &Context<'_>, name: &Name) -> Option<Arc<MeasuredBrdf>> {
    let known = |path: &PathBuf| cx.measurements.borrow().get(path).cloned();
    if let Some(brdf) = cx.files.candidates(&name.text).iter().find_map(known) {
        return Some(brdf);
    }
    let (path, bytes) = cx.read_file(name)?;
    let read = crate::measured::read(&bytes).map_err(|error| error.to_string());
    match read.and_then(|brdf| brdf.problem().map_or(Ok(brdf), Err)) {
        Ok(brdf) => {
            let brdf = Arc::new(brdf);
            cx.measurements.borrow_mut().insert(path, Arc::clone(&brdf));
            Some(brdf)
        }
        Err(problem) => {
            let message =
                format!("can't read the measured surface {}: {problem}", quote(name.text.as_bytes()));
            cx.report.error("bad-measurement", name.span, message);
            None
        }
    }
}

fn mix(cx: &Context<'_>, p: &Reader<'_>) -> MaterialKind {
    let amount = float_param(cx, p, "amount", FloatParam::Constant(0.5));
    let Some(names) = p.strings("materials") else {
        if !p.has("materials") {
            p.report().error("missing-parameter", p.span(), "material `mix` needs two `string materials`");
        }
        return MaterialKind::Surface(Material::default());
    };
    let [first, second] = names else {
        p.invalid("materials", &format!("needs two names, found {}", names.len()));
        return MaterialKind::Surface(Material::default());
    };
    MaterialKind::Mix([first.clone(), second.clone()], amount)
}

fn interface(_: &Context<'_>, _: &Reader<'_>) -> MaterialKind {
    MaterialKind::Interface
}
