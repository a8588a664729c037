//! Light from an image of the sky.

use std::f32::consts::PI;

use sahl_image::Image;
use sahl_math::{Transform, Vec2, Vec3};

use super::{LightSample, SphereMap};
use crate::distribution::PiecewiseConstant2d;
use crate::spectrum::{ColorLookup, ColorRole, Spectrum, Wavelengths};

/// A sky whose brightest texel exceeds the mean by less than this share has no structure but that of rounding.
const LEAST_CONTRAST: f32 = 1e-3;

/// Radiance by direction, from an image; directions are sampled in proportion to it.
///
/// Where directions are found by the BSDF as well (multiple importance sampling), those that are no brighter than the mean are
/// left to it, and the others sampled in proportion to what they are brighter. Source: Karlík, Šik, Vévoda, Skřivan,
/// Křivánek, *MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling*, ACM TOG 38(6), 2019.
///
/// Equal-area images are constant within a pixel, as in pbrt-v4, and sampled exactly; latitude-longitude images are
/// interpolated bilinearly, and a pixel is sampled in proportion to its mean under that interpolation.
#[derive(Clone, Debug)]
pub(crate) struct ImageEnvironment {
    map: SphereMap,
    width: usize,
    height: usize,
    /// Linear, in the image's own space.
    texels: Vec<[f32; 3]>,
    colors: ColorLookup,
    distribution: PiecewiseConstant2d,
    /// Mean over the sphere of the radiance in proportion to which directions are sampled, before scaling.
    sampled_mean: f32,
    /// Axes of the image's space in the world, orthonormal, and perhaps left-handed.
    axes: [Vec3; 3],
    scale: f32,
}

impl ImageEnvironment {
    /// The environment that `image` is, `None` if it has no pixels. Negative and non-finite values count as zero.
    pub(crate) fn new(
        image: &Image,
        map: SphereMap,
        light_to_world: &Transform,
        sampled: Sampled,
    ) -> Option<Self> {
        let (width, height) = (image.width, image.height);
        let texels = linear_texels(image)?;
        let mut weights = mean_radiance(map, &texels, width, height);
        let solid_angle = |i: usize| match map {
            SphereMap::EqualArea => 1.0,
            SphereMap::LatLong => (PI * ((i / width) as f32 + 0.5) / height as f32).sin(),
        };
        if sampled == Sampled::WithBsdf {
            compensate(&mut weights, solid_angle);
        }
        let mut sums = [0.0_f64; 2];
        for (i, weight) in weights.iter_mut().enumerate() {
            *weight *= solid_angle(i);
            sums[0] += f64::from(*weight);
            sums[1] += f64::from(solid_angle(i));
        }
        let sampled_mean = (sums[0] / sums[1]) as f32;
        let distribution = PiecewiseConstant2d::new(&weights, width);
        let axes = orthonormal_axes(light_to_world);
        let colors = ColorLookup::new(image.color_space);
        Some(Self { map, width, height, texels, colors, distribution, sampled_mean, axes, scale: 1.0 })
    }

    /// Multiplies the radiance by `factor`.
    pub(crate) fn scaled(self, factor: f32) -> Self {
        Self { scale: self.scale * factor, ..self }
    }

    /// Texels along an axis, in the mean of both.
    pub(super) fn resolution(&self) -> usize {
        (self.width * self.height).isqrt()
    }

    /// The directions of the middles of all texels, in the world.
    pub(super) fn texel_directions(&self) -> impl Iterator<Item = Vec3> {
        let (width, height) = (self.width, self.height);
        (0..width * height).map(move |i| {
            let (x, y) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
            self.to_world(self.map.direction(Vec2::new(x / width as f32, y / height as f32)))
        })
    }

    /// Radiance from a unit direction in the world.
    #[inline]
    pub(crate) fn radiance(&self, direction: Vec3, wavelengths: &Wavelengths) -> Spectrum {
        self.at(self.map.uv(self.to_local(direction)), wavelengths)
    }

