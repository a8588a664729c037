//! A ray with what the tests of nodes and blocks need of it.

use sahl_math::{Ray, Vec3};

use super::block::VertexRows;
use super::isa::{Octant, Order, Row};
use super::node::{EXIT_WIDENING, PlaneRows};
use crate::geometry::triangle::{Axis, Shear};

/// A ray with what all tests of it need.
///
/// In rows, because eight rays are prepared together and written and copied row by row: what is copied by wide loads waits for
/// narrow stores that have just written it.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct PreparedRay {
    /// The ray's origin, direction, `t_min`, which is at least zero, and `t_max`.
    pub(super) numbers: Row,
    /// One over the direction, for the planes where the ray enters, and [`EXIT_WIDENING`] times that for those where it leaves.
    pub(super) reciprocals: Row,
    /// The origin in the order of [`Shear::axes`], and [`Shear::factors`].
    pub(super) turned: Row,
    /// A copy: a pointer would be followed at each step.
    pub(super) orientation: Orientation,
    pub(super) time: f32,
}

/// What depends on nothing but the signs of a ray's direction and the axis along which it is longest.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Orientation {
    pub(crate) order: Order,
    pub(super) planes: PlaneRows,
    /// The rows of a block in the order of the axes.
    pub(super) vertices: [VertexRows; 3],
    pub(super) axes: [Axis; 3],
    pub(crate) octant: Octant,
}

impl Orientation {
    /// The bits of an index that stand for the octant.
    pub(super) const OCTANT_BITS: u32 = 3;
    const COUNT: usize = 4 << Self::OCTANT_BITS;

    /// That of an octant, the lower bits of the index, and of a longest axis, the higher ones: both 2 and 3 mean z.
    #[inline(always)]
    pub(super) fn at(index: usize) -> &'static Self {
        static ORIENTATIONS: [Orientation; Orientation::COUNT] = {
            let mut all = [Orientation::new(Octant::at(0), Axis::X); Orientation::COUNT];
            let mut index = 0;
            while index < Orientation::COUNT {
                let axis = [Axis::X, Axis::Y, Axis::Z, Axis::Z][index >> Orientation::OCTANT_BITS];
                all[index] = Orientation::new(Octant::at(index), axis);
                index += 1;
            }
            all
        };
        &ORIENTATIONS[index % Self::COUNT]
    }

    const fn new(octant: Octant, longest: Axis) -> Self {
        let axes = *longest.after_others();
        let [x, y, z] = axes;
        let vertices = [VertexRows::of(x), VertexRows::of(y), VertexRows::of(z)];
        Self { order: *Order::of(octant), planes: PlaneRows::of(octant), vertices, axes, octant }
    }
}

impl PreparedRay {
    /// A ray that hits nothing, in places for others.
    pub(crate) const NONE: Self = {
        const ORIENTATION: Orientation = Orientation::new(Octant::at(0), Axis::X);
        let zero = Row::splat(0.0);
        Self { numbers: zero, reciprocals: zero, turned: zero, orientation: ORIENTATION, time: 0.0 }
    };

    /// `None` for a ray that hits nothing: see [`can_hit`].
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Option<Self> {
        can_hit(ray).then(|| Self::of_usable(ray))
    }

