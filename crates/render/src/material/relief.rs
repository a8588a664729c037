//! Bumps and normal maps: shading normals that a material gives to the surface.
//!
//! A shading normal may lean so far that the mirror image of the viewer lies below the surface: what is reflected there
//! would be lost, and the surface dark. Such a normal is turned back, just as far as needed. Light that a normal would let
//! through the surface is left out by the integrators. Scenes that ask for leaky normals ([`sahl_scene::Quirks`]) get neither.

use std::sync::Arc;

use sahl_image::Image;
use sahl_math::{Frame, Vec2, Vec3};
use sahl_scene::SceneDesc;

use super::Query;
use crate::interaction::Interaction;
use crate::shape::Derivatives;
use crate::texture::{FloatSource, Footprint, TexturePoint, Textures};

/// Where the normals of a material come from.
///
/// In a scene file: `Material "diffuse" "texture displacement" "waves"` or `"string normalmap" "bricks.png"`.
#[derive(Clone, Debug)]
pub enum Relief {
    /// A height above the surface, which itself stays where it is.
    Bump(FloatSource),
    /// Normals in the frame of ∂p/∂u and the surface's normal: (n + 1) / 2 as a linear image.
    Normals(Arc<Image>),
}

/// The step in u and v over which heights are compared where no footprint is known: pbrt-v4's.
const STEP: f32 = 0.0005;

