//! Glass: rays through the elements of a lens, and where it focuses.
//!
//! Coordinates are those of the camera: the film lies in the plane z = 0, the axis is z, the scene at large z. Lengths in metres.
//!
//! Source: Kolb, Mitchell, Hanrahan, *A Realistic Camera Model for Computer Graphics*, SIGGRAPH 1995; Hecht, *Optics*, 5th ed., 2017,
//! section 6.2.1 for matrices of thick lenses. Deviation from pbrt-v4: the planes of the thick lens come from the matrix of the whole
//! lens, which is exact for rays near the axis, not from one ray traced a little off it.

use glam::DVec3;
use sahl_math::solve_quadratic;
use sahl_scene::{LensElement, LensSystem};

use super::aperture::Mask;

/// A way of light in camera space; the direction has any length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Way {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
}

/// The elements of a lens at their places.
#[derive(Clone, Debug)]
pub(super) struct Stack {
    /// From the film to the scene.
    elements: Box<[Element]>,
    mask: Option<Mask>,
}

/// A surface between two media, or the stop.
#[derive(Clone, Copy, Debug)]
struct Element {
    /// Where it crosses the axis.
    z: f64,
    /// As the scene describes it: positive if its centre is nearer to the film. Zero for the stop.
    curvature_radius: f64,
    aperture_radius: f64,
    /// Index of refraction on the side of the film, and of the scene.
    eta: [f64; 2],
}

/// The thick lens that acts on rays near the axis like a stack: distances along the axis, away from the scene.
#[derive(Clone, Copy, Debug)]
struct ThickLens {
    focal_length: f64,
    /// From the foremost element to the principal plane of the scene, and from the hindmost to that of the film.
    principal: [f64; 2],
    /// From the foremost element to the hindmost.
    length: f64,
}

/// A medium that files leave open is air.
fn index(eta: f32) -> f64 {
    if eta == 0.0 { 1.0 } else { f64::from(eta) }
}

impl Stack {
    /// The elements of `system`, moved along the axis to focus at its distance.
    ///
    /// # Errors
    /// A message if they form no image there.
    pub(super) fn new(system: &LensSystem, mask: Option<Mask>) -> Result<Self, String> {
        let thick = ThickLens::new(&system.elements)?;
        let mut z = thick.distance_to_film(f64::from(system.focus_distance))?;
        let mut elements = Vec::with_capacity(system.elements.len());
        for (i, element) in system.elements.iter().enumerate().rev() {
            if i + 1 < system.elements.len() {
                z += f64::from(element.thickness);
            }
            let is_stop = element.curvature_radius == 0.0;
            let diameter =
                if is_stop { element.diameter.min(system.aperture_diameter) } else { element.diameter };
            let before = i.checked_sub(1).map_or(1.0, |before| index(system.elements[before].eta));
            elements.push(Element {
                z,
                curvature_radius: f64::from(element.curvature_radius),
                aperture_radius: 0.5 * f64::from(diameter),
                eta: [index(element.eta), before],
            });
        }
        Ok(Self { elements: elements.into(), mask })
    }

    /// Where the hindmost element crosses the axis.
    pub(super) fn rear_z(&self) -> f64 {
        self.elements.first().map_or(0.0, |element| element.z)
    }

    /// The radius of the hindmost element.
    pub(super) fn rear_radius(&self) -> f64 {
        self.elements.first().map_or(0.0, |element| element.aperture_radius)
    }

    /// The way into the scene of light that comes from the film, and the share that the stop lets through; `None` if an
    /// element stops it.
    pub(super) fn trace(&self, way: Way) -> Option<(Way, f32)> {
        self.follow(way, |x, y| match &self.mask {
            Some(mask) => mask.at(x, y),
            None => f32::from(x * x + y * y <= 1.0),
        })
    }

    /// Whether an element other than the stop stops light from the film, or the stop does whichever way its shape is turned.
    pub(super) fn may_pass(&self, way: Way) -> bool {
        let reach = self.mask.as_ref().map_or(1.0, Mask::reach);
        self.follow(way, |x, y| f32::from(x * x + y * y <= reach * reach)).is_some()
    }

