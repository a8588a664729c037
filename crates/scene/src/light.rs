//! Lights.

use std::sync::Arc;

use sahl_image::Image;
use sahl_math::{Transform, Vec3};
use serde::{Deserialize, Serialize};

use crate::{Handle, Spectrum, SpectrumParam};

/// A light that is not a shape. Positions and directions are in the world.
///
/// Spectra of emission are normalised to luminance one unless they are RGB, as in pbrt-v4; `scale` comes on top, and a
/// given `power` (in watts of luminous flux over 683 lm/W, so lumens in pbrt's photometric units) or `illuminance`
/// (in lux) replaces the magnitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Light {
    /// Shines from a point, alike in all directions.
    Point {
        /// Radiant intensity.
        intensity: Spectrum,
        /// Factor on the intensity.
        scale: f32,
        /// Total flux instead of the intensity's magnitude.
        power: Option<f32>,
        /// Where it stands.
        position: Vec3,
    },
    /// Shines from a point into a cone.
    Spot {
        /// Radiant intensity along the axis.
        intensity: Spectrum,
        /// Factor on the intensity.
        scale: f32,
        /// Total flux instead of the intensity's magnitude.
        power: Option<f32>,
        /// Where it stands.
        position: Vec3,
        /// Axis of the cone; a unit vector.
        direction: Vec3,
        /// Half angle of the cone, in radians.
        angle: f32,
        /// Width of the soft border, inside the cone, in radians.
        penumbra: f32,
    },
    /// Shines from a point by a table of factors over directions: a measured lamp.
    Goniometric {
        /// Radiant intensity where the table says one.
        intensity: Spectrum,
        /// Factor on the intensity.
        scale: f32,
        /// Total flux instead of the intensity's magnitude.
        power: Option<f32>,
        /// The table, the mean of whose colours counts: a square equal-area octahedral image, z up (Clarberg 2008).
        image: Handle<Arc<Image>>,
        /// From the space in which the image is laid out, whose origin is the light, to the world.
        light_to_world: Transform,
    },
    /// Throws a picture from a point: along +z, its top toward +y, its left toward −x.
    Projection {
        /// Radiant intensity by direction.
        image: Handle<Arc<Image>>,
        /// Factor on the intensity.
        scale: f32,
        /// Total flux instead of the magnitude.
        power: Option<f32>,
        /// Angle that the shorter side of the picture fills, in radians.
        fov: f32,
        /// From the light's space, whose origin is the light, to the world.
        light_to_world: Transform,
    },
    /// Parallel light from infinitely far away.
    Distant {
        /// Irradiance on a surface that faces the light.
        radiance: Spectrum,
        /// Factor on the irradiance.
        scale: f32,
        /// Illuminance instead of the magnitude.
        illuminance: Option<f32>,
        /// Where the light goes; a unit vector.
        direction: Vec3,
    },
    /// Light from all directions.
    Infinite {
        /// Radiance by direction.
        radiance: Radiance,
        /// Factor on the radiance.
        scale: f32,
        /// Illuminance on an upward surface instead of the magnitude.
        illuminance: Option<f32>,
        /// From the space in which the image is laid out to the world.
        light_to_world: Transform,
        /// A rectangle in the world through which alone the light comes: its corners in order round it, such that
        /// (p₃ − p₀) × (p₁ − p₀) points out of the room.
        portal: Option<[Vec3; 4]>,
    },
}

/// Radiance of an infinite light by direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Radiance {
    /// The same from everywhere.
    Constant(Spectrum),
    /// A square equal-area octahedral image, z up (Clarberg 2008; pbrt-v4's layout).
    EqualArea(Handle<Arc<Image>>),
    /// A latitude-longitude image: top row +y, u = 0.5 looks along −z, u grows with rightward turns (glTF viewers' and
    /// HDRI makers' layout).
    LatLong(Handle<Arc<Image>>),
}

/// Emission of a shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AreaLight {
    /// Emitted radiance, the same in all directions; a texture may vary it over the surface.
    pub radiance: SpectrumParam,
    /// Factor on the radiance.
    pub scale: f32,
    /// Whether both sides emit; otherwise the side of the surface normal does.
    pub two_sided: bool,
    /// Total flux instead of the radiance's magnitude.
    pub power: Option<f32>,
}
