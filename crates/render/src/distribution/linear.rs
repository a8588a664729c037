//! Distributions that are linear between the values of a table, and mixtures of such tables.

use sahl_math::{Vec2, lerp};

use super::{BELOW_ONE, usable};

/// Tables among which a mixture may choose: the corners of a cell of two parameters.
const MOST_MIXED: usize = 4;

/// Weights of a few tables, which add up to one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixture {
    slices: [u32; MOST_MIXED],
    weights: [f32; MOST_MIXED],
}

impl Mixture {
    /// One table alone.
    pub const fn of(slice: u32) -> Self {
        Self { slices: [slice; MOST_MIXED], weights: [1.0, 0.0, 0.0, 0.0] }
    }

    /// Between four tables, numbered as points (x, y) of a grid with `width` points a row.
    ///
    /// `x` and `y` are the points before and after, and how far it is from the first to the second.
    #[inline]
    pub(crate) fn between(x: ([usize; 2], f32), y: ([usize; 2], f32), width: usize) -> Self {
        let ([x0, x1], tx) = x;
        let ([y0, y1], ty) = y;
        let slice = |x: usize, y: usize| (y * width + x) as u32;
        Self {
            slices: [slice(x0, y0), slice(x1, y0), slice(x0, y1), slice(x1, y1)],
            weights: [(1.0 - tx) * (1.0 - ty), tx * (1.0 - ty), (1.0 - tx) * ty, tx * ty],
        }
    }

    /// The mean of `value`, a function of the number of a table.
    #[inline]
    pub(crate) fn mean(&self, mut value: impl FnMut(usize) -> f32) -> f32 {
        let mut sum = 0.0;
        for (&slice, &weight) in self.slices.iter().zip(&self.weights) {
            if weight != 0.0 {
                sum += weight * value(slice as usize);
            }
        }
        sum
    }
}

/// Densities on the unit square that are bilinear between the values of tables, all of the same size.
///
/// Each table is scaled to a density of its own, and mixed after that. y is drawn from the marginal density of the mixture, x from
/// its conditional one; all of it is exact for mixtures, since cumulative sums are as linear in the weights as densities are.
///
/// Source: Dupuy, Jakob, *An Adaptive Parameterization for Efficient Material Acquisition and Rendering*, ACM TOG 37(6), 2018,
/// section 5.1, for the mixing.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearSlices2d {
    width: usize,
    height: usize,
    /// Densities, row by row.
    values: Vec<f32>,
    /// For each of them the integral along the row from x = 0.
    conditional: Vec<f32>,
    /// For each row the integral of the rows before.
    marginal: Vec<f32>,
}

/// A place between two values of `count`: the first one, and how far it is to the next.
#[inline]
pub(crate) fn cell(x: f32, count: usize) -> (usize, f32) {
    let at = x.clamp(0.0, 1.0) * (count - 1) as f32;
    let index = (at as usize).min(count.saturating_sub(2));
    (index, at - index as f32)
}

/// Where in [0, 1] the integral of a line from `a` at 0 to `b` at 1 reaches `area`.
///
/// The form of the root that does not cancel where the line is nearly flat.
#[inline]
fn solve_line(a: f32, b: f32, area: f32) -> f32 {
    let root = (a * a + 2.0 * area * (b - a)).max(0.0).sqrt();
    let t = 2.0 * area / (a + root);
    if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 }
}

/// The last of `count` − 1 cells that begins below `target`, given where each begins.
#[inline]
fn last_below(count: usize, target: f32, begin: impl Fn(usize) -> f32) -> usize {
    let (mut first, mut rest) = (0, count - 1);
    while rest > 1 {
        let half = rest / 2;
        if begin(first + half) < target {
            first += half;
            rest -= half;
        } else {
            rest = half;
        }
    }
    first
}

impl LinearSlices2d {
    /// Densities in proportion to `values`: tables one after the other, each of rows of `width` entries, y = 0 first.
    ///
    /// # Panics
    /// If a table has less than two values a side, or if the last one is not complete.
    pub fn new(values: &[f32], width: usize, height: usize) -> Self {
        assert!(width > 1 && height > 1, "a line needs two ends");
        assert!(values.len().is_multiple_of(width * height), "whole tables");
        let mut all = Self {
            width,
            height,
            values: Vec::with_capacity(values.len()),
            conditional: Vec::with_capacity(values.len()),
            marginal: Vec::with_capacity(values.len() / width),
        };
        for table in values.chunks(width * height) {
            all.push(table);
        }
        all
    }

