//! Numbers as text: the inner loop of reading a scene, since nearly all of a large file is numbers.
//!
//! A decimal of at most 15 digits or so is an integer times or over a power of ten, both exact in `f64`, so that one
//! operation gives the correctly rounded value (Clinger, *How to read floating point numbers accurately*, 1990, section
//! 3). Whatever does not fit goes to the standard library: every result is the one that `str::parse` gives.

/// Powers of ten that are exact in `f64`.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Integers up to here are exact in `f64`.
const LARGEST_EXACT: u64 = 1 << 53;

/// The bytes at the start of `text` that a bare token may consist of.
pub(super) fn token_length(text: &[u8]) -> usize {
    text.iter().position(|&byte| ends_token(byte)).unwrap_or(text.len())
}

/// Whether `byte` ends a bare token.
#[inline]
pub(super) fn ends_token(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | b'\x0c' | b'\x0b' | b'"' | b'[' | b']' | b'#')
}

/// A number in two parts, before it is rounded.
struct Scanned {
    /// Its digits, without sign and point.
    mantissa: u64,
    /// The power of ten on them.
    exponent: i32,
    negative: bool,
    /// Bytes of text.
    length: usize,
}

impl Scanned {
    /// The value, if one exact operation gives it.
    #[inline]
    fn exact(&self) -> Option<f64> {
        if self.mantissa > LARGEST_EXACT {
            return None;
        }
        let mantissa = self.mantissa as f64;
        let power = *EXACT_POWERS.get(self.exponent.unsigned_abs() as usize)?;
        let value = if self.exponent < 0 { mantissa / power } else { mantissa * power };
        Some(if self.negative { -value } else { value })
    }
}

/// Reads sign, digits, point and exponent; `None` if the token is no such number, or has too many digits for this.
#[inline]
fn scan(text: &[u8]) -> Option<Scanned> {
    let mut at = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let negative = text.first() == Some(&b'-');
    let (mut mantissa, mut exponent, mut digits) = (0_u64, 0_i32, 0_u32);
    let mut point = false;
    loop {
        match text.get(at) {
            Some(digit @ b'0'..=b'9') => {
                mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
                digits += 1;
                exponent -= i32::from(point);
            }
            Some(b'.') if !point => point = true,
            _ => break,
        }
        at += 1;
    }
    // 19 digits always fit; leading zeros may send a short number the slow way, where it is right as well.
    if digits == 0 || digits > 19 {
        return None;
    }
    if let Some(b'e' | b'E') = text.get(at) {
        let (power, length) = scan_exponent(&text[at + 1..])?;
        exponent += power;
        at += 1 + length;
    }
    let complete = text.get(at).is_none_or(|&byte| ends_token(byte));
    complete.then_some(Scanned { mantissa, exponent, negative, length: at })
}

/// The exponent after the `e`, with its length.
fn scan_exponent(text: &[u8]) -> Option<(i32, usize)> {
    let sign = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let digits = text[sign..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    if digits == 0 || digits > 6 {
        return None;
    }
    let power = text[sign..sign + digits].iter().fold(0, |power, digit| power * 10 + i32::from(digit - b'0'));
    Some((if text[0] == b'-' { -power } else { power }, sign + digits))
}

/// The `f64` at the start of `text` and its length in bytes; `None` if there is no number.
///
/// Accepts what the standard library does: `1`, `.5`, `-2.`, `1e-3`, `inf`, `nan`. May be infinite or NaN.
#[inline]
pub(super) fn parse_f64(text: &[u8]) -> Option<(f64, usize)> {
    if let Some(scanned) = scan(text)
        && let Some(value) = scanned.exact()
    {
        return Some((value, scanned.length));
    }
    let length = token_length(text);
    Some((token(text, length)?.parse().ok()?, length))
}

/// The `f32` at the start of `text` and its length in bytes; `None` if there is no number.
#[inline]
pub(super) fn parse_f32(text: &[u8]) -> Option<(f32, usize)> {
    /// The bits of an `f64` that an `f32` does not have, and the value at which they are half of its last place.
    const LOST_BITS: u64 = (1 << 29) - 1;
    const HALFWAY: u64 = 1 << 28;
    if let Some(scanned) = scan(text)
        && let Some(value) = scanned.exact()
        // Rounding twice differs from rounding once only where the first result lies between two `f32`; the range of
        // normal numbers keeps the position of the lost bits.
        && value.to_bits() & LOST_BITS != HALFWAY
        && (value == 0.0 || (1e-37..1e38).contains(&value.abs()))
    {
        return Some((value as f32, scanned.length));
    }
    let length = token_length(text);
    Some((token(text, length)?.parse().ok()?, length))
}

/// What stands at the start of a text where an integer is expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Integer {
    /// A value and its length in bytes.
    Value(i32, usize),
    /// An integer beyond 32 bits, by its length.
    OutOfRange(usize),
    /// Something else.
    None,
}

