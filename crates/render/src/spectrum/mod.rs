//! Colour as the renderer carries it: four lanes whose meaning is in the [`Wavelengths`] of the path.
//!
//! Design decision: every formula between emission and film multiplies and adds [`Spectrum`] lanes without asking what
//! they mean. Only three places ask: turning a file's colour into a [`Spectrum`] ([`SpectralCurve::at`]), dispersion,
//! and the film's sensor. In RGB mode the lanes are linear sRGB; in spectral mode each is a wavelength of its own.
//!
//! Deliberately absent: generics over colour, and colour management of images (the crate `sahl_image` has it).

pub(crate) mod cie;
mod curve;
mod dense;
mod hero;
mod lookup;
mod named;
mod table;
mod uplift;

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

use glam::Vec4;

pub use curve::{ColorRole, SpectralCurve};
pub(crate) use curve::{RGB_MODE_CODES, measured_rgb_weights};
pub use hero::{HeroWavelengths, sample_visible, visible_pdf};
pub(crate) use lookup::ColorLookup;

/// A quantity at each of the four lanes of a path.
///
/// In RGB mode the lanes are red, green and blue of linear sRGB, and green once more, so that maxima and finiteness
/// checks over all lanes need no special case.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(transparent)]
pub struct Spectrum(Vec4);

impl Spectrum {
    /// Zero in every lane.
    pub const ZERO: Self = Self(Vec4::ZERO);
    /// One in every lane.
    pub const ONE: Self = Self(Vec4::ONE);

    /// The same value in every lane.
    #[inline]
    pub const fn splat(value: f32) -> Self {
        Self(Vec4::splat(value))
    }

    /// A colour in linear sRGB (RGB mode).
    #[inline]
    pub const fn from_rgb([r, g, b]: [f32; 3]) -> Self {
        Self(Vec4::new(r, g, b, g))
    }

    /// The colour in linear sRGB (RGB mode).
    #[inline]
    pub const fn to_rgb(self) -> [f32; 3] {
        let [r, g, b, _] = self.0.to_array();
        [r, g, b]
    }

    /// The spectrum with the given lanes.
    #[inline]
    pub const fn from_lanes(lanes: [f32; 4]) -> Self {
        Self(Vec4::from_array(lanes))
    }

    /// The lanes.
    #[inline]
    pub const fn lanes(self) -> [f32; 4] {
        self.0.to_array()
    }

    /// Applies `f` to each lane.
    #[inline]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self::from_lanes(self.lanes().map(f))
    }

    /// Applies `f` to each pair of lanes.
    #[inline]
    pub fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let (a, b) = (self.lanes(), other.lanes());
        Self::from_lanes(std::array::from_fn(|lane| f(a[lane], b[lane])))
    }

    /// The largest lane.
    #[inline]
    pub fn max_component(self) -> f32 {
        self.0.max_element()
    }

    /// The smallest lane.
    #[inline]
    pub fn min_component(self) -> f32 {
        self.0.min_element()
    }

    /// The mean of the lanes; in RGB mode green counts twice.
    #[inline]
    pub fn average(self) -> f32 {
        self.0.element_sum() * 0.25
    }

    /// Relative luminance of linear sRGB (RGB mode); ITU-R BT.709, 3.2.
    #[inline]
    pub fn luminance(self) -> f32 {
        let [r, g, b] = self.to_rgb();
        0.212_639 * r + 0.715_169 * g + 0.072_192 * b
    }

    /// Whether every lane is zero.
    #[inline]
    pub fn is_zero(self) -> bool {
        self.0 == Vec4::ZERO
    }

    /// Whether no lane is infinite or NaN.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    /// The square root of each lane.
    #[inline]
    pub fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }

    /// e to the power of each lane.
    #[inline]
    pub fn exp(self) -> Self {
        self.map(f32::exp)
    }

    /// Each lane limited to [`low`, `high`].
    #[inline]
    pub fn clamp(self, low: f32, high: f32) -> Self {
        Self(self.0.clamp(Vec4::splat(low), Vec4::splat(high)))
    }
}

