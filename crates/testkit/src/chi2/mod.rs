//! Pearson's chi² test of samples against the density they claim to have.
//!
//! Every pair of a sampling routine and its density goes through here. The domain is cut into bins; the counts of many
//! independent samples are compared with the integrals of the density over the bins. What the density leaves below one
//! is the expected share of failed samples (`None`), and is a bin like any other, so that a density with a wrong
//! normalisation is found as surely as one with a wrong shape.
//!
//! On two-dimensional domains the sums over rows and over columns are tested as well: they have far fewer degrees of
//! freedom, and so see a drift along one axis that drowns in the full table. The significance is shared by the three.
//!
//! Deliberately absent: delta lobes. A sample of a discrete lobe has a probability and no density; [`DiscreteTest`]
//! tests the choice among such lobes.
//!
//! Source: Subr, Arvo, *Statistical Hypothesis Testing for Assessing Monte Carlo Estimators*, 2007; the use on BSDFs
//! follows Jakob's `chi2test` in Nori.

mod discrete;
mod pearson;
mod plane;
mod sphere;

pub use discrete::DiscreteTest;
pub use pearson::{Pearson, pearson};
pub use plane::{LineTest, SquareTest};
pub use sphere::SphereTest;

/// The seed of the samples of every test: verdicts repeat.
const SEED: u64 = 0x05AE_71C0_2F0A_C0DE;
