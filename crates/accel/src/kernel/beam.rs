//! Which triangles of a block may be hit by which rays of a bundle that start at one point.
//!
//! In the sheared space of the triangle test an edge function is linear in the slopes of the ray: with vertices `p` and `q`, sheared
//! along the middle of the bundle, and a ray whose slopes differ from the middle by (dx, dy),
//!
//! ```text
//! e = p_x q_y − p_y q_x  −  dx (p_z q_y − q_z p_y)  −  dy (p_x q_z − q_x p_z).
//! ```
//!
//! Over a rectangle of slopes its least and greatest value follow at once. A triangle whose edge functions cannot all be at least
//! zero, nor all at most zero, is hit by no ray of the rectangle. The bounds are widened by what both this computation and that of
//! the triangle test may err, so that nothing is left out that a single ray would hit.

use super::block::TriangleBlock;
use super::isa::{Isa, Lanes};
use super::watertight::Relative;
use crate::geometry::triangle::Axis;

/// Groups that a bundle has at most.
pub(crate) const MAX_GROUPS: usize = super::BUNDLE_RAYS / super::WIDTH;

/// The slopes of a bundle whose rays start at one point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beam {
    /// In the order of `axes`.
    pub(super) origin: [f32; 3],
    pub(super) axes: [Axis; 3],
    /// The slopes along which triangles are sheared.
    pub(super) middle: [f32; 2],
    /// How far any ray's slope lies from the middle, at most.
    pub(super) spread: f32,
    pub(super) groups: [SlopeRange; MAX_GROUPS],
}

/// A rectangle of slopes, relative to the middle of a beam.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlopeRange {
    pub(super) center: [f32; 2],
    pub(super) radius: [f32; 2],
}

/// The edge functions of a block's triangles as functions of slopes.
pub(crate) struct BeamEdges<F> {
    /// The vertices relative to the origin of the beam.
    relative: Relative<F>,
    edges: [BeamEdge<F>; 3],
    /// What the bounds are widened by.
    margin: F,
}

struct BeamEdge<F> {
    at_middle: F,
    along: [F; 2],
}

/// With the unit roundoff ε, coordinates below `m`, and sheared ones below `w` for every ray of the beam: a sheared coordinate is off by 3 ε m
/// here and by as much in the triangle test, and the slopes of a rectangle move it by 4 ε m. An edge function is then off by 40 ε m w,
/// and by less than 24 ε w (m + w) from the rounding of products and sums on both sides.
const MARGIN: f32 = 128.0 * 0.5 * f32::EPSILON;

/// By how much the rounding of slopes and their differences may move them: slopes are at most one.
pub(super) const SLOPE_ERROR: f32 = 4.0 * 0.5 * f32::EPSILON;

impl<F: Lanes> BeamEdges<F> {
    /// The edges of the triangles of a block.
    #[inline(always)]
    pub(crate) fn new<I: Isa<F32 = F>>(isa: I, block: TriangleBlock<'_>, beam: &Beam) -> Self {
        // No closures: they would not be compiled for the instruction set.
        let relative = Relative {
            x: relative(isa, block, (beam, 0)),
            y: relative(isa, block, (beam, 1)),
            z: relative(isa, block, (beam, 2)),
        };
        let [middle_x, middle_y] = beam.middle;
        let x = sheared(&relative.x, &relative.z, isa.splat(middle_x));
        let y = sheared(&relative.y, &relative.z, isa.splat(middle_y));
        let vertices = ShearedVertices { x, y, z: relative.z };
        let ShearedVertices { x, y, z } = &vertices;
        let depth = greatest(z);
        let width = greatest(x).max(greatest(y)) + depth * isa.splat(beam.spread);
        let margin = (width * isa.splat(MARGIN)) * (width + depth) + isa.splat(f32::MIN_POSITIVE);
        Self { relative, edges: [vertices.edge(2, 1), vertices.edge(0, 2), vertices.edge(1, 0)], margin }
    }

