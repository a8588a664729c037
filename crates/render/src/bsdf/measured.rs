//! Surfaces that were measured.
//!
//! Deliberately absent: anything below the horizon. The database holds reflection alone.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use sahl_math::{Vec2, Vec3, lerp};
use sahl_scene::{Diagnostics, MeasuredBrdf, MeasuredGrid, Span};

use super::{BsdfSample, Reach, Scatter, ScatterKind};
use crate::distribution::{LinearSlices2d, Mixture, cell};
use crate::spectrum::{Spectrum, Wavelengths, measured_rgb_weights};

/// Directions a side in the estimate of the albedo.
const ALBEDO_GRID: usize = 4;

/// The tables of a measured surface, ready to be looked up and sampled.
///
/// See [`MeasuredBrdf`] for what they are. In RGB mode the spectra are colours under D65, computed here once.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredTables {
    brdf: MeasuredBrdf,
    /// The signs of x and y that azimuths of a half or a quarter of the circle have.
    sector: Option<[f32; 2]>,
    parts: u32,
    /// The azimuth in the middle of those that there are.
    middle: f32,
    vndf: LinearSlices2d,
    luminance: LinearSlices2d,
    /// For each azimuth and polar angle the red, green and blue values over u.
    rgb: Vec<[f32; 3]>,
}

/// A measured surface, which reflects on both sides, seen with the light of a path.
///
/// f |cos θi| = S(u) D(m) / (4 σ(ωo)), with u the point that the distribution of visible normals takes to the halfway vector m.
/// Samples follow the luminance of S, then that distribution: the density is p(u) p(m) / (4 ωo·m) over the Jacobian
/// 2 π² √(2 θ/π) sin θ of the parametrisation.
///
/// Source: Dupuy, Jakob, *An Adaptive Parameterization for Efficient Material Acquisition and Rendering*, ACM TOG 37(6), 2018,
/// section 4. As in pbrt-v4, what files call the incident direction is wo. Deviations from pbrt-v4: the symmetries of anisotropic
/// files are honoured, and values that are not relative to microfacets are taken for what they are.
///
/// In a scene file: `Material "measured" "string filename" "cc_nothern_aurora_spec.bsdf"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured<'a> {
    tables: &'a MeasuredTables,
    /// The wavelengths of a path, in nanometres; `None`: colours.
    lambda: Option<[f32; 4]>,
}

/// The entries of the increasing `knots` about `x`, and how far it is from the first to the second.
#[inline]
fn bracket(knots: &[f32], x: f32) -> ([usize; 2], f32) {
    let after = knots.partition_point(|&knot| knot <= x);
    if after == 0 {
        return ([0; 2], 0.0);
    }
    if after == knots.len() {
        return ([after - 1; 2], 0.0);
    }
    let (low, high) = (knots[after - 1], knots[after]);
    ([after - 1, after], (x - low) / (high - low))
}

/// A function of the unit square, which may have one value along an axis.
fn lookup(grid: &MeasuredGrid, p: Vec2) -> f32 {
    let [width, height] = grid.resolution.map(|side| side as usize);
    let ((column, s), (row, t)) = (cell(p.x, width), cell(p.y, height));
    let at =
        |row: usize, column: usize| grid.values[row.min(height - 1) * width + column.min(width - 1)].max(0.0);
    let along = |row| lerp(s, at(row, column), at(row, column + 1));
    lerp(t, along(row), along(row + 1))
}

/// The polar angle and the azimuth of a direction.
#[inline]
fn angles(w: Vec3) -> [f32; 2] {
    [w.x.hypot(w.y).atan2(w.z), w.y.atan2(w.x)]
}

/// The point of the unit square that stands for a direction.
#[inline]
fn point([theta, phi]: [f32; 2]) -> Vec2 {
    let y = phi / TAU + 0.5;
    Vec2::new((theta / FRAC_PI_2).sqrt().min(1.0), y - y.floor())
}

impl MeasuredTables {
    /// The tables of `brdf`, which must have no problem (see [`MeasuredBrdf::problem`]); `span` is what messages point at.
    ///
    /// # Panics
    /// If the sizes of its tables do not fit.
    pub fn new(brdf: &MeasuredBrdf, span: Option<Span>, diagnostics: &mut Diagnostics) -> Self {
        let slices = |grid: &MeasuredGrid| {
            let [width, height] = grid.resolution.map(|side| side as usize);
            LinearSlices2d::new(&grid.values, width, height)
        };
        let parts = brdf.symmetry().unwrap_or(1);
        let middle = brdf.phi.first().zip(brdf.phi.last()).map_or(0.0, |(first, last)| 0.5 * (first + last));
        Self {
            vndf: slices(&brdf.vndf),
            luminance: slices(&brdf.luminance),
            rgb: rgb(brdf, span, diagnostics),
            sector: (parts > 1).then(|| [middle.cos(), middle.sin()]),
            parts,
            middle,
            brdf: brdf.clone(),
        }
    }

