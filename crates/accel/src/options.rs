//! How to build.

use crate::kernel::Tier;

/// Which builder makes the trees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Builder {
    /// Halves the primitives at the median along the longest axis.
    ///
    /// Source: Kay, Kajiya, *Ray Tracing Complex Scenes*, SIGGRAPH 1986, for the object median.
    Median,
    /// Splits where the surface area heuristic is least, on all cores, cuts large triangles where that pays, and improves the
    /// top of the tree afterwards.
    ///
    /// Source: Wald, *On Fast Construction of SAH-based Bounding Volume Hierarchies*, Interactive Ray Tracing 2007; Stich, Friedrich,
    /// Dietrich, *Spatial Splits in Bounding Volume Hierarchies*, High Performance Graphics 2009; Meister, Bittner, *Parallel
    /// Reinsertion for Bounding Volume Hierarchy Optimization*, Computer Graphics Forum 37(2), 2018.
    #[default]
    BinnedSah,
    /// [`Self::BinnedSah`] with more cuts and more improvement, for several times the time.
    HighQuality,
    /// For previews: neighbours on a space-filling curve share a block, and the surface area heuristic divides the blocks. Quicker to
    /// build than [`Self::BinnedSah`], and slower to trace.
    ///
    /// Source: Lauterbach, Garland, Sengupta, Luebke, Manocha, *Fast BVH Construction on GPUs*, Computer Graphics Forum 28(2), 2009,
    /// the other way round.
    Fast,
    /// No tree: every query tests every primitive with the scalar kernels. The oracle of the tests.
    BruteForce,
}

/// Settings of [`crate::Accel::build`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// Which builder makes the trees.
    pub builder: Builder,
    /// Bins an axis of the binned builder, clamped to 2 … 16.
    pub bins: u32,
    /// The instruction set of the queries; `None`, or one that this processor lacks, for the fastest that it has.
    pub tier: Option<Tier>,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { builder: Builder::default(), bins: 16, tier: None }
    }
}
