//! NanoVDB volumes: files of sparse grids as simulations write them.
//!
//! A file is a row of segments. A segment is a header, a description of each of its grids with the grid's name, and then
//! the grids, each a copy of the memory that holds its tree, compressed or not. What is read is grids of 32-bit floats in the
//! layout of version 32, raw or compressed by zip or Blosc.
//!
//! Source: Museth, *NanoVDB: A GPU-Friendly and Portable VDB Data Structure for Real-Time Rendering and Simulation*, SIGGRAPH
//! Talks 2021, and the offsets that its reference implementation documents.
//!
//! Deliberately absent: quantised values, and the trees themselves: they are flattened.

mod grid;

use std::io::ErrorKind;

use sahl_scene::SparseGrid;
use thiserror::Error;

use crate::blosc::{self, BloscError};
use crate::zlib;

/// Bytes of a segment's header, and of the description of a grid in it.
const HEADER: usize = 16;
const DESCRIPTION: usize = 176;

/// The major version whose layout is known.
const VERSION: u32 = 32;

/// The number of the type of grids that are read: 32-bit floats.
const FLOAT: u32 = 1;

/// The classes of grids that hold densities: unknown and fog volumes.
const CLASSES: [u32; 2] = [0, 2];

/// Why a volume can't be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(crate) enum NanoVdbError {
    #[error("it is not a NanoVDB file")]
    NoVolume,
    #[error("it ends too early, or leads outside itself")]
    Truncated,
    #[error("its layout is that of version {0}: only that of version 32 can be read")]
    Version(u32),
    #[error("a Blosc chunk of the grid can't be read: {0}")]
    Blosc(#[from] BloscError),
    #[error("the grid is compressed in an unknown way ({0})")]
    Codec(u16),
    #[error("the compressed grid is damaged: {0}")]
    Damaged(String),
    #[error("the grid holds values of type {0}: only 32-bit floats (type 1) can be read")]
    Type(u32),
    #[error("the grid is no fog volume, but a level set or something else (class {0})")]
    Class(u32),
    #[error("the transform of the grid is singular")]
    Transform,
    #[error("the grid reaches too far: a table of {0} blocks would be needed")]
    TooSparse(u64),
    #[error("the grid has a tile of 4096 voxels a side, which is not supported")]
    GiantTile,
}

/// Bytes at offsets, which may be wrong.
#[derive(Clone, Copy)]
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take<const N: usize>(&self, offset: usize) -> Result<[u8; N], NanoVdbError> {
        let end = offset.checked_add(N).ok_or(NanoVdbError::Truncated)?;
        let bytes = self.0.get(offset..end).ok_or(NanoVdbError::Truncated)?;
        bytes.try_into().map_err(|_| NanoVdbError::Truncated)
    }

    fn part(&self, offset: usize, length: u64) -> Result<&'a [u8], NanoVdbError> {
        let end = usize::try_from(length).ok().and_then(|length| offset.checked_add(length));
        end.and_then(|end| self.0.get(offset..end)).ok_or(NanoVdbError::Truncated)
    }

    fn u16(&self, offset: usize) -> Result<u16, NanoVdbError> {
        self.take(offset).map(u16::from_le_bytes)
    }

    fn u32(&self, offset: usize) -> Result<u32, NanoVdbError> {
        self.take(offset).map(u32::from_le_bytes)
    }

    fn u64(&self, offset: usize) -> Result<u64, NanoVdbError> {
        self.take(offset).map(u64::from_le_bytes)
    }

    fn f32(&self, offset: usize) -> Result<f32, NanoVdbError> {
        self.take(offset).map(f32::from_le_bytes)
    }

    fn f64(&self, offset: usize) -> Result<f64, NanoVdbError> {
        self.take(offset).map(f64::from_le_bytes)
    }
}

/// A grid of a file.
struct Entry<'a> {
    name: String,
    kind: u32,
    class: u32,
    codec: u16,
    /// Bytes of the grid in memory.
    size: u64,
    /// As they are stored.
    stored: &'a [u8],
}

