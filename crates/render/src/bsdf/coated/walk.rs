//! What walks through a coat need: random numbers, and how light gets on between interface and base.

use sahl_math::{Vec2, Vec3};

use crate::sampler::hash::{GOLDEN_STEP, mix, to_unit};

/// Random numbers by counting and mixing, from a start that is a hash of what the walk is for.
pub(super) struct Random(u64);

impl Random {
    /// The numbers that belong to `place` and the directions `first` and `second`, in this order.
    pub(super) fn new(place: u64, first: Vec3, second: Vec3) -> Self {
        let absorb = |state: u64, w: Vec3| {
            let [x, y, z] = <[f32; 3]>::from(w).map(|x| u64::from(x.to_bits()));
            mix(mix(state ^ (x << 32 | y)).wrapping_add(z))
        };
        Self(absorb(absorb(place, first), second))
    }

    #[inline]
    pub(super) fn next_1d(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(GOLDEN_STEP);
        to_unit((mix(self.0) >> 32) as u32)
    }

    #[inline]
    pub(super) fn next_2d(&mut self) -> Vec2 {
        Vec2::new(self.next_1d(), self.next_1d())
    }
}

/// The share of light that crosses the depth `dz` along `w`, in units of the mean free path.
#[inline]
pub(super) fn transmittance(dz: f32, w: Vec3) -> f32 {
    (-(dz / w.z).abs()).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_depend_on_all_they_are_for() {
        let (a, b) = (Vec3::X, Vec3::new(0.6, 0.0, 0.8));
        let first = |place, a, b| Random::new(place, a, b).next_1d();
        assert_eq!(first(1, a, b), first(1, a, b));
        assert!(first(1, a, b) != first(2, a, b) && first(1, a, b) != first(1, b, a));
    }
}
