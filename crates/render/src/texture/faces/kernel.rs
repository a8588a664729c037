//! The kernel along one axis.

/// Widths end at half a face: the kernel then reaches over the whole of its neighbours, and no farther.
pub(super) const MOST_WIDTH: f32 = 0.5;

/// No kernel has more taps: four widths of less than eight pixels each, and one.
const MOST_TAPS: usize = 33;

/// Pixels with their weights, of sum one.
pub(super) struct Taps {
    /// The first pixel; negative before the face.
    first: i32,
    count: usize,
    weights: [f32; MOST_TAPS],
}

/// A width that a kernel may have, given what a footprint has.
pub(super) fn limited(width: f32) -> f32 {
    if width.is_finite() { width.clamp(0.0, MOST_WIDTH) } else { MOST_WIDTH }
}

/// How often the `2^log2` pixels of a side may be halved such that a width still covers one.
pub(super) fn reduction(width: f32, log2: u32) -> u32 {
    let pixels = width * (1_u32 << log2) as f32;
    // A cast is zero for what is less than one.
    (pixels as u32).max(1).ilog2().min(log2)
}

impl Taps {
    /// The kernel of a width about `x`, over a face of `2^log2` pixels from zero to one.
    pub(super) fn new(x: f32, width: f32, log2: u32) -> Self {
        let pixels = (1_u32 << log2) as f32;
        let x = if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 };
        let center = x * pixels - 0.5;
        let width = (width * pixels).max(1.0).min(MOST_WIDTH * pixels);
        let reach = 2.0 * width;
        let first = (center - reach).ceil();
        let count = ((center + reach).floor() - first) as usize + 1;
        let mut taps = Self { first: first as i32, count: count.min(MOST_TAPS), weights: [0.0; MOST_TAPS] };
        let mut sum = 0.0;
        for (i, weight) in taps.weights[..taps.count].iter_mut().enumerate() {
            *weight = b_spline((first + i as f32 - center) / width);
            sum += *weight;
        }
        for weight in &mut taps.weights[..taps.count] {
            *weight /= sum;
        }
        taps
    }

    /// Pixels and weights, without those that count nothing.
    pub(super) fn iter(&self) -> impl Iterator<Item = (i32, f32)> {
        let weights = self.weights[..self.count].iter().enumerate();
        weights.filter(|(_, weight)| **weight > 0.0).map(|(i, &weight)| (self.first + i as i32, weight))
    }
}

/// The cubic B-spline over [−2, 2].
fn b_spline(x: f32) -> f32 {
    let x = x.abs();
    if x < 1.0 {
        2.0 / 3.0 - x * x * (1.0 - 0.5 * x)
    } else {
        let rest = (2.0 - x).max(0.0);
        rest * rest * rest / 6.0
    }
}