    /// Follows light from the film through all elements. `stop` gives the share that gets through a place of the stop, in units
    /// of its radius.
    fn follow(&self, way: Way, stop: impl Fn(f64, f64) -> f32) -> Option<(Way, f32)> {
        let mut way = way;
        let mut transmittance = 1.0;
        for element in &self.elements {
            let (p, normal) = element.meet(&way)?;
            let radius = element.aperture_radius;
            if element.curvature_radius == 0.0 {
                transmittance *= stop(p.x / radius, p.y / radius);
                if transmittance == 0.0 {
                    return None;
                }
                way.origin = p;
                continue;
            }
            if p.x * p.x + p.y * p.y > radius * radius {
                return None;
            }
            let [film, scene] = element.eta;
            way = Way { origin: p, direction: refract(way.direction.normalize(), normal, film / scene)? };
        }
        Some((way, transmittance))
    }
}

impl Element {
    /// Where light that goes to the scene meets the element, and the normal there, against the light; `None` if it passes beside
    /// the sphere.
    fn meet(&self, way: &Way) -> Option<(DVec3, DVec3)> {
        let radius = self.curvature_radius;
        if radius == 0.0 {
            let t = (self.z - way.origin.z) / way.direction.z;
            return (t >= 0.0).then(|| (way.origin + way.direction * t, DVec3::NEG_Z));
        }
        // A sphere with its centre on the side of the film is left behind, one with its centre beyond is entered.
        let center = DVec3::new(0.0, 0.0, self.z - radius);
        let from_center = way.origin - center;
        let a = way.direction.length_squared();
        let b = 2.0 * way.direction.dot(from_center);
        let (near, far) = solve_quadratic(a, b, from_center.length_squared() - radius * radius)?;
        let t = if radius < 0.0 { near } else { far };
        let n = from_center + way.direction * t;
        let n = if n.dot(way.direction) > 0.0 { -n } else { n };
        (t >= 0.0).then(|| (way.origin + way.direction * t, n.normalize()))
    }
}

/// The direction behind a surface of the unit vector `d` that meets it against the normal `n`, `eta` being the index before over
/// that behind (Snell); `None` under total reflection.
fn refract(d: DVec3, n: DVec3, eta: f64) -> Option<DVec3> {
    let cos = -d.dot(n);
    let sin2_behind = eta * eta * (1.0 - cos * cos).max(0.0);
    (sin2_behind < 1.0).then(|| d * eta + n * (eta * cos - (1.0 - sin2_behind).sqrt()))
}

impl ThickLens {
    /// By the product of the matrices of all elements, which act on (height, index × slope) of rays from the scene.
    fn new(elements: &[LensElement]) -> Result<Self, String> {
        let [mut a, mut b, mut c, mut d] = [1.0, 0.0, 0.0, 1.0];
        let mut length = 0.0;
        let mut before = 1.0;
        for (i, element) in elements.iter().enumerate() {
            let behind = index(element.eta);
            if element.curvature_radius != 0.0 {
                let power = (behind - before) / f64::from(element.curvature_radius);
                (c, d) = (c - power * a, d - power * b);
            }
            if i + 1 < elements.len() {
                let thickness = f64::from(element.thickness);
                length += thickness;
                (a, b) = (a + thickness / behind * c, b + thickness / behind * d);
            }
            before = behind;
        }
        let focal_length = -1.0 / c;
        if !(focal_length > 0.0 && focal_length.is_finite()) {
            return Err(
                "the lens does not gather light: its elements have no positive focal length".to_owned()
            );
        }
        Ok(Self { focal_length, principal: [(d - 1.0) / c, (1.0 - a) / c], length })
    }

