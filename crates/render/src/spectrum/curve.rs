//! From a colour as a scene file gives it to lanes.
//!
//! Design decision: a curve has the lanes of RGB mode and the function of spectral mode side by side. A path in RGB mode reads
//! sixteen bytes and a tag; and what is no light (features for denoisers, the choice among lights) is found in RGB in
//! either mode, without noise of colour.
//!
//! Deliberately absent: a choice of mode when a scene is built.

use std::sync::Arc;

use sahl_image::ColorSpace;
use sahl_scene::{Diagnostic, Diagnostics, Span};

use super::cie;
use super::dense::DenseSpectrum;
use super::hero::HeroWavelengths;
use super::named::{self, NamedSpectrum};
use super::table::{Outside, interpolate};
use super::uplift::{Uplifted, UpliftedLight};
use super::{Spectrum, Wavelengths};

/// Negative components up to this share of the largest are taken for rounding of colour matrices.
const GAMUT_SLACK: f32 = 1e-3;

/// Codes of warnings that tell what RGB mode approximates: in spectral mode they do not hold.
pub(crate) const RGB_MODE_CODES: [&str; 2] = ["spectrum-approximated", "color-gamut"];

/// What a colour is for, which decides how a spectrum becomes RGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorRole {
    /// A share of light that is scattered: limited to [0, 1].
    Albedo,
    /// Any other quantity, such as an index of refraction: at least zero.
    Unbounded,
    /// Emitted light. Spectra other than RGB and constants are scaled to luminance one, as in pbrt-v4, where a
    /// constant stands for the white of the colour space.
    Illuminant,
}

/// A colour of the scene, ready to be evaluated at the wavelengths of a path.
///
/// It has both: its linear sRGB components, and what stands for it in spectral mode. Reflectances are seen under D65 and
/// scaled such that a flat spectrum keeps its value in all lanes.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralCurve {
    rgb: Spectrum,
    sampled: Sampled,
}

/// A function of wavelength.
#[derive(Clone, Debug, PartialEq)]
enum Sampled {
    /// The same everywhere.
    Constant(f32),
    /// A quantity that was given by its colour.
    Color(Uplifted),
    /// Light that was given by its colour.
    Light(UpliftedLight),
    /// Anything else; shared by everything that the scene makes of it.
    Table(Arc<DenseSpectrum>),
}

impl SpectralCurve {
    /// Makes `spectrum` ready for its `role`.
    ///
    /// What RGB can't tell is approximated there, with a warning of a code among `RGB_MODE_CODES`; an unknown name is an
    /// error, and the curve is then zero. `span` is what messages point at.
    pub fn new(
        spectrum: &sahl_scene::Spectrum,
        role: ColorRole,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let dense = match spectrum {
            sahl_scene::Spectrum::Constant(value) => return Self::of_constant(*value, role),
            sahl_scene::Spectrum::Rgb { rgb, space } => {
                return Self::of_rgb(*rgb, *space, role, span, diagnostics);
            }
            sahl_scene::Spectrum::Blackbody(kelvin) => {
                DenseSpectrum::new(|lambda| cie::blackbody(*kelvin, lambda))
            }
            sahl_scene::Spectrum::Sampled(samples) => {
                if role != ColorRole::Illuminant {
                    diagnostics.push(approximated(span, "a sampled spectrum"));
                }
                DenseSpectrum::new(|lambda| interpolate(samples, lambda, Outside::Zero))
            }
            sahl_scene::Spectrum::Named(name) => match named::find(name) {
                Some(found) => return Self::of_named(name, &found, role, span, diagnostics),
                None => {
                    diagnostics.push(unknown_name(name, span));
                    return Self::constant(0.0);
                }
            },
        };
        Self::of_dense(dense, role)
    }

    /// The curve that is `value` everywhere.
    pub const fn constant(value: f32) -> Self {
        Self { rgb: Spectrum::splat(value), sampled: Sampled::Constant(value) }
    }

