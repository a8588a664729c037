//! A gonioreflectometer for surfaces that are known: it fills the tables of a measurement.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use sahl_math::{Vec2, Vec3};
use sahl_render::bsdf::Bsdf;
use sahl_render::bsdf::microfacet::TrowbridgeReitz;
use sahl_render::distribution::{LinearSlices2d, Mixture};
use sahl_render::spectrum::{ColorRole, SpectralCurve, Wavelengths};
use sahl_scene::{Diagnostics, MeasuredBrdf, MeasuredGrid};

/// Values a side of the tables over u, of those over halfway vectors, and polar angles of wo.
const SIDE: usize = 24;
const FINE: usize = 96;
const POLAR: usize = 16;

const WAVELENGTHS: [f32; 3] = [400.0, 550.0, 700.0];

/// By what the measured surface is darker than the original.
pub(crate) fn tint(lambda: f32) -> f32 {
    0.5 + (lambda.clamp(400.0, 700.0) - 400.0) / 600.0
}

/// The tint in linear sRGB.
pub(crate) fn rgb_tint() -> [f32; 3] {
    let samples = [300.0, 400.0, 700.0, 900.0].map(|lambda| (lambda, tint(lambda))).to_vec();
    let spectrum = sahl_scene::Spectrum::Sampled(samples);
    let curve = SpectralCurve::new(&spectrum, ColorRole::Albedo, None, &mut Diagnostics::default());
    curve.at(&Wavelengths::Rgb).to_rgb()
}

fn place(index: usize, count: usize) -> f32 {
    index as f32 / (count - 1) as f32
}

fn direction(theta: f32, phi: f32) -> Vec3 {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta.sin_cos(), phi.sin_cos());
    Vec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// The direction that a point of the unit square stands for, its azimuth counted from `from`.
fn direction_at(p: Vec2, from: f32) -> Vec3 {
    direction(p.x * p.x * FRAC_PI_2, (2.0 * p.y - 1.0) * PI + from)
}

fn plane(side: usize, mut value: impl FnMut(Vec2) -> f32) -> Vec<f32> {
    (0..side * side).map(|i| value(Vec2::new(place(i % side, side), place(i / side, side)))).collect()
}

fn grid(side: usize, values: Vec<f32>) -> MeasuredGrid {
    MeasuredGrid { resolution: [side as u32; 2], values: values.into() }
}

/// Measures `bsdf` at the azimuths `phi`, with microfacets of the slopes `alpha` for the parametrisation.
pub(crate) fn measure(bsdf: &Bsdf<'_>, alpha: [f32; 2], phi: &[f32]) -> MeasuredBrdf {
    let facets = TrowbridgeReitz::new(alpha[0], alpha[1]).expect("the surface is rough");
    let sigma = |w: Vec3| {
        let [x, y] = [alpha[0] * w.x, alpha[1] * w.y];
        0.5 * (w.z + (x * x + y * y + w.z * w.z).sqrt())
    };
    // Finer toward the horizon.
    let theta: Vec<f32> = (0..POLAR).map(|i| 1.555 * (FRAC_PI_2 * place(i, POLAR)).sin()).collect();
    let (mut vndf, mut luminance, mut spectra) = (Vec::new(), Vec::new(), Vec::new());
    for &phi_o in phi {
        let from = if phi.len() > 1 { 0.0 } else { phi_o };
        for &theta_o in &theta {
            let wo = direction(theta_o, phi_o);
            let density = plane(FINE, |p| {
                let m = direction_at(p, from);
                facets.density(m) * wo.dot(m).max(0.0) * p.x * m.x.hypot(m.y)
            });
            let warp = LinearSlices2d::new(&density, FINE, FINE);
            let relative = plane(SIDE, |u| {
                let m = direction_at(warp.sample(u, &Mixture::of(0)), from);
                let wi = m * (2.0 * wo.dot(m)) - wo;
                if wi.z > 0.0 {
                    bsdf.eval(wo, wi).max_component() * 4.0 * sigma(wo) / facets.density(m)
                } else {
                    0.0
                }
            });
            for lambda in WAVELENGTHS {
                spectra.extend(relative.iter().map(|value| value * tint(lambda)));
            }
            luminance.extend(relative);
            vndf.extend(density);
        }
    }
    MeasuredBrdf {
        theta: theta.into(),
        phi: phi.into(),
        wavelengths: Arc::new(WAVELENGTHS),
        ndf: grid(FINE, plane(FINE, |p| facets.density(direction_at(p, 0.0)))),
        sigma: grid(FINE, plane(FINE, |p| sigma(direction_at(p, 0.0)))),
        vndf: grid(FINE, vndf),
        luminance: grid(SIDE, luminance),
        spectra: grid(SIDE, spectra),
        is_relative: true,
    }
}
