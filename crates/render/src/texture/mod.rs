//! Functions over surfaces, ready to be evaluated.
//!
//! Design decision: the textures of a scene are compiled once into a flat list of nodes that refer to each other by
//! number. What is constant is found then: a [`FloatSource`] or [`SpectrumSource`] of a constant parameter holds its
//! value and costs a branch. The work of one evaluation is bounded at that time too, so that no scene file can overflow
//! the stack or stall a pixel: cycles, and textures that would evaluate too many others, are errors.
//!
//! Deliberately absent: filtering over the footprint of a ray, and noise.
//!
//! In a scene file: `Texture "floor" "spectrum" "checkerboard" "float uscale" 8 "float vscale" 8 "rgb tex1" [.8 .2 .1]`.

mod compile;
mod image;

use sahl_math::{Vec2, Vec3};
use sahl_scene::UvMapping;

use crate::spectrum::{ColorRole, SpectralCurve, Spectrum, Wavelengths};
use image::ImageNode;

/// Where a texture is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexturePoint {
    /// Surface coordinates.
    pub uv: Vec2,
    /// Position in the world.
    pub p: Vec3,
}

/// A number that may vary over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatSource {
    /// The same everywhere.
    Constant(f32),
    /// A texture.
    Texture(TextureId),
}

/// A spectrum that may vary over a surface, and what it is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpectrumSource {
    /// The same everywhere.
    Constant(SpectralCurve),
    /// A texture.
    Texture(TextureId, ColorRole),
}

/// A compiled texture of a [`Textures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureId(u32);

/// The compiled textures of a scene.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    nodes: Vec<Node>,
    /// The node of each texture of the scene, in the order of its arena.
    resolved: Vec<TextureId>,
}

/// A step of evaluation; the nodes it refers to come before it in the list.
#[derive(Clone, Debug)]
enum Node {
    Constant(ConstantNode),
    Scale { texture: TextureId, scale: FloatSource },
    Mix { first: TextureId, second: TextureId, amount: FloatSource },
    Checkerboard { mapping: UvMapping, even: TextureId, odd: TextureId },
    Image(ImageNode),
}

/// A constant as each kind of parameter sees it.
#[derive(Clone, Copy, Debug)]
struct ConstantNode {
    float: f32,
    albedo: SpectralCurve,
    unbounded: SpectralCurve,
    illuminant: SpectralCurve,
}

impl ConstantNode {
    fn curve(&self, role: ColorRole) -> &SpectralCurve {
        match role {
            ColorRole::Albedo => &self.albedo,
            ColorRole::Unbounded => &self.unbounded,
            ColorRole::Illuminant => &self.illuminant,
        }
    }
}

impl Textures {
    /// The value of `source` at a point.
    #[inline]
    pub fn float(&self, source: &FloatSource, at: &TexturePoint) -> f32 {
        match *source {
            FloatSource::Constant(value) => value,
            FloatSource::Texture(id) => self.node_float(id, at),
        }
    }

    /// The value of `source` at a point, in each lane.
    #[inline]
    pub fn spectrum(
        &self,
        source: &SpectrumSource,
        at: &TexturePoint,
        wavelengths: &Wavelengths,
    ) -> Spectrum {
        match source {
            SpectrumSource::Constant(curve) => curve.at(wavelengths),
            SpectrumSource::Texture(id, role) => self.node_spectrum(*id, *role, at, wavelengths),
        }
    }

    fn node_float(&self, id: TextureId, at: &TexturePoint) -> f32 {
        match &self.nodes[id.0 as usize] {
            Node::Constant(constant) => constant.float,
            Node::Scale { texture, scale } => {
                let scale = self.float(scale, at);
                if scale == 0.0 { 0.0 } else { scale * self.node_float(*texture, at) }
            }
            Node::Mix { first, second, amount } => blend(self.float(amount, at), |is_second| {
                self.node_float(if is_second { *second } else { *first }, at)
            }),
            Node::Checkerboard { mapping, even, odd } => {
                self.node_float(if is_even_square(mapping, at.uv) { *even } else { *odd }, at)
            }
            Node::Image(image) => image.float(at.uv),
        }
    }

    fn node_spectrum(
        &self,
        id: TextureId,
        role: ColorRole,
        at: &TexturePoint,
        wavelengths: &Wavelengths,
    ) -> Spectrum {
        let value = |id| self.node_spectrum(id, role, at, wavelengths);
        match &self.nodes[id.0 as usize] {
            Node::Constant(constant) => constant.curve(role).at(wavelengths),
            Node::Scale { texture, scale } => {
                let scale = self.float(scale, at);
                if scale == 0.0 { Spectrum::ZERO } else { value(*texture) * scale }
            }
            Node::Mix { first, second, amount } => {
                blend(self.float(amount, at), |is_second| value(if is_second { *second } else { *first }))
            }
            Node::Checkerboard { mapping, even, odd } => {
                value(if is_even_square(mapping, at.uv) { *even } else { *odd })
            }
            Node::Image(image) => image.spectrum(at.uv, role, wavelengths),
        }
    }
}

/// `(1 − amount) first + amount second`; what counts nothing is not evaluated.
fn blend<T>(amount: f32, value: impl Fn(bool) -> T) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    if amount == 0.0 {
        value(false)
    } else if amount == 1.0 {
        value(true)
    } else {
        value(false) * (1.0 - amount) + value(true) * amount
    }
}

/// The point of texture space at surface coordinates `uv`.
#[inline]
fn map_uv(mapping: &UvMapping, uv: Vec2) -> Vec2 {
    Vec2::new(mapping.scale[0] * uv.x + mapping.offset[0], mapping.scale[1] * uv.y + mapping.offset[1])
}

/// Whether the integer parts of the texture coordinates have an even sum.
#[inline]
fn is_even_square(mapping: &UvMapping, uv: Vec2) -> bool {
    let st = map_uv(mapping, uv);
    // Parities add up without overflow; casts saturate.
    (st.x.floor() as i64 & 1) == (st.y.floor() as i64 & 1)
}

#[cfg(test)]
mod tests;
