//! Reconstruction filters of pixels, by importance sampling.
//!
//! Design decision: a sample belongs to one pixel. Where in the pixel's neighbourhood it lies is drawn in proportion to
//! the absolute value of the filter; the sign, and the ratio of ∫|f| to ∫f, are its weight. So the mean of
//! `weight × radiance` over a pixel's samples is the filtered image, and the weights have mean one.
//!
//! Every filter here is a product f(x) f(y), and the axes are drawn apart: smooth curves, one-dimensional tables.
//!
//! Deliberately absent: splatting one sample into several pixels.
//!
//! In a scene file: `PixelFilter "gaussian" "float xradius" 1.5 "float yradius" 1.5 "float sigma" .5`.

mod table;

use sahl_math::Vec2;

use crate::warp;
use table::AxisTable;

/// A place to sample for a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSample {
    /// From the centre of the pixel, in pixels.
    pub offset: Vec2,
    /// What the radiance found there counts; negative in negative lobes. The mean over the filter is one.
    pub weight: f32,
}

/// A reconstruction filter, ready to be sampled.
#[derive(Clone, Debug)]
pub enum PixelFilter {
    /// Constant within the radius.
    Box {
        /// Half widths in pixels.
        radius: Vec2,
    },
    /// Linear falloff to zero at the radius.
    Triangle {
        /// Half widths in pixels.
        radius: Vec2,
    },
    /// A product of two curves given by tables: Gaussian, Mitchell and Netravali's cubic, and the windowed sinc.
    Tabulated {
        /// The curve in x.
        x: AxisTable,
        /// The curve in y.
        y: AxisTable,
    },
}

impl PixelFilter {
    /// The filter a scene asks for.
    ///
    /// A radius of zero, or one that is negative or not finite, samples the centre of the pixel along that axis.
    pub fn new(filter: &sahl_scene::Filter) -> Self {
        let half_widths = |radius: [f32; 2]| {
            Vec2::from(radius).map(|radius| if radius.is_finite() { radius.max(0.0) } else { 0.0 })
        };
        let tabulated = |radius: Vec2, curve: &dyn Fn(f32, f32) -> f32| Self::Tabulated {
            x: AxisTable::new(radius.x, |x| curve(x, radius.x)),
            y: AxisTable::new(radius.y, |y| curve(y, radius.y)),
        };
        match *filter {
            sahl_scene::Filter::Box { radius } => Self::Box { radius: half_widths(radius) },
            sahl_scene::Filter::Triangle { radius } => Self::Triangle { radius: half_widths(radius) },
            sahl_scene::Filter::Gaussian { radius, sigma } => {
                tabulated(half_widths(radius), &|x, radius| gaussian(x, radius, sigma))
            }
            sahl_scene::Filter::Mitchell { radius, b, c } => {
                tabulated(half_widths(radius), &|x, radius| mitchell(2.0 * x / radius, b, c))
            }
            sahl_scene::Filter::Sinc { radius, tau } => {
                tabulated(half_widths(radius), &|x, _| sinc(x) * sinc(x / tau))
            }
        }
    }

    /// The place to sample for `u` uniform in the unit square.
    #[inline]
    pub fn sample(&self, u: Vec2) -> FilterSample {
        match self {
            Self::Box { radius } => FilterSample { offset: (u * 2.0 - Vec2::ONE) * *radius, weight: 1.0 },
            Self::Triangle { radius } => FilterSample { offset: u.map(warp::tent) * *radius, weight: 1.0 },
            Self::Tabulated { x, y } => {
                let ((x, weight_x), (y, weight_y)) = (x.sample(u.x), y.sample(u.y));
                FilterSample { offset: Vec2::new(x, y), weight: weight_x * weight_y }
            }
        }
    }

    /// The half widths, in pixels.
    pub fn radius(&self) -> Vec2 {
        match self {
            Self::Box { radius } | Self::Triangle { radius } => *radius,
            Self::Tabulated { x, y } => Vec2::new(x.radius(), y.radius()),
        }
    }
}

/// A Gaussian of standard deviation `sigma`, moved down to reach zero at `radius`, as in pbrt-v4; not normalised.
fn gaussian(x: f32, radius: f32, sigma: f32) -> f32 {
    let bell = |x: f32| (-x * x / (2.0 * sigma * sigma)).exp();
    (bell(x) - bell(radius)).max(0.0)
}

/// The cubic of Mitchell, Netravali, *Reconstruction Filters in Computer Graphics*, SIGGRAPH 1988, equation 8, over
/// [−2, 2]; `b` blurs, `c` rings.
fn mitchell(x: f32, b: f32, c: f32) -> f32 {
    let x = x.abs();
    if x < 1.0 {
        ((12.0 - 9.0 * b - 6.0 * c) * x * x * x + (-18.0 + 12.0 * b + 6.0 * c) * x * x + (6.0 - 2.0 * b))
            / 6.0
    } else if x < 2.0 {
        ((-b - 6.0 * c) * x * x * x
            + (6.0 * b + 30.0 * c) * x * x
            + (-12.0 * b - 48.0 * c) * x
            + (8.0 * b + 24.0 * c))
            / 6.0
    } else {
        0.0
    }
}

/// sin(πx) / (πx).
fn sinc(x: f32) -> f32 {
    let angle = std::f32::consts::PI * x;
    // Where the square is below one bit of one, the quotient rounds to one.
    if 1.0 - angle * angle == 1.0 { 1.0 } else { angle.sin() / angle }
}

#[cfg(test)]
mod tests;
