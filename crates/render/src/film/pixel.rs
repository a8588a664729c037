//! What a pixel remembers of its samples.

/// Sums over the samples of a pixel: one cache line.
///
/// The image is the ratio Σ w c / Σ w, which has less noise than Σ w c / n where a filter has negative lobes. For its
/// variance the mean and the squared deviations of the colours, weighted by w², are kept as running moments: sums of
/// squares would need twice the digits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pixel {
    /// Σ w c.
    weighted: [f64; 3],
    /// Σ w.
    weight: f64,
    /// Mean of c, weighted by w².
    mean: [f32; 3],
    /// Σ w² (c − mean)².
    deviation: [f32; 3],
    /// Σ w².
    weight_squares: f32,
    /// How many samples were added.
    samples: u32,
}

impl Pixel {
    /// Adds a sample of the given colour and filter weight.
    ///
    /// Moments: West, *Updating Mean and Variance Estimates: An Improved Method*, CACM 22(9), 1979.
    #[inline]
    pub(crate) fn add(&mut self, color: [f32; 3], weight: f32) {
        let square = weight * weight;
        self.samples += 1;
        self.weight += f64::from(weight);
        self.weight_squares += square;
        let share = if self.weight_squares > 0.0 { square / self.weight_squares } else { 0.0 };
        for (channel, value) in color.into_iter().enumerate() {
            self.weighted[channel] += f64::from(value) * f64::from(weight);
            let before = value - self.mean[channel];
            self.mean[channel] += share * before;
            self.deviation[channel] += square * before * (value - self.mean[channel]);
        }
    }

    /// How many samples were added.
    pub(crate) fn samples(&self) -> u32 {
        self.samples
    }

    /// The filtered colour; zero without samples.
    ///
    /// Where positive and negative weights nearly cancel, which few samples can do, the ratio means nothing, and the
    /// mean weighted by w² stands in for it.
    pub(crate) fn color(&self) -> [f64; 3] {
        let cancels = self.weight * self.weight < 0.5 * f64::from(self.weight_squares);
        std::array::from_fn(|channel| {
            if self.samples == 0 || self.weight_squares == 0.0 {
                0.0
            } else if cancels || self.weight < 0.0 && self.samples > 1 {
                f64::from(self.mean[channel])
            } else {
                self.weighted[channel] / self.weight
            }
        })
    }

    /// The variance of [`Pixel::color`], estimated from its samples; infinite with fewer than two.
    ///
    /// That of a ratio estimator, to first order: Cochran, *Sampling Techniques*, 3rd ed., 1977, section 6.4.
    pub(crate) fn variance(&self) -> [f64; 3] {
        if self.samples < 2 || self.weight == 0.0 {
            return [f64::INFINITY; 3];
        }
        let color = self.color();
        let n = f64::from(self.samples);
        std::array::from_fn(|channel| {
            let shift = f64::from(self.mean[channel]) - color[channel];
            let sum = f64::from(self.deviation[channel]) + f64::from(self.weight_squares) * shift * shift;
            sum / (self.weight * self.weight) * n / (n - 1.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_variance_are_those_of_the_samples() {
        let mut pixel = Pixel::default();
        let values = [1.0_f32, 4.0, 2.0, 9.0, 4.0];
        for v in values {
            pixel.add([v, 2.0 * v, 0.5], 1.0);
        }
        let mean = 4.0;
        let variance = values.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>() / 4.0 / 5.0;
        assert_eq!(pixel.color(), [4.0, 8.0, 0.5]);
        let found = pixel.variance();
        assert!((found[0] - variance).abs() < 1e-6 && (found[1] - 4.0 * variance).abs() < 1e-6);
        assert_eq!(found[2], 0.0);
        assert_eq!(pixel.samples(), 5);
    }

    #[test]
    fn a_bright_flat_pixel_has_no_variance() {
        let mut pixel = Pixel::default();
        for _ in 0..100_000 {
            pixel.add([12_345.678; 3], 1.0);
        }
        assert!(pixel.variance()[0] < 1e-6);
    }

    #[test]
    fn cancelling_weights_do_not_explode() {
        let mut pixel = Pixel::default();
        pixel.add([1.0; 3], 1.2);
        pixel.add([1.5; 3], -1.199);
        assert!(pixel.color()[0] > 0.9 && pixel.color()[0] < 1.6, "{:?}", pixel.color());
        let mut single = Pixel::default();
        single.add([3.0; 3], -1.2);
        assert!((single.color()[0] - 3.0).abs() < 1e-6);
        assert_eq!(Pixel::default().color(), [0.0; 3]);
    }

    #[test]
    fn a_pixel_is_a_cache_line() {
        assert_eq!(size_of::<Pixel>(), 64);
    }
}
