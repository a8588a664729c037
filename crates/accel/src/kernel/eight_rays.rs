//! Eight rays prepared together, with a ray in each lane: the arithmetic of one, lane by lane.

use std::mem::offset_of;

use sahl_math::{Ray, Vec3};

use super::WIDTH;
use super::isa::{Isa, Lanes, Row};
use super::node::EXIT_WIDENING;
use super::prepared::{Orientation, PreparedRay};

/// Eight rays, one a lane; a row for each coordinate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EightRays<F> {
    /// The numbers of each ray.
    numbers: [F; WIDTH],
    pub(super) origin: [F; 3],
    pub(super) direction: [F; 3],
    /// At least zero.
    pub(super) t_min: F,
    pub(super) t_max: F,
}

impl<F: Lanes> EightRays<F> {
    #[inline(always)]
    pub(crate) fn load<I: Isa<F32 = F>>(isa: I, [a, b, c, d, e, f, g, h]: &[Ray; WIDTH]) -> Self {
        const NONE: f32 = f32::NEG_INFINITY;
        // Negative parameters lie behind the origin and never count.
        let least = isa.load(&Row([NONE, NONE, NONE, NONE, NONE, NONE, 0.0, NONE]));
        // Written out: a closure would not have the instruction set of the function around it.
        let numbers = [
            isa.load_unaligned(numbers(a)).max(least),
            isa.load_unaligned(numbers(b)).max(least),
            isa.load_unaligned(numbers(c)).max(least),
            isa.load_unaligned(numbers(d)).max(least),
            isa.load_unaligned(numbers(e)).max(least),
            isa.load_unaligned(numbers(f)).max(least),
            isa.load_unaligned(numbers(g)).max(least),
            isa.load_unaligned(numbers(h)).max(least),
        ];
        let [ox, oy, oz, dx, dy, dz, t_min, t_max] = isa.transpose(numbers);
        Self { numbers, origin: [ox, oy, oz], direction: [dx, dy, dz], t_min, t_max }
    }

    /// Which of the rays can hit anything, one bit each.
    #[inline(always)]
    fn usable(&self) -> u32 {
        let Self { origin: [ox, oy, oz], direction: [dx, dy, dz], .. } = *self;
        let zero = ox.splat(0.0);
        // Zero times what is infinite or NaN is NaN.
        let (x, y, z) = (ox * zero + dx * zero, oy * zero + dy * zero, oz * zero + dz * zero);
        (x + y + z).equal(zero) & zero.less(dx.abs() + dy.abs() + dz.abs()) & self.t_min.less(self.t_max)
    }
}

const _: () = assert!(offset_of!(Ray, origin) == 0 && offset_of!(Ray, direction) == size_of::<Vec3>());
const _: () = assert!(size_of::<Vec3>() == 3 * size_of::<f32>());
const _: () = assert!(offset_of!(Ray, t_min) == 6 * size_of::<f32>());
const _: () = assert!(offset_of!(Ray, t_max) == 7 * size_of::<f32>());

/// Fewer than eight rays, and then some that hit nothing.
#[inline(always)]
pub(super) fn filled_up(rays: &[Ray]) -> [Ray; WIDTH] {
    let mut all = [Ray::new(Vec3::ZERO, Vec3::ZERO); WIDTH];
    all[..rays.len()].copy_from_slice(rays);
    all
}

/// Origin, direction, `t_min` and `t_max` of a ray.
#[inline(always)]
#[expect(unsafe_code, reason = "one load instead of eight")]
fn numbers(ray: &Ray) -> &[f32; WIDTH] {
    // SAFETY: a ray begins with these eight numbers, as is asserted above.
    unsafe { &*std::ptr::from_ref(ray).cast() }
}

/// Along which axis rays are longest, one bit each: x where no bit is set.
#[derive(Clone, Copy)]
struct LongestAxis {
    y: u32,
    /// Whatever the bit of `y` is.
    z: u32,
}

impl LongestAxis {
    #[inline(always)]
    fn new<F: Lanes>([x, y, z]: [F; 3]) -> Self {
        let (x, y, z) = (x.abs(), y.abs(), z.abs());
        Self { y: x.less(y), z: x.max(y).less(z) }
    }