    /// The turn about the normal, or the mirroring, that brings `wo` to where there are tables: signs of x and y.
    #[inline]
    fn turn(&self, wo: Vec3) -> Vec3 {
        let Some([x, y]) = self.sector else { return Vec3::ONE };
        let sign = |is_there: bool| if is_there { 1.0 } else { -1.0 };
        if self.parts == 2 {
            let both = sign(wo.x * x + wo.y * y >= 0.0);
            Vec3::new(both, both, 1.0)
        } else {
            Vec3::new(sign(wo.x * x >= 0.0), sign(wo.y * y >= 0.0), 1.0)
        }
    }

    /// The tables about the direction of these angles.
    #[inline]
    fn mixture(&self, [theta, phi]: [f32; 2]) -> Mixture {
        // By whole turns to where there are tables.
        let phi = phi + ((self.middle - phi) / TAU).round() * TAU;
        let (theta, phi) = (bracket(&self.brdf.theta, theta), bracket(&self.brdf.phi, phi));
        Mixture::between(theta, phi, self.brdf.theta.len())
    }

    /// S at the point `u`.
    fn spectrum(&self, u: Vec2, mixture: &Mixture, lambda: Option<[f32; 4]>) -> Spectrum {
        let [width, height] = self.brdf.spectra.resolution.map(|side| side as usize);
        let ((column, s), (row, t)) = (cell(u.x, width), cell(u.y, height));
        let plane = |first: usize, value: &dyn Fn(usize) -> f32| {
            let at = |row: usize, column: usize| value(first + row * width + column);
            let along = |row| lerp(s, at(row, column), at(row, column + 1));
            lerp(t, along(row), along(row + 1))
        };
        let area = width * height;
        let Some(lambda) = lambda else {
            let rgb = [0, 1, 2].map(|lane| {
                mixture.mean(|slice| plane(slice * area, &|index| self.rgb[index][lane])).max(0.0)
            });
            return Spectrum::from_rgb(rgb);
        };
        let (count, values) = (self.brdf.wavelengths.len(), &self.brdf.spectra.values);
        Spectrum::from_lanes(lambda.map(|lambda| {
            let ([before, after], t) = bracket(&self.brdf.wavelengths, lambda);
            let at = |slice: usize, knot| plane((slice * count + knot) * area, &|index| values[index]);
            mixture.mean(|slice| lerp(t, at(slice, before), at(slice, after))).max(0.0)
        }))
    }
}

/// The spectra as colours.
fn rgb(brdf: &MeasuredBrdf, span: Option<Span>, diagnostics: &mut Diagnostics) -> Vec<[f32; 3]> {
    let weights = measured_rgb_weights(&brdf.wavelengths, span, diagnostics);
    let [width, height] = brdf.spectra.resolution.map(|side| side as usize);
    let area = width * height;
    let slices = brdf.theta.len() * brdf.phi.len();
    let mut rgb = vec![[0.0; 3]; slices * area];
    for (slice, spectra) in brdf.spectra.values.chunks(area * weights.len()).enumerate() {
        for (plane, weight) in spectra.chunks(area).zip(&weights) {
            for (sum, value) in rgb[slice * area..].iter_mut().zip(plane) {
                *sum = std::array::from_fn(|lane| sum[lane] + weight[lane] * value);
            }
        }
    }
    rgb
}

/// What a pair of directions is to the tables.
struct Configuration {
    mixture: Mixture,
    /// The points of wo, of the halfway vector, and that which is taken to it.
    outgoing: Vec2,
    halfway: Vec2,
    u: Vec2,
    /// The density of directions over that of points u.
    density: f32,
}

impl<'a> Measured<'a> {
    /// The surface with these tables, for the light of a path.
    #[inline]
    pub fn new(tables: &'a MeasuredTables, wavelengths: &Wavelengths) -> Self {
        let lambda = match wavelengths {
            Wavelengths::Rgb => None,
            Wavelengths::Sampled(hero) => Some(hero.lambda()),
        };
        Self { tables, lambda }
    }

