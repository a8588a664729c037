//! What an `illuminance` makes of the image of an infinite light.
//!
//! pbrt-v4 divides by a sum over the upper half of the image that is not the illuminance of its sky: directions count half
//! their solid angle, and the weights of red, green and blue are given to the channels in the order of the file, which in
//! EXR files is that of their names: blue, green, red. A sky is about twice as bright as its `illuminance` says. Scenes are
//! lit by what they were seen with, so that the sum is done here as it is there, and `illuminance` is left to
//! descriptions that mean it. In a scene file: `LightSource "infinite" "string filename" "sky.exr" "float illuminance" 1000`.

use std::f64::consts::PI;

use sahl_image::Image;

/// The factor on the radiance of the square equal-area image in the file called `name` that makes its `illuminance` what
/// pbrt-v4 makes it; zero for a sky that is black above.
pub(super) fn illuminance_factor(image: &Image, name: &str, illuminance: f32) -> f32 {
    let factor = f64::from(illuminance) / upper_sum(image, channel_order(image, name));
    if factor.is_finite() { factor.max(0.0) as f32 } else { 0.0 }
}

/// Which channels of a pixel in RGBA stand first, second and third in the file.
fn channel_order(image: &Image, name: &str) -> [usize; 3] {
    let is_exr = name.rsplit_once('.').is_some_and(|(_, extension)| extension.eq_ignore_ascii_case("exr"));
    match (is_exr, image.has_alpha()) {
        (false, _) => [0, 1, 2],
        (true, false) => [2, 1, 0],
        (true, true) => [3, 2, 1],
    }
}

/// 2π times the mean over the image of what its pixels above the horizon weigh.
fn upper_sum(image: &Image, order: [usize; 3]) -> f64 {
    let space = image.color_space;
    let mut sum = 0.0;
    for y in 0..image.height {
        for x in 0..image.width {
            let place = |i: usize, size: usize| (2 * i + 1) as f64 / size as f64 - 1.0;
            let height = octahedral_height(place(x, image.width), place(y, image.height));
            if height > 0.0 {
                let pixel = image.pixel(x, y);
                sum += height * f64::from(space.luminance(order.map(|channel| pixel[channel])));
            }
        }
    }
    2.0 * PI * sum / (image.width * image.height) as f64
}

/// The z of the direction at (x, y) in [−1, 1]² of an equal-area octahedral map.
///
/// Source: Clarberg, *Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD*, Journal of Graphics Tools 13(3), 2008.
fn octahedral_height(x: f64, y: f64) -> f64 {
    let from_horizon = 1.0 - (x.abs() + y.abs());
    let r = 1.0 - from_horizon.abs();
    (1.0 - r * r).copysign(from_horizon)
}

#[cfg(test)]
mod tests {
    use sahl_image::ColorSpace;

    use super::*;

    #[test]
    fn heights_are_spread_evenly() {
        // As over a sphere: each tenth of the height has a tenth of the area.
        const N: i32 = 400;
        let mut counts = [0; 10];
        for i in 0..N * N {
            let place = |i: i32| f64::from(2 * i + 1) / f64::from(N) - 1.0;
            let z = octahedral_height(place(i % N), place(i / N));
            counts[((z + 1.0) * 5.0) as usize] += 1;
        }
        assert!(counts.iter().all(|&count: &i32| (count - N * N / 10).abs() < N * N / 200), "{counts:?}");
        assert_eq!(octahedral_height(0.0, 0.0), 1.0);
        assert_eq!(octahedral_height(-1.0, 1.0), -1.0);
    }

    #[test]
    fn a_white_sky_becomes_twice_as_bright_as_asked() {
        let white = Image::filled(64, 64, 3, 1.0).unwrap();
        for name in ["a.pfm", "a.EXR", "a"] {
            let factor = illuminance_factor(&white, name, 5.0);
            assert!((f64::from(factor) - 2.0 * 5.0 / PI).abs() < 0.01, "{name} {factor}");
        }
    }

    #[test]
    fn channels_count_in_the_order_of_the_file() {
        let blue: Vec<f32> = [0.0, 0.0, 1.0].repeat(16 * 16);
        let sky = |space| Image::rgb_f32(16, 16, blue.clone()).unwrap().with_color_space(space);
        let ratio = |image: &Image| {
            illuminance_factor(image, "sky.pfm", 1.0) / illuminance_factor(image, "sky.exr", 1.0)
        };
        assert!((ratio(&sky(ColorSpace::Srgb)) - 0.2126 / 0.0722).abs() < 1e-2);
        // The weight of ACES's blue is negative: such a sky has no illuminance, and pbrt's would be less than black.
        assert_eq!(illuminance_factor(&sky(ColorSpace::Aces2065_1), "sky.pfm", 1.0), 0.0);
        assert!(illuminance_factor(&sky(ColorSpace::Aces2065_1), "sky.exr", 1.0) > 0.0);
    }

    #[test]
    fn a_sky_that_is_black_above_stays_black() {
        assert_eq!(illuminance_factor(&Image::filled(8, 8, 3, 0.0).unwrap(), "a.pfm", 1.0), 0.0);
    }
}
