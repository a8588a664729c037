//! Ptex files: an image for each face of a mesh, and which faces touch.
//!
//! A file is a header, an extended header, the faces with their sizes and neighbours, a constant for each face, and levels: the images
//! themselves, then ever smaller ones. Sizes in the header lead from one block to the next. Numbers are little-endian, most blocks
//! are compressed by zip. What is read is the faces, the constants and the first level.
//!
//! The input may be hostile. Nothing is set aside that the bytes at hand could not expand to, and faces may not take more pixels
//! than Deflate could make of the file.
//!
//! Source: *Ptex File Format Specification*, version 1.3r1, and the behaviour of Ptex 2.4.
//!
//! Deliberately absent: meshes of triangles, whose pixels are laid out in another way; smaller levels, which are made anew; metadata;
//! edits, alpha and border modes, about which there is a warning.

mod pixels;

use sahl_scene::{Face, FaceImages, Neighbor};
use thiserror::Error;

use crate::zlib::{self, MOST_EXPANSION};
use pixels::{Encoding, Store, Type};

/// What a file may expand to: this many bytes, and so many times its own size, as much as Deflate can.
const FREE_EXPANSION: u64 = 16 << 20;

/// Bytes of the header, and of what is told about a face and about a level.
const HEADER: usize = 64;
const FACE: usize = 20;
const LEVEL: usize = 16;

/// Flags of a face.
const CONSTANT: u8 = 1;
const PART: u8 = 8;

/// Why a file can't be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(crate) enum PtexError {
    #[error("it is not a Ptex file")]
    NoPtex,
    #[error("its version is {0}: only version 1 can be read")]
    Version(u32),
    #[error("it is for a mesh of triangles: only meshes of quadrilaterals are supported")]
    Triangles,
    #[error("it has an unknown type of mesh ({0})")]
    Mesh(u32),
    #[error("it has an unknown type of values ({0})")]
    Type(u32),
    #[error("it has {0} channels: only one and three are supported, as in pbrt-v4")]
    Channels(u16),
    #[error("it has no faces")]
    NoFaces,
    #[error("it ends too early, or leads outside itself")]
    Truncated,
    #[error("{0} can't be decompressed, or have not the size that they should")]
    Damaged(&'static str),
    #[error("face {0} has a side of 2^{1} pixels: 2^15 is the limit")]
    Size(usize, i8),
    #[error("face {0} has a neighbour that does not exist ({1})")]
    Neighbor(usize, u32),
    #[error("face {0} is stored in tiles that don't fit it")]
    Tiles(usize),
    #[error("face {0} has pixels that are not finite")]
    Infinite(usize),
    #[error("it claims to expand to {0} bytes")]
    Expansion(u64),
}

/// What a file holds.
#[derive(Debug)]
pub(crate) struct PtexFile {
    pub(crate) images: FaceImages,
    /// What of it is not honoured.
    pub(crate) warnings: Vec<&'static str>,
}

/// Bytes that are used up from the front.
#[derive(Clone, Copy)]
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: u64) -> Result<&'a [u8], PtexError> {
        let count = usize::try_from(count).map_err(|_| PtexError::Truncated)?;
        let (taken, rest) = self.0.split_at_checked(count).ok_or(PtexError::Truncated)?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], PtexError> {
        let (taken, rest) = self.0.split_first_chunk().ok_or(PtexError::Truncated)?;
        self.0 = rest;
        Ok(*taken)
    }

    fn u16(&mut self) -> Result<u16, PtexError> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, PtexError> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, PtexError> {
        self.array().map(u64::from_le_bytes)
    }
}

/// `compressed` as the `length` bytes that it must expand to; `what` is what it holds.
fn inflate(compressed: &[u8], length: u64, what: &'static str) -> Result<Vec<u8>, PtexError> {
    zlib::inflate(compressed, length).map_err(|_| PtexError::Damaged(what))
}

/// What the header says that matters.
struct Header {
    kind: Type,
    alpha: u32,
    channels: u16,
    levels: u16,
    faces: u32,
    /// Bytes of the extended header, of the faces, of the constants and of what is told about levels.
    blocks: [u32; 4],
}

impl Header {
    fn read(bytes: &mut Bytes<'_>) -> Result<Self, PtexError> {
        let mut header = Bytes(bytes.take(HEADER as u64).map_err(|_| PtexError::NoPtex)?);
        if header.array()? != *b"Ptex" {
            return Err(PtexError::NoPtex);
        }
        let version = header.u32()?;
        if version != 1 {
            return Err(PtexError::Version(version));
        }
        match header.u32()? {
            0 => return Err(PtexError::Triangles),
            1 => {}
            other => return Err(PtexError::Mesh(other)),
        }
        let kind = Type::of(header.u32()?)?;
        let (alpha, channels, levels) = (header.u32()?, header.u16()?, header.u16()?);
        if !matches!(channels, 1 | 3) {
            return Err(PtexError::Channels(channels));
        }
        let faces = header.u32()?;
        if faces == 0 || levels == 0 {
            return Err(PtexError::NoFaces);
        }
        let blocks = [header.u32()?, header.u32()?, header.u32()?, header.u32()?];
        Ok(Self { kind, alpha, channels, levels, faces, blocks })
    }

