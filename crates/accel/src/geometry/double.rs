//! The little double-precision algebra that shapes need where `f32` loses digits.

use std::ops::{Add, Mul, Neg, Sub};

use sahl_math::{Rows, Transform, Vec3};

/// Half the distance from one to the next larger `f64`.
const UNIT_ROUNDOFF: f64 = f64::EPSILON * 0.5;

/// Three `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DVec3 {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
}

impl DVec3 {
    #[inline]
    pub(crate) const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    #[inline]
    pub(crate) fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline]
    pub(crate) fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    #[inline]
    pub(crate) fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    #[inline]
    pub(crate) fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }

    #[inline]
    pub(crate) fn to_f32(self) -> Vec3 {
        Vec3::new(self.x as f32, self.y as f32, self.z as f32)
    }

    /// The unit vector in `f32`; `fallback` where there is no direction.
    #[inline]
    pub(crate) fn unit_or(self, fallback: Vec3) -> Vec3 {
        // Products of two lengths within the range of `f32`: their squares neither underflow nor overflow.
        let length = self.length();
        if length > 0.0 && length.is_finite() { (self * (1.0 / length)).to_f32() } else { fallback }
    }

    /// The point in `f32`, and how far it may lie from the true one, known here to within `error`.
    ///
    /// A few roundings in `f64` are allowed for on top of `error`.
    #[inline]
    pub(crate) fn round_with_error(self, error: Self) -> (Vec3, Vec3) {
        let bound = |exact: f64, rounded: f32, error: f64| {
            ((exact - f64::from(rounded)).abs() + 16.0 * UNIT_ROUNDOFF * exact.abs() + error) as f32
        };
        let p = self.to_f32();
        let errors = Vec3::new(
            bound(self.x, p.x, error.x).next_up(),
            bound(self.y, p.y, error.y).next_up(),
            bound(self.z, p.z, error.z).next_up(),
        );
        (p, errors)
    }
}

impl From<Vec3> for DVec3 {
    #[inline]
    fn from(v: Vec3) -> Self {
        Self::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
    }
}

impl Add for DVec3 {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl Sub for DVec3 {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<f64> for DVec3 {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl Neg for DVec3 {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

/// An affine map applied in double precision, with its inverse.
#[derive(Clone, Debug)]
pub(crate) struct DoubleTransform {
    forward: Rows,
    inverse: Rows,
}

impl DoubleTransform {
    pub(crate) fn new(transform: &Transform) -> Self {
        Self { forward: transform.to_rows(), inverse: transform.inverse().to_rows() }
    }

    /// From the rows of a map and of its inverse.
    pub(crate) fn from_rows([forward, inverse]: [Rows; 2]) -> Self {
        Self { forward, inverse }
    }

    #[inline]
    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        apply(&self.forward, p, 1.0)
    }

    #[inline]
    pub(crate) fn inverse_point(&self, p: DVec3) -> DVec3 {
        apply(&self.inverse, p, 1.0)
    }

    #[inline]
    pub(crate) fn inverse_vector(&self, v: DVec3) -> DVec3 {
        apply(&self.inverse, v, 0.0)
    }

    /// A normal, by the transposed inverse: not flipped where the map mirrors.
    #[inline]
    pub(crate) fn normal(&self, n: DVec3) -> DVec3 {
        let m = &self.inverse;
        DVec3::new(
            m[0][0] * n.x + m[1][0] * n.y + m[2][0] * n.z,
            m[0][1] * n.x + m[1][1] * n.y + m[2][1] * n.z,
            m[0][2] * n.x + m[1][2] * n.y + m[2][2] * n.z,
        )
    }

    /// How far the image may move when each coordinate moves by at most `error`.
    #[inline]
    pub(crate) fn spread(&self, error: DVec3) -> DVec3 {
        let m = &self.forward;
        let row = |i: usize| m[i][0].abs() * error.x + m[i][1].abs() * error.y + m[i][2].abs() * error.z;
        DVec3::new(row(0), row(1), row(2))
    }

    /// The largest rounding error of [`Self::point`] and of the inverse map that undoes it.
    #[inline]
    pub(crate) fn rounding(&self, p: DVec3) -> DVec3 {
        let moved = DVec3::new(self.forward[0][3], self.forward[1][3], self.forward[2][3]).abs();
        (self.spread(p.abs()) + moved) * Self::rounding_of(1.0)
    }

    /// [`Self::rounding`] where the sum of the absolute values of all that is added up is known.
    #[inline]
    pub(crate) fn rounding_of(sum: f64) -> f64 {
        sum * (32.0 * UNIT_ROUNDOFF)
    }

    /// The rows of the linear part.
    pub(crate) fn rows(&self) -> &[[f64; 4]; 3] {
        &self.forward
    }
}

#[inline]
fn apply(rows: &[[f64; 4]; 3], v: DVec3, w: f64) -> DVec3 {
    let dot = |row: &[f64; 4]| row[0] * v.x + row[1] * v.y + row[2] * v.z + row[3] * w;
    DVec3::new(dot(&rows[0]), dot(&rows[1]), dot(&rows[2]))
}
