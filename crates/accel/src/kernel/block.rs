//! Four triangles with their vertices, and the watertight test on all four.

use sahl_math::{Ray, Vec3};

use super::F32x4;
use crate::geometry::triangle::{self, Shear};

/// Triangles of a block.
pub(crate) const BLOCK_WIDTH: usize = 4;

/// Copies of four triangles' vertices as a structure of arrays. A lane without a triangle holds NaN, which nothing hits.
#[derive(Clone, Debug)]
#[repr(C, align(16))]
pub(crate) struct TriangleBlock {
    /// Axis, vertex, lane.
    coordinates: [[[f32; BLOCK_WIDTH]; 3]; 3],
    ids: [u32; BLOCK_WIDTH],
}

/// A hit with one lane of a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockHit {
    pub(crate) t: f32,
    pub(crate) b1: f32,
    pub(crate) b2: f32,
    pub(crate) id: u32,
}

impl TriangleBlock {
    /// A block without triangles.
    pub(crate) fn empty() -> Self {
        Self { coordinates: [[[f32::NAN; BLOCK_WIDTH]; 3]; 3], ids: [u32::MAX; BLOCK_WIDTH] }
    }

    pub(crate) fn set(&mut self, lane: usize, vertices: [Vec3; 3], id: u32) {
        for (axis, rows) in self.coordinates.iter_mut().enumerate() {
            for (row, vertex) in rows.iter_mut().zip(vertices) {
                row[lane] = vertex[axis];
            }
        }
        self.ids[lane] = id;
    }

    /// How many triangles it holds.
    pub(crate) fn len(&self) -> u64 {
        self.ids.iter().filter(|&&id| id != u32::MAX).count() as u64
    }

    fn vertices(&self, lane: usize) -> [Vec3; 3] {
        let [x, y, z] = &self.coordinates;
        std::array::from_fn(|vertex| Vec3::new(x[vertex][lane], y[vertex][lane], z[vertex][lane]))
    }

    /// Calls `found` for each triangle hit strictly between `ray.t_min` and infinity and at or before `t_max`, in the order
    /// of lanes, until it returns true; returns whether it did.
    ///
    /// The arithmetic is that of [`triangle::intersect`], operation by operation.
    #[inline(always)]
    pub(crate) fn intersect(
        &self,
        ray: &Ray,
        shear: &Shear,
        t_max: f32,
        mut found: impl FnMut(BlockHit) -> bool,
    ) -> bool {
        let [kx, ky, kz] = shear.axes;
        let [sx, sy, sz] = shear.factors.map(F32x4::splat);
        let origin: [f32; 3] = ray.origin.into();
        let relative = |axis: usize| {
            let base = F32x4::splat(origin[axis]);
            let rows = &self.coordinates[axis];
            [F32x4::load(&rows[0]) - base, F32x4::load(&rows[1]) - base, F32x4::load(&rows[2]) - base]
        };
        let (x, y, z) = (relative(kx), relative(ky), relative(kz));
        let shear_x = |i: usize| x[i] - sx * z[i];
        let shear_y = |i: usize| y[i] - sy * z[i];
        let (ax, bx, cx) = (shear_x(0), shear_x(1), shear_x(2));
        let (ay, by, cy) = (shear_y(0), shear_y(1), shear_y(2));
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        let zero = F32x4::splat(0.0);
        let (lowest, highest) = (u.min(v).min(w), u.max(v).max(w));
        // Padding is NaN in all three and fails both comparisons.
        let inside = zero.less_or_equal(lowest) | highest.less_or_equal(zero);
        if inside == 0 {
            return false;
        }
        let (az, bz, cz) = (sz * z[0], sz * z[1], sz * z[2]);
        let det = u + v + w;
        let reciprocal = det.reciprocal();
        let t = (u * az + v * bz + w * cz) * reciprocal;
        let t_min = F32x4::splat(ray.t_min);
        let in_front = zero.less(az.max(bz).max(cz));
        let straddling = inside & in_front & az.min(bz).min(cz).less_or_equal(zero);
        let on_edge = inside & in_front & (u.equal(zero) | v.equal(zero) | w.equal(zero));
        let mut doubtful = 0;
        if straddling != 0 {
            let largest = |rows: [F32x4; 3]| rows[0].abs().max(rows[1].abs()).max(rows[2].abs());
            let reach = largest(x).max(largest(y)).max(largest(z));
            let scale = F32x4::splat(triangle::MARGIN_DETERMINANT) * (reach * reach) * reciprocal.abs();
            let margin = (scale + F32x4::splat(triangle::MARGIN_DEPTH)) * (reach * sz.abs());
            doubtful = straddling & (t - t_min).abs().less_or_equal(margin);
        }
        let in_interval = in_front & t_min.less(t) & t.less_or_equal(F32x4::splat(t_max));
        let mut lanes = inside & in_interval | doubtful | on_edge;
        if lanes == 0 {
            return false;
        }
        let special = doubtful | on_edge;
        let (ts, b1s, b2s) = (t.to_array(), (v * reciprocal).to_array(), (w * reciprocal).to_array());
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % BLOCK_WIDTH;
            lanes &= lanes - 1;
            let mut hit = BlockHit { t: ts[lane], b1: b1s[lane], b2: b2s[lane], id: self.ids[lane] };
            if special >> lane & 1 == 1 {
                match self.decide(ray, shear, (lane, on_edge >> lane & 1 == 1), hit) {
                    Some(decided) if decided.t <= t_max => hit = decided,
                    _ => continue,
                }
            }
            if found(hit) {
                return true;
            }
        }
        false
    }

    /// The hit with a lane for which `f32` is not enough: because an edge function is zero, or because the sign of the
    /// parameter is in doubt.
    #[inline(never)]
    fn decide(
        &self,
        ray: &Ray,
        shear: &Shear,
        (lane, on_edge): (usize, bool),
        hit: BlockHit,
    ) -> Option<BlockHit> {
        let vertices = self.vertices(lane);
        let decided = if on_edge {
            triangle::intersect_sheared(ray, shear, vertices).map(|exact| BlockHit {
                t: exact.t,
                b1: exact.b1,
                b2: exact.b2,
                ..hit
            })?
        } else {
            BlockHit { t: triangle::plane_parameter(ray, vertices).unwrap_or(hit.t), ..hit }
        };
        (decided.t > ray.t_min).then_some(decided)
    }
}
