//! Lights, and the choice of one among many.
//!
//! Design decision: a light says three things: a way to be sampled from a point, the density of that way for a
//! direction that was found otherwise, and its power, by which the choice among lights is made. Surfaces that emit are
//! lights too, one for each primitive. Radiance is that of the linear working space, all factors included.
//!
//! Deliberately absent: visibility (integrators trace the shadow ray) and emission of photons.

mod area;
mod environment;
mod goniometric;
mod infinite;
mod kinds;
mod portal;
mod projection;
mod projector;
mod select;
mod tree;

use sahl_math::{Vec2, Vec3};

use crate::interaction::Interaction;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::texture::Textures;

pub(crate) use area::{AreaLight, EmissionTexture, Presence};
pub(crate) use environment::{ImageEnvironment, Sampled, is_rigid};
pub(crate) use goniometric::GoniometricLight;
use infinite::Strength;
pub(crate) use kinds::{DistantLight, Emission, PointLight, SpotLight};
pub(crate) use portal::{Portal, PortalEnvironment, Sky};
pub(crate) use projection::SphereMap;
pub(crate) use projector::ProjectionLight;
pub(crate) use select::{LightSelection, Vantage};
pub(crate) use tree::Cone;
use tree::LightBounds;

/// A source of light.
#[derive(Clone, Debug)]
pub(crate) enum Light {
    /// A point that shines alike in all directions.
    Point(PointLight),
    /// A point that shines into a cone.
    Spot(SpotLight),
    /// A point that shines by a table of directions.
    Goniometric(Box<GoniometricLight>),
    /// A point that throws a picture.
    Projection(Box<ProjectionLight>),
    /// Parallel light.
    Distant(DistantLight),
    /// A primitive that emits.
    Area(AreaLight),
    /// The same radiance from all directions.
    Uniform(Emission),
    /// Radiance by direction.
    Image(Box<ImageEnvironment>),
    /// Either of these, through a window.
    Portal(Box<PortalEnvironment>),
}

/// Light that arrives at a point, if nothing is in the way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSample {
    /// Radiance; for lights without extent irradiance on a surface that faces the light, the density being one.
    pub(crate) radiance: Spectrum,
    /// Unit direction toward the light.
    pub(crate) wi: Vec3,
    /// Density of `wi` per steradian; one for lights without extent.
    pub(crate) pdf: f32,
    /// Whether no other way than sampling the light can find it.
    pub(crate) is_delta: bool,
    /// Where the shadow ray ends: point, error, normal; `None` for infinitely far away.
    pub(crate) end: Option<(Vec3, Vec3, Vec3)>,
}

/// By what a light is chosen.
enum ChosenBy {
    /// Where it is, where it shines, and how strongly.
    Place(LightBounds),
    /// What arrives from infinitely far away.
    Strength(Strength),
}

impl Light {
    /// Light that arrives at `from`; `None` where none can.
    #[inline]
    pub(crate) fn sample(
        &self,
        from: Vec3,
        u: Vec2,
        textures: &Textures,
        wavelengths: &Wavelengths,
    ) -> Option<LightSample> {
        match self {
            Self::Point(light) => light.sample(from, wavelengths),
            Self::Spot(light) => light.sample(from, wavelengths),
            Self::Goniometric(light) => light.sample(from, wavelengths),
            Self::Projection(light) => light.sample(from, wavelengths),
            Self::Distant(light) => Some(light.sample(wavelengths)),
            Self::Area(light) => light.sample(from, u, textures, wavelengths),
            Self::Uniform(radiance) => {
                let (wi, pdf) = (crate::warp::uniform_sphere(u), crate::warp::UNIFORM_SPHERE_PDF);
                let radiance = radiance.at(wavelengths);
                Some(LightSample { radiance, wi, pdf, is_delta: false, end: None })
            }
            Self::Image(light) => light.sample(u, wavelengths),
            Self::Portal(light) => light.sample(from, u, wavelengths),
        }
    }

    /// Radiance that arrives at `from` along `direction`, a unit vector toward the sky, from a light that is infinitely far
    /// away; zero for other lights.
    #[inline]
    pub(crate) fn escaped(&self, from: Vec3, direction: Vec3, wavelengths: &Wavelengths) -> Spectrum {
        match self {
            Self::Uniform(radiance) => radiance.at(wavelengths),
            Self::Image(light) => light.radiance(direction, wavelengths),
            Self::Portal(light) => light.radiance(from, direction, wavelengths),
            Self::Point(_)
            | Self::Spot(_)
            | Self::Goniometric(_)
            | Self::Projection(_)
            | Self::Distant(_)
            | Self::Area(_) => Spectrum::ZERO,
        }
    }

