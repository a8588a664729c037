//! Affine maps that change while the shutter is open.
//!
//! The matrices at both ends are taken apart into translation, rotation, and scale with shear, and the parts are interpolated. A wheel
//! that turns then keeps its shape, which it would not if the matrices themselves were interpolated.
//!
//! Deliberately absent: turns of more than half a circle. Between two matrices the way is the shortest; a longer one is given by more
//! maps, one after the other.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Bounds3, Transform, Vec3};

/// Steps that bound a motion. Between two of them a point is as far off the chord as its acceleration allows, which is added: their number
/// decides how tight the box is, not whether it holds.
const BOUND_STEPS: u32 = 64;

/// The decomposition stops here at the latest: each step halves what a matrix is too large or too small by.
const MAX_POLAR_STEPS: u32 = 128;

/// The rows of a 3 × 4 matrix, in the precision in which maps are composed.
pub type Rows = [[f64; 4]; 3];

/// An affine map `p ↦ R(x) S(x) (p − c) + t(x)` that goes from one map to another during a part of the time that the shutter is open.
///
/// `x` runs from 0 to 1; `t` and `S` (scale and shear) are linear in it, `R` is the rotation at the start followed by the part `x` of the
/// shortest rotation to that at the end. Before and after the motion the map is that of the start and of the end. The pivot `c` is the
/// point that goes along a straight line: the origin, unless [`Self::about`] says otherwise.
///
/// Source: Shoemake, Duff, *Matrix Animation and Polar Decomposition*, Graphics Interface 1992; Pharr, Jakob, Humphreys, *Physically
/// Based Rendering*, 4th ed., 2023, section 3.9.8 and Shoemake, *Animating Rotation with Quaternion Curves*, SIGGRAPH 1985, for the
/// interpolation. Deviation: maps that mirror are taken apart as well, by giving the mirroring to `S`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Motion", into = "Motion")]
pub struct AnimatedTransform {
    ends: [Transform; 2],
    times: [f32; 2],
    pivot: DVec3,
    /// Where the pivot is at both ends.
    translation: [DVec3; 2],
    /// The rotation at the start, and from there to that at the end.
    rotation: DMat3,
    axis: DVec3,
    angle: f64,
    stretch: [DMat3; 2],
}

/// What an [`AnimatedTransform`] is made of.
#[derive(Clone, Serialize, Deserialize)]
struct Motion {
    ends: [Transform; 2],
    times: [f32; 2],
    #[serde(default)]
    pivot: [f64; 3],
}

impl AnimatedTransform {
    /// The motion from `start` to `end` between two times, which are fractions of the time that the shutter is open and may lie outside
    /// of 0 … 1: the shutter then sees a part of the motion.
    ///
    /// `None` if one end mirrors and the other does not, because the map between them would be singular, and if the times do not ascend.
    pub fn new(start: Transform, end: Transform, times: [f32; 2]) -> Option<Self> {
        let ascending = times[0] < times[1] && times[0].is_finite() && times[1].is_finite();
        if !ascending || start.swaps_handedness() != end.swaps_handedness() {
            return None;
        }
        let exact = [start, end].map(|end| end.exact());
        let [(first, first_stretch), (last, last_stretch)] = exact.map(|map| polar(map.matrix3));
        let way = DQuat::from_mat3(&last) * DQuat::from_mat3(&first).conjugate();
        let way = if way.w < 0.0 { -way } else { way };
        let sine = way.xyz().length();
        let axis = if sine > 0.0 { way.xyz() / sine } else { DVec3::X };
        Some(Self {
            ends: [start, end],
            times,
            pivot: DVec3::ZERO,
            translation: exact.map(|map| map.translation),
            rotation: first,
            axis,
            angle: 2.0 * sine.atan2(way.w),
            stretch: [first_stretch, last_stretch],
        })
    }

    /// The motion between the same maps in which another point goes along a straight line: `pivot`, in the space that is mapped.
    #[must_use]
    pub fn about(mut self, pivot: [f64; 3]) -> Self {
        self.pivot = DVec3::from(pivot);
        self.translation = self.ends.map(|end| end.exact().transform_point3(self.pivot));
        self
    }

    /// The point that goes along a straight line, in the space that is mapped.
    pub fn pivot(&self) -> [f64; 3] {
        self.pivot.to_array()
    }

    /// The maps before and after the motion.
    pub fn ends(&self) -> &[Transform; 2] {
        &self.ends
    }

