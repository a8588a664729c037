//! Cameras.

use std::sync::Arc;

use sahl_image::Image;
use sahl_math::{AnimatedTransform, Transform};
use serde::{Deserialize, Serialize};

use crate::{Handle, Medium};

/// A camera: +z is forward, +y up and +x right in its space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// How directions become places on the film.
    pub projection: Projection,
    /// Where the camera stands, when the shutter opens if it moves.
    pub camera_to_world: Transform,
    /// Its way while the shutter is open, if it moves.
    pub motion: Option<Box<AnimatedTransform>>,
    /// The part of the projection plane that the film shows: x min, x max, y min, y max. Flat projections alone have one.
    ///
    /// `None`: the shorter axis of the image spans −1 to 1 (pbrt's rule).
    pub screen_window: Option<[f32; 4]>,
    /// Radius of the thin lens of a flat projection, in metres; zero for a pinhole.
    pub lens_radius: f32,
    /// Distance at which the thin lens focuses, in metres.
    pub focal_distance: f32,
    /// When the shutter opens and closes, in seconds.
    pub shutter: [f32; 2],
    /// What the camera stands in; `None` is empty space.
    pub medium: Option<Handle<Medium>>,
}

/// How directions become places on the film.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Projection {
    /// Central projection.
    Perspective {
        /// Full angle of view along the shorter axis of the image, in radians.
        fov: f32,
    },
    /// Parallel projection.
    Orthographic,
    /// All directions around a point.
    Spherical(SphereLayout),
    /// What glass makes of it.
    Realistic(LensSystem),
}

/// How an image shows all directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SphereLayout {
    /// Longitude by latitude: the top row is +y, columns go from +x by +z.
    Equirectangular,
    /// A square in which equal areas are equal solid angles (Clarberg 2008), +y in the middle.
    EqualArea,
}

/// Glass elements between the scene and the film, all round about one axis. Lengths in metres.
///
/// Pixels record the irradiance that the lens casts on the film, so that a smaller aperture makes a darker image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LensSystem {
    /// The surfaces from the scene to the film.
    pub elements: Vec<LensElement>,
    /// Diameter of the opening of the aperture stop.
    pub aperture_diameter: f32,
    /// What the opening looks like.
    pub aperture: Aperture,
    /// Distance from the film at which the lens focuses.
    pub focus_distance: f32,
}

/// A surface of a lens, or the aperture stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LensElement {
    /// Radius of the sphere: positive where the middle is nearest to the scene. Zero for the aperture stop, a plane.
    pub curvature_radius: f32,
    /// Distance along the axis to the next element; that of the last one is found by focusing.
    pub thickness: f32,
    /// Index of refraction behind the surface, towards the film; zero and one for air.
    pub eta: f32,
    /// Diameter of the part that lets light through.
    pub diameter: f32,
}

/// The opening of an aperture stop, in the square about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Aperture {
    /// A disk.
    Round,
    /// A Gaussian that fades to nothing at the rim.
    Gaussian,
    /// A square of half the diameter.
    Square,
    /// A regular pentagon.
    Pentagon,
    /// A star with five points.
    Star,
    /// Transmittance by an image, the mean of its colours. It is scaled to let as much light through as the disk.
    Image(Handle<Arc<Image>>),
}

impl Default for Camera {
    /// pbrt's default: a pinhole with a right angle of view, at the origin.
    fn default() -> Self {
        Self {
            projection: Projection::Perspective { fov: std::f32::consts::FRAC_PI_2 },
            camera_to_world: Transform::IDENTITY,
            motion: None,
            screen_window: None,
            lens_radius: 0.0,
            focal_distance: 1e6,
            shutter: [0.0, 1.0],
            medium: None,
        }
    }
}
