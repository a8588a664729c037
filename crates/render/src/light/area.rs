//! Primitives that emit.
//!
//! Each primitive of an emitting shape is a light of its own. What it emits is the same in all directions, and either the
//! same everywhere or a texture over the surface, which is evaluated where a sample or a ray finds it; unless it has to pass the layers
//! of a material that emits. Points are sampled alike in all cases: a picture that is dark in most places is better cut into primitives.
//!
//! In a scene file: `AreaLightSource "diffuse" "rgb L" [ 5 5 5 ]`, or with `"string filename" "screen.png"`; or by a material,
//! `Material "openpbr" "float emission_luminance" 5`.

use std::f32::consts::PI;
use std::sync::Arc;

use sahl_math::{Vec2, Vec3};

use super::{Emission, LightBounds, LightSample};
use crate::interaction::Interaction;
use crate::material::OpenPbrSource;
use crate::shape::{Emitter, EmitterPoint, SurfaceMap};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::{SpectrumSource, TexturePoint, Textures};

/// A primitive that emits.
#[derive(Clone, Debug)]
pub(crate) struct AreaLight {
    emitter: Emitter,
    /// In W·m⁻²·sr⁻¹; where it varies over the primitive, its mean.
    radiance: Emission,
    /// Whether both sides emit.
    two_sided: bool,
    presence: Presence,
    texture: Option<Box<EmissionTexture>>,
}

/// How much of an emitting surface is there, and so how its light is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Presence {
    /// This share: rays meet it with this probability, and samples of the light are that much darker.
    Share(f32),
    /// Rays pass it, samples find all of it: a light that is not seen itself, as pbrt-v4 makes of an alpha of zero.
    Unseen,
    /// It varies over the surface: rays alone find the light.
    Varying,
}

impl Presence {
    /// The share of the light that samples of it find.
    fn sampled(self) -> f32 {
        match self {
            Self::Share(share) => share,
            Self::Unseen => 1.0,
            Self::Varying => 0.0,
        }
    }
}

/// Radiance that varies over a primitive, or with the direction.
#[derive(Clone, Debug)]
pub(crate) struct EmissionTexture {
    source: SpectrumSource,
    scale: f32,
    map: SurfaceMap,
    /// The material whose layers the light has to pass.
    veil: Option<Arc<OpenPbrSource>>,
}

/// The cosine that stands for all directions of emission where one number has to: its mean over the flux.
const MEAN_COS: f32 = 2.0 / 3.0;

impl EmissionTexture {
    /// `scale` times the texture `source`, which is an illuminant; `map` gives the coordinates of points of the primitive.
    pub(crate) fn new(source: SpectrumSource, scale: f32, map: SurfaceMap) -> Self {
        Self { source, scale, map, veil: None }
    }

    /// The same below the layers of `veil`.
    pub(crate) fn below(self, veil: Option<Arc<OpenPbrSource>>) -> Self {
        Self { veil, ..self }
    }

    /// Multiplies the radiance by `factor`.
    pub(crate) fn scaled(self, factor: f32) -> Self {
        Self { scale: self.scale * factor, ..self }
    }

    /// Radiance at `point`, in a direction whose cosine to the normal is `cos`.
    #[inline]
    fn at(&self, point: TexturePoint, cos: f32, textures: &Textures, wavelengths: &Wavelengths) -> Spectrum {
        let radiance = textures.spectrum(&self.source, &point, wavelengths) * self.scale;
        match &self.veil {
            None => radiance,
            Some(veil) => radiance * veil.veil(cos.abs(), &point, textures, wavelengths),
        }
    }

    /// The mean over the primitive `emitter` in linear sRGB, from `side` × `side` points.
    ///
    /// It is uniform by area but for the distortion of the parameters. Textures in space count as they are in the middle.
    pub(crate) fn mean(&self, emitter: &Emitter, textures: &Textures, side: usize) -> [f32; 3] {
        let p = emitter.bounds().center();
        let mut sum = [0.0_f64; 3];
        for i in 0..side * side {
            let u = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) * (1.0 / side as f32);
            let point = TexturePoint { uv: self.map.uv_of_square(u), p, ..TexturePoint::default() };
            let rgb = self.at(point, MEAN_COS, textures, &Wavelengths::Rgb).to_rgb();
            for (sum, value) in sum.iter_mut().zip(rgb) {
                *sum += f64::from(value);
            }
        }
        sum.map(|sum| (sum / (side * side) as f64) as f32)
    }
}