    /// `None` unless both directions are on the same side.
    fn configuration(&self, wo: Vec3, wi: Vec3) -> Option<Configuration> {
        if wo.z * wi.z <= 0.0 {
            return None;
        }
        // Seen from behind, the surface is that of the front, turned about a tangent.
        let (wo, wi) = if wo.z < 0.0 { (-wo, -wi) } else { (wo, wi) };
        let tables = self.tables;
        let turn = tables.turn(wo);
        let (wo, wi) = (wo * turn, wi * turn);
        let m = (wo + wi).try_normalize()?;
        let ([theta_o, phi_o], [theta_m, phi_m]) = (angles(wo), angles(m));
        let mixture = tables.mixture([theta_o, phi_o]);
        let from = if tables.brdf.is_isotropic() { phi_o } else { 0.0 };
        let halfway = point([theta_m, phi_m - from]);
        let jacobian = 8.0 * PI * PI * wo.dot(m) * halfway.x * m.x.hypot(m.y);
        Some(Configuration {
            outgoing: point([theta_o, phi_o]),
            halfway,
            u: tables.vndf.inverse(halfway, &mixture),
            density: tables.vndf.density(halfway, &mixture) / jacobian,
            mixture,
        })
    }

    fn value(&self, configuration: &Configuration) -> Spectrum {
        let (tables, Configuration { mixture, u, .. }) = (self.tables, configuration);
        let value = tables.spectrum(*u, mixture, self.lambda);
        if !tables.brdf.is_relative {
            return value;
        }
        let sigma = lookup(&tables.brdf.sigma, configuration.outgoing);
        if sigma > 0.0 {
            value * (lookup(&tables.brdf.ndf, configuration.halfway) / (4.0 * sigma))
        } else {
            Spectrum::ZERO
        }
    }

    /// The density of directions; zero where it has none, exactly at a mirror's direction.
    fn density(&self, configuration: &Configuration) -> f32 {
        let Configuration { mixture, u, density, .. } = configuration;
        let pdf = density * self.tables.luminance.density(*u, mixture);
        if pdf.is_finite() { pdf } else { 0.0 }
    }
}

impl Scatter for Measured<'_> {
    #[inline(never)]
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        self.configuration(wo, wi).map_or(Spectrum::ZERO, |configuration| self.value(&configuration))
    }

    #[inline(never)]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.configuration(wo, wi).map_or(0.0, |configuration| self.density(&configuration))
    }

    #[inline(never)]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let tables = self.tables;
        let upper = if wo.z < 0.0 { -wo } else { wo };
        let turn = tables.turn(upper);
        let local = upper * turn;
        let [theta_o, phi_o] = angles(local);
        let mixture = tables.mixture([theta_o, phi_o]);
        let point = tables.vndf.sample(tables.luminance.sample(u, &mixture), &mixture);
        let from = if tables.brdf.is_isotropic() { phi_o } else { 0.0 };
        let (sin, cos) = (point.x * point.x * FRAC_PI_2).sin_cos();
        let (sin_phi, cos_phi) = ((point.y - 0.5) * TAU + from).sin_cos();
        let m = Vec3::new(sin * cos_phi, sin * sin_phi, cos);
        let wi = (m * (2.0 * local.dot(m)) - local).try_normalize()? * turn;
        if wi.z <= 0.0 {
            return None;
        }
        let wi = if wo.z < 0.0 { -wi } else { wi };
        let configuration = self.configuration(wo, wi)?;
        let (pdf, value) = (self.density(&configuration), self.value(&configuration));
        let weight = value / pdf;
        (pdf > 0.0 && weight.is_finite()).then_some(BsdfSample {
            wi,
            weight,
            pdf,
            kind: ScatterKind::GLOSSY_REFLECTION,
            eta: 1.0,
        })
    }

    #[inline]
    fn is_specular(&self) -> bool {
        false
    }

    #[inline]
    fn reach(&self) -> Reach {
        Reach::OneSide
    }

    /// The mean weight of a few samples.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        let place = |i: usize| (i as f32 + 0.5) / ALBEDO_GRID as f32;
        let mut sum = Spectrum::ZERO;
        for i in 0..ALBEDO_GRID * ALBEDO_GRID {
            let u = Vec2::new(place(i % ALBEDO_GRID), place(i / ALBEDO_GRID));
            sum += self.sample(wo, 0.0, u).map_or(Spectrum::ZERO, |sample| sample.weight);
        }
        (sum / (ALBEDO_GRID * ALBEDO_GRID) as f32).clamp(0.0, 1.0)
    }
}
