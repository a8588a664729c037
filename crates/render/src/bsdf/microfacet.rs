//! The Trowbridge–Reitz (GGX) distribution of microfacet normals.
//!
//! Design decision: everything is written with t(w) = √(αx² x² + αy² y² + z²), the length of a stretched direction.
//! Smith's masking functions are ratios of t and z, so that no tangent or infinite Λ appears at grazing angles.
//!
//! Every method takes directions of the upper hemisphere; the BSDFs mirror theirs.

use std::f32::consts::PI;

use sahl_math::{Vec2, Vec3, safe_sqrt};

use crate::warp;

/// Surfaces whose larger α is below this are treated as perfectly smooth (pbrt-v4's limit).
pub const SMOOTH_ALPHA: f32 = 1e-3;
/// The least α of a rough surface, which bounds its anisotropy (pbrt-v4's limit).
const MIN_ALPHA: f32 = 1e-4;

/// A surface of ellipsoidal microfacets with slopes αx and αy along the two tangents.
///
/// Source: Trowbridge, Reitz, *Average Irregularity Representation of a Rough Surface for Ray Reflection*, JOSA 65(5),
/// 1975; Heitz, *Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs*, JCGT 3(2), 2014.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrowbridgeReitz {
    alpha_x: f32,
    alpha_y: f32,
}

impl TrowbridgeReitz {
    /// The distribution with the given α, or `None` for a surface that counts as smooth: both below [`SMOOTH_ALPHA`].
    #[inline]
    pub fn new(alpha_x: f32, alpha_y: f32) -> Option<Self> {
        // Written such that NaN is smooth.
        let rough = alpha_x >= SMOOTH_ALPHA || alpha_y >= SMOOTH_ALPHA;
        rough.then(|| Self { alpha_x: alpha_x.max(MIN_ALPHA), alpha_y: alpha_y.max(MIN_ALPHA) })
    }

    /// The distribution with the given α, each at least [`SMOOTH_ALPHA`]: for surfaces that are never smooth.
    #[inline]
    pub fn never_smooth([alpha_x, alpha_y]: [f32; 2]) -> Self {
        Self { alpha_x: alpha_x.max(SMOOTH_ALPHA), alpha_y: alpha_y.max(SMOOTH_ALPHA) }
    }

    /// α along the two tangents.
    #[inline]
    pub fn alpha(&self) -> [f32; 2] {
        [self.alpha_x, self.alpha_y]
    }

    /// D(m): area of microfacets with normal `m` (a unit vector) per area of surface and steradian.
    ///
    /// ∫ D(m) cos θm dm = 1 over the hemisphere.
    #[inline]
    pub fn density(&self, m: Vec3) -> f32 {
        let (x, y) = (m.x / self.alpha_x, m.y / self.alpha_y);
        let s = x * x + y * y + m.z * m.z;
        1.0 / (PI * self.alpha_x * self.alpha_y * s * s)
    }

    /// t(w) = √(αx² x² + αy² y² + z²) = |z| (1 + 2 Λ(w)).
    #[inline]
    pub fn stretched_length(&self, w: Vec3) -> f32 {
        let (x, y) = (self.alpha_x * w.x, self.alpha_y * w.y);
        (x * x + y * y + w.z * w.z).sqrt()
    }

    /// G₂(wo, wi) / (4 |cos θo| |cos θi|): the visibility term of both directions, with height-correlated masking and
    /// shadowing.
    ///
    /// G₂ = 1 / (1 + Λ(wo) + Λ(wi)), Heitz 2014, equation 99. Symmetric; both directions must leave the surface.
    #[inline]
    pub fn visibility(&self, wo: Vec3, wi: Vec3) -> f32 {
        let (zo, zi) = (wo.z.abs(), wi.z.abs());
        0.5 / (zi * self.stretched_length(wo) + zo * self.stretched_length(wi))
    }

    /// Draws a normal in proportion to D(m) (wo·m)₊: of those that are visible from `wo`, `wo.z` ≥ 0.
    ///
    /// In the space in which the microfacets form a hemisphere, the mirror directions of `wo` fill a spherical cap
    /// uniformly. Source: Dupuy, Benyoub, *Sampling Visible GGX Normals with Spherical Caps*, CGF 42(8), 2023.
    #[inline]
    pub fn sample_visible(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let stretched = self.stretch(wo);
        self.normal_from_cap(stretched, stretched.z, u)
    }

    /// Density of [`TrowbridgeReitz::sample_visible`] per steradian of the normal, over (wo·m)₊.
    ///
    /// D_v(m) = D(m) G₁(wo) (wo·m)₊ / cos θo (Heitz 2014), and G₁ / cos θo = 2 / (cos θo + t(wo)).
    #[inline]
    pub fn visible_density_over_cos(&self, wo: Vec3, m: Vec3) -> f32 {
        2.0 * self.density(m) / (wo.z + self.stretched_length(wo))
    }

    /// Draws a visible normal, `wo.z` ≥ 0, leaving out some of those that reflect `wo` below the surface.
    ///
    /// The spherical cap is cut to the smallest one of which it is known to hold all reflections above the surface.
    /// Source: Eto, Tokuyoshi, *Bounded VNDF Sampling for Smith–GGX Reflections*, SIGGRAPH Asia Technical
    /// Communications, 2023.
    #[inline]
    pub fn sample_reflecting(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let stretched = self.stretch(wo);
        self.normal_from_cap(stretched, self.cap_bound(wo) * stretched.z, u)
    }

    /// k cos θo + t(wo), by which D(m) / 2 is divided for the density per steradian of the reflection of `wo` at a
    /// normal drawn by [`TrowbridgeReitz::sample_reflecting`].
    #[inline]
    pub fn reflecting_normalization(&self, wo: Vec3) -> f32 {
        self.cap_bound(wo) * wo.z + self.stretched_length(wo)
    }

    /// k, the factor on the height at which the cap of reflections ends: 1 for no cut.
    ///
    /// Eto and Tokuyoshi give it for the smaller α; an α above one is bounded as if it were one.
    #[inline]
    fn cap_bound(&self, wo: Vec3) -> f32 {
        let a = self.alpha_x.min(self.alpha_y).min(1.0);
        let s = 1.0 + safe_sqrt(wo.x * wo.x + wo.y * wo.y);
        let (a2, s2) = (a * a, s * s);
        (1.0 - a2) * s2 / (s2 + a2 * wo.z * wo.z)
    }

    /// `w` in the space in which the microfacets form a hemisphere, as a unit vector.
    #[inline]
    fn stretch(&self, w: Vec3) -> Vec3 {
        Vec3::new(w.x * self.alpha_x, w.y * self.alpha_y, w.z) * (1.0 / self.stretched_length(w))
    }

    /// The normal halfway to a direction uniform in the cap of heights above −`depth`.
    #[inline]
    fn normal_from_cap(&self, stretched: Vec3, depth: f32, u: Vec2) -> Vec3 {
        let z = (1.0 - u.y) * (1.0 + depth) - depth;
        let radius = safe_sqrt(1.0 - z * z);
        let (sin, cos) = warp::sin_cos_turns(u.x);
        let half = stretched + Vec3::new(radius * cos, radius * sin, z);
        let m = Vec3::new(half.x * self.alpha_x, half.y * self.alpha_y, half.z.max(0.0));
        // Only the direction opposite to `stretched`, of probability zero, has no halfway vector.
        let length = m.length();
        if length > 0.0 { m * (1.0 / length) } else { Vec3::Z }
    }
}
