//! Cameras with a lens of glass.
//!
//! A pixel records the irradiance on its place of the film, E = ∫ L cos⁴θ / Z² dA over the exit pupil, Z being the distance of the hindmost
//! element and dA its area in that plane. Points of the pupil are drawn uniformly from a box about it.
//!
//! Source: Kolb, Mitchell, Hanrahan, *A Realistic Camera Model for Computer Graphics*, SIGGRAPH 1995, section 3; pbrt-v4, whose lens files,
//! film and weights these are.
//!
//! Deliberately absent: dispersion in the glass, whose indices files give for one wavelength, reflections between elements, and diffraction.
//!
//! In a scene file: `Camera "realistic" "string lensfile" "dgauss.50mm.dat" "float aperturediameter" 12 "float focusdistance" 6.9`.

use glam::DVec3;
use sahl_math::{Vec2, Vec3};
use sahl_scene::{Aperture, LensSystem, SceneDesc};

use super::CameraRay;
use super::aperture::Mask;
use super::lens::{Stack, Way};
use super::pupil::Pupils;

/// A lens before a film.
#[derive(Clone, Debug)]
pub(super) struct Realistic {
    stack: Stack,
    pupils: Pupils,
    /// The place of the upper left corner of the image on the film, which stands upside down, and its change a pixel.
    corner: [f64; 2],
    per_pixel: [f64; 2],
}

impl Realistic {
    /// The lens `system` before the film of `scene`.
    ///
    /// # Errors
    /// A message if the lens makes no image.
    pub(super) fn new(system: &LensSystem, scene: &SceneDesc) -> Result<Self, String> {
        let stack = Stack::new(system, mask(system, scene)?)?;
        let [width, height] = scene.film.resolution.map(|pixels| f64::from(pixels.max(1)));
        let diagonal = f64::from(scene.film.diagonal);
        let per_pixel = diagonal / width.hypot(height);
        let pupils = Pupils::new(&stack, 0.5 * diagonal);
        if pupils.at(0.0).is_none() {
            return Err("the lens lets no light through to the middle of the film".to_owned());
        }
        Ok(Self {
            stack,
            pupils,
            corner: [0.5 * width * per_pixel, -0.5 * height * per_pixel],
            per_pixel: [-per_pixel, per_pixel],
        })
    }

    /// The ray in camera space from the foremost element, with the weight cos⁴θ / (Z² pdf) and what the stop lets through.
    pub(super) fn ray(&self, film: Vec2, lens: Vec2) -> CameraRay {
        let [x, y] = [film.x, film.y].map(f64::from);
        let film =
            DVec3::new(self.corner[0] + x * self.per_pixel[0], self.corner[1] + y * self.per_pixel[1], 0.0);
        self.through(film, lens).unwrap_or(CameraRay::BLOCKED)
    }

    fn through(&self, film: DVec3, lens: Vec2) -> Option<CameraRay> {
        let radius = film.x.hypot(film.y);
        let pupil = self.pupils.at(radius)?;
        let along = pupil.x[0] + f64::from(lens.x) * (pupil.x[1] - pupil.x[0]);
        let across = (2.0 * f64::from(lens.y) - 1.0) * pupil.y;
        // The box lies as if the film point were on the x axis.
        let (sin, cos) = if radius > 0.0 { (film.y / radius, film.x / radius) } else { (0.0, 1.0) };
        let rear_z = self.stack.rear_z();
        let rear = DVec3::new(cos * along - sin * across, sin * along + cos * across, rear_z);
        let direction = rear - film;
        let (way, transmittance) = self.stack.trace(Way { origin: film, direction })?;
        let cos2 = direction.z * direction.z / direction.length_squared();
        let weight = f64::from(transmittance) * cos2 * cos2 * pupil.area() / (rear_z * rear_z);
        Some(CameraRay::new(to_f32(way.origin), to_f32(way.direction), weight as f32))
    }
}

