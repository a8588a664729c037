//! The sky through a window.
//!
//! Indoors most directions of a sky end at a wall. A portal says where the window is: light comes through it alone, and is
//! sampled in proportion to the radiance within what a point sees through it.
//!
//! Source: Bitterli, Wyman, Pharr, Shirley, Lefohn, Jarosz, *Portal-Masked Environment Map Sampling*, CGF 34(4), 2015. In
//! coordinates that are the angles about the portal's two edges, a rectangle appears as a rectangle from everywhere.
//! Deviation: the radiance is that of the sky itself; the grid in these coordinates is only what is sampled by. pbrt-v4
//! looks up radiance in its grid, too.
//!
//! In a scene file:
//! `LightSource "infinite" "string filename" "sky.exr" "point3 portal" [ 0 1 0  0 3 0  2 3 0  2 1 0 ]`.
//!
//! Deliberately absent: several portals for one sky, and MIS compensation, which would depend on the window.

use std::f32::consts::{FRAC_PI_2, PI};

use sahl_math::{Bounds3, Vec2, Vec3};

use super::{Cone, Emission, ImageEnvironment, LightBounds, LightSample};
use crate::distribution::{Window, Windowed2d};
use crate::spectrum::{Spectrum, Wavelengths};

/// How far lengths and right angles of a portal may be off, as a share: they come from files with few digits.
const TOLERANCE: f32 = 1e-3;

/// The grid has at least and at most this many cells along each axis.
const CELLS: [usize; 2] = [32, 1024];

/// A rectangle through which a sky is seen.
#[derive(Clone, Debug)]
pub(crate) struct Portal {
    /// Its first and third corner, which are opposite.
    corners: [Vec3; 2],
    /// Unit vectors along the edges, and across them out of the room.
    axes: [Vec3; 3],
    area: f32,
}

/// A sky that is seen through a portal.
#[derive(Clone, Debug)]
pub(crate) struct PortalEnvironment {
    sky: Sky,
    portal: Portal,
    distribution: Windowed2d,
}

/// What is behind a portal.
#[derive(Clone, Debug)]
pub(crate) enum Sky {
    /// The same radiance from all directions.
    Uniform(Emission),
    /// Radiance by direction.
    Image(ImageEnvironment),
}

impl Portal {
    /// The rectangle with the given corners in order round it, whose outside is where (p₃ − p₀) × (p₁ − p₀) points; `None` if they
    /// are not those of a rectangle.
    pub(crate) fn new([p0, p1, p2, p3]: [Vec3; 4]) -> Option<Self> {
        let (x, y) = (p3 - p0, p1 - p0);
        let (width, height) = (x.length(), y.length());
        let (x, y) = (x.try_normalize()?, y.try_normalize()?);
        let fourth = p0 + (p3 - p0) + (p1 - p0);
        let is_rectangle =
            x.dot(y).abs() <= TOLERANCE && (p2 - fourth).length() <= TOLERANCE * width.max(height);
        is_rectangle.then_some(())?;
        let z = x.cross(y).try_normalize()?;
        Some(Self { corners: [p0, p2], axes: [x, z.cross(x), z], area: width * height })
    }

    /// Its four corners.
    fn all_corners(&self) -> [Vec3; 4] {
        let [first, third] = self.corners;
        let along = |axis: Vec3| first + axis * axis.dot(third - first);
        [first, third, along(self.axes[0]), along(self.axes[1])]
    }

    /// Whether `p` is on the side to which light comes.
    pub(crate) fn is_inside(&self, p: Vec3) -> bool {
        (self.corners[0] - p).dot(self.axes[2]) > 0.0
    }

    /// What is seen of the sky from `from`, in the angles about the edges; `None` from outside.
    #[inline]
    fn window(&self, from: Vec3) -> Option<Window> {
        let [a, b] = self.corners.map(|corner| self.angles(corner - from));
        let (a, b) = (a?, b?);
        Some([a.min(b), a.max(b)])
    }

    /// The coordinates of a direction, which needs not have length one: angles from −π/2 to π/2 become 0 to 1. `None` for
    /// directions into the room.
    #[inline]
    fn angles(&self, direction: Vec3) -> Option<Vec2> {
        let [x, y, z] = self.axes.map(|axis| axis.dot(direction));
        (z > 0.0).then(|| Vec2::new((x / z).atan() / PI + 0.5, (y / z).atan() / PI + 0.5))
    }

    /// The unit direction with these coordinates.
    #[inline]
    fn direction(&self, uv: Vec2) -> Vec3 {
        let tan = |t: f32| (PI * t - FRAC_PI_2).tan();
        let [x, y, z] = self.axes;
        (x * tan(uv.x) + y * tan(uv.y) + z).normalize()
    }

    /// Solid angle per area of the coordinates at a unit direction: π² (1 − x²)(1 − y²) / z.
    #[inline]
    fn solid_angle(&self, direction: Vec3) -> f32 {
        let [x, y, z] = self.axes.map(|axis| axis.dot(direction));
        PI * PI * (1.0 - x * x) * (1.0 - y * y) / z
    }
}

