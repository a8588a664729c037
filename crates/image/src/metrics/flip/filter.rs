//! Filtering of planes with separable kernels; the edge of the picture is repeated outward.

/// A picture of one channel.
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) values: Vec<f32>,
}

/// Weights at −radius to radius.
#[derive(Clone)]
pub(super) struct Kernel {
    weights: Vec<f32>,
}

impl Kernel {
    /// The weights `function(x)` at integer x.
    pub(super) fn new(radius: usize, function: impl Fn(f32) -> f32) -> Kernel {
        let radius = radius as i32;
        Kernel { weights: (-radius..=radius).map(|x| function(x as f32)).collect() }
    }

    pub(super) fn sum(&self) -> f32 {
        self.weights.iter().sum()
    }

    /// All weights times `factor`.
    pub(super) fn scaled(&self, factor: f32) -> Kernel {
        Kernel { weights: self.weights.iter().map(|weight| weight * factor).collect() }
    }

    /// The positive weights scaled to add up to 1, the negative ones to −1.
    pub(super) fn balanced(&self) -> Kernel {
        let positive: f32 = self.weights.iter().filter(|weight| **weight > 0.0).sum();
        let negative: f32 = self.weights.iter().filter(|weight| **weight < 0.0).sum();
        let balance =
            |&weight: &f32| if weight > 0.0 { weight / positive } else { weight / negative.abs().max(1e-30) };
        Kernel { weights: self.weights.iter().map(balance).collect() }
    }
}

/// The plane filtered with the sum of kernels, each a product of one in x and one in y.
pub(super) fn sum(plane: &Plane, terms: &[(Kernel, Kernel)]) -> Plane {
    let mut total = Plane { width: plane.width, height: plane.height, values: vec![0.0; plane.values.len()] };
    for (x, y) in terms {
        let filtered = separable(plane, x, y);
        total.values.iter_mut().zip(filtered.values).for_each(|(sum, value)| *sum += value);
    }
    total
}

/// The plane filtered with a kernel in x, then one in y.
pub(super) fn separable(plane: &Plane, x: &Kernel, y: &Kernel) -> Plane {
    let (width, height) = (plane.width, plane.height);
    let rows = filter_rows(plane, x);
    let mut values = vec![0.0; width * height];
    let radius = y.weights.len() / 2;
    for (row, target) in values.chunks_exact_mut(width).enumerate() {
        for (tap, &weight) in y.weights.iter().enumerate() {
            let source = (row + tap).saturating_sub(radius).min(height - 1);
            add_scaled(target, &rows[source * width..(source + 1) * width], weight);
        }
    }
    Plane { width, height, values }
}

/// Every row filtered with the kernel.
fn filter_rows(plane: &Plane, kernel: &Kernel) -> Vec<f32> {
    let width = plane.width;
    let radius = kernel.weights.len() / 2;
    let mut padded = vec![0.0; width + 2 * radius];
    let mut values = vec![0.0; plane.values.len()];
    let rows = plane.values.chunks_exact(width).zip(values.chunks_exact_mut(width));
    for (source, target) in rows {
        padded[..radius].fill(source[0]);
        padded[radius..radius + width].copy_from_slice(source);
        padded[radius + width..].fill(source[width - 1]);
        for (tap, &weight) in kernel.weights.iter().enumerate() {
            add_scaled(target, &padded[tap..tap + width], weight);
        }
    }
    values
}

/// `target += weight source`.
fn add_scaled(target: &mut [f32], source: &[f32], weight: f32) {
    target.iter_mut().zip(source).for_each(|(sum, &value)| *sum += weight * value);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane() -> Plane {
        Plane { width: 3, height: 2, values: vec![1.0, 2.0, 4.0, 8.0, 16.0, 32.0] }
    }

    #[test]
    fn rows_and_columns_repeat_their_edge() {
        let identity = Kernel::new(0, |_| 1.0);
        let next = Kernel::new(1, |x| if x == 1.0 { 1.0 } else { 0.0 });
        assert_eq!(separable(&plane(), &next, &identity).values, [2.0, 4.0, 4.0, 16.0, 32.0, 32.0]);
        assert_eq!(separable(&plane(), &identity, &next).values, [8.0, 16.0, 32.0, 8.0, 16.0, 32.0]);
        let both = [(next.clone(), identity.clone()), (identity.clone(), identity)];
        assert_eq!(sum(&plane(), &both).values, [3.0, 6.0, 8.0, 24.0, 48.0, 64.0]);
    }

    #[test]
    fn kernels_wider_than_the_plane_average_its_edges() {
        let wide = Kernel::new(50, |_| 1.0).balanced();
        let flat = Plane { width: 2, height: 1, values: vec![3.0, 3.0] };
        for value in separable(&flat, &wide, &wide).values {
            assert!((value - 3.0).abs() < 1e-5);
        }
    }

    #[test]
    fn balanced_kernels_add_up_to_one_on_either_side() {
        let kernel = Kernel::new(4, |x| -x * (-x * x / 8.0).exp()).balanced();
        let positive: f32 = kernel.weights.iter().filter(|weight| **weight > 0.0).sum();
        assert!((positive - 1.0).abs() < 1e-6 && kernel.sum().abs() < 1e-6);
    }
}
