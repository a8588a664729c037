//! What the tests of Sahl share: statistical tests, golden images, energy checks, and geometry that is nasty on purpose.
//!
//! Design decision: everything here takes closures and plain arrays, never a type of the crate under test, so that any
//! crate above `math` and `image` can use it from its tests, and so that a lab can run the same check on formulas of
//! its own. Checks return `Result<_, String>` (or a failure type that displays itself) instead of panicking: the test
//! says `check.run(..).unwrap()`, and a test of a test can ask for the error.
//!
//! All randomness comes from [`random::Rng`] with fixed seeds: a check gives the same verdict on every run and every
//! machine. The significance of a family of checks is shared out by [`stats::per_test`].
//!
//! Deliberately absent: reading scenes, rendering, and anything a release build needs. This crate is a development
//! dependency only.
#![forbid(unsafe_code)]

pub mod chi2;
pub mod furnace;
pub mod golden;
pub mod meshes;
pub mod quadrature;
pub mod random;
pub mod rays;
pub mod stats;
pub mod ztest;
