use super::*;

/// A generator of standard normal numbers with a fixed seed: SplitMix64 and Box-Muller.
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 * 2.0_f64.powi(-53)
    }

    fn next(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

const SIZE: usize = 128;
const NOISE: f64 = 0.1;

/// An image of 0.5 with noise, plus `bias(x, y)`.
fn noisy(seed: u64, bias: impl Fn(usize, usize) -> f64) -> Image {
    // Seeds of SplitMix64 are positions in one sequence: spread them out.
    let mut normal = Normal(seed.wrapping_mul(0xd134_2543_de82_ef95));
    let mut values = Vec::with_capacity(SIZE * SIZE * 3);
    for y in 0..SIZE {
        for x in 0..SIZE {
            values.extend([0, 1, 2].map(|_| (0.5 + bias(x, y) + NOISE * normal.next()) as f32));
        }
    }
    Image::rgb_f32(SIZE, SIZE, values).unwrap()
}

fn exact() -> Image {
    Image::filled(SIZE, SIZE, 3, 0.5).unwrap()
}

fn noise_variance() -> Image {
    Image::filled(SIZE, SIZE, 3, (NOISE * NOISE) as f32).unwrap()
}

#[test]
fn unbiased_tests_pass() {
    let tests = [1, 2, 3, 4].map(|seed| noisy(seed, |_, _| 0.0));
    let found = z_test(&tests, &exact(), &ZTestOptions::default()).unwrap();
    let figures = &found.figures;
    assert!(!figures.biased, "{figures:?}");
    assert!((figures.z_rms - 1.0).abs() < 0.2 && figures.z_max < 5.0, "{figures:?}");
    assert!((found.pixel_correlation - 1.0).abs() < 0.2, "{}", found.pixel_correlation);
    assert_eq!((found.tests, figures.tiles, found.tile_z.width), (4, 64, 8));
    // With variances known, pixel deviates are standard normal.
    let variances = [1, 2, 3, 4].map(|_| noise_variance());
    let options = ZTestOptions { test_variances: Some(&variances), ..ZTestOptions::default() };
    let found = z_test(&tests, &exact(), &options).unwrap();
    let crate::Pixels::F32(deviates) = &found.pixel_z.pixels else { panic!("floats") };
    let square = deviates.iter().map(|z| f64::from(z * z)).sum::<f64>() / deviates.len() as f64;
    // 49152 squares of variance 2: six standard errors are 0.038.
    assert!((square - 1.0).abs() < 0.038, "{square}");
    assert!(!found.figures.biased);
}

#[test]
fn one_image_with_its_variance_is_enough() {
    let variances = [noise_variance()];
    let options = ZTestOptions { test_variances: Some(&variances), ..ZTestOptions::default() };
    let fair = z_test(&[noisy(5, |_, _| 0.0)], &exact(), &options).unwrap();
    assert!(!fair.figures.biased, "{:?}", fair.figures);
    let biased = z_test(&[noisy(5, |_, _| 0.01)], &exact(), &options).unwrap();
    assert!(biased.figures.biased && biased.figures.p_global < 1e-4);
    assert!((biased.figures.relative_mean_difference - 0.02).abs() < 0.003);
}

#[test]
fn noise_of_the_reference_counts() {
    let tests = [1, 2, 3, 4].map(|seed| noisy(seed, |_, _| 0.0));
    let reference = noisy(99, |_, _| 0.0);
    let variance = noise_variance();
    let known = ZTestOptions { reference_variance: Some(&variance), ..ZTestOptions::default() };
    assert!(!z_test(&tests, &reference, &known).unwrap().figures.biased);
    assert!(z_test(&tests, &reference, &ZTestOptions::default()).unwrap().figures.biased);
}

#[test]
fn each_kind_of_bias_is_found_by_its_figure() {
    let run = |bias: fn(usize, usize) -> f64| {
        let tests = [1, 2, 3, 4].map(|seed| noisy(seed, bias));
        z_test(&tests, &exact(), &ZTestOptions::default()).unwrap().figures
    };
    // 1 % everywhere: hidden in each pixel and tile, plain in the mean.
    let overall = run(|_, _| 0.005);
    assert!(overall.biased && overall.p_global < 1e-4);
    // One tile of 64.
    let local = run(|x, y| if x < 16 && y < 16 { 0.03 } else { 0.0 });
    assert!(local.biased && local.p_max < 1e-4, "{local:?}");
    // Half the tiles up, half down: the mean is right.
    let checkered = run(|x, y| if (x / 16 + y / 16) % 2 == 0 { 0.008 } else { -0.008 });
    assert!(checkered.biased && checkered.p_rms < 1e-4 && checkered.p_global > 1e-4, "{checkered:?}");
}

#[test]
fn neighbours_that_vary_together_do_not_trip_the_test() {
    // Pairs of pixels share their noise, as after a wide reconstruction filter.
    let pairs = |seed| {
        let image = noisy(seed, |_, _| 0.0);
        let twice = (0..SIZE * SIZE).flat_map(|index| {
            let pixel = image.pixel((index % SIZE) & !1, index / SIZE);
            [pixel[0], pixel[1], pixel[2]]
        });
        Image::rgb_f32(SIZE, SIZE, twice.collect()).unwrap()
    };
    let found = z_test(&[1, 2, 3, 4].map(pairs), &exact(), &ZTestOptions::default()).unwrap();
    assert!((found.pixel_correlation - 2.0).abs() < 0.4, "{}", found.pixel_correlation);
    assert!(!found.figures.biased);
}

#[test]
fn a_difference_without_noise_is_a_bias() {
    let constant = |value| Image::filled(32, 16, 3, value).unwrap();
    let same = z_test(&[constant(0.5), constant(0.5)], &constant(0.5), &ZTestOptions::default()).unwrap();
    assert!(!same.figures.biased && same.figures.z_rms == 0.0);
    let other = z_test(&[constant(0.5), constant(0.5)], &constant(0.6), &ZTestOptions::default()).unwrap();
    assert!(other.figures.biased);
    assert_eq!(other.figures.different_without_noise, 6);
    assert_eq!(other.tile_z.texel(0, 0, 0), f32::NEG_INFINITY);
}

#[test]
fn unusable_requests_are_refused() {
    let message = |tests: &[Image], options: &ZTestOptions<'_>| {
        z_test(tests, &exact(), options).unwrap_err().to_string()
    };
    let default = ZTestOptions::default();
    assert_eq!(message(&[], &default), "the z-test needs a test image");
    let needs_more = "the z-test needs two or more test images, or a variance image";
    assert_eq!(message(&[exact()], &default), needs_more);
    let variances = [noise_variance()];
    let options = ZTestOptions { test_variances: Some(&variances), ..default };
    assert!(message(&[exact(), exact()], &options).contains("found 1 for 2"));
    let options = ZTestOptions { tile: 200, ..default };
    assert!(message(&[exact(), exact()], &options).contains("does not fit"));
    let small = [Image::filled(1, 1, 3, 0.0).unwrap()];
    assert!(message(&small, &default).contains("different size"));
}
