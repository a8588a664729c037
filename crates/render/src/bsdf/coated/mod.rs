//! Surfaces below a coat: plastic, varnish, lacquered metal.
//!
//! Design decision: light walks at random between the interface and the base, which may have any roughness, with
//! scattering matter between them. No formula is known for what comes out; the walk estimates it without bias, and every
//! other property (energy, colour by multiple reflection, darkening of rough coats) follows from the parts.
//!
//! Source: Guo, Hašan, Zhao, *Position-Free Monte Carlo Simulation for Arbitrary Layered BSDFs*, ACM TOG 37(6), 2018;
//! with the choices of pbrt-v4 (Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 14.3): the
//! free path along z has the unit of the coat's thickness, and a coat whose albedo is zero only absorbs. Deviations: the
//! random numbers depend on the place too, so that a pixel in which both directions stay the same converges; and the
//! density has the change of solid angle by refraction in it.
//!
//! Deliberately absent: a base that lets light through, so that both sides of the surface are alike.

mod walk;

use std::f32::consts::FRAC_1_PI;

use sahl_math::{Vec2, Vec3};

use super::dielectric::LobeSample;
use super::{BsdfSample, Conductor, Dielectric, Diffuse, Reach, Scatter, ScatterKind, fresnel};
use crate::medium::HenyeyGreenstein;
use crate::mis::power_heuristic;
use crate::spectrum::Spectrum;
use crate::warp::UNIFORM_SPHERE_PDF;
use walk::{Random, transmittance};

/// The layer over a base: an interface, and matter below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// The interface to the outside.
    pub surface: Dielectric,
    /// Depth of the matter, in mean free paths.
    pub thickness: f32,
    /// Mean cosine of scattering in the matter.
    pub g: f32,
    /// Share of light that the matter scatters, where it does not absorb.
    pub albedo: Spectrum,
    /// Steps of a walk.
    pub max_depth: u32,
    /// Walks of an evaluation.
    pub samples: u32,
    /// Whether walks weigh as pbrt-v4's do, whose coats are too bright: [`sahl_scene::Quirks::bright_coats`].
    pub is_bright: bool,
}

/// A base below a [`Coat`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coated<B> {
    coat: Coat,
    base: B,
    /// A hash of the place, of which random numbers are made.
    place: u64,
}

/// Lambertian reflection below a coat.
///
/// In a scene file: `Material "coateddiffuse" "rgb reflectance" [.1 .3 .6] "float roughness" .03`.
pub type CoatedDiffuse = Coated<Diffuse>;

/// A metal below a coat; its index is relative to that of the coat.
///
/// In a scene file: `Material "coatedconductor" "float interface.roughness" .01 "float conductor.roughness" .3`.
pub type CoatedConductor = Coated<Conductor>;

/// The share of the density that is uniform over the hemisphere, for what the estimate does not find.
const UNIFORM_SHARE: f32 = 0.1;

/// From this step on, walks end at random once their weight is below [`DIM`].
const SURE_STEPS: u32 = 4;
/// See [`SURE_STEPS`].
const DIM: f32 = 0.25;

/// A walk between base and interface.
struct Walk {
    /// f |cos θ| / pdf of what happened so far.
    throughput: Spectrum,
    /// Height above the base.
    z: f32,
    /// Where the walk goes.
    w: Vec3,
}

/// What happens next to a walk.
enum Event {
    Interface,
    Base,
    /// Scattering in the matter.
    Matter,
    /// Nothing: the step is lost in rounding.
    Nowhere,
}

/// Where a walk is wanted to come out, and a direction inside that leads there.
struct Target {
    wi: Vec3,
    /// Drawn by refraction from `wi`; its weight is that of importance, which is not compressed.
    inside: LobeSample,
}

impl Target {
    /// f |cos θi| / pdf from inside to the target, by the direction that leads there, over the cosine of the latter.
    #[inline]
    fn weight(&self) -> f32 {
        self.inside.weight / self.inside.wi.z.abs() * self.wi.z
    }
}

impl<B> Coated<B> {
    /// `base` below `coat`, at a point of which `place` is a hash.
    pub fn new(coat: Coat, base: B, place: u64) -> Self {
        let thickness = if coat.thickness > 0.0 { coat.thickness.min(f32::MAX) } else { 0.0 };
        let g = if coat.g.is_nan() { 0.0 } else { coat.g.clamp(-0.99, 0.99) };
        Self { coat: Coat { thickness, g, albedo: coat.albedo.clamp(0.0, 1.0), ..coat }, base, place }
    }
}

