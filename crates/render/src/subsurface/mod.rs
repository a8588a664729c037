//! Light that enters a surface at one point and leaves it at another.
//!
//! Design decision: what light does below the surface is a separable function S = C (1 − F(θo)) S(|po − pi|) (1 − F(θi)) of the
//! directions and of the distance between the points. The path refracts into the surface as into glass; instead of following it
//! there, the point where light entered is drawn in proportion to S, by a ray that probes the surface nearby. This is what pbrt-v4's
//! `subsurface` means. A random walk below the surface would know its shape, and give other images.
//!
//! Source: Jensen, Marschner, Levoy, Hanrahan, *A Practical Model for Subsurface Light Transport*, SIGGRAPH 2001; King, Kulla, Conty,
//! Fajardo, *BSSRDF Importance Sampling*, SIGGRAPH Talks 2013; Pharr, Jakob, Humphreys, *Physically Based Rendering*, 3rd ed., 2016,
//! sections 11.4, 15.4 and 15.5. Deviations from pbrt-v4: a point counts for an axis and a lane only if their probe could have
//! reached it, and the lane is drawn anew for each point, so that there is no preference for the first.
//!
//! Deliberately absent: the shape of the surface between the points, and the direction inside.
//!
//! In a scene file: `Material "subsurface" "string name" "Skin1" "float scale" 1000`.

mod spline;
mod table;

use std::f32::consts::TAU;

use sahl_math::{Frame, Vec2, Vec3};

use crate::interaction::Interaction;
use crate::spectrum::Spectrum;
use crate::warp;

pub(crate) use table::DiffusionTable;
use table::Profile;

/// ∫ F(μ) μ dμ, the mean reflectance of an interface of the relative index `eta` for diffuse light, halved.
pub(crate) fn first_moment(eta: f32) -> f32 {
    table::fresnel_moment(eta, 1) as f32
}

/// Share of the light that leaves nearer than probes reach.
const REACH: f32 = 0.999;

/// The probability with which probes follow each axis: the tangents and the normal.
const AXES: [f32; 3] = [0.25, 0.25, 0.5];

const LANES: usize = 4;

/// How light spreads below a point of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bssrdf<'a> {
    po: Vec3,
    frame: Frame,
    /// The index of refraction inside over outside.
    pub(crate) eta: f32,
    lanes: [Lane<'a>; LANES],
}

/// How light of one lane spreads.
#[derive(Clone, Copy, Debug)]
struct Lane<'a> {
    profile: Profile<'a>,
    /// Extinction per unit of length.
    sigma_t: f32,
    effective_albedo: f32,
    /// How far probes reach.
    reach: f32,
}

/// A segment that probes the surface for points at which light may have entered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Probe {
    pub(crate) start: Vec3,
    pub(crate) end: Vec3,
}

impl Lane<'_> {
    /// Light that leaves per area at the distance `r` of where a unit of it entered.
    #[inline]
    fn value(&self, r: f32) -> f32 {
        let optical = r * self.sigma_t;
        let radial = self.profile.radial(optical);
        let around = if optical > 0.0 { TAU * optical } else { 1.0 };
        let value = radial / around * self.sigma_t * self.sigma_t;
        if value.is_finite() { value } else { 0.0 }
    }

    /// The density per area with which distances are drawn, all azimuths alike.
    #[inline]
    fn pdf(&self, r: f32) -> f32 {
        if self.effective_albedo > 0.0 { self.value(r) / self.effective_albedo } else { 0.0 }
    }
}

impl<'a> Bssrdf<'a> {
    /// Below the point `at`, for matter of the given coefficients per unit of length, whose profiles are in `table`.
    pub(crate) fn new(
        at: &Interaction,
        eta: f32,
        table: &'a DiffusionTable,
        [sigma_a, sigma_s]: [Spectrum; 2],
    ) -> Self {
        let sigma_t = (sigma_a + sigma_s).lanes();
        let lanes = std::array::from_fn(|lane| {
            let sigma_t = sigma_t[lane];
            let albedo = if sigma_t > 0.0 { sigma_s.lanes()[lane] / sigma_t } else { 0.0 };
            let profile = table.profile(albedo);
            let effective_albedo = profile.effective_albedo().max(0.0);
            let is_there = sigma_t > 0.0 && effective_albedo > 0.0;
            let reach = if is_there { profile.sample(REACH) / sigma_t } else { 0.0 };
            Lane { profile, sigma_t, effective_albedo, reach }
        });
        Self { po: at.p, frame: Frame::from_z(at.shading.z), eta, lanes }
    }

    /// Draws a probe: `u_choice` chooses axis and lane, `u` the point of the disk that the probe passes.
    ///
    /// `None` where light does not come out, or where the drawn distance is beyond the reach.
    pub(crate) fn probe(&self, u_choice: f32, u: Vec2) -> Option<Probe> {
        let scaled = u_choice * LANES as f32;
        let lane = &self.lanes[(scaled as usize).min(LANES - 1)];
        let axis = match scaled - scaled.floor() {
            u if u < AXES[0] => 0,
            u if u < AXES[0] + AXES[1] => 1,
            _ => 2,
        };
        if lane.reach <= 0.0 {
            return None;
        }
        let r = lane.profile.sample(u.x) / lane.sigma_t;
        let half = sahl_math::safe_sqrt(lane.reach * lane.reach - r * r);
        if half <= 0.0 {
            return None;
        }
        let (sin, cos) = warp::sin_cos_turns(u.y);
        let axes = [self.frame.x, self.frame.y, self.frame.z];
        let [along, across, other] = [axes[axis], axes[(axis + 1) % 3], axes[(axis + 2) % 3]];
        let middle = self.po + (across * cos + other * sin) * r;
        Some(Probe { start: middle - along * half, end: middle + along * half })
    }

    /// The density per area of the surface with which probes meet the point `p` with the geometric normal `n`.
    pub(crate) fn pdf(&self, p: Vec3, n: Vec3) -> f32 {
        let (d, n) = (self.frame.to_local(p - self.po), self.frame.to_local(n));
        let distance = d.length();
        let mut pdf = 0.0;
        for lane in self.lanes.iter().filter(|lane| distance <= lane.reach) {
            pdf += AXES[0] * lane.pdf(d.y.hypot(d.z)) * n.x.abs()
                + AXES[1] * lane.pdf(d.z.hypot(d.x)) * n.y.abs()
                + AXES[2] * lane.pdf(d.x.hypot(d.y)) * n.z.abs();
        }
        pdf / LANES as f32
    }

    /// Light that leaves per area at `p`, for each lane.
    pub(crate) fn value(&self, p: Vec3) -> Spectrum {
        let r = (p - self.po).length();
        Spectrum::from_lanes(self.lanes.map(|lane| lane.value(r)))
    }
}

#[cfg(test)]
mod tests;
