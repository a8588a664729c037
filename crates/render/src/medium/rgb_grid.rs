//! Colours of absorption, scattering and emission on a grid.
//!
//! In a scene file: `MakeNamedMedium "haze" "string type" "rgbgrid" "integer nx" 2 "integer ny" 1 "integer nz" 1` with two
//! triples of `rgb sigma_s`.

use sahl_image::ColorSpace;
use sahl_math::{Bounds3, Vec3};
use sahl_scene::{Diagnostics, Grid, RgbGridMedium, Span};

use super::grid::{Cells, Frame, Mix};
use super::majorant::MajorantGrid;
use super::walk::{self, Collision, Next};
use super::{HenyeyGreenstein, Properties, Way};
use crate::sampler::Stream;
use crate::spectrum::{ColorRole, SpectralCurve, Spectrum, Wavelengths};

/// Cells of the majorant along each axis, as in pbrt-v4.
const MAJORANT_CELLS: usize = 16;

/// A colour with a bound of what it is in any lane.
#[derive(Clone, Debug)]
struct Color {
    curve: SpectralCurve,
    bound: f32,
}

type Colors = Cells<Color>;

/// Matter whose colours are given on a grid. Colours become lanes at the centres of cells, and lanes are interpolated.
#[derive(Clone, Debug)]
pub(crate) struct RgbGrid {
    frame: Frame,
    scale: f32,
    /// One everywhere where it is not given.
    sigma_a: Option<Colors>,
    sigma_s: Option<Colors>,
    emission: Option<(Colors, f32)>,
    majorant: MajorantGrid,
    pub(super) phase: HenyeyGreenstein,
}

impl Mix for Spectrum {
    const ZERO: Self = Self::ZERO;
    #[inline]
    fn mix(self, other: Self, t: f32) -> Self {
        self + (other - self) * t
    }
}

impl RgbGrid {
    /// The medium of a scene; `span` is what messages point at.
    pub(crate) fn new(
        description: &RgbGridMedium,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let RgbGridMedium { region, space, sigma_a, sigma_s, scale, g, emission, emission_scale } =
            description;
        let mut colors = |grid: &Option<Grid<[f32; 3]>>, role| {
            let mut messages = Diagnostics::default();
            let colors = grid
                .as_ref()
                .map(|grid| Cells::new(grid, |rgb| Color::new(*rgb, *space, role, &mut messages)));
            // One cell speaks for all.
            if let Some(mut message) = messages.into_iter().next() {
                message.span = span;
                diagnostics.push(message);
            }
            colors
        };
        let sigma_a = colors(sigma_a, ColorRole::Unbounded);
        let sigma_s = colors(sigma_s, ColorRole::Unbounded);
        let emission = colors(emission, ColorRole::Illuminant).map(|colors| (colors, *emission_scale));
        let largest = |colors: &Option<Colors>, part: &Bounds3| {
            colors.as_ref().map_or(1.0, |colors| colors.max_within(part, |color| color.bound))
        };
        let majorant = MajorantGrid::new(MAJORANT_CELLS, |part| {
            scale * (largest(&sigma_a, part) + largest(&sigma_s, part))
        });
        let (frame, phase) = (Frame::new(region), HenyeyGreenstein::new(*g));
        Self { frame, scale: *scale, sigma_a, sigma_s, emission, majorant, phase }
    }

    pub(super) fn walk(
        &self,
        way: &Way,
        u: f32,
        stream: &mut Stream,
        visit: impl FnMut(&Collision) -> Next,
    ) -> Spectrum {
        let ray = self.frame.ray_to_cube(&way.ray);
        let stretches = self.majorant.stretches(&ray, way.length, Spectrum::ONE);
        walk::walk(way, u, stream, stretches, |p| self.properties(p, &way.wavelengths), visit)
    }

    fn properties(&self, p: Vec3, wavelengths: &Wavelengths) -> Properties {
        let p = self.frame.to_cube(p);
        let at = |colors: &Colors| {
            colors.at(p, |color| match color.bound {
                0.0 => Spectrum::ZERO,
                _ => color.curve.at(wavelengths),
            })
        };
        let sigma = |colors: &Option<Colors>| colors.as_ref().map_or(Spectrum::ONE, at) * self.scale;
        let emission = match &self.emission {
            Some((colors, scale)) => at(colors) * *scale,
            None => Spectrum::ZERO,
        };
        Properties { sigma_a: sigma(&self.sigma_a), sigma_s: sigma(&self.sigma_s), emission }
    }
}

impl Color {
    /// A spectrum that is seen as a colour may exceed its largest component, but not twice: the sigmoid of an unbounded
    /// quantity is below one, and its factor twice that component. What is grey is so in every lane.
    fn new(rgb: [f32; 3], space: ColorSpace, role: ColorRole, diagnostics: &mut Diagnostics) -> Self {
        let curve = SpectralCurve::new(&sahl_scene::Spectrum::Rgb { rgb, space }, role, None, diagnostics);
        let [r, g, b] = rgb;
        let factor = if r == g && g == b { 1.0 } else { 2.0 };
        let in_rgb = curve.at(&Wavelengths::Rgb).max_component();
        Self { curve, bound: in_rgb.max(factor * r.max(g).max(b)) }
    }
}