    /// The vertices as all rays of the beam see them, in memory.
    #[inline(always)]
    pub(crate) fn vertices(&self) -> BeamVertices<F::Array> {
        let Relative { x, y, z } = &self.relative;
        BeamVertices { x: to_arrays(x), y: to_arrays(y), z: to_arrays(z) }
    }

    /// The triangles that rays of a group may hit, one bit each.
    #[inline(always)]
    pub(crate) fn may_hit<I: Isa<F32 = F>>(&self, isa: I, beam: &Beam, group: usize) -> u32 {
        let SlopeRange { center: [dx, dy], radius: [rx, ry] } = beam.groups[group % MAX_GROUPS];
        let (dx, dy, rx, ry) = (isa.splat(dx), isa.splat(dy), isa.splat(rx), isa.splat(ry));
        let zero = isa.splat(0.0);
        let (mut positive, mut negative) = (u32::MAX, u32::MAX);
        for edge in &self.edges {
            let [x, y] = edge.along;
            let middle = edge.at_middle - dx * x - dy * y;
            let radius = rx * x.abs() + ry * y.abs() + self.margin;
            // Comparisons that NaN, the padding of a block, fails.
            positive &= zero.less_or_equal(middle + radius);
            negative &= (middle - radius).less_or_equal(zero);
        }
        positive | negative
    }
}

/// The vertices of a block's triangles relative to the origin of a beam, in memory; axes in the order of the beam's.
pub(crate) struct BeamVertices<A> {
    x: [A; 3],
    y: [A; 3],
    z: [A; 3],
}

impl<A: AsRef<[f32]>> BeamVertices<A> {
    /// A triangle, the same for each of a group of rays.
    #[inline(always)]
    pub(super) fn triangle<W: Lanes>(&self, triangle: usize, like: W) -> Relative<W> {
        let Self { x, y, z } = self;
        Relative { x: spread(x, triangle, like), y: spread(y, triangle, like), z: spread(z, triangle, like) }
    }
}

#[inline(always)]
fn to_arrays<F: Lanes>([p0, p1, p2]: &[F; 3]) -> [F::Array; 3] {
    [p0.to_array(), p1.to_array(), p2.to_array()]
}

#[inline(always)]
fn spread<A: AsRef<[f32]>, W: Lanes>(rows: &[A; 3], triangle: usize, like: W) -> [W; 3] {
    let [p0, p1, p2] = rows;
    let triangle = triangle % super::WIDTH;
    [like.splat(p0.as_ref()[triangle]), like.splat(p1.as_ref()[triangle]), like.splat(p2.as_ref()[triangle])]
}

/// Vertices of triangles, sheared along the middle of a beam.
struct ShearedVertices<F> {
    x: [F; 3],
    y: [F; 3],
    z: [F; 3],
}

impl<F: Lanes> ShearedVertices<F> {
    /// The edge function of two vertices.
    #[inline(always)]
    fn edge(&self, p: usize, q: usize) -> BeamEdge<F> {
        let Self { x, y, z } = self;
        BeamEdge {
            at_middle: x[p] * y[q] - y[p] * x[q],
            along: [z[p] * y[q] - z[q] * y[p], x[p] * z[q] - x[q] * z[p]],
        }
    }
}

/// The vertices' coordinates on one of the beam's axes, relative to its origin.
#[inline(always)]
fn relative<I: Isa>(isa: I, block: TriangleBlock<'_>, (beam, axis): (&Beam, usize)) -> [I::F32; 3] {
    let base = isa.splat(beam.origin[axis]);
    let [p0, p1, p2] = block.rows_of(beam.axes[axis]);
    [isa.load(p0) - base, isa.load(p1) - base, isa.load(p2) - base]
}

#[inline(always)]
fn sheared<F: Lanes>(x: &[F; 3], z: &[F; 3], slope: F) -> [F; 3] {
    [x[0] - slope * z[0], x[1] - slope * z[1], x[2] - slope * z[2]]
}

#[inline(always)]
fn greatest<F: Lanes>(v: &[F; 3]) -> F {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}