    fn push(&mut self, table: &[f32]) {
        let [dx, dy] = [self.width, self.height].map(|count| 1.0 / (count - 1) as f64);
        let integral = |row: &[f32]| -> f64 {
            let value = |i: usize| f64::from(usable(row[i]));
            (1..row.len()).map(|i| 0.5 * dx * (value(i - 1) + value(i))).sum()
        };
        let rows: Vec<f64> = table.chunks(self.width).map(integral).collect();
        let total: f64 = rows.windows(2).map(|pair| 0.5 * dy * (pair[0] + pair[1])).sum();
        let density = |value: f32| if total > 0.0 { (f64::from(usable(value)) / total) as f32 } else { 1.0 };
        let mut below = 0.0;
        let mut before = None;
        for row in table.chunks(self.width) {
            let mut sum = 0.0;
            for (i, &value) in row.iter().enumerate() {
                if i > 0 {
                    sum += 0.5 * dx * f64::from(density(row[i - 1]) + density(value));
                }
                self.values.push(density(value));
                self.conditional.push(sum as f32);
            }
            if let Some(before) = before.replace(sum) {
                below += 0.5 * dy * (before + sum);
            }
            self.marginal.push(below as f32);
        }
    }

    #[inline]
    fn at(&self, table: &[f32], row: usize, column: usize, mixture: &Mixture) -> f32 {
        mixture.mean(|slice| table[(slice * self.height + row) * self.width + column])
    }

    /// The integrals along a row and along the next.
    #[inline]
    fn rows(&self, row: usize, mixture: &Mixture) -> [f32; 2] {
        [row, row + 1].map(|row| self.at(&self.conditional, row, self.width - 1, mixture))
    }

    #[inline]
    fn below(&self, row: usize, mixture: &Mixture) -> f32 {
        mixture.mean(|slice| self.marginal[slice * self.height + row])
    }

    /// The value of `table` at a column, `t` of the way from a row to the next.
    #[inline]
    fn between(&self, table: &[f32], (row, t): (usize, f32), column: usize, mixture: &Mixture) -> f32 {
        lerp(t, self.at(table, row, column, mixture), self.at(table, row + 1, column, mixture))
    }

    /// The density of the mixture at `p`, whose coordinates are limited to [0, 1].
    #[inline]
    pub fn density(&self, p: Vec2, mixture: &Mixture) -> f32 {
        let ((column, s), y) = (cell(p.x, self.width), cell(p.y, self.height));
        let [before, after] =
            [column, column + 1].map(|column| self.between(&self.values, y, column, mixture));
        lerp(s, before, after)
    }

    /// Draws a point of the unit square from the mixture.
    pub fn sample(&self, u: Vec2, mixture: &Mixture) -> Vec2 {
        let row = last_below(self.height, u.y, |row| self.below(row, mixture));
        let [r0, r1] = self.rows(row, mixture);
        let t = solve_line(r0, r1, (u.y - self.below(row, mixture)) * (self.height - 1) as f32);
        let target = u.x * lerp(t, r0, r1);
        let begin = |column| self.between(&self.conditional, (row, t), column, mixture);
        let column = last_below(self.width, target, begin);
        let [c0, c1] =
            [column, column + 1].map(|column| self.between(&self.values, (row, t), column, mixture));
        let s = solve_line(c0, c1, (target - begin(column)) * (self.width - 1) as f32);
        let place = |index: usize, t: f32, count: usize| (index as f32 + t) / (count - 1) as f32;
        Vec2::new(place(column, s, self.width), place(row, t, self.height))
    }

    /// The point of [0, 1)² for which [`LinearSlices2d::sample`] draws `p`.
    pub fn inverse(&self, p: Vec2, mixture: &Mixture) -> Vec2 {
        let ((column, s), (row, t)) = (cell(p.x, self.width), cell(p.y, self.height));
        let area = |a: f32, b: f32, t: f32| t * (a + 0.5 * t * (b - a));
        let [c0, c1] =
            [column, column + 1].map(|column| self.between(&self.values, (row, t), column, mixture));
        let before = self.between(&self.conditional, (row, t), column, mixture);
        let [r0, r1] = self.rows(row, mixture);
        let x = (before + area(c0, c1, s) / (self.width - 1) as f32) / lerp(t, r0, r1);
        let y = self.below(row, mixture) + area(r0, r1, t) / (self.height - 1) as f32;
        let limited = |x: f32| if x.is_finite() { x.clamp(0.0, BELOW_ONE) } else { 0.0 };
        Vec2::new(limited(x), limited(y))
    }
}
