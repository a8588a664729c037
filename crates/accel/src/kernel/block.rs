//! Eight triangles with their vertices, and the watertight test on all eight.

use sahl_math::Vec3;

use super::WIDTH;
use super::isa::{Isa, Lanes, Row};
use super::prepared::PreparedRay;
use super::watertight::{BlockHit, EdgeFunctions, RayLanes, Relative, Solved};
use crate::geometry::triangle::Axis;

/// Triangles of a block.
pub(crate) const BLOCK_WIDTH: usize = WIDTH;

/// Rows of a block.
pub(crate) const BLOCK_ROWS: usize = 10;

const IDS: usize = 9;

/// Copies of eight triangles' vertices as a structure of arrays. A lane without a triangle holds NaN, which nothing hits.
///
/// Rows: x of vertices 0, 1, 2, then y, then z, then the bits of the ids.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleBlock<'a>(pub(crate) &'a [Row; BLOCK_ROWS]);

/// A block without triangles.
pub(crate) const EMPTY_BLOCK: [Row; BLOCK_ROWS] = {
    let mut rows = [Row::splat(f32::NAN); BLOCK_ROWS];
    rows[IDS] = Row::splat(f32::from_bits(u32::MAX));
    rows
};

/// Writes a triangle into a lane of a block.
pub(crate) fn set_triangle(block: &mut [Row; BLOCK_ROWS], lane: usize, vertices: [Vec3; 3], id: u32) {
    for axis in 0..3 {
        for (i, vertex) in vertices.iter().enumerate() {
            block[3 * axis + i].0[lane] = vertex[axis];
        }
    }
    block[IDS].0[lane] = f32::from_bits(id);
}

/// The first of an axis' three rows, as the distance in bytes from the beginning of the block.
#[derive(Clone, Copy, Debug)]
#[repr(u8)]
pub(super) enum VertexRows {
    X = 0,
    Y = 96,
    Z = 192,
}

const _: () = assert!(VertexRows::Z as usize == 6 * size_of::<Row>());

impl VertexRows {
    /// Those of an axis.
    pub(super) const fn of(axis: Axis) -> Self {
        match axis {
            Axis::X => Self::X,
            Axis::Y => Self::Y,
            Axis::Z => Self::Z,
        }
    }
}

/// The triangles of a block through which a ray's line passes, and all edge functions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossed {
    edges: [Row; 3],
    /// One bit a triangle.
    inside: u32,
}

impl Crossed {
    /// None, to be replaced.
    pub(crate) const NONE: Self = Self { edges: [Row::splat(0.0); 3], inside: 0 };
}

#[inline(always)]
fn ray_lanes<I: Isa>(isa: I, ray: &PreparedRay, limit: f32) -> RayLanes<I::F32> {
    let [sx, sy, sz] = ray.shear_factors();
    let factors = [isa.splat(sx), isa.splat(sy), isa.splat(sz)];
    RayLanes { factors, t_min: isa.splat(ray.t_min()), limit: isa.splat(limit) }
}