    /// Density per steradian with which [`Light::sample`] finds `direction` from `from`; zero for lights that are not infinitely
    /// far away and for those without extent.
    #[inline]
    pub(crate) fn escaped_pdf(&self, from: Vec3, direction: Vec3) -> f32 {
        match self {
            Self::Uniform(_) => crate::warp::UNIFORM_SPHERE_PDF,
            Self::Image(light) => light.pdf(direction),
            Self::Portal(light) => light.pdf(from, direction),
            Self::Point(_)
            | Self::Spot(_)
            | Self::Goniometric(_)
            | Self::Projection(_)
            | Self::Distant(_)
            | Self::Area(_) => 0.0,
        }
    }

    /// Radiance that a surface which is this light sends along `wo`.
    #[inline]
    pub(crate) fn emitted(
        &self,
        at: &Interaction,
        wo: Vec3,
        textures: &Textures,
        wavelengths: &Wavelengths,
    ) -> Spectrum {
        match self {
            Self::Area(light) => light.emitted(at, wo, textures, wavelengths),
            _ => Spectrum::ZERO,
        }
    }

    /// Density per steradian with which [`Light::sample`] finds the point `at` of this light from `from`.
    #[inline]
    pub(crate) fn pdf(&self, from: Vec3, at: &Interaction) -> f32 {
        match self {
            Self::Area(light) => light.pdf(from, at),
            _ => 0.0,
        }
    }

    /// Whether the light may be found in the way to one of its own points from that far away: it is flat, and rounding is
    /// all that puts it there.
    #[inline]
    pub(crate) fn may_block_itself(&self, distance: f32) -> bool {
        matches!(self, Self::Area(light) if light.may_block_itself(distance))
    }

    /// Flux in watts, by lane, into a scene within a sphere of radius `scene_radius`.
    pub(crate) fn power(&self, scene_radius: f32, wavelengths: &Wavelengths) -> Spectrum {
        use std::f32::consts::PI;
        let cross_section = PI * scene_radius * scene_radius;
        match self {
            Self::Point(light) => light.power(wavelengths),
            Self::Spot(light) => light.power(wavelengths),
            Self::Goniometric(light) => light.power(wavelengths),
            Self::Projection(light) => light.power(wavelengths),
            Self::Distant(light) => light.irradiance.at(wavelengths) * cross_section,
            Self::Area(light) => light.power(wavelengths),
            Self::Uniform(radiance) => radiance.at(wavelengths) * (4.0 * PI * cross_section),
            Self::Image(light) => light.mean(wavelengths) * (4.0 * PI * cross_section),
            Self::Portal(light) => light.power(wavelengths),
        }
    }

    /// By what it is chosen. A portal is where its window is; other skies are infinitely far away.
    fn chosen_by(&self) -> ChosenBy {
        use std::f32::consts::PI;
        match self {
            Self::Point(light) => ChosenBy::Place(LightBounds::point(light.position, light.intensity.mean())),
            Self::Spot(light) => ChosenBy::Place(light.bounds()),
            Self::Goniometric(light) => ChosenBy::Place(light.bounds()),
            Self::Projection(light) => ChosenBy::Place(light.bounds()),
            Self::Area(light) => ChosenBy::Place(light.bounds()),
            Self::Portal(light) => ChosenBy::Place(light.bounds()),
            Self::Distant(light) => {
                ChosenBy::Strength(Strength::Parallel(light.irradiance.mean(), -light.direction))
            }
            Self::Uniform(radiance) => ChosenBy::Strength(Strength::AllRound(4.0 * PI * radiance.mean())),
            Self::Image(light) => ChosenBy::Strength(Strength::AllRound(light.sampled_fluence())),
        }
    }

    /// Where the light is, where it shines, and how strongly; `None` for lights that are infinitely far away.
    fn bounds(&self) -> Option<LightBounds> {
        match self.chosen_by() {
            ChosenBy::Place(bounds) => Some(bounds),
            ChosenBy::Strength(_) => None,
        }
    }

    /// Whether the light is infinitely far away in many directions, so that rays that leave the scene find it.
    pub(crate) fn is_environment(&self) -> bool {
        matches!(self, Self::Uniform(_) | Self::Image(_) | Self::Portal(_))
    }
}

#[cfg(test)]
mod tests;
