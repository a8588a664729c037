//! Images of faces, filtered across their edges.
//!
//! Around the point stands a kernel, the product of cubic B-splines along u and v that are as wide as the footprint and at least
//! a pixel: four widths in all. Its taps are the pixels of the face at the size at which the narrower width is one to two pixels. Those
//! beyond an edge belong to the neighbour there, turned and, next to parts of faces that have not four corners, scaled as its
//! coordinates are; of a neighbour with more pixels a smaller size is read, and of one with fewer the pixel that holds the tap. Where
//! there is no neighbour, the border pixels go on. Taps beyond a corner at which not four faces meet have no place, and are left out.
//! Weights are divided by their sum, so that what is constant stays constant.
//!
//! Source: Burley, Lacewell, *Ptex: Per-Face Texture Mapping for Production Rendering*, EGSR 2008, section 5. It is what pbrt-v4's `ptex`
//! does with the filter `f_bspline` of the Ptex library, and as there values are decoded after they are filtered.
//!
//! Deviations from that library: sizes get smaller along both axes at once, so that a long footprint takes more taps, and one
//! longer than four times its width is made wider; widths end at half a face, beyond which pixels of the picture are left to
//! average; smaller sizes are computed here, not read from the file; decoded values are not rounded to 8 bits before.
//!
//! As in the library, a seam stays where faces have different numbers of pixels and the footprint is small: each side is smoothed over its
//! own pixels.
//!
//! Deliberately absent: coordinates outside the face, which are moved to its border, and faces that do not exist, which are black.
//!
//! In a scene file: `Texture "paint" "spectrum" "ptex" "string filename" "paint.ptx"`.

mod kernel;
mod pyramid;
mod walk;

use std::sync::Arc;

use sahl_image::Encoding;
use sahl_math::Vec2;
use sahl_scene::FaceTexture;

use super::TexturePoint;
use kernel::Taps;
pub(super) use pyramid::Pyramid;
use walk::Place;

/// Logarithm to base two of the length of footprints that are left as narrow as they are, in widths.
const MOST_ASPECT_LOG2: u32 = 2;

/// A texture of faces.
#[derive(Clone, Debug)]
pub(super) struct FaceNode {
    pyramid: Arc<Pyramid>,
    encoding: Encoding,
    scale: f32,
}

/// What a texture of faces holds at a point.
pub(super) enum FaceValue {
    Number(f32),
    Color([f32; 3]),
}

impl FaceNode {
    pub(super) fn new(texture: &FaceTexture, pyramid: Arc<Pyramid>) -> Self {
        Self { pyramid, encoding: texture.encoding, scale: texture.scale }
    }

    /// The value at a point, filtered, decoded and scaled.
    #[inline(never)]
    pub(super) fn value(&self, at: &TexturePoint) -> FaceValue {
        let footprint = &at.footprint;
        // The box about the footprint.
        let width = footprint.duv_dx.abs() + footprint.duv_dy.abs();
        let values = self.pyramid.filtered(at.face, at.uv, width).map(|value| self.decoded(value));
        if self.pyramid.channels() == 1 { FaceValue::Number(values[0]) } else { FaceValue::Color(values) }
    }

    fn decoded(&self, value: f32) -> f32 {
        let value = match self.encoding {
            Encoding::Linear => value,
            encoding => encoding.decode(value.clamp(0.0, 1.0)),
        };
        self.scale * value
    }
}

impl Pyramid {
    /// The mean about the point `uv` of a face over a width along u and one along v; channels that are not there are zero.
    fn filtered(&self, face: u32, uv: Vec2, width: Vec2) -> [f32; 3] {
        let Some(log2) = self.size_log2(face) else { return [0.0; 3] };
        let widths = [width.x, width.y].map(kernel::limited);
        let reductions = [0, 1].map(|axis| kernel::reduction(widths[axis], log2[axis]));
        let [least, most] = [reductions[0].min(reductions[1]), reductions[0].max(reductions[1])];
        let level = least.max(most.saturating_sub(MOST_ASPECT_LOG2));
        let grid = log2.map(|log| log.saturating_sub(level));
        let [u, v] = [(uv.x, 0), (uv.y, 1)].map(|(x, axis)| Taps::new(x, widths[axis], grid[axis]));

        let (mut sum, mut weight_sum) = ([0.0; 3], 0.0);
        for (j, v_weight) in v.iter() {
            for (i, u_weight) in u.iter() {
                let weight = u_weight * v_weight;
                let Some(place) = self.place(Place::of_tap(face, [i, j], grid)) else { continue };
                let texel = self.texel(&place);
                for (sum, value) in sum.iter_mut().zip(texel) {
                    *sum += weight * value;
                }
                weight_sum += weight;
            }
        }
        if weight_sum > 0.0 { sum.map(|sum| sum / weight_sum) } else { sum }
    }
}

#[cfg(test)]
mod tests;
