//! How much light the layers of [`super::OpenPbr`] scatter: tables over angle, roughness and index.
//!
//! Computed once a process, when the first such surface is built; a few hundred thousand averages of microfacet samples.

use std::f32::consts::{PI, TAU};
use std::sync::LazyLock;

use rayon::prelude::*;
use sahl_math::{Vec2, Vec3, safe_sqrt};

use super::lobes::{fuzz_density, fuzz_visibility};
use crate::bsdf::dielectric::Dielectric;
use crate::bsdf::fresnel;
use crate::bsdf::microfacet::{SMOOTH_ALPHA, TrowbridgeReitz};

/// Entries along the root of the cosine.
const ANGLES: usize = 32;
/// Entries along the root of α.
const ROUGHNESSES: usize = 24;
/// Entries along the index of refraction.
const INDICES: usize = 16;
/// Indices of refraction at both ends of the tables.
pub(super) const INDEX_RANGE: [f32; 2] = [1.0, 3.0];
/// Samples along each of two axes that an entry is the mean of: drawn by microfacets, and uniform ones.
const SAMPLES: usize = 16;
const UNIFORM_SAMPLES: usize = 64;
/// The cosine that stands for zero, at which microfacets are not defined.
const LEAST_COS: f32 = 1e-4;

/// Shares of light that are scattered, by layer.
#[derive(Debug, PartialEq)]
pub(super) struct Albedos {
    /// Microfacets that reflect everything.
    mirror: Table,
    /// Light reflected outside an interface.
    reflected: Table,
    /// Light reflected and refracted at an interface, from outside and from inside.
    glass: [Table; 2],
    fuzz: Table,
}

/// The tables, which are the same for all surfaces.
pub(super) fn albedos() -> &'static Albedos {
    static ALBEDOS: LazyLock<Albedos> = LazyLock::new(Albedos::new);
    &ALBEDOS
}

/// A function of the cosine, of α and of an index of refraction: linear between its entries.
#[derive(Debug, PartialEq)]
struct Table {
    values: Vec<f32>,
    indices: usize,
}

impl Albedos {
    fn new() -> Self {
        let glass = |is_inside: bool| {
            Table::new(INDICES, |cos, alpha, eta| {
                let glass = Dielectric::new(eta, [alpha; 2]);
                let wo = view(if is_inside { -cos } else { cos });
                let square = if is_inside { 1.0 / (eta * eta) } else { eta * eta };
                mean(SAMPLES, |u| {
                    let lobe =
                        |transmits| glass.sample_lobe(wo, transmits, u).map_or(0.0, |lobe| lobe.weight);
                    // Without the compression of radiance.
                    lobe(false) + square * lobe(true)
                })
            })
        };
        Self {
            mirror: Table::new(1, |cos, alpha, _| reflected(cos, alpha, |_| 1.0)),
            reflected: Table::new(INDICES, |cos, alpha, eta| {
                reflected(cos, alpha, |cos| fresnel::dielectric(cos, eta).reflectance)
            }),
            glass: [glass(false), glass(true)],
            fuzz: Table::new(1, |cos, alpha, _| fuzz(cos, alpha)),
        }
    }

    /// Of microfacets that reflect everything, seen under the cosine `cos`.
    #[inline]
    pub(super) fn mirror(&self, cos: f32, alpha: f32) -> f32 {
        self.mirror.at(cos, alpha, 0.0)
    }

    /// Of the outside of an interface to matter with the index `eta`.
    #[inline]
    pub(super) fn reflected(&self, cos: f32, alpha: f32, eta: f32) -> f32 {
        self.reflected.at(cos, alpha, eta)
    }

    /// Of an interface, reflection and refraction together.
    #[inline]
    pub(super) fn glass(&self, cos: f32, alpha: f32, eta: f32, is_inside: bool) -> f32 {
        self.glass[usize::from(is_inside)].at(cos, alpha, eta)
    }

    /// Of white fuzz; may exceed one where `fuzz` is grazed.
    #[inline]
    pub(super) fn fuzz(&self, cos: f32, alpha: f32) -> f32 {
        self.fuzz.at(cos, alpha, 0.0)
    }
}

