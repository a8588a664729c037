//! Cameras.

use sahl_math::Transform;
use serde::{Deserialize, Serialize};

use crate::{Handle, Medium};

/// A camera: +z is forward, +y up and +x right in its space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// How directions become places on the film.
    pub projection: Projection,
    /// Where the camera stands.
    pub camera_to_world: Transform,
    /// The part of the projection plane that the film shows: x min, x max, y min, y max.
    ///
    /// `None`: the shorter axis of the image spans −1 to 1 (pbrt's rule).
    pub screen_window: Option<[f32; 4]>,
    /// Radius of the lens in metres; zero for a pinhole.
    pub lens_radius: f32,
    /// Distance at which the thin lens focuses, in metres.
    pub focal_distance: f32,
    /// When the shutter opens and closes, in seconds.
    pub shutter: [f32; 2],
    /// What the camera stands in; `None` is empty space.
    pub medium: Option<Handle<Medium>>,
}

/// How directions become places on the film.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Projection {
    /// Central projection.
    Perspective {
        /// Full angle of view along the shorter axis of the image, in radians.
        fov: f32,
    },
    /// Parallel projection.
    Orthographic,
}

impl Default for Camera {
    /// pbrt's default: a pinhole with a right angle of view, at the origin.
    fn default() -> Self {
        Self {
            projection: Projection::Perspective { fov: std::f32::consts::FRAC_PI_2 },
            camera_to_world: Transform::IDENTITY,
            screen_window: None,
            lens_radius: 0.0,
            focal_distance: 1e6,
            shutter: [0.0, 1.0],
            medium: None,
        }
    }
}
