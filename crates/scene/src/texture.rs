//! Textures, and parameters that may be one.
//!
//! The set is pbrt-v4's. A texture has no kind of its own: any of them can stand where a number or a spectrum is asked for.

use std::sync::Arc;

use sahl_image::{Encoding, Image};
use sahl_math::{Transform, Vec3};
use serde::{Deserialize, Serialize};

use crate::{FaceImages, Handle, Spectrum};

/// A number, or a texture of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum FloatParam {
    /// The same everywhere.
    Constant(f32),
    /// A texture; of a colour, the mean of its components.
    Texture(Handle<Texture>),
}

impl FloatParam {
    /// The texture, if it is one.
    pub const fn texture(&self) -> Option<Handle<Texture>> {
        match *self {
            Self::Texture(handle) => Some(handle),
            Self::Constant(_) => None,
        }
    }
}

/// A spectrum, or a texture of spectra.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum SpectrumParam {
    /// The same everywhere.
    Constant(Spectrum),
    /// A texture.
    Texture(Handle<Texture>),
}

impl SpectrumParam {
    /// The texture, if it is one.
    pub const fn texture(&self) -> Option<Handle<Texture>> {
        match *self {
            Self::Texture(handle) => Some(handle),
            Self::Constant(_) => None,
        }
    }
}

/// A function over surfaces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Texture {
    /// The same everywhere.
    Constant(Spectrum),
    /// A product.
    Scale {
        /// First factor.
        texture: SpectrumParam,
        /// Second factor.
        scale: FloatParam,
    },
    /// `(1 − amount) first + amount second`.
    Mix {
        /// Where the amount is zero.
        first: SpectrumParam,
        /// Where the amount is one.
        second: SpectrumParam,
        /// The weight of the second.
        amount: FloatParam,
    },
    /// `|n · direction| first + (1 − |n · direction|) second`, n being the unit geometric normal.
    DirectionMix {
        /// Where the surface faces the direction.
        first: SpectrumParam,
        /// Where the surface lies along the direction.
        second: SpectrumParam,
        /// In the world; its length does not matter.
        direction: Vec3,
    },
    /// The bilinear interpolation of four values, which goes on outside the unit square.
    Bilerp {
        /// Surface to texture space.
        mapping: TextureMapping,
        /// At (s, t) = (0, 0), (1, 0), (0, 1), (1, 1).
        corners: [SpectrumParam; 4],
    },
    /// Alternating unit squares of texture space.
    Checkerboard {
        /// Surface to texture space.
        mapping: TextureMapping,
        /// In squares whose coordinates have an even sum.
        even: SpectrumParam,
        /// In the other squares.
        odd: SpectrumParam,
    },
    /// Alternating unit cubes of space.
    SolidCheckerboard {
        /// From the world to the space of the cubes.
        world_to_texture: Transform,
        /// In cubes whose coordinates have an even sum.
        even: SpectrumParam,
        /// In the other cubes.
        odd: SpectrumParam,
    },
    /// Disks of radius 0.35, one in about half of the unit squares of texture space, at random places.
    Dots {
        /// Surface to texture space.
        mapping: TextureMapping,
        /// In the disks.
        inside: SpectrumParam,
        /// Around them.
        outside: SpectrumParam,
    },
    /// A sum of octaves of noise, about zero.
    Fbm(SolidNoise),
    /// A sum of absolute values of octaves of noise.
    Wrinkled(SolidNoise),
    /// Waves of water under gusts of wind.
    Windy {
        /// From the world to the space of the noise.
        world_to_texture: Transform,
    },
    /// Grey veins in layers along y, bent by noise.
    Marble {
        /// Bends the layers.
        noise: SolidNoise,
        /// Factor on the coordinates of the noise's space.
        scale: f32,
        /// How far the noise bends.
        variation: f32,
    },
    /// An image file.
    Image(ImageTexture),
    /// An image for each face of a mesh.
    Faces(FaceTexture),
}

impl Texture {
    /// The textures that this one refers to.
    pub fn parts(&self) -> impl Iterator<Item = Handle<Self>> {
        let parts = match self {
            Self::Constant(_)
            | Self::Image(_)
            | Self::Faces(_)
            | Self::Fbm(_)
            | Self::Wrinkled(_)
            | Self::Windy { .. }
            | Self::Marble { .. } => [None; 4],
            Self::Scale { texture, scale } => [texture.texture(), scale.texture(), None, None],
            Self::Mix { first, second, amount } => {
                [first.texture(), second.texture(), amount.texture(), None]
            }
            Self::Bilerp { corners, .. } => corners.each_ref().map(SpectrumParam::texture),
            Self::DirectionMix { first: a, second: b, .. }
            | Self::Checkerboard { even: a, odd: b, .. }
            | Self::SolidCheckerboard { even: a, odd: b, .. }
            | Self::Dots { inside: a, outside: b, .. } => [a.texture(), b.texture(), None, None],
        };
        parts.into_iter().flatten()
    }
}

