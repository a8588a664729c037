//! The watertight test on eight lanes, whatever differs between them: the triangles, or the rays.
//!
//! The arithmetic is that of [`triangle::intersect`], operation by operation. No operation is fused with another: the sign of
//! an edge function must come out reversed for the triangle on the other side of the edge.

use sahl_math::{Ray, Vec3};

use super::isa::Lanes;
use crate::geometry::triangle::{self, Shear};

/// A hit of a ray with a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockHit {
    pub(crate) t: f32,
    pub(crate) b1: f32,
    pub(crate) b2: f32,
    pub(crate) id: u32,
}

/// Vertices relative to the ray's origin: axis in the order of [`Shear::axes`], vertex.
pub(super) struct Relative<F> {
    pub(super) x: [F; 3],
    pub(super) y: [F; 3],
    pub(super) z: [F; 3],
}

/// What else the test asks of rays.
pub(super) struct RayLanes<F> {
    /// [`Shear::factors`].
    pub(super) factors: [F; 3],
    pub(super) t_min: F,
    /// The largest parameter that counts.
    pub(super) limit: F,
}

/// Hits in the lanes that have one.
pub(crate) struct Solved<F> {
    /// The lanes that are hit for certain, one bit each.
    pub(super) certain: u32,
    /// The lanes that need a closer look.
    pub(super) special: u32,
    /// Those of the special ones in which an edge function is zero.
    on_edge: u32,
    pub(super) t: F,
    pub(super) b1: F,
    pub(super) b2: F,
}

/// [`Solved`] in memory, for lanes that are looked at one by one.
pub(super) struct SolvedArrays<A> {
    special: u32,
    on_edge: u32,
    t: A,
    b1: A,
    b2: A,
}

/// Twice the signed areas that the ray spans with the edges, each opposite to one vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeFunctions<F> {
    pub(super) u: F,
    pub(super) v: F,
    pub(super) w: F,
}

impl<F: Lanes> Solved<F> {
    #[inline(always)]
    pub(super) fn to_arrays(&self) -> SolvedArrays<F::Array> {
        let (t, b1, b2) = (self.t.to_array(), self.b1.to_array(), self.b2.to_array());
        SolvedArrays { special: self.special, on_edge: self.on_edge, t, b1, b2 }
    }
}

impl<A: AsRef<[f32]>> SolvedArrays<A> {
    /// The hit of one of the lanes; `None` if a closer look finds none at or before `limit`.
    #[inline(always)]
    pub(super) fn hit(
        &self,
        lane: usize,
        ray: &Ray,
        limit: f32,
        (id, vertices): (u32, impl FnOnce() -> [Vec3; 3]),
    ) -> Option<BlockHit> {
        let [t, b1, b2] = [&self.t, &self.b1, &self.b2].map(|lanes| lanes.as_ref()[lane]);
        let hit = BlockHit { t, b1, b2, id };
        if self.special >> lane & 1 == 0 {
            return Some(hit);
        }
        let decided = if self.on_edge >> lane & 1 == 1 {
            decide_on_edge(hit, ray, &vertices())
        } else {
            decide_in_front(hit, ray, vertices())
        };
        decided.filter(|hit| hit.t <= limit)
    }
}

/// The hit for which `f32` is not enough, because an edge function is zero.
#[inline(never)]
fn decide_on_edge(hit: BlockHit, ray: &Ray, vertices: &[Vec3; 3]) -> Option<BlockHit> {
    let ray = &Ray { t_min: ray.t_min.max(0.0), ..*ray };
    let exact = triangle::intersect_sheared(ray, &Shear::new(ray.direction), *vertices)?;
    (exact.t > ray.t_min).then_some(BlockHit { t: exact.t, b1: exact.b1, b2: exact.b2, ..hit })
}

