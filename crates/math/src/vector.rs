//! Two- and three-component vectors of `f32`.

use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign};

use serde::{Deserialize, Serialize};

use crate::difference_of_products;

/// A pair of `f32`: a point on the image plane, a texture coordinate, a random number in the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(C)]
#[serde(from = "[f32; 2]", into = "[f32; 2]")]
pub struct Vec2 {
    /// First component.
    pub x: f32,
    /// Second component.
    pub y: f32,
}

/// Three `f32`: a point, a direction or a normal (see the crate's documentation).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(C)]
#[serde(from = "[f32; 3]", into = "[f32; 3]")]
pub struct Vec3 {
    /// First component.
    pub x: f32,
    /// Second component.
    pub y: f32,
    /// Third component.
    pub z: f32,
}

/// The operators that act on each component apart, and the conversions from and to arrays.
macro_rules! componentwise {
    ($Vec:ident, $n:literal, $($c:ident = $i:tt),+) => {
        impl $Vec {
            /// All components zero.
            pub const ZERO: Self = Self::splat(0.0);
            /// All components one.
            pub const ONE: Self = Self::splat(1.0);

            /// The vector with the given components.
            #[inline]
            pub const fn new($($c: f32),+) -> Self {
                Self { $($c),+ }
            }

            /// All components equal to `value`.
            #[inline]
            pub const fn splat(value: f32) -> Self {
                Self { $($c: value),+ }
            }

            /// Applies `f` to each component.
            #[inline]
            pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
                Self { $($c: f(self.$c)),+ }
            }

            /// Applies `f` to each pair of components.
            #[inline]
            pub fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
                Self { $($c: f(self.$c, other.$c)),+ }
            }

            /// The smaller of each pair of components; `other`'s where `self`'s is NaN.
            #[inline]
            pub fn min(self, other: Self) -> Self {
                self.zip(other, |a, b| if a < b { a } else { b })
            }

            /// The larger of each pair of components; `other`'s where `self`'s is NaN.
            #[inline]
            pub fn max(self, other: Self) -> Self {
                self.zip(other, |a, b| if a > b { a } else { b })
            }

            /// The absolute value of each component.
            #[inline]
            pub fn abs(self) -> Self {
                self.map(f32::abs)
            }

            /// The scalar product.
            #[inline]
            pub fn dot(self, other: Self) -> f32 {
                let product = self * other;
                0.0 $(+ product.$c)+
            }

            /// The squared Euclidean length.
            #[inline]
            pub fn length_squared(self) -> f32 {
                self.dot(self)
            }

            /// The Euclidean length.
            #[inline]
            pub fn length(self) -> f32 {
                self.length_squared().sqrt()
            }

            /// Whether no component is infinite or NaN.
            #[inline]
            pub fn is_finite(self) -> bool {
                true $(&& self.$c.is_finite())+
            }

            /// Whether any component is NaN.
            #[inline]
            pub fn is_nan(self) -> bool {
                false $(|| self.$c.is_nan())+
            }
        }

        impl Add for $Vec {
            type Output = Self;
            #[inline]
            fn add(self, other: Self) -> Self {
                Self { $($c: self.$c + other.$c),+ }
            }
        }

        impl Sub for $Vec {
            type Output = Self;
            #[inline]
            fn sub(self, other: Self) -> Self {
                Self { $($c: self.$c - other.$c),+ }
            }
        }

        impl Mul for $Vec {
            type Output = Self;
            #[inline]
            fn mul(self, other: Self) -> Self {
                Self { $($c: self.$c * other.$c),+ }
            }
        }

        impl Mul<f32> for $Vec {
            type Output = Self;
            #[inline]
            fn mul(self, factor: f32) -> Self {
                Self { $($c: self.$c * factor),+ }
            }
        }

        impl Mul<$Vec> for f32 {
            type Output = $Vec;
            #[inline]
            fn mul(self, vector: $Vec) -> $Vec {
                vector * self
            }
        }

        impl Div<f32> for $Vec {
            type Output = Self;
            #[inline]
            fn div(self, divisor: f32) -> Self {
                Self { $($c: self.$c / divisor),+ }
            }
        }

        impl Neg for $Vec {
            type Output = Self;
            #[inline]
            fn neg(self) -> Self {
                Self { $($c: -self.$c),+ }
            }
        }

        impl AddAssign for $Vec {
            #[inline]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl SubAssign for $Vec {
            #[inline]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }

        impl MulAssign<f32> for $Vec {
            #[inline]
            fn mul_assign(&mut self, factor: f32) {
                *self = *self * factor;
            }
        }

        impl Index<usize> for $Vec {
            type Output = f32;
            #[inline]
            fn index(&self, axis: usize) -> &f32 {
                match axis {
                    $($i => &self.$c,)+
                    _ => panic!("axis {axis} of a vector with {} components", $n),
                }
            }
        }

        impl IndexMut<usize> for $Vec {
            #[inline]
            fn index_mut(&mut self, axis: usize) -> &mut f32 {
                match axis {
                    $($i => &mut self.$c,)+
                    _ => panic!("axis {axis} of a vector with {} components", $n),
                }
            }
        }

        impl From<[f32; $n]> for $Vec {
            #[inline]
            fn from([$($c),+]: [f32; $n]) -> Self {
                Self { $($c),+ }
            }
        }

        impl From<$Vec> for [f32; $n] {
            #[inline]
            fn from(vector: $Vec) -> Self {
                [$(vector.$c),+]
            }
        }
    };
}