#[expect(private_bounds, reason = "the bound is the contract among the kinds of this module")]
impl<B: Scatter> Coated<B> {
    /// Whether the matter scatters.
    #[inline]
    fn is_turbid(&self) -> bool {
        !self.coat.albedo.is_zero() && self.coat.thickness > 0.0
    }

    /// f |cos θi| of light that passed the interface, by one walk from `wo` to `wi`, both above.
    fn walk_between(&self, wo: Vec3, wi: Vec3, random: &mut Random) -> Spectrum {
        let surface = &self.coat.surface;
        let mut sum = Spectrum::ZERO;
        let Some(entry) = surface.sample_lobe(wo, true, random.next_2d()) else { return sum };
        let Some(mut inside) = surface.sample_lobe(wi, true, random.next_2d()) else { return sum };
        inside.weight *= surface.eta() * surface.eta();
        let target = Target { wi, inside };
        let mut walk =
            Walk { throughput: Spectrum::splat(entry.weight), z: self.coat.thickness, w: entry.wi };
        for step in 0..self.coat.max_depth {
            if !goes_on(&mut walk.throughput, step, random) || walk.w.z == 0.0 {
                break;
            }
            match self.advance(&mut walk, random) {
                Event::Nowhere => {}
                Event::Matter => sum += self.scatter(&mut walk, &target, random),
                Event::Base => sum += self.reflect(&mut walk, &target, random),
                Event::Interface => {
                    let Some(back) = surface.sample_lobe(-walk.w, false, random.next_2d()) else { break };
                    walk.throughput *= back.weight;
                    walk.w = back.wi;
                }
            }
        }
        sum
    }

    /// Goes to the next boundary or scattering.
    #[inline]
    fn advance(&self, walk: &mut Walk, random: &mut Random) -> Event {
        let thickness = self.coat.thickness;
        let (boundary, event) =
            if walk.w.z > 0.0 { (thickness, Event::Interface) } else { (0.0, Event::Base) };
        if !self.is_turbid() {
            walk.throughput *= transmittance(thickness, walk.w);
            walk.z = boundary;
            return event;
        }
        let z = walk.z - (-random.next_1d()).ln_1p() * walk.w.z;
        if z == walk.z {
            return Event::Nowhere;
        }
        if z > 0.0 && z < thickness {
            walk.z = z;
            return Event::Matter;
        }
        walk.z = boundary;
        event
    }

    /// Scatters in the matter; gives the light that leaves at the target by it.
    fn scatter(&self, walk: &mut Walk, target: &Target, random: &mut Random) -> Spectrum {
        let Coat { surface, thickness, g, albedo, .. } = &self.coat;
        let (height, inside) = (thickness - walk.z, &target.inside);
        walk.throughput *= *albedo;
        // By the direction that leads to the target.
        let (phase, wo) = (HenyeyGreenstein::new(*g), -walk.w);
        let density = phase.eval(wo, -inside.wi);
        let weight = if surface.is_specular() { 1.0 } else { power_heuristic(inside.pdf, density) };
        let mut found = weight * density * target.weight() * transmittance(height, inside.wi);
        // By one that the phase function draws.
        let scattered = phase.sample(wo, random.next_2d());
        let w = scattered.wi;
        if w.z > 0.0 && !surface.is_specular() {
            let weight = power_heuristic(scattered.pdf, self.exit_pdf(target.wi, w));
            let leaving = surface.eval(-w, target.wi).max_component();
            found += weight * leaving * transmittance(height, w);
        }
        let sum = walk.throughput * found;
        walk.w = w;
        sum
    }

    /// Reflects at the base; gives the light that leaves at the target by it. The walk may end there, black.
    fn reflect(&self, walk: &mut Walk, target: &Target, random: &mut Random) -> Spectrum {
        let Coat { surface, thickness, .. } = &self.coat;
        let (wo, inside) = (-walk.w, &target.inside);
        let mut sum = Spectrum::ZERO;
        // By the direction that leads to the target.
        if !self.base.is_specular() {
            let weight = if surface.is_specular() {
                1.0
            } else {
                power_heuristic(inside.pdf, self.base.pdf(wo, -inside.wi))
            };
            let through = weight * target.weight() * transmittance(*thickness, inside.wi);
            sum += walk.throughput * self.base.eval(wo, -inside.wi) * through;
        }
        // By one that the base draws.
        let (u_lobe, u) = (random.next_1d(), random.next_2d());
        let Some(sample) = self.base.sample(wo, u_lobe, u) else {
            walk.throughput = Spectrum::ZERO;
            return sum;
        };
        walk.throughput *= sample.weight;
        walk.w = sample.wi;
        if !surface.is_specular() {
            let weight = if sample.kind.is_specular() {
                1.0
            } else {
                power_heuristic(sample.pdf, self.exit_pdf(target.wi, walk.w))
            };
            let leaving = surface.eval(-walk.w, target.wi).max_component();
            sum += walk.throughput * (weight * leaving * transmittance(*thickness, walk.w));
        }
        sum
    }

