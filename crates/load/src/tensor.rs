//! Tensor files: named arrays of numbers, as the RGL material database stores its measurements (`.bsdf`).
//!
//! A header, a description of each array (name, type, shape, and where in the file its values are), and the values; everything
//! little-endian. What is read is looked up in the file, and nothing that it claims is set aside for beforehand.
//!
//! Source: the description beside the reference implementation of Dupuy and Jakob 2018.
//!
//! Deliberately absent: conversion of types. Who asks for 32-bit floats gets an array of 32-bit floats or an error.

use thiserror::Error;

/// Arrays that a file may have: measurements have ten.
const MOST_FIELDS: u32 = 256;

/// Dimensions that an array may have: those of measurements have five.
const MOST_DIMENSIONS: u16 = 16;

const MAGIC: &[u8; 12] = b"tensor_file\0";

/// Types of numbers by what they are called in files, with the bytes of each.
const UINT8: u8 = 1;
const FLOAT32: u8 = 10;
const SIZES: [u64; 12] = [0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];

/// Why a file can't be read, and at which of its bytes.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("at byte {offset}: {problem}")]
pub(crate) struct TensorError {
    pub(crate) offset: u64,
    pub(crate) problem: Problem,
}

/// Why a file can't be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(crate) enum Problem {
    #[error("it is not a tensor file")]
    Magic,
    #[error("its version is {0}.{1}: only 1.0 can be read")]
    Version(u8, u8),
    #[error("it ends too early")]
    Truncated,
    #[error("{0} arrays are more than {MOST_FIELDS}")]
    TooMany(u32),
    #[error("an array has {0} dimensions, more than {MOST_DIMENSIONS}")]
    TooDeep(u16),
    #[error("`{0}` has values of the unknown type {1}")]
    Type(String, u8),
    #[error("`{0}` leads outside the file")]
    Outside(String),
    #[error("there is no array `{0}`")]
    Missing(&'static str),
    #[error("`{name}` has {found}: expected {expected}")]
    Shape { name: &'static str, expected: String, found: String },
}

/// An array of a file.
struct Field<'a> {
    name: &'a [u8],
    kind: u8,
    shape: Vec<u64>,
    /// Where its description begins.
    described: u64,
    values: &'a [u8],
}

/// The arrays of a file.
pub(crate) struct Tensors<'a>(Vec<Field<'a>>);

/// Bytes that are read one after the other.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn error(&self, problem: Problem) -> TensorError {
        TensorError { offset: self.at as u64, problem }
    }

    fn part(&mut self, length: usize) -> Result<&'a [u8], TensorError> {
        let end = self.at.checked_add(length);
        let part = end.and_then(|end| self.bytes.get(self.at..end));
        let part = part.ok_or_else(|| self.error(Problem::Truncated))?;
        self.at += length;
        Ok(part)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], TensorError> {
        let at = self.at;
        let truncated = TensorError { offset: at as u64, problem: Problem::Truncated };
        self.part(N)?.try_into().map_err(|_| truncated)
    }

    fn u16(&mut self) -> Result<u16, TensorError> {
        self.take().map(u16::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, TensorError> {
        self.take().map(u64::from_le_bytes)
    }

    fn field(&mut self) -> Result<Field<'a>, TensorError> {
        let described = self.at as u64;
        let error = |problem| TensorError { offset: described, problem };
        let length = self.u16()?;
        let name = self.part(usize::from(length))?;
        let shown = || String::from_utf8_lossy(name).into_owned();
        let dimensions = self.u16()?;
        if dimensions > MOST_DIMENSIONS {
            return Err(error(Problem::TooDeep(dimensions)));
        }
        let [kind] = self.take()?;
        let size = SIZES.get(usize::from(kind)).copied().filter(|&size| size > 0);
        let size = size.ok_or_else(|| error(Problem::Type(shown(), kind)))?;
        let offset = self.u64()?;
        let mut shape = Vec::with_capacity(usize::from(dimensions));
        for _ in 0..dimensions {
            shape.push(self.u64()?);
        }
        let bytes = shape.iter().try_fold(size, |bytes, &side| bytes.checked_mul(side));
        let end = bytes.and_then(|bytes| offset.checked_add(bytes));
        let range = end.and_then(|end| Some(usize::try_from(offset).ok()?..usize::try_from(end).ok()?));
        let values = range.and_then(|range| self.bytes.get(range));
        let values = values.ok_or_else(|| error(Problem::Outside(shown())))?;
        Ok(Field { name, kind, shape, described, values })
    }
}

impl<'a> Tensors<'a> {
    /// The arrays of the file `bytes`.
    pub(crate) fn read(bytes: &'a [u8]) -> Result<Self, TensorError> {
        let mut cursor = Cursor { bytes, at: 0 };
        if !bytes.starts_with(MAGIC) {
            return Err(cursor.error(Problem::Magic));
        }
        cursor.at = MAGIC.len();
        let version = cursor.take()?;
        if version != [1, 0] {
            return Err(TensorError { offset: 12, problem: Problem::Version(version[0], version[1]) });
        }
        let count = u32::from_le_bytes(cursor.take()?);
        if count > MOST_FIELDS {
            return Err(TensorError { offset: 14, problem: Problem::TooMany(count) });
        }
        (0..count).map(|_| cursor.field()).collect::<Result<_, _>>().map(Self)
    }

    /// The array called `name` of `N` dimensions and of type `kind`: its shape and its bytes.
    fn find<const N: usize>(
        &self,
        name: &'static str,
        (kind, kind_name): (u8, &str),
    ) -> Result<([u64; N], &'a [u8]), TensorError> {
        let found = self.0.iter().find(|field| field.name == name.as_bytes());
        let field = found.ok_or(TensorError { offset: 0, problem: Problem::Missing(name) })?;
        if let Ok(shape) = field.shape.as_slice().try_into()
            && field.kind == kind
        {
            return Ok((shape, field.values));
        }
        let expected = format!("{N} dimensions of {kind_name} (type {kind})");
        let found = format!("{} dimensions of type {}", field.shape.len(), field.kind);
        Err(TensorError { offset: field.described, problem: Problem::Shape { name, expected, found } })
    }

    /// The 32-bit floats called `name`, with the lengths of their `N` dimensions; the last one varies fastest.
    pub(crate) fn floats<const N: usize>(
        &self,
        name: &'static str,
    ) -> Result<([u64; N], Vec<f32>), TensorError> {
        let (shape, bytes) = self.find(name, (FLOAT32, "32-bit floats"))?;
        Ok((shape, bytes.as_chunks().0.iter().map(|&value| f32::from_le_bytes(value)).collect()))
    }

    /// The bytes called `name`.
    pub(crate) fn bytes(&self, name: &'static str) -> Result<&'a [u8], TensorError> {
        self.find::<1>(name, (UINT8, "bytes")).map(|(_, bytes)| bytes)
    }

    /// An error about the array `name`, whose shape is not what is `expected`.
    pub(crate) fn mismatch(&self, name: &'static str, expected: String) -> TensorError {
        let found = self.0.iter().find(|field| field.name == name.as_bytes());
        let (offset, shape) = found.map_or((0, &[][..]), |field| (field.described, &field.shape));
        TensorError {
            offset,
            problem: Problem::Shape { name, expected, found: format!("the shape {shape:?}") },
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
