use sahl_math::{Ray, Vec3};
use sahl_scene::{Coefficients, Diagnostics, Spectrum as Color};
use sahl_testkit::chi2::LineTest;
use sahl_testkit::random::Rng;

use super::*;

fn homogeneous(sigma_a: [f32; 3], sigma_s: [f32; 3]) -> Medium {
    let coefficients =
        Coefficients { sigma_a: Color::srgb(sigma_a), sigma_s: Color::srgb(sigma_s), scale: 1.0, g: 0.0 };
    let mut diagnostics = Diagnostics::default();
    let medium = Homogeneous::new(&coefficients, None, None, &mut diagnostics);
    assert!(diagnostics.is_empty());
    Medium::Homogeneous(medium)
}

fn way(length: f32, hero: usize) -> Way {
    let ray = Ray::new(Vec3::new(1.0, 2.0, 3.0), Vec3::Z);
    Way { ray, length, hero, wavelengths: Wavelengths::Rgb }
}

fn stream(rng: &mut Rng) -> Stream {
    Stream::new(rng.uniform().into())
}

/// The distance to the first collision, if there is one.
fn first_collision(medium: &Medium, way: &Way, u: f32, stream: &mut Stream) -> Option<f32> {
    let mut distance = None;
    medium.walk(way, u, stream, |collision| {
        distance = Some((collision.p - way.ray.origin).length());
        Next::Stop
    });
    distance
}

#[test]
fn distances_are_exponential_at_the_rate_of_the_hero() {
    let medium = homogeneous([0.5, 0.25, 3.0], [1.0, 0.0, 2.0]);
    for (hero, rate) in [(0, 1.5), (1, 0.25), (2, 5.0_f32), (3, 0.25)] {
        let mut rng = Rng::new(hero as u64);
        let test = LineTest { range: [0.0, 2.0], samples: 200_000, tests: 4, ..LineTest::default() };
        test.run(
            |u| first_collision(&medium, &way(2.0, hero), u, &mut stream(&mut rng)),
            |t| rate * (-rate * t).exp(),
        )
        .unwrap_or_else(|e| panic!("lane {hero}: {e}"));
    }
}

#[test]
fn the_rest_of_a_walk_is_the_transmittance_of_all_lanes() {
    let medium = homogeneous([0.0, 1.0, 2.0], [0.0, 0.0, 1.0]);
    // The hero sees nothing, so that nothing happens.
    let mut rng = Rng::new(1);
    let found = medium.walk(&way(0.5, 0), 0.9, &mut stream(&mut rng), |_| panic!("nothing to meet"));
    let expected = [1.0, (-0.5_f32).exp(), (-1.5_f32).exp()];
    for (found, expected) in found.to_rgb().into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6);
    }
    assert_eq!(medium.transmittance(&way(0.5, 0)).map(Spectrum::lanes), Some(found.lanes()));
}

#[test]
fn an_endless_way_is_passed_where_nothing_is_and_nowhere_else() {
    let medium = homogeneous([0.0, 1.0, 2.0], [0.0; 3]);
    let mut rng = Rng::new(1);
    let rest = medium.walk(&way(f32::INFINITY, 0), 0.5, &mut stream(&mut rng), |_| Next::Walk);
    assert_eq!(rest.to_rgb(), [1.0, 0.0, 0.0]);
    assert!(first_collision(&medium, &way(f32::INFINITY, 2), 0.999_999, &mut stream(&mut rng)).is_some());
}

#[test]
fn a_collision_in_uniform_matter_is_real() {
    let medium = homogeneous([0.3, 0.1, 0.7], [0.9, 0.4, 0.2]);
    let mut rng = Rng::new(3);
    for hero in 0..4 {
        medium.walk(&way(1e3, hero), 0.5, &mut stream(&mut rng), |collision| {
            let Properties { sigma_a, sigma_s, .. } = collision.properties;
            assert_eq!((sigma_a + sigma_s).lanes(), collision.majorant.lanes());
            Next::Walk
        });
    }
}
