//! The choice of one light among many.

use crate::distribution::AliasTable;
use crate::light::Light;
use crate::spectrum::Wavelengths;

/// How lights are chosen for direct lighting.
#[derive(Clone, Debug)]
pub(crate) struct LightSelection {
    table: AliasTable,
}

/// A light and the probability with which it was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightChoice {
    pub(crate) light: u32,
    pub(crate) pmf: f32,
}

impl LightSelection {
    /// A choice in proportion to `weights`, one a light: none at all if they are all zero.
    pub(crate) fn new(weights: &[f32]) -> Self {
        let any = weights.iter().any(|&weight| weight > 0.0);
        Self { table: AliasTable::new(if any { weights } else { &[] }) }
    }

    /// In proportion to the power of each light in a scene of the given radius.
    ///
    /// Environments of one radiance are never chosen: sampling the BSDF finds them at least as well, because it knows
    /// the cosine, and they have no structure to look for.
    pub(crate) fn by_power(lights: &[Light], scene_radius: f32) -> Self {
        Self::by(lights, scene_radius, |power| power)
    }

    /// All alike, but for lights that have no power and environments of one radiance.
    pub(crate) fn uniform(lights: &[Light], scene_radius: f32) -> Self {
        Self::by(lights, scene_radius, |power| if power > 0.0 { 1.0 } else { 0.0 })
    }

    fn by(lights: &[Light], scene_radius: f32, weight: impl Fn(f32) -> f32) -> Self {
        let weight = |light: &Light| match light {
            Light::Uniform(_) => 0.0,
            _ => weight(light.power(scene_radius, &Wavelengths::default()).average()),
        };
        Self::new(&lights.iter().map(weight).collect::<Vec<f32>>())
    }

    /// The light that `u` chooses; `None` if there is none to choose.
    #[inline]
    pub(crate) fn choose(&self, u: f32) -> Option<LightChoice> {
        let (light, pmf, _) = self.table.sample(u)?;
        Some(LightChoice { light: light as u32, pmf })
    }

    /// The probability with which `light` is chosen.
    #[inline]
    pub(crate) fn pmf(&self, light: u32) -> f32 {
        self.table.pmf(light as usize)
    }

    /// Whether no light can be chosen.
    pub(crate) fn is_empty(&self) -> bool {
        self.table.is_empty()
    }
}
