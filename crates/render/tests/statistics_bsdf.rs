//! Every kind of BSDF: `sample` follows `pdf`, `weight` is `eval / pdf`, reciprocity, energy.
//!
//! A kind has at least one row in [`rows`]; one without a row fails to compile in [`kind`], then fails
//! [`every_kind_has_a_row`].

#[path = "support/measured.rs"]
mod measured;

use sahl_math::{Vec2, Vec3};
use sahl_render::bsdf::fresnel;
use sahl_render::bsdf::microfacet::TrowbridgeReitz;
use sahl_render::bsdf::{
    Bsdf, BsdfSample, Coat, Coated, Conductor, Dielectric, Diffuse, DiffuseTransmission, Entry, Hair,
    HairShape, Measured, MeasuredTables, OpenPbr, OpenPbrParameters, ThinDielectric,
};
use sahl_render::spectrum::{HeroWavelengths, Spectrum, Wavelengths};
use sahl_render::warp::{cosine_hemisphere, uniform_sphere};
use sahl_scene::{Diagnostics, MeasuredBrdf};
use sahl_testkit::chi2::{DiscreteTest, SphereTest};
use sahl_testkit::furnace::{Furnace, Reciprocity, albedo_by_sampling};
use sahl_testkit::quadrature::integrate_sphere;
use sahl_testkit::random::Rng;
use sahl_testkit::stats::{Running, per_test, welch};

/// How many tests share the significance of 0.01: more than there are rows times directions.
const TESTS: usize = 600;

struct Row {
    name: String,
    bsdf: Bsdf<'static>,
    /// Index of refraction below over above; one where nothing is transmitted.
    eta: f32,
    /// Whether nothing is absorbed.
    is_white: bool,
}

/// The number of kinds, and the place of each among them.
const KINDS: usize = 11;

fn kind(bsdf: &Bsdf<'_>) -> usize {
    match bsdf {
        Bsdf::Diffuse(_) => 0,
        Bsdf::Conductor(_) => 1,
        Bsdf::Dielectric(_) => 2,
        Bsdf::ThinDielectric(_) => 3,
        Bsdf::DiffuseTransmission(_) => 4,
        Bsdf::CoatedDiffuse(_) => 5,
        Bsdf::CoatedConductor(_) => 6,
        Bsdf::Hair(_) => 7,
        Bsdf::OpenPbr(_) => 8,
        Bsdf::Measured(_) => 9,
        Bsdf::Entry(_) => 10,
    }
}

fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add = |name: String, bsdf: Bsdf<'static>, eta: f32, is_white: bool| {
        rows.push(Row { name, bsdf, eta, is_white });
    };
    for albedo in [1.0, 0.3] {
        add(format!("diffuse {albedo}"), Diffuse::new(Spectrum::splat(albedo)).into(), 1.0, albedo == 1.0);
    }
    // With such an absorption hardly anything but reflection is left.
    let (silver, white) = ((0.05, 3.5), (1.0, 1e4));
    for (alpha, (eta, k)) in [
        ([0.0, 0.0], silver),
        ([0.02, 0.02], white),
        ([0.1, 0.1], silver),
        ([0.4, 0.4], white),
        ([1.0, 1.0], white),
        ([1.4, 1.4], white),
        ([0.6, 0.1], silver),
        ([0.05, 0.8], white),
    ] {
        let metal = Conductor::new(Spectrum::splat(eta), Spectrum::splat(k), alpha);
        add(format!("conductor {alpha:?}"), metal.into(), 1.0, k == white.1);
    }
    for (eta, alpha) in [
        (1.5, [0.0, 0.0]),
        (1.0, [0.3, 0.3]),
        (1.5, [0.05, 0.05]),
        (1.5, [0.3, 0.3]),
        (1.5, [1.0, 1.0]),
        (0.7, [0.2, 0.2]),
        (2.4, [0.6, 0.15]),
        (1.05, [0.2, 0.5]),
    ] {
        add(format!("dielectric {eta} {alpha:?}"), Dielectric::new(eta, alpha).into(), eta, true);
    }
    for eta in [1.5, 0.8] {
        add(format!("thin dielectric {eta}"), ThinDielectric::new(eta).into(), 1.0, true);
    }
    for (r, t) in [(0.7, 0.3), (0.0, 0.6), (0.5, 0.0)] {
        let sheet = DiffuseTransmission::new(Spectrum::splat(r), Spectrum::splat(t));
        add(format!("diffuse transmission {r} {t}"), sheet.into(), 1.0, r + t == 1.0);
    }
    add_coated(&mut add);
    for eta in [1.33, 1.0, 2.4] {
        add(format!("entry {eta}"), Entry::new(eta).into(), 1.0, true);
    }
    for (name, _, brdf) in measured_surfaces() {
        add(format!("measured {name}"), seen(&brdf, &Wavelengths::Rgb), 1.0, false);
    }
    for (name, parameters) in white_surfaces(0.6) {
        let dark = OpenPbrParameters { base_color: Spectrum::splat(0.6), ..parameters };
        let eta = if name.contains("glass") || name == "all" { dark.specular_ior } else { 1.0 };
        let surface = Box::leak(Box::new(OpenPbr::new(&dark)));
        add(format!("OpenPBR {name}"), (&*surface).into(), eta, false);
    }
    for (name, parameters) in filmed_surfaces(0.5).into_iter().step_by(4) {
        let dark = OpenPbrParameters { base_color: Spectrum::splat(0.6), ..parameters };
        let eta = if name.starts_with("glass") || name.starts_with("all") { dark.specular_ior } else { 1.0 };
        let surface = Box::leak(Box::new(OpenPbr::new(&dark)));
        add(format!("OpenPBR {name}"), (&*surface).into(), eta, false);
    }
    for (beta_m, beta_n, h, sigma_a) in
        [(0.3, 0.3, 0.4, 0.0), (0.15, 0.6, -0.8, 0.5), (0.9, 0.2, 0.0, 0.0), (0.5, 1.0, 0.97, 2.0)]
    {
        let shape = HairShape { eta: 1.55, beta_m, beta_n, alpha: 0.035 };
        let hair = Box::leak(Box::new(Hair::new(h, &shape, Spectrum::splat(sigma_a))));
        add(format!("hair {beta_m} {beta_n} {h}"), (&*hair).into(), 1.0, sigma_a == 0.0);
    }
    rows
}

