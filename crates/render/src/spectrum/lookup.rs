//! Colours that are looked up while rendering, such as those of texels.

use sahl_image::{Adaptation, ColorSpace};

use super::hero::HeroWavelengths;
use super::uplift::{Uplifted, UpliftedLight};
use super::{ColorRole, Spectrum, Wavelengths};

/// Turns linear RGB of one space into lanes.
#[derive(Clone, Debug)]
pub(crate) struct ColorLookup {
    space: ColorSpace,
    /// To linear sRGB, for reflectances and for emission; `None`: it is that already.
    to_srgb: Option<Box<[[[f32; 3]; 3]; 2]>>,
}

impl ColorLookup {
    /// For colours of sRGB.
    pub(crate) const SRGB: Self = Self { space: ColorSpace::Srgb, to_srgb: None };

    /// For colours of `space`.
    pub(crate) fn new(space: ColorSpace) -> Self {
        let matrix = |adaptation| {
            space.conversion_matrix(ColorSpace::Srgb, adaptation).map(|row| row.map(|x| x as f32))
        };
        let to_srgb = (space != ColorSpace::Srgb)
            .then(|| Box::new([matrix(Adaptation::Bradford), matrix(Adaptation::None)]));
        Self { space, to_srgb }
    }

    /// The space.
    pub(crate) fn space(&self) -> ColorSpace {
        self.space
    }

    /// The colour `rgb`, limited to what its role allows, in each lane.
    #[inline]
    pub(crate) fn at(&self, rgb: [f32; 3], role: ColorRole, wavelengths: &Wavelengths) -> Spectrum {
        match wavelengths {
            Wavelengths::Rgb => role.limit(self.to_srgb(rgb, role)),
            Wavelengths::Sampled(hero) => self.at_sampled(rgb, role, hero),
        }
    }

    #[inline]
    fn to_srgb(&self, rgb: [f32; 3], role: ColorRole) -> [f32; 3] {
        let transform = |m: &[[f32; 3]; 3]| m.map(|row| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]);
        match self.to_srgb.as_deref() {
            None => rgb,
            Some([_, emission]) if role == ColorRole::Illuminant => transform(emission),
            Some([reflectance, _]) => transform(reflectance),
        }
    }

    // Out of line, so that it does not crowd the code of RGB mode.
    #[inline(never)]
    fn at_sampled(&self, rgb: [f32; 3], role: ColorRole, hero: &HeroWavelengths) -> Spectrum {
        Spectrum(match role {
            ColorRole::Albedo => Uplifted::albedo(rgb, self.space).lanes(hero),
            ColorRole::Unbounded => Uplifted::unbounded(rgb, self.space).lanes(hero),
            ColorRole::Illuminant => UpliftedLight::new(rgb, self.space).lanes(hero),
        })
    }
}
