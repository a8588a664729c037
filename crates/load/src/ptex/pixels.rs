//! Pixels of faces: from compressed planes, differences and tiles to values in rows.

use sahl_scene::{Face, FaceTexels};

use super::{Bytes, PtexError, inflate};

/// Types of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    U8,
    U16,
    Half,
    F32,
}

impl Type {
    pub(super) fn of(number: u32) -> Result<Self, PtexError> {
        [Self::U8, Self::U16, Self::Half, Self::F32]
            .get(number as usize)
            .copied()
            .ok_or(PtexError::Type(number))
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::Half => 2,
            Self::F32 => 4,
        }
    }
}

/// How pixels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// One for all.
    Constant,
    /// Compressed, channel after channel.
    Zipped,
    /// Likewise, and each value less the one before.
    Differences,
    /// As tiles that are stored in one of the other ways.
    Tiled,
}

impl Encoding {
    /// The encoding and the size that are stored in a number.
    pub(super) fn of(number: u32) -> (Self, u32) {
        let encoding =
            [Self::Constant, Self::Zipped, Self::Differences, Self::Tiled][(number >> 30) as usize];
        (encoding, number & 0x3FFF_FFFF)
    }
}

/// The values of all faces so far.
pub(super) struct Store {
    kind: Type,
    channels: usize,
    /// Bytes that may still be added.
    budget: u64,
    limit: u64,
    texels: Texels,
}

enum Texels {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

impl Store {
    pub(super) fn new(kind: Type, channels: usize, [budget, limit]: [u64; 2]) -> Self {
        let texels = match kind {
            Type::U8 => Texels::U8(Vec::new()),
            Type::U16 => Texels::U16(Vec::new()),
            Type::Half | Type::F32 => Texels::F32(Vec::new()),
        };
        Self { kind, channels, budget, limit, texels }
    }

    /// Adds the pixels of face `number`, which `data` holds unless it is constant.
    pub(super) fn add(
        &mut self,
        number: usize,
        face: &mut Face,
        (encoding, data): (Encoding, &[u8]),
        constant: &[u8],
    ) -> Result<(), PtexError> {
        face.first = self.len() as u64;
        // A face of one pixel is stored as its constant.
        if face.is_constant || face.size_log2 == [0, 0] || (encoding == Encoding::Constant && data.is_empty())
        {
            face.is_constant = true;
            self.push(number, constant)
        } else if encoding == Encoding::Constant {
            face.is_constant = true;
            self.push(number, Bytes(data).take(constant.len() as u64)?)
        } else {
            let size = face.stored() * constant.len() as u64;
            self.budget = self.budget.checked_sub(size).ok_or(PtexError::Expansion(self.limit))?;
            let pixels = if encoding == Encoding::Tiled {
                self.tiles(number, face.size_log2, data)?
            } else {
                self.block(face.size_log2, encoding, data)?
            };
            self.push(number, &pixels)
        }
    }

    /// Pixels in rows, of a face or a tile that is compressed as a whole.
    fn block(&self, log2: [u8; 2], encoding: Encoding, data: &[u8]) -> Result<Vec<u8>, PtexError> {
        let bytes = self.kind.bytes();
        let count = 1_usize << (log2[0] + log2[1]);
        let length = (count * self.channels * bytes) as u64;
        let mut planes = inflate(data, length, "the pixels of a face")?;
        if encoding == Encoding::Differences {
            match self.kind {
                Type::U8 => accumulate_u8(&mut planes),
                Type::U16 => accumulate_u16(&mut planes),
                // Differences of floats are not taken.
                Type::Half | Type::F32 => {}
            }
        }
        if self.channels == 1 {
            return Ok(planes);
        }
        let mut pixels = Vec::with_capacity(planes.len());
        for i in 0..count {
            for channel in 0..self.channels {
                pixels.extend_from_slice(&planes[(channel * count + i) * bytes..][..bytes]);
            }
        }
        Ok(pixels)
    }

