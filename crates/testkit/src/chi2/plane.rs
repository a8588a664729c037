//! Tables of bins over rectangles; densities on the unit square and on an interval.

use sahl_math::Vec2;

use super::SEED;
use super::pearson::{View, verdict};
use crate::quadrature::{Accuracy, Cell, integrate};
use crate::random::Rng;

/// A grid of bins over a rectangle, with what fell into each and the failed samples.
pub(super) struct Table {
    pub(super) region: Cell,
    pub(super) counts: [usize; 2],
    pub(super) axes: [&'static str; 2],
    pub(super) failed: u64,
    observed: Vec<u64>,
    points: Vec<[f64; 2]>,
}

/// Standard deviations between a count and its expectation from which the integral is doubted.
const SURPRISE: f64 = 3.0;
/// How well the integral of a density in `f32` over the whole domain is known: the expected count of failed samples is
/// moved by up to this share of all samples toward the count observed.
const MASS_ERROR: f64 = 3e-4;
/// How many times a doubted cell is halved.
const MAX_DEPTH: usize = 20;
/// How many doubted cells are integrated again: it bounds the time that a wrong density costs.
const CELL_BUDGET: usize = 200_000;

/// The share of samples that `density` expects in `cell`, given the share found there and the count of all samples.
///
/// The error aimed at is a fiftieth of the standard deviation of the count.
fn integral(density: impl Fn(f64, f64) -> f64, cell: Cell, share: f64, n: f64) -> f64 {
    integrate(density, cell, Accuracy { cuts: 2, absolute: 0.02 * (share * n).max(1.0).sqrt() / n })
}

/// The difference of a count from its expectation in standard deviations.
fn surprise(observed: u64, expected: f64) -> f64 {
    (observed as f64 - expected).abs() / expected.max(1.0).sqrt()
}

/// What [`Follower::expected`] needs beside the cell.
struct Follower<'a, F> {
    density: &'a F,
    /// How many samples were drawn.
    n: f64,
    /// How many cells may still be cut.
    budget: usize,
    /// Whether the second axis is cut too.
    two_axes: bool,
}

impl<F: Fn(f64, f64) -> f64> Follower<'_, F> {
    /// The expected count in `cell`, halved while the count of its `points` surprises and the budget lasts.
    fn expected(&mut self, cell: Cell, points: Vec<[f64; 2]>, depth: usize) -> f64 {
        let expected = self.n * integral(self.density, cell, points.len() as f64 / self.n, self.n);
        if depth == MAX_DEPTH || self.budget == 0 || surprise(points.len() as u64, expected) <= SURPRISE {
            return expected;
        }
        self.budget -= 1;
        let axis = if self.two_axes { depth % 2 } else { 0 };
        let counts = if axis == 0 { [2, 1] } else { [1, 2] };
        let (lower, upper) = (cell.part([0, 0], counts), cell.part([counts[0] - 1, counts[1] - 1], counts));
        let (below, above) = points.into_iter().partition(|point| point[axis] < upper.low[axis]);
        self.expected(lower, below, depth + 1) + self.expected(upper, above, depth + 1)
    }
}