    /// What a direction `w` that leads to the exit `wi` weighs against: the density with which `wi` would have led to it.
    /// pbrt-v4 takes that of the opposite way.
    #[inline]
    fn exit_pdf(&self, wi: Vec3, w: Vec3) -> f32 {
        let surface = &self.coat.surface;
        if self.coat.is_bright { surface.lobe_pdf(-w, wi) } else { surface.lobe_pdf(wi, -w) }
    }

    /// A density of `wi`, both above, for light that passes the interface, is reflected once and passes it again. What is
    /// reflected inside is left out, so that it integrates to less than one.
    fn density_below(&self, wo: Vec3, wi: Vec3, random: &mut Random) -> f32 {
        let surface = &self.coat.surface;
        let Some(entry) = surface.sample_lobe(wo, true, random.next_2d()) else { return 0.0 };
        let inside = surface.sample_lobe(wi, true, random.next_2d());
        let wo = -entry.wi;
        let mut density = 0.0;
        if let Some(inside) = inside {
            let by_base = self.base.pdf(wo, -inside.wi);
            // How much more often the interface leads outward here than it led inward.
            density += if surface.is_specular() {
                by_base * wi.z / (surface.eta() * surface.eta() * inside.wi.z.abs())
            } else {
                let ratio = surface.lobe_pdf(inside.wi, wi) / inside.pdf;
                power_heuristic(inside.pdf, by_base) * by_base * ratio
            };
        }
        let (u_lobe, u) = (random.next_1d(), random.next_2d());
        if !surface.is_specular()
            && let Some(sample) = self.base.sample(wo, u_lobe, u)
        {
            let weight = if sample.kind.is_specular() {
                1.0
            } else {
                power_heuristic(sample.pdf, surface.lobe_pdf(wi, -sample.wi))
            };
            density += weight * surface.lobe_pdf(-sample.wi, wi);
        }
        entry.share * density
    }

    /// What pbrt-v4 takes for the density of `wi`. It is not normalised, and only divides the work between ways to find light; where
    /// values are too bright it also says how much of that is seen.
    fn bright_pdf(&self, wo: Vec3, wi: Vec3, random: &mut Random) -> f32 {
        let surface = &self.coat.surface;
        let reflected = surface.lobe_pdf(wo, wi);
        let Some(entry) = surface.sample_lobe(wo, true, random.next_2d()) else { return reflected };
        let Some(inside) = surface.sample_lobe(wi, true, random.next_2d()) else { return reflected };
        let wo = -entry.wi;
        if surface.is_specular() {
            return reflected + self.base.pdf(wo, -inside.wi);
        }
        let (u_lobe, u) = (random.next_1d(), random.next_2d());
        let Some(sample) = self.base.sample(wo, u_lobe, u) else { return reflected };
        let leaving = surface.pdf(-sample.wi, wi);
        if sample.kind.is_specular() {
            return reflected + leaving;
        }
        let by_base = self.base.pdf(wo, -inside.wi);
        reflected
            + power_heuristic(inside.pdf, by_base) * by_base
            + power_heuristic(sample.pdf, leaving) * leaving
    }