    #[inline]
    pub(super) fn sample(&self, u: Vec2, wavelengths: &Wavelengths) -> Option<LightSample> {
        let (uv, pdf) = self.distribution.sample(u);
        let pdf = pdf / self.map.solid_angle(uv);
        let wi = self.to_world(self.map.direction(uv));
        (pdf > 0.0 && pdf.is_finite()).then(|| LightSample {
            radiance: self.at(uv, wavelengths),
            wi,
            pdf,
            is_delta: false,
            end: None,
        })
    }

    #[inline]
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        let uv = self.map.uv(self.to_local(direction));
        let pdf = self.distribution.pdf(uv) / self.map.solid_angle(uv);
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// Mean radiance over the sphere.
    pub(crate) fn mean(&self, wavelengths: &Wavelengths) -> Spectrum {
        self.lanes(self.integrate(1, |_| 1.0).map(|x| x / (4.0 * PI)), wavelengths)
    }

    /// ∫ L dω of what directions are sampled by: the light that is left to sampling the environment.
    pub(super) fn sampled_fluence(&self) -> f32 {
        4.0 * PI * self.sampled_mean * self.scale
    }

    /// Luminous irradiance on a surface that faces up: +z for equal-area images, +y for the others.
    pub(crate) fn illuminance(&self) -> f32 {
        let map = self.map;
        let cosine = |w: Vec3| match map {
            SphereMap::EqualArea => w.z.max(0.0),
            SphereMap::LatLong => w.y.max(0.0),
        };
        self.colors.space().luminance(self.integrate(3, cosine))
    }

    /// ∫ L f dω, by the midpoints of `cuts` × `cuts` parts of each pixel.
    fn integrate(&self, cuts: usize, f: impl Fn(Vec3) -> f32) -> [f32; 3] {
        let (columns, rows) = (self.width * cuts, self.height * cuts);
        let mut sum = [0.0_f64; 3];
        for y in 0..rows {
            for x in 0..columns {
                let uv = Vec2::new((x as f32 + 0.5) / columns as f32, (y as f32 + 0.5) / rows as f32);
                let weight = f64::from(self.map.solid_angle(uv) * f(self.map.direction(uv)));
                for (sum, value) in sum.iter_mut().zip(self.texel(uv)) {
                    *sum += weight * f64::from(value);
                }
            }
        }
        let area = 1.0 / (columns * rows) as f64;
        sum.map(|x| (x * area) as f32 * self.scale)
    }

    #[inline]
    fn to_local(&self, w: Vec3) -> Vec3 {
        to_axes(&self.axes, w)
    }

    #[inline]
    fn to_world(&self, w: Vec3) -> Vec3 {
        self.axes[0] * w.x + self.axes[1] * w.y + self.axes[2] * w.z
    }

    #[inline]
    fn at(&self, uv: Vec2, wavelengths: &Wavelengths) -> Spectrum {
        self.lanes(self.texel(uv), wavelengths) * self.scale
    }

    /// A colour of the image in the lanes of a path.
    #[inline]
    fn lanes(&self, rgb: [f32; 3], wavelengths: &Wavelengths) -> Spectrum {
        self.colors.at(rgb, ColorRole::Illuminant, wavelengths)
    }

    /// The colour at `uv`, before scaling.
    #[inline]
    fn texel(&self, uv: Vec2) -> [f32; 3] {
        let (x, y) = (uv.x * self.width as f32, uv.y * self.height as f32);
        match self.map {
            SphereMap::EqualArea => {
                self.texels[(y as usize).min(self.height - 1) * self.width + (x as usize).min(self.width - 1)]
            }
            SphereMap::LatLong => self.bilinear(x - 0.5, y - 0.5),
        }
    }

    /// Interpolates between texel centres, which lie at whole numbers: round the image in x, up to its border in y.
    #[inline]
    fn bilinear(&self, x: f32, y: f32) -> [f32; 3] {
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let column = |x: f32| (x as i64).rem_euclid(self.width as i64) as usize;
        let row = |y: f32| (y.max(0.0) as usize).min(self.height - 1) * self.width;
        let (left, right, top, bottom) = (column(x0), column(x0 + 1.0), row(y0), row(y0 + 1.0));
        let (a, b) = (self.texels[top + left], self.texels[top + right]);
        let (c, d) = (self.texels[bottom + left], self.texels[bottom + right]);
        std::array::from_fn(|i| {
            (a[i] * (1.0 - fx) + b[i] * fx) * (1.0 - fy) + (c[i] * (1.0 - fx) + d[i] * fx) * fy
        })
    }
}

