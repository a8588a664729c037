//! From a colour as a scene file gives it to lanes.

use sahl_image::ColorSpace;
use sahl_scene::{Diagnostic, Diagnostics, Span};

use super::cie;
use super::named::{self, NamedSpectrum};
use super::{Spectrum, Wavelengths};

/// Negative components up to this share of the largest are taken for rounding of colour matrices.
const GAMUT_SLACK: f32 = 1e-3;

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
/// RGB mode has no more of it than its linear sRGB components: spectra are reduced when the scene is built. Reflectances
/// are seen under a black body of 6504 K and scaled such that a flat spectrum keeps its value in all lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralCurve {
    rgb: Spectrum,
}

impl SpectralCurve {
    /// Makes `spectrum` ready for its `role`.
    ///
    /// What RGB can't tell is approximated, with a warning; an unknown name is an error, and the curve is then zero.
    /// `span` is what messages point at.
    pub fn new(
        spectrum: &sahl_scene::Spectrum,
        role: ColorRole,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let rgb = match spectrum {
            sahl_scene::Spectrum::Constant(value) => [*value; 3],
            sahl_scene::Spectrum::Rgb { rgb, space } => to_srgb(*rgb, *space, role),
            sahl_scene::Spectrum::Blackbody(kelvin) => {
                from_power(|lambda| cie::blackbody(*kelvin, lambda), role)
            }
            sahl_scene::Spectrum::Sampled(samples) => {
                if role != ColorRole::Illuminant {
                    diagnostics.push(approximated(span, "a sampled spectrum"));
                }
                from_power(|lambda| interpolate(samples, lambda), role)
            }
            sahl_scene::Spectrum::Named(name) => from_name(name, role, span, diagnostics),
        };
        let (low, high) = match role {
            ColorRole::Albedo => (0.0, 1.0),
            ColorRole::Unbounded | ColorRole::Illuminant => (0.0, f32::MAX),
        };
        let largest = rgb[0].max(rgb[1]).max(rgb[2]);
        if largest > 0.0 && rgb.iter().any(|&x| x < -GAMUT_SLACK * largest) {
            let message =
                format!("the colour {rgb:.3?} in linear sRGB is outside its gamut, and is clipped to it");
            diagnostics.push(Diagnostic::warning("color-gamut", span, message));
        }
        Self { rgb: Spectrum::from_rgb(rgb).clamp(low, high) }
    }

    /// The curve that is `value` everywhere.
    pub const fn constant(value: f32) -> Self {
        Self { rgb: Spectrum::splat(value) }
    }

    /// The value in each lane.
    #[inline]
    pub fn at(&self, wavelengths: &Wavelengths) -> Spectrum {
        match wavelengths {
            Wavelengths::Rgb => self.rgb,
        }
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

/// RGB of a spectral distribution: as emission, with luminance one; otherwise as a quantity averaged over wavelengths.
fn from_power(power: impl Fn(f32) -> f32, role: ColorRole) -> [f32; 3] {
    if role == ColorRole::Illuminant {
        let [x, y, z] = cie::xyz(power);
        return if y > 0.0 { ColorSpace::Srgb.xyz_to_rgb([x / y, 1.0, z / y]) } else { [0.0; 3] };
    }
    let daylight = |lambda| cie::blackbody(6504.0, lambda);
    let seen = ColorSpace::Srgb.xyz_to_rgb(cie::xyz(|lambda| power(lambda) * daylight(lambda)));
    let white = ColorSpace::Srgb.xyz_to_rgb(cie::xyz(daylight));
    std::array::from_fn(|lane| seen[lane] / white[lane])
}

/// The value at `lambda` between samples: linear; zero outside their range.
fn interpolate(samples: &[(f32, f32)], lambda: f32) -> f32 {
    let after = samples.partition_point(|&(wavelength, _)| wavelength < lambda);
    match (after.checked_sub(1).and_then(|before| samples.get(before)), samples.get(after)) {
        (_, Some(&(wavelength, value))) if wavelength == lambda => value,
        (Some(&(x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * (lambda - x0) / (x1 - x0),
        _ => 0.0,
    }
}

fn from_name(name: &str, role: ColorRole, span: Option<Span>, diagnostics: &mut Diagnostics) -> [f32; 3] {
    match named::find(name) {
        Some(NamedSpectrum::Rgb(rgb)) => {
            diagnostics.push(approximated(span, &format!("the spectrum `{name}`")));
            rgb
        }
        Some(NamedSpectrum::Index(index)) => {
            diagnostics.push(
                Diagnostic::warning(
                    "spectrum-approximated",
                    span,
                    format!(
                        "the spectrum `{name}` is approximated in RGB mode by its index at 587.6 nm, {index}"
                    ),
                )
                .with_note("there is no dispersion in RGB mode"),
            );
            [index; 3]
        }
        Some(NamedSpectrum::Illuminant(xy)) if role == ColorRole::Illuminant => {
            ColorSpace::Srgb.xyz_to_rgb(cie::xyz_of_chromaticity(xy))
        }
        Some(NamedSpectrum::Illuminant(_)) => {
            diagnostics.push(approximated(span, &format!("the illuminant `{name}` as a reflectance")));
            [1.0; 3]
        }
        None => {
            diagnostics.push(unknown_name(name, span));
            [0.0; 3]
        }
    }
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
    fn samples_are_joined_by_lines() {
        let samples = [(400.0, 1.0), (500.0, 3.0)];
        for (lambda, expected) in [(399.9, 0.0), (400.0, 1.0), (450.0, 2.0), (500.0, 3.0), (500.1, 0.0)] {
            assert_eq!(interpolate(&samples, lambda), expected, "{lambda}");
        }
        assert_eq!(interpolate(&[], 500.0), 0.0);
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
