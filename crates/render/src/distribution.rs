//! Distributions given by tables.
//!
//! Design decision: cumulative sums are carried in `f64` and rounded once, so that the error of an entry does not grow
//! with its place in the table and the tail is sampled as it should be. A function that is zero everywhere is sampled
//! uniformly, with an integral of zero: what is divided by its density is then zero, not NaN.
//!
//! Negative and non-finite values count as zero.

mod linear;
mod windowed;

use sahl_math::Vec2;

pub(crate) use linear::cell;
pub use linear::{LinearSlices2d, Mixture};
pub use windowed::{Window, Windowed2d};

/// The largest number below one: where coordinates of samples end.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// What a table holds for `value`: itself if it can be a density.
fn usable(value: f32) -> f32 {
    if value.is_finite() { value.max(0.0) } else { 0.0 }
}

/// Appends the cumulative distribution of `values` (one entry more than they are) to `cdf`, and returns their mean.
fn push_cdf(values: &[f32], cdf: &mut Vec<f32>) -> f64 {
    let total: f64 = values.iter().map(|&value| f64::from(usable(value))).sum();
    let count = values.len() as f64;
    let mut sum = 0.0;
    cdf.push(0.0);
    for (i, &value) in values.iter().enumerate() {
        sum += f64::from(usable(value));
        cdf.push(if total > 0.0 { (sum / total) as f32 } else { ((i + 1) as f64 / count) as f32 });
    }
    // Behind the last entry that counts, all are one: no number below one leads there.
    total / count
}

/// The entry of `cdf` (n + 1 values from 0 to 1) in which `u` lies, and where in it, in [0, 1).
#[inline]
fn find(cdf: &[f32], u: f32) -> (usize, f32) {
    // The last entry that begins at or below u: entries of no probability begin where the next one does.
    let mut first = 0;
    let mut count = cdf.len() - 1;
    while count > 1 {
        let half = count / 2;
        if cdf[first + half] <= u {
            first += half;
        }
        count -= half;
    }
    let (low, high) = (cdf[first], cdf[first + 1]);
    (first, if high > low { ((u - low) / (high - low)).min(BELOW_ONE) } else { 0.0 })
}

/// The point of [0, 1) at `within` of cell `entry` of `count`, such that [`cell_of`] leads back to the cell.
#[inline]
fn place(entry: usize, within: f32, count: usize) -> f32 {
    let mut x = ((entry as f32 + within) / count as f32).min(BELOW_ONE);
    // At the border of a cell rounding may lead to its neighbour, where the density is another.
    loop {
        let found = cell_of(x, count);
        if found == entry {
            return x;
        }
        x = if found < entry { x.next_up() } else { x.next_down() };
    }
}

/// The cell of `count` in which `x` of [0, 1] lies.
#[inline]
fn cell_of(x: f32, count: usize) -> usize {
    ((x * count as f32) as usize).min(count - 1)
}

/// A piecewise constant density on [0, 1], in proportion to a table of values at equal distances.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant1d {
    values: Vec<f32>,
    cdf: Vec<f32>,
    integral: f32,
}

impl PiecewiseConstant1d {
    /// The density in proportion to `values`.
    ///
    /// # Panics
    /// If there are none.
    pub fn new(values: &[f32]) -> Self {
        assert!(!values.is_empty(), "a distribution over an empty table");
        let mut cdf = Vec::with_capacity(values.len() + 1);
        let integral = push_cdf(values, &mut cdf) as f32;
        Self { values: values.iter().copied().map(usable).collect(), cdf, integral }
    }

    /// The integral of the function over [0, 1]: the mean of the values.
    pub fn integral(&self) -> f32 {
        self.integral
    }

    /// Draws a point: its place in [0, 1), the density there, and the table's entry.
    #[inline]
    pub fn sample(&self, u: f32) -> (f32, f32, usize) {
        let (entry, within) = find(&self.cdf, u);
        (place(entry, within, self.values.len()), self.density(entry), entry)
    }