impl Table {
    pub(super) fn new(region: Cell, counts: [usize; 2], axes: [&'static str; 2]) -> Self {
        assert!(counts[0] > 0 && counts[1] > 0, "a table needs bins");
        Self { region, counts, axes, failed: 0, observed: vec![0; counts[0] * counts[1]], points: Vec::new() }
    }

    /// Counts a sample at a point, which is moved to the nearest bin if rounding put it outside.
    pub(super) fn add(&mut self, point: [f64; 2]) {
        let at = self.bin(point);
        self.observed[at] += 1;
        self.points.push(point);
    }

    /// The bin of a point.
    fn bin(&self, point: [f64; 2]) -> usize {
        let along = |axis: usize| {
            let t = (point[axis] - self.region.low[axis]) / (self.region.high[axis] - self.region.low[axis]);
            ((t * self.counts[axis] as f64) as usize).min(self.counts[axis] - 1)
        };
        along(1) * self.counts[0] + along(0)
    }

    /// The cell of bin `i`.
    fn cell(&self, i: usize) -> Cell {
        self.region.part([i % self.counts[0], i / self.counts[0]], self.counts)
    }

    /// The expected count of each bin, for a density per unit of the coordinates.
    ///
    /// Where the count of a bin surprises, its parts are integrated apart, and so on while the count of a part
    /// surprises: if a narrow peak had slipped through the points of the quadrature, the samples lead to it.
    fn expected(&self, density: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let n = self.drawn();
        let (mut expected, mut points) = (Vec::new(), vec![Vec::new(); self.observed.len()]);
        for (i, &observed) in self.observed.iter().enumerate() {
            expected.push(n * integral(&density, self.cell(i), observed as f64 / n, n));
        }
        let surprising = |i: usize| surprise(self.observed[i], expected[i]) > SURPRISE;
        for &point in self.points.iter().filter(|&&point| surprising(self.bin(point))) {
            points[self.bin(point)].push(point);
        }
        let two_axes = self.counts[1] > 1;
        let mut follower = Follower { density: &density, n, budget: CELL_BUDGET, two_axes };
        for (i, points) in points.into_iter().enumerate().filter(|(_, points)| !points.is_empty()) {
            expected[i] = follower.expected(self.cell(i), points, 0);
        }
        expected
    }

    /// How many samples were drawn.
    fn drawn(&self) -> f64 {
        self.points.len() as f64 + self.failed as f64
    }

    /// The verdict on the whole table, its columns and its rows.
    pub(super) fn test(
        &self,
        density: impl Fn(f64, f64) -> f64,
        significance: f64,
        tests: usize,
    ) -> Result<(), String> {
        let n = self.drawn();
        let expected = self.expected(density);
        let mass = expected.iter().sum::<f64>() / n;
        if !mass.is_finite() || expected.iter().any(|e| *e < 0.0) {
            return Err(format!("the density is negative or not finite somewhere (its integral is {mass})"));
        }
        if mass > 1.0 + MASS_ERROR {
            return Err(format!("the density integrates to {mass:.6}, more than one"));
        }
        let (missing, slack) = ((1.0 - mass).max(0.0) * n, MASS_ERROR * n);
        let failures = (self.failed, missing + (self.failed as f64 - missing).clamp(-slack, slack));
        let [columns, rows] = self.counts;
        let name_whole = format!("{} x {} bins", self.axes[0], self.axes[1]);
        let label_whole = |i: usize| self.label(i, &[0, 1], failures);
        let label_column = |x: usize| self.label(if x < columns { x } else { usize::MAX }, &[0], failures);
        let label_row = |y: usize| self.label(y.saturating_mul(columns), &[1], failures);
        let view = |name, bins: usize, bin_of: &dyn Fn(usize) -> usize, label| {
            let (mut counts, mut sums) = (vec![0; bins + 1], vec![0.0; bins + 1]);
            for i in 0..self.observed.len() {
                counts[bin_of(i)] += self.observed[i];
                sums[bin_of(i)] += expected[i];
            }
            (counts[bins], sums[bins]) = failures;
            View { name, observed: counts, expected: sums, label }
        };
        let mut views =
            vec![view(name_whole.as_str(), columns * rows, &|i| i, &label_whole as &dyn Fn(usize) -> String)];
        if columns > 1 && rows > 1 {
            views.push(view(self.axes[0], columns, &|i| i % columns, &label_column));
            views.push(view(self.axes[1], rows, &|i| i / columns, &label_row));
        }
        verdict(&views, significance, tests)
    }

    /// The name of bin `i`: its intervals along `axes`; beyond the last bin lie the failed samples.
    fn label(&self, i: usize, axes: &[usize], failures: (u64, f64)) -> String {
        if i >= self.observed.len() {
            return format!("failed samples ({} of {:.2})", failures.0, failures.1);
        }
        let cell = self.cell(i);
        let interval =
            |&axis: &usize| format!("{} {:.3}..{:.3}", self.axes[axis], cell.low[axis], cell.high[axis]);
        axes.iter().map(interval).collect::<Vec<_>>().join(", ")
    }
}

/// The test of points in the unit square against a density per unit area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareTest {
    /// Bins along x.
    pub x_bins: usize,
    /// Bins along y.
    pub y_bins: usize,
    /// How many points are drawn.
    pub samples: usize,
    /// Probability that a family of `tests` right tests fails.
    pub significance: f64,
    /// How many tests share the significance.
    pub tests: usize,
}

impl Default for SquareTest {
    fn default() -> Self {
        Self { x_bins: 32, y_bins: 32, samples: 1_000_000, significance: 0.01, tests: 1 }
    }
}

impl SquareTest {
    /// Draws points from pairs of uniform numbers in [0, 1) and compares them with `pdf`.
    ///
    /// `None` is a failed draw; the density may integrate to less than one accordingly. Fails on points outside
    /// [0, 1]², on a negative or not finite density, and on an integral above one.
    pub fn run(
        &self,
        mut sample: impl FnMut([f32; 2]) -> Option<Vec2>,
        pdf: impl Fn(Vec2) -> f32,
    ) -> Result<(), String> {
        let region = Cell { low: [0.0; 2], high: [1.0; 2] };
        let mut table = Table::new(region, [self.x_bins, self.y_bins], ["x", "y"]);
        let mut rng = Rng::new(SEED);
        for _ in 0..self.samples {
            match sample(rng.uniform()) {
                None => table.failed += 1,
                Some(p) if (0.0..=1.0).contains(&p.x) && (0.0..=1.0).contains(&p.y) => {
                    table.add([f64::from(p.x), f64::from(p.y)]);
                }
                Some(p) => return Err(format!("sampled ({}, {}), outside the unit square", p.x, p.y)),
            }
        }
        let density = |x: f64, y: f64| f64::from(pdf(Vec2::new(x as f32, y as f32)));
        table.test(density, self.significance, self.tests)
    }
}