/// Surfaces that a gonioreflectometer might have measured, and what it measured.
fn measured_surfaces() -> Vec<(&'static str, Bsdf<'static>, MeasuredBrdf)> {
    use std::f32::consts::{FRAC_PI_2, PI};
    let metal = |alpha| Bsdf::from(Conductor::new(Spectrum::splat(0.2), Spectrum::splat(3.0), alpha));
    let paper = Bsdf::from(Diffuse::new(Spectrum::splat(0.7)));
    let quarter: Vec<f32> = (0..7).map(|i| -PI + FRAC_PI_2 * i as f32 / 6.0).collect();
    let isotropic = [("paper", [1.0; 2], paper), ("metal", [0.4; 2], metal([0.4; 2]))];
    let mut surfaces: Vec<_> = isotropic
        .into_iter()
        .map(|(name, alpha, bsdf)| (name, bsdf, measured::measure(&bsdf, alpha, &[0.0])))
        .collect();
    let brushed = metal([0.5, 0.25]);
    surfaces.push(("brushed metal", brushed, measured::measure(&brushed, [0.5, 0.25], &quarter)));
    surfaces
}

/// A measured surface in the light of a path.
fn seen(brdf: &MeasuredBrdf, wavelengths: &Wavelengths) -> Bsdf<'static> {
    let tables = MeasuredTables::new(brdf, None, &mut Diagnostics::default());
    Measured::new(Box::leak(Box::new(tables)), wavelengths).into()
}

#[test]
fn measured_surfaces_are_what_was_measured() {
    for (name, original, brdf) in measured_surfaces() {
        assert_eq!(brdf.problem(), None, "{name}");
        let hero = HeroWavelengths::sample(0.3);
        let (rgb, spectral) = (seen(&brdf, &Wavelengths::Rgb), seen(&brdf, &Wavelengths::Sampled(hero)));
        let mut rng = Rng::new(0x3ea5);
        let (mut errors, mut asymmetry, mut total) = ([0.0; 2], 0.0, 0.0);
        for _ in 0..20_000 {
            let mut direction = || cosine_hemisphere(Vec2::new(rng.next_f32(), rng.next_f32()));
            let (wo, wi) = (direction(), direction());
            let expected = original.eval(wo, wi).max_component();
            let found = [rgb, spectral].map(|bsdf| bsdf.eval(wo, wi).lanes());
            // The measured metal is tinted: half as bright at 400 nm as at 700 nm.
            let tint = hero.lambda().map(measured::tint);
            errors[0] += f64::from((found[0][1] - expected * measured::rgb_tint()[1]).abs());
            errors[1] += f64::from((found[1][0] - expected * tint[0]).abs());
            asymmetry += f64::from((found[0][0] / wi.z - rgb.eval(wi, wo).lanes()[0] / wo.z).abs() * wi.z);
            total += f64::from(expected);
        }
        let [in_rgb, in_spectrum] = errors.map(|error| error / total);
        assert!(in_rgb < 0.03 && in_spectrum < 0.03, "{name}: {in_rgb} {in_spectrum}");
        assert!(asymmetry / total < 0.05, "{name}: {}", asymmetry / total);
    }
}

