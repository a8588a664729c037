//! Functions over surfaces, ready to be evaluated.
//!
//! Design decision: the textures of a scene are compiled once into a flat list of nodes that refer to each other by
//! number. What is constant is found then: a [`FloatSource`] or [`SpectrumSource`] of a constant parameter holds its
//! value and costs a branch. The work of one evaluation is bounded at that time too, so that no scene file can overflow
//! the stack or stall a pixel: cycles, and textures that would evaluate too many others, are errors.
//!
//! A texture is evaluated at a [`TexturePoint`], which knows how much of the surface a pixel of the picture covers. Only
//! noise, checkerboards, images of faces and the filters `trilinear` and `EWA` ask for that; all others leave smoothing to the samples of the pixel.
//!
//! Deliberately absent: differentials carried along paths. The camera estimates the footprint at any point, as pbrt-v4
//! does.
//!
//! In a scene file: `Texture "floor" "spectrum" "checkerboard" "float uscale" 8 "float vscale" 8 "rgb tex1" [.8 .2 .1]`.

mod checks;
mod compile;
mod faces;
mod filter;
mod image;
mod mapping;
pub(crate) mod noise;
mod pyramid;
mod solid;

use std::ops::{Add, Mul};

use sahl_math::{Transform, Vec2, Vec3};

use crate::spectrum::{ColorLookup, ColorRole, SpectralCurve, Spectrum, Wavelengths};
use faces::{FaceNode, FaceValue};
use image::ImageNode;
use mapping::Mapping;
use solid::{SolidNode, SolidValue};

/// Where a texture is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexturePoint {
    /// Surface coordinates.
    pub uv: Vec2,
    /// Position in the world.
    pub p: Vec3,
    /// Unit geometric normal in the world, either side.
    pub n: Vec3,
    /// The number of the face among those that face textures have images for; zero where it is not known or nobody asks.
    pub face: u32,
    /// What a pixel of the picture covers there; zero where it is not known or nobody asks.
    pub footprint: Footprint,
}

/// How a point of a surface and its coordinates change from a pixel of the picture to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// ∂p/∂x, to the next pixel in the row; in the world.
    pub dp_dx: Vec3,
    /// ∂p/∂y, to the next row.
    pub dp_dy: Vec3,
    /// ∂(u, v)/∂x.
    pub duv_dx: Vec2,
    /// ∂(u, v)/∂y.
    pub duv_dy: Vec2,
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
#[derive(Clone, Debug, PartialEq)]
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
    /// Whether a node asks for the footprint.
    needs_footprint: bool,
    /// Whether a node asks for the number of the face.
    needs_face: bool,
    /// Bytes of the smaller sizes of images, and of images of faces.
    pyramid_bytes: u64,
}

/// A step of evaluation; the nodes it refers to come before it in the list.
#[derive(Clone, Debug)]
enum Node {
    Constant(ConstantNode),
    Scale { texture: TextureId, scale: FloatSource },
    Mix { first: TextureId, second: TextureId, amount: FloatSource },
    DirectionMix { first: TextureId, second: TextureId, direction: Vec3 },
    Bilerp { mapping: Mapping, corners: [TextureId; 4] },
    Checkerboard { mapping: Mapping, even: TextureId, odd: TextureId },
    SolidCheckerboard { to_texture: Box<Transform>, even: TextureId, odd: TextureId },
    Dots { mapping: Mapping, inside: TextureId, outside: TextureId },
    Solid(Box<SolidNode>),
    Image(ImageNode),
    Faces(FaceNode),
}

/// A constant as each kind of parameter sees it.
#[derive(Clone, Debug)]
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

/// What a texture is read as: how its leaves become values. Between leaves all kinds are computed alike.
trait Kind {
    type Value: Copy + Add<Output = Self::Value> + Mul<f32, Output = Self::Value>;

    fn number(&self, value: f32) -> Self::Value;
    /// `rgb` is a colour in linear sRGB.
    fn color(&self, rgb: [f32; 3]) -> Self::Value;
    fn constant(&self, constant: &ConstantNode) -> Self::Value;
    fn image(&self, image: &ImageNode, at: &TexturePoint) -> Self::Value;
}

/// A texture read as numbers; of a colour, the mean of its components.
struct Numbers;

impl Kind for Numbers {
    type Value = f32;

    fn number(&self, value: f32) -> f32 {
        value
    }

    fn color(&self, [r, g, b]: [f32; 3]) -> f32 {
        (r + g + b) * (1.0 / 3.0)
    }

    fn constant(&self, constant: &ConstantNode) -> f32 {
        constant.float
    }

    fn image(&self, image: &ImageNode, at: &TexturePoint) -> f32 {
        image.float(at)
    }
}