impl TriangleBlock<'_> {
    /// How many triangles it holds.
    pub(crate) fn len(self) -> u64 {
        self.0[IDS].0.iter().filter(|id| id.to_bits() != u32::MAX).count() as u64
    }

    pub(crate) fn id(self, lane: usize) -> u32 {
        self.0[IDS].0[lane].to_bits()
    }

    pub(crate) fn vertices(self, lane: usize) -> [Vec3; 3] {
        let coordinate = |axis: usize, vertex: usize| self.0[3 * axis + vertex].0[lane];
        std::array::from_fn(|i| Vec3::new(coordinate(0, i), coordinate(1, i), coordinate(2, i)))
    }

    /// Calls `found` for each triangle hit strictly between `t_min` and infinity and at or before `limit`, in the order
    /// of lanes, until it returns true; returns whether it did.
    #[inline(always)]
    pub(crate) fn intersect<I: Isa>(
        self,
        isa: I,
        ray: &PreparedRay,
        limit: f32,
        found: impl FnMut(BlockHit) -> bool,
    ) -> bool {
        let solved = self.relative_to(isa, ray).solve(&ray_lanes(isa, ray, limit));
        self.offer_hits(&solved, ray, limit, found)
    }

    /// Finds the triangles through which the ray's line passes; returns whether there are any.
    #[inline(always)]
    pub(crate) fn cross<I: Isa>(self, isa: I, ray: &PreparedRay, crossed: &mut Crossed) -> bool {
        let [sx, sy, _] = ray.shear_factors();
        let edges = self.relative_to(isa, ray).edge_functions([isa.splat(sx), isa.splat(sy)]);
        let EdgeFunctions { u, v, w } = edges;
        crossed.edges = [Row(u.to_array()), Row(v.to_array()), Row(w.to_array())];
        crossed.inside = edges.inside(isa.splat(0.0));
        crossed.inside != 0
    }

    /// [`Self::intersect`] for what [`Self::cross`] has found.
    #[inline(always)]
    pub(crate) fn intersect_crossed<I: Isa>(
        self,
        isa: I,
        ray: &PreparedRay,
        (crossed, limit): (&Crossed, f32),
        found: impl FnMut(BlockHit) -> bool,
    ) -> bool {
        let [u, v, w] = &crossed.edges;
        let edges = EdgeFunctions { u: isa.load(u), v: isa.load(v), w: isa.load(w) };
        let lanes = ray_lanes(isa, ray, limit);
        let solved = self.relative_to(isa, ray).solve_inside(&lanes, (&edges, crossed.inside));
        self.offer_hits(&solved, ray, limit, found)
    }

    #[inline(always)]
    fn offer_hits<F: Lanes>(
        self,
        solved: &Solved<F>,
        ray: &PreparedRay,
        limit: f32,
        mut found: impl FnMut(BlockHit) -> bool,
    ) -> bool {
        let mut hits = solved.certain | solved.special;
        if hits == 0 {
            return false;
        }
        let (solved, ray) = (solved.to_arrays(), ray.ray());
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize % BLOCK_WIDTH;
            hits &= hits - 1;
            let triangle = (self.id(lane), || self.vertices(lane));
            if solved.hit(lane, &ray, limit, triangle).is_some_and(&mut found) {
                return true;
            }
        }
        false
    }

    /// The triangles there are, one bit each.
    #[inline(always)]
    pub(crate) fn all<I: Isa>(self, isa: I) -> u32 {
        // Padding is NaN, which is not equal to itself.
        let first = isa.load(&self.0[0]);
        first.equal(first)
    }

    /// The vertices' coordinates on an axis.
    #[inline(always)]
    pub(super) fn rows_of(&self, axis: Axis) -> [&Row; 3] {
        let first = 3 * axis as usize;
        [&self.0[first], &self.0[first + 1], &self.0[first + 2]]
    }

    /// The vertices relative to the ray's origin, in the order of the ray's axes.
    #[inline(always)]
    fn relative_to<I: Isa>(self, isa: I, ray: &PreparedRay) -> Relative<I::F32> {
        Relative {
            x: self.relative(isa, ray, 0),
            y: self.relative(isa, ray, 1),
            z: self.relative(isa, ray, 2),
        }
    }

    #[inline(always)]
    fn relative<I: Isa>(self, isa: I, ray: &PreparedRay, axis: usize) -> [I::F32; 3] {
        let [p0, p1, p2] = self.vertex_rows(ray.orientation().vertices[axis]);
        let base = isa.splat(ray.turned_origin()[axis]);
        [isa.load(p0) - base, isa.load(p1) - base, isa.load(p2) - base]
    }

    #[inline(always)]
    #[expect(
        unsafe_code,
        reason = "three multiplications and comparisons a block, before anything can be loaded"
    )]
    fn vertex_rows(&self, axis: VertexRows) -> &[Row; 3] {
        // SAFETY: each value is the distance of one of the first three triples of ten rows.
        unsafe { &*self.0.as_ptr().byte_add(axis as usize).cast() }
    }
}
