//! How to build.

use crate::kernel::Tier;

/// Which builder makes the trees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Builder {
    /// Halves the primitives at the median along the longest axis.
    ///
    /// Source: Kay, Kajiya, *Ray Tracing Complex Scenes*, SIGGRAPH 1986, for the object median.
    Median,
    /// Splits where the surface area heuristic is least among the borders of a fixed number of bins, on all cores.
    ///
    /// Source: Wald, *On Fast Construction of SAH-based Bounding Volume Hierarchies*, Interactive Ray Tracing 2007.
    #[default]
    BinnedSah,
    /// No tree: every query tests every primitive with the scalar kernels. The oracle of the tests.
    BruteForce,
}

/// Settings of [`crate::Accel::build`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// Which builder makes the trees.
    pub builder: Builder,
    /// Bins an axis of the binned builder, clamped to 2 … 32.
    pub bins: u32,
    /// The instruction set of the queries; `None`, or one that this processor lacks, for the fastest that it has.
    pub tier: Option<Tier>,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { builder: Builder::default(), bins: 16, tier: None }
    }
}