/// Octaves of gradient noise in space, each of about twice the frequency of the one before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolidNoise {
    /// From the world to the space of the noise, whose lattice has unit cells.
    pub world_to_texture: Transform,
    /// How many there are; fewer are added where they would be finer than the pixels.
    pub octaves: u32,
    /// The factor from the weight of an octave to that of the next.
    pub roughness: f32,
}

impl SolidNoise {
    /// More octaves than this are not asked for: the 31st is finer than numbers of 32 bits.
    pub const MOST_OCTAVES: u32 = 32;
}

/// An image wrapped over a surface. v = 0 is its bottom row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageTexture {
    /// The pixels, which know their encoding.
    pub image: Handle<Arc<Image>>,
    /// Surface to texture space.
    pub mapping: TextureMapping,
    /// What lies outside the unit square.
    pub wrap: Wrap,
    /// What lies between pixels.
    pub filter: TextureFilter,
    /// Factor on the values.
    pub scale: f32,
    /// Whether values, after scaling, are subtracted from one.
    pub invert: bool,
}

impl ImageTexture {
    /// The largest ratio of axes that [`TextureFilter::Ewa`] may have, which bounds the pixels that a look-up reads.
    pub const MOST_ANISOTROPY: f32 = 64.0;
}

/// Images of the faces of a mesh, found by the number that a face has in it ([`Mesh::face_indices`](crate::Mesh::face_indices)) and the
/// coordinates of the surface.
///
/// What displaces a surface, and what it emits, is looked up in face zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaceTexture {
    /// The images.
    pub images: Arc<FaceImages>,
    /// What their values mean. They are decoded after filtering.
    pub encoding: Encoding,
    /// Factor on the decoded values.
    pub scale: f32,
}

/// From a point of a surface to the point (s, t) of texture space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum TextureMapping {
    /// By the coordinates of the surface.
    Uv(UvMapping),
    /// By direction from the origin: s = θ/π from +z, t = φ/2π from +x towards +y.
    Spherical {
        /// From the world to the space of the directions.
        world_to_texture: Transform,
    },
    /// By direction about the z axis and by height: s = ½ + φ/2π with φ in (−π, π], t = z.
    Cylindrical {
        /// From the world to the space of the cylinder.
        world_to_texture: Transform,
    },
    /// Along two directions: s = p · s + ds, t = p · t + dt.
    Planar {
        /// From the world to the space of the directions.
        world_to_texture: Transform,
        /// How s changes.
        s: Vec3,
        /// How t changes.
        t: Vec3,
        /// ds and dt.
        offset: [f32; 2],
    },
}

impl Default for TextureMapping {
    fn default() -> Self {
        Self::Uv(UvMapping::default())
    }
}

/// An affine map of surface coordinates: `(su u + du, sv v + dv)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UvMapping {
    /// Factors.
    pub scale: [f32; 2],
    /// Offsets.
    pub offset: [f32; 2],
}

impl Default for UvMapping {
    fn default() -> Self {
        Self { scale: [1.0, 1.0], offset: [0.0, 0.0] }
    }
}

/// What an image shows outside the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wrap {
    /// Itself again.
    Repeat,
    /// Its border pixels.
    Clamp,
    /// Nothing.
    Black,
    /// What is next to the border when the square is folded to an octahedron (Clarberg's map of the sphere).
    OctahedralSphere,
}

/// What an image shows between its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum TextureFilter {
    /// The nearest pixel.
    Nearest,
    /// Linear interpolation of four pixels.
    Bilinear,
    /// The mean over a square about as large as the footprint of a pixel of the picture: linear interpolation in two
    /// levels of a pyramid of ever smaller images (Williams, *Pyramidal Parametrics*, SIGGRAPH 1983).
    Trilinear,
    /// A Gaussian mean over the ellipse that is the footprint (Heckbert, *Fundamentals of Texture Mapping and Image
    /// Warping*, 1989).
    Ewa {
        /// Longer ellipses are made wider: the largest ratio of their axes, from one to
        /// [`ImageTexture::MOST_ANISOTROPY`].
        max_anisotropy: f32,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_all_textures_of_all_parameters() {
        let texture = |i: u32| SpectrumParam::Texture(Handle::new(i));
        let constant = SpectrumParam::Constant(Spectrum::Constant(1.0));
        let parts = |texture: Texture| texture.parts().map(Handle::index).collect::<Vec<_>>();
        let amount = FloatParam::Texture(Handle::new(3));
        assert_eq!(parts(Texture::Mix { first: texture(1), second: texture(2), amount }), [1, 2, 3]);
        assert_eq!(parts(Texture::Scale { texture: constant.clone(), scale: amount }), [3]);
        let corners = [texture(4), constant.clone(), texture(5), texture(6)];
        assert_eq!(parts(Texture::Bilerp { mapping: TextureMapping::default(), corners }), [4, 5, 6]);
        let dots =
            Texture::Dots { mapping: TextureMapping::default(), inside: constant, outside: texture(7) };
        assert_eq!(parts(dots), [7]);
        assert!(parts(Texture::Windy { world_to_texture: Transform::IDENTITY }).is_empty());
    }
}