    /// The distance from the hindmost element to a film that sees a plane at the distance `focus` from it sharp.
    fn distance_to_film(&self, focus: f64) -> Result<f64, String> {
        let [scene, film] = self.principal;
        // Object and image distances s and s′ obey 1/s + 1/s′ = 1/f; between the principal planes light jumps.
        let reach = focus - (self.length + film - scene);
        let product = reach * (reach - 4.0 * self.focal_length);
        if !(reach > 0.0 && product > 0.0) {
            let least = 4.0 * self.focal_length + (self.length + film - scene);
            return Err(format!(
                "a focus distance of {focus} m is too short for the lens, of {:.1} mm focal length: it must be more than {least:.4} m",
                self.focal_length * 1e3
            ));
        }
        // The smaller root, by the larger, without cancellation.
        let image = 2.0 * self.focal_length * reach / (reach + product.sqrt());
        let distance = image + film;
        if distance > 0.0 {
            Ok(distance)
        } else {
            Err("the lens focuses inside its last element: the film would have to be in the glass".to_owned())
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use sahl_scene::Aperture;

    fn element(curvature_radius: f32, thickness: f32, eta: f32, diameter: f32) -> LensElement {
        LensElement { curvature_radius, thickness, eta, diameter }
    }

    /// A biconvex lens of about 50 mm focal length, and a stop behind it.
    pub(in super::super) fn simple(aperture_diameter: f32, focus_distance: f32) -> LensSystem {
        LensSystem {
            elements: vec![
                element(0.05, 0.004, 1.5, 0.02),
                element(-0.05, 0.002, 1.0, 0.02),
                element(0.0, 0.0, 1.0, 0.02),
            ],
            aperture_diameter,
            aperture: Aperture::Round,
            focus_distance,
        }
    }

    #[test]
    fn a_thin_lens_has_the_focal_length_of_its_formula() {
        let thick = ThickLens::new(&simple(0.01, 1.0).elements).unwrap();
        // Lensmaker: (n − 1) (1/R₁ − 1/R₂ + (n − 1) d / (n R₁ R₂)).
        let power = 0.5 * (2.0 / 0.05 - 0.5 * 0.004 / (1.5 * 0.05 * 0.05));
        assert!((thick.focal_length - 1.0 / power).abs() < 1e-6, "{thick:?}");
        // Both planes within the glass, which is 4 mm thick and 2 mm before the stop: a third of it from either side.
        assert!((thick.principal[0] - 0.004 / 3.0).abs() < 1e-4, "{thick:?}");
        assert!((thick.principal[1] + 0.002 + 0.004 / 3.0).abs() < 1e-4, "{thick:?}");
    }

    #[test]
    fn light_from_a_film_point_meets_where_the_lens_focuses() {
        for focus in [0.5, 1.0, 10.0] {
            let stack = Stack::new(&simple(0.002, focus), None).unwrap();
            let film = DVec3::new(2e-4, 0.0, 0.0);
            let cross = |x: f64, y: f64| {
                let rear = DVec3::new(x, y, stack.rear_z());
                let (way, weight) = stack.trace(Way { origin: film, direction: rear - film }).unwrap();
                assert_eq!(weight, 1.0);
                let t = (f64::from(focus) - way.origin.z) / way.direction.z;
                way.origin + way.direction * t
            };
            let (a, b, c) = (cross(0.0, 0.0), cross(3e-4, 0.0), cross(0.0, -3e-4));
            // A third of a millimetre on the stop is apart by less than a hundredth of what it would be out of focus.
            let apart = (a - b).length().max((a - c).length());
            assert!(apart < 0.02 * 3e-4 * f64::from(focus) / 0.05, "{focus}: {apart}");
            // Upside down, and as large as the distances say.
            assert!(a.x < 0.0);
        }
    }

    #[test]
    fn stops_and_rims_stop_light() {
        let stack = Stack::new(&simple(0.002, 1.0), None).unwrap();
        let towards = |x: f64| {
            let rear = DVec3::new(x, 0.0, stack.rear_z());
            stack.trace(Way { origin: DVec3::ZERO, direction: rear })
        };
        assert!(towards(0.0009).is_some() && towards(0.0011).is_none());
        let wide = Stack::new(&simple(1.0, 1.0), None).unwrap();
        assert!(
            wide.trace(Way { origin: DVec3::ZERO, direction: DVec3::new(0.009, 0.0, wide.rear_z()) })
                .is_some()
        );
        assert_eq!(wide.rear_radius(), f64::from(0.02_f32) * 0.5);
    }

    #[test]
    fn lenses_that_make_no_image_are_refused() {
        let mut hollow = simple(0.01, 1.0);
        hollow.elements[0].curvature_radius = -0.05;
        hollow.elements[1].curvature_radius = 0.05;
        assert!(Stack::new(&hollow, None).unwrap_err().contains("gather"));
        assert!(Stack::new(&simple(0.01, 0.1), None).unwrap_err().contains("too short"));
        let mut ball = simple(0.01, 1.0);
        ball.elements[1].thickness = 0.06;
        assert!(Stack::new(&ball, None).unwrap_err().contains("in the glass"));
        assert!(ThickLens::new(&[]).is_err());
    }
}