impl PartialEq for Relief {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Bump(a), Self::Bump(b)) => a == b,
            (Self::Normals(a), Self::Normals(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl Relief {
    /// The relief of a scene; flat where its image does not exist, which validation reports.
    pub(super) fn new(relief: &sahl_scene::Relief, scene: &SceneDesc, textures: &Textures) -> Self {
        match relief {
            sahl_scene::Relief::Bump(height) => Self::Bump(textures.float_source(height)),
            sahl_scene::Relief::Normals(image) => match scene.images.get(*image) {
                Some(image) => Self::Normals(Arc::clone(image)),
                None => Self::Bump(FloatSource::Constant(0.0)),
            },
        }
    }

    /// Gives the surface its normal at a point that is seen from `wo`. `derivatives` tells how the surface changes.
    pub(crate) fn shape(
        &self,
        at: &mut Interaction,
        wo: Vec3,
        query: &Query<'_>,
        derivatives: impl FnOnce(&Interaction) -> Derivatives,
    ) {
        let (n, tangent) = match self {
            Self::Bump(height) => {
                let Some(found) = bumped(height, at, query, &derivatives(at)) else { return };
                found
            }
            Self::Normals(image) => {
                let Some(n) = mapped_normal(image, at.uv).try_normalize() else { return };
                (at.shading.to_world(n), at.shading.x)
            }
        };
        let n = n.face_forward(at.ng);
        let n = if at.is_leaky { n } else { turned_back(n, at.ng, wo) };
        at.shading = Frame::from_z_and_tangent(n, tangent);
    }
}

/// The normal of a surface that is raised by `height`, and its ∂p/∂u; `None` where it has none.
///
/// p' = p + h n. Source: Blinn, *Simulation of Wrinkled Surfaces*, SIGGRAPH 1978; with the step of pbrt-v4, half a pixel.
fn bumped(
    height: &FloatSource,
    at: &Interaction,
    query: &Query<'_>,
    surface: &Derivatives,
) -> Option<(Vec3, Vec3)> {
    let n = at.shading.z;
    let step = |dx: f32, dy: f32| {
        let step = 0.5 * (dx.abs() + dy.abs());
        if step > 0.0 && step.is_finite() { step } else { STEP }
    };
    let Footprint { duv_dx, duv_dy, .. } = query.at.footprint;
    let steps = [step(duv_dx.x, duv_dy.x), step(duv_dx.y, duv_dy.y)];
    let moved = |dp: Vec3, duv: Vec2| {
        let at = TexturePoint { uv: query.at.uv + duv, p: query.at.p + dp, ..*query.at };
        query.textures.float(height, &at)
    };
    let here = query.float(height);
    let by_u = (moved(surface.dp_du * steps[0], Vec2::new(steps[0], 0.0)) - here) / steps[0];
    let by_v = (moved(surface.dp_dv * steps[1], Vec2::new(0.0, steps[1])) - here) / steps[1];
    // Of the shading surface, whose normal is n.
    let project = |dp: Vec3| dp - n * n.dot(dp);
    let dp_du = project(surface.dp_du) + n * by_u + surface.dn_du * here;
    let dp_dv = project(surface.dp_dv) + n * by_v + surface.dn_dv * here;
    let bumped = dp_du.cross(dp_dv).try_normalize().filter(|n| n.is_finite())?;
    Some((bumped, dp_du))
}

/// The normal that the image shows at `uv`, in the frame of the surface; not of unit length.
fn mapped_normal(image: &Image, uv: Vec2) -> Vec3 {
    let wrapped = |x: i64, size: usize| x.rem_euclid(size.max(1) as i64) as usize;
    let position = |x: f32, size: usize| if x.is_finite() { x * size as f32 - 0.5 } else { 0.0 };
    let (x, y) = (position(uv.x, image.width), position(1.0 - uv.y, image.height));
    let (x0, y0) = (x.floor(), y.floor());
    let (dx, dy) = (x - x0, y - y0);
    let texel = |x: i64, y: i64| {
        let (x, y) = (wrapped(x, image.width), wrapped(y, image.height));
        let channel = |i: usize| image.texel(x, y, i.min(image.channels - 1));
        Vec3::new(channel(0), channel(1), channel(2))
    };
    let (x0, y0) = (x0 as i64, y0 as i64);
    let (x1, y1) = (x0.saturating_add(1), y0.saturating_add(1));
    let mean = (texel(x0, y0) * (1.0 - dx) + texel(x1, y0) * dx) * (1.0 - dy)
        + (texel(x0, y1) * (1.0 - dx) + texel(x1, y1) * dx) * dy;
    mean * 2.0 - Vec3::ONE
}

/// The shading normal `n`, turned toward the geometric one `ng` if `wo` would be mirrored into the surface by it.
///
/// The mirror image is moved up to the tangent plane, and the normal stands halfway between it and the viewer. Source:
/// Keller et al., *The Iray Light Transport Simulation and Rendering System*, 2017, appendix A.3.
fn turned_back(n: Vec3, ng: Vec3, wo: Vec3) -> Vec3 {
    // As seen by the viewer, who may be behind the surface.
    let side = 1.0_f32.copysign(wo.dot(ng));
    let (n, ng) = (n * side, ng * side);
    let mirrored = n * (2.0 * n.dot(wo)) - wo;
    let height = mirrored.dot(ng);
    if height >= 0.0 && n.dot(wo) > 0.0 {
        return n * side;
    }
    let level = (mirrored - ng * height).try_normalize();
    let halfway = level.and_then(|level| (level + wo).try_normalize()).unwrap_or(ng);
    halfway * side
}

#[cfg(test)]
mod tests {
    use sahl_image::Encoding;

    use super::*;
    use crate::spectrum::Wavelengths;

    fn interaction() -> Interaction {
        Interaction::test(Frame { x: Vec3::X, y: Vec3::Y, z: Vec3::Z }, Vec2::new(0.25, 0.5))
    }

    fn shaped(relief: &Relief, wo: Vec3, surface: Derivatives) -> Frame {
        let textures = Textures::default();
        let mut at = interaction();
        let point = TexturePoint { uv: at.uv, p: at.p, ..TexturePoint::default() };
        let query =
            Query { textures: &textures, at: &point, wavelengths: &mut Wavelengths::Rgb, regularize: false };
        relief.shape(&mut at, wo, &query, |_| surface);
        at.shading
    }

    #[test]
    fn a_normal_map_tilts_the_frame() {
        let image = Image::rgb_f32(1, 1, vec![0.8, 0.5, 0.9]).unwrap().with_encoding(Encoding::Linear);
        let frame = shaped(&Relief::Normals(Arc::new(image)), Vec3::Z, Derivatives::default());
        assert!((frame.z - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6, "{frame:?}");
        assert!((frame.x - Vec3::new(0.8, 0.0, -0.6)).length() < 1e-6, "{frame:?}");
    }

    #[test]
    fn the_map_is_the_right_way_up() {
        // The upper row leans to +x, the lower to -x; v = 0 is the bottom.
        let image = Image::rgb_f32(1, 2, vec![1.0, 0.5, 0.5, 0.0, 0.5, 0.5]).unwrap();
        assert!(mapped_normal(&image, Vec2::new(0.5, 0.75)).x > 0.9);
        assert!(mapped_normal(&image, Vec2::new(0.5, 0.25)).x < -0.9);
    }

    #[test]
    fn a_constant_height_changes_nothing_on_a_plane() {
        let surface = Derivatives { dp_du: Vec3::X * 2.0, dp_dv: Vec3::Y * 3.0, ..Derivatives::default() };
        let frame = shaped(&Relief::Bump(FloatSource::Constant(5.0)), Vec3::Z, surface);
        assert!((frame.z - Vec3::Z).length() < 1e-6, "{frame:?}");
    }

    #[test]
    fn leaky_surfaces_keep_their_normals() {
        let image = Image::rgb_f32(1, 1, vec![0.8, 0.5, 0.9]).unwrap().with_encoding(Encoding::Linear);
        let relief = Relief::Normals(Arc::new(image));
        let wo = Vec3::new(-0.99, 0.0, 0.14).normalize();
        let leaky = |is_leaky| {
            let mut at = Interaction { is_leaky, ..interaction() };
            let point = TexturePoint { uv: at.uv, p: at.p, ..TexturePoint::default() };
            let (textures, wavelengths) = (Textures::default(), &mut Wavelengths::Rgb);
            let query = Query { textures: &textures, at: &point, wavelengths, regularize: false };
            relief.shape(&mut at, wo, &query, |_| Derivatives::default());
            at
        };
        let (as_told, turned) = (leaky(true), leaky(false));
        assert!((as_told.shading.z - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6);
        assert!(turned.shading.z.x < 0.1, "{turned:?}");
        // The mirror image lies below the surface.
        let mirrored = as_told.shading.z * (2.0 * as_told.shading.z.dot(wo)) - wo;
        let guarded = Interaction { is_leaky: false, ..as_told };
        assert!(mirrored.z < 0.0 && as_told.sides_agree(wo, mirrored) && !guarded.sides_agree(wo, mirrored));
    }

    #[test]
    fn mirror_images_stay_above_the_surface_on_both_sides() {
        for (n, wo) in [
            (Vec3::new(0.8, 0.0, 0.6), Vec3::new(-0.9, 0.0, 0.1)),
            (Vec3::new(-0.6, 0.0, 0.8), Vec3::new(-0.98, 0.1, 0.05)),
            (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.9, 0.1, -0.3)),
        ] {
            let wo = wo.normalize();
            let turned = turned_back(n, Vec3::Z, wo);
            let mirrored = turned * (2.0 * turned.dot(wo)) - wo;
            assert!((turned.length() - 1.0).abs() < 1e-5);
            assert!(mirrored.z * wo.z > -1e-5, "{n:?} {wo:?}: {mirrored:?}");
            assert!(turned.dot(wo) * wo.z > 0.0 && turned.z > 0.0, "{turned:?}");
        }
        let upright = Vec3::new(0.1, 0.0, 0.99).normalize();
        assert_eq!(turned_back(upright, Vec3::Z, Vec3::Z), upright);
    }
}
