//! The choice of lights that are infinitely far away, beside those that have a place.
//!
//! Design decision: half of the choices are made in proportion to what is expected to arrive at the vantage, the other half falls on all
//! alike, where lights with a place count as one. The first half is right where nothing stands in the way; the second bounds what it
//! costs where something does: no light's share is less than half of what chance would give it, so that its noise is at most doubled,
//! be it a lamp in a room beside which the sun would be a thousand times as bright.
//!
//! A sky counts by what is sampled of it: what it has above its mean, which BSDF samples do not find as well.
//!
//! Deliberately absent: a tree. Few scenes have more than some such lights, and all of them are looked at for each choice.

use sahl_math::Vec3;

use super::select::{Facing, Vantage};

/// How much a light that is infinitely far away gives.
#[derive(Clone, Copy, Debug)]
pub(super) enum Strength {
    /// Irradiance on a surface that faces the light, and the unit direction toward it.
    Parallel(f32, Vec3),
    /// ∫ L dω over all directions.
    AllRound(f32),
}

/// Lights that are infinitely far away.
#[derive(Clone, Debug)]
pub(super) struct InfiniteLights {
    /// By number.
    lights: Box<[(Strength, u32)]>,
}

/// How choices are divided at a vantage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shares {
    /// That of the lights which have a place.
    pub(super) beside: f64,
    /// What is due to each candidate, and to each unit of what is expected to arrive.
    each: f64,
    per_unit: f64,
}

impl Strength {
    /// What is expected to arrive: irradiance on a surface, with the mean over its orientations where light comes from many directions.
    ///
    /// Finite and not negative.
    #[inline]
    fn expected(&self, facing: &Facing) -> f64 {
        let expected = match (self, facing) {
            (Self::Parallel(irradiance, _), Facing::All) => *irradiance,
            (Self::Parallel(irradiance, wi), Facing::Side(n)) => irradiance * n.dot(*wi),
            (Self::Parallel(irradiance, wi), Facing::Sides(n)) => irradiance * n.dot(*wi).abs(),
            (Self::AllRound(fluence), Facing::All) => *fluence,
            (Self::AllRound(fluence), Facing::Side(_)) => 0.25 * fluence,
            (Self::AllRound(fluence), Facing::Sides(_)) => 0.5 * fluence,
        };
        if expected > 0.0 { f64::from(expected.min(f32::MAX)) } else { 0.0 }
    }
}

