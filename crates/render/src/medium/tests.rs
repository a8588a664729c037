use sahl_image::ColorSpace;
use sahl_math::{Bounds3, Ray, Transform, Vec3};
use sahl_scene::{
    CloudMedium, Coefficients, Diagnostics, Grid, GridMedium, Region, RgbGridMedium, SparseGrid,
    SparseMedium, Spectrum as Color, TemperatureScale,
};
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

/// A density that is given at the centres of `values.len()` layers of the unit cube, along z.
fn layered(values: &[f32]) -> DensityGrid {
    let grey = |x: f32| Color::srgb([x, 2.0 * x, 0.5 * x]);
    let description = GridMedium {
        coefficients: Coefficients { sigma_a: grey(1.0), sigma_s: grey(1.0), scale: 1.5, g: 0.0 },
        region: Region {
            bounds: Bounds3 { min: Vec3::new(0.0, 1.0, 2.0), max: Vec3::new(2.0, 3.0, 5.0) },
            medium_to_world: Transform::translate(0.0, 0.0, 1.0).unwrap(),
        },
        density: Grid { resolution: [1, 1, values.len() as u32], values: values.into() },
        emission: None,
    };
    let mut diagnostics = Diagnostics::default();
    let medium = DensityGrid::new(&description, None, &mut diagnostics);
    assert!(diagnostics.is_empty());
    medium
}

/// The density of [`layered`] in the middle of its x and y, at a share of its height.
fn layer(values: &[f32], share: f64) -> f64 {
    let place = share * values.len() as f64 - 0.5;
    let value =
        |i: f64| usize::try_from(i as i64).ok().and_then(|i| values.get(i)).map_or(0.0, |&v| f64::from(v));
    let below = place.floor();
    value(below) + (value(below + 1.0) - value(below)) * (place - below)
}

/// Whether light passes `way` without meeting matter; what is met is decided by the hero.
fn passes(medium: &Medium, way: &Way, rng: &mut Rng) -> bool {
    let mut passed = true;
    medium.walk(way, rng.next_f32(), &mut stream(rng), |collision| {
        let Properties { sigma_a, sigma_s, .. } = collision.properties;
        let matter = (sigma_a + sigma_s).lanes()[way.hero];
        let majorant = collision.majorant.lanes()[way.hero];
        assert!(matter <= majorant * (1.0 + 1e-5), "{matter} beyond the majorant {majorant}");
        if collision.u * majorant < matter {
            passed = false;
            return Next::Stop;
        }
        Next::Walk
    });
    passed
}

#[test]
fn walks_through_a_known_profile_are_unbiased() {
    let values = [0.0, 0.3, 1.2, 0.1, 0.0, 0.7];
    let medium = Medium::DensityGrid(Box::new(layered(&values)));
    let steps = 60_000;
    for (hero, sigma) in [(0, 3.0), (1, 6.0), (2, 1.5)] {
        // From below the box, which stands on z = 3, upward and to its upper third; and down from above.
        for (origin, direction, length, range) in [
            (Vec3::new(1.0, 2.0, 1.0), Vec3::Z, 4.0, [0.0, 2.0 / 3.0]),
            (Vec3::new(1.0, 2.0, 9.0), -Vec3::Z, f32::INFINITY, [0.0, 1.0]),
        ] {
            let step = (range[1] - range[0]) / f64::from(steps);
            let density =
                (0..steps).map(|i| layer(&values, range[0] + (f64::from(i) + 0.5) * step)).sum::<f64>()
                    * step;
            let expected = (-sigma * 3.0 * density).exp();
            let way = Way { ray: Ray::new(origin, direction), length, hero, wavelengths: Wavelengths::Rgb };
            let mut rng = Rng::new(hero as u64);
            let n = 200_000;
            let found = (0..n).filter(|_| passes(&medium, &way, &mut rng)).count() as f64 / f64::from(n);
            let deviation = (expected * (1.0 - expected) / f64::from(n)).sqrt();
            assert!((found - expected).abs() < 4.5 * deviation + 1e-5, "lane {hero}: {found} for {expected}");
        }
    }
}