/// A texture read as spectra for a certain role.
struct Spectra<'a> {
    role: ColorRole,
    wavelengths: &'a Wavelengths,
}

impl Spectra<'_> {
    /// Limited to what the role allows.
    fn limited(&self, spectrum: Spectrum) -> Spectrum {
        let high = if self.role == ColorRole::Albedo { 1.0 } else { f32::MAX };
        spectrum.clamp(0.0, high)
    }
}

impl Kind for Spectra<'_> {
    type Value = Spectrum;

    fn number(&self, value: f32) -> Spectrum {
        self.limited(Spectrum::splat(value))
    }

    fn color(&self, rgb: [f32; 3]) -> Spectrum {
        ColorLookup::SRGB.at(rgb, self.role, self.wavelengths)
    }

    fn constant(&self, constant: &ConstantNode) -> Spectrum {
        constant.curve(self.role).at(self.wavelengths)
    }

    fn image(&self, image: &ImageNode, at: &TexturePoint) -> Spectrum {
        image.spectrum(at, self.role, self.wavelengths)
    }
}

impl Textures {
    /// The value of `source` at a point.
    #[inline]
    pub fn float(&self, source: &FloatSource, at: &TexturePoint) -> f32 {
        match *source {
            FloatSource::Constant(value) => value,
            FloatSource::Texture(id) => self.value(id, at, &Numbers),
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
            SpectrumSource::Texture(id, role) => self.value(*id, at, &Spectra { role: *role, wavelengths }),
        }
    }

    /// Whether any texture asks for the footprint of a pixel.
    #[inline]
    pub fn need_footprint(&self) -> bool {
        self.needs_footprint
    }

    /// Whether any texture asks for the number of the face.
    #[inline]
    pub fn need_face(&self) -> bool {
        self.needs_face
    }

    /// Bytes that images take beside their own pixels, for smaller sizes, and images of faces in all.
    pub fn pyramid_bytes(&self) -> u64 {
        self.pyramid_bytes
    }

    fn value<K: Kind>(&self, id: TextureId, at: &TexturePoint, kind: &K) -> K::Value {
        let value = |id: &TextureId| self.value(*id, at, kind);
        match &self.nodes[id.0 as usize] {
            Node::Constant(constant) => kind.constant(constant),
            Node::Scale { texture, scale } => {
                let scale = self.float(scale, at);
                if scale == 0.0 { kind.number(0.0) } else { value(texture) * scale }
            }
            Node::Mix { first, second, amount } => {
                blend(self.float(amount, at), |is_second| value(if is_second { second } else { first }))
            }
            Node::DirectionMix { first, second, direction } => {
                let amount = 1.0 - at.n.dot(*direction).abs();
                blend(amount, |is_second| value(if is_second { second } else { first }))
            }
            Node::Bilerp { mapping, corners: [v00, v10, v01, v11] } => {
                let st = mapping.map(at);
                let row = |left, right| value(left) * (1.0 - st.x) + value(right) * st.x;
                row(v00, v10) * (1.0 - st.y) + row(v01, v11) * st.y
            }
            Node::Checkerboard { mapping, even, odd } => {
                let st = mapping.map(at);
                let amount = checks::odd_share([st.x, st.y], checks::reach(&mapping.differentials(at)));
                blend(amount, |is_odd| value(if is_odd { odd } else { even }))
            }
            Node::SolidCheckerboard { to_texture, even, odd } => {
                let reach = checks::solid_reach(&at.footprint, |v| to_texture.vector(v));
                let amount = checks::odd_share(<[f32; 3]>::from(to_texture.point(at.p)), reach);
                blend(amount, |is_odd| value(if is_odd { odd } else { even }))
            }
            Node::Dots { mapping, inside, outside } => {
                let st = mapping.map(at);
                value(if solid::is_in_dot(st.x, st.y) { inside } else { outside })
            }
            Node::Solid(solid) => match solid.value(at) {
                SolidValue::Number(value) => kind.number(value),
                SolidValue::Color(rgb) => kind.color(rgb),
            },
            Node::Image(image) => kind.image(image, at),
            Node::Faces(faces) => match faces.value(at) {
                FaceValue::Number(value) => kind.number(value),
                FaceValue::Color(rgb) => kind.color(rgb),
            },
        }
    }
}

/// `(1 − amount) first + amount second`; what counts nothing is not evaluated.
fn blend<T>(amount: f32, value: impl Fn(bool) -> T) -> T
where
    T: Mul<f32, Output = T> + Add<Output = T>,
{
    if amount == 0.0 {
        value(false)
    } else if amount == 1.0 {
        value(true)
    } else {
        value(false) * (1.0 - amount) + value(true) * amount
    }
}

#[cfg(test)]
mod tests;
