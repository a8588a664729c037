//! Roughness of microfacets.

use sahl_math::safe_sqrt;

use super::Query;
use crate::texture::{FloatSource, Textures};

/// Microfacet slopes along the two tangents.
///
/// A path that came by a rough surface may be asked to see slopes below 0.3 doubled, and at least 0.1: pbrt-v4's
/// regularisation, which trades caustics of small lights, never found, for blurred ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roughness {
    /// The same everywhere.
    Constant([f32; 2]),
    /// Varying over the surface.
    Varying {
        /// Along the first tangent.
        u: FloatSource,
        /// Along the second tangent.
        v: FloatSource,
        /// Whether α is the square root of the roughness.
        remap: bool,
    },
}

impl Roughness {
    pub(super) fn new(roughness: &sahl_scene::Roughness, textures: &Textures) -> Self {
        let (u, v) = (textures.float_source(&roughness.u), textures.float_source(&roughness.v));
        match (u, v) {
            (FloatSource::Constant(u), FloatSource::Constant(v)) => {
                Self::Constant([slope(u, roughness.remap), slope(v, roughness.remap)])
            }
            _ => Self::Varying { u, v, remap: roughness.remap },
        }
    }

    /// α along the two tangents.
    #[inline]
    pub(super) fn alpha(&self, query: &Query<'_>) -> [f32; 2] {
        let alpha = match self {
            Self::Constant(alpha) => *alpha,
            Self::Varying { u, v, remap } => [slope(query.float(u), *remap), slope(query.float(v), *remap)],
        };
        if query.regularize { alpha.map(regularized) } else { alpha }
    }
}

/// α of a roughness: its square root under pbrt-v4's remapping, else itself.
#[inline]
fn slope(roughness: f32, remap: bool) -> f32 {
    if remap { safe_sqrt(roughness) } else { roughness }
}

/// α of a surface that a path with a rough bounce sees, if it is regularised.
#[inline]
pub(super) fn regularized(alpha: f32) -> f32 {
    if alpha < 0.3 { (2.0 * alpha).clamp(0.1, 0.3) } else { alpha }
}
