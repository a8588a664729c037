//! Light that comes to a surface straight from a light.

use sahl_math::{Ray, Vec3};

use super::Tracer;
use crate::bsdf::Bsdf;
use crate::interaction::Interaction;
use crate::light::{Light, LightSample, Vantage};
use crate::spectrum::Spectrum;

/// A surface point with what scatters light there, seen from `wo`.
pub(super) struct Scattering<'a> {
    pub(super) at: &'a Interaction,
    pub(super) bsdf: &'a Bsdf<'a>,
    /// Unit direction in the world from which the point is looked at.
    pub(super) wo: Vec3,
}

/// Light that a surface scatters, if nothing lies on the way from where it comes.
pub(super) struct Unshadowed<'s> {
    pub(super) light: &'s Light,
    /// The way, from the surface on.
    pub(super) ray: Ray,
    pub(super) radiance: Spectrum,
}

impl Scattering<'_> {
    /// From where light is looked for.
    #[inline]
    pub(super) fn vantage(&self) -> Vantage {
        Vantage::on_surface(self.at, self.wo, self.bsdf.reach())
    }

    /// f |cos θ| for light from `wi`, and the density with which the BSDF samples `wi`.
    #[inline]
    pub(super) fn eval(&self, wi: Vec3) -> (Spectrum, f32) {
        let to_local = |w| self.at.shading.to_local(w);
        let (wo, local) = (to_local(self.wo), to_local(wi));
        (self.bsdf.eval(wo, local), self.bsdf.pdf(wo, local))
    }

    /// Light from `light` that is scattered along `wo` where it is not in shadow, one sample.
    ///
    /// The light is looked for from the point `from`, that of [`Self::vantage`]. `weigh` says how much a
    /// sample counts beside other ways to find the light, given its densities by light and by BSDF.
    #[inline]
    pub(super) fn light_from<'s>(
        &self,
        light: &'s Light,
        from: Vec3,
        tracer: &mut Tracer<'_>,
        weigh: impl FnOnce(&LightSample, f32) -> f32,
    ) -> Option<Unshadowed<'s>> {
        let u = tracer.sampler.next_2d();
        let sample = light.sample(from, u, &tracer.scene.textures, &tracer.wavelengths)?;
        if !self.at.sides_agree(self.wo, sample.wi) {
            return None;
        }
        let (f, bsdf_pdf) = self.eval(sample.wi);
        if f.is_zero() {
            return None;
        }
        let radiance = f * sample.radiance * (weigh(&sample, bsdf_pdf) / sample.pdf);
        Some(Unshadowed { light, ray: self.at.ray_to(&sample), radiance })
    }
}