componentwise!(Vec2, 2, x = 0, y = 1);
componentwise!(Vec3, 3, x = 0, y = 1, z = 2);

impl Vec3 {
    /// The unit vector along x.
    pub const X: Self = Self::new(1.0, 0.0, 0.0);
    /// The unit vector along y.
    pub const Y: Self = Self::new(0.0, 1.0, 0.0);
    /// The unit vector along z.
    pub const Z: Self = Self::new(0.0, 0.0, 1.0);

    /// The vector product, each component with one rounding (see [`difference_of_products`]).
    #[inline]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            difference_of_products(self.y, other.z, self.z, other.y),
            difference_of_products(self.z, other.x, self.x, other.z),
            difference_of_products(self.x, other.y, self.y, other.x),
        )
    }

    /// The vector of length one in the same direction; NaN for the zero vector.
    #[inline]
    pub fn normalize(self) -> Self {
        self / self.length()
    }

    /// The vector of length one in the same direction, or `None` where it has no direction: zero or not finite.
    #[inline]
    pub fn try_normalize(self) -> Option<Self> {
        let length = self.length();
        (length > 0.0 && length.is_finite()).then(|| self / length)
    }

    /// This vector, turned round if needed to lie in the hemisphere about `direction`.
    #[inline]
    pub fn face_forward(self, direction: Self) -> Self {
        if self.dot(direction) < 0.0 { -self } else { self }
    }

    /// The index of the component that is largest in absolute value (the first of equals).
    #[inline]
    pub fn max_axis(self) -> usize {
        let a = self.abs();
        if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        }
    }

    /// The largest component.
    #[inline]
    pub fn max_component(self) -> f32 {
        self.x.max(self.y).max(self.z)
    }

    /// The smallest component.
    #[inline]
    pub fn min_component(self) -> f32 {
        self.x.min(self.y).min(self.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cross_is_perpendicular_and_right_handed() {
        assert_eq!(Vec3::X.cross(Vec3::Y), Vec3::Z);
        let (a, b) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(-2.0, 0.5, 4.0));
        let c = a.cross(b);
        assert_eq!(c.dot(a), 0.0);
        assert_eq!(c.dot(b), 0.0);
    }

    #[test]
    fn cross_of_nearly_parallel_vectors_keeps_its_digits() {
        let a = Vec3::new(33962.035, 41563.4, 7706.415);
        let b = Vec3::new(-24871.969, -30438.8, -5643.727);
        let exact = [1556.0276, -1257.5151, -75.1656];
        let c = a.cross(b);
        for axis in 0..3 {
            assert!((c[axis] - exact[axis]).abs() < 0.02, "axis {axis}: {} against {}", c[axis], exact[axis]);
        }
    }

    #[test]
    fn zero_and_infinite_vectors_have_no_direction() {
        assert_eq!(Vec3::ZERO.try_normalize(), None);
        assert_eq!(Vec3::splat(f32::INFINITY).try_normalize(), None);
        assert_eq!((Vec3::X * 3.0).try_normalize(), Some(Vec3::X));
    }

    #[test]
    fn the_longest_axis_is_found_by_magnitude() {
        assert_eq!(Vec3::new(1.0, -5.0, 3.0).max_axis(), 1);
        assert_eq!(Vec3::ZERO.max_axis(), 0);
    }
}
