//! Catmull-Rom splines through values at increasing places.
//!
//! Source: Catmull, Rom, *A Class of Local Interpolating Splines*, 1974; Pharr, Jakob, Humphreys, *Physically Based Rendering*, 3rd
//! ed., 2016, section 8.6, for uneven distances: tangents are differences over two intervals, and over one at the ends.

/// Which four neighbours a value is made of, and with which weights; those outside the table have weight zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Weights {
    first: i32,
    weights: [f32; 4],
}

impl Weights {
    /// The weights at `x`; `None` outside the places.
    #[inline]
    pub(super) fn at(places: &[f32], x: f32) -> Option<Self> {
        let (&first, &last) = (places.first()?, places.last()?);
        if !(first <= x && x <= last) {
            return None;
        }
        let i = (places.partition_point(|&place| place <= x)).min(places.len() - 1) - 1;
        Some(Self::within(places, i, (x - places[i]) / (places[i + 1] - places[i])))
    }

    /// The weights at `t` of the way from place `i` to the next.
    #[inline]
    fn within(places: &[f32], i: usize, t: f32) -> Self {
        let (x0, x1) = (places[i], places[i + 1]);
        let (t2, t3) = (t * t, t * t * t);
        let (start, end) = (2.0 * t3 - 3.0 * t2 + 1.0, 3.0 * t2 - 2.0 * t3);
        let (leaving, arriving) = (t3 - 2.0 * t2 + t, t3 - t2);
        let mut weights = [0.0, start, end, 0.0];
        match i.checked_sub(1) {
            Some(before) => {
                let tangent = leaving * (x1 - x0) / (x1 - places[before]);
                weights[0] -= tangent;
                weights[2] += tangent;
            }
            None => {
                weights[1] -= leaving;
                weights[2] += leaving;
            }
        }
        match places.get(i + 2) {
            Some(after) => {
                let tangent = arriving * (x1 - x0) / (after - x0);
                weights[1] -= tangent;
                weights[3] += tangent;
            }
            None => {
                weights[1] -= arriving;
                weights[2] += arriving;
            }
        }
        Self { first: i as i32 - 1, weights }
    }

    /// The sum of weights times `value`, a function of the index.
    #[inline]
    pub(super) fn sum(&self, mut value: impl FnMut(usize) -> f32) -> f32 {
        let mut sum = 0.0;
        for (index, &weight) in (self.first..).zip(&self.weights) {
            if weight != 0.0 {
                sum += weight * value(index as usize);
            }
        }
        sum
    }
}

/// A cubic between two places, by its values and its slopes over the whole interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    values: [f32; 2],
    slopes: [f32; 2],
}

impl Segment {
    /// The piece of the spline through `value` that begins at place `i`.
    #[inline]
    pub(super) fn new(places: &[f32], i: usize, value: impl Fn(usize) -> f32) -> Self {
        let (width, values) = (places[i + 1] - places[i], [value(i), value(i + 1)]);
        let whole = values[1] - values[0];
        let before = i.checked_sub(1).map(|j| width * (values[1] - value(j)) / (places[i + 1] - places[j]));
        let after = places.get(i + 2).map(|place| width * (value(i + 2) - values[0]) / (place - places[i]));
        Self { values, slopes: [before.unwrap_or(whole), after.unwrap_or(whole)] }
    }

    /// The integral over the interval, whose width counts as one.
    #[inline]
    pub(super) fn integral(&self) -> f32 {
        0.5 * (self.values[0] + self.values[1]) + (self.slopes[0] - self.slopes[1]) / 12.0
    }

    /// The integral up to `t`, and the value there.
    #[inline]
    fn at(&self, t: f32) -> (f32, f32) {
        let ([f0, f1], [d0, d1]) = (self.values, self.slopes);
        let (square, cube) = (3.0 * (f1 - f0) - 2.0 * d0 - d1, 2.0 * (f0 - f1) + d0 + d1);
        let value = f0 + t * (d0 + t * (square + t * cube));
        let integral = t * (f0 + t * (0.5 * d0 + t * (square / 3.0 + t * 0.25 * cube)));
        (integral, value)
    }