/// The integer at the start of `text`.
#[inline]
pub(super) fn parse_i32(text: &[u8]) -> Integer {
    let mut at = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let first_digit = at;
    let mut value = 0_i64;
    while let Some(digit @ b'0'..=b'9') = text.get(at) {
        value = value.saturating_mul(10).saturating_add(i64::from(digit - b'0'));
        at += 1;
    }
    if at == first_digit || text.get(at).is_some_and(|&byte| !ends_token(byte)) {
        return Integer::None;
    }
    let value = if text[0] == b'-' { -value } else { value };
    i32::try_from(value).map_or(Integer::OutOfRange(at), |value| Integer::Value(value, at))
}

/// The first `length` bytes as text.
fn token(text: &[u8], length: usize) -> Option<&str> {
    std::str::from_utf8(&text[..length]).ok()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    fn same_as_std(text: &str) {
        let bytes = text.as_bytes();
        let expected = text.parse::<f64>().ok().map(f64::to_bits);
        assert_eq!(parse_f64(bytes).map(|(value, _)| value.to_bits()), expected, "{text}");
        let expected = text.parse::<f32>().ok().map(f32::to_bits);
        assert_eq!(parse_f32(bytes).map(|(value, _)| value.to_bits()), expected, "{text}");
    }

    #[test]
    fn every_spelling_agrees_with_the_standard_library() {
        for text in [
            "0",
            "-0",
            "+1",
            "1.",
            ".5",
            "-.5e2",
            "1e5",
            "1E+5",
            "1e-5",
            "12345678901234567890",
            "1e400",
            "-1e400",
            "1e-400",
            "0.1",
            "3.4028236e38",
            "1.17549435e-38",
            "1e-45",
            "inf",
            "-inf",
            "nan",
            "",
            "-",
            ".",
            "e5",
            "1e",
            "1e+",
            "1.2.3",
            "0x10",
            "1_000",
            "9007199254740993",
            "0.000000000000000000000000000001",
            "1.00000017881393421514957253748434595763683319091796875",
            "16777217",
            "1e0000001",
            "--1",
            "true",
        ] {
            same_as_std(text);
        }
    }

    #[test]
    fn numbers_end_at_delimiters() {
        assert_eq!(parse_f64(b"1.5]"), Some((1.5, 3)));
        assert_eq!(parse_f32(b"-2\n3"), Some((-2.0, 2)));
        assert_eq!(parse_i32(b"7 8"), Integer::Value(7, 1));
        assert_eq!(parse_i32(b"7.5"), Integer::None);
        assert_eq!(parse_i32(b"-"), Integer::None);
        assert_eq!(parse_i32(b"2147483648"), Integer::OutOfRange(10));
        assert_eq!(parse_i32(b"-2147483648"), Integer::Value(i32::MIN, 11));
        assert_eq!(parse_i32(b"99999999999999999999999999"), Integer::OutOfRange(26));
    }

    #[test]
    fn halfway_values_round_once() {
        // Between two `f32`, and so near the middle that `f64` cannot tell: the digits beyond decide.
        same_as_std("1.00000005960464477539062500000001");
        same_as_std("1.000000059604644775390625");
        same_as_std("33554433.0");
        same_as_std("33554435.0");
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            failure_persistence: None,
            rng_seed: RngSeed::Fixed(1),
            ..ProptestConfig::default()
        })]

        #[test]
        fn random_floats_agree_with_the_standard_library(bits: u64, digits in 1_usize..20) {
            let value = f64::from_bits(bits);
            same_as_std(&format!("{value:e}"));
            same_as_std(&format!("{value:.digits$e}"));
            let small = f64::from(bits as i32) * 10_f64.powi((bits >> 60) as i32 - 12);
            same_as_std(&format!("{small}"));
            same_as_std(&format!("{small:.digits$}"));
            same_as_std(&format!("{}", f32::from_bits(bits as u32)));
        }

        #[test]
        fn random_text_agrees_with_the_standard_library(text in "[-+.eE0-9]{0,12}") {
            same_as_std(&text);
        }
    }
}