    /// A constant; as light it stands for the white of sRGB.
    fn of_constant(value: f32, role: ColorRole) -> Self {
        let (low, high) = role.limits();
        let value = value.clamp(low, high);
        match role {
            ColorRole::Albedo | ColorRole::Unbounded => Self::constant(value),
            ColorRole::Illuminant => {
                let light = UpliftedLight::new([value; 3], ColorSpace::Srgb);
                Self { rgb: Spectrum::splat(value), sampled: Sampled::Light(light) }
            }
        }
    }

    fn of_rgb(
        rgb: [f32; 3],
        space: ColorSpace,
        role: ColorRole,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let [r, g, b] = rgb;
        if r == g && g == b && role != ColorRole::Illuminant {
            return Self::of_constant(r, role);
        }
        let sampled = match role {
            ColorRole::Albedo => Sampled::Color(Uplifted::exact_albedo(rgb, space)),
            ColorRole::Unbounded => Sampled::Color(Uplifted::exact_unbounded(rgb, space)),
            ColorRole::Illuminant => Sampled::Light(UpliftedLight::new(rgb, space)),
        };
        let rgb = to_srgb(rgb, space, role);
        let largest = rgb[0].max(rgb[1]).max(rgb[2]);
        if largest > 0.0 && rgb.iter().any(|&x| x < -GAMUT_SLACK * largest) {
            let message =
                format!("the colour {rgb:.3?} in linear sRGB is outside its gamut, and is clipped to it");
            diagnostics.push(Diagnostic::warning("color-gamut", span, message));
        }
        Self { rgb: role.limit(rgb), sampled }
    }

    /// A distribution over wavelengths; as light it is scaled to luminance one.
    fn of_dense(dense: DenseSpectrum, role: ColorRole) -> Self {
        let (low, high) = role.limits();
        let dense = match role {
            ColorRole::Illuminant => cie::with_luminance_one(dense),
            ColorRole::Albedo | ColorRole::Unbounded => dense,
        };
        let rgb = role.limit(rgb_of(&dense, role));
        Self { rgb, sampled: Sampled::Table(Arc::new(dense.map(|value| value.clamp(low, high)))) }
    }

    fn of_named(
        name: &str,
        found: &NamedSpectrum,
        role: ColorRole,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        match found {
            NamedSpectrum::Measured(dense) => Self::of_dense(dense.clone(), role),
            NamedSpectrum::Index { index, dense } => {
                diagnostics.push(
                    Diagnostic::warning(
                        "spectrum-approximated",
                        span,
                        format!(
                            "the spectrum `{name}` is approximated in RGB mode by its index at 587.6 nm, {index:.4}"
                        ),
                    )
                    .with_note("there is no dispersion in RGB mode"),
                );
                Self { rgb: role.limit([*index; 3]), ..Self::of_dense(dense.clone(), role) }
            }
            NamedSpectrum::Illuminant(dense) => {
                if role != ColorRole::Illuminant {
                    diagnostics
                        .push(approximated(span, &format!("the illuminant `{name}` as a reflectance")));
                }
                Self::of_dense(dense.clone(), role)
            }
        }
    }

    /// The value in each lane.
    #[inline]
    pub fn at(&self, wavelengths: &Wavelengths) -> Spectrum {
        match wavelengths {
            Wavelengths::Rgb => self.rgb,
            Wavelengths::Sampled(hero) => self.at_sampled(hero),
        }
    }

    /// The value of an index of refraction for a path, which can follow only one: where the index varies, the path goes on
    /// with its first wavelength alone, of which its throughput has to learn ([`HeroWavelengths::terminate_secondary`]). In RGB mode it is
    /// the mean of the lanes.
    #[inline]
    pub fn index(&self, wavelengths: &mut Wavelengths) -> f32 {
        match (wavelengths, &self.sampled) {
            (Wavelengths::Rgb, _) => self.rgb.average(),
            (Wavelengths::Sampled(_), Sampled::Constant(value)) => *value,
            (Wavelengths::Sampled(hero), _) => {
                hero.terminate_secondary();
                self.at_sampled(hero).lanes()[0]
            }
        }
    }

