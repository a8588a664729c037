//! What an image shows between its pixels and around them.
//!
//! Filters over the footprint of a pixel choose among the levels of a pyramid. Source: Williams, *Pyramidal Parametrics*,
//! SIGGRAPH 1983 (trilinear); Heckbert, *Fundamentals of Texture Mapping and Image Warping*, 1989 (elliptical weighted
//! average), with the Gaussian e^(−2r²) − e^(−2) and the choice of levels of Pharr, Jakob, Humphreys, *Physically Based
//! Rendering*, 4th ed., 2023, section 10.4. Deviations: footprints are measured in pixels of the image along each axis, so
//! that images that are not square are filtered alike along both; the trilinear filter blends the first two levels too;
//! the nearest and bilinear filters read the full image, and leave smoothing to the samples of the pixel.

use sahl_image::Image;
use sahl_math::{Vec2, safe_sqrt};
use sahl_scene::{ImageTexture, Wrap};

use super::mapping::Differentials;

/// Half the side of a square as large as the largest box about an ellipse: of a short half axis below two pixels.
const MOST_REACH: f32 = 2.0 * ImageTexture::MOST_ANISOTROPY + 2.0;

/// One level of an image, and how to read its pixels.
pub(super) struct Level<'a, F> {
    pub(super) image: &'a Image,
    pub(super) wrap: Wrap,
    /// What is filtered, of the pixel whose first channel has this place in the storage.
    pub(super) texel: F,
}

impl<const N: usize, F: Fn(usize) -> [f32; N]> Level<'_, F> {
    /// Width and height.
    fn size(&self) -> Vec2 {
        Vec2::new(self.image.width as f32, self.image.height as f32)
    }

    /// What is shown at pixel (x, y), which may lie outside.
    fn at(&self, x: i64, y: i64) -> [f32; N] {
        match wrap([x, y], [self.image.width, self.image.height], self.wrap) {
            Some([x, y]) => (self.texel)(self.image.index(x, y)),
            None => [0.0; N],
        }
    }

    /// The pixel at `place`, in units of the image from its upper left corner.
    pub(super) fn nearest(&self, place: Vec2) -> [f32; N] {
        let p = place * self.size();
        self.at(p.x.floor() as i64, p.y.floor() as i64)
    }

    /// Linear interpolation between the centres of four pixels about `place`.
    pub(super) fn bilinear(&self, place: Vec2) -> [f32; N] {
        let p = place * self.size() - Vec2::splat(0.5);
        let corner = p.map(f32::floor);
        let d = p - corner;
        let (x0, y0) = (corner.x as i64, corner.y as i64);
        let (x1, y1) = (x0.saturating_add(1), y0.saturating_add(1));
        let (v00, v10, v01, v11) = (self.at(x0, y0), self.at(x1, y0), self.at(x0, y1), self.at(x1, y1));
        std::array::from_fn(|i| {
            (1.0 - d.y) * ((1.0 - d.x) * v00[i] + d.x * v10[i]) + d.y * ((1.0 - d.x) * v01[i] + d.x * v11[i])
        })
    }

    /// The only pixel of the last level.
    fn mean(&self) -> [f32; N] {
        self.at(0, 0)
    }

    /// The Gaussian mean about `place` over the ellipse with half axes `axes`, in units of the image, widened by a pixel;
    /// `None` if that would take too many pixels.
    fn gaussian(&self, place: Vec2, axes: [Vec2; 2]) -> Option<[f32; N]> {
        let center = place * self.size() - Vec2::splat(0.5);
        let ellipse = Ellipse::new(axes.map(|axis| axis * self.size()));
        let reach = ellipse.half_extent();
        let pixels = reach.x * reach.y;
        if pixels.is_nan() || pixels > MOST_REACH * MOST_REACH {
            return None;
        }
        let (low, high) = ((center - reach).map(f32::ceil), (center + reach).map(f32::floor));
        let (mut sum, mut weights) = ([0.0; N], 0.0);
        for y in low.y as i64..=high.y as i64 {
            for x in low.x as i64..=high.x as i64 {
                let r2 = ellipse.squared_radius(Vec2::new(x as f32, y as f32) - center);
                if r2 < 1.0 {
                    let weight = (-2.0 * r2).exp() - (-2.0_f32).exp();
                    let value = self.at(x, y);
                    for (sum, value) in sum.iter_mut().zip(value) {
                        *sum += weight * value;
                    }
                    weights += weight;
                }
            }
        }
        // Far from the origin floats have no fractions, and the ellipse may miss every pixel.
        Some(if weights > 0.0 { sum.map(|sum| sum / weights) } else { self.bilinear(place) })
    }
}

/// The mean over a square about as large as the footprint.
pub(super) fn trilinear<'a, const N: usize, F: Fn(usize) -> [f32; N]>(
    level: &impl Fn(usize) -> Level<'a, F>,
    levels: usize,
    place: Vec2,
    differentials: &Differentials,
) -> [f32; N] {
    let extent = (differentials.dx.abs().max(differentials.dy.abs())) * level(0).size();
    // A pixel of level i is 2^i pixels wide; the square reaches as far to either side as the next pixel of the picture.
    let number = (2.0 * extent.x.max(extent.y)).log2();
    let last = levels - 1;
    blend(number, last, |number| level(number).bilinear(place)).unwrap_or_else(|| level(last).mean())
}

