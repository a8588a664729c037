//! A point of a surface, as integrators see it.

use sahl_accel::Hit;
use sahl_math::{Frame, Ray, Vec2, Vec3};

use crate::light::LightSample;

/// A primitive of the accelerator, by its indices there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) geometry: u32,
    pub(crate) primitive: u32,
    pub(crate) instance: u32,
}

/// Where a ray met a surface, and what the surface is like there; in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interaction {
    /// The point.
    pub(crate) p: Vec3,
    /// When it is there: the time of the ray, see [`Ray::time`].
    pub(crate) time: f32,
    /// Absolute error bound of each coordinate.
    pub(crate) p_error: Vec3,
    /// Unit geometric normal on the surface's front.
    pub(crate) ng: Vec3,
    /// The shading normal with tangents. The first tangent follows ∂p/∂u where the material asks for tangents.
    pub(crate) shading: Frame,
    /// Texture coordinates.
    pub(crate) uv: Vec2,
    /// Parameters of the hit on its primitive, as the accelerator gives them.
    pub(crate) parameters: Vec2,
    /// What the point is part of.
    pub(crate) place: Place,
    /// Index of the material.
    pub(crate) material: u32,
    /// Index of the light that the surface is, or [`Interaction::NO_LIGHT`].
    pub(crate) light: u32,
    /// Whether light follows the shading normal even where it leads through the surface, or looks away from the viewer.
    pub(crate) is_leaky: bool,
}

impl Interaction {
    /// What [`Interaction::light`] says of a surface that does not emit.
    pub(crate) const NO_LIGHT: u32 = u32::MAX;

    /// What the accelerator said of it, but for the parameter of the ray, which is zero.
    pub(crate) fn hit(&self) -> Hit {
        let Place { geometry, primitive, instance } = self.place;
        Hit { t: 0.0, u: self.parameters.x, v: self.parameters.y, geometry, primitive, instance }
    }

    /// The ray that leaves along `direction`.
    #[inline]
    pub(crate) fn spawn(&self, direction: Vec3) -> Ray {
        Ray::spawn(self.p, self.p_error, self.ng, direction).with_time(self.time)
    }

    /// The segment to a point with its error and its geometric normal, which are zero where it lies on no surface.
    #[inline]
    pub(crate) fn spawn_to(&self, end: (Vec3, Vec3, Vec3)) -> Ray {
        Ray::spawn_to((self.p, self.p_error, self.ng), end).with_time(self.time)
    }

    /// The ray to what `sample` found of a light.
    #[inline]
    pub(crate) fn ray_to(&self, sample: &LightSample) -> Ray {
        match sample.end {
            Some(end) => self.spawn_to(end),
            None => self.spawn(sample.wi),
        }
    }

    /// Whether the surface lies between the directions `wo` and `wi` by its geometry just as it does by its shading.
    ///
    /// A shading normal can put a direction on the side of the surface where it is not. Light that is reflected into
    /// the surface or refracted out of it is left out: it would leak through walls. Source: Veach, *Robust Monte Carlo
    /// Methods for Light Transport Simulation*, 1997, section 5.3. A leaky surface passes for one that agrees.
    #[inline]
    pub(crate) fn sides_agree(&self, wo: Vec3, wi: Vec3) -> bool {
        let by_geometry = wo.dot(self.ng) * wi.dot(self.ng);
        let by_shading = wo.dot(self.shading.z) * wi.dot(self.shading.z);
        self.is_leaky || by_geometry * by_shading > 0.0
    }

    /// A point at the origin with the given frame, for tests.
    #[cfg(test)]
    pub(crate) fn test(shading: Frame, uv: Vec2) -> Self {
        Self {
            p: Vec3::ZERO,
            time: 0.0,
            p_error: Vec3::ZERO,
            ng: shading.z,
            shading,
            uv,
            parameters: uv,
            place: Place { geometry: 0, primitive: 0, instance: Hit::NO_INSTANCE },
            material: 0,
            light: Self::NO_LIGHT,
            is_leaky: false,
        }
    }
}
