//! Cameras: from a place on the film to a ray in the world.
//!
//! Design decision: a film position is in pixels, (0, 0) being the upper left corner of the image, so that a pixel
//! filter adds its offset without knowing the camera. A camera makes a ray in its own space and says what light along it
//! counts; one placement moves all kinds into the world.
//!
//! Deliberately absent: importance, which only light tracing needs.
//!
//! In a scene file: `Camera "perspective" "float fov" 40 "float lensradius" .02 "float focaldistance" 3`.

mod aperture;
mod differentials;
mod lens;
mod projective;
mod pupil;
mod realistic;
mod spherical;

use sahl_math::{AnimatedTransform, Ray, Transform, Vec2, Vec3};
use sahl_scene::{Diagnostic, Diagnostics, Projection, SceneDesc};

use crate::texture::Footprint;
use differentials::Differentials;
use projective::Projective;
use realistic::Realistic;
use spherical::Spherical;

/// A camera, ready to make rays.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    kind: Kind,
    /// How little rays change from pixel to pixel.
    differentials: Differentials,
    /// Where it is when the shutter opens.
    camera_to_world: Transform,
    world_to_camera: Transform,
    motion: Option<Box<AnimatedTransform>>,
}

/// How rays leave the film.
#[derive(Clone, Debug)]
enum Kind {
    Projective(Projective),
    Spherical(Spherical),
    Realistic(Box<Realistic>),
}

/// A ray, and what light along it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CameraRay {
    /// The ray; with unit direction in the world.
    pub(crate) ray: Ray,
    /// Factor on radiance: one, but for lenses of glass; zero where the lens lets no light through.
    pub(crate) weight: f32,
}

impl CameraRay {
    /// A way that the lens does not let through: an empty ray.
    const BLOCKED: Self = Self { ray: Ray::new(Vec3::ZERO, Vec3::Z).with_t_max(0.0), weight: 0.0 };

    #[inline]
    fn new(origin: Vec3, direction: Vec3, weight: f32) -> Self {
        Self { ray: Ray::new(origin, direction), weight }
    }

    /// The ray in the world of a camera that is placed by `to_world` at `time`.
    #[inline]
    fn placed(self, to_world: &Transform, time: f32) -> Self {
        let origin = to_world.point(self.ray.origin);
        let direction = to_world.vector(self.ray.direction).normalize();
        Self { ray: Ray { origin, direction, time, ..self.ray }, ..self }
    }
}

impl Camera {
    /// The camera of a scene; `None` and an error if its lens makes no image.
    pub(crate) fn new(scene: &SceneDesc, diagnostics: &mut Diagnostics) -> Option<Self> {
        let camera = &scene.camera;
        let resolution = scene.film.resolution;
        let kind = match &camera.projection {
            flat @ (Projection::Perspective { .. } | Projection::Orthographic) => {
                Kind::Projective(Projective::new(camera, projective::field_of_view(flat), resolution))
            }
            Projection::Spherical(layout) => Kind::Spherical(Spherical::new(*layout, resolution)),
            Projection::Realistic(system) => match Realistic::new(system, scene) {
                Ok(lens) => Kind::Realistic(Box::new(lens)),
                Err(message) => {
                    diagnostics.push(Diagnostic::error("bad-lens", None, message));
                    return None;
                }
            },
        };
        let mut camera = Self {
            kind,
            differentials: Differentials::default(),
            camera_to_world: camera.camera_to_world,
            world_to_camera: camera.camera_to_world.inverse(),
            motion: camera.motion.clone(),
        };
        camera.differentials =
            Differentials::least(resolution, |film| camera.local_ray(film, Vec2::splat(0.5)));
        Some(camera)
    }

    /// The ray in camera space.
    #[inline]
    fn local_ray(&self, film: Vec2, lens: Vec2) -> CameraRay {
        match &self.kind {
            Kind::Projective(projective) => projective.ray(film, lens),
            Kind::Spherical(spherical) => spherical.ray(film),
            Kind::Realistic(realistic) => realistic.ray(film, lens),
        }
    }

    /// The ray through `film`, in pixels from the upper left corner, and a point of the lens chosen by `lens`, uniform in
    /// the unit square, at `time`, a fraction of the time that the shutter is open.
    #[inline]
    pub(crate) fn ray(&self, film: Vec2, lens: Vec2, time: f32) -> CameraRay {
        let local = self.local_ray(film, lens);
        match &self.motion {
            None => local.placed(&self.camera_to_world, time),
            Some(motion) => local.placed(&motion.at(time), time),
        }
    }

    /// Whether it moves while the shutter is open.
    pub(crate) fn moves(&self) -> bool {
        self.motion.is_some()
    }

    /// Distance of a point in the world from the plane of the camera at `time`, along the axis of view; from the camera itself if
    /// that looks in all directions.
    #[inline]
    pub(crate) fn depth(&self, p: Vec3, time: f32) -> f32 {
        let p = match &self.motion {
            None => self.world_to_camera.point(p),
            Some(motion) => motion.at(time).inverse().point(p),
        };
        match self.kind {
            Kind::Spherical(_) => p.length(),
            Kind::Projective(_) | Kind::Realistic(_) => p.z,
        }
    }

    /// What a pixel covers of the plane through `p` with normal `n` at `time`, if the pixels that see it are as fine as the finest of
    /// the image; without the change of surface coordinates. In the world.
    ///
    /// Points that the camera sees by a mirror are treated as if it saw them directly. In the picture of a perspective that is
    /// exact; elsewhere the smallest pixel stands for all. Source: Pharr, Jakob, Humphreys,
    /// *Physically Based Rendering*, 4th ed., 2023, section 10.1.2.
    pub(crate) fn footprint(&self, p: Vec3, n: Vec3, time: f32) -> Footprint {
        match &self.motion {
            None => self.footprint_from((&self.camera_to_world, &self.world_to_camera), p, n),
            Some(motion) => {
                let to_world = motion.at(time);
                self.footprint_from((&to_world, &to_world.inverse()), p, n)
            }
        }
    }

    #[inline]
    fn footprint_from(&self, (to_world, to_camera): (&Transform, &Transform), p: Vec3, n: Vec3) -> Footprint {
        let (p, n) = (to_camera.point(p), to_camera.normal(n));
        let exact = match &self.kind {
            Kind::Projective(projective) => projective.footprint(p, n),
            Kind::Spherical(_) | Kind::Realistic(_) => None,
        };
        let [dx, dy] = exact.unwrap_or_else(|| self.differentials.at(p, n));
        Footprint { dp_dx: to_world.vector(dx), dp_dy: to_world.vector(dy), ..Footprint::default() }
    }
}

#[cfg(test)]
mod tests;
