//! Every warp, table and pixel filter: samples follow the density, inverses undo, weights have the right mean.

use sahl_math::{Vec2, Vec3};
use sahl_render::distribution::{AliasTable, PiecewiseConstant1d, PiecewiseConstant2d, Windowed2d};
use sahl_render::filter::PixelFilter;
use sahl_render::warp;
use sahl_scene::Filter;
use sahl_testkit::chi2::{DiscreteTest, LineTest, SphereTest, SquareTest};
use sahl_testkit::random::Rng;

/// How many tests share the significance of 0.01.
const TESTS: usize = 40;
const SAMPLES: usize = 300_000;

/// Two points of the square are the same, or the same on a square whose left and right sides meet.
fn assert_returns(u: Vec2, back: Vec2, tolerance: f32, what: &str) {
    let difference = (u - back).abs();
    let turn = difference.y.min((difference.y - 1.0).abs());
    assert!(difference.x < tolerance && turn < tolerance, "{what}: {u:?} came back as {back:?}");
}

type Direction = (&'static str, fn(Vec2) -> Vec3, fn(Vec3) -> f32, fn(Vec3) -> Vec2);

const CONES: [f32; 3] = [0.01, 0.5, 1.8];

fn in_cone<const CONE: usize>() -> Direction {
    (
        "uniform_cone",
        |u| warp::uniform_cone(u, CONES[CONE]),
        |w| if 1.0 - w.z <= CONES[CONE] { warp::uniform_cone_pdf(CONES[CONE]) } else { 0.0 },
        |w| warp::uniform_cone_inverse(w, CONES[CONE]),
    )
}

#[test]
fn directions() {
    let table: [Direction; 6] = [
        (
            "cosine_hemisphere",
            warp::cosine_hemisphere,
            |w| warp::cosine_hemisphere_pdf(w.z),
            warp::cosine_hemisphere_inverse,
        ),
        ("uniform_sphere", warp::uniform_sphere, |_| warp::UNIFORM_SPHERE_PDF, warp::uniform_sphere_inverse),
        (
            "uniform_hemisphere",
            warp::uniform_hemisphere,
            |w| if w.z > 0.0 { warp::UNIFORM_HEMISPHERE_PDF } else { 0.0 },
            warp::uniform_hemisphere_inverse,
        ),
        in_cone::<0>(),
        in_cone::<1>(),
        in_cone::<2>(),
    ];
    for (name, sample, pdf, inverse) in table {
        let test = SphereTest { samples: SAMPLES, tests: TESTS, ..SphereTest::default() };
        test.run(|[x, y, _]| Some(sample(Vec2::new(x, y))), pdf).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut rng = Rng::new(1);
        for _ in 0..1000 {
            let u = Vec2::from(rng.uniform()) * 0.98 + Vec2::splat(0.01);
            let w = sample(u);
            assert!((w.length() - 1.0).abs() < 1e-5);
            assert_returns(u, inverse(w), 1e-3, name);
        }
    }
}

#[test]
fn narrow_cones_keep_their_digits() {
    // Half angle of 1e-4: one minus the cosine is 5e-9, which the cosine itself can't tell from zero.
    let w = warp::uniform_cone(Vec2::new(0.999_999, 0.125), 5e-9);
    let sin = (w.x * w.x + w.y * w.y).sqrt();
    assert!((sin - 1e-4).abs() < 1e-9, "{sin}");
    let back = warp::uniform_cone_inverse(warp::uniform_cone(Vec2::new(0.3, 0.6), 5e-9), 5e-9);
    assert_returns(Vec2::new(0.3, 0.6), back, 1e-4, "cone");
}

#[test]
fn disk_and_triangle() {
    let test = SquareTest { samples: SAMPLES, tests: TESTS, ..SquareTest::default() };
    let to_square = |p: Vec2| p * 0.5 + Vec2::splat(0.5);
    let in_disk = |p: Vec2| {
        let p = p * 2.0 - Vec2::ONE;
        if p.length_squared() <= 1.0 { 4.0 * warp::CONCENTRIC_DISK_PDF } else { 0.0 }
    };
    test.run(|u| Some(to_square(warp::concentric_disk(u.into()))), in_disk).unwrap();
    let in_triangle = |b: Vec2| if b.x + b.y <= 1.0 { 2.0 } else { 0.0 };
    test.run(|u| Some(warp::uniform_triangle(u.into()).into()), in_triangle).unwrap();
    let mut rng = Rng::new(2);
    for _ in 0..1000 {
        let u = Vec2::from(rng.uniform());
        assert_returns(u, warp::concentric_disk_inverse(warp::concentric_disk(u)), 1e-5, "disk");
        assert_returns(u, warp::uniform_triangle_inverse(warp::uniform_triangle(u)), 1e-5, "triangle");
    }
    assert_eq!(warp::concentric_disk(Vec2::splat(0.5)), Vec2::ZERO);
    assert_eq!(warp::concentric_disk_inverse(Vec2::ZERO), Vec2::splat(0.5));
}

#[test]
fn curves() {
    let line = LineTest { samples: SAMPLES, tests: TESTS, ..LineTest::default() };
    let tent = LineTest { range: [-1.0, 1.0], ..line };
    tent.run(|u| Some(warp::tent(u)), warp::tent_pdf).unwrap();
    let mut rng = Rng::new(3);
    for (a, b) in [(1.0, 3.0), (2.0, 0.0), (0.0, 5.0), (1.0, 1.0), (0.0, 0.0)] {
        line.run(|u| Some(warp::linear(u, a, b)), |x| warp::linear_pdf(x, a, b)).unwrap();
        for _ in 0..200 {
            let u = rng.next_f32();
            assert!((warp::linear_inverse(warp::linear(u, a, b), a, b) - u).abs() < 1e-5);
            assert!((warp::tent_inverse(warp::tent(u)) - u).abs() < 1e-6);
        }
    }
    for values in [[1.0, 2.0, 0.5, 4.0], [0.0, 1.0, 1.0, 0.0], [0.0; 4], [0.0, 0.0, 0.0, 1.0]] {
        let test = SquareTest { samples: SAMPLES, tests: TESTS, ..SquareTest::default() };
        test.run(|u| Some(warp::bilinear(u.into(), values)), |p| warp::bilinear_pdf(p, values)).unwrap();
        for _ in 0..200 {
            let u = Vec2::from(rng.uniform()) * 0.98 + Vec2::splat(0.01);
            assert_returns(u, warp::bilinear_inverse(warp::bilinear(u, values), values), 1e-4, "bilinear");
        }
    }
}

#[test]
fn tables() {
    let values = [0.0, 3.0, 1.0, 0.0, 0.0, 8.0, 0.5, 0.0];
    let line = PiecewiseConstant1d::new(&values);
    let test = LineTest { samples: SAMPLES, tests: TESTS, ..LineTest::default() };
    test.run(|u| Some(line.sample(u).0), |x| line.pdf(x)).unwrap();
    let grid = PiecewiseConstant2d::new(&[1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 4.0, 1.0, 0.0, 0.1, 0.0, 0.0], 3);
    let test = SquareTest { x_bins: 30, y_bins: 32, samples: SAMPLES, tests: TESTS, ..SquareTest::default() };
    test.run(|u| Some(grid.sample(u.into()).0), |p| grid.pdf(p)).unwrap();
    let grid = Windowed2d::new(&[1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 4.0, 1.0, 0.0, 0.1, 0.0, 0.0], 3);
    for [low, high] in [[[0.0, 0.0], [1.0, 1.0]], [[0.1, 0.55], [0.85, 0.8]], [[0.35, 0.6], [0.6, 0.7]]] {
        let window = [Vec2::from(low), Vec2::from(high)];
        let size = window[1] - window[0];
        let stretched = |p: Vec2| Vec2::new((p.x - low[0]) / size.x, (p.y - low[1]) / size.y);
        let inside = |p: Vec2| Vec2::new(low[0] + p.x * size.x, low[1] + p.y * size.y);
        test.run(
            |u| grid.sample(u.into(), window).map(|(p, _)| stretched(p).map(|x| x.clamp(0.0, 1.0))),
            |p| grid.pdf(inside(p), window) * size.x * size.y,
        )
        .unwrap_or_else(|error| panic!("{window:?}: {error}"));
    }
    let weights = [0.0, 3.0, 1e-3, 5.0, 0.0, 2.0, 2.0];
    let alias = AliasTable::new(&weights);
    let probabilities: Vec<f32> = (0..weights.len()).map(|i| alias.pmf(i)).collect();
    let test = DiscreteTest { samples: SAMPLES, tests: TESTS, ..DiscreteTest::default() };
    test.run(|u| alias.sample(f64::from(u)).map(|(outcome, ..)| outcome), &probabilities).unwrap();
    let reused = LineTest { samples: SAMPLES, tests: TESTS, ..LineTest::default() };
    reused.run(|u| alias.sample(f64::from(u)).map(|(_, _, rest)| rest), |_| 1.0).unwrap();
}

/// A filter of every kind; a new kind must be added here for this to compile, and then to [`filters`].
fn name(filter: &Filter) -> &'static str {
    match filter {
        Filter::Box { .. } => "box",
        Filter::Triangle { .. } => "triangle",
        Filter::Gaussian { .. } => "gaussian",
        Filter::Mitchell { .. } => "mitchell",
        Filter::Sinc { .. } => "sinc",
    }
}

