use std::f64::consts::TAU;

use super::*;

fn sampler(kind: SamplerKind, samples: u32, seed: u64) -> Sampler {
    Sampler::new(&sahl_scene::Sampler { kind, samples, seed }, [64, 64])
}

fn points(sampler: &mut Sampler, pixel: [u32; 2], samples: u32, dimension: u32) -> Vec<Vec2> {
    let point = |index| {
        sampler.start(pixel, index, dimension);
        sampler.next_2d()
    };
    (0..samples).map(point).collect()
}

/// Whether each box of the unit square cut into 2^a × 2^(k − a), for every a, holds one of 2^k points.
fn is_net(points: &[Vec2]) -> bool {
    let k = points.len().trailing_zeros();
    (0..=k).all(|a| {
        let (columns, rows) = (1_usize << a, 1_usize << (k - a));
        let mut taken = vec![false; points.len()];
        points.iter().all(|p| {
            let (column, row) = ((p.x * columns as f32) as usize, (p.y * rows as f32) as usize);
            !std::mem::replace(&mut taken[row * columns + column], true)
        })
    })
}

#[test]
fn every_power_of_two_is_a_net() {
    for (samples, seed) in [(1, 0), (2, 1), (8, 7), (64, 2), (100, 3), (128, u64::MAX), (1024, 5)] {
        let mut sampler = sampler(SamplerKind::Sobol, samples, seed);
        for pixel in [[0, 0], [63, 1], [17, 42], [5000, 70_000]] {
            for dimension in [0, 1, 2, 7, 40] {
                let points = points(&mut sampler, pixel, samples, dimension);
                for k in 0..=samples.ilog2() {
                    assert!(is_net(&points[..1 << k]), "{samples} {seed} {pixel:?} {dimension} {k}");
                }
            }
        }
    }
}

#[test]
fn one_dimension_is_stratified() {
    let mut sampler = sampler(SamplerKind::Sobol, 64, 3);
    for dimension in 0..32 {
        let mut strata: Vec<u32> = (0..64)
            .map(|index| {
                sampler.start([9, 4], index, dimension);
                (sampler.next_1d() * 64.0) as u32
            })
            .collect();
        strata.sort_unstable();
        assert!(strata.iter().copied().eq(0..64), "{dimension}");
    }
}

#[test]
fn squares_of_pixels_are_nets_together() {
    let mut sampler = sampler(SamplerKind::Sobol, 4, 11);
    for dimension in [0, 2, 8] {
        for size in [2, 4, 16] {
            let all: Vec<Vec2> = (0..size * size)
                .flat_map(|i| points(&mut sampler, [32 + i % size, 16 + i / size], 4, dimension))
                .collect();
            assert!(is_net(&all), "{dimension} {size}");
        }
    }
}

#[test]
fn a_coordinate_depends_on_its_address_alone() {
    for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
        let (mut a, mut b) = (sampler(kind, 16, 1), sampler(kind, 16, 1));
        a.start([3, 4], 5, 0);
        let in_a_row = [a.pixel_2d(), a.next_2d(), Vec2::new(a.next_1d(), a.next_1d()), a.next_2d()];
        b.start([60, 2], 9, 3);
        b.next_2d();
        b.start([3, 4], 5, 6);
        assert_eq!(b.next_2d(), in_a_row[3]);
        b.start([3, 4], 5, 2);
        assert_eq!(b.next_2d(), in_a_row[1]);
        assert_ne!(in_a_row[0], in_a_row[1]);
        b.start([4, 3], 5, 2);
        assert_ne!(b.next_2d(), in_a_row[1]);
    }
}

/// Mean, correlation of two columns, and the counts of an 8 × 8 histogram, compared with independent uniform numbers.
fn assert_independent(pairs: &[(f32, f32)], what: &str) {
    let n = pairs.len() as f64;
    let mut bins = [0.0_f64; 64];
    let (mut sum, mut product) = (0.0, 0.0);
    for &(x, y) in pairs {
        assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y));
        bins[(x * 8.0) as usize * 8 + (y * 8.0) as usize] += 1.0;
        sum += f64::from(x) - 0.5;
        product += (f64::from(x) - 0.5) * (f64::from(y) - 0.5);
    }
    let chi2: f64 = bins.iter().map(|count| (count - n / 64.0).powi(2) / (n / 64.0)).sum();
    // Five standard deviations; 63 degrees of freedom.
    assert!(chi2 < 63.0 + 5.0 * (2.0_f64 * 63.0).sqrt(), "{what}: chi2 {chi2}");
    assert!((sum / n).abs() < 5.0 / (12.0 * n).sqrt(), "{what}: mean {}", sum / n);
    assert!((product / n).abs() < 5.0 / (12.0 * n.sqrt()), "{what}: correlation {}", product / n);
}

#[test]
fn dimensions_and_seeds_are_independent() {
    for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
        let (mut a, mut b) = (sampler(kind, 16, 1), sampler(kind, 16, 2));
        for (first, second) in [(0, 2), (0, 4), (2, 4), (2, 3), (10, 12), (5, 50)] {
            let mut pairs = Vec::new();
            let mut seeds = Vec::new();
            for pixel in 0..1024 {
                for index in 0..16 {
                    let pixel = [pixel % 32, pixel / 32];
                    let at = |sampler: &mut Sampler, dimension| {
                        sampler.start(pixel, index, dimension);
                        sampler.next_2d()
                    };
                    let (p, q) = (at(&mut a, first), at(&mut a, second));
                    pairs.push((p.x, q.x));
                    pairs.push((p.y, q.y));
                    seeds.push((p.x, at(&mut b, first).x));
                }
            }
            assert_independent(&pairs, &format!("{kind:?} dimensions {first} and {second}"));
            assert_independent(&seeds, &format!("{kind:?} seeds, dimension {first}"));
        }
    }
}

