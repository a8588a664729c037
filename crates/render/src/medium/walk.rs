//! Walks from one tentative collision to the next.

use sahl_math::Vec3;

use super::{Properties, Way};
use crate::sampler::Stream;
use crate::spectrum::Spectrum;

/// A part of a way over which the majorant is constant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// Its ends, in metres along the way.
    pub(super) from: f32,
    pub(super) to: f32,
    /// A bound of σₐ + σₛ, per metre.
    pub(super) majorant: Spectrum,
}

/// A point where light may have met matter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Collision {
    /// Where.
    pub(crate) p: Vec3,
    /// What is there.
    pub(crate) properties: Properties,
    /// The majorant there.
    pub(crate) majorant: Spectrum,
    /// Majorant transmittance from the last collision, or from the start, to this one.
    pub(crate) transmittance: Spectrum,
    /// A number in [0, 1) by which to decide what happens.
    pub(crate) u: f32,
}

/// What comes after a collision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// The next one.
    Walk,
    /// Nothing.
    Stop,
}

/// exp(−σ d), for a length that may be infinite.
#[inline]
pub(super) fn passed(sigma: Spectrum, length: f32) -> Spectrum {
    // Where nothing is, any length is passed: zero times the largest number is zero.
    (sigma * -length.min(f32::MAX)).exp()
}

/// Visits tentative collisions along `stretches`, which follow each other, until one says stop.
///
/// Distances d have the density σ exp(−σ d) with σ the hero's majorant. A stretch that is passed without a collision leaves
/// the exponential distribution without memory, and the next one starts afresh. See [`super::Medium::walk`].
#[inline]
pub(super) fn walk(
    way: &Way,
    u: f32,
    stream: &mut Stream,
    stretches: impl Iterator<Item = Stretch>,
    properties: impl Fn(Vec3) -> Properties,
    mut visit: impl FnMut(&Collision) -> Next,
) -> Spectrum {
    let mut transmittance = Spectrum::ONE;
    let mut u = u;
    for Stretch { mut from, to, majorant } in stretches {
        let rate = majorant.lanes()[way.hero];
        // Where the hero meets nothing, nothing is met.
        loop {
            let t = from - (1.0 - u).ln() / rate;
            u = stream.next_1d();
            if rate == 0.0 || t >= to {
                break;
            }
            let p = way.ray.at(t);
            let collision = Collision {
                p,
                properties: properties(p),
                majorant,
                transmittance: transmittance * passed(majorant, t - from),
                u: stream.next_1d(),
            };
            if visit(&collision) == Next::Stop {
                return Spectrum::ONE;
            }
            transmittance = Spectrum::ONE;
            from = t;
        }
        transmittance *= passed(majorant, to - from);
    }
    transmittance
}
