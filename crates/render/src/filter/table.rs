//! One axis of a filter, as a table.

use crate::distribution::PiecewiseConstant1d;

/// Cells of the table over the whole width.
const CELLS: usize = 512;

/// A curve over [−radius, radius] that is drawn in proportion to its absolute value.
///
/// Within a cell the curve counts as constant: the filter that is sampled is a staircase of 512 steps.
#[derive(Clone, Debug)]
pub struct AxisTable {
    radius: f32,
    density: PiecewiseConstant1d,
    /// The weight in cells where the curve is positive: ∫|f| / ∫f.
    weight: f32,
    /// Whether the curve is negative, by cell.
    negative: Vec<bool>,
}

impl AxisTable {
    /// The table of `curve`.
    ///
    /// A curve that is nowhere finite and positive on balance counts as constant.
    pub(super) fn new(radius: f32, curve: impl Fn(f32) -> f32) -> Self {
        let center = |cell: usize| radius * ((2 * cell + 1) as f32 / CELLS as f32 - 1.0);
        let values: Vec<f32> = (0..CELLS).map(|cell| curve(center(cell))).collect();
        let signed: f32 = values.iter().sum();
        let absolute: f32 = values.iter().map(|value| value.abs()).sum();
        let values = if absolute.is_finite() && signed > 0.0 { values } else { vec![1.0; CELLS] };
        let weight = if absolute.is_finite() && signed > 0.0 { absolute / signed } else { 1.0 };
        let magnitudes: Vec<f32> = values.iter().map(|value| value.abs()).collect();
        Self {
            radius,
            density: PiecewiseConstant1d::new(&magnitudes),
            weight,
            negative: values.iter().map(|&value| value < 0.0).collect(),
        }
    }

    /// Half the width.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// The place on the axis for `u` uniform in [0, 1), and its weight.
    #[inline]
    pub(super) fn sample(&self, u: f32) -> (f32, f32) {
        let (x, _, cell) = self.density.sample(u);
        let weight = if self.negative[cell] { -self.weight } else { self.weight };
        (self.radius * (2.0 * x - 1.0), weight)
    }
}
