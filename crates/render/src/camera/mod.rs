//! Cameras: from a place on the film to a ray in the world.
//!
//! Design decision: a film position is in pixels, (0, 0) being the upper left corner of the image, so that a pixel
//! filter adds its offset without knowing the camera. Both projections are one linear map of it; a lens adds two more
//! numbers.
//!
//! Deliberately absent: importance, which only light tracing needs, and motion of the shutter.
//!
//! In a scene file: `Camera "perspective" "float fov" 40 "float lensradius" .02 "float focaldistance" 3`.

use sahl_math::{Ray, Transform, Vec2, Vec3};
use sahl_scene::Projection;

use crate::warp;

/// A camera, ready to make rays.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    projection: Projection,
    /// The plane of projection at the upper left corner of the film, and its change a pixel, in camera space: at
    /// distance one for a perspective camera, at distance zero for an orthographic one.
    corner: Vec2,
    per_pixel: Vec2,
    lens_radius: f32,
    focal_distance: f32,
    camera_to_world: Transform,
    world_to_camera: Transform,
}

impl Camera {
    /// The camera that `description` asks for, for an image of `resolution` pixels.
    ///
    /// Without a screen window, the shorter axis of the image spans −1 to 1 and pixels are square (pbrt's rule).
    pub(crate) fn new(description: &sahl_scene::Camera, resolution: [u32; 2]) -> Self {
        let [width, height] = resolution.map(|pixels| pixels.max(1) as f32);
        let shorter = width.min(height);
        let [x_min, x_max, y_min, y_max] = description.screen_window.unwrap_or([
            -width / shorter,
            width / shorter,
            -height / shorter,
            height / shorter,
        ]);
        let scale = match description.projection {
            Projection::Perspective { fov } => (0.5 * fov).tan(),
            Projection::Orthographic => 1.0,
        };
        Self {
            projection: description.projection,
            corner: Vec2::new(x_min, y_max) * scale,
            per_pixel: Vec2::new((x_max - x_min) / width, (y_min - y_max) / height) * scale,
            lens_radius: description.lens_radius,
            focal_distance: description.focal_distance,
            camera_to_world: description.camera_to_world,
            world_to_camera: description.camera_to_world.inverse(),
        }
    }

    /// The ray of unit direction through `film`, in pixels from the upper left corner, and a point of the lens chosen
    /// by `lens`, uniform in the unit square.
    #[inline]
    pub(crate) fn ray(&self, film: Vec2, lens: Vec2) -> Ray {
        let projected = self.corner + self.per_pixel * film;
        let (mut origin, mut direction) = match self.projection {
            Projection::Perspective { .. } => (Vec3::ZERO, Vec3::new(projected.x, projected.y, 1.0)),
            Projection::Orthographic => (Vec3::new(projected.x, projected.y, 0.0), Vec3::Z),
        };
        if self.lens_radius > 0.0 {
            // All rays of a film position meet where the chief ray meets the plane of focus.
            let focus = origin + direction * self.focal_distance;
            let offset = warp::concentric_disk(lens) * self.lens_radius;
            origin += Vec3::new(offset.x, offset.y, 0.0);
            direction = focus - origin;
        }
        Ray::new(self.camera_to_world.point(origin), self.camera_to_world.vector(direction).normalize())
    }

    /// Distance of a point in the world from the plane of the camera, along the axis of view.
    #[inline]
    pub(crate) fn depth(&self, p: Vec3) -> f32 {
        self.world_to_camera.point(p).z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CENTER: Vec2 = Vec2::splat(0.5);

    fn close(a: Vec3, b: Vec3) -> bool {
        (a - b).length() < 1e-5
    }

    #[test]
    fn the_field_of_view_spans_the_shorter_axis() {
        let description = sahl_scene::Camera::default();
        for (resolution, top, right) in [([200, 100], 1.0, 2.0), ([100, 200], 2.0, 1.0)] {
            let camera = Camera::new(&description, resolution);
            let ray = camera.ray(Vec2::new(resolution[0] as f32, 0.0), CENTER);
            assert!(close(ray.direction / ray.direction.z, Vec3::new(right, top, 1.0)), "{ray:?}");
            assert!((ray.direction.length() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_screen_window_replaces_the_rule() {
        let description =
            sahl_scene::Camera { screen_window: Some([-0.5, 1.0, 0.25, 0.75]), ..Default::default() };
        let camera = Camera::new(&description, [30, 10]);
        let at = |x, y| camera.ray(Vec2::new(x, y), CENTER).direction;
        assert!(close(at(0.0, 0.0) / at(0.0, 0.0).z, Vec3::new(-0.5, 0.75, 1.0)));
        assert!(close(at(30.0, 10.0) / at(30.0, 10.0).z, Vec3::new(1.0, 0.25, 1.0)));
    }

    #[test]
    fn rays_through_the_lens_meet_in_the_plane_of_focus() {
        let perspective = Projection::Perspective { fov: 1.0 };
        for projection in [perspective, Projection::Orthographic] {
            let description = sahl_scene::Camera {
                projection,
                lens_radius: 0.3,
                focal_distance: 4.0,
                camera_to_world: Transform::translate(1.0, 2.0, 3.0).unwrap(),
                ..Default::default()
            };
            let camera = Camera::new(&description, [64, 64]);
            let film = Vec2::new(12.0, 50.0);
            let meet = |lens| {
                let ray: Ray = camera.ray(film, lens);
                assert!((camera.depth(ray.origin)).abs() < 1e-6);
                ray.at(4.0 / ray.direction.z)
            };
            let focus = meet(CENTER);
            for lens in [Vec2::ZERO, Vec2::new(0.9, 0.2), Vec2::new(0.1, 0.7)] {
                assert!(close(meet(lens), focus));
            }
            assert!((camera.depth(focus) - 4.0).abs() < 1e-5);
        }
    }

    #[test]
    fn an_orthographic_camera_with_a_lens_stays_parallel_on_average() {
        let description = sahl_scene::Camera {
            projection: Projection::Orthographic,
            lens_radius: 0.1,
            focal_distance: 2.0,
            ..Default::default()
        };
        let camera = Camera::new(&description, [10, 10]);
        let ray = camera.ray(Vec2::new(0.0, 10.0), CENTER);
        assert!(close(ray.origin, Vec3::new(-1.0, -1.0, 0.0)) && close(ray.direction, Vec3::Z));
    }
}