/// Media of every kind with a majorant that is more than a bound.
fn uneven() -> Vec<Medium> {
    let mut rng = Rng::new(4);
    let mut values = |n: usize| -> Vec<f32> { (0..n).map(|_| rng.next_f32().powi(4)).collect() };
    let coefficients =
        Coefficients { sigma_a: Color::Constant(1.0), sigma_s: Color::Constant(2.0), scale: 2.0, g: 0.0 };
    let region = Region {
        bounds: Bounds3 { min: Vec3::ZERO, max: Vec3::new(1.0, 2.0, 1.0) },
        medium_to_world: Transform::rotate(0.5, [1.0, 2.0, 3.0]).unwrap(),
    };
    let colors: Vec<[f32; 3]> = values(3 * 105).as_chunks().0.to_vec();
    let rgb = RgbGridMedium {
        region,
        space: ColorSpace::Srgb,
        sigma_a: Some(Grid { resolution: [3, 5, 7], values: colors.clone().into() }),
        sigma_s: None,
        scale: 3.0,
        g: 0.0,
        emission: Some(Grid { resolution: [3, 5, 7], values: colors.into() }),
        emission_scale: 1.0,
    };
    let grid = GridMedium {
        coefficients: coefficients.clone(),
        region,
        density: Grid { resolution: [5, 21, 17], values: values(5 * 21 * 17).into() },
        emission: None,
    };
    let cloud = CloudMedium {
        coefficients: coefficients.clone(),
        region,
        density: 1.0,
        wispiness: 1.0,
        frequency: 5.0,
    };
    let lattice = SparseGrid {
        index_to_medium: Transform::scale(0.05, 0.1, 0.07).unwrap(),
        bounds: Bounds3 { min: Vec3::new(-0.4, -0.8, -0.5), max: Vec3::new(0.4, 0.8, 1.1) },
        origin: [-8, -8, -8],
        blocks: [2, 2, 3],
        table: [0, 1, SparseGrid::NO_BLOCK, 2, 3, SparseGrid::NO_BLOCK, 4, 1, 0, 2, 3, 4].into(),
        values: values(5 * SparseGrid::BLOCK).into(),
        background: 0.0,
    };
    let sparse = SparseMedium {
        coefficients,
        medium_to_world: Transform::translate(0.1, 0.2, 0.3).unwrap(),
        density: lattice.clone(),
        temperature: Some((lattice, TemperatureScale { offset: 0.1, scale: 4000.0 })),
        emission_scale: 1.0,
    };
    let mut diagnostics = Diagnostics::default();
    vec![
        Medium::DensityGrid(Box::new(DensityGrid::new(&grid, None, &mut diagnostics))),
        Medium::RgbGrid(Box::new(RgbGrid::new(&rgb, None, &mut diagnostics))),
        Medium::Cloud(Box::new(Cloud::new(&cloud, None, &mut diagnostics))),
        Medium::Sparse(Box::new(Sparse::new(&sparse, None, &mut diagnostics))),
    ]
}

#[test]
fn majorants_bound_matter_along_any_way() {
    for (kind, medium) in uneven().iter().enumerate() {
        let mut rng = Rng::new(kind as u64);
        let (mut met, mut nothing) = (0, 0);
        for turn in 0..3000 {
            let target = rng.point(Vec3::splat(-0.5), Vec3::splat(1.0));
            // Along the axes too, where borders of cells are never crossed.
            let direction =
                if turn % 3 == 0 { [Vec3::X, -Vec3::Y, Vec3::Z][turn / 3 % 3] } else { rng.direction() };
            let ray = Ray::new(target - direction * 3.0, direction);
            let way = Way { ray, length: 4.0, hero: turn % 4, wavelengths: Wavelengths::Rgb };
            medium.walk(&way, rng.next_f32(), &mut stream(&mut rng), |collision| {
                let Properties { sigma_a, sigma_s, emission } = collision.properties;
                let (matter, majorant) = ((sigma_a + sigma_s).lanes(), collision.majorant.lanes());
                for (matter, majorant) in matter.into_iter().zip(majorant) {
                    assert!(
                        (0.0..=majorant * (1.0 + 1e-4)).contains(&matter),
                        "{kind}: {matter} of {majorant}"
                    );
                }
                assert!(emission.is_finite() && emission.min_component() >= 0.0);
                met += 1;
                nothing += i32::from(matter[0] < 0.5 * majorant[0]);
                Next::Walk
            });
        }
        assert!(met > 1000 && nothing > met / 10, "{kind}: {met} collisions, {nothing} with little");
    }
}