/// The hit for which `f32` is not enough, because the sign of the parameter is in doubt. Every ray that leaves a surface meets its own
/// triangle here, and most often from behind.
#[inline(always)]
fn decide_in_front(hit: BlockHit, ray: &Ray, vertices: [Vec3; 3]) -> Option<BlockHit> {
    let crossing = triangle::PlaneCrossing::new(ray, vertices);
    if crossing.is_behind() {
        return None;
    }
    let t = crossing.parameter().unwrap_or(hit.t);
    (t > ray.t_min.max(0.0)).then_some(BlockHit { t, ..hit })
}

impl<F: Lanes> Relative<F> {
    /// The hits strictly between `t_min` and infinity and at or before the limit.
    ///
    #[inline(always)]
    pub(super) fn solve(&self, ray: &RayLanes<F>) -> Solved<F> {
        let [sx, sy, _] = ray.factors;
        let edges = self.edge_functions([sx, sy]);
        self.solve_inside(ray, (&edges, edges.inside(self.z[0].splat(0.0))))
    }

    /// [`Self::solve`] given the edge functions and in which lanes no two of a triangle's differ in sign.
    ///
    /// Where nothing is left that could be a hit it ends early, with parameters and weights that mean nothing.
    #[inline(always)]
    pub(super) fn solve_inside(
        &self,
        ray: &RayLanes<F>,
        (edges, inside): (&EdgeFunctions<F>, u32),
    ) -> Solved<F> {
        let [_, _, scale] = ray.factors;
        let zero = scale.splat(0.0);
        let [a, b, c] = [scale * self.z[0], scale * self.z[1], scale * self.z[2]];
        // The signs of the depths are exact. A triangle behind the origin cannot be hit.
        let in_front = inside & zero.less(a.max(b).max(c));
        let on_edge = in_front & (edges.u.equal(zero) | edges.v.equal(zero) | edges.w.equal(zero));
        let straddling = in_front & !on_edge & a.min(b).min(c).less_or_equal(zero);
        // Every ray that leaves a surface meets its own triangle here.
        let behind = if straddling == 0 { 0 } else { straddling & self.behind(ray) };
        let left = in_front & !behind;
        if left == 0 {
            return Solved { certain: 0, special: 0, on_edge: 0, t: zero, b1: zero, b2: zero };
        }
        let reciprocal = (edges.u + edges.v + edges.w).reciprocal();
        let t = (edges.u * a + edges.v * b + edges.w * c) * reciprocal;
        let straddling = straddling & !behind;
        let doubtful = if straddling == 0 { 0 } else { straddling & self.doubtful(ray, (t, reciprocal)) };
        let special = doubtful | on_edge;
        let in_interval = ray.t_min.less(t) & t.less_or_equal(ray.limit);
        let certain = left & in_interval & !special;
        Solved { certain, special, on_edge, t, b1: edges.v * reciprocal, b2: edges.w * reciprocal }
    }

    /// The edge functions of rays with these slopes.
    #[inline(always)]
    pub(super) fn edge_functions(&self, [sx, sy]: [F; 2]) -> EdgeFunctions<F> {
        let [ax, bx, cx] = sheared(&self.x, &self.z, sx);
        let [ay, by, cy] = sheared(&self.y, &self.z, sy);
        EdgeFunctions { u: cx * by - cy * bx, v: ax * cy - ay * cx, w: bx * ay - by * ax }
    }

