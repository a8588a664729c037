//! The tree against its own probabilities, and against the light that arrives.

use sahl_math::{Bounds3, Vec2, Vec3};
use sahl_scene::LightSampler;
use sahl_testkit::chi2::DiscreteTest;
use sahl_testkit::random::Rng;

use super::*;
use crate::light::select::{Facing, LightSelection};
use crate::light::{
    AreaLight, DistantLight, Emission, Light, PointLight, Portal, PortalEnvironment, Presence, Sky, SpotLight,
};
use crate::shape::{Emitter, SphereEmitter, TriangleEmitter};
use crate::spectrum::{SpectralCurve, Wavelengths};
use crate::texture::Textures;

fn emission(value: f32) -> Emission {
    Emission { curve: SpectralCurve::constant(value), scale: 1.0 }
}

fn vector(rng: &mut Rng) -> Vec3 {
    let [x, y, z] = rng.uniform();
    Vec3::new(x, y, z) * 2.0 - Vec3::ONE
}

/// Lights of every kind that has a place, some in clumps, some alike, some black.
fn lights(count: usize, rng: &mut Rng) -> Vec<Light> {
    let mut center = Vec3::ZERO;
    (0..count)
        .map(|i| {
            if i % 7 == 0 {
                center = vector(rng) * 5.0;
            }
            let position = center + vector(rng) * 0.3;
            let value = if i % 11 == 0 { 0.0 } else { rng.next_f32() + 0.01 };
            match i % 5 {
                0 => Light::Point(PointLight { position, intensity: emission(value) }),
                1 => {
                    let (inner, width) = (rng.next_f32() * 1.5, rng.next_f32());
                    let (cos_inner, cos_outer) = (inner.cos(), (inner + width).cos());
                    let direction = rng.direction();
                    Light::Spot(SpotLight {
                        position,
                        direction,
                        intensity: emission(value),
                        cos_inner,
                        cos_outer,
                    })
                }
                2 => {
                    let sphere = SphereEmitter::new(position, 0.02, false);
                    Light::Area(AreaLight::new(
                        Emitter::Sphere(sphere),
                        emission(value),
                        false,
                        Presence::Share(1.0),
                    ))
                }
                kind => {
                    let corners = [position, position + vector(rng) * 0.1, position + vector(rng) * 0.1];
                    let triangle = TriangleEmitter::new(corners, false, None);
                    Light::Area(AreaLight::new(
                        Emitter::Triangle(triangle),
                        emission(value),
                        kind == 3,
                        Presence::Share(1.0),
                    ))
                }
            }
        })
        .collect()
}

fn vantages(rng: &mut Rng) -> Vec<Vantage> {
    (0..12)
        .map(|i| {
            let facing = match i % 3 {
                0 => Facing::All,
                1 => Facing::Side(rng.direction()),
                _ => Facing::Sides(rng.direction()),
            };
            Vantage { p: vector(rng) * 6.0, facing }
        })
        .collect()
}

#[test]
fn a_node_is_a_cache_line() {
    assert_eq!(size_of::<Node>(), 64);
}

#[test]
fn lights_are_chosen_with_their_probability() {
    let mut rng = Rng::new(2);
    let mut lights = lights(60, &mut rng);
    let selections = [
        LightSelection::new(LightSampler::Tree, &lights, 10.0),
        {
            let down = DistantLight { direction: -Vec3::Z, irradiance: emission(1.0) };
            lights.insert(7, Light::Distant(down));
            LightSelection::new(LightSampler::Tree, &lights, 10.0)
        },
        // Few, and one of them far away.
        LightSelection::new(LightSampler::Tree, &lights[5..8], 10.0),
        LightSelection::new(LightSampler::Uniform, &lights, 10.0),
    ];
    let vantages = vantages(&mut rng);
    let test =
        DiscreteTest { samples: 40_000, tests: selections.len() * vantages.len(), ..DiscreteTest::default() };
    for selection in &selections {
        for from in &vantages {
            let probabilities: Vec<f32> = (0..lights.len() as u32).map(|i| selection.pmf(from, i)).collect();
            let choose = |u| selection.choose(from, u).map(|choice| choice.light as usize);
            test.run(choose, &probabilities).unwrap_or_else(|error| panic!("{from:?}: {error}"));
            for i in 0..200 {
                if let Some(choice) = selection.choose(from, i as f32 / 200.0) {
                    assert_eq!(choice.pmf, selection.pmf(from, choice.light));
                }
            }
        }
    }
}