/// The test of numbers in an interval against a density per unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineTest {
    /// Lower and upper end of the interval.
    pub range: [f32; 2],
    /// Bins along the interval.
    pub bins: usize,
    /// How many numbers are drawn.
    pub samples: usize,
    /// Probability that a family of `tests` right tests fails.
    pub significance: f64,
    /// How many tests share the significance.
    pub tests: usize,
}

impl Default for LineTest {
    fn default() -> Self {
        Self { range: [0.0, 1.0], bins: 128, samples: 1_000_000, significance: 0.01, tests: 1 }
    }
}

impl LineTest {
    /// Draws numbers from uniform ones in [0, 1) and compares them with `pdf`.
    ///
    /// `None` is a failed draw; the density may integrate to less than one accordingly. Fails on numbers outside the
    /// interval, on a negative or not finite density, and on an integral above one.
    pub fn run(
        &self,
        mut sample: impl FnMut(f32) -> Option<f32>,
        pdf: impl Fn(f32) -> f32,
    ) -> Result<(), String> {
        let [low, high] = self.range;
        // The second axis is a dummy of length one.
        let region = Cell { low: [f64::from(low), 0.0], high: [f64::from(high), 1.0] };
        let mut table = Table::new(region, [self.bins, 1], ["x", "all"]);
        let mut rng = Rng::new(SEED);
        for _ in 0..self.samples {
            match sample(rng.next_f32()) {
                None => table.failed += 1,
                Some(x) if (low..=high).contains(&x) => table.add([f64::from(x), 0.5]),
                Some(x) => return Err(format!("sampled {x}, outside [{low}, {high}]")),
            }
        }
        table.test(|x, _| f64::from(pdf(x as f32)), self.significance, self.tests)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of density `4 x y`.
    fn sample_product(u: [f32; 2]) -> Option<Vec2> {
        Some(Vec2::new(u[0].sqrt(), u[1].sqrt()))
    }

    #[test]
    fn right_densities_pass() {
        SquareTest::default().run(sample_product, |p| 4.0 * p.x * p.y).unwrap();
        LineTest::default().run(|u| Some(u.sqrt()), |x| 2.0 * x).unwrap();
        let exponential = LineTest { range: [0.0, 30.0], ..LineTest::default() };
        exponential.run(|u| Some(-(-u).ln_1p()), |x| (-x).exp()).unwrap();
    }

    #[test]
    fn failed_samples_are_the_missing_mass() {
        let test = SquareTest::default();
        // Half of the square is refused, in a shape that no bin follows.
        let refused = |u: [f32; 2]| Some(Vec2::from(u)).filter(|p| p.x + p.y < 1.0);
        let half = |p: Vec2| f32::from(p.x + p.y < 1.0);
        test.run(refused, half).unwrap();
        test.run(refused, |p| 0.99 * half(p)).unwrap_err();
        test.run(refused, |p| 2.0 * half(p)).unwrap_err();
    }

    #[test]
    fn wrong_densities_fail() {
        let test = SquareTest::default();
        let product = |p: Vec2| 4.0 * p.x * p.y;
        // One per cent off in the exponent, in the normalisation either way, and a swap of axes.
        test.run(sample_product, |p| 2.02 * p.x.powf(1.02) * 2.0 * p.y).unwrap_err();
        test.run(sample_product, |p| 0.99 * product(p)).unwrap_err();
        assert!(test.run(sample_product, |p| 1.01 * product(p)).unwrap_err().contains("more than one"));
        let skewed = |u: [f32; 2]| Some(Vec2::new(u[0].sqrt(), u[1]));
        test.run(skewed, |p| 2.0 * p.y).unwrap_err();
        LineTest::default().run(|u| Some(u.sqrt()), |x| 2.02 * x.powf(1.02)).unwrap_err();
    }

    #[test]
    fn a_peak_that_no_quadrature_point_touches_is_found_by_the_samples() {
        let (centre, width) = (0.437_1_f32, 1e-4_f32);
        let test = LineTest { bins: 8, ..LineTest::default() };
        let pdf =
            |x: f32| if (x - centre).abs() < width { 0.5 / (2.0 * width) } else { 0.5 / (1.0 - 2.0 * width) };
        let sample = |u: f32| {
            let v = 2.0 * u - 1.0;
            if v >= 0.0 {
                return Some(centre + width * (2.0 * v - 1.0));
            }
            let x = (v + 1.0) * (1.0 - 2.0 * width);
            Some(if x < centre - width { x } else { x + 2.0 * width })
        };
        test.run(sample, pdf).unwrap();
    }

    #[test]
    fn nonsense_is_told() {
        let test = SquareTest { samples: 1000, ..SquareTest::default() };
        assert!(test.run(|_| Some(Vec2::splat(f32::NAN)), |_| 1.0).unwrap_err().contains("outside"));
        assert!(test.run(|_| Some(Vec2::splat(1.5)), |_| 1.0).unwrap_err().contains("outside"));
        assert!(test.run(|u| Some(u.into()), |_| f32::NAN).unwrap_err().contains("not finite"));
        assert!(test.run(|u| Some(u.into()), |p| p.x * 4.0 - 1.0).unwrap_err().contains("negative"));
    }
}