/// A white surface that is paper, with the roughness `roughness`.
fn white_surface(roughness: f32) -> OpenPbrParameters {
    OpenPbrParameters {
        base_weight: 1.0,
        base_color: Spectrum::ONE,
        base_diffuse_roughness: 0.0,
        base_metalness: 0.0,
        specular_weight: 1.0,
        specular_color: Spectrum::ONE,
        specular_roughness: roughness,
        specular_anisotropy: 0.0,
        specular_ior: 1.5,
        transmission_weight: 0.0,
        transmission_color: Spectrum::ONE,
        subsurface_weight: 0.0,
        subsurface_color: Spectrum::ONE,
        coat_weight: 0.0,
        coat_color: Spectrum::ONE,
        coat_roughness: 0.2,
        coat_ior: 1.6,
        coat_darkening: 1.0,
        fuzz_weight: 0.0,
        fuzz_color: Spectrum::ONE,
        fuzz_roughness: 0.5,
        thin_film_weight: 0.0,
        thin_film_thickness: 0.5,
        thin_film_ior: 1.4,
        thin_walled: false,
        wavelengths: Wavelengths::Rgb,
    }
}

/// White surfaces of every kind, with what they are called; all have the given roughness.
fn white_surfaces(roughness: f32) -> Vec<(&'static str, OpenPbrParameters)> {
    let paper = white_surface(roughness);
    let metal = OpenPbrParameters { base_metalness: 1.0, ..paper };
    let glass = OpenPbrParameters { transmission_weight: 1.0, ..paper };
    let coated = OpenPbrParameters { coat_weight: 1.0, ..metal };
    vec![
        ("paper", paper),
        ("rough paper", OpenPbrParameters { base_diffuse_roughness: 1.0, ..paper }),
        ("metal", metal),
        ("half metal", OpenPbrParameters { base_metalness: 0.5, ..paper }),
        ("glass", glass),
        ("half glass", OpenPbrParameters { transmission_weight: 0.5, ..paper }),
        ("pane", OpenPbrParameters { thin_walled: true, ..glass }),
        ("leaf", OpenPbrParameters { thin_walled: true, subsurface_weight: 0.8, ..paper }),
        ("coated metal", coated),
        ("coated paper", OpenPbrParameters { base_metalness: 0.0, coat_roughness: 0.6, ..coated }),
        ("fuzz", OpenPbrParameters { fuzz_weight: 1.0, ..paper }),
        ("all", OpenPbrParameters { base_metalness: 0.3, fuzz_weight: 0.5, coat_weight: 0.5, ..glass }),
    ]
}

#[test]
fn white_surfaces_are_white_whatever_their_roughness() {
    for roughness in [0.0, 0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0] {
        for (name, parameters) in white_surfaces(roughness) {
            let surface = OpenPbr::new(&parameters);
            for wo in views() {
                let bsdf = Bsdf::from(&surface);
                let albedo = albedo_by_sampling(|u| draw(&bsdf, wo, u).as_ref().map(energy), 20_000);
                let noise = 4.0 * albedo.variance_of_mean().sqrt();
                let difference = (albedo.mean() - 1.0).abs();
                assert!(difference < 0.005 + noise, "{name} {roughness} {wo:?}: {} {noise}", albedo.mean());
            }
        }
    }
}

/// White surfaces of every kind with a film on them, seen by bands and by wavelengths.
fn filmed_surfaces(roughness: f32) -> Vec<(String, OpenPbrParameters)> {
    let spectral = Wavelengths::Sampled(HeroWavelengths::sample(0.7));
    let films = [(1.0, 0.3, 1.8, Wavelengths::Rgb), (1.0, 0.12, 2.4, spectral), (0.6, 1.5, 1.33, spectral)];
    let mut surfaces = Vec::new();
    for (name, parameters) in white_surfaces(roughness) {
        if !["paper", "glass", "pane", "all"].contains(&name) {
            continue;
        }
        for (number, (thin_film_weight, thin_film_thickness, thin_film_ior, wavelengths)) in
            films.into_iter().enumerate()
        {
            let filmed = OpenPbrParameters {
                thin_film_weight,
                thin_film_thickness,
                thin_film_ior,
                wavelengths,
                ..parameters
            };
            surfaces.push((format!("{name}, film {number}"), filmed));
        }
    }
    surfaces
}

