//! A point that throws a picture: a slide projector.
//!
//! In a scene file: `LightSource "projection" "string filename" "slide.png" "float fov" 60 "float scale" 5`.

use sahl_image::Image;
use sahl_math::{Bounds3, Transform, Vec3};

use super::environment::{linear_texels, orthonormal_axes, to_axes};
use super::kinds::toward_point;
use super::{Cone, LightBounds, LightSample};
use crate::spectrum::{ColorLookup, ColorRole, Spectrum, Wavelengths};

/// A point whose radiant intensity in the directions of a pyramid is an image on the plane across it, constant within a
/// pixel, as pbrt-v4's. The middle of the picture lies along +z, its top toward +y, its left toward −x.
#[derive(Clone, Debug)]
pub(crate) struct ProjectionLight {
    position: Vec3,
    /// Axes of the light's space in the world, orthonormal.
    axes: [Vec3; 3],
    /// Linear, in the picture's own space.
    texels: Vec<[f32; 3]>,
    colors: ColorLookup,
    width: usize,
    height: usize,
    /// Tangents of half the angles that the picture fills along x and y.
    extent: [f32; 2],
    /// Radiant intensity in W/sr of a texel of one.
    scale: f32,
}

impl ProjectionLight {
    /// The light that throws `image` over an angle of `fov` along its shorter side; `None` if it has no pixels. Values that
    /// are negative or not finite count as zero.
    pub(crate) fn new(image: &Image, fov: f32, light_to_world: &Transform) -> Option<Self> {
        let (width, height) = (image.width, image.height);
        let tan = (0.5 * fov).tan();
        let aspect = width as f32 / height as f32;
        Some(Self {
            position: light_to_world.point(Vec3::ZERO),
            axes: orthonormal_axes(light_to_world),
            texels: linear_texels(image)?,
            colors: ColorLookup::new(image.color_space),
            width,
            height,
            extent: [tan * aspect.max(1.0), tan * (1.0 / aspect).max(1.0)],
            scale: 1.0,
        })
    }

    /// Multiplies the intensity by `factor`.
    pub(crate) fn scaled(self, factor: f32) -> Self {
        Self { scale: self.scale * factor, ..self }
    }

    #[inline]
    pub(super) fn sample(&self, from: Vec3, wavelengths: &Wavelengths) -> Option<LightSample> {
        let sample = toward_point(self.position, Spectrum::ONE, from)?;
        let texel = self.texel(-sample.wi)?;
        let intensity = self.colors.at(texel, ColorRole::Illuminant, wavelengths) * self.scale;
        (!intensity.is_zero()).then(|| LightSample { radiance: sample.radiance * intensity, ..sample })
    }

    /// The texel that is thrown along the unit vector `w`; `None` beside the picture.
    fn texel(&self, w: Vec3) -> Option<[f32; 3]> {
        let local = to_axes(&self.axes, w);
        if local.z <= 0.0 {
            return None;
        }
        let place = |t: f32, size: usize| {
            let t = 0.5 + 0.5 * t;
            (0.0..=1.0).contains(&t).then(|| ((t * size as f32) as usize).min(size - 1))
        };
        let x = place(local.x / (local.z * self.extent[0]), self.width)?;
        let y = place(-local.y / (local.z * self.extent[1]), self.height)?;
        Some(self.texels[y * self.width + x])
    }

    /// ∫ I dω, with the solid angle of each texel.
    ///
    /// That of the rectangle from the axis to (x, y) on the plane at distance one is atan(x y / √(1 + x² + y²)). pbrt-v4 takes
    /// the area by the cube of the cosine in the middle, which is off by some per cent for few texels.
    pub(crate) fn power(&self, wavelengths: &Wavelengths) -> Spectrum {
        let border =
            |k: usize, size: usize, extent: f32| (2.0 * k as f64 / size as f64 - 1.0) * f64::from(extent);
        let to_corner = |x: usize, y: usize| {
            let x = border(x, self.width, self.extent[0]);
            let y = border(y, self.height, self.extent[1]);
            (x * y / (1.0 + x * x + y * y).sqrt()).atan()
        };
        let mut sum = [0.0_f64; 3];
        for (i, texel) in self.texels.iter().enumerate() {
            let (x, y) = (i % self.width, i / self.width);
            let solid_angle =
                to_corner(x + 1, y + 1) - to_corner(x, y + 1) - to_corner(x + 1, y) + to_corner(x, y);
            for (sum, value) in sum.iter_mut().zip(texel) {
                *sum += f64::from(*value) * solid_angle;
            }
        }
        let sum = sum.map(|sum| sum as f32);
        self.colors.at(sum, ColorRole::Illuminant, wavelengths) * self.scale
    }

    /// The cone about the pyramid.
    pub(super) fn bounds(&self) -> LightBounds {
        let [x, y] = self.extent;
        let mean = |[r, g, b]: [f32; 3]| f64::from((r + g + b) / 3.0);
        let sum: f64 = self.texels.iter().map(|&texel| mean(texel)).sum();
        LightBounds {
            bounds: Bounds3::from_points([self.position]),
            facing: Cone { axis: self.axes[2], cos: 1.0 / (1.0 + x * x + y * y).sqrt() },
            cos_reach: 1.0,
            two_sided: false,
            intensity: (sum / self.texels.len() as f64) as f32 * self.scale,
        }
    }
}