    /// The fractions of the time that the shutter is open at which the motion begins and ends.
    pub fn times(&self) -> [f32; 2] {
        self.times
    }

    /// The map at a time, a fraction of the time that the shutter is open: clamped to 0 … 1, NaN counting as zero.
    pub fn at(&self, time: f32) -> Transform {
        let progress = self.progress(time);
        if let Some(end) = self.end_at(progress) {
            return *end;
        }
        // Where the ends are at the limits of what is finite, what lies between them may be beyond.
        Transform::from_exact(self.between(progress)).unwrap_or(self.ends[0])
    }

    /// The rows of the map at a time and those of its inverse, for who computes in `f64`.
    pub fn rows_at(&self, time: f32) -> [Rows; 2] {
        let map = self.exact_at(self.progress(time));
        [map, map.inverse()].map(|map| crate::transform::rows_of(&map))
    }

    /// A box about all that a box passes through while the shutter is open.
    ///
    /// Each corner's path is followed in small steps. On a step of length `h` it leaves its chord by at most `h² / 8` times its greatest
    /// acceleration, `ω² |S p| + 2 ω |S′ p|` at the angular speed `ω`, and by so much the box is widened.
    pub fn bounds(&self, bounds: &Bounds3) -> Bounds3 {
        if bounds.is_empty() {
            return Bounds3::EMPTY;
        }
        let corners = bounds.corners().map(|p| DVec3::new(p.x.into(), p.y.into(), p.z.into()));
        let (first, last) = (self.progress(0.0), self.progress(1.0));
        let step = (last - first) / f64::from(BOUND_STEPS);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for i in 0..=BOUND_STEPS {
            let map = self.exact_at(if i == BOUND_STEPS { last } else { first + f64::from(i) * step });
            for p in corners.map(|corner| map.transform_point3(corner)) {
                (low, high) = (low.min(p), high.max(p));
            }
        }
        let acceleration =
            corners.map(|corner| self.greatest_acceleration(corner)).into_iter().fold(0.0, f64::max);
        // What rounding in f64 may add where terms of this size are added up, many times over.
        let rounding = 1024.0
            * f64::EPSILON
            * corners.map(|corner| self.greatest_term(corner)).into_iter().fold(0.0, f64::max);
        let slack = DVec3::splat(acceleration * step * step / 8.0 + rounding);
        let to_f32 = |p: DVec3| Vec3::new(p.x as f32, p.y as f32, p.z as f32);
        Bounds3 { min: to_f32(low - slack).map(f32::next_down), max: to_f32(high + slack).map(f32::next_up) }
    }

    /// Bounds the second derivative of the path of a point.
    fn greatest_acceleration(&self, p: DVec3) -> f64 {
        let [a, b] = self.stretch.map(|stretch| stretch * (p - self.pivot));
        self.angle * self.angle * a.length().max(b.length()) + 2.0 * self.angle * (b - a).length()
    }

    /// Bounds all that is added up to where a point is.
    fn greatest_term(&self, p: DVec3) -> f64 {
        let reach = p.abs() + self.pivot.abs();
        let term = |end: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| self.stretch[end].col(axis).length() * reach[axis]);
            x + y + z + self.translation[end].length()
        };
        term(0).max(term(1))
    }

    /// How far the motion is at a time.
    #[inline]
    fn progress(&self, time: f32) -> f64 {
        let time = if time > 0.0 { time.min(1.0) } else { 0.0 };
        let [start, end] = self.times.map(f64::from);
        let progress = (f64::from(time) - start) / (end - start);
        progress.clamp(0.0, 1.0)
    }

    /// The end at which the motion is.
    #[inline]
    fn end_at(&self, progress: f64) -> Option<&Transform> {
        match progress {
            0.0 => Some(&self.ends[0]),
            1.0 => Some(&self.ends[1]),
            _ => None,
        }
    }

    #[inline]
    fn exact_at(&self, progress: f64) -> DAffine3 {
        self.end_at(progress).map_or_else(|| self.between(progress), Transform::exact)
    }

    fn between(&self, x: f64) -> DAffine3 {
        let turned = DMat3::from_axis_angle(self.axis, x * self.angle) * self.rotation;
        let [first, last] = self.stretch;
        let [from, to] = self.translation;
        let matrix3 = turned * (first * (1.0 - x) + last * x);
        DAffine3 { matrix3, translation: from * (1.0 - x) + to * x - matrix3 * self.pivot }
    }
}