    // Out of line, so that it does not crowd the code of RGB mode.
    #[inline(never)]
    fn at_sampled(&self, hero: &HeroWavelengths) -> Spectrum {
        Spectrum(match &self.sampled {
            Sampled::Constant(value) => return Spectrum::splat(*value),
            Sampled::Color(color) => color.lanes(hero),
            Sampled::Light(light) => light.lanes(hero),
            Sampled::Table(table) => table.lanes(hero),
        })
    }
}

impl ColorRole {
    /// The least and the largest value.
    pub(super) const fn limits(self) -> (f32, f32) {
        match self {
            Self::Albedo => (0.0, 1.0),
            Self::Unbounded | Self::Illuminant => (0.0, f32::MAX),
        }
    }

    /// The lanes of a colour, brought to where the role allows them.
    #[inline]
    pub(super) fn limit(self, rgb: [f32; 3]) -> Spectrum {
        let (low, high) = self.limits();
        Spectrum::from_rgb(rgb).clamp(low, high)
    }
}

/// Linear sRGB of linear RGB in another space; components of colours outside the gamut of sRGB are negative.
///
/// Emission keeps its light, so that the white of ACES is warmer than that of sRGB; what is not light maps white to
/// white.
fn to_srgb(rgb: [f32; 3], space: ColorSpace, role: ColorRole) -> [f32; 3] {
    match role {
        ColorRole::Illuminant => space.convert(ColorSpace::Srgb, rgb),
        ColorRole::Albedo | ColorRole::Unbounded => space.convert_reflectance(ColorSpace::Srgb, rgb),
    }
}

/// Linear sRGB of a spectral distribution: as emission its colour; otherwise as a quantity averaged over wavelengths under D65.
fn rgb_of(dense: &DenseSpectrum, role: ColorRole) -> [f32; 3] {
    if role == ColorRole::Illuminant {
        return ColorSpace::Srgb.xyz_to_rgb(cie::xyz(|lambda| dense.at(lambda)));
    }
    let daylight = cie::white(ColorSpace::Srgb);
    let seen = ColorSpace::Srgb.xyz_to_rgb(cie::xyz(|lambda| dense.at(lambda) * daylight.at(lambda)));
    let white = ColorSpace::Srgb.xyz_to_rgb(cie::xyz(|lambda| daylight.at(lambda)));
    std::array::from_fn(|lane| seen[lane] / white[lane])
}

/// The linear sRGB components of reflectances that are given at the wavelengths `knots`, for each of these: a reflectance is the
/// sum of its values times them. Between the wavelengths it is linear, outside them constant.
pub(crate) fn measured_rgb_weights(
    knots: &[f32],
    span: Option<Span>,
    diagnostics: &mut Diagnostics,
) -> Vec<[f32; 3]> {
    diagnostics.push(approximated(span, "a measured surface"));
    let hat = |peak: usize| {
        let samples: Vec<(f32, f32)> = knots
            .iter()
            .enumerate()
            .map(|(knot, &lambda)| (lambda, if knot == peak { 1.0 } else { 0.0 }))
            .collect();
        DenseSpectrum::new(|lambda| interpolate(&samples, lambda, Outside::Ends))
    };
    (0..knots.len()).map(|peak| rgb_of(&hat(peak), ColorRole::Albedo)).collect()
}

fn approximated(span: Option<Span>, what: &str) -> Diagnostic {
    Diagnostic::warning(
        "spectrum-approximated",
        span,
        format!("{what} is approximated by its colour in RGB mode"),
    )
}