/// The Gaussian mean over the ellipse that is the footprint.
pub(super) fn ewa<'a, const N: usize, F: Fn(usize) -> [f32; N]>(
    level: &impl Fn(usize) -> Level<'a, F>,
    levels: usize,
    place: Vec2,
    differentials: &Differentials,
    max_anisotropy: f32,
) -> [f32; N] {
    let size = level(0).size();
    let (mut long, mut short) = (differentials.dx, differentials.dy);
    let length = |axis: Vec2| (axis * size).length();
    if length(long) < length(short) {
        (long, short) = (short, long);
    }
    let (long_length, short_length) = (length(long), length(short));
    if long_length == 0.0 {
        return level(0).bilinear(place);
    }
    let least = long_length / max_anisotropy;
    if short_length < least {
        // Without a direction of its own it goes across the other.
        let across = Vec2::new(-long.y * size.y / size.x, long.x * size.x / size.y);
        short = if short_length > 0.0 { short * (least / short_length) } else { across / max_anisotropy };
    }
    let number = short_length.max(least).log2();
    let last = levels - 1;
    // Levels of images that are not square shrink along one axis only in the end: the ellipse may need a higher one.
    let value = |number: usize| {
        let fitting = (number..last).find_map(|number| level(number).gaussian(place, [long, short]));
        fitting.unwrap_or_else(|| level(last).mean())
    };
    blend(number, last, value).unwrap_or_else(|| level(last).mean())
}

/// The value at level `number`, a fraction, between those of the two levels about it; `None` from the last level on.
fn blend<const N: usize>(number: f32, last: usize, value: impl Fn(usize) -> [f32; N]) -> Option<[f32; N]> {
    // NaN and all below zero: the image itself.
    let number = number.max(0.0);
    if number >= last as f32 {
        return None;
    }
    let lower = number.floor();
    let t = number - lower;
    let (a, b) = (value(lower as usize), value(lower as usize + 1));
    Some(std::array::from_fn(|i| (1.0 - t) * a[i] + t * b[i]))
}

/// The points d with A dx² + B dx dy + C dy² < 1, in pixels.
struct Ellipse {
    a: f32,
    b: f32,
    c: f32,
}

impl Ellipse {
    /// With the given half axes, which need not be perpendicular: the image of the unit disk. Widened by a pixel, so that
    /// it never falls between pixels (Heckbert 1989, section 3.5.8).
    fn new([u, v]: [Vec2; 2]) -> Self {
        let a = u.y * u.y + v.y * v.y + 1.0;
        let b = -2.0 * (u.x * u.y + v.x * v.y);
        let c = u.x * u.x + v.x * v.x + 1.0;
        let scale = 1.0 / (a * c - 0.25 * b * b);
        Self { a: a * scale, b: b * scale, c: c * scale }
    }

    fn squared_radius(&self, d: Vec2) -> f32 {
        self.a * d.x * d.x + self.b * d.x * d.y + self.c * d.y * d.y
    }

    /// Half the size of the box about it.
    fn half_extent(&self) -> Vec2 {
        let determinant = 4.0 * self.a * self.c - self.b * self.b;
        Vec2::new(2.0 * safe_sqrt(determinant * self.c), 2.0 * safe_sqrt(determinant * self.a)) / determinant
    }
}

/// The pixel shown at (x, y) in an image of the given size; `None` where nothing is.
fn wrap([x, y]: [i64; 2], [width, height]: [usize; 2], wrap: Wrap) -> Option<[usize; 2]> {
    let size = [width as i64, height as i64];
    if (0..size[0]).contains(&x) && (0..size[1]).contains(&y) {
        return Some([x as usize, y as usize]);
    }
    let place = match wrap {
        Wrap::Repeat => [x.rem_euclid(size[0]), y.rem_euclid(size[1])],
        Wrap::Clamp => [x.clamp(0, size[0] - 1), y.clamp(0, size[1] - 1)],
        Wrap::Black => return None,
        Wrap::OctahedralSphere => {
            // Crossing a border leads back into the image, the border read in the other direction.
            let (x, flips_y) = reflected(x, size[0]);
            let y = if flips_y { size[1] - 1 - y.rem_euclid(2 * size[1]) } else { y };
            let (y, flips_x) = reflected(y, size[1]);
            [if flips_x { size[0] - 1 - x } else { x }, y]
        }
    };
    Some(place.map(|coordinate| coordinate as usize))
}

