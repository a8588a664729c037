//! The mathematics that every other crate of Sahl shares.
//!
//! Design decision: one vector type, [`Vec3`], stands for points, directions and normals. What a value means is told
//! by its name and by the method that transforms it ([`Transform::point`], [`Transform::vector`],
//! [`Transform::normal`]). Three types would say it in the signature, but cost a conversion wherever a formula mixes
//! them, and the formulas of this field mix them everywhere.
//!
//! `glam` does the matrix algebra behind [`Transform`] and does not appear in any public signature: it breaks its
//! interface a few times a year, this crate does not.
//!
//! Deliberately absent: colour, randomness, and anything that knows a shape.
#![forbid(unsafe_code)]

mod animated;
mod bounds;
mod float;
mod frame;
mod ray;
mod transform;
mod vector;

pub use animated::{AnimatedTransform, Rows};
pub use bounds::Bounds3;
pub use float::{
    difference_of_products, gamma, lerp, next_float_down, next_float_up, safe_acos, safe_asin, safe_sqrt,
    solve_quadratic,
};
pub use frame::Frame;
pub use ray::{Ray, offset_ray_origin};
pub use transform::Transform;
pub use vector::{Vec2, Vec3};