impl Table {
    fn new(indices: usize, value: impl Fn(f32, f32, f32) -> f32 + Sync) -> Self {
        let [low, high] = INDEX_RANGE;
        let entry = |i: usize| {
            let root = |i: usize, count: usize| i as f32 / (count - 1) as f32;
            let (angle, rest) = (root(i % ANGLES, ANGLES), i / ANGLES);
            let (roughness, index) = (root(rest % ROUGHNESSES, ROUGHNESSES), rest / ROUGHNESSES);
            let eta = if indices > 1 { low + (high - low) * root(index, indices) } else { low };
            value((angle * angle).max(LEAST_COS), (roughness * roughness).max(SMOOTH_ALPHA), eta)
        };
        Self { values: (0..ANGLES * ROUGHNESSES * indices).into_par_iter().map(entry).collect(), indices }
    }

    #[inline]
    fn at(&self, cos: f32, alpha: f32, eta: f32) -> f32 {
        let [low, high] = INDEX_RANGE;
        let (angle, x) = place(safe_sqrt(cos), ANGLES);
        let (roughness, y) = place(safe_sqrt(alpha), ROUGHNESSES);
        let row = |roughness: usize, index: usize| {
            let first = (index * ROUGHNESSES + roughness) * ANGLES + angle;
            self.values[first] * (1.0 - x) + self.values[first + 1] * x
        };
        let sheet = |index| row(roughness, index) * (1.0 - y) + row(roughness + 1, index) * y;
        if self.indices == 1 {
            return sheet(0);
        }
        let (index, z) = place((eta - low) / (high - low), self.indices);
        sheet(index) * (1.0 - z) + sheet(index + 1) * z
    }
}

/// The entry before `x` in [0, 1], and how far `x` is from it to the next.
#[inline]
fn place(x: f32, count: usize) -> (usize, f32) {
    let x = if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) } * (count - 1) as f32;
    let i = (x as usize).min(count - 2);
    (i, x - i as f32)
}

/// A direction with the given cosine.
fn view(cos: f32) -> Vec3 {
    Vec3::new(safe_sqrt(1.0 - cos * cos), 0.0, cos)
}

/// The mean over the unit square, by so many samples along each side.
fn mean(samples: usize, value: impl Fn(Vec2) -> f32) -> f32 {
    let coordinate = |i: usize| (i as f32 + 0.5) / samples as f32;
    let sum: f32 = (0..samples * samples)
        .map(|i| value(Vec2::new(coordinate(i % samples), coordinate(i / samples))))
        .sum();
    sum / (samples * samples) as f32
}

/// The light that microfacets with the reflectance `fresnel` of the cosine reflect.
fn reflected(cos: f32, alpha: f32, fresnel: impl Fn(f32) -> f32) -> f32 {
    let Some(facets) = TrowbridgeReitz::new(alpha, alpha) else { return fresnel(cos) };
    let wo = view(cos);
    mean(SAMPLES, |u| {
        let m = facets.sample_reflecting(wo, u);
        let cos = wo.dot(m);
        let wi = m * (2.0 * cos) - wo;
        if wi.z <= 0.0 {
            return 0.0;
        }
        fresnel(cos) * 2.0 * facets.reflecting_normalization(wo) * facets.visibility(wo, wi) * wi.z
    })
}

/// The light that white fuzz scatters.
fn fuzz(cos: f32, alpha: f32) -> f32 {
    let wo = view(cos);
    mean(UNIFORM_SAMPLES, |u| {
        // Uniform over the hemisphere.
        let (sin_phi, cos_phi) = (u.x * TAU).sin_cos();
        let sin = safe_sqrt(1.0 - u.y * u.y);
        let wi = Vec3::new(sin * cos_phi, sin * sin_phi, u.y);
        let Some(m) = (wo + wi).try_normalize() else { return 0.0 };
        fuzz_density(m.z, alpha) * fuzz_visibility(wo.z, wi.z) * wi.z * 2.0 * PI
    })
}
