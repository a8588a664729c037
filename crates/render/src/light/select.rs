//! The choice of one light among many.
//!
//! Design decision: a choice is made from a [`Vantage`], the point that is lit with what is known of its orientation, and
//! [`LightSelection::pmf`] tells the probability of that choice for a light that was found otherwise. Few lights with a
//! place, and scenes that ask for it, are chosen from one table, which is the same everywhere. Many are chosen by a tree that
//! estimates how much of each group arrives at the vantage. What is infinitely far away stands beside the tree, as
//! [`infinite`](super::infinite) tells: power says nothing of its share, since it grows with the scene.
//!
//! Deliberately absent: visibility. A light behind a wall is chosen as if the wall were not there.
//!
//! In a scene file: `Integrator "path" "string lightsampler" "bvh"`, which is the default, `"power"`, or `"uniform"`.

use sahl_math::{Vec3, offset_ray_origin};
use sahl_scene::LightSampler;

use super::infinite::InfiniteLights;
use super::tree::{BELOW_ONE, LightTree};
use crate::bsdf::Reach;
use crate::distribution::AliasTable;
use crate::interaction::Interaction;
use crate::light::{ChosenBy, Light};
use crate::sampler::mix;
use crate::spectrum::Wavelengths;

/// Up to this many lights one table serves as well as a tree, and costs a tenth.
const MOST_IN_TABLE: usize = 4;

/// How lights are chosen for direct lighting.
#[derive(Clone, Debug)]
pub(crate) enum LightSelection {
    /// With the same probabilities at every point.
    Table(AliasTable),
    /// By the light that arrives.
    Tree(Box<TreeSelection>),
}

/// A tree, and what stands beside it.
#[derive(Clone, Debug)]
pub(crate) struct TreeSelection {
    tree: LightTree,
    infinite: InfiniteLights,
}

/// A light and the probability with which it was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightChoice {
    pub(crate) light: u32,
    pub(crate) pmf: f32,
}

/// A point that is to be lit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vantage {
    pub(crate) p: Vec3,
    pub(crate) facing: Facing,
}

/// From which directions light matters at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Facing {
    /// From all alike: a point of a medium or of a fibre.
    All,
    /// From the side of this unit normal, by the cosine.
    Side(Vec3),
    /// From both sides of a surface of this unit normal, by the cosine.
    Sides(Vec3),
}

impl Vantage {
    /// A point of a surface that is seen along `wo` and scatters light with the given reach.
    ///
    /// A surface of one side looks for light from where its rays start, so that sampling a light and scattering find the same. For
    /// curves these are up to 1.7 widths from the point that was hit. Which side it will be is not known yet for the others, nor where
    /// leaky normals send rays through the surface, which pbrt-v4 accepts too.
    #[inline]
    pub(crate) fn on_surface(at: &Interaction, wo: Vec3, reach: Reach) -> Self {
        match reach {
            Reach::OneSide => Self {
                p: offset_ray_origin(at.p, at.p_error, at.ng, wo),
                facing: Facing::Side(at.shading.z.face_forward(wo)),
            },
            Reach::BothSides => Self { p: at.p, facing: Facing::Sides(at.shading.z) },
            Reach::Everywhere => Self { p: at.p, facing: Facing::All },
        }
    }

    /// A point in space, without a surface.
    #[inline]
    pub(crate) fn in_space(p: Vec3) -> Self {
        Self { p, facing: Facing::All }
    }
}

impl LightSelection {
    /// The selection that a scene asks for, whose surfaces lie in a sphere of the given radius.
    ///
    /// Lights without power are never chosen. Neither are environments of one radiance: sampling the BSDF finds them at
    /// least as well, because it knows the cosine, and they have no structure to look for.
    pub(crate) fn new(sampler: LightSampler, lights: &[Light], scene_radius: f32) -> Self {
        let power = |light: &Light| match light {
            Light::Uniform(_) => 0.0,
            _ => light.power(scene_radius, &Wavelengths::default()).average(),
        };
        let weights: Vec<f32> = lights.iter().map(power).collect();
        let candidates = || lights.iter().zip(&weights).filter(|&(_, &weight)| weight > 0.0);
        // What is infinitely far away has a power that can be compared with no other, nor with that of its like.
        let comparable = candidates().all(|(light, _)| light.bounds().is_some());
        match sampler {
            LightSampler::Tree if candidates().count() > MOST_IN_TABLE || !comparable => {
                Self::Tree(Box::new(TreeSelection::new(lights, &weights)))
            }
            LightSampler::Tree | LightSampler::Power => Self::from_weights(&weights),
            LightSampler::Uniform => {
                let alike = |&weight: &f32| if weight > 0.0 { 1.0 } else { 0.0 };
                Self::from_weights(&weights.iter().map(alike).collect::<Vec<f32>>())
            }
        }
    }