#[test]
fn in_space_amid_lights_that_shine_all_round_the_probabilities_sum_to_one() {
    let mut rng = Rng::new(9);
    let point = |rng: &mut Rng| Light::Point(PointLight { position: vector(rng), intensity: emission(1.0) });
    let lights: Vec<Light> = (0..300).map(|_| point(&mut rng)).collect();
    let selection = LightSelection::new(LightSampler::Tree, &lights, 10.0);
    for _ in 0..20 {
        let from = Vantage::in_space(vector(&mut rng) * 3.0);
        let sum: f64 = (0..300).map(|i| f64::from(selection.pmf(&from, i))).sum();
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
    }
}

#[test]
fn every_light_that_arrives_can_be_chosen() {
    let mut rng = Rng::new(5);
    let mut lights = lights(80, &mut rng);
    lights.push(Light::Distant(DistantLight { direction: rng.direction(), irradiance: emission(0.1) }));
    let window = [[-1.0, 0.0], [-1.0, 2.0], [3.0, 2.0], [3.0, 0.0]].map(|[x, y]| Vec3::new(x, y, 0.5));
    let window = PortalEnvironment::new(Sky::Uniform(emission(0.2)), Portal::new(window).unwrap());
    lights.push(Light::Portal(Box::new(window)));
    let selection = LightSelection::new(LightSampler::Tree, &lights, 10.0);
    let mut arriving = 0;
    for _ in 0..40 {
        for from in &vantages(&mut rng) {
            for (index, light) in (0_u32..).zip(&lights) {
                let [a, b] = rng.uniform();
                let sample = light.sample(from.p, Vec2::new(a, b), &Textures::default(), &Wavelengths::Rgb);
                let cos = |wi: Vec3| match from.facing {
                    Facing::All => 1.0,
                    Facing::Side(n) => n.dot(wi),
                    Facing::Sides(n) => n.dot(wi).abs(),
                };
                if sample.is_some_and(|sample| !sample.radiance.is_zero() && cos(sample.wi) > 1e-4) {
                    arriving += 1;
                    assert!(selection.pmf(from, index) > 0.0, "{from:?} {light:?}");
                }
            }
        }
    }
    assert!(arriving > 5_000, "{arriving}");
}

#[test]
fn what_is_behind_an_opaque_surface_is_not_chosen() {
    let mut rng = Rng::new(8);
    let lights: Vec<Light> = (0..50)
        .map(|i| {
            let side = if i < 25 { Vec3::Z } else { -Vec3::Z };
            Light::Point(PointLight { position: side * 3.0 + vector(&mut rng), intensity: emission(1.0) })
        })
        .collect();
    let selection = LightSelection::new(LightSampler::Tree, &lights, 10.0);
    let from = Vantage { p: Vec3::ZERO, facing: Facing::Side(Vec3::Z) };
    assert!((0..25).all(|light| selection.pmf(&from, light) > 0.0));
    assert!((25..50).all(|light| selection.pmf(&from, light) == 0.0));
}

/// The mean of 1/pmf is the number of lights, however unevenly they are chosen.
fn check_count(selection: &LightSelection, from: &Vantage, count: usize) {
    let mut rng = Rng::new(4);
    let (mut sum, mut squares) = (0.0, 0.0);
    let draws = 200_000;
    for _ in 0..draws {
        let value = selection.choose(from, rng.next_f32()).map_or(0.0, |choice| 1.0 / f64::from(choice.pmf));
        sum += value;
        squares += value * value;
    }
    let mean = sum / f64::from(draws);
    let deviation = ((squares / f64::from(draws) - mean * mean) / f64::from(draws)).sqrt();
    assert!((mean - count as f64).abs() < 4.5 * deviation, "{mean} ± {deviation}, not {count}");
    assert!(deviation < 0.05 * count as f64, "{deviation}");
}