    /// The density at `x`; zero outside [0, 1].
    #[inline]
    pub fn pdf(&self, x: f32) -> f32 {
        if (0.0..=1.0).contains(&x) { self.density(self.entry(x)) } else { 0.0 }
    }

    /// The number for which [`PiecewiseConstant1d::sample`] draws `x`, in [0, 1].
    pub fn inverse(&self, x: f32) -> f32 {
        let entry = self.entry(x);
        let within = (x * self.values.len() as f32 - entry as f32).clamp(0.0, 1.0);
        sahl_math::lerp(within, self.cdf[entry], self.cdf[entry + 1])
    }

    #[inline]
    fn entry(&self, x: f32) -> usize {
        cell_of(x, self.values.len())
    }

    #[inline]
    fn density(&self, entry: usize) -> f32 {
        if self.integral > 0.0 { self.values[entry] / self.integral } else { 1.0 }
    }
}

/// A piecewise constant density on the unit square, in proportion to a table of values on a grid.
///
/// y is drawn from the rows' sums, then x from the row.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant2d {
    width: usize,
    values: Vec<f32>,
    /// One cumulative distribution of `width + 1` entries a row.
    conditional: Vec<f32>,
    marginal: PiecewiseConstant1d,
}

impl PiecewiseConstant2d {
    /// The density in proportion to `values`: rows of `width` entries, y = 0 first.
    ///
    /// # Panics
    /// If there are none, or if they do not fill whole rows.
    pub fn new(values: &[f32], width: usize) -> Self {
        assert!(
            width > 0 && values.len() >= width && values.len().is_multiple_of(width),
            "a grid of whole rows"
        );
        let height = values.len() / width;
        let mut conditional = Vec::with_capacity((width + 1) * height);
        let rows: Vec<f32> = values.chunks(width).map(|row| push_cdf(row, &mut conditional) as f32).collect();
        Self {
            width,
            values: values.iter().copied().map(usable).collect(),
            conditional,
            marginal: PiecewiseConstant1d::new(&rows),
        }
    }

    /// The integral of the function over the unit square: the mean of the values.
    pub fn integral(&self) -> f32 {
        self.marginal.integral
    }

    /// Draws a point of the unit square; returns it and the density there.
    #[inline]
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (y, _, row) = self.marginal.sample(u.y);
        let (column, within) = find(self.row_cdf(row), u.x);
        (Vec2::new(place(column, within, self.width), y), self.density(row, column))
    }

    /// The density at `p`; zero outside the unit square.
    #[inline]
    pub fn pdf(&self, p: Vec2) -> f32 {
        if (0.0..=1.0).contains(&p.x) && (0.0..=1.0).contains(&p.y) {
            self.density(self.marginal.entry(p.y), self.column(p.x))
        } else {
            0.0
        }
    }

    /// The point for which [`PiecewiseConstant2d::sample`] draws `p`, in [0, 1]².
    pub fn inverse(&self, p: Vec2) -> Vec2 {
        let column = self.column(p.x);
        let cdf = self.row_cdf(self.marginal.entry(p.y));
        let within = (p.x * self.width as f32 - column as f32).clamp(0.0, 1.0);
        Vec2::new(sahl_math::lerp(within, cdf[column], cdf[column + 1]), self.marginal.inverse(p.y))
    }

    #[inline]
    fn column(&self, x: f32) -> usize {
        cell_of(x, self.width)
    }

    #[inline]
    fn row_cdf(&self, row: usize) -> &[f32] {
        &self.conditional[row * (self.width + 1)..(row + 1) * (self.width + 1)]
    }

    #[inline]
    fn density(&self, row: usize, column: usize) -> f32 {
        if self.integral() > 0.0 { self.values[row * self.width + column] / self.integral() } else { 1.0 }
    }
}

/// A discrete distribution that is sampled in constant time.
///
/// Source: Walker, *An Efficient Method for Generating Discrete Random Variables with General Distributions*, ACM TOMS
/// 3(3), 1977; the linear-time construction of Vose, IEEE TSE 17(9), 1991.
#[derive(Clone, Debug)]
pub struct AliasTable {
    bins: Vec<Bin>,
}

