//! Hair and fur.

use sahl_scene::{Diagnostics, FloatParam, Span};

use super::Query;
use crate::bsdf::room::Large;
use crate::bsdf::{Bsdf, BsdfRoom, Hair, HairShape};
use crate::spectrum::{ColorRole, SpectralCurve, Spectrum};
use crate::texture::{FloatSource, SpectrumSource, Textures};

/// Absorption per radius of hair with one unit of eumelanin, linear sRGB: d'Eon et al. 2011.
const EUMELANIN: [f32; 3] = [0.419, 0.697, 1.37];
/// The same for pheomelanin.
const PHEOMELANIN: [f32; 3] = [0.187, 0.4, 1.05];

/// The parameters of a fibre.
#[derive(Clone, Debug, PartialEq)]
pub struct HairSource {
    color: Color,
    eta: FloatSource,
    beta_m: FloatSource,
    beta_n: FloatSource,
    alpha: FloatSource,
}

#[derive(Clone, Debug, PartialEq)]
enum Color {
    /// σa per radius.
    Absorption(SpectrumSource),
    /// The colour of a full head of such hair.
    Reflectance(SpectrumSource),
    /// Concentrations that vary over the surface, and the σa of one unit of each.
    Melanin([(FloatSource, SpectralCurve); 2]),
}

impl HairSource {
    pub(super) fn new(
        hair: &sahl_scene::Hair,
        textures: &Textures,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        Self {
            color: Color::new(&hair.color, textures, span, diagnostics),
            eta: textures.float_source(&hair.eta),
            beta_m: textures.float_source(&hair.beta_m),
            beta_n: textures.float_source(&hair.beta_n),
            alpha: textures.float_source(&hair.alpha),
        }
    }

    #[inline(never)]
    pub(super) fn bsdf<'r>(&self, query: &Query<'_>, room: &'r mut BsdfRoom) -> Bsdf<'r> {
        let beta_n = query.float(&self.beta_n);
        let sigma_a = match &self.color {
            Color::Absorption(sigma_a) => query.spectrum(sigma_a),
            Color::Reflectance(color) => absorption_of_color(query.spectrum(color), beta_n),
            Color::Melanin(pigments) => {
                let mut sigma_a = Spectrum::ZERO;
                for (amount, of_one) in pigments {
                    sigma_a += of_one.at(query.wavelengths) * query.float(amount).max(0.0);
                }
                sigma_a
            }
        };
        let shape = HairShape {
            eta: query.float(&self.eta),
            beta_m: query.float(&self.beta_m),
            beta_n,
            alpha: query.float(&self.alpha),
        };
        room.keep(Large::Hair(Hair::new(2.0 * query.at.uv.y - 1.0, &shape, sigma_a)))
    }
}

impl Color {
    fn new(
        color: &sahl_scene::HairColor,
        textures: &Textures,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let mut curve = |rgb: [f32; 3]| {
            SpectralCurve::new(&sahl_scene::Spectrum::srgb(rgb), ColorRole::Unbounded, span, diagnostics)
        };
        match color {
            sahl_scene::HairColor::Absorption(sigma_a) => {
                Self::Absorption(textures.spectrum_source(sigma_a, ColorRole::Unbounded, span, diagnostics))
            }
            sahl_scene::HairColor::Reflectance(color) => {
                Self::Reflectance(textures.spectrum_source(color, ColorRole::Albedo, span, diagnostics))
            }
            sahl_scene::HairColor::Melanin {
                eumelanin: FloatParam::Constant(eumelanin),
                pheomelanin: FloatParam::Constant(pheomelanin),
            } => {
                // One colour for both, as pbrt-v4 makes one spectrum of their sum.
                let sum = std::array::from_fn(|i| eumelanin * EUMELANIN[i] + pheomelanin * PHEOMELANIN[i]);
                Self::Absorption(SpectrumSource::Constant(curve(sum)))
            }
            sahl_scene::HairColor::Melanin { eumelanin, pheomelanin } => Self::Melanin([
                (textures.float_source(eumelanin), curve(EUMELANIN)),
                (textures.float_source(pheomelanin), curve(PHEOMELANIN)),
            ]),
        }
    }
}

/// The σa of fibres that look like `color` together; Chiang et al. 2016, equation 9.
fn absorption_of_color(color: Spectrum, beta_n: f32) -> Spectrum {
    let b = beta_n;
    let fit = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))));
    color.map(|c| {
        // Black takes an absorption without end.
        let root = (c.ln() / fit).max(-f32::MAX.sqrt());
        root * root
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_become_absorption_and_black_is_finite() {
        let sigma = absorption_of_color(Spectrum::from_rgb([1.0, 0.5, 0.0]), 0.3);
        let [r, g, b] = sigma.to_rgb();
        assert!(r == 0.0 && b.is_finite() && b > 1e30);
        // ln 0.5 over the fit at 0.3, which is 5.887 14, squared.
        assert!((g - 0.013_862).abs() < 1e-4, "{g}");
    }
}
