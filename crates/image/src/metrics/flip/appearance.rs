//! The colour spaces of FLIP: an opponent space to filter in, and one to measure differences in.

/// Linear sRGB to XYZ, as the authors of FLIP round it: exact for D65 with the chromaticities of the standard.
const TO_XYZ: [[f32; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// The inverse of [`TO_XYZ`].
const FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_2, -1.537_399, -0.498_615_9],
    [-0.969_224_3, 1.875_93, 0.041_554_226],
    [0.055_639_42, -0.204_011_21, 1.057_149],
];

/// XYZ of white: the rows of [`TO_XYZ`] added up.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

fn multiply(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn divide(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] / b[0], a[1] / b[1], a[2] / b[2]]
}

/// YCxCz of linear sRGB in 0 to 1: like CIE L*a*b*, but linear.
///
/// Source: Flohr, Kolpatzik, Balasubramanian, Carrara, Bouman, Allebach 1993, *Model-based color image quantization*.
pub(super) fn opponent_from_rgb(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = divide(multiply(&TO_XYZ, rgb), WHITE);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// CIE L*a*b* with the Hunt effect of a filtered YCxCz colour, which is first clipped to the gamut of the display.
pub(super) fn perceived_from_opponent([luma, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (luma + 16.0) / 116.0;
    let xyz = [(y + cx / 500.0) * WHITE[0], y * WHITE[1], (y - cz / 200.0) * WHITE[2]];
    perceived_from_rgb(multiply(&FROM_XYZ, xyz).map(|value| value.clamp(0.0, 1.0)))
}

/// CIE L*a*b* with the Hunt effect: colours look less colourful where they are dark.
///
/// Source: Hunt 1952, *Light and dark adaptation and the perception of color*, as FLIP models it.
fn perceived_from_rgb(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = divide(multiply(&TO_XYZ, rgb), WHITE).map(|value| {
        if value > DELTA.powi(3) { value.cbrt() } else { value / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    });
    let lightness = 116.0 * y - 16.0;
    let strength = 0.01 * lightness;
    [lightness, strength * 500.0 * (x - y), strength * 200.0 * (y - z)]
}

/// HyAB: city-block in lightness, Euclidean in chroma.
///
/// Source: Abasi, Tehran, Fairchild 2020, *Distance metrics for very large color differences*.
pub(super) fn difference(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// The difference between green and blue, the largest within the gamut.
pub(super) fn largest_difference() -> f32 {
    difference(perceived_from_rgb([0.0, 1.0, 0.0]), perceived_from_rgb([0.0, 0.0, 1.0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_constants_belong_together() {
        let white = multiply(&TO_XYZ, [1.0; 3]);
        for (found, expected) in white.iter().zip(WHITE) {
            assert!((found - expected).abs() < 2e-7, "{white:?}");
        }
        for primary in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let back = multiply(&FROM_XYZ, multiply(&TO_XYZ, primary));
            for (found, expected) in back.iter().zip(primary) {
                assert!((found - expected).abs() < 1e-6, "{back:?}");
            }
        }
    }

    #[test]
    fn filtering_nothing_changes_no_colour() {
        for rgb in [[0.2, 0.5, 0.9], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.7, 0.01, 0.3]] {
            let there = perceived_from_opponent(opponent_from_rgb(rgb));
            assert!(difference(there, perceived_from_rgb(rgb)) < 0.02);
        }
        // Greys have lightness alone.
        let grey = perceived_from_rgb([0.5; 3]);
        assert!(grey[1].abs() < 1e-3 && grey[2].abs() < 1e-3);
    }
}
