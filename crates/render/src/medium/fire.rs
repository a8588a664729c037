//! Light of hot matter.

use sahl_image::ColorSpace;

use crate::spectrum::{Spectrum, Wavelengths, cie};

/// Below this temperature nothing glows: pbrt-v4's limit.
const COLDEST: f32 = 100.0;

/// Temperatures in the table of colours.
const ENTRIES: usize = 256;

/// Thermal emission of matter up to a temperature, relative to the peak of each temperature over all wavelengths: so hot
/// matter is no brighter than warm matter, as in pbrt-v4, which leaves that to a factor.
///
/// Source: Planck's law. With colours in RGB it is looked up in a table over temperatures.
#[derive(Clone, Debug)]
pub(super) struct Fire {
    hottest: f32,
    /// The colours of temperatures from zero to the highest, equally far apart.
    colors: Box<[Spectrum]>,
}

impl Fire {
    /// Emission up to `hottest` kelvin.
    pub(super) fn new(hottest: f32) -> Self {
        let hottest = hottest.max(COLDEST);
        let color = |i: usize| {
            let kelvin = hottest * i as f32 / (ENTRIES - 1) as f32;
            let xyz = cie::xyz(|lambda| cie::blackbody(kelvin, lambda));
            Spectrum::from_rgb(ColorSpace::Srgb.xyz_to_rgb(xyz).map(|x| x.max(0.0)))
        };
        Self { hottest, colors: (0..ENTRIES).map(color).collect() }
    }

    /// The radiance of a black body at a temperature in kelvin.
    pub(super) fn at(&self, kelvin: f32, wavelengths: &Wavelengths) -> Spectrum {
        if kelvin <= COLDEST {
            return Spectrum::ZERO;
        }
        match wavelengths {
            Wavelengths::Rgb => {
                let place = (kelvin / self.hottest).min(1.0) * (ENTRIES - 1) as f32;
                let before = (place as usize).min(ENTRIES - 2);
                let (cooler, hotter) = (self.colors[before], self.colors[before + 1]);
                cooler + (hotter - cooler) * (place - before as f32)
            }
            Wavelengths::Sampled(hero) => {
                Spectrum::from_lanes(hero.lambda().map(|lambda| cie::blackbody(kelvin, lambda)))
            }
        }
    }
}