#[derive(Clone, Copy, Debug)]
struct Bin {
    /// Probability of the outcome of the bin's number.
    pmf: f32,
    /// Share of the bin that leads to its own outcome.
    share: f32,
    /// The outcome of the rest.
    alias: u32,
}

impl AliasTable {
    /// The distribution in proportion to `weights`; uniform if all are zero; without outcomes if there are none.
    ///
    /// # Panics
    /// If there are 2³² weights or more.
    pub fn new(weights: &[f32]) -> Self {
        let count = u32::try_from(weights.len()).expect("fewer than 2^32 outcomes");
        let total: f64 = weights.iter().map(|&weight| f64::from(usable(weight))).sum();
        let probability = |weight: f32| {
            if total > 0.0 { f64::from(usable(weight)) / total } else { 1.0 / f64::from(count) }
        };
        let mut bins: Vec<Bin> = Vec::with_capacity(weights.len());
        // The mass of each outcome in units of bins, still to be placed.
        let mut mass: Vec<f64> = Vec::with_capacity(weights.len());
        for (alias, &weight) in (0..count).zip(weights) {
            bins.push(Bin { pmf: probability(weight) as f32, share: 1.0, alias });
            mass.push(probability(weight) * f64::from(count));
        }
        let (mut small, mut large): (Vec<u32>, Vec<u32>) = (0..count).partition(|&i| mass[i as usize] < 1.0);
        while let (Some(&under), Some(&over)) = (small.last(), large.last()) {
            small.pop();
            bins[under as usize].share = mass[under as usize] as f32;
            bins[under as usize].alias = over;
            mass[over as usize] -= 1.0 - mass[under as usize];
            if mass[over as usize] < 1.0 {
                large.pop();
                small.push(over);
            }
        }
        // What is left over has mass one but for rounding. An outcome without weight must not be among it.
        for &i in &small {
            if bins[i as usize].pmf == 0.0 {
                bins[i as usize].share = 0.0;
                bins[i as usize].alias = heaviest(weights);
            }
        }
        Self { bins }
    }

    /// Number of outcomes.
    pub fn len(&self) -> usize {
        self.bins.len()
    }

    /// Whether there are no outcomes.
    pub fn is_empty(&self) -> bool {
        self.bins.is_empty()
    }

    /// Draws an outcome: its number, its probability, and a number in [0, 1) that is uniform again.
    ///
    /// `u` needs more than the 24 bits of an `f32` where there are more than some thousand outcomes: their number takes
    /// the first bits, and what is left decides between a bin's own outcome and its alias. `None` if there are no outcomes.
    #[inline]
    pub fn sample(&self, u: f64) -> Option<(usize, f32, f32)> {
        let scaled = u * self.bins.len() as f64;
        let index = (scaled as usize).min(self.bins.len().checked_sub(1)?);
        let (bin, within) = (&self.bins[index], ((scaled - index as f64) as f32).min(BELOW_ONE));
        Some(if within < bin.share {
            (index, bin.pmf, (within / bin.share).min(BELOW_ONE))
        } else {
            let rest = ((within - bin.share) / (1.0 - bin.share)).min(BELOW_ONE);
            (bin.alias as usize, self.bins[bin.alias as usize].pmf, rest)
        })
    }

    /// The probability of an outcome; zero if there is no such outcome.
    #[inline]
    pub fn pmf(&self, outcome: usize) -> f32 {
        self.bins.get(outcome).map_or(0.0, |bin| bin.pmf)
    }
}

/// The number of the largest weight.
fn heaviest(weights: &[f32]) -> u32 {
    let mut best = 0;
    for (i, &weight) in weights.iter().enumerate() {
        if usable(weight) > usable(weights[best]) {
            best = i;
        }
    }
    best as u32
}

#[cfg(test)]
mod tests;
