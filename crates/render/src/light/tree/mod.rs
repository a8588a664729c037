//! A tree over lights, from which one is chosen by an estimate of what it contributes at a point.
//!
//! Source: Conty Estevez, Kulla, *Importance Sampling of Many Lights with Adaptive Tree Splitting*, HPG 2018, for the
//! bounds, the measure of orientation and the cost of a split; Pharr, Jakob, Humphreys, *Physically Based Rendering*,
//! 4th ed., 2023, section 12.6.3, for the estimate at a shading point with a normal and for the trails by which the
//! probability of a given light is found. Deviations: a group is bounded by a sphere, which is what the estimate uses,
//! rather than by a box that a sphere is made of at each visit; what counts is radiant intensity rather than power, so
//! that lamps of different kinds compare as the light that arrives; and light from behind an opaque surface counts
//! nothing.
//!
//! Design decision: a node holds the bounds of both its children in one cache line of 64 bytes. At each node the random
//! number is compared with the first child's share and stretched again, so that one number leads to a light. Each light
//! knows its trail, the turns that lead to it, and its probability is the product of shares along it. Estimates err
//! on the safe side: one is zero only where nothing of the group can arrive.
//!
//! Deliberately absent: splitting (sampling both children of a node that is near), and learning from samples.

mod bounds;
mod build;
mod node;

pub(crate) use bounds::{Cone, LightBounds};

use super::select::Vantage;
use node::{Link, Node};

/// The largest number below one.
pub(super) const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// The trail of a light that is not in the tree.
const NO_TRAIL: u64 = 0;

/// Lights with a place, by place, orientation and intensity.
#[derive(Clone, Debug)]
pub(crate) struct LightTree {
    /// The root is the first.
    nodes: Vec<Node>,
    /// By light: the turns from the root, the first in the lowest bit, and a one behind the last.
    trails: Vec<u64>,
}

impl LightTree {
    /// A tree over the given lights, which are numbers below `count`.
    pub(crate) fn new(lights: Vec<(LightBounds, u32)>, count: usize) -> Self {
        let mut tree = Self { nodes: Vec::new(), trails: vec![NO_TRAIL; count] };
        build::build(lights, &mut tree);
        tree
    }

    /// An estimate of what arrives at `from` from all lights; zero only if nothing can.
    #[inline]
    pub(super) fn contribution(&self, from: &Vantage) -> f32 {
        self.nodes.first().map_or(0.0, |root| root.contribution(from))
    }

    /// The light that `u` in [0, 1) chooses for `from`, and its probability; `None` if none can matter there.
    pub(crate) fn choose(&self, from: &Vantage, mut u: f64) -> Option<(u32, f32)> {
        let mut pmf = 1.0;
        let mut node = self.nodes.first()?;
        loop {
            let first = node.first_share(from)?;
            let split = f64::from(first);
            let turn = usize::from(u >= split);
            let (share, start) = if turn == 0 { (split, 0.0) } else { (1.0 - split, split) };
            u = ((u - start) / share).min(BELOW_ONE);
            pmf *= share as f32;
            match node.link(turn) {
                Link::Light(light) => return Some((light, pmf)),
                Link::Node(index) => node = &self.nodes[index as usize],
            }
        }
    }

    /// The probability with which `light` is chosen for `from`; `None` if it is not in the tree.
    pub(crate) fn pmf(&self, from: &Vantage, light: u32) -> Option<f32> {
        let mut trail = *self.trails.get(light as usize).filter(|&&trail| trail != NO_TRAIL)?;
        let mut pmf = 1.0;
        let mut node = self.nodes.first()?;
        loop {
            let Some(first) = node.first_share(from) else { return Some(0.0) };
            let turn = (trail & 1) as usize;
            pmf *= if turn == 0 { first } else { (1.0 - f64::from(first)) as f32 };
            trail >>= 1;
            match node.link(turn) {
                Link::Light(_) => return Some(pmf),
                Link::Node(index) => node = &self.nodes[index as usize],
            }
        }
    }
}

#[cfg(test)]
mod tests;