impl InfiniteLights {
    /// Lights by their numbers, in order.
    pub(super) fn new(lights: Vec<(Strength, u32)>) -> Self {
        Self { lights: lights.into() }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// The shares at `from`, where `beside` is expected to arrive from lights that have a place.
    #[inline]
    pub(super) fn shares(&self, from: &Vantage, beside: f32) -> Shares {
        let beside = f64::from(beside.max(0.0));
        let is_candidate = |expected: f64| if expected > 0.0 { 1.0 } else { 0.0 };
        let (mut sum, mut count) = (beside, is_candidate(beside));
        for (strength, _) in &self.lights {
            let expected = strength.expected(&from.facing);
            sum += expected;
            count += is_candidate(expected);
        }
        let mut shares = Shares { beside: 0.0, each: 0.5 / count, per_unit: 0.5 / sum };
        shares.beside = shares.of(beside);
        shares
    }

    /// The light that `u` chooses, a number between zero and the sum of these lights' shares, and its probability.
    #[inline]
    pub(super) fn choose(&self, from: &Vantage, shares: &Shares, mut u: f64) -> Option<(u32, f32)> {
        let mut last = None;
        for (strength, light) in &self.lights {
            let share = shares.of(strength.expected(&from.facing));
            if share > 0.0 {
                last = Some((*light, share as f32));
                if u < share {
                    break;
                }
                u -= share;
            }
        }
        last
    }

    /// The probability with which `light` is chosen; zero if it is not among these.
    #[inline]
    pub(super) fn pmf(&self, from: &Vantage, shares: &Shares, light: u32) -> f32 {
        let Ok(place) = self.lights.binary_search_by_key(&light, |&(_, light)| light) else { return 0.0 };
        let (strength, _) = self.lights[place];
        shares.of(strength.expected(&from.facing)) as f32
    }
}

impl Shares {
    /// That of a candidate from which `expected` is expected to arrive.
    #[inline]
    fn of(&self, expected: f64) -> f64 {
        if expected > 0.0 { self.each + expected * self.per_unit } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use sahl_math::Bounds3;

    use super::*;
    use crate::light::tree::{LightBounds, LightTree};

    const UP: Facing = Facing::Side(Vec3::Z);

    fn at(p: Vec3, facing: Facing) -> Vantage {
        Vantage { p, facing }
    }

    #[test]
    fn half_of_the_choices_follow_what_arrives_and_none_is_left_out() {
        let lights =
            [Strength::Parallel(6.0, Vec3::Z), Strength::AllRound(8.0), Strength::Parallel(9.0, -Vec3::Z)];
        let lights = InfiniteLights::new(lights.into_iter().zip(0..).collect());
        let from = at(Vec3::ZERO, UP);
        // Irradiances 6, 2, none from below, and 8 beside.
        let shares = lights.shares(&from, 8.0);
        let found = [0, 1, 2, 3].map(|light| lights.pmf(&from, &shares, light));
        let due = |expected: f32| 0.5 / 3.0 + 0.5 * expected / 16.0;
        for (found, expected) in found.into_iter().zip([due(6.0), due(2.0), 0.0, 0.0]) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        assert!((shares.beside as f32 - due(8.0)).abs() < 1e-6);
        // A sun a million times as bright leaves the others a sixth each.
        let shares =
            InfiniteLights::new(vec![(Strength::Parallel(1e7, Vec3::Z), 0), (Strength::AllRound(1.0), 1)]);
        let due = shares.shares(&from, 1.0).beside;
        assert!((due - 1.0 / 6.0).abs() < 1e-6, "{due}");
    }

    #[test]
    fn numbers_that_are_none_choose_nothing() {
        let lights = InfiniteLights::new(vec![(Strength::Parallel(1.0, Vec3::Z), 5)]);
        for facing in [Facing::Sides(Vec3::splat(f32::NAN)), Facing::Side(-Vec3::Z)] {
            let from = at(Vec3::ZERO, facing);
            let shares = lights.shares(&from, f32::NAN);
            assert_eq!(lights.choose(&from, &shares, 0.5), None);
            assert_eq!((shares.beside, lights.pmf(&from, &shares, 5)), (0.0, 0.0));
        }
        let largest = InfiniteLights::new(vec![(Strength::AllRound(f32::INFINITY), 0)]);
        let from = at(Vec3::ZERO, UP);
        let shares = largest.shares(&from, f32::MAX);
        assert!(largest.choose(&from, &shares, 0.2).is_some_and(|(_, pmf)| (pmf - 0.5).abs() < 1e-3));
    }

    #[test]
    fn a_lamp_counts_by_what_it_gives_and_not_by_the_size_of_the_scene() {
        // A lamp of 1 m² and 30 W/(m² sr), 2 m above the place; a sky that gives a tenth of that.
        let lamp = LightBounds {
            bounds: Bounds3::from_points([Vec3::new(-0.5, -0.5, 2.0), Vec3::new(0.5, 0.5, 2.0)]),
            facing: crate::light::Cone::of(-Vec3::Z),
            cos_reach: 0.0,
            two_sided: false,
            intensity: 30.0,
        };
        let tree = LightTree::new(vec![(lamp, 0)], 2);
        let sky = InfiniteLights::new(vec![(Strength::AllRound(3.0), 1)]);
        let share = |p: Vec3| {
            let from = at(p, UP);
            sky.shares(&from, tree.contribution(&from)).beside
        };
        assert!(share(Vec3::ZERO) > 0.7, "{}", share(Vec3::ZERO));
        // A hundred metres away it gives next to nothing, and keeps the half of a half.
        assert!((share(Vec3::X * 100.0) - 0.25).abs() < 0.01, "{}", share(Vec3::X * 100.0));
        assert_eq!(share(Vec3::Z * 5.0), 0.0);
    }
}