    /// One of three numbers for each ray.
    #[inline(always)]
    fn pick<F: Lanes>(self, [x, y, z]: [F; 3]) -> F {
        z.select(self.z, y.select(self.y, x))
    }
}

/// Up to eight rays that follow each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedEight {
    rays: [PreparedRay; WIDTH],
    /// Those that can hit anything and have not been taken, one bit each.
    left: u32,
}

impl PreparedEight {
    /// No rays.
    pub(crate) const NONE: Self = Self { rays: [PreparedRay::NONE; WIDTH], left: 0 };

    /// Whether no ray is left that can hit anything.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.left == 0
    }

    /// Takes the first ray that is left and can hit anything, with its place.
    #[inline(always)]
    pub(crate) fn next(&mut self) -> Option<(usize, &PreparedRay)> {
        if self.left == 0 {
            return None;
        }
        let place = self.left.trailing_zeros() as usize % WIDTH;
        self.left &= self.left - 1;
        Some((place, &self.rays[place]))
    }

    /// Replaces the rays by the first eight of others.
    #[inline(always)]
    pub(crate) fn prepare<I: Isa>(&mut self, isa: I, rays: &[Ray]) {
        if let Some(rays) = rays.first_chunk() {
            self.prepare_all(isa, rays);
        } else {
            self.prepare_all(isa, &filled_up(rays));
        }
    }

    #[inline(always)]
    fn prepare_all<I: Isa>(&mut self, isa: I, rays: &[Ray; WIDTH]) {
        let eight = EightRays::load(isa, rays);
        self.left = eight.usable();
        let EightRays { origin: [ox, oy, oz], direction: [dx, dy, dz], .. } = eight;
        let (rx, ry, rz) = (dx.reciprocal(), dy.reciprocal(), dz.reciprocal());
        let (low, high, widening) = (isa.splat(f32::MIN), isa.splat(f32::MAX), isa.splat(EXIT_WIDENING));
        let unused = isa.splat(0.0);
        let (ex, ey, ez) = (rx.max(low).min(high), ry.max(low).min(high), rz.max(low).min(high));
        let (wx, wy, wz) = (rx * widening, ry * widening, rz * widening);
        let reciprocals = isa.transpose([ex, ey, ez, wx, wy, wz, unused, unused]);
        let axis = LongestAxis::new(eight.direction);
        let (x, y, z) = (axis.pick([oy, oz, ox]), axis.pick([oz, ox, oy]), axis.pick([ox, oy, oz]));
        let scale = axis.pick([rx, ry, rz]);
        let (sx, sy) = (axis.pick([dy, dz, dx]) * scale, axis.pick([dz, dx, dy]) * scale);
        let turned = isa.transpose([x, y, z, sx, sy, scale, unused, unused]);
        // By the sign bits: a zero direction's reciprocal is an infinite number of its sign.
        let negative = [rx.less(unused), ry.less(unused), rz.less(unused)];
        let orientations = orientation_indices(negative, axis);
        for (lane, ray) in self.rays.iter_mut().enumerate() {
            ray.numbers = Row(eight.numbers[lane].to_array());
            ray.reciprocals = Row(reciprocals[lane].to_array());
            ray.turned = Row(turned[lane].to_array());
            ray.orientation = *Orientation::at((orientations >> (8 * lane)) as usize);
            ray.time = rays[lane].time;
        }
    }
}

/// The indices of the rays' orientations, a byte each.
#[inline(always)]
fn orientation_indices([x, y, z]: [u32; 3], longest: LongestAxis) -> u64 {
    let octants = bytes(x) | bytes(y) << 1 | bytes(z) << 2;
    octants | (bytes(longest.y) | bytes(longest.z) << 1) << Orientation::OCTANT_BITS
}

/// For each of eight bits a byte that is 0 or 1.
#[inline(always)]
fn bytes(bits: u32) -> u64 {
    const ONES: u64 = 0x0101_0101_0101_0101;
    // In byte `i` all bits, of which bit `i` stays; adding carries it to the highest.
    let apart = (u64::from(bits & 0xff) * ONES) & 0x8040_2010_0804_0201;
    ((apart + 0x7f * ONES) >> 7) & ONES
}