type FilterRow = (Filter, fn(f32, f32) -> f32);

/// Filters with their curve over (offset, radius) along an axis, not normalised.
fn filters() -> [FilterRow; 5] {
    [
        (Filter::Box { radius: [0.5, 1.5] }, |_, _| 1.0),
        (Filter::Triangle { radius: [2.0, 1.0] }, |x, radius| radius - x.abs()),
        (Filter::Gaussian { radius: [1.5, 2.0], sigma: 0.5 }, |x, radius| {
            (-2.0 * x * x).exp() - (-2.0 * radius * radius).exp()
        }),
        (Filter::Sinc { radius: [4.0, 3.0], tau: 3.0 }, |x, _| {
            let sinc = |x: f32| {
                if x == 0.0 { 1.0 } else { (std::f32::consts::PI * x).sin() / (std::f32::consts::PI * x) }
            };
            sinc(x) * sinc(x / 3.0)
        }),
        (Filter::Mitchell { radius: [2.0, 3.0], b: 1.0 / 3.0, c: 1.0 / 3.0 }, |x, radius| {
            let x = (2.0 * x / radius).abs();
            if x < 1.0 {
                (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0
            } else {
                (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0
            }
        }),
    ]
}

#[test]
fn every_kind_of_filter_has_a_row() {
    assert_eq!(
        filters().map(|(filter, _)| name(&filter)),
        ["box", "triangle", "gaussian", "sinc", "mitchell"]
    );
}

#[test]
fn filters_are_sampled_by_their_magnitude() {
    for (filter, curve) in filters() {
        let sampler = PixelFilter::new(&filter);
        let radius = sampler.radius();
        let axis_sum = |radius: f32, value: &dyn Fn(f32) -> f32| -> f32 {
            let n = 20_000;
            let center = |i: u16| radius * ((2.0 * f32::from(i) + 1.0) / f32::from(n) - 1.0);
            (0..n).map(|i| f64::from(value(curve(center(i), radius)))).sum::<f64>() as f32 / f32::from(n)
        };
        let magnitude = axis_sum(radius.x, &f32::abs) * axis_sum(radius.y, &f32::abs);
        // Points of the unit square stand for offsets; the density follows |f|.
        let pdf = |p: Vec2| {
            let offset = (p * 2.0 - Vec2::ONE).zip(radius, |x, r| x * r);
            (curve(offset.x, radius.x) * curve(offset.y, radius.y)).abs() / magnitude
        };
        let sample = |u: [f32; 2]| {
            let offset = sampler.sample(u.into()).offset;
            Some(offset.zip(radius, |x, r| 0.5 * (x / r + 1.0)))
        };
        let test = SquareTest { samples: SAMPLES, tests: TESTS, ..SquareTest::default() };
        test.run(sample, pdf).unwrap_or_else(|e| panic!("{}: {e}", name(&filter)));
        // The weight is the sign times the ratio of the integrals.
        let signed = axis_sum(radius.x, &|x| x) * axis_sum(radius.y, &|x| x);
        let mut rng = Rng::new(4);
        for _ in 0..2000 {
            let sample = sampler.sample(rng.uniform().into());
            let f = curve(sample.offset.x, radius.x) * curve(sample.offset.y, radius.y);
            assert!((sample.weight.abs() - magnitude / signed).abs() < 1e-3, "{}: {sample:?}", name(&filter));
            // Within a cell of a zero the sign may be either.
            assert!(f.signum() == sample.weight.signum() || f.abs() < 1e-2, "{}: {sample:?}", name(&filter));
        }
    }
}
