//! The mixture of what is there when the shutter opens and what is there when it closes.

use sahl_math::Vec3;

use crate::kernel::{Isa, Lanes, Row};

/// The weights of both ends at a time: `1 − t` and `t`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights([f32; 2]);

impl Weights {
    /// Those at a time, which is clamped to 0 … 1; NaN counts as zero.
    #[inline(always)]
    pub(crate) fn at(time: f32) -> Self {
        let t = if time > 0.0 { time.min(1.0) } else { 0.0 };
        Self([1.0 - t, t])
    }

    /// A coordinate between two; exact at both ends.
    #[inline(always)]
    fn mix(self, start: f32, end: f32) -> f32 {
        start * self.0[0] + end * self.0[1]
    }

    /// A vertex on its way.
    #[inline(always)]
    pub(crate) fn vertex(self, start: Vec3, end: Vec3) -> Vec3 {
        start.zip(end, |start, end| self.mix(start, end))
    }

    /// A triangle on its way.
    #[inline(always)]
    pub(crate) fn triangle(self, [start, end]: &[[Vec3; 3]; 2]) -> [Vec3; 3] {
        std::array::from_fn(|i| self.vertex(start[i], end[i]))
    }

    /// Rows of nodes or blocks, but for the last, which is the same at both ends: [`Self::mix`] in every lane.
    #[inline(always)]
    pub(crate) fn rows<I: Isa, const N: usize>(self, isa: I, start: &[Row; N], end: &[Row; N]) -> [Row; N] {
        let [first, last] = self.0.map(|weight| isa.splat(weight));
        let mut mixed = *start;
        for (row, (start, end)) in mixed[..N - 1].iter_mut().zip(start.iter().zip(end)) {
            *row = Row((isa.load(start) * first + isa.load(end) * last).to_array());
        }
        mixed
    }
}