    /// The walk of a sample that passed the interface.
    fn walk_out(&self, wo: Vec3, first: &BsdfSample, random: &mut Random) -> Option<BsdfSample> {
        let mut walk = Walk { throughput: first.weight, z: self.coat.thickness, w: first.wi };
        let (mut pmf, mut is_specular) = (first.pdf, first.kind.is_specular());
        for step in 0..self.coat.max_depth {
            if !goes_on(&mut walk.throughput, step, random) || walk.w.z == 0.0 {
                return None;
            }
            let event = self.advance(&mut walk, random);
            let (u_lobe, u) = (random.next_1d(), random.next_2d());
            let sample = match event {
                Event::Nowhere => continue,
                Event::Matter => {
                    walk.throughput *= self.coat.albedo;
                    walk.w = HenyeyGreenstein::new(self.coat.g).sample(-walk.w, u).wi;
                    is_specular = false;
                    continue;
                }
                Event::Base => self.base.sample(-walk.w, u_lobe, u)?,
                Event::Interface => self.coat.surface.sample(-walk.w, u_lobe, u)?,
            };
            walk.throughput *= sample.weight;
            walk.w = sample.wi;
            pmf *= sample.pdf;
            is_specular &= sample.kind.is_specular();
            if sample.kind.is_transmission() {
                let (pdf, kind) = if is_specular {
                    (pmf, ScatterKind::SPECULAR_REFLECTION)
                } else {
                    (self.pdf(wo, walk.w), ScatterKind::GLOSSY_REFLECTION)
                };
                return (pdf > 0.0 && pdf.is_finite() && walk.throughput.is_finite()).then_some(BsdfSample {
                    wi: walk.w,
                    weight: walk.throughput,
                    pdf,
                    kind,
                    eta: 1.0,
                });
            }
        }
        None
    }
}

/// Ends a walk at random if it is dim, and makes up for that if it goes on.
#[inline]
fn goes_on(throughput: &mut Spectrum, step: u32, random: &mut Random) -> bool {
    let brightness = throughput.max_component();
    if step >= SURE_STEPS && brightness < DIM {
        if random.next_1d() >= brightness {
            return false;
        }
        *throughput = *throughput / brightness;
    }
    brightness > 0.0
}

/// Both directions turned about the surface such that `wo` is above; `None` unless `wi` then is, too.
#[inline]
fn above(wo: Vec3, wi: Vec3) -> Option<(Vec3, Vec3)> {
    if wo.z * wi.z <= 0.0 {
        return None;
    }
    Some(if wo.z < 0.0 { (-wo, -wi) } else { (wo, wi) })
}

impl<B: Scatter> Scatter for Coated<B> {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        let Some((wo, wi)) = above(wo, wi) else { return Spectrum::ZERO };
        let mut random = Random::new(self.place, wo, wi);
        let mut sum = Spectrum::ZERO;
        for _ in 0..self.coat.samples {
            sum += self.walk_between(wo, wi, &mut random);
        }
        self.coat.surface.eval(wo, wi) + sum / self.coat.samples.max(1) as f32
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let Some((wo, wi)) = above(wo, wi) else { return 0.0 };
        if self.is_specular() {
            return 0.0;
        }
        // Numbers of their own: the weight of a strategy must not depend on the noise of what it weighs.
        let mut random = Random::new(self.place, wi, wo);
        if self.coat.is_bright {
            let found: f32 = (0..self.coat.samples).map(|_| self.bright_pdf(wo, wi, &mut random)).sum();
            let uniform = UNIFORM_SHARE * UNIFORM_SPHERE_PDF;
            return (1.0 - UNIFORM_SHARE) * found / self.coat.samples.max(1) as f32 + uniform;
        }
        let below: f32 = (0..self.coat.samples).map(|_| self.density_below(wo, wi, &mut random)).sum();
        let found = self.coat.surface.pdf(wo, wi) + below / self.coat.samples.max(1) as f32;
        (1.0 - UNIFORM_SHARE) * found + UNIFORM_SHARE * (wi.z * FRAC_1_PI)
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let flip = wo.z < 0.0;
        let wo = if flip { -wo } else { wo };
        let first = self.coat.surface.sample(wo, u_lobe, u)?;
        let mut sample = if first.kind.is_transmission() {
            let mut random = Random::new(self.place, wo, Vec3::new(u_lobe, u.x, u.y));
            self.walk_out(wo, &first, &mut random)?
        } else if first.kind.is_specular() {
            first
        } else {
            BsdfSample { pdf: self.pdf(wo, first.wi), ..first }
        };
        if flip {
            sample.wi = -sample.wi;
        }
        Some(sample)
    }

    #[inline]
    fn is_specular(&self) -> bool {
        self.coat.surface.is_specular() && self.base.is_specular() && !self.is_turbid()
    }

    #[inline]
    fn reach(&self) -> Reach {
        Reach::OneSide
    }

    #[inline]
    fn albedo(&self, wo: Vec3) -> Spectrum {
        let reflected = fresnel::dielectric(wo.z.abs(), self.coat.surface.eta()).reflectance;
        self.base.albedo(wo) * (1.0 - reflected) + reflected
    }

    #[inline]
    fn is_stochastic(&self) -> bool {
        true
    }
}
