//! Images that belong to the faces of a mesh, one each, and know which face lies beyond each edge.
//!
//! Such a mesh needs no texture coordinates that would have to be unfolded: a face has its own, from zero to one. Where two faces
//! meet, the adjacency says how to go on, so that a filter sees no seam.
//!
//! In a scene file: `Texture "paint" "spectrum" "ptex" "string filename" "paint.ptx"`.
//!
//! Source: Burley, Lacewell, *Ptex: Per-Face Texture Mapping for Production Rendering*, EGSR 2008.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// The images of all faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaceImages {
    /// Values a pixel: one, or three for red, green and blue.
    pub channels: usize,
    /// By the number of the face.
    pub faces: Arc<[Face]>,
    /// The pixels of all faces, channels together, in rows from v = 0 up, from u = 0 on.
    pub texels: FaceTexels,
}

/// The image of one face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Face {
    /// Logarithm to base two of the pixels along u and v.
    pub size_log2: [u8; 2],
    /// Whether all pixels are alike, and only one is stored.
    pub is_constant: bool,
    /// Whether it is a part of a face that has not four corners: it is half as long as its neighbours along an edge.
    pub is_part: bool,
    /// Where its values begin among [`FaceImages::texels`].
    pub first: u64,
    /// What lies beyond the edges v = 0, u = 1, v = 1, u = 0. Of two parts, it is the one at the start of the edge, if edges go around
    /// the face as listed.
    pub neighbors: [Option<Neighbor>; 4],
}

/// The face on the other side of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Neighbor {
    /// Its number.
    pub face: u32,
    /// Which of its edges is the same.
    pub edge: u8,
}

/// Values as they are stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum FaceTexels {
    /// In 255ths.
    U8(Arc<[u8]>),
    /// In 65 535ths.
    U16(Arc<[u16]>),
    /// As they are.
    F32(Arc<[f32]>),
}

impl Face {
    /// Sides have no more than `2^MOST_LOG2` pixels.
    pub const MOST_LOG2: u8 = 15;

    /// How many pixels are stored.
    pub const fn stored(&self) -> u64 {
        if self.is_constant { 1 } else { 1 << (self.size_log2[0] as u64 + self.size_log2[1] as u64) }
    }
}

impl FaceTexels {
    /// How many values there are.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::U16(values) => values.len(),
            Self::F32(values) => values.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        match self {
            Self::U8(values) => size_of_val(&**values),
            Self::U16(values) => size_of_val(&**values),
            Self::F32(values) => size_of_val(&**values),
        }
    }

    /// The value at `index`, which must be there: from zero to one unless floats are stored.
    #[inline]
    pub fn value(&self, index: usize) -> f32 {
        match self {
            Self::U8(values) => f32::from(values[index]) / 255.0,
            Self::U16(values) => f32::from(values[index]) / 65_535.0,
            Self::F32(values) => values[index],
        }
    }
}

impl FaceImages {
    /// The first face that has pixels or a neighbour which are not there, or pixels that are not finite; `None` if all is well.
    pub fn first_bad_face(&self) -> Option<usize> {
        let exists = |neighbor: &Neighbor| (neighbor.face as usize) < self.faces.len() && neighbor.edge < 4;
        self.faces.iter().position(|face| {
            let is_small = face.size_log2.iter().all(|&log| log <= Face::MOST_LOG2);
            let values = is_small.then(|| face.stored().checked_mul(self.channels as u64)).flatten();
            let end = values.and_then(|values| face.first.checked_add(values));
            let range = end
                .filter(|&end| end <= self.texels.len() as u64)
                .map(|end| face.first as usize..end as usize);
            let is_finite = match (&self.texels, range) {
                (FaceTexels::F32(values), Some(range)) => values[range].iter().all(|value| value.is_finite()),
                (_, range) => range.is_some(),
            };
            !(is_finite && face.neighbors.iter().flatten().all(exists))
        })
    }

    /// Whether the images can be read: they have faces, one or three channels, and what each face refers to.
    pub fn is_usable(&self) -> bool {
        matches!(self.channels, 1 | 3) && !self.faces.is_empty() && self.first_bad_face().is_none()
    }
}