#[test]
fn samples_beyond_the_declared_number_are_distributed_too() {
    let mut sampler = sampler(SamplerKind::Sobol, 16, 4);
    for pixel in [[1, 2], [100, 3]] {
        let all = points(&mut sampler, pixel, 48, 0);
        for run in all.chunks(16) {
            assert!(is_net(run));
        }
        assert!(all[..16].iter().all(|p| !all[16..].contains(p)));
    }
}

/// Root mean square error of the mean of `n` values of a smooth function, over pixels.
fn error(kind: SamplerKind, n: u32) -> f64 {
    let mut sampler = sampler(kind, n, 9);
    let pixels = 256;
    // The integral of sin(2 π x) over a quarter turn each way: (2 / π)² for the product below.
    let exact = (2.0 / std::f64::consts::PI).powi(2);
    let mut sum = 0.0;
    for pixel in 0..pixels {
        let points = points(&mut sampler, [pixel % 64, pixel / 64], n, 4);
        let value = |p: &Vec2| (TAU * 0.25 * f64::from(p.x)).sin() * (TAU * 0.25 * f64::from(p.y)).cos();
        let mean = points.iter().map(value).sum::<f64>() / f64::from(n);
        sum += (mean - exact).powi(2);
    }
    (sum / f64::from(pixels)).sqrt()
}

#[test]
fn errors_fall_as_promised() {
    let rate = |kind| (error(kind, 16) / error(kind, 1024)).log2() / 6.0;
    let (sobol, independent) = (rate(SamplerKind::Sobol), rate(SamplerKind::Independent));
    assert!(sobol > 1.35, "N^-{sobol}");
    assert!((independent - 0.5).abs() < 0.1, "N^-{independent}");
    // Far better for the same number, and no worse for one that is no power of two.
    assert!(error(SamplerKind::Sobol, 64) < 0.05 * error(SamplerKind::Independent, 64));
    assert!(error(SamplerKind::Sobol, 48) < 0.2 * error(SamplerKind::Independent, 48));
}

/// Mean power of an image's frequencies in bands of radius, lowest first, relative to the mean of all.
fn radial_power(image: &[f64], size: usize, bands: usize) -> Vec<f64> {
    let transform = |rows: &[[f64; 2]]| -> Vec<[f64; 2]> {
        let mut out = vec![[0.0; 2]; size * size];
        for row in 0..size {
            for frequency in 0..size {
                let mut sum = [0.0; 2];
                for x in 0..size {
                    let (sin, cos) = (-TAU * ((frequency * x) % size) as f64 / size as f64).sin_cos();
                    let [re, im] = rows[row * size + x];
                    sum = [sum[0] + re * cos - im * sin, sum[1] + re * sin + im * cos];
                }
                // Transposed, so that a second pass transforms the columns.
                out[frequency * size + row] = sum;
            }
        }
        out
    };
    let rows: Vec<[f64; 2]> = image.iter().map(|&value| [value, 0.0]).collect();
    let spectrum = transform(&transform(&rows));
    let mut power = vec![(0.0, 0.0); bands];
    let mut total = (0.0, 0.0);
    for (i, [re, im]) in spectrum.iter().enumerate().skip(1) {
        let distance = |f: usize| f.min(size - f) as f64;
        let radius = distance(i % size).hypot(distance(i / size));
        let band = ((radius / (size as f64 / 2.0) * bands as f64) as usize).min(bands - 1);
        let value = re * re + im * im;
        power[band] = (power[band].0 + value, power[band].1 + 1.0);
        total = (total.0 + value, total.1 + 1.0);
    }
    power.iter().map(|(sum, count)| sum / count / (total.0 / total.1)).collect()
}

#[test]
fn the_error_of_an_image_is_blue_noise() {
    let size = 64;
    let spectrum = |kind, samples: u32, dimension| {
        let mut mean = [0.0; 8];
        for seed in 0..4 {
            let mut sampler = sampler(kind, samples, seed);
            let image: Vec<f64> = (0..size * size)
                .map(|i| {
                    let points =
                        points(&mut sampler, [(i % size) as u32, (i / size) as u32], samples, dimension);
                    // An edge across the square: what a shadow's border looks like to a pixel.
                    let inside = points.iter().filter(|p| p.x + 0.6 * p.y < 0.7).count();
                    inside as f64 / f64::from(samples)
                })
                .collect();
            for (mean, band) in mean.iter_mut().zip(radial_power(&image, size, 8)) {
                *mean += 0.25 * band;
            }
        }
        mean
    };
    for (samples, dimension) in [(1, 0), (4, 2), (8, 6), (16, 4)] {
        let blue = spectrum(SamplerKind::Sobol, samples, dimension);
        // Random permutations of every digit, without hashing, give 0.16 to 0.24 and 0.39 to 0.53 in these bands.
        assert!(blue[0] < 0.3 && blue[1] < 0.6, "{samples} samples: {blue:?}");
        assert!(blue[6] > 1.0 && blue[7] > 1.0, "{samples} samples: {blue:?}");
    }
    let white = spectrum(SamplerKind::Independent, 4, 2);
    assert!(white.iter().all(|band| (0.6..1.4).contains(band)), "{white:?}");
}
