//! 16-bit floats, IEEE 754 binary16.

/// The nearest 16-bit float, ties to even; magnitudes below the smallest normal one become zero, those above the
/// largest become it.
pub(super) fn encode(value: f32) -> u16 {
    let bits = value.to_bits();
    let sign = (bits >> 16) as u16 & 0x8000;
    let magnitude = bits & 0x7fff_ffff;
    let rounded = magnitude + 0xfff + ((magnitude >> 13) & 1);
    let exponent = (rounded >> 23) as i32 - 127;
    match exponent {
        ..=-15 => sign,
        16.. => sign | 0x7bff,
        _ => sign | ((exponent + 15) as u16) << 10 | (rounded >> 13) as u16 & 0x3ff,
    }
}

/// The value of a 16-bit float that is zero or normal.
#[cfg(test)]
pub(super) fn decode(half: u16) -> f32 {
    f32::from_bits((u32::from(half) & 0x8000) << 16 | (u32::from(half) & 0x7fff) << 13)
        * f32::from_bits(0x7780_0000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_survive_to_half_precision() {
        assert_eq!([encode(1.0), encode(-2.0), encode(0.0), encode(65504.0)], [0x3c00, 0xc000, 0, 0x7bff]);
        for value in [0.333_f32, -57.81, 1234.5, 6.2e-5, -0.999_9] {
            assert!((decode(encode(value)) / value - 1.0).abs() <= 1.0 / 2048.0, "{value}");
        }
        assert_eq!(decode(encode(1e-6)), 0.0);
        assert_eq!(decode(encode(1e6)), 65504.0);
    }
}