/// A regular matrix as a rotation after a symmetric matrix, which is definite: positive if the matrix does not mirror, and negative if it
/// does. Mixtures of two positive ones are positive, so that no map between two ends is singular.
///
/// Source: Higham, *Computing the Polar Decomposition—with Applications*, SIAM Journal on Scientific and Statistical Computing 7(4), 1986.
fn polar(matrix: DMat3) -> (DMat3, DMat3) {
    let determinant = matrix.determinant();
    // Of unit volume from the start, and not mirroring: the negative of what does.
    let mut rotation = matrix * (determinant.signum() / determinant.abs().cbrt());
    for _ in 0..MAX_POLAR_STEPS {
        let next = (rotation + rotation.inverse().transpose()) * 0.5;
        let change = (next - rotation).to_cols_array().map(f64::abs).into_iter().fold(0.0, f64::max);
        rotation = next;
        if change <= 4.0 * f64::EPSILON {
            break;
        }
    }
    (rotation, rotation.transpose() * matrix)
}

impl TryFrom<Motion> for AnimatedTransform {
    type Error = &'static str;

    fn try_from(motion: Motion) -> Result<Self, Self::Error> {
        let [start, end] = motion.ends;
        let found =
            Self::new(start, end, motion.times).ok_or("a motion through a singular map, or in no time");
        found.map(|found| found.about(motion.pivot))
    }
}