    /// The lanes in which the parameter at the triangle's plane is negative for certain, so that [`PlaneCrossing::is_behind`] says so too:
    /// that of most rays at the triangle that they have just left.
    ///
    /// With the normal n = (p₁−p₀) × (p₂−p₀) it has the sign of (n·p₀) (n·d). With the unit roundoff ε, sizes gᵢ of the two edges' coordinates
    /// that bound the vertices they are made of, and Pᵢ = gⱼ hₖ + gₖ hⱼ, a coordinate of an edge is off by 2.1 ε gᵢ, one of n by
    /// 6.3 ε Pᵢ, and the two products by less than 11 ε Σ Pᵢ |p₀ᵢ| and, for n·d over the longest coordinate of d, 15 ε Σ Pᵢ, as no coordinate
    /// of d over that is more than one. The sums are computed with an error that 16 allows for, and what products lose that leave the normal range by the last terms.
    #[inline(always)]
    fn behind(&self, ray: &RayLanes<F>) -> u32 {
        const BOUND: f32 = 16.0 * 0.5 * f32::EPSILON;
        // Far above what is lost, so that the products with it are seldom subnormal, which takes a processor a hundred cycles.
        const TINY: f32 = f32::MIN_POSITIVE * 1e12;
        let [sx, sy, scale] = ray.factors;
        let (x, y, z) = (Edges::new(&self.x), Edges::new(&self.y), Edges::new(&self.z));
        let (nx, px) = y.cross(&z);
        let (ny, py) = z.cross(&x);
        let (nz, pz) = x.cross(&y);
        let (ax, ay, az) = (self.x[0].abs(), self.y[0].abs(), self.z[0].abs());
        let (tiny, bound) = (scale.splat(TINY), scale.splat(BOUND));
        let distance = nx * self.x[0] + ny * self.y[0] + nz * self.z[0];
        let distance_bound = bound * (px * ax + py * ay + pz * az) + tiny * (ax + ay + az) + tiny;
        let speed = nx * sx + ny * sy + nz;
        let speed_bound = bound * (px + py + pz) + tiny;
        let certain = distance_bound.less(distance.abs()) & speed_bound.less(speed.abs());
        certain & (distance * (speed * scale)).less(scale.splat(0.0))
    }

    /// The lanes in which `f32` cannot tell on which side of `t_min` the hit lies.
    #[inline(always)]
    fn doubtful(&self, ray: &RayLanes<F>, (t, reciprocal): (F, F)) -> u32 {
        let [_, _, scale] = ray.factors;
        let reach = largest(&self.x).max(largest(&self.y)).max(largest(&self.z));
        let determinant = reach.splat(triangle::MARGIN_DETERMINANT) * (reach * reach) * reciprocal.abs();
        let margin = (determinant + reach.splat(triangle::MARGIN_DEPTH)) * (reach * scale.abs());
        (t - ray.t_min).abs().less_or_equal(margin)
    }
}

/// The coordinates of two edges from vertex 0 on an axis, and what bounds them as well as their errors.
struct Edges<F> {
    edges: [F; 2],
    sizes: [F; 2],
}

impl<F: Lanes> Edges<F> {
    #[inline(always)]
    fn new([p0, p1, p2]: &[F; 3]) -> Self {
        let size = p0.abs();
        Self { edges: [*p1 - *p0, *p2 - *p0], sizes: [p1.abs() + size, p2.abs() + size] }
    }

    /// A coordinate of the vector product, from those on the two other axes, and the sum of the sizes of its two terms.
    #[inline(always)]
    fn cross(&self, next: &Self) -> (F, F) {
        let ([e1, e2], [f1, f2]) = (self.edges, next.edges);
        let ([g1, g2], [h1, h2]) = (self.sizes, next.sizes);
        (e1 * f2 - f1 * e2, g1 * h2 + h1 * g2)
    }
}

#[inline(always)]
fn sheared<F: Lanes>(x: &[F; 3], z: &[F; 3], factor: F) -> [F; 3] {
    [x[0] - factor * z[0], x[1] - factor * z[1], x[2] - factor * z[2]]
}

#[inline(always)]
fn largest<F: Lanes>(x: &[F; 3]) -> F {
    x[0].abs().max(x[1].abs()).max(x[2].abs())
}

impl<F: Lanes> EdgeFunctions<F> {
    /// The lanes in which no two differ in sign. Padding is NaN in all three and not among them.
    #[inline(always)]
    pub(super) fn inside(&self, zero: F) -> u32 {
        let lowest = self.u.min(self.v).min(self.w);
        let highest = self.u.max(self.v).max(self.w);
        zero.less_or_equal(lowest) | highest.less_or_equal(zero)
    }
}
