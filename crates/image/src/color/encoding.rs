//! What a stored value means.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

/// What a stored value means.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Encoding {
    /// The quantity itself.
    Linear,
    /// IEC 61966-2-1.
    Srgb,
    /// The quantity raised to one over this.
    Gamma(f32),
}

/// The quantities that the sRGB values 0/255 to 255/255 stand for.
static SRGB_TABLE: LazyLock<[f32; 256]> = LazyLock::new(|| table(srgb_decode));

impl Encoding {
    /// The quantity that `stored` stands for.
    ///
    /// The linear piece of the sRGB curve goes on below 0 and its power piece above 1; negative values of
    /// [`Encoding::Gamma`] are mirrored. So every finite value survives [`Encoding::encode`] and back.
    ///
    /// Source: IEC 61966-2-1:1999, section 5.2.
    #[inline]
    pub fn decode(self, stored: f32) -> f32 {
        match self {
            Encoding::Linear => stored,
            Encoding::Srgb if stored <= 0.04045 => stored / 12.92,
            Encoding::Srgb => ((stored + 0.055) / 1.055).powf(2.4),
            Encoding::Gamma(gamma) => stored.abs().powf(gamma).copysign(stored),
        }
    }

    /// The value to store for `quantity`: the inverse of [`Encoding::decode`].
    ///
    /// Source: IEC 61966-2-1:1999, section 5.3.
    #[inline]
    pub fn encode(self, quantity: f32) -> f32 {
        match self {
            Encoding::Linear => quantity,
            Encoding::Srgb if quantity <= 0.003_130_8 => quantity * 12.92,
            // The same as 1.055 q^(1/2.4) − 0.055, arranged so that 1 stays 1 in spite of rounding.
            Encoding::Srgb => 1.0 + 1.055 * (quantity.powf(1.0 / 2.4) - 1.0),
            Encoding::Gamma(gamma) => quantity.abs().powf(1.0 / gamma).copysign(quantity),
        }
    }

    /// The quantity that the 8-bit value `stored` / 255 stands for; a table look-up for sRGB.
    #[inline]
    pub fn decode_u8(self, stored: u8) -> f32 {
        match self {
            Encoding::Srgb => SRGB_TABLE[usize::from(stored)],
            _ => self.decode(f32::from(stored) / 255.0),
        }
    }

    /// [`Encoding::decode_u8`] of every value from 0 to 255, for who decodes many.
    pub fn decode_table(self) -> [f32; 256] {
        match self {
            Encoding::Linear => table(|stored| stored),
            Encoding::Srgb => *SRGB_TABLE,
            Encoding::Gamma(gamma) => table(|stored| stored.powf(f64::from(gamma))),
        }
    }
}

/// `decode` of the 256 values n/255, rounded once.
fn table(decode: impl Fn(f64) -> f64) -> [f32; 256] {
    std::array::from_fn(|stored| decode(stored as f64 / 255.0) as f32)
}

/// The sRGB curve in `f64`.
fn srgb_decode(stored: f64) -> f64 {
    if stored <= 0.04045 { stored / 12.92 } else { ((stored + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Encoding; 4] = [Encoding::Linear, Encoding::Srgb, Encoding::Gamma(2.2), Encoding::Gamma(1.8)];

    #[test]
    fn srgb_has_its_known_values() {
        // 0.5 decodes to 0.2140411, middle grey 0.18 encodes to 0.4613561: from the standard's formula in f64.
        assert!((Encoding::Srgb.decode(0.5) - 0.214_041_14).abs() < 1e-7);
        assert!((Encoding::Srgb.encode(0.18) - 0.461_356_13).abs() < 1e-7);
        assert_eq!(Encoding::Srgb.decode(0.0), 0.0);
        assert_eq!(Encoding::Srgb.decode(1.0), 1.0);
        assert_eq!(Encoding::Srgb.encode(1.0), 1.0);
        assert_eq!(Encoding::Gamma(2.0).decode(0.5), 0.25);
    }

    #[test]
    fn encoding_is_the_inverse_of_decoding() {
        for encoding in ALL {
            for step in -200..=500 {
                let stored = step as f32 / 100.0;
                let back = encoding.encode(encoding.decode(stored));
                assert!(
                    (back - stored).abs() <= 2e-6 * stored.abs().max(1.0),
                    "{encoding:?} {stored} {back}"
                );
            }
        }
    }

    #[test]
    fn bytes_survive_decoding_and_encoding() {
        for encoding in ALL {
            let table = encoding.decode_table();
            for byte in 0..=255_u8 {
                let linear = encoding.decode_u8(byte);
                assert_eq!((encoding.encode(linear) * 255.0).round() as u8, byte);
                assert!((table[usize::from(byte)] - linear).abs() < 1e-6);
            }
        }
    }
}