#[test]
fn matter_is_found_inside_its_box_alone() {
    for medium in &uneven() {
        let mut rng = Rng::new(9);
        let ray = Ray::new(Vec3::new(-40.0, 30.0, 5.0), Vec3::X);
        let way = Way { ray, length: f32::INFINITY, hero: 0, wavelengths: Wavelengths::Rgb };
        let rest = medium.walk(&way, 0.5, &mut stream(&mut rng), |_| panic!("nothing is there"));
        assert_eq!(rest.lanes(), [1.0; 4]);
    }
}

#[test]
fn values_of_a_lattice_are_met_at_its_points() {
    let mut values = vec![0.0; SparseGrid::BLOCK];
    values[(2 * 8 + 3) * 8 + 4] = 1.0;
    let density = SparseGrid {
        index_to_medium: Transform::IDENTITY,
        bounds: Bounds3 { min: Vec3::splat(0.0), max: Vec3::splat(8.0) },
        origin: [0; 3],
        blocks: [1; 3],
        table: [0].into(),
        values: values.into(),
        background: 0.0,
    };
    let coefficients =
        Coefficients { sigma_a: Color::Constant(1.0), sigma_s: Color::Constant(0.0), scale: 1.0, g: 0.0 };
    let description = SparseMedium {
        coefficients,
        medium_to_world: Transform::IDENTITY,
        density,
        temperature: None,
        emission_scale: 1.0,
    };
    let medium = Medium::Sparse(Box::new(Sparse::new(&description, None, &mut Diagnostics::default())));
    // A hat of height one and width two about the point (2, 3, 4): its integral along z is one.
    let mut rng = Rng::new(2);
    for (x, share) in [(2.0, 1.0), (2.5, 0.5), (1.25, 0.25)] {
        let ray = Ray::new(Vec3::new(x, 3.0, -1.0), Vec3::Z);
        let way = Way { ray, length: 20.0, hero: 0, wavelengths: Wavelengths::Rgb };
        let n = 100_000;
        let found = (0..n).filter(|_| passes(&medium, &way, &mut rng)).count() as f64 / f64::from(n);
        let expected = f64::exp(-share);
        assert!((found - expected).abs() < 4.5 * (0.25 / f64::from(n)).sqrt(), "{found} for {expected}");
    }
}

#[test]
fn a_flat_box_holds_nothing() {
    let bounds = Bounds3 { min: Vec3::ZERO, max: Vec3::new(1.0, 0.0, 1.0) };
    let region = Region { bounds, medium_to_world: Transform::IDENTITY };
    let coefficients =
        Coefficients { sigma_a: Color::Constant(1.0), sigma_s: Color::Constant(0.0), scale: 1e3, g: 0.0 };
    let density = Grid { resolution: [1; 3], values: [1.0].into() };
    let description = GridMedium { coefficients, region, density, emission: None };
    let flat = DensityGrid::new(&description, None, &mut Diagnostics::default());
    let medium = Medium::DensityGrid(Box::new(flat));
    let mut rng = Rng::new(1);
    for (origin, direction) in [(Vec3::new(0.5, -1.0, 0.5), Vec3::Y), (Vec3::new(-1.0, 0.0, 0.5), Vec3::X)] {
        let way =
            Way { ray: Ray::new(origin, direction), length: 9.0, hero: 0, wavelengths: Wavelengths::Rgb };
        medium.walk(&way, 0.5, &mut stream(&mut rng), |_| panic!("nothing is there"));
    }
}
