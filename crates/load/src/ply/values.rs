//! The values after the header, one after the other, as text or binary.

use super::PlyError;
use super::header::{Kind, Scalar};

/// Reads values in order. Every error says where.
pub(super) trait Values {
    /// An integer.
    fn integer(&mut self, scalar: Scalar) -> Result<i64, PlyError>;

    /// A number, rounded to `f32`; not necessarily finite.
    fn float(&mut self, scalar: Scalar) -> Result<f32, PlyError>;

    /// Passes over one value or one list.
    fn skip(&mut self, kind: Kind) -> Result<(), PlyError>;

    /// Where the next value starts.
    fn offset(&self) -> usize;

    /// Whether anything but white space is left.
    fn has_more(&self) -> bool;

    /// The most rows that what is left can hold, given the columns of a table.
    fn most_rows(&self, kinds: impl Iterator<Item = Kind>) -> usize;

    /// The most items of a list that what is left can hold.
    fn most_items(&self, item: Scalar) -> usize;

    /// The next `rows` rows of `stride` bytes, if the values are binary and all there.
    fn rows(&mut self, stride: usize, rows: u64) -> Option<Rows<'_>>;

    /// Reads triangles and quadrilaterals as long as each row is a one-byte count of three or four and so many
    /// four-byte indices, giving each to `face` with its offset, until `face` declines or `rows` have been read.
    /// Returns how many were; zero for text.
    fn common_faces(&mut self, rows: u64, face: impl FnMut(&[u32]) -> bool) -> u64;

    /// Reads the length of a list, which the rest of the file must be able to hold.
    fn length(&mut self, count: Scalar, item: Scalar) -> Result<usize, PlyError> {
        let offset = self.offset();
        let length = self.integer(count)?;
        match usize::try_from(length) {
            Ok(length) if length <= self.most_items(item) => Ok(length),
            Ok(_) => Err(PlyError::at(
                offset,
                format!("a list of {length} values, which the file is too short for"),
            )),
            Err(_) => Err(PlyError::at(offset, format!("a list of {length} values"))),
        }
    }
}

/// Rows of binary values of one width.
pub(super) struct Rows<'a> {
    bytes: &'a [u8],
    stride: usize,
    /// Where the first row starts in the file.
    offset: usize,
    decode: fn(Scalar, &[u8]) -> f64,
    /// Whether a plain copy of four bytes is an `f32`.
    little_endian: bool,
}

impl<'a> Rows<'a> {
    /// The rows with the offset of each in the file.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, &'a [u8])> {
        let offsets = (self.offset..).step_by(self.stride);
        offsets.zip(self.bytes.chunks_exact(self.stride))
    }

    /// The value at `at` in a row.
    #[inline]
    pub(super) fn float(&self, scalar: Scalar, row: &[u8], at: usize) -> f32 {
        let bytes = &row[at..at + scalar.size()];
        match <[u8; 4]>::try_from(bytes) {
            Ok(bytes) if scalar == Scalar::F32 && self.little_endian => f32::from_le_bytes(bytes),
            _ => (self.decode)(scalar, bytes) as f32,
        }
    }
}

/// Values as text, apart by white space. Lines have no meaning, as in most readers.
pub(super) struct Ascii<'a> {
    bytes: &'a [u8],
    offset: usize,
}

impl<'a> Ascii<'a> {
    pub(super) fn new(bytes: &'a [u8], offset: usize) -> Self {
        let mut values = Self { bytes, offset };
        values.skip_white();
        values
    }

    fn skip_white(&mut self) {
        let rest = &self.bytes[self.offset..];
        self.offset += rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
    }

    /// The next word and where it starts.
    fn word(&mut self) -> Result<(&'a [u8], usize), PlyError> {
        let (start, rest) = (self.offset, &self.bytes[self.offset..]);
        let length = rest.iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        if length == 0 {
            return Err(PlyError::at(start, "the file ends early"));
        }
        self.offset += length;
        self.skip_white();
        Ok((&rest[..length], start))
    }

    fn remaining(&self) -> usize {
        self.bytes.len() - self.offset
    }
}

/// The word as a number.
fn parse<T: std::str::FromStr>(word: &[u8], start: usize) -> Result<T, PlyError> {
    const LONGEST: usize = 40;
    std::str::from_utf8(word).ok().and_then(|word| word.parse().ok()).ok_or_else(|| {
        let shown = String::from_utf8_lossy(&word[..word.len().min(LONGEST)]);
        PlyError::at(start, format!("expected a number, found `{shown}`"))
    })
}

