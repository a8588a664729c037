//! What it takes to compute a sample.

use std::ptr;

use sahl_accel::Hit;
use sahl_math::{Ray, Vec3};

use crate::bsdf::{Bsdf, BsdfRoom};
use crate::interaction::Interaction;
use crate::light::Light;
use crate::sampler::Sampler;
use crate::scene::SceneData;
use crate::spectrum::{Spectrum, Wavelengths};

/// The state of a sample on its way: the scene, the sampler, and a count of rays.
pub(crate) struct Tracer<'a> {
    pub(crate) scene: &'a SceneData,
    pub(crate) sampler: Sampler,
    /// Those of the current path, which may drop some on its way.
    pub(crate) wavelengths: Wavelengths,
    /// Rays traced so far, shadow rays included.
    pub(crate) rays: u64,
}

impl<'a> Tracer<'a> {
    pub(crate) fn new(scene: &'a SceneData) -> Self {
        Self { scene, sampler: scene.sampler.clone(), wavelengths: Wavelengths::Rgb, rays: 0 }
    }

    /// Where `ray` first meets a surface that is there, or the border of a medium.
    #[inline]
    pub(crate) fn hit(&mut self, ray: &Ray) -> Option<Hit> {
        self.rays += 1;
        self.scene.first_hit(ray)
    }

    /// The first surface along `ray`, in scenes without borders of media.
    #[inline]
    pub(crate) fn nearest(&mut self, ray: &Ray) -> Option<Interaction> {
        let hit = self.hit(ray)?;
        Some(self.scene.interaction(ray, &hit))
    }

    /// The first surface along `ray`, through borders of media.
    pub(crate) fn nearest_surface(&mut self, ray: &Ray) -> Option<Interaction> {
        let mut ray = *ray;
        loop {
            let hit = self.hit(&ray)?;
            let at = self.scene.interaction(&ray, &hit);
            if !self.scene.is_border(&hit) {
                return Some(at);
            }
            ray = at.spawn(ray.direction);
        }
    }

    /// Whether anything lies along `ray`.
    #[inline]
    pub(crate) fn is_occluded(&mut self, ray: &Ray) -> bool {
        self.rays += 1;
        self.scene.is_occluded(ray)
    }

    /// Whether anything lies on a ray to a point of `light`.
    #[inline]
    pub(crate) fn is_in_shadow(&mut self, ray: &Ray, light: &Light) -> bool {
        self.is_occluded(ray) && !self.ends_at(ray, light)
    }

    /// Whether what blocks a ray to a point of `light` is nothing but the light.
    #[inline(never)]
    pub(crate) fn ends_at(&mut self, ray: &Ray, light: &Light) -> bool {
        light.may_block_itself(ray.direction.length())
            && self.hit(ray).is_some_and(|hit| self.is_target(ray, &hit, light))
    }

    /// Whether `hit`, the first along a ray to a point of `light`, is that point.
    ///
    /// Segments end before their target, but the test of a flat shape that is much longer than wide, or than the segment, may
    /// err by more than that. Nothing of such a shape lies in front of its points, so that it can only be the target.
    pub(crate) fn is_target(&self, ray: &Ray, hit: &Hit, light: &Light) -> bool {
        light.may_block_itself(ray.direction.length())
            && self.scene.light(&self.scene.interaction(ray, hit)).is_some_and(|found| ptr::eq(found, light))
    }

    /// The point of the smooth surface that a mesh stands for, above `at` as it is seen from `wo`; `at` where there is none, and where something
    /// stands between the two.
    #[inline(never)]
    pub(crate) fn lifted(&mut self, at: &Interaction, wo: Vec3) -> Interaction {
        let attributes = &self.scene.attributes[at.place.geometry as usize];
        let Some(lifted) = attributes.lifted(&self.scene.accel, at, wo) else { return *at };
        let end = (lifted.p, Vec3::ZERO, Vec3::ZERO);
        let way = Ray::spawn_to((at.p, at.p_error, at.ng), end).with_time(at.time);
        if self.is_occluded(&way) { *at } else { lifted }
    }

    /// How a surface scatters light, made rougher where `regularize` is set; the path may lose wavelengths there, of which the
    /// integrator has to tell its throughput. `room` is where a BSDF with many parameters is kept.
    #[inline]
    pub(crate) fn bsdf<'r>(&mut self, at: &Interaction, regularize: bool, room: &'r mut BsdfRoom) -> Bsdf<'r>
    where
        'a: 'r,
    {
        self.scene.bsdf(at, &mut self.wavelengths, regularize, room)
    }

    /// Radiance that a surface emits along `wo`.
    #[inline]
    pub(crate) fn emitted(&self, at: &Interaction, wo: Vec3) -> Spectrum {
        self.scene
            .light(at)
            .map_or(Spectrum::ZERO, |light| light.emitted(at, wo, &self.scene.textures, &self.wavelengths))
    }

    /// Radiance that arrives along a ray that left the scene.
    #[inline]
    pub(crate) fn escaped(&self, ray: &Ray) -> Spectrum {
        let mut radiance = Spectrum::ZERO;
        for &light in &self.scene.environments {
            radiance +=
                self.scene.lights[light as usize].escaped(ray.origin, ray.direction, &self.wavelengths);
        }
        radiance
    }
}