impl Sky {
    #[inline]
    fn radiance(&self, direction: Vec3, wavelengths: &Wavelengths) -> Spectrum {
        match self {
            Self::Uniform(radiance) => radiance.at(wavelengths),
            Self::Image(image) => image.radiance(direction, wavelengths),
        }
    }

    /// Cells along each axis of a grid that is as fine as the sky.
    fn resolution(&self) -> usize {
        match self {
            Self::Uniform(_) => 2 * CELLS[0],
            Self::Image(image) => image.resolution().clamp(CELLS[0], CELLS[1]),
        }
    }
}

impl PortalEnvironment {
    /// `sky` through `portal`.
    pub(crate) fn new(sky: Sky, portal: Portal) -> Self {
        let size = sky.resolution();
        let weight = |uv: Vec2| {
            let direction = portal.direction(uv);
            sky.radiance(direction, &Wavelengths::Rgb).average() * portal.solid_angle(direction)
        };
        let center = |i: usize| Vec2::new((i % size) as f32 + 0.5, (i / size) as f32 + 0.5);
        let mut weights: Vec<f32> =
            (0..size * size).map(|i| weight(center(i) * (1.0 / size as f32))).collect();
        // A texel that lies between the centres counts too: what is not in the grid would never be sampled.
        if let Sky::Image(image) = &sky {
            for direction in image.texel_directions() {
                if let Some(uv) = portal.angles(direction) {
                    let place = |t: f32| ((t * size as f32) as usize).min(size - 1);
                    let cell = &mut weights[place(uv.y) * size + place(uv.x)];
                    *cell = cell.max(weight(uv));
                }
            }
        }
        let distribution = Windowed2d::new(&weights, size);
        Self { sky, portal, distribution }
    }

    #[inline]
    pub(super) fn sample(&self, from: Vec3, u: Vec2, wavelengths: &Wavelengths) -> Option<LightSample> {
        let window = self.portal.window(from)?;
        let (uv, pdf) = self.distribution.sample(u, window)?;
        let wi = self.portal.direction(uv);
        let pdf = pdf / self.portal.solid_angle(wi);
        let radiance = self.sky.radiance(wi, wavelengths);
        (pdf > 0.0 && pdf.is_finite()).then_some(LightSample {
            radiance,
            wi,
            pdf,
            is_delta: false,
            end: None,
        })
    }

    /// Radiance that arrives at `from` along a unit direction in the world.
    #[inline]
    pub(super) fn radiance(&self, from: Vec3, direction: Vec3, wavelengths: &Wavelengths) -> Spectrum {
        match self.seen(from, direction) {
            Some(_) => self.sky.radiance(direction, wavelengths),
            None => Spectrum::ZERO,
        }
    }

    #[inline]
    pub(super) fn pdf(&self, from: Vec3, direction: Vec3) -> f32 {
        let Some((uv, window)) = self.seen(from, direction) else { return 0.0 };
        let pdf = self.distribution.pdf(uv, window) / self.portal.solid_angle(direction);
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// The coordinates of `direction`, and the window, if it goes through the portal.
    #[inline]
    fn seen(&self, from: Vec3, direction: Vec3) -> Option<(Vec2, Window)> {
        let (window, uv) = (self.portal.window(from)?, self.portal.angles(direction)?);
        let [low, high] = window;
        let inside = (low.x..=high.x).contains(&uv.x) && (low.y..=high.y).contains(&uv.y);
        inside.then_some((uv, window))
    }

    /// The window as a lamp that shines into the room.
    pub(super) fn bounds(&self) -> LightBounds {
        LightBounds {
            bounds: Bounds3::from_points(self.portal.all_corners()),
            facing: Cone::of(-self.portal.axes[2]),
            cos_reach: 0.0,
            two_sided: false,
            intensity: self.power(&Wavelengths::Rgb).average() / PI,
        }
    }

    /// Flux through the portal: A ∫ L cos θ dω.
    pub(super) fn power(&self, wavelengths: &Wavelengths) -> Spectrum {
        const SIZE: usize = 64;
        let mut sum = Spectrum::ZERO;
        for i in 0..SIZE * SIZE {
            let uv = Vec2::new((i % SIZE) as f32 + 0.5, (i / SIZE) as f32 + 0.5) * (1.0 / SIZE as f32);
            let direction = self.portal.direction(uv);
            let weight = self.portal.solid_angle(direction) * self.portal.axes[2].dot(direction);
            sum += self.sky.radiance(direction, wavelengths) * weight;
        }
        sum * (self.portal.area / (SIZE * SIZE) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lamp_in_the_place_of_a_window_holds_all_its_corners() {
        // A square that stands on a corner.
        let corners = [Vec3::X, Vec3::Y, -Vec3::X, -Vec3::Y].map(|corner| corner + Vec3::Z);
        let portal = Portal::new(corners).expect("a square");
        let (found, all) = (Bounds3::from_points(portal.all_corners()), Bounds3::from_points(corners));
        assert!((found.min - all.min).length() + (found.max - all.max).length() < 1e-6, "{found:?}");
    }
}
