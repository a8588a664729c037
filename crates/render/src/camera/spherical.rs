//! Cameras that look in all directions.
//!
//! In a scene file: `Camera "spherical" "string mapping" "equirectangular"`.

use sahl_math::{Vec2, Vec3};
use sahl_scene::SphereLayout;

use super::CameraRay;
use crate::light::SphereMap;
use crate::warp::sin_cos_turns;

/// A camera at a point, whose film is the sphere about it.
#[derive(Clone, Debug)]
pub(super) struct Spherical {
    layout: SphereLayout,
    /// Of the unit square a pixel.
    per_pixel: Vec2,
}

impl Spherical {
    pub(super) fn new(layout: SphereLayout, resolution: [u32; 2]) -> Self {
        let [width, height] = resolution.map(|pixels| pixels.max(1) as f32);
        Self { layout, per_pixel: Vec2::new(1.0 / width, 1.0 / height) }
    }

    /// The ray in camera space, of unit direction. Places beyond the border, which pixel filters reach for, are those that
    /// continue the image there.
    #[inline]
    pub(super) fn ray(&self, film: Vec2) -> CameraRay {
        let uv = film * self.per_pixel;
        let direction = match self.layout {
            SphereLayout::Equirectangular => {
                let (sin_theta, cos_theta) = sin_cos_turns(0.5 * uv.y);
                let (sin_phi, cos_phi) = sin_cos_turns(uv.x);
                Vec3::new(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi)
            }
            SphereLayout::EqualArea => {
                let d = SphereMap::EqualArea.direction(folded(uv));
                Vec3::new(d.x, d.z, d.y)
            }
        };
        CameraRay::new(Vec3::ZERO, direction, 1.0)
    }
}

/// The place in the unit square that lies on the sphere where `uv` would: beyond a border the square goes on on the other
/// half of that border.
fn folded(uv: Vec2) -> Vec2 {
    let Vec2 { mut x, mut y } = uv;
    if !(0.0..=1.0).contains(&x) {
        x = if x < 0.0 { -x } else { 2.0 - x };
        y = 1.0 - y;
    }
    if !(0.0..=1.0).contains(&y) {
        y = if y < 0.0 { -y } else { 2.0 - y };
        x = 1.0 - x;
    }
    // Filters reach a few pixels; an image of fewer than those ends at its border.
    Vec2::new(x.clamp(0.0, 1.0), y.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_places_look_where_pbrt_looks() {
        let at = |layout, x, y| Spherical::new(layout, [200, 100]).ray(Vec2::new(x, y)).ray.direction;
        let close = |a: Vec3, b: Vec3| (a - b).length() < 1e-5;
        let lat_long = |x, y| at(SphereLayout::Equirectangular, x, y);
        assert!(close(lat_long(30.0, 0.0), Vec3::Y) && close(lat_long(30.0, 100.0), -Vec3::Y));
        assert!(close(lat_long(0.0, 50.0), Vec3::X) && close(lat_long(50.0, 50.0), Vec3::Z));
        assert!(close(lat_long(100.0, 50.0), -Vec3::X));
        let equal_area = |x, y| at(SphereLayout::EqualArea, x, y);
        assert!(close(equal_area(100.0, 50.0), Vec3::Y) && close(equal_area(0.0, 0.0), -Vec3::Y));
        assert!(close(equal_area(200.0, 50.0), Vec3::X) && close(equal_area(100.0, 100.0), Vec3::Z));
    }

    #[test]
    fn the_image_goes_on_beyond_its_border() {
        for layout in [SphereLayout::EqualArea, SphereLayout::Equirectangular] {
            let camera = Spherical::new(layout, [64, 64]);
            let direction = |x, y| camera.ray(Vec2::new(x, y)).ray.direction;
            for i in 0..64 {
                let i = i as f32 + 0.3;
                for (inside, outside) in [
                    ([1e-3, i], [-1e-3, i]),
                    ([64.0 - 1e-3, i], [64.0 + 1e-3, i]),
                    ([i, 1e-3], [i, -1e-3]),
                    ([i, 64.0 - 1e-3], [i, 64.0 + 1e-3]),
                ] {
                    let (a, b) = (direction(inside[0], inside[1]), direction(outside[0], outside[1]));
                    assert!((a - b).length() < 2e-3, "{layout:?} {inside:?} {outside:?}");
                }
            }
        }
    }
}