    /// Where the integral reaches `target`, by Newton's method with bisection where it leaves the bounds.
    #[inline]
    pub(super) fn solve(&self, target: f32) -> f32 {
        let (mut low, mut high) = (0.0_f32, 1.0_f32);
        let mut t = (target / self.integral()).clamp(0.0, 1.0);
        for _ in 0..NEWTON_STEPS {
            if !(low <= t && t <= high) {
                t = 0.5 * (low + high);
            }
            let (integral, value) = self.at(t);
            if integral < target {
                low = t;
            } else {
                high = t;
            }
            t -= (integral - target) / value;
        }
        if low <= t && t <= high { t } else { 0.5 * (low + high) }
    }
}

/// Each step doubles the digits, or halves the bounds: a dozen is more than `f32` needs.
const NEWTON_STEPS: u32 = 12;

/// Where an increasing spline through `values` has the value `y`; the nearest end if it is outside.
pub(super) fn invert(places: &[f32], values: &[f32], y: f32) -> f32 {
    let last = values.len() - 1;
    if y.is_nan() || y <= values[0] {
        return places[0];
    }
    if y >= values[last] {
        return places[last];
    }
    let i = values.partition_point(|&value| value <= y) - 1;
    let (mut low, mut high) = (0.0_f32, 1.0_f32);
    for _ in 0..f32::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        if Weights::within(places, i, middle).sum(|index| values[index]) < y {
            low = middle;
        } else {
            high = middle;
        }
    }
    sahl_math::lerp(0.5 * (low + high), places[i], places[i + 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACES: [f32; 6] = [0.0, 0.5, 0.7, 1.5, 3.0, 3.1];

    #[test]
    fn lines_are_kept_and_values_are_met() {
        let line = |x: f32| 2.0 + 3.0 * x;
        for x in [0.0, 0.2, 0.5, 0.69, 1.0, 2.9, 3.1] {
            let found = Weights::at(&PLACES, x).unwrap().sum(|i| line(PLACES[i]));
            assert!((found - line(x)).abs() < 1e-5, "{x}: {found}");
        }
        assert_eq!(Weights::at(&PLACES, -0.1), None);
        assert_eq!(Weights::at(&PLACES, 3.2), None);
        assert_eq!(Weights::at(&PLACES, f32::NAN), None);
    }

    #[test]
    fn segments_are_the_spline() {
        let value = |i: usize| [1.0, 4.0, 3.0, 2.0, 2.5, 0.5][i];
        for i in 0..PLACES.len() - 1 {
            let segment = Segment::new(&PLACES, i, value);
            let mut sum = 0.0;
            for k in 0..1000 {
                let t = (k as f32 + 0.5) / 1000.0;
                let expected = Weights::within(&PLACES, i, t).sum(value);
                assert!((segment.at(t).1 - expected).abs() < 1e-4);
                sum += expected / 1000.0;
                assert!((segment.solve(segment.at(t).0) - t).abs() < 1e-4, "{i} {t}");
            }
            assert!((segment.integral() - sum).abs() < 1e-3);
        }
    }

    #[test]
    fn increasing_splines_are_inverted() {
        let values = [0.0, 0.1, 0.4, 0.5, 0.9, 1.0];
        for k in 0..=310 {
            let x = k as f32 / 100.0;
            let y = Weights::at(&PLACES, x).unwrap().sum(|i| values[i]);
            assert!((invert(&PLACES, &values, y) - x).abs() < 1e-3, "{x}");
        }
        assert_eq!((invert(&PLACES, &values, -1.0), invert(&PLACES, &values, 2.0)), (0.0, 3.1));
    }
}