    /// A ray that [`can_hit`].
    #[inline(always)]
    pub(super) fn of_usable(ray: &Ray) -> Self {
        let Ray { origin: o, direction: d, t_max, time, .. } = *ray;
        let reciprocal = d.map(|x| 1.0 / x);
        let Shear { axes, factors: [sx, sy, sz] } = Shear::with_reciprocal(d, reciprocal);
        let [x, y, z] = axes.map(|axis| <[f32; 3]>::from(o)[axis as usize]);
        // The reciprocal of a subnormal number is infinite and too late for where a box begins; the largest number never is.
        let (enter, exit) = (reciprocal.map(|x| x.clamp(f32::MIN, f32::MAX)), reciprocal * EXIT_WIDENING);
        let [_, _, longest] = axes;
        Self {
            // Negative parameters lie behind the origin and never count.
            numbers: Row([o.x, o.y, o.z, d.x, d.y, d.z, at_least_zero(ray.t_min), t_max]),
            reciprocals: Row([enter.x, enter.y, enter.z, exit.x, exit.y, exit.z, 0.0, 0.0]),
            turned: Row([x, y, z, sx, sy, sz, 0.0, 0.0]),
            orientation: *Orientation::at(
                Octant::of(d).index() | (longest as usize) << Orientation::OCTANT_BITS,
            ),
            time,
        }
    }

    /// See [`limit_of`].
    #[inline(always)]
    pub(crate) fn limit(&self) -> f32 {
        let [.., t_max] = self.numbers.0;
        // The number before `t_max`, which is positive, without the branches of `next_down`.
        f32::from_bits(t_max.to_bits() - 1)
    }

    /// The ray, from the first parameter on that counts.
    #[inline(always)]
    pub(crate) fn ray(&self) -> Ray {
        let [ox, oy, oz, dx, dy, dz, t_min, t_max] = self.numbers.0;
        Ray { origin: Vec3::new(ox, oy, oz), direction: Vec3::new(dx, dy, dz), t_min, t_max, time: self.time }
    }

    /// The ray from a parameter on.
    #[inline(always)]
    pub(crate) fn after(mut self, t: f32) -> Self {
        let [.., t_min, _] = &mut self.numbers.0;
        *t_min = t;
        self
    }

    #[inline(always)]
    pub(crate) fn shear(&self) -> Shear {
        Shear { axes: self.orientation.axes, factors: self.shear_factors() }
    }

    #[inline(always)]
    pub(crate) fn orientation(&self) -> &Orientation {
        &self.orientation
    }

    #[inline(always)]
    pub(super) fn t_min(&self) -> f32 {
        let [.., t_min, _] = self.numbers.0;
        t_min
    }

    #[inline(always)]
    pub(super) fn origin(&self) -> [f32; 3] {
        first_three(&self.numbers)
    }

    #[inline(always)]
    pub(super) fn reciprocal(&self) -> [f32; 3] {
        first_three(&self.reciprocals)
    }

    #[inline(always)]
    pub(super) fn widened(&self) -> [f32; 3] {
        second_three(&self.reciprocals)
    }

    #[inline(always)]
    pub(super) fn turned_origin(&self) -> [f32; 3] {
        first_three(&self.turned)
    }

    #[inline(always)]
    pub(super) fn shear_factors(&self) -> [f32; 3] {
        second_three(&self.turned)
    }
}

#[inline(always)]
fn first_three(row: &Row) -> [f32; 3] {
    let [x, y, z, ..] = row.0;
    [x, y, z]
}

#[inline(always)]
fn second_three(row: &Row) -> [f32; 3] {
    let [_, _, _, x, y, z, ..] = row.0;
    [x, y, z]
}

/// Whether a ray may hit anything: it has a direction, is finite, and its interval is not empty.
#[inline(always)]
fn can_hit(ray: &Ray) -> bool {
    // Zero times what is infinite or NaN is NaN: one comparison for all coordinates.
    let sums = ray.origin * 0.0 + ray.direction * 0.0;
    let direction = ray.direction.map(f32::abs);
    (sums.x + sums.y) + sums.z == 0.0
        && (direction.x + direction.y) + direction.z > 0.0
        && at_least_zero(ray.t_min) < ray.t_max
}

/// The number, or zero if it is negative or NaN: one instruction, unlike `max`.
#[inline(always)]
fn at_least_zero(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

/// The largest parameter that counts for a ray: the last before `t_max`.
#[inline(always)]
pub(crate) fn limit_of(ray: &Ray) -> f32 {
    ray.t_max.next_down()
}