fn to_f32(v: DVec3) -> Vec3 {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

/// The opening of the stop; `None` for the disk.
fn mask(system: &LensSystem, scene: &SceneDesc) -> Result<Option<Mask>, String> {
    let mask = match system.aperture {
        Aperture::Round => return Ok(None),
        Aperture::Gaussian => Mask::gaussian(),
        Aperture::Square => Mask::square(),
        Aperture::Pentagon => Mask::pentagon(),
        Aperture::Star => Mask::star(),
        Aperture::Image(handle) => scene.images.get(handle).and_then(|image| Mask::of_image(image)),
    };
    mask.map(Some).ok_or_else(|| "the image of the aperture lets no light through".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::lens::tests::simple;
    use sahl_testkit::random::Rng;

    fn scene(resolution: [u32; 2], diagonal: f32) -> SceneDesc {
        let mut scene = SceneDesc::default();
        scene.film.resolution = resolution;
        scene.film.diagonal = diagonal;
        scene
    }

    fn camera(aperture_diameter: f32) -> Realistic {
        Realistic::new(&simple(aperture_diameter, 2.0), &scene([64, 48], 0.035)).unwrap()
    }

    /// ∫ cos⁴θ / Z² dA by a grid over the plane of the hindmost element, without boxes.
    fn irradiance(camera: &Realistic, film: DVec3) -> f64 {
        let (z, reach, n) = (camera.stack.rear_z(), 1.5 * camera.stack.rear_radius(), 800);
        let step = 2.0 * reach / f64::from(n);
        let mut sum = 0.0;
        for i in 0..n * n {
            let at = |i: i32| (f64::from(i) + 0.5) * step - reach;
            let direction = DVec3::new(at(i % n), at(i / n), z) - film;
            if let Some((_, transmittance)) = camera.stack.trace(Way { origin: film, direction }) {
                sum += f64::from(transmittance) * (z * z / direction.length_squared()).powi(2);
            }
        }
        sum * step * step / (z * z)
    }

    #[test]
    fn weights_sum_to_the_irradiance_under_a_uniform_sky() {
        let mut shaped = simple(0.012, 2.0);
        shaped.aperture = Aperture::Star;
        for camera in [camera(0.012), camera(0.02), Realistic::new(&shaped, &scene([64, 48], 0.035)).unwrap()]
        {
            let mut rng = Rng::new(3);
            for film in [[32.0, 24.0], [20.0, 10.0], [50.0, 44.0], [0.5, 0.5]] {
                let n = 60_000;
                let place = Vec2::new(film[0], film[1]);
                let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
                for _ in 0..n {
                    let u = Vec2::from(rng.uniform::<2>());
                    let weight = f64::from(camera.ray(place, u).weight);
                    sum += weight;
                    squares += weight * weight;
                }
                let mean = sum / f64::from(n);
                let error = ((squares / f64::from(n) - mean * mean) / f64::from(n)).sqrt();
                let at = DVec3::new(
                    camera.corner[0] + f64::from(film[0]) * camera.per_pixel[0],
                    camera.corner[1] + f64::from(film[1]) * camera.per_pixel[1],
                    0.0,
                );
                let expected = irradiance(&camera, at);
                assert!(
                    (mean - expected).abs() <= 4.0 * error + 4e-3 * expected,
                    "{film:?}: {mean} {expected}"
                );
            }
        }
    }

    #[test]
    fn a_small_stop_gives_the_irradiance_of_its_solid_angle() {
        // The image of a stop behind all glass is the stop itself: π r² / Z² on the axis.
        let camera = camera(0.001);
        let z = camera.stack.rear_z();
        let expected = std::f64::consts::PI * 0.0005_f64.powi(2) / (z * z);
        assert!((irradiance(&camera, DVec3::ZERO) / expected - 1.0).abs() < 0.02);
        let pupil = camera.pupils.at(0.0).unwrap();
        assert!(pupil.y > 0.0005 && pupil.y < 0.0006, "{pupil:?}");
    }

    #[test]
    fn boxes_hold_all_that_gets_through() {
        let mut rng = Rng::new(7);
        for camera in [camera(0.001), camera(0.02)] {
            let reach = 1.5 * camera.stack.rear_radius();
            for _ in 0..200_000 {
                let radius = 0.0175 * rng.next_f64();
                let x = (2.0 * rng.next_f64() - 1.0) * reach;
                let y = (2.0 * rng.next_f64() - 1.0) * reach;
                let film = DVec3::new(radius, 0.0, 0.0);
                let direction = DVec3::new(x, y, camera.stack.rear_z()) - film;
                if camera.stack.trace(Way { origin: film, direction }).is_some() {
                    let pupil = camera.pupils.at(radius).expect("light gets through");
                    assert!(pupil.x[0] <= x && x <= pupil.x[1] && y.abs() <= pupil.y, "{radius} {x} {y}");
                }
            }
        }
    }

    #[test]
    fn the_picture_stands_upright() {
        let camera = camera(0.01);
        let direction = |x, y| camera.ray(Vec2::new(x, y), Vec2::splat(0.5)).ray.direction;
        let (left, right) = (direction(10.0, 24.0), direction(54.0, 24.0));
        assert!(left.x < 0.0 && right.x > 0.0 && left.z > 0.0);
        let (top, bottom) = (direction(32.0, 4.0), direction(32.0, 44.0));
        assert!(top.y > 0.0 && bottom.y < 0.0);
    }

    #[test]
    fn what_the_stop_hides_is_blocked() {
        let camera = camera(0.012);
        assert_eq!(camera.ray(Vec2::new(32.0, 24.0), Vec2::ZERO), CameraRay::BLOCKED);
        assert!(camera.ray(Vec2::new(32.0, 24.0), Vec2::splat(0.5)).weight > 0.0);
    }
}
