//! Densities of which a part is sampled.

use sahl_math::Vec2;

use super::{cell_of, usable};

/// A piecewise constant function on the unit square, given by a table on a grid, that can be sampled within any window.
///
/// Source: Bitterli, Wyman, Pharr, Shirley, Lefohn, Jarosz, *Portal-Masked Environment Map Sampling*, CGF 34(4), 2015: a
/// summed-area table (Crow 1984) holds the integral over every window. It is kept in `f64`, whose differences leave enough
/// digits for a small window beside a bright spot; where a sum reaches its goal within the table is found by bisection over
/// its entries, and the point between two of them exactly.
#[derive(Clone, Debug)]
pub struct Windowed2d {
    width: usize,
    height: usize,
    values: Vec<f32>,
    /// Sums over the cells above and to the left of each corner: (width + 1) × (height + 1).
    sums: Vec<f64>,
}

/// A window: its corners with the smallest and the largest coordinates.
pub type Window = [Vec2; 2];

/// A range along an axis, in cells.
type Range = [f64; 2];

impl Windowed2d {
    /// The function with the given values: rows of `width` entries, y = 0 first. Negative and non-finite ones count as zero.
    ///
    /// # Panics
    /// If there are none, or if they do not fill whole rows.
    pub fn new(values: &[f32], width: usize) -> Self {
        assert!(
            width > 0 && values.len() >= width && values.len().is_multiple_of(width),
            "a grid of whole rows"
        );
        let height = values.len() / width;
        let mut sums = vec![0.0; (width + 1) * (height + 1)];
        for y in 0..height {
            let mut row = 0.0;
            for x in 0..width {
                row += f64::from(usable(values[y * width + x]));
                sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
            }
        }
        Self { width, height, values: values.iter().copied().map(usable).collect(), sums }
    }

    /// The integral of the function over `window`.
    pub fn integral(&self, window: Window) -> f32 {
        let (x, y) = self.ranges(window);
        (self.sum(x, y) / self.cells()) as f32
    }

    /// Draws a point of `window` in proportion to the function, with its density there; `None` if the function is zero in it.
    pub fn sample(&self, u: Vec2, window: Window) -> Option<(Vec2, f32)> {
        let (x, y) = self.ranges(window);
        let total = self.sum(x, y);
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        // The column by its share in the window, then the row by its share in the part of the column in the window.
        let (column, within) = self.search(x, f64::from(u.x), |end| self.sum([x[0], end], y))?;
        let strip = [x[0].max(column), x[1].min(column + 1.0)];
        let px = strip[0] + within * (strip[1] - strip[0]);
        let (row, within) = self.search(y, f64::from(u.y), |end| self.sum(strip, [y[0], end]))?;
        let strip = [y[0].max(row), y[1].min(row + 1.0)];
        let py = strip[0] + within * (strip[1] - strip[0]);
        let p = Vec2::new((px / self.width as f64) as f32, (py / self.height as f64) as f32);
        // Rounding may lead over a border, where the density is another: it is asked for the point that is returned.
        let [low, high] = window;
        let p = Vec2::new(p.x.clamp(low.x, high.x), p.y.clamp(low.y, high.y));
        let pdf = self.density(p, total);
        (pdf > 0.0).then_some((p, pdf))
    }

    /// The density of [`Windowed2d::sample`] at `p`; zero outside the window.
    pub fn pdf(&self, p: Vec2, window: Window) -> f32 {
        let [low, high] = window;
        let inside = (low.x..=high.x).contains(&p.x) && (low.y..=high.y).contains(&p.y);
        let (x, y) = self.ranges(window);
        let total = self.sum(x, y);
        if inside && total > 0.0 { self.density(p, total) } else { 0.0 }
    }

    fn density(&self, p: Vec2, total: f64) -> f32 {
        let (x, y) = (cell_of(p.x, self.width), cell_of(p.y, self.height));
        (f64::from(self.values[y * self.width + x]) * self.cells() / total) as f32
    }

    fn cells(&self) -> f64 {
        (self.width * self.height) as f64
    }

    /// The sides of a window in cells; empty where it has no positive extent.
    fn ranges(&self, [low, high]: Window) -> (Range, Range) {
        let range = |low: f32, high: f32, size: usize| {
            let place = |x: f32| f64::from(x.clamp(0.0, 1.0)) * size as f64;
            if low < high { [place(low), place(high)] } else { [0.0; 2] }
        };
        (range(low.x, high.x, self.width), range(low.y, high.y, self.height))
    }

    /// The sum of the values over a box of cells and parts of cells.
    fn sum(&self, x: Range, y: Range) -> f64 {
        let corner = |x: f64, y: f64| self.sum_from_origin(x, y);
        (corner(x[1], y[1]) - corner(x[0], y[1]) - (corner(x[1], y[0]) - corner(x[0], y[0]))).max(0.0)
    }

    /// Between corners of cells the sum is bilinear, because the function is constant there.
    #[inline]
    fn sum_from_origin(&self, x: f64, y: f64) -> f64 {
        let (column, row) = ((x as usize).min(self.width - 1), (y as usize).min(self.height - 1));
        let (fx, fy) = (x - column as f64, y - row as f64);
        let at = |dx: usize, dy: usize| self.sums[(row + dy) * (self.width + 1) + column + dx];
        let (top, bottom) = (at(0, 0) + fx * (at(1, 0) - at(0, 0)), at(0, 1) + fx * (at(1, 1) - at(0, 1)));
        top + fy * (bottom - top)
    }

    /// The cell of `range` in which a sum that grows with its `end` reaches the share `u` of the whole, and where in the part of
    /// the cell that lies in the range; `None` if the whole is zero.
    fn search(&self, range: Range, u: f64, sum_to: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
        let goal = u * sum_to(range[1]);
        // The last cell whose sum up to its beginning is at most the goal.
        let (mut first, mut beyond) = (range[0].floor(), range[1].ceil());
        while beyond - first > 1.0 {
            let middle = ((first + beyond) * 0.5).floor();
            if sum_to(middle) <= goal { first = middle } else { beyond = middle }
        }
        let (before, after) = (sum_to(range[0].max(first)), sum_to(range[1].min(first + 1.0)));
        (after > before).then(|| (first, ((goal - before) / (after - before)).clamp(0.0, 1.0)))
    }
}