    /// A choice in proportion to `weights`, one a light: none at all if they are all zero.
    fn from_weights(weights: &[f32]) -> Self {
        let any = weights.iter().any(|&weight| weight > 0.0);
        Self::Table(AliasTable::new(if any { weights } else { &[] }))
    }

    /// The light that `u` in [0, 1) chooses for `from`; `None` if none can matter there.
    #[inline]
    pub(crate) fn choose(&self, from: &Vantage, u: f32) -> Option<LightChoice> {
        match self {
            Self::Table(table) if table.len() <= MOST_IN_TABLE => Self::look_up(table, f64::from(u)),
            Self::Table(table) => Self::look_up(table, refined(u, from.p)),
            Self::Tree(selection) => selection.choose(from, refined(u, from.p)),
        }
    }

    #[inline]
    fn look_up(table: &AliasTable, u: f64) -> Option<LightChoice> {
        let (light, pmf, _) = table.sample(u)?;
        Some(LightChoice { light: light as u32, pmf })
    }

    /// The probability with which `light` is chosen for `from`.
    #[inline]
    pub(crate) fn pmf(&self, from: &Vantage, light: u32) -> f32 {
        match self {
            Self::Table(table) => table.pmf(light as usize),
            Self::Tree(selection) => selection.pmf(from, light),
        }
    }

    /// Whether no light can be chosen.
    pub(crate) fn is_empty(&self) -> bool {
        match self {
            Self::Table(table) => table.is_empty(),
            // Trees are for many lights.
            Self::Tree(_) => false,
        }
    }
}

impl TreeSelection {
    /// A selection among the lights with a positive weight.
    fn new(lights: &[Light], weights: &[f32]) -> Self {
        let mut bounded = Vec::new();
        let mut infinite = Vec::new();
        for ((index, light), &weight) in (0_u32..).zip(lights).zip(weights) {
            if weight > 0.0 {
                match light.chosen_by() {
                    ChosenBy::Place(bounds) => bounded.push((bounds, index)),
                    ChosenBy::Strength(strength) => infinite.push((strength, index)),
                }
            }
        }
        Self { tree: LightTree::new(bounded, lights.len()), infinite: InfiniteLights::new(infinite) }
    }

    // Out of line, so that scenes of few lights keep it out of their loops.
    #[inline(never)]
    fn choose(&self, from: &Vantage, u: f64) -> Option<LightChoice> {
        if self.infinite.is_empty() {
            return self.tree.choose(from, u).map(|(light, pmf)| LightChoice { light, pmf });
        }
        let shares = self.infinite.shares(from, self.tree.contribution(from));
        if u >= shares.beside {
            let (light, pmf) = self.infinite.choose(from, &shares, u - shares.beside)?;
            return Some(LightChoice { light, pmf });
        }
        let (light, within) = self.tree.choose(from, (u / shares.beside).min(BELOW_ONE))?;
        Some(LightChoice { light, pmf: shares.beside as f32 * within })
    }

    #[inline(never)]
    fn pmf(&self, from: &Vantage, light: u32) -> f32 {
        if self.infinite.is_empty() {
            return self.tree.pmf(from, light).unwrap_or(0.0);
        }
        let shares = self.infinite.shares(from, self.tree.contribution(from));
        match self.tree.pmf(from, light) {
            Some(pmf) => shares.beside as f32 * pmf,
            None => self.infinite.pmf(from, &shares, light),
        }
    }
}

/// A number in [0, 1) that begins with the 24 bits of `u` and goes on with bits hashed from `u` and `p`.
///
/// The 24 bits of a coordinate are used up by the choice among some million lights: the last of them would be chosen
/// more or less often than they should, or never. What follows needs not be stratified, only uniform from point to point.
#[inline]
fn refined(u: f32, p: Vec3) -> f64 {
    const STEPS: f64 = (1_u32 << 24) as f64;
    let key = |a: f32, b: f32| u64::from(a.to_bits()) << 32 | u64::from(b.to_bits());
    let bits = mix(mix(key(u, p.x)) ^ key(p.y, p.z));
    // 29 more bits make 53, the width of the mantissa.
    let fraction = (bits >> 35) as f64 * (1.0 / (1_u64 << 29) as f64);
    ((f64::from(u) * STEPS).floor() + fraction) * (1.0 / STEPS)
}