/// The place inside `0..size` to which mirrors at both ends lead, and whether their number is odd.
fn reflected(i: i64, size: i64) -> (i64, bool) {
    let place = i.rem_euclid(2 * size);
    if place < size { (place, false) } else { (2 * size - 1 - place, true) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::pyramid;
    use std::sync::Arc;

    /// A grey ramp, and a checkerboard of single pixels.
    fn ramp(size: usize) -> Image {
        let values = (0..size * size).map(|i| (i % size) as f32 / size as f32).collect();
        Image::y_f32(size, size, values).unwrap()
    }

    fn level<'a>(image: &'a Image, wrap: Wrap) -> Level<'a, impl Fn(usize) -> [f32; 1]> {
        Level { image, wrap, texel: |index| [image_value(image, index)] }
    }

    fn image_value(image: &Image, index: usize) -> f32 {
        image.texel(index % image.width, index / image.width, 0)
    }

    fn differentials(dx: [f32; 2], dy: [f32; 2]) -> Differentials {
        Differentials { dx: dx.into(), dy: dy.into() }
    }

    /// Both filters over a pyramid of `image`.
    fn filtered(image: Image, wrap: Wrap, place: Vec2, footprint: &Differentials) -> [f32; 2] {
        let levels = pyramid::levels(&Arc::new(image));
        let level = |number: usize| level(&levels[number], wrap);
        let [a] = trilinear(&level, levels.len(), place, footprint);
        let [b] = ewa(&level, levels.len(), place, footprint, 8.0);
        [a, b]
    }

    #[test]
    fn without_a_footprint_both_filters_interpolate() {
        let place = Vec2::new(0.37, 0.61);
        let [expected] = level(&ramp(16), Wrap::Clamp).bilinear(place);
        let none = differentials([0.0; 2], [0.0; 2]);
        assert_eq!(filtered(ramp(16), Wrap::Clamp, place, &none), [expected; 2]);
    }

    #[test]
    fn a_wide_footprint_sees_the_mean() {
        let place = Vec2::new(0.2, 0.9);
        for wide in [differentials([2.0, 0.0], [0.0, 2.0]), differentials([1e8, 0.0], [0.0, 1e8])] {
            for found in filtered(ramp(16), Wrap::Repeat, place, &wide) {
                assert!((found - 15.0 / 32.0).abs() < 1e-5, "{found}");
            }
        }
    }

    #[test]
    fn a_ramp_stays_a_ramp_under_any_footprint() {
        let place = Vec2::new(0.5, 0.5);
        for footprint in [
            differentials([0.04, 0.0], [0.0, 0.04]),
            differentials([0.03, 0.02], [-0.01, 0.03]),
            differentials([0.0, 0.05], [0.01, 0.0]),
        ] {
            for found in filtered(ramp(64), Wrap::Clamp, place, &footprint) {
                assert!((found - (0.5 - 0.5 / 64.0)).abs() < 4e-3, "{footprint:?} {found}");
            }
        }
    }

    #[test]
    fn the_ellipse_is_long_where_the_footprint_is() {
        // Columns alternate: a footprint along them sees a column, one across them their mean.
        let stripes = || Image::y_f32(64, 64, (0..64 * 64).map(|i| (i / 4 % 2) as f32).collect()).unwrap();
        let place = Vec2::new(6.0 / 64.0, 0.5);
        let [_, along] = filtered(stripes(), Wrap::Repeat, place, &differentials([0.0, 0.1], [0.013, 0.0]));
        let [square, across] =
            filtered(stripes(), Wrap::Repeat, place, &differentials([0.1, 0.0], [0.0, 0.013]));
        assert!(along > 0.9 && (across - 0.5).abs() < 0.1 && (square - 0.5).abs() < 0.05, "{along} {across}");
        // Without a second direction the ellipse is still an ellipse.
        let [_, line] = filtered(stripes(), Wrap::Repeat, place, &differentials([0.0, 0.1], [0.0, 0.0]));
        assert!(line > 0.9, "{line}");
    }

    #[test]
    fn wild_places_and_footprints_give_numbers() {
        let wild = [0.0, 1e-30, 1e30, f32::MAX];
        for x in wild {
            for y in wild {
                let footprint = differentials([x, y], [y, -x]);
                for found in filtered(ramp(8), Wrap::Repeat, Vec2::new(y, -x), &footprint) {
                    assert!(found.is_finite(), "{x} {y}");
                }
            }
        }
    }

    #[test]
    fn the_octahedron_closes() {
        let size = [4, 4];
        let at = |x, y| wrap([x, y], size, Wrap::OctahedralSphere).unwrap();
        // Beyond the left border lies the left border, upside down; at the corners all four meet.
        assert_eq!(
            [at(-1, 0), at(-1, 3), at(4, 1), at(1, -1), at(2, 4)],
            [[0, 3], [0, 0], [3, 2], [2, 0], [1, 3]]
        );
        assert_eq!(at(-1, -1), [3, 3]);
        for x in -20..20 {
            for y in -20..20 {
                let [a, b] = at(x, y);
                assert!(a < 4 && b < 4);
                assert_eq!(at(x + 16, y - 16), at(x, y));
            }
        }
        assert_eq!(wrap([i64::MAX, i64::MIN], [3, 5], Wrap::OctahedralSphere).map(|_| ()), Some(()));
    }
}