#[test]
fn surfaces_with_films_keep_their_energy() {
    for roughness in [0.2, 1.0] {
        for (name, parameters) in filmed_surfaces(roughness) {
            let surface = OpenPbr::new(&parameters);
            for wo in views() {
                let bsdf = Bsdf::from(&surface);
                let mut rng = Rng::new(0xf117);
                // A lane each; what is absorbed by none of these surfaces is kept by every lane.
                let mut lanes = [Running::default(); 4];
                for _ in 0..8_000 {
                    let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
                    let sample = draw(&bsdf, wo, u);
                    let kept = sample.map_or(Spectrum::ZERO, |s| s.weight * (s.eta * s.eta));
                    for (lane, value) in lanes.iter_mut().zip(kept.lanes()) {
                        lane.add(f64::from(value));
                    }
                }
                for lane in lanes {
                    let noise = 4.0 * lane.variance_of_mean().sqrt();
                    let albedo = lane.mean();
                    // The albedo under a film is known by a few microfacets.
                    let difference = (albedo - 1.0).abs();
                    assert!(difference < 0.0075 + noise, "{name} {roughness} {wo:?}: {albedo} ± {noise}");
                }
            }
        }
    }
}

#[test]
fn a_coat_darkens_paper_as_much_as_light_goes_to_and_fro() {
    // Lambert below a smooth interface (Elias, Simonot 2001): F + E (1 − F) (1 − K) / (1 − E K), where K = 0.5964 for an index of 1.5.
    let base = OpenPbrParameters {
        base_color: Spectrum::splat(0.5),
        specular_weight: 0.0,
        coat_weight: 1.0,
        coat_ior: 1.5,
        coat_roughness: 0.0,
        ..white_surface(0.3)
    };
    let full = 0.04 + 0.5 * 0.96 * (1.0 - 0.5964) / (1.0 - 0.5 * 0.5964);
    for (coat_darkening, expected) in [(1.0, full), (0.0, 0.52), (0.5, 0.5 * (full + 0.52))] {
        let surface = OpenPbr::new(&OpenPbrParameters { coat_darkening, ..base });
        let bsdf = Bsdf::from(&surface);
        let albedo = albedo_by_sampling(|u| draw(&bsdf, Vec3::Z, u).as_ref().map(energy), 200_000);
        let error = (albedo.mean() - expected).abs();
        let noise = 4.0 * albedo.variance_of_mean().sqrt();
        assert!(error < 0.003 + noise, "{coat_darkening}: {} ± {noise}, not {expected}", albedo.mean());
    }
}

/// A clear coat of no depth, in which light may go to and fro as often as it likes.
fn clear_coat(alpha: f32) -> Coat {
    Coat {
        surface: Dielectric::new(1.5, [alpha; 2]),
        thickness: 0.0,
        g: 0.0,
        albedo: Spectrum::ZERO,
        max_depth: 1000,
        samples: 1,
        is_bright: false,
    }
}

