//! Flat projections, with a pinhole or a thin lens.
//!
//! A film position is mapped by one linear function to the plane of projection; a lens adds two more numbers.
//!
//! Source: Kolb, Mitchell, Hanrahan, *A Realistic Camera Model for Computer Graphics*, SIGGRAPH 1995, section 2; Pharr, Jakob,
//! Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 5.2.3. Deviation from pbrt-v4: there all rays of an orthographic
//! camera with a lens start on the axis, and the picture becomes a perspective. Here they start about their own place.

use sahl_math::{Vec2, Vec3};
use sahl_scene::Projection;

use super::CameraRay;
use crate::warp;

/// A perspective or orthographic projection.
#[derive(Clone, Debug)]
pub(super) struct Projective {
    is_perspective: bool,
    /// The plane of projection at the upper left corner of the film, and its change a pixel, in camera space: at
    /// distance one for a perspective camera, at distance zero for an orthographic one.
    corner: Vec2,
    per_pixel: Vec2,
    /// Width and height of the image.
    size: Vec2,
    lens_radius: f32,
    focal_distance: f32,
}

impl Projective {
    /// The projection with the angle of view `fov`, or the orthographic one, for an image of `resolution` pixels.
    ///
    /// Without a screen window, the shorter axis of the image spans −1 to 1 and pixels are square (pbrt's rule).
    pub(super) fn new(camera: &sahl_scene::Camera, fov: Option<f32>, resolution: [u32; 2]) -> Self {
        let [width, height] = resolution.map(|pixels| pixels.max(1) as f32);
        let shorter = width.min(height);
        let [x_min, x_max, y_min, y_max] = camera.screen_window.unwrap_or([
            -width / shorter,
            width / shorter,
            -height / shorter,
            height / shorter,
        ]);
        let scale = fov.map_or(1.0, |fov| (0.5 * fov).tan());
        Self {
            is_perspective: fov.is_some(),
            corner: Vec2::new(x_min, y_max) * scale,
            per_pixel: Vec2::new((x_max - x_min) / width, (y_min - y_max) / height) * scale,
            size: Vec2::new(width, height),
            lens_radius: camera.lens_radius,
            focal_distance: camera.focal_distance,
        }
    }

    /// The ray in camera space; its direction has any length.
    #[inline]
    pub(super) fn ray(&self, film: Vec2, lens: Vec2) -> CameraRay {
        let projected = self.corner + self.per_pixel * film;
        let (mut origin, mut direction) = if self.is_perspective {
            (Vec3::ZERO, Vec3::new(projected.x, projected.y, 1.0))
        } else {
            (Vec3::new(projected.x, projected.y, 0.0), Vec3::Z)
        };
        if self.lens_radius > 0.0 {
            // All rays of a film position meet where the chief ray meets the plane of focus.
            let focus = origin + direction * self.focal_distance;
            let offset = warp::concentric_disk(lens) * self.lens_radius;
            origin += Vec3::new(offset.x, offset.y, 0.0);
            direction = focus - origin;
        }
        CameraRay::new(origin, direction, 1.0)
    }

    /// How a point of the plane through `p` with normal `n` moves from pixel to pixel, through the middle of the lens; `None` if a
    /// perspective does not see it. In camera space.
    ///
    /// A pixel changes the direction d = p / z by e, and the ray along d + e meets the plane at z (n·p) / (n·p + z n·e).
    pub(super) fn footprint(&self, p: Vec3, n: Vec3) -> Option<[Vec3; 2]> {
        let projected = Vec2::new(p.x, p.y) / p.z - self.corner;
        let film = Vec2::new(projected.x / self.per_pixel.x, projected.y / self.per_pixel.y);
        let is_seen = (0.0..=self.size.x).contains(&film.x) && (0.0..=self.size.y).contains(&film.y);
        if !self.is_perspective || p.z <= 0.0 || !is_seen {
            return None;
        }
        let height = n.dot(p);
        let moved = [Vec3::new(self.per_pixel.x, 0.0, 0.0), Vec3::new(0.0, self.per_pixel.y, 0.0)].map(|e| {
            let moved = (e * height - p * n.dot(e)) * (p.z / (height + p.z * n.dot(e)));
            if moved.is_finite() { moved } else { Vec3::ZERO }
        });
        Some(moved)
    }
}

/// The angle of view of a perspective; `None` for an orthographic projection.
pub(super) fn field_of_view(projection: &Projection) -> Option<f32> {
    match projection {
        Projection::Perspective { fov } => Some(*fov),
        Projection::Orthographic | Projection::Spherical(_) | Projection::Realistic(_) => None,
    }
}