impl Values for Ascii<'_> {
    fn integer(&mut self, _: Scalar) -> Result<i64, PlyError> {
        let (word, start) = self.word()?;
        // Nearly all are a few digits.
        if word.len() <= 9 && word.iter().all(u8::is_ascii_digit) {
            return Ok(word.iter().fold(0, |value, digit| value * 10 + i64::from(digit - b'0')));
        }
        // Some writers print integers as `3.0`.
        let value: f64 = parse(word, start)?;
        let is_integer = value.fract() == 0.0 && value.abs() < 9e15;
        if !is_integer {
            return Err(PlyError::at(start, format!("expected an integer, found `{value}`")));
        }
        Ok(value as i64)
    }

    fn float(&mut self, _: Scalar) -> Result<f32, PlyError> {
        let (word, start) = self.word()?;
        parse(word, start)
    }

    fn skip(&mut self, kind: Kind) -> Result<(), PlyError> {
        let words = match kind {
            Kind::Scalar(_) => 1,
            Kind::List { count, item } => self.length(count, item)?,
        };
        for _ in 0..words {
            self.word()?;
        }
        Ok(())
    }

    fn offset(&self) -> usize {
        self.offset
    }

    fn has_more(&self) -> bool {
        self.remaining() > 0
    }

    fn most_rows(&self, kinds: impl Iterator<Item = Kind>) -> usize {
        // Each number, or count of a list, takes a digit and a blank; a list of a face has three numbers more.
        let values: usize = kinds.map(|kind| if matches!(kind, Kind::List { .. }) { 4 } else { 1 }).sum();
        self.remaining() / (2 * values.max(1)) + 1
    }

    fn most_items(&self, _: Scalar) -> usize {
        self.remaining().div_ceil(2)
    }

    fn rows(&mut self, _: usize, _: u64) -> Option<Rows<'_>> {
        None
    }

    fn common_faces(&mut self, _: u64, _: impl FnMut(&[u32]) -> bool) -> u64 {
        0
    }
}

/// Values as in memory, with the most significant byte first or last.
pub(super) struct Binary<'a, const BIG: bool> {
    bytes: &'a [u8],
    offset: usize,
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    pub(super) fn new(bytes: &'a [u8], offset: usize) -> Self {
        Self { bytes, offset }
    }

    fn take(&mut self, length: usize) -> Result<&'a [u8], PlyError> {
        let rest = &self.bytes[self.offset..];
        let Some(bytes) = rest.get(..length) else {
            return Err(PlyError::at(self.offset, "the file ends early"));
        };
        self.offset += length;
        Ok(bytes)
    }

    fn remaining(&self) -> usize {
        self.bytes.len() - self.offset
    }
}

/// The number that `bytes`, as many as its type takes, stand for. `f64` holds each of them exactly.
fn decode<const BIG: bool>(scalar: Scalar, bytes: &[u8]) -> f64 {
    // The low bytes of the word come first in both orders.
    let mut word = [0; 8];
    word[..bytes.len()].copy_from_slice(bytes);
    if BIG {
        word[..bytes.len()].reverse();
    }
    let bits = u64::from_le_bytes(word);
    match scalar {
        Scalar::I8 => f64::from(bits as i8),
        Scalar::U8 => f64::from(bits as u8),
        Scalar::I16 => f64::from(bits as i16),
        Scalar::U16 => f64::from(bits as u16),
        Scalar::I32 => f64::from(bits as i32),
        Scalar::U32 => f64::from(bits as u32),
        Scalar::F32 => f64::from(f32::from_bits(bits as u32)),
        Scalar::F64 => f64::from_bits(bits),
    }
}

impl<const BIG: bool> Values for Binary<'_, BIG> {
    fn integer(&mut self, scalar: Scalar) -> Result<i64, PlyError> {
        let bytes = self.take(scalar.size())?;
        Ok(decode::<BIG>(scalar, bytes) as i64)
    }

    fn float(&mut self, scalar: Scalar) -> Result<f32, PlyError> {
        let bytes = self.take(scalar.size())?;
        Ok(decode::<BIG>(scalar, bytes) as f32)
    }

    fn skip(&mut self, kind: Kind) -> Result<(), PlyError> {
        let bytes = match kind {
            Kind::Scalar(scalar) => scalar.size(),
            // No overflow: the length is that of something which fits into the file.
            Kind::List { count, item } => self.length(count, item)? * item.size(),
        };
        self.take(bytes).map(|_| ())
    }

    fn offset(&self) -> usize {
        self.offset
    }

    fn has_more(&self) -> bool {
        !self.bytes[self.offset..].trim_ascii().is_empty()
    }

    fn most_rows(&self, kinds: impl Iterator<Item = Kind>) -> usize {
        let bytes: usize = kinds
            .map(|kind| match kind {
                Kind::Scalar(scalar) => scalar.size(),
                Kind::List { count, item } => count.size() + 3 * item.size(),
            })
            .sum();
        self.remaining() / bytes.max(1) + 1
    }

    fn most_items(&self, item: Scalar) -> usize {
        self.remaining() / item.size()
    }

    fn rows(&mut self, stride: usize, rows: u64) -> Option<Rows<'_>> {
        let length = usize::try_from(rows).ok()?.checked_mul(stride)?;
        let offset = self.offset;
        let bytes = self.take(length).ok()?;
        Some(Rows { bytes, stride, offset, decode: decode::<BIG>, little_endian: !BIG })
    }

    fn common_faces(&mut self, rows: u64, mut face: impl FnMut(&[u32]) -> bool) -> u64 {
        let index = |bytes: &[u8], at: usize| {
            let bytes = [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
            if BIG { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
        };
        let mut read = 0;
        while read < rows {
            let rest = &self.bytes[self.offset..];
            let (accepted, length) = match rest {
                [3, row @ ..] if row.len() >= 12 => {
                    (face(&[index(row, 0), index(row, 4), index(row, 8)]), 13)
                }
                [4, row @ ..] if row.len() >= 16 => {
                    (face(&[index(row, 0), index(row, 4), index(row, 8), index(row, 12)]), 17)
                }
                _ => (false, 0),
            };
            if !accepted {
                break;
            }
            self.offset += length;
            read += 1;
        }
        read
    }
}