/// How else the directions of an environment are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sampled {
    /// Not at all: every direction from which light comes must be sampled.
    Alone,
    /// By sampling the BSDF, too.
    WithBsdf,
}

/// The colours of an image, linear in its own space, negative and non-finite components zero; `None` if there are none.
pub(super) fn linear_texels(image: &Image) -> Option<Vec<[f32; 3]>> {
    let (width, height) = (image.width, image.height);
    let mut texels = Vec::with_capacity(width.checked_mul(height)?);
    for y in 0..height {
        for x in 0..width {
            let [r, g, b, _] = image.pixel(x, y);
            texels.push([r, g, b].map(|v| if v.is_finite() { v.max(0.0) } else { 0.0 }));
        }
    }
    (!texels.is_empty()).then_some(texels)
}

/// Subtracts the mean over the sphere from the radiance of each texel, but not below zero. A sky without structure is left as
/// it is.
fn compensate(radiance: &mut [f32], solid_angle: impl Fn(usize) -> f32) {
    let mut sums = [0.0_f64; 2];
    for (i, &value) in radiance.iter().enumerate() {
        sums[0] += f64::from(value * solid_angle(i));
        sums[1] += f64::from(solid_angle(i));
    }
    let mean = (sums[0] / sums[1]) as f32;
    if radiance.iter().any(|&value| value > mean * (1.0 + LEAST_CONTRAST)) {
        for value in radiance {
            *value = (*value - mean).max(0.0);
        }
    }
}

/// The mean of the lanes over each texel.
fn mean_radiance(map: SphereMap, texels: &[[f32; 3]], width: usize, height: usize) -> Vec<f32> {
    let mean = |[r, g, b]: [f32; 3]| (r + g + b) / 3.0;
    let means: Vec<f32> = texels.iter().map(|&texel| mean(texel)).collect();
    match map {
        SphereMap::EqualArea => means,
        SphereMap::LatLong => {
            // The mean of a bilinear interpolation over a texel weighs it and its neighbours by 6 and 1 along each axis.
            let blur = |before: f32, at: f32, after: f32| (before + 6.0 * at + after) / 8.0;
            let across: Vec<f32> = (0..means.len())
                .map(|i| {
                    let (x, row) = (i % width, &means[i / width * width..][..width]);
                    blur(row[(x + width - 1) % width], row[x], row[(x + 1) % width])
                })
                .collect();
            (0..means.len())
                .map(|i| {
                    let (x, y) = (i % width, i / width);
                    let at = |y: usize| across[y * width + x];
                    blur(at(y.saturating_sub(1)), at(y), at((y + 1).min(height - 1)))
                })
                .collect()
        }
    }
}

/// The images of the axes under `transform`, made orthonormal (Gram and Schmidt), keeping its handedness.
pub(super) fn orthonormal_axes(transform: &Transform) -> [Vec3; 3] {
    let x = transform.vector(Vec3::X).normalize();
    let y = transform.vector(Vec3::Y);
    let y = (y - x * x.dot(y)).normalize();
    let z = x.cross(y);
    [x, y, if transform.swaps_handedness() { -z } else { z }]
}

/// The components of `w` along orthonormal axes.
#[inline]
pub(super) fn to_axes(axes: &[Vec3; 3], w: Vec3) -> Vec3 {
    Vec3::new(w.dot(axes[0]), w.dot(axes[1]), w.dot(axes[2]))
}

/// Whether `transform` is a rotation, perhaps mirrored and scaled alike in all directions.
pub(crate) fn is_rigid(transform: &Transform) -> bool {
    let scale = transform.vector(Vec3::X).length();
    let axes = orthonormal_axes(transform);
    [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .zip(axes)
        .all(|(axis, expected)| (transform.vector(axis) / scale - expected).length() < 1e-4)
}
