//! Openings of aperture stops that are not round.
//!
//! The shapes are pbrt-v4's: 256 by 256 values over the square about the stop. Each is scaled to let as much light through as
//! the disk would, π/4 of the square.

use std::f32::consts::{FRAC_PI_4, PI};
use std::f64::consts::SQRT_2;

use sahl_image::Image;

/// Values along a side of the shapes that are built in.
const SIDE: usize = 256;

/// Transmittance over the square about an aperture stop, bilinear between values and zero around them.
#[derive(Clone, Debug)]
pub(super) struct Mask {
    width: usize,
    height: usize,
    /// Row by row, the lowest first.
    values: Box<[f32]>,
    /// Farther from the middle than this, in radii of the stop, nothing gets through.
    reach: f64,
}

impl Mask {
    /// A shape within the disk of the stop.
    fn built_in(value: impl Fn(usize, usize) -> f32) -> Option<Self> {
        Some(Self { reach: 1.0 + 1.0 / SIDE as f64, ..Self::new(SIDE, SIDE, value)? })
    }

    /// Rows are given from the top; `None` if nothing gets through.
    fn new(width: usize, height: usize, value: impl Fn(usize, usize) -> f32) -> Option<Self> {
        let places = (0..height).rev().flat_map(|y| (0..width).map(move |x| (x, y)));
        let mut values: Box<[f32]> = places.map(|(x, y)| value(x, y).max(0.0)).collect();
        let sum: f64 = values.iter().map(|&value| f64::from(value)).sum();
        let scale = f64::from(FRAC_PI_4) * (width * height) as f64 / sum;
        if !(sum > 0.0 && scale.is_finite()) {
            return None;
        }
        for value in &mut values {
            *value *= scale as f32;
        }
        let reach = SQRT_2 * (1.0 + 1.0 / width.min(height) as f64);
        Some(Self { width, height, values, reach })
    }

    /// By the mean of the colours of an image.
    pub(super) fn of_image(image: &Image) -> Option<Self> {
        Self::new(image.width, image.height, |x, y| {
            let [r, g, b, _] = image.pixel(x, y);
            (r + g + b) / 3.0
        })
    }

    /// The bell e^(−r²) − e^(−1).
    pub(super) fn gaussian() -> Option<Self> {
        Self::built_in(|x, y| {
            let [x, y] = centered(x, y);
            (-x * x - y * y).exp() - (-1.0_f32).exp()
        })
    }

    /// Half as wide as the stop.
    pub(super) fn square() -> Option<Self> {
        let is_inside = |i: usize| (SIDE / 4..3 * SIDE / 4).contains(&i);
        Self::built_in(|x, y| f32::from(is_inside(x) && is_inside(y)))
    }

    /// Regular, with a radius of 0.8 of the stop's, a corner at the lower end: the stop stands in the ray's way upside down.
    pub(super) fn pentagon() -> Option<Self> {
        let corner = |i: usize| {
            let (sin, cos) = (0.4 * PI * i as f32).sin_cos();
            [0.8 * sin, 0.8 * cos]
        };
        Self::polygon(&std::array::from_fn::<_, 5, _>(corner))
    }

    /// Five points on the rim, between them the corners of the pentagon that their lines enclose.
    pub(super) fn star() -> Option<Self> {
        let corner = |i: usize| {
            let radius = if i % 2 == 1 { 1.0 } else { (0.4 * PI).cos() / (0.2 * PI).cos() };
            let (sin, cos) = (0.2 * PI * i as f32).sin_cos();
            [radius * cos, radius * sin]
        };
        Self::polygon(&std::array::from_fn::<_, 10, _>(corner))
    }

    /// One inside a polygon in [−1, 1]², by the parity of the edges to the right of a point.
    fn polygon(corners: &[[f32; 2]]) -> Option<Self> {
        Self::built_in(|x, y| {
            let [x, y] = centered(x, y);
            let crossings = (0..corners.len()).filter(|&i| {
                let ([x0, y0], [x1, y1]) = (corners[i], corners[(i + 1) % corners.len()]);
                (y0 > y) != (y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
            });
            (crossings.count() % 2) as f32
        })
    }

    /// Farther from the middle than this, in radii of the stop, nothing gets through.
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// The transmittance at (x, y) in units of the stop's radius.
    pub(super) fn at(&self, x: f64, y: f64) -> f32 {
        let place = |i: f64, size: usize| {
            let place = (i as f32 + 1.0) * 0.5 * size as f32 - 0.5;
            (place.floor() as i64, place - place.floor())
        };
        let ((x, dx), (y, dy)) = (place(x, self.width), place(y, self.height));
        let value = |x: i64, y: i64| {
            let inside = (0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y);
            if inside { self.values[y as usize * self.width + x as usize] } else { 0.0 }
        };
        let row = |y| (1.0 - dx) * value(x, y) + dx * value(x + 1, y);
        (1.0 - dy) * row(y) + dy * row(y + 1)
    }
}

/// The middle of a value, in [−1, 1]².
fn centered(x: usize, y: usize) -> [f32; 2] {
    [x, y].map(|i| 2.0 * (i as f32 + 0.5) / SIDE as f32 - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_lets_as_much_through_as_the_disk() {
        let image = Image::rgb_f32(2, 3, (0..18).map(|i| i as f32).collect()).unwrap();
        for mask in [Mask::gaussian(), Mask::square(), Mask::pentagon(), Mask::star(), Mask::of_image(&image)]
        {
            let mask = mask.unwrap();
            let n = 400;
            let sum: f64 = (0..n * n)
                .map(|i| {
                    let at = |i: i32| 2.4 * (f64::from(i) + 0.5) / f64::from(n) - 1.2;
                    f64::from(mask.at(at(i % n), at(i / n)))
                })
                .sum();
            let area = sum * (2.4 / f64::from(n)) * (2.4 / f64::from(n));
            // An image of a few pixels loses what bilinear interpolation spreads beyond the square.
            assert!((area / std::f64::consts::PI - 1.0).abs() < 0.02 || mask.width == 2, "{area}");
        }
        assert!(Mask::of_image(&Image::filled(4, 4, 1, 0.0).unwrap()).is_none());
    }

    #[test]
    fn shapes_are_where_they_should_be() {
        let (square, pentagon, star) =
            (Mask::square().unwrap(), Mask::pentagon().unwrap(), Mask::star().unwrap());
        assert!(square.at(0.45, -0.45) > 0.0 && square.at(0.55, 0.0) == 0.0);
        assert!(pentagon.at(0.0, -0.7) > 0.0 && pentagon.at(0.0, 0.7) == 0.0 && pentagon.at(0.0, 0.6) > 0.0);
        assert!(star.at(-0.9, 0.0) > 0.0 && star.at(0.9, 0.0) == 0.0);
        assert!(star.at(0.0, 0.0) > 0.0);
        // What lies beyond the stop's radius is closed.
        assert_eq!([square.at(1.5, 0.0), star.at(-1.2, 0.0)], [0.0; 2]);
    }

    #[test]
    fn images_stand_upright_as_the_eye_sees_them() {
        // The top left pixel of four lets light through; y points up in the camera.
        let image = Image::y_f32(2, 2, vec![1.0, 0.0, 0.0, 0.0]).unwrap();
        let mask = Mask::of_image(&image).unwrap();
        assert!(mask.at(-0.5, 0.5) > 0.0);
        assert_eq!([mask.at(0.5, 0.5), mask.at(-0.5, -0.5), mask.at(0.5, -0.5)], [0.0; 3]);
    }
}
