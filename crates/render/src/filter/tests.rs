//! Shapes and normalisation; the sampling is tested by the statistical tests of the crate.

use sahl_scene::Filter;

use super::*;

#[test]
fn mitchell_is_continuous_and_sums_to_one() {
    let third = 1.0 / 3.0;
    assert!((mitchell(1.0 - 1e-6, third, third) - mitchell(1.0, third, third)).abs() < 1e-5);
    assert!(mitchell(2.0 - 1e-4, third, third).abs() < 1e-6 && mitchell(2.5, third, third) == 0.0);
    assert!(mitchell(1.5, third, third) < 0.0);
    // Filters of this family sum to one over the integers, wherever they stand.
    for offset in [0.0, 0.25, 0.7] {
        let sum: f32 = (-3..=3).map(|i| mitchell(i as f32 + offset, third, third)).sum();
        assert!((sum - 1.0).abs() < 1e-5, "{offset}: {sum}");
    }
}

#[test]
fn weights_have_mean_one() {
    for filter in [
        Filter::Box { radius: [0.5, 0.5] },
        Filter::Triangle { radius: [2.0, 1.0] },
        Filter::default(),
        Filter::Mitchell { radius: [2.0, 2.0], b: 1.0 / 3.0, c: 1.0 / 3.0 },
        Filter::Mitchell { radius: [1.0, 3.0], b: 0.0, c: 1.0 },
        Filter::Sinc { radius: [4.0, 3.0], tau: 3.0 },
    ] {
        let sampler = PixelFilter::new(&filter);
        let n = 512;
        let mut sum = 0.0_f64;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let sample = sampler.sample(u);
            assert!(
                sample.offset.x.abs() <= sampler.radius().x && sample.offset.y.abs() <= sampler.radius().y
            );
            sum += f64::from(sample.weight);
        }
        assert!((sum / f64::from(n * n) - 1.0).abs() < 0.02, "{filter:?}: {}", sum / f64::from(n * n));
    }
}

#[test]
fn nonsense_becomes_a_point_or_a_box() {
    for filter in [
        Filter::Box { radius: [f32::NAN, -1.0] },
        Filter::Gaussian { radius: [0.0, f32::INFINITY], sigma: 0.5 },
        Filter::Mitchell { radius: [0.0, 0.0], b: f32::NAN, c: 0.0 },
    ] {
        let sample = PixelFilter::new(&filter).sample(Vec2::new(0.3, 0.9));
        assert_eq!(sample.offset, Vec2::ZERO, "{filter:?}");
        assert_eq!(sample.weight, 1.0);
    }
    let flat = PixelFilter::new(&Filter::Gaussian { radius: [1.0, 1.0], sigma: 0.0 });
    assert_eq!(flat.sample(Vec2::new(0.75, 0.5)).weight, 1.0);
}