/// The names of the grids in a file; as many as can be read.
pub(crate) fn names(bytes: &[u8]) -> Vec<String> {
    let entries = entries(bytes).unwrap_or_default();
    entries.into_iter().map(|entry| entry.name).collect()
}

/// The grid called `name`; `None` if there is none of this name.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<Option<SparseGrid>, NanoVdbError> {
    let Some(entry) = entries(bytes)?.into_iter().find(|entry| entry.name == name) else { return Ok(None) };
    if entry.kind != FLOAT {
        return Err(NanoVdbError::Type(entry.kind));
    }
    if !CLASSES.contains(&entry.class) {
        return Err(NanoVdbError::Class(entry.class));
    }
    match entry.codec {
        0 => grid::flatten(Bytes(entry.stored)).map(Some),
        1 => grid::flatten(Bytes(&unzip(&entry)?)).map(Some),
        2 => grid::flatten(Bytes(&unpack(&entry)?)).map(Some),
        other => Err(NanoVdbError::Codec(other)),
    }
}

/// The grid's bytes, after a count of those that are stored.
fn unzip(entry: &Entry<'_>) -> Result<Vec<u8>, NanoVdbError> {
    let stored = Bytes(entry.stored);
    let compressed = stored.part(8, stored.u64(0)?)?;
    zlib::inflate(compressed, entry.size).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => NanoVdbError::Truncated,
        _ => NanoVdbError::Damaged(error.to_string()),
    })
}

/// The grid's bytes, from chunks of at most a gigabyte, each after a count of its bytes.
fn unpack(entry: &Entry<'_>) -> Result<Vec<u8>, NanoVdbError> {
    let stored = Bytes(entry.stored);
    let (mut grid, mut offset) = (Vec::new(), 0);
    while (grid.len() as u64) < entry.size {
        let chunk = stored.part(offset + 8, stored.u64(offset)?)?;
        blosc::decompress(chunk, entry.size - grid.len() as u64, &mut grid)?;
        offset += 8 + chunk.len();
    }
    Ok(grid)
}

/// The grids of all segments.
fn entries(bytes: &[u8]) -> Result<Vec<Entry<'_>>, NanoVdbError> {
    let file = Bytes(bytes);
    let (mut entries, mut offset) = (Vec::new(), 0);
    while offset < bytes.len() || offset == 0 {
        match &file.take::<8>(offset).unwrap_or_default() {
            b"NanoVDB0" | b"NanoVDB2" => {}
            _ => return Err(NanoVdbError::NoVolume),
        }
        let version = file.u32(offset + 8)? >> 21;
        if version != VERSION {
            return Err(NanoVdbError::Version(version));
        }
        let count = file.u16(offset + 12)?;
        offset = segment(file, offset + HEADER, count, &mut entries)?;
    }
    Ok(entries)
}

/// Adds the `count` grids of a segment whose descriptions begin at `offset`; returns where the segment ends.
fn segment<'a>(
    file: Bytes<'a>,
    mut offset: usize,
    count: u16,
    entries: &mut Vec<Entry<'a>>,
) -> Result<usize, NanoVdbError> {
    let mut described = Vec::new();
    for _ in 0..count {
        let name = file.part(offset + DESCRIPTION, u64::from(file.u32(offset + 136)?))?;
        described.push((offset, name));
        offset += DESCRIPTION + name.len();
    }
    for (description, name) in described {
        let stored = file.part(offset, file.u64(description + 8)?)?;
        let text = name.split(|&byte| byte == 0).next().unwrap_or_default();
        entries.push(Entry {
            name: String::from_utf8_lossy(text).into_owned(),
            kind: file.u32(description + 32)?,
            class: file.u32(description + 36)?,
            codec: file.u16(description + 168)?,
            size: file.u64(description)?,
            stored,
        });
        offset += stored.len();
    }
    Ok(offset)
}

#[cfg(test)]
mod tests;