    /// Pixels in rows, of a face that is stored in tiles.
    fn tiles(&self, number: usize, log2: [u8; 2], data: &[u8]) -> Result<Vec<u8>, PtexError> {
        let mut data = Bytes(data);
        let tile: [u8; 2] = data.array()?;
        if tile[0] > log2[0] || tile[1] > log2[1] {
            return Err(PtexError::Tiles(number));
        }
        let [columns, rows] = [log2[0] - tile[0], log2[1] - tile[1]].map(|log| 1_usize << log);
        let sizes = data.u32()?;
        let sizes = inflate(data.take(sizes.into())?, (columns * rows * 4) as u64, "the sizes of tiles")?;
        let pixel = self.channels * self.kind.bytes();
        let (row, tile_row) = (pixel << log2[0], pixel << tile[0]);
        let mut pixels = vec![0; row << log2[1]];
        for (i, size) in sizes.chunks_exact(4).enumerate() {
            let (encoding, size) = Encoding::of(Bytes(size).u32()?);
            let stored = data.take(size.into())?;
            let values = match encoding {
                Encoding::Tiled => return Err(PtexError::Tiles(number)),
                Encoding::Constant => Bytes(stored).take(pixel as u64)?.repeat(1 << (tile[0] + tile[1])),
                _ => self.block(tile, encoding, stored)?,
            };
            let start = ((i / columns) << tile[1]) * row + (i % columns) * tile_row;
            for (j, values) in values.chunks_exact(tile_row).enumerate() {
                pixels[start + j * row..][..tile_row].copy_from_slice(values);
            }
        }
        Ok(pixels)
    }

    fn len(&self) -> usize {
        match &self.texels {
            Texels::U8(values) => values.len(),
            Texels::U16(values) => values.len(),
            Texels::F32(values) => values.len(),
        }
    }

    /// Appends values as they are stored in the file.
    fn push(&mut self, number: usize, bytes: &[u8]) -> Result<(), PtexError> {
        match &mut self.texels {
            Texels::U8(values) => values.extend_from_slice(bytes),
            Texels::U16(values) => values.extend(bytes.as_chunks().0.iter().copied().map(u16::from_le_bytes)),
            Texels::F32(values) => {
                let start = values.len();
                if self.kind == Type::Half {
                    values.extend(bytes.as_chunks().0.iter().copied().map(u16::from_le_bytes).map(half));
                } else {
                    values.extend(bytes.as_chunks().0.iter().copied().map(f32::from_le_bytes));
                }
                if !values[start..].iter().all(|value| value.is_finite()) {
                    return Err(PtexError::Infinite(number));
                }
            }
        }
        Ok(())
    }

    pub(super) fn into_texels(self) -> FaceTexels {
        match self.texels {
            Texels::U8(values) => FaceTexels::U8(values.into()),
            Texels::U16(values) => FaceTexels::U16(values.into()),
            Texels::F32(values) => FaceTexels::F32(values.into()),
        }
    }
}

fn accumulate_u8(values: &mut [u8]) {
    let mut sum = 0_u8;
    for value in values {
        sum = sum.wrapping_add(*value);
        *value = sum;
    }
}

fn accumulate_u16(bytes: &mut [u8]) {
    let mut sum = 0_u16;
    for value in bytes.as_chunks_mut().0 {
        sum = sum.wrapping_add(u16::from_le_bytes(*value));
        *value = sum.to_le_bytes();
    }
}

/// The number that a float of 16 bits stands for (IEEE 754-2008, binary16).
fn half(bits: u16) -> f32 {
    let (sign, exponent, fraction) = (bits >> 15, bits >> 10 & 31, f32::from(bits & 1023) / 1024.0);
    let magnitude = match exponent {
        0 => fraction * f32::exp2(-14.0),
        31 => return if fraction == 0.0 { f32::INFINITY } else { f32::NAN },
        _ => (1.0 + fraction) * f32::exp2(f32::from(exponent) - 15.0),
    };
    if sign == 0 { magnitude } else { -magnitude }
}