impl From<AnimatedTransform> for Motion {
    fn from(animated: AnimatedTransform) -> Self {
        Self { ends: animated.ends, times: animated.times, pivot: animated.pivot() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn product(maps: &[Transform]) -> Transform {
        maps.iter().rev().fold(Transform::IDENTITY, |all, map| map.after(&all).unwrap())
    }

    fn motions() -> Vec<AnimatedTransform> {
        let scale = |x, y, z| Transform::scale(x, y, z).unwrap();
        let rotate = |angle, axis| Transform::rotate(angle, axis).unwrap();
        let translate = |x, y, z| Transform::translate(x, y, z).unwrap();
        let sheared =
            Transform::from_rows([[1.0, 0.7, 0.0, 0.0], [0.0, 1.0, -0.3, 2.0], [0.1, 0.0, 1.0, 0.0]])
                .unwrap();
        let ends = [
            (Transform::IDENTITY, translate(1.0, -2.0, 3.0)),
            (Transform::IDENTITY, rotate(3.1, [1.0, 2.0, -0.5])),
            (rotate(-1.0, [0.0, 0.0, 1.0]), rotate(1.0, [0.0, 0.0, 1.0])),
            (
                product(&[translate(5.0, 0.0, 0.0), rotate(0.4, [1.0, 0.0, 0.3]), scale(2.0, 0.5, 1e-3)]),
                product(&[rotate(2.9, [0.2, -1.0, 0.0]), scale(1e3, 1.0, 0.2)]),
            ),
            (sheared, product(&[rotate(0.8, [0.0, 1.0, 0.0]), sheared, scale(0.1, 0.2, 3.0)])),
            (scale(-1.0, 2.0, 3.0), product(&[rotate(1.2, [1.0, 1.0, 0.0]), scale(1.0, -0.5, 1.0)])),
        ];
        let motions = ends.map(|(start, end)| AnimatedTransform::new(start, end, [0.0, 1.0]).unwrap());
        let about = motions.clone().map(|motion| motion.about([0.5, -0.2, 0.3]));
        motions.into_iter().chain(about).collect()
    }

    fn farthest(a: Vec3, b: Vec3) -> f32 {
        (a - b).abs().max_component()
    }

    #[test]
    fn the_ends_are_what_was_given_and_what_is_next_to_them_is_near() {
        let p = Vec3::new(0.3, -0.7, 1.1);
        for motion in motions() {
            let [start, end] = *motion.ends();
            assert_eq!((motion.at(0.0), motion.at(1.0)), (start, end));
            assert_eq!((motion.at(-3.0), motion.at(7.0), motion.at(f32::NAN)), (start, end, start));
            let size = start.point(p).abs().max_component().max(end.point(p).abs().max_component());
            assert!(farthest(motion.at(1e-6).point(p), start.point(p)) < 1e-5 * size, "{motion:?}");
            assert!(farthest(motion.at(1.0 - 1e-6).point(p), end.point(p)) < 1e-5 * size, "{motion:?}");
        }
    }

    #[test]
    fn rotations_stay_rotations_and_scales_are_interpolated() {
        let [_, turn, half, ..] = &motions()[..] else { panic!("there are more") };
        let quarter = Transform::rotate(3.1 * 0.25, [1.0, 2.0, -0.5]).unwrap();
        let p = Vec3::new(0.3, -0.7, 1.1);
        assert!(farthest(turn.at(0.25).point(p), quarter.point(p)) < 1e-6);
        assert!(farthest(half.at(0.5).point(p), p) < 1e-6);
        let growing =
            AnimatedTransform::new(Transform::IDENTITY, Transform::scale(3.0, 5.0, 1.0).unwrap(), [0.0, 1.0]);
        assert!(farthest(growing.unwrap().at(0.5).point(Vec3::ONE), Vec3::new(2.0, 3.0, 1.0)) < 1e-6);
    }

    #[test]
    fn the_pivot_goes_along_a_straight_line() {
        for motion in motions() {
            let pivot = Vec3::from(motion.pivot().map(|x| x as f32));
            let [start, end] = motion.ends().map(|end| end.point(pivot));
            for time in [0.0, 0.1, 0.5, 0.9, 1.0] {
                let on_line = start * (1.0 - time) + end * time;
                let size = start.abs().max_component().max(end.abs().max_component()).max(1.0);
                assert!(farthest(motion.at(time).point(pivot), on_line) < 1e-5 * size, "{motion:?}");
            }
        }
    }

    #[test]
    fn a_part_of_the_shutter_and_a_part_of_the_motion() {
        let end = Transform::translate(4.0, 0.0, 0.0).unwrap();
        let x = |times, time| {
            AnimatedTransform::new(Transform::IDENTITY, end, times).unwrap().at(time).point(Vec3::ZERO).x
        };
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(|time| x([0.25, 0.75], time)), [0.0, 0.0, 2.0, 4.0, 4.0]);
        assert_eq!([-9.0, 0.0, 0.5, 1.0, 9.0].map(|time| x([-1.0, 3.0], time)), [1.0, 1.0, 1.5, 2.0, 2.0]);
        for times in [[0.5, 0.5], [1.0, 0.0], [0.0, f32::NAN], [f32::NEG_INFINITY, 1.0]] {
            assert_eq!(AnimatedTransform::new(Transform::IDENTITY, end, times), None);
        }
        let mirror = Transform::scale(1.0, -1.0, 1.0).unwrap();
        assert_eq!(AnimatedTransform::new(Transform::IDENTITY, mirror, [0.0, 1.0]), None);
    }

    #[test]
    fn the_rows_are_those_of_the_map_and_its_inverse() {
        for motion in motions() {
            for time in [0.0, 0.1, 0.5, 0.9, 1.0] {
                let [forward, inverse] = motion.rows_at(time);
                assert_eq!(Transform::from_rows(forward), Some(motion.at(time)));
                for (i, row) in forward.iter().enumerate() {
                    for j in [0, 1, 2] {
                        let entry: f64 = (0..3).map(|k| row[k] * inverse[k][j]).sum();
                        let size: f64 = (0..3).map(|k| (row[k] * inverse[k][j]).abs()).sum();
                        assert!((entry - f64::from(u8::from(i == j))).abs() <= 1e-13 * size.max(1.0));
                    }
                }
            }
        }
    }

    #[test]
    fn the_box_holds_the_motion_and_is_tight() {
        let still = Bounds3 { min: Vec3::new(-1.0, 0.2, 0.1), max: Vec3::new(0.5, 0.9, 3.0) };
        for motion in motions() {
            let [start, end] = *motion.ends();
            for times in [[0.0, 1.0], [0.3, 0.6], [-2.0, 1.5]] {
                let motion = AnimatedTransform::new(start, end, times).unwrap();
                let bounds = motion.bounds(&still);
                let mut swept = Bounds3::EMPTY;
                for i in 0..=5000 {
                    let map = motion.at(i as f32 / 5000.0);
                    swept = swept.union(map.bounds(&still));
                }
                // The corners here are rounded to f32, so that they may stick out by that much.
                let size = swept.diagonal().max_component();
                let rounding = Vec3::splat(size * 1e-6);
                assert!(bounds.contains(swept.min + rounding) && bounds.contains(swept.max - rounding));
                assert!(bounds.diagonal().max_component() <= size * 1.001, "{bounds:?} about {swept:?}");
            }
        }
        assert!(motions()[0].bounds(&Bounds3::EMPTY).is_empty());
    }
}