    /// Bytes of a pixel.
    fn pixel(&self) -> u64 {
        u64::from(self.channels) * self.kind.bytes() as u64
    }
}

/// Reads a Ptex file.
///
/// # Errors
/// [`PtexError`] if the file is damaged, or of a kind that is not supported.
pub(crate) fn read(file: &[u8]) -> Result<PtexFile, PtexError> {
    let mut bytes = Bytes(file);
    let header = Header::read(&mut bytes)?;
    let [extended, faces, constants, levels] = header.blocks;
    let warnings = warnings(&header, bytes.take(extended.into())?);
    let count = u64::from(header.faces);
    let faces = inflate(bytes.take(faces.into())?, count * FACE as u64, "the faces")?;
    let constants = inflate(bytes.take(constants.into())?, count * header.pixel(), "the constants")?;
    if u64::from(levels) < u64::from(header.levels) * LEVEL as u64 {
        return Err(PtexError::Truncated);
    }
    let mut levels = Bytes(bytes.take(levels.into())?);
    let (size, sizes, level_faces) = (levels.u64()?, levels.u32()?, levels.u32()?);
    let mut level = Bytes(bytes.take(size)?);
    if level_faces != header.faces {
        return Err(PtexError::Damaged("the sizes of faces"));
    }
    let sizes = inflate(level.take(sizes.into())?, count * 4, "the sizes of faces")?;

    let limit = FREE_EXPANSION + MOST_EXPANSION * file.len() as u64;
    // What is kept of every face, whatever its pixels.
    let kept = count * (size_of::<Face>() as u64 + header.pixel());
    let budget = limit.checked_sub(kept).ok_or(PtexError::Expansion(limit))?;
    let mut store = Store::new(header.kind, header.channels.into(), [budget, limit]);
    let mut read = Vec::with_capacity(faces.len() / FACE);
    for (i, (face, size)) in faces.chunks_exact(FACE).zip(sizes.chunks_exact(4)).enumerate() {
        let mut face = face_of(i, Bytes(face), header.faces)?;
        let (encoding, size) = Encoding::of(Bytes(size).u32()?);
        let data = level.take(size.into())?;
        let pixel = header.pixel() as usize;
        let constant = &constants[i * pixel..][..pixel];
        store.add(i, &mut face, (encoding, data), constant)?;
        read.push(face);
    }
    let images =
        FaceImages { channels: header.channels.into(), faces: read.into(), texels: store.into_texels() };
    Ok(PtexFile { images, warnings })
}

/// What is not honoured.
fn warnings(header: &Header, extended: &[u8]) -> Vec<&'static str> {
    // Files of older versions have a shorter extended header, or none.
    let mut extended = Bytes(extended);
    let mut number = || extended.u32().unwrap_or(0);
    let borders = [number(), number()];
    // Past the sizes of large metadata.
    let edits = [number(), number(), number(), number(), number(), number()];
    let mut warnings = Vec::new();
    if borders != [0, 0] {
        warnings.push("its borders are continued by their last pixels, not in black or periodically");
    }
    if edits[4..] != [0, 0] {
        warnings.push("edits at its end are left out");
    }
    if header.alpha < header.channels.into() {
        warnings.push("its alpha is taken for a colour");
    }
    warnings
}

/// What the file tells about face `number` of `count`; where its pixels are is found out later.
fn face_of(number: usize, mut bytes: Bytes<'_>, count: u32) -> Result<Face, PtexError> {
    let [u, v, edges, flags] = bytes.array()?;
    let mut size_log2 = [0; 2];
    for (log, stored) in size_log2.iter_mut().zip([u, v]) {
        if stored > Face::MOST_LOG2 {
            return Err(PtexError::Size(number, stored.cast_signed()));
        }
        *log = stored;
    }
    let mut neighbors = [None; 4];
    for (i, neighbor) in neighbors.iter_mut().enumerate() {
        *neighbor = match bytes.u32()? {
            u32::MAX => None,
            face if face < count => Some(Neighbor { face, edge: edges >> (2 * i) & 3 }),
            face => return Err(PtexError::Neighbor(number, face)),
        };
    }
    Ok(Face {
        size_log2,
        is_constant: flags & CONSTANT != 0,
        is_part: flags & PART != 0,
        first: 0,
        neighbors,
    })
}

#[cfg(test)]
mod tests;
