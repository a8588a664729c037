//! Every kind of BSDF: `sample` follows `pdf`, `weight` is `eval / pdf`, reciprocity, energy.
//!
//! A kind has at least one row in [`rows`]; one without a row fails to compile in [`kind`], then fails
//! [`every_kind_has_a_row`].

use sahl_math::{Vec2, Vec3};
use sahl_render::bsdf::microfacet::TrowbridgeReitz;
use sahl_render::bsdf::{Bsdf, BsdfSample, Conductor, Dielectric, Diffuse};
use sahl_render::spectrum::Spectrum;
use sahl_testkit::chi2::{DiscreteTest, SphereTest};
use sahl_testkit::furnace::{Furnace, Reciprocity};
use sahl_testkit::quadrature::integrate_sphere;
use sahl_testkit::random::Rng;

/// How many tests share the significance of 0.01: more than there are rows times directions.
const TESTS: usize = 200;

struct Row {
    name: String,
    bsdf: Bsdf,
    /// Index of refraction below over above; one where nothing is transmitted.
    eta: f32,
    /// Whether nothing is absorbed.
    is_white: bool,
}

/// The number of kinds, and the place of each among them.
const KINDS: usize = 3;

fn kind(bsdf: &Bsdf) -> usize {
    match bsdf {
        Bsdf::Diffuse(_) => 0,
        Bsdf::Conductor(_) => 1,
        Bsdf::Dielectric(_) => 2,
    }
}

fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add = |name: String, bsdf: Bsdf, eta: f32, is_white: bool| {
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
    rows
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

fn draw(bsdf: &Bsdf, wo: Vec3, [u_lobe, x, y]: [f32; 3]) -> Option<BsdfSample> {
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
        |row| !row.bsdf.is_specular(),
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
    check(kind.is_specular() == row.bsdf.is_specular(), "the wrong lobe")?;
    let (density, value) = (row.bsdf.pdf(wo, wi), row.bsdf.eval(wo, wi));
    if kind.is_specular() {
        return check(density == 0.0 && value.is_zero() && pdf <= 1.0, "a delta lobe with a density");
    }
    check((density / pdf - 1.0).abs() < 5e-3, &format!("pdf says {density}"))?;
    let expected = weight * pdf;
    let difference = (value - expected).map(f32::abs).max_component();
    check(difference <= 5e-3 * expected.max_component(), &format!("eval says {value:?}, not {expected:?}"))
}

#[test]
fn light_goes_both_ways_alike() {
    for row in rows().iter().filter(|row| !row.bsdf.is_specular()) {
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
        |row| !row.bsdf.is_specular() && !row.name.contains("0.02") && !row.name.contains("0.05"),
        |row, wo| {
            let furnace = Furnace { samples: 50_000, tests: TESTS, significance: 0.01 };
            let sample = |u| draw(&row.bsdf, wo, u).map(|sample| sample.weight.max_component());
            furnace.agreement(sample, |wi| row.bsdf.eval(wo, wi).max_component()).map(|_| ())
        },
    );
}

#[test]
fn smooth_glass_chooses_between_its_two_directions() {
    let glass: Bsdf = Dielectric::new(1.5, [0.0, 0.0]).into();
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
