//! Axis-aligned boxes.

use serde::{Deserialize, Serialize};

use crate::Vec3;

/// An axis-aligned box, closed; empty where `min` exceeds `max`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct Bounds3 {
    /// The corner with the smallest coordinates.
    pub min: Vec3,
    /// The corner with the largest coordinates.
    pub max: Vec3,
}

impl Bounds3 {
    /// The box that holds nothing: neutral for [`Bounds3::union`].
    pub const EMPTY: Self = Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// The smallest box that holds all `points`.
    #[inline]
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::including)
    }

    /// The smallest box that holds this one and `point`.
    #[inline]
    pub fn including(self, point: Vec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The smallest box that holds both.
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The part in both; empty if they do not meet.
    #[inline]
    pub fn intersection(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Whether the box holds no point.
    #[inline]
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// Whether `point` lies inside or on the border.
    #[inline]
    pub fn contains(&self, point: Vec3) -> bool {
        (0..3).all(|axis| self.min[axis] <= point[axis] && point[axis] <= self.max[axis])
    }

    /// Edge lengths.
    #[inline]
    pub fn diagonal(&self) -> Vec3 {
        self.max - self.min
    }

    /// The middle; computed without overflow.
    #[inline]
    pub fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Half the surface area, the measure of the surface area heuristic; zero if empty.
    #[inline]
    pub fn half_area(&self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        let d = self.diagonal();
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// Centre and radius of the sphere about the box; `None` if empty.
    #[inline]
    pub fn bounding_sphere(&self) -> Option<(Vec3, f32)> {
        (!self.is_empty()).then(|| (self.center(), self.diagonal().length() * 0.5))
    }

    /// The eight corners.
    #[inline]
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|corner| {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            Vec3::new(pick(0), pick(1), pick(2))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_is_neutral() {
        let unit = Bounds3 { min: Vec3::ZERO, max: Vec3::ONE };
        assert_eq!(unit.union(Bounds3::EMPTY), unit);
        assert!(Bounds3::EMPTY.is_empty());
        assert_eq!(Bounds3::EMPTY.half_area(), 0.0);
        assert_eq!(unit.half_area(), 3.0);
        assert_eq!(Bounds3::EMPTY.bounding_sphere(), None);
    }

    #[test]
    fn corners_span_the_box() {
        let b = Bounds3 { min: Vec3::new(-1.0, 2.0, 3.0), max: Vec3::new(4.0, 5.0, 6.0) };
        assert_eq!(Bounds3::from_points(b.corners()), b);
        assert!(b.contains(b.center()) && !b.contains(Vec3::ZERO));
        assert!(b.intersection(Bounds3::from_points([Vec3::splat(9.0)])).is_empty());
    }
}