#[test]
fn a_million_dim_lights_beside_a_bright_one_can_all_be_chosen() {
    const COUNT: usize = 1_000_000;
    let mut rng = Rng::new(6);
    let lights: Vec<Light> = (0..COUNT)
        .map(|i| {
            let intensity = emission(if i == 0 { 64.0 * COUNT as f32 } else { 1.0 });
            Light::Point(PointLight { position: vector(&mut rng), intensity })
        })
        .collect();
    let from = Vantage { p: Vec3::new(0.5, 1.0, 4.0), facing: Facing::Side(-Vec3::Z) };
    for sampler in [LightSampler::Tree, LightSampler::Power] {
        let selection = LightSelection::new(sampler, &lights, 10.0);
        check_count(&selection, &from, COUNT);
        // A step of a random number of 24 bits spans several dim lights: which of them is not for its bits to say.
        let (mut numbers, mut chosen) = (0, 0);
        for i in 0..4000 {
            let u = i as f32 / 4096.0;
            let near = |k: u32| Vantage { p: from.p + Vec3::X * (1e-5 * k as f32), ..from };
            let chosen_from = |k| selection.choose(&near(k), u).unwrap().light;
            if chosen_from(0) != 0 {
                numbers += 1;
                let distinct: std::collections::BTreeSet<u32> = (0..32).map(chosen_from).collect();
                chosen += distinct.len();
            }
        }
        assert!(numbers > 20 && chosen >= 2 * numbers, "{sampler:?}: {chosen} lights by {numbers} numbers");
    }
}

#[test]
fn degenerate_sets_make_trees_too() {
    let from = Vantage::in_space(Vec3::new(0.0, 0.0, 2.0));
    let bounds = |x: f32| LightBounds::point(Vec3::new(x, 0.0, 0.0), 1.0);
    // None, one, many in one place, and intensities that overflow when they are added up.
    let none = LightTree::new(Vec::new(), 0);
    assert_eq!((none.choose(&from, 0.5), none.contribution(&from)), (None, 0.0));
    let one = LightTree::new(vec![(bounds(0.0), 3)], 4);
    assert_eq!(
        (one.choose(&from, 0.7), one.pmf(&from, 3), one.pmf(&from, 2)),
        (Some((3, 1.0)), Some(1.0), None)
    );
    let alike = LightTree::new((0..100).map(|i| (bounds(0.0), i)).collect(), 100);
    for light in 0..100 {
        let pmf = alike.pmf(&from, light).unwrap();
        assert!(pmf > 0.004 && pmf < 0.02, "{pmf}");
    }
    let huge = LightBounds { intensity: f32::MAX, ..bounds(0.0) };
    let huge = LightTree::new((0..10).map(|i| (huge, i)).collect(), 10);
    assert!(huge.choose(&Vantage::in_space(Vec3::ZERO), 0.3).is_some_and(|(_, pmf)| pmf.is_finite()));
    let nan = Vantage::in_space(Vec3::splat(f32::NAN));
    assert_eq!((alike.choose(&nan, 0.5), alike.pmf(&nan, 5)), (None, Some(0.0)));
    // A row whose members are each a thousand times as far as the one before.
    let row = LightTree::new((0..13).map(|i| (bounds(1000.0_f32.powi(i - 6)), i as u32)).collect(), 13);
    assert!((0..13).all(|light| row.pmf(&from, light).is_some()));
}

#[test]
fn cones_hold_what_they_are_made_of() {
    let mut rng = Rng::new(3);
    for _ in 0..2000 {
        let cone = |rng: &mut Rng| Cone { axis: rng.direction(), cos: rng.next_f32() * 2.0 - 1.0 };
        let (a, b) = (cone(&mut rng), cone(&mut rng));
        let bounds = |facing| LightBounds {
            bounds: Bounds3::from_points([Vec3::ZERO]),
            facing,
            cos_reach: 0.0,
            two_sided: false,
            intensity: 1.0,
        };
        let both = bounds(a).union(&bounds(b)).facing;
        for part in [a, b] {
            for _ in 0..20 {
                let w = rng.direction();
                if w.dot(part.axis) >= part.cos {
                    assert!(w.dot(both.axis) >= both.cos - 1e-5, "{a:?} {b:?} {both:?} {w:?}");
                }
            }
        }
    }
    let directions = [Vec3::X, Vec3::Y, Vec3::new(0.6, 0.8, 0.0)];
    let cone = Cone::about(&directions);
    assert!(directions.iter().all(|w| w.dot(cone.axis) >= cone.cos - 1e-6));
    assert_eq!(Cone::about(&[Vec3::X, -Vec3::X]), Cone::ALL);
}
