//! Figures about a built structure.

/// Counts, sizes and quality of an acceleration structure, all trees together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Primitives in the trees: triangles, halves of planar patches, curved patches, quadrics, instances.
    pub primitives: u64,
    /// Primitives that were left out: not finite, without surface, with an index out of range; geometries and
    /// groups that do not exist.
    pub dropped: u64,
    /// Nodes, each with up to eight children; zero for the brute-force list.
    pub nodes: u64,
    /// Leaves: blocks of up to eight triangles, and single other primitives. A triangle that was cut stands in several.
    pub leaves: u64,
    /// Nodes on the longest way from a root to a leaf.
    pub depth: u32,
    /// The expected cost of a random ray that meets the world's box, in visits of nodes and tests of blocks, which count
    /// the same. A primitive that is no triangle counts twice, an instance one more than its group. Zero for the brute-force list.
    ///
    /// Source: MacDonald, Booth, *Heuristics for Ray Tracing Using Space Subdivision*, The Visual Computer 6(3), 1990.
    pub sah_cost: f32,
    /// Memory of nodes, vertex copies and primitive lists; without the meshes themselves.
    pub bytes: u64,
}