/// The lane-wise operators with a spectrum and with a number on the right.
macro_rules! lanewise {
    ($($Trait:ident $method:ident),+) => {$(
        impl $Trait for Spectrum {
            type Output = Self;
            #[inline]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }

        impl $Trait<f32> for Spectrum {
            type Output = Self;
            #[inline]
            fn $method(self, other: f32) -> Self {
                Self(self.0.$method(other))
            }
        }
    )+};
}

lanewise!(Add add, Sub sub, Mul mul, Div div);

impl Mul<Spectrum> for f32 {
    type Output = Spectrum;
    #[inline]
    fn mul(self, spectrum: Spectrum) -> Spectrum {
        spectrum * self
    }
}

impl AddAssign for Spectrum {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl MulAssign for Spectrum {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        self.0 *= other.0;
    }
}

impl MulAssign<f32> for Spectrum {
    #[inline]
    fn mul_assign(&mut self, factor: f32) {
        self.0 *= factor;
    }
}

/// What the lanes of a path's spectra stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Wavelengths {
    /// Red, green, blue of linear sRGB, and green again.
    #[default]
    Rgb,
    /// Four wavelengths.
    Sampled(HeroWavelengths),
}

impl Wavelengths {
    /// Whether the path follows its first wavelength alone.
    #[inline]
    pub fn is_terminated(&self) -> bool {
        matches!(self, Self::Sampled(hero) if hero.is_terminated())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spare_lane_repeats_green() {
        let s = Spectrum::from_rgb([1.0, 2.0, 0.5]);
        assert_eq!(s.lanes(), [1.0, 2.0, 0.5, 2.0]);
        assert_eq!((s * s + 1.0 - Spectrum::ONE).to_rgb(), [1.0, 4.0, 0.25]);
        assert_eq!((2.0 * s / 2.0).max_component(), 2.0);
        assert_eq!((s * s).sqrt().min_component(), 0.5);
    }

    #[test]
    fn one_bad_lane_is_not_finite() {
        assert!(!Spectrum::from_rgb([0.0, f32::NAN, 0.0]).is_finite());
        assert!(!Spectrum::from_rgb([0.0, 0.0, f32::INFINITY]).is_finite());
        assert!(Spectrum::ZERO.is_finite() && Spectrum::ZERO.is_zero());
    }

    #[test]
    fn white_has_luminance_one() {
        assert!((Spectrum::ONE.luminance() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_data_is_what_was_checked() {
        // FNV-1a, 64 bits. A file that changes needs a new number here and a word in data/color/PROVENANCE.md.
        let checksum = |bytes: &[u8]| {
            bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            })
        };
        let files: [(&[u8], u64); 12] = [
            (include_bytes!("../../../../data/color/cie-1931-2deg.csv"), 0x7b70_aded_5821_555c),
            (include_bytes!("../../../../data/color/cie-illuminants.csv"), 0x058e_0f4f_2c2c_a599),
            (include_bytes!("../../../../data/color/metals.csv"), 0xa2ab_7c45_a59e_817c),
            (include_bytes!("../../../../data/color/uplift-srgb.bin"), 0x06e1_4839_c2a3_bee9),
            (include_bytes!("../../../../data/color/uplift-dci-p3.bin"), 0xb666_f1c1_66f5_c90c),
            (include_bytes!("../../../../data/color/uplift-rec2020.bin"), 0x6b31_21bc_7afa_5e4a),
            (include_bytes!("../../../../data/color/uplift-aces2065-1.bin"), 0x700d_7e17_efd9_7cc3),
            (include_bytes!("../../../../data/color/uplift-light-srgb.bin"), 0x19fb_b0d7_97cb_79b7),
            (include_bytes!("../../../../data/color/uplift-light-dci-p3.bin"), 0xbbca_dda5_17ad_8081),
            (include_bytes!("../../../../data/color/uplift-light-rec2020.bin"), 0xe299_a5b9_5201_8e87),
            (include_bytes!("../../../../data/color/uplift-light-aces2065-1.bin"), 0xcd7a_bcb6_52c2_619f),
            (include_bytes!("../../../../data/color/illuminant-d60.csv"), 0x98f6_4fd9_47ad_23b4),
        ];
        for (place, (bytes, expected)) in files.into_iter().enumerate() {
            assert_eq!(checksum(bytes), expected, "file {place} of the list: {:#x}", checksum(bytes));
        }
    }
}