fn add_coated(add: &mut impl FnMut(String, Bsdf<'static>, f32, bool)) {
    let cloudy = Coat { thickness: 0.4, g: 0.6, albedo: Spectrum::splat(0.9), samples: 2, ..clear_coat(0.3) };
    let absorbing = Coat { thickness: 0.2, ..clear_coat(0.25) };
    for (name, coat, white) in [
        ("smooth", clear_coat(0.0), true),
        ("rough", clear_coat(0.3), false),
        ("very rough", clear_coat(0.8), false),
        ("cloudy", cloudy, false),
        ("cloudy and smooth", Coat { surface: Dielectric::new(1.3, [0.0; 2]), ..cloudy }, false),
    ] {
        let paper = Diffuse::new(Spectrum::splat(if white { 1.0 } else { 0.7 }));
        let bsdf = Box::leak(Box::new(Coated::new(coat, paper, 7)));
        add(format!("coated diffuse {name}"), (&*bsdf).into(), 1.0, white);
    }
    for (name, coat, alpha) in [
        ("smooth", clear_coat(0.0), 0.0),
        ("smooth", clear_coat(0.0), 0.4),
        ("absorbing", absorbing, 0.0),
        ("absorbing", absorbing, 0.5),
        ("cloudy", cloudy, 0.3),
    ] {
        let metal = Conductor::new(Spectrum::splat(0.1), Spectrum::splat(2.5), [alpha; 2]);
        let bsdf = Box::leak(Box::new(Coated::new(coat, metal, 7)));
        add(format!("coated conductor {name} {alpha}"), (&*bsdf).into(), 1.0, false);
    }
}

/// Directions of view: both sides, near the normal, oblique, and grazing; not symmetric to the tangents.
fn views() -> Vec<Vec3> {
    let angles: [(f32, f32); 6] =
        [(1.0, 0.4), (35.0, 1.1), (62.0, 4.0), (85.0, 2.5), (180.0 - 25.0, 0.9), (180.0 - 70.0, 5.5)];
    angles
        .into_iter()
        .map(|(theta, phi)| {
            let (sin, cos) = theta.to_radians().sin_cos();
            Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
        })
        .collect()
}

fn draw(bsdf: &Bsdf<'_>, wo: Vec3, [u_lobe, x, y]: [f32; 3]) -> Option<BsdfSample> {
    bsdf.sample(wo, u_lobe, Vec2::new(x, y))
}

/// Runs `check` on all rows that `wanted` keeps and all directions of view.
fn for_each(wanted: impl Fn(&Row) -> bool, check: impl Fn(&Row, Vec3) -> Result<(), String>) {
    for row in rows().iter().filter(|row| wanted(row)) {
        for wo in views() {
            check(row, wo).unwrap_or_else(|message| panic!("{} from {wo:?}: {message}", row.name));
        }
    }
}

#[test]
fn every_kind_has_a_row() {
    let mut found = [false; KINDS];
    for row in rows() {
        found[kind(&row.bsdf)] = true;
    }
    assert_eq!(found, [true; KINDS]);
    assert!(rows().len() * views().len() < TESTS);
}

#[test]
fn samples_follow_their_density() {
    for_each(
        |row| !row.bsdf.is_specular() && !row.bsdf.is_stochastic(),
        |row, wo| {
            // Rough refraction seen at a grazing angle has an edge that crosses the bins: it takes fine ones.
            let [theta_bins, phi_bins] = if row.eta == 1.0 { [40, 40] } else { [60, 90] };
            let test =
                SphereTest { theta_bins, phi_bins, samples: 200_000, tests: TESTS, significance: 0.01 };
            test.run(|u| draw(&row.bsdf, wo, u).map(|sample| sample.wi), |wi| row.bsdf.pdf(wo, wi))
        },
    );
}

#[test]
fn a_sample_agrees_with_eval_and_pdf() {
    for_each(
        |_| true,
        |row, wo| {
            let mut rng = Rng::new(5);
            let mut drawn = 0;
            for _ in 0..2000 {
                let Some(sample) = draw(&row.bsdf, wo, rng.uniform()) else { continue };
                drawn += 1;
                check_sample(row, wo, &sample).map_err(|message| format!("{sample:?}: {message}"))?;
            }
            if drawn == 0 { Err("nothing was drawn".to_owned()) } else { Ok(()) }
        },
    );
}

fn check_sample(row: &Row, wo: Vec3, sample: &BsdfSample) -> Result<(), String> {
    let BsdfSample { wi, weight, pdf, kind, eta } = *sample;
    let check = |holds: bool, what: &str| if holds { Ok(()) } else { Err(what.to_owned()) };
    check((wi.length() - 1.0).abs() < 1e-5, "not a unit vector")?;
    check(pdf > 0.0 && pdf.is_finite() && weight.is_finite() && weight.min_component() >= 0.0, "not usable")?;
    check(kind.is_transmission() == (wo.z * wi.z < 0.0), "the wrong side")?;
    let passed = if wo.z > 0.0 { row.eta } else { 1.0 / row.eta };
    check(eta == if kind.is_transmission() { passed } else { 1.0 }, "the wrong index")?;
    // Light may be reflected by a smooth coat or get through it.
    let either = row.bsdf.is_stochastic() && !row.bsdf.is_specular();
    check(either || kind.is_specular() == row.bsdf.is_specular(), "the wrong lobe")?;
    let (density, value) = (row.bsdf.pdf(wo, wi), row.bsdf.eval(wo, wi));
    if kind.is_specular() {
        let is_delta = either || density == 0.0 && value.is_zero();
        return check(is_delta && pdf <= 1.0, "a delta lobe with a density");
    }
    if row.bsdf.is_stochastic() {
        return check(density == pdf, &format!("pdf says {density}"));
    }
    check((density / pdf - 1.0).abs() < 5e-3, &format!("pdf says {density}"))?;
    let expected = weight * pdf;
    let difference = (value - expected).map(f32::abs).max_component();
    check(difference <= 5e-3 * expected.max_component(), &format!("eval says {value:?}, not {expected:?}"))
}

#[test]
fn light_goes_both_ways_alike() {
    // Hair and OpenPBR give up reciprocity, an entry is half of what has it; tables of measurements have it as far as they are fine enough.
    let is_reciprocal = |row: &&Row| {
        !row.bsdf.is_specular()
            && !row.bsdf.is_stochastic()
            && !matches!(row.bsdf, Bsdf::Hair(_) | Bsdf::OpenPbr(_) | Bsdf::Measured(_) | Bsdf::Entry(_))
    };
    for row in rows().iter().filter(is_reciprocal) {
        let check = Reciprocity { pairs: 20_000, tolerance: 1e-3, eta: row.eta };
        check
            .check(|wo, wi| row.bsdf.eval(wo, wi).max_component())
            .unwrap_or_else(|message| panic!("{}: {message}", row.name));
    }
}

/// The share of energy of a sample, without the compression of radiance by refraction.
fn energy(sample: &BsdfSample) -> f32 {
    sample.weight.max_component() * sample.eta * sample.eta
}

#[test]
fn no_energy_is_gained() {
    for_each(
        |_| true,
        |row, wo| {
            let furnace = Furnace { samples: 100_000, tests: TESTS, significance: 0.01 };
            // Where reflection and transmission differ in colour, the brightest lanes of the samples are no albedo; each lane has one.
            let lanes = if row.name.contains("film") { 4 } else { 0 };
            for lane in 0..lanes {
                let furnace = Furnace { samples: furnace.samples / lanes, ..furnace };
                let kept = |sample: &BsdfSample| sample.weight.lanes()[lane] * sample.eta * sample.eta;
                furnace.no_gain(|u| draw(&row.bsdf, wo, u).as_ref().map(kept))?;
            }
            if lanes > 0 {
                return Ok(());
            }
            let albedo = furnace.no_gain(|u| draw(&row.bsdf, wo, u).as_ref().map(energy))?;
            // What bounces more than once between microfacets is lost; the roughest row loses most.
            let kept = if row.bsdf.is_specular() { 0.999 } else { 0.15 };
            if row.is_white && albedo < kept {
                return Err(format!("only {albedo} is left"));
            }
            Ok(())
        },
    );
}

#[test]
fn a_surface_of_slope_one_loses_what_it_should() {
    // With αx = αy = 1 the microfacets are spheres: D = 1 / π, and G₂ / (4 cos θo cos θi) = 1 / (2 (cos θo + cos θi)).
    // The integral of f |cos θi| is then 1 − c ln(1 + 1 / c), with c = cos θo.
    for row in rows().iter().filter(|row| row.name == "conductor [1.0, 1.0]") {
        for wo in views() {
            let c = f64::from(wo.z.abs());
            let furnace = Furnace { tests: TESTS, ..Furnace::default() };
            furnace
                .expect_albedo(
                    |u| draw(&row.bsdf, wo, u).map(|sample| sample.weight.max_component()),
                    1.0 - c * (1.0 / c).ln_1p(),
                )
                .unwrap_or_else(|message| panic!("{wo:?}: {message}"));
        }
    }
}

#[test]
fn sampling_and_quadrature_agree() {
    for_each(
        |row| {
            let is_narrow = row.name.contains("0.02") || row.name.contains("0.05");
            !row.bsdf.is_specular() && !row.bsdf.is_stochastic() && !is_narrow
        },
        |row, wo| {
            let furnace = Furnace { samples: 50_000, tests: TESTS, significance: 0.01 };
            let sample = |u| draw(&row.bsdf, wo, u).map(|sample| sample.weight.max_component());
            furnace.agreement(sample, |wi| row.bsdf.eval(wo, wi).max_component()).map(|_| ())
        },
    );
}

/// Features of a direction, by which distributions are compared: parts of the hemisphere, smoothly bounded.
fn features(wi: Vec3) -> [f64; 4] {
    let [x, y, z] = [wi.x, wi.y, wi.z].map(f64::from);
    [1.0, z.abs(), x.max(0.0), y * y]
}

fn weighted(weight: f32, wi: Vec3, count: f64) -> [f64; 4] {
    features(wi).map(|feature| feature * f64::from(weight) * count)
}

/// Means of `draw`, which gives four numbers, over as many samples.
fn means(seed: u64, mut draw: impl FnMut(&mut Rng) -> [f64; 4]) -> [Running; 4] {
    let mut rng = Rng::new(seed);
    let mut sums: [Running; 4] = Default::default();
    for _ in 0..100_000 {
        for (sum, value) in sums.iter_mut().zip(draw(&mut rng)) {
            sum.add(value);
        }
    }
    sums
}

/// Integrals over the sphere of what `eval` gives, times the features.
fn integrals(seed: u64, eval: impl Fn(Vec3) -> f32) -> [Running; 4] {
    means(seed, |rng| {
        let [x, y] = rng.uniform();
        let wi = uniform_sphere(Vec2::new(x, y));
        weighted(eval(wi), wi, 4.0 * std::f64::consts::PI)
    })
}

#[test]
fn walks_come_out_where_their_values_say() {
    for_each(
        |row| row.bsdf.is_stochastic() && !row.bsdf.is_specular(),
        |row, wo| {
            let sampled = means(21, |rng| match draw(&row.bsdf, wo, rng.uniform()) {
                Some(sample) if !sample.kind.is_specular() => {
                    weighted(sample.weight.max_component(), sample.wi, 1.0)
                }
                _ => [0.0; 4],
            });
            let evaluated = integrals(22, |wi| row.bsdf.eval(wo, wi).max_component());
            for (feature, (a, b)) in sampled.iter().zip(&evaluated).enumerate() {
                if welch(a, b) < per_test(0.01, 4 * TESTS) {
                    return Err(format!("feature {feature}: {} sampled, {} evaluated", a.mean(), b.mean()));
                }
            }
            Ok(())
        },
    );
}

#[test]
fn densities_of_walks_integrate_to_less_than_one() {
    for_each(
        |row| row.bsdf.is_stochastic() && !row.bsdf.is_specular(),
        |row, wo| {
            let [total, ..] = integrals(23, |wi| row.bsdf.pdf(wo, wi));
            let mirrored = means(24, |rng| {
                let specular =
                    draw(&row.bsdf, wo, rng.uniform()).is_some_and(|sample| sample.kind.is_specular());
                [f64::from(specular), 0.0, 0.0, 0.0]
            });
            // Of what diffuse light there is inside, 1 / η² at least gets out at once; the rest is left out.
            let (total, mirrored) = (total.mean(), mirrored[0].mean());
            let expected = 1.0 - mirrored;
            if (0.4 * expected..1.02).contains(&total) {
                Ok(())
            } else {
                Err(format!("{total} beside {mirrored}"))
            }
        },
    );
}

#[test]
fn walks_go_both_ways_alike() {
    for row in rows().iter().filter(|row| row.bsdf.is_stochastic() && !row.bsdf.is_specular()) {
        let mean = |wo: Vec3, wi: Vec3| {
            means(25, |rng| {
                // Directions nearby have other random numbers.
                let [x, y] = rng.uniform();
                let nudge = Vec3::new(x, y, 0.0) * 1e-3;
                let (wo, wi) = ((wo + nudge).normalize(), (wi + nudge).normalize());
                [f64::from(row.bsdf.eval(wo, wi).max_component() / wi.z.abs()), 0.0, 0.0, 0.0]
            })
        };
        let (a, b) = (views()[1], views()[2]);
        let (forth, back) = (mean(a, b), mean(b, a));
        assert!(welch(&forth[0], &back[0]) > 1e-5, "{}: {:?} {:?}", row.name, forth[0], back[0]);
    }
}

#[test]
fn a_smooth_coat_over_paper_is_what_the_formula_says() {
    // All orders of reflection inside add up: f = T(wo) T(wi) ρ / (π η² (1 − ρ R)), R being the mean reflectance of the
    // interface from inside (Lee et al., "Efficient Importance Sampling ...", and older: Saunderson 1942).
    let (eta, rho) = (1.5_f64, 0.8_f64);
    let inside: f64 = (0..100_000)
        .map(|i| {
            let cos = (f64::from(i) + 0.5) / 100_000.0;
            f64::from(fresnel::dielectric(cos as f32, (1.0 / eta) as f32).reflectance) * 2.0 * cos / 100_000.0
        })
        .sum();
    let through = |cos: f32| 1.0 - f64::from(fresnel::dielectric(cos, eta as f32).reflectance);
    for (wo, wi) in [(views()[0], views()[1]), (views()[2], views()[1]), (views()[3], views()[2])] {
        let value = means(26, |rng| {
            let coated =
                Coated::new(clear_coat(0.0), Diffuse::new(Spectrum::splat(rho as f32)), rng.next_u64());
            [f64::from(Bsdf::from(&coated).eval(wo, wi).max_component()), 0.0, 0.0, 0.0]
        });
        let cos = f64::from(wi.z);
        let expected = through(wo.z) * through(wi.z) * rho * cos
            / (std::f64::consts::PI * eta * eta * (1.0 - rho * inside));
        let error = (value[0].mean() - expected) / value[0].variance_of_mean().sqrt().max(1e-7);
        assert!(error.abs() < 4.5, "{wo:?}: {} instead of {expected}", value[0].mean());
    }
}

/// The mean of what a coat with microfacets of roughness `alpha` over grey paper reflects from anywhere, and its error.
fn mean_of_coat(alpha: f32, is_bright: bool) -> (f64, f64) {
    let mut rng = Rng::new(0xb127);
    let (mut sum, mut squares, n) = (0.0, 0.0, 100_000);
    for _ in 0..n {
        let mut upward = || cosine_hemisphere(Vec2::new(rng.next_f32(), rng.next_f32()));
        let (wo, wi) = (upward(), upward());
        let coat = Coat { is_bright, ..clear_coat(alpha) };
        let coated = Coated::new(coat, Diffuse::new(Spectrum::splat(0.5)), rng.next_u64());
        // Without what the interface itself reflects, which is noise here.
        let below = Bsdf::from(&coated).eval(wo, wi) - Bsdf::from(coat.surface).eval(wo, wi);
        let value = f64::from(below.max_component() / wi.z);
        (sum, squares) = (sum + value, squares + value * value);
    }
    let mean = sum / f64::from(n);
    (mean, ((squares / f64::from(n) - mean * mean) / f64::from(n)).sqrt())
}

/// Weights of pbrt-v4 add up to more than one where both the interface and the base are rough.
#[test]
fn bright_coats_are_brighter_if_they_are_rough() {
    let gain = |alpha| {
        let ((plain, error), (bright, other)) = (mean_of_coat(alpha, false), mean_of_coat(alpha, true));
        (bright / plain, (error.hypot(other)) / plain)
    };
    assert_eq!(gain(0.0).0, 1.0);
    let (gain, error) = gain(0.3);
    assert!(gain - 4.0 * error > 1.02 && gain < 1.12, "{gain} ± {error}");
}

#[test]
fn white_paper_below_a_clear_coat_is_white() {
    let row = rows().into_iter().find(|row| row.name == "coated diffuse smooth").unwrap();
    for wo in views() {
        let furnace = Furnace { tests: TESTS, ..Furnace::default() };
        furnace
            .expect_albedo(|u| draw(&row.bsdf, wo, u).map(|sample| sample.weight.max_component()), 1.0)
            .unwrap_or_else(|message| panic!("{wo:?}: {message}"));
    }
}

#[test]
fn smooth_glass_chooses_between_its_two_directions() {
    let glass: Bsdf<'_> = Dielectric::new(1.5, [0.0, 0.0]).into();
    for wo in views() {
        let choice =
            |u| draw(&glass, wo, [u, 0.5, 0.5]).map(|sample| usize::from(sample.kind.is_transmission()));
        let mass = |u: f32| draw(&glass, wo, [u, 0.5, 0.5]).map_or(0.0, |sample| sample.pdf);
        let reflected = mass(0.0);
        let test = DiscreteTest { samples: 100_000, tests: TESTS, ..DiscreteTest::default() };
        test.run(choice, &[reflected, 1.0 - reflected]).unwrap_or_else(|message| panic!("{wo:?}: {message}"));
        assert!(reflected == 1.0 || (mass(1.0 - f32::EPSILON) - (1.0 - reflected)).abs() < 1e-6);
    }
}

#[test]
fn visible_normals_follow_their_density_and_fill_it() {
    for alpha in [[0.1, 0.1], [0.5, 0.5], [1.0, 1.0], [0.2, 0.9]] {
        let facets = TrowbridgeReitz::new(alpha[0], alpha[1]).unwrap();
        let projected = integrate_sphere(|m| if m.z > 0.0 { facets.density(m) * m.z } else { 0.0 }, 1e-5);
        assert!((projected - 1.0).abs() < 1e-3, "{alpha:?}: {projected}");
        for wo in views().into_iter().filter(|wo| wo.z > 0.0) {
            // The weak white furnace: the density of visible normals integrates to one.
            let density = |m: Vec3| {
                let visible = m.z > 0.0 && m.dot(wo) > 0.0;
                if visible { facets.visible_density_over_cos(wo, m) * m.dot(wo) } else { 0.0 }
            };
            let test = SphereTest { samples: 200_000, tests: TESTS, ..SphereTest::default() };
            test.run(|[_, x, y]| Some(facets.sample_visible(wo, Vec2::new(x, y))), density)
                .unwrap_or_else(|message| panic!("{alpha:?} from {wo:?}: {message}"));
        }
    }
}

#[test]
fn bounding_the_cap_saves_samples() {
    let failures = |alpha: f32, wo: Vec3, bounded: bool| {
        let facets = TrowbridgeReitz::new(alpha, alpha).unwrap();
        let mut rng = Rng::new(8);
        (0..20_000)
            .filter(|_| {
                let u = Vec2::from(rng.uniform());
                let m = if bounded { facets.sample_reflecting(wo, u) } else { facets.sample_visible(wo, u) };
                2.0 * wo.dot(m) * m.z <= wo.z
            })
            .count()
    };
    let oblique = Vec3::new(0.8, 0.0, 0.6);
    assert_eq!(failures(1.0, oblique, true), 0);
    assert!(failures(1.0, oblique, false) > 2000);
    assert!(2 * failures(0.6, oblique, true) < failures(0.6, oblique, false));
}