impl AreaLight {
    /// A light that sends `radiance` from the front of `emitter`, or from both sides.
    pub(crate) fn new(emitter: Emitter, radiance: Emission, two_sided: bool, presence: Presence) -> Self {
        Self { emitter, radiance, two_sided, presence, texture: None }
    }

    /// The same with a texture, whose mean is the radiance so far.
    pub(crate) fn with_texture(self, texture: EmissionTexture) -> Self {
        Self { texture: Some(Box::new(texture)), ..self }
    }

    #[inline]
    pub(super) fn sample(
        &self,
        from: Vec3,
        u: Vec2,
        textures: &Textures,
        wavelengths: &Wavelengths,
    ) -> Option<LightSample> {
        let (point, pdf) = self.emitter.sample(from, u)?;
        let wi = (point.p - from).try_normalize()?;
        if !self.sends(point.n, -wi) {
            return None;
        }
        let radiance = match &self.texture {
            None => self.radiance.at(wavelengths),
            Some(texture) => {
                let uv = texture.map.uv(&point);
                let at = TexturePoint { uv, p: point.p, n: point.n, ..TexturePoint::default() };
                texture.at(at, point.n.dot(-wi), textures, wavelengths)
            }
        };
        let radiance = radiance * self.presence.sampled();
        let end = Some((point.p, point.p_error, point.n));
        let is_delta = self.presence == Presence::Unseen;
        (!radiance.is_zero()).then_some(LightSample { radiance, wi, pdf, is_delta, end })
    }

    /// Radiance along `wo` from a point that a ray found.
    #[inline]
    pub(super) fn emitted(
        &self,
        at: &Interaction,
        wo: Vec3,
        textures: &Textures,
        wavelengths: &Wavelengths,
    ) -> Spectrum {
        if !self.sends(at.ng, wo) {
            return Spectrum::ZERO;
        }
        match &self.texture {
            None => self.radiance.at(wavelengths),
            Some(texture) => {
                let point = TexturePoint { uv: at.uv, p: at.p, n: at.ng, ..TexturePoint::default() };
                texture.at(point, at.ng.dot(wo), textures, wavelengths)
            }
        }
    }

    /// Whether the side with the normal `n` emits along `wo`.
    #[inline]
    fn sends(&self, n: Vec3, wo: Vec3) -> bool {
        self.two_sided || n.dot(wo) > 0.0
    }

    /// Density per steradian with which [`AreaLight::sample`] finds the point `at` from `from`.
    #[inline]
    pub(super) fn pdf(&self, from: Vec3, at: &Interaction) -> f32 {
        let point = EmitterPoint { p: at.p, p_error: at.p_error, n: at.ng, uv: at.parameters };
        if self.presence == Presence::Varying { 0.0 } else { self.emitter.pdf(from, &point) }
    }

    /// See [`Light::may_block_itself`](super::Light::may_block_itself).
    pub(super) fn may_block_itself(&self, distance: f32) -> bool {
        self.emitter.may_block_itself(distance)
    }

    pub(super) fn power(&self, wavelengths: &Wavelengths) -> Spectrum {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        self.radiance.at(wavelengths) * (PI * self.emitter.area() * sides * self.presence.sampled())
    }

    pub(super) fn bounds(&self) -> LightBounds {
        let facing = self.emitter.facing();
        // Seen from anywhere, a closed convex surface shows a quarter of its area (Cauchy).
        let seen = if facing.cos <= -1.0 { 0.25 } else { 1.0 };
        LightBounds {
            bounds: self.emitter.bounds(),
            facing,
            cos_reach: 0.0,
            two_sided: self.two_sided,
            intensity: self.radiance.mean() * self.emitter.area() * seen * self.presence.sampled(),
        }
    }
}