fn unknown_name(name: &str, span: Option<Span>) -> Diagnostic {
    let error = Diagnostic::error("unknown-spectrum", span, format!("unknown named spectrum `{name}`"));
    let names: Vec<String> = named::names().collect();
    match sahl_scene::suggest::nearest(name, names.iter().map(String::as_str)) {
        Some(nearest) => error.with_help(format!("did you mean `{nearest}`?")),
        None => error.with_note(format!("known names: {}", names.join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(spectrum: &sahl_scene::Spectrum, role: ColorRole) -> (Spectrum, Diagnostics) {
        let mut diagnostics = Diagnostics::default();
        let curve = SpectralCurve::new(spectrum, role, None, &mut diagnostics);
        (curve.at(&Wavelengths::Rgb), diagnostics)
    }

    fn assert_close(found: Spectrum, expected: [f32; 3], tolerance: f32) {
        for (a, b) in found.to_rgb().into_iter().zip(expected) {
            assert!((a - b).abs() <= tolerance, "{found:?} against {expected:?}");
        }
    }

    #[test]
    fn rgb_and_constants_are_themselves() {
        let (s, diagnostics) = curve(&sahl_scene::Spectrum::srgb([0.1, 2.0, 3.0]), ColorRole::Illuminant);
        assert_eq!(s, Spectrum::from_rgb([0.1, 2.0, 3.0]));
        assert!(diagnostics.is_empty());
        let (s, _) = curve(&sahl_scene::Spectrum::srgb([0.1, 2.0, -3.0]), ColorRole::Albedo);
        assert_eq!(s, Spectrum::from_rgb([0.1, 1.0, 0.0]));
        assert_eq!(curve(&sahl_scene::Spectrum::Constant(1.5), ColorRole::Unbounded).0, Spectrum::splat(1.5));
    }

    #[test]
    fn white_is_white_in_every_space_unless_it_is_light() {
        for space in [ColorSpace::DciP3, ColorSpace::Rec2020, ColorSpace::Aces2065_1] {
            let white = sahl_scene::Spectrum::Rgb { rgb: [1.0; 3], space };
            assert_close(curve(&white, ColorRole::Albedo).0, [1.0; 3], 1e-5);
            let light = curve(&white, ColorRole::Illuminant).0;
            assert!((light.luminance() - 1.0).abs() < 1e-5);
            assert_eq!(space == ColorSpace::Aces2065_1, light.to_rgb()[0] > light.to_rgb()[2] + 0.05);
        }
    }

    #[test]
    fn emission_has_luminance_one() {
        let flat = sahl_scene::Spectrum::Sampled(vec![(300.0, 7.0), (900.0, 7.0)]);
        for spectrum in [flat, sahl_scene::Spectrum::Blackbody(4000.0)] {
            let (s, diagnostics) = curve(&spectrum, ColorRole::Illuminant);
            assert!((s.luminance() - 1.0).abs() < 1e-3, "{s:?}");
            assert!(diagnostics.is_empty());
        }
        let (d65, _) = curve(&sahl_scene::Spectrum::Named("stdillum-D65".into()), ColorRole::Illuminant);
        assert_close(d65, [1.0; 3], 1e-3);
    }

    #[test]
    fn a_flat_reflectance_keeps_its_value_and_a_red_one_is_red() {
        let flat = sahl_scene::Spectrum::Sampled(vec![(300.0, 0.25), (900.0, 0.25)]);
        let (s, diagnostics) = curve(&flat, ColorRole::Albedo);
        assert_close(s, [0.25; 3], 1e-5);
        assert_eq!(diagnostics.iter().next().map(|d| d.code), Some("spectrum-approximated"));
        let edge =
            sahl_scene::Spectrum::Sampled(vec![(300.0, 0.0), (590.0, 0.0), (600.0, 1.0), (900.0, 1.0)]);
        let [r, g, b] = curve(&edge, ColorRole::Albedo).0.to_rgb();
        assert!(r > 0.7 && g < 0.2 && b < 0.1, "{r} {g} {b}");
    }

    #[test]
    fn unknown_names_are_errors_with_the_nearest_name() {
        let (s, diagnostics) =
            curve(&sahl_scene::Spectrum::Named("metal-Cu-etta".into()), ColorRole::Unbounded);
        assert!(s.is_zero() && diagnostics.has_errors());
        let help = diagnostics.iter().next().and_then(|d| d.help.clone());
        assert_eq!(help.as_deref(), Some("did you mean `metal-Cu-eta`?"));
        let (s, diagnostics) = curve(&sahl_scene::Spectrum::Named("glass-BK7".into()), ColorRole::Unbounded);
        assert_eq!(s, Spectrum::splat(1.5168));
        assert!(!diagnostics.has_errors() && !diagnostics.is_empty());
    }
}
