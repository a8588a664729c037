//! Values on a grid of cells over a box.

use sahl_math::{Bounds3, Ray, Transform, Vec3};
use sahl_scene::Region;

/// Values at the centres of the cells of a unit cube; zero outside it, trilinear between.
#[derive(Clone, Debug)]
pub(super) struct Cells<T> {
    resolution: [usize; 3],
    /// x varies fastest.
    values: Box<[T]>,
}

/// What can be interpolated.
pub(super) trait Mix: Copy {
    const ZERO: Self;
    fn mix(self, other: Self, t: f32) -> Self;
}

impl Mix for f32 {
    const ZERO: Self = 0.0;
    #[inline]
    fn mix(self, other: Self, t: f32) -> Self {
        self + (other - self) * t
    }
}

impl<T> Cells<T> {
    /// The values of a description, each turned into what is looked up.
    pub(super) fn new<S>(grid: &sahl_scene::Grid<S>, value: impl FnMut(&S) -> T) -> Self {
        let resolution = grid.resolution.map(|n| n as usize);
        Self { resolution, values: grid.values.iter().map(value).collect() }
    }

    pub(super) fn values(&self) -> &[T] {
        &self.values
    }

    /// The value at `p` in the unit cube: `read` of the eight nearest centres, interpolated.
    #[inline]
    pub(super) fn at<M: Mix>(&self, p: Vec3, read: impl Fn(&T) -> M) -> M {
        let place = |axis: usize| {
            let t = p[axis] * self.resolution[axis] as f32 - 0.5;
            let cell = t.floor();
            (cell as i64, t - cell)
        };
        let ([x, y, z], [tx, ty, tz]) = {
            let [x, y, z] = [place(0), place(1), place(2)];
            ([x.0, y.0, z.0], [x.1, y.1, z.1])
        };
        let value = |dx: i64, dy: i64, dz: i64| self.cell([x + dx, y + dy, z + dz]).map_or(M::ZERO, &read);
        let along_x = |dy, dz| value(0, dy, dz).mix(value(1, dy, dz), tx);
        let along_y = |dz| along_x(0, dz).mix(along_x(1, dz), ty);
        along_y(0).mix(along_y(1), tz)
    }

    #[inline]
    fn cell(&self, place: [i64; 3]) -> Option<&T> {
        let mut index = 0;
        for axis in [2, 1, 0] {
            let i = usize::try_from(place[axis]).ok().filter(|&i| i < self.resolution[axis])?;
            index = index * self.resolution[axis] + i;
        }
        self.values.get(index)
    }

    /// The largest value of `read` among all centres that matter within `part` of the unit cube.
    pub(super) fn max_within(&self, part: &Bounds3, read: impl Fn(&T) -> f32) -> f32 {
        let range = |axis: usize| {
            let n = self.resolution[axis] as f32;
            let first = (part.min[axis] * n - 0.5).floor().max(0.0) as usize;
            let last = ((part.max[axis] * n - 0.5).floor() + 1.0).clamp(0.0, n - 1.0) as usize;
            first..=last
        };
        let mut largest = 0.0_f32;
        for z in range(2) {
            for y in range(1) {
                let row = (z * self.resolution[1] + y) * self.resolution[0];
                let (first, last) = range(0).into_inner();
                let cells = self.values.get(row + first..=row + last).unwrap_or_default();
                largest = cells.iter().map(&read).fold(largest, f32::max);
            }
        }
        largest
    }
}

/// The box of a medium, as a unit cube.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    world_to_medium: Transform,
    bounds: Bounds3,
    /// One over the edges of the box, and zero; where it is flat, zero and −1, so that nothing is inside.
    scale: Vec3,
    shift: Vec3,
}

impl Frame {
    pub(super) fn new(region: &Region) -> Self {
        let edges = region.bounds.diagonal();
        let scale = edges.map(|edge| if edge > 0.0 { 1.0 / edge } else { 0.0 });
        let shift = edges.map(|edge| if edge > 0.0 { 0.0 } else { -1.0 });
        Self { world_to_medium: region.medium_to_world.inverse(), bounds: region.bounds, scale, shift }
    }

    /// From the world to the space in which the medium is described.
    #[inline]
    pub(super) fn to_medium(&self, p: Vec3) -> Vec3 {
        self.world_to_medium.point(p)
    }

    /// From the world to the unit cube.
    #[inline]
    pub(super) fn to_cube(&self, p: Vec3) -> Vec3 {
        (self.to_medium(p) - self.bounds.min) * self.scale + self.shift
    }

    /// A ray of the world in the unit cube, with the same parameters.
    #[inline]
    pub(super) fn ray_to_cube(&self, ray: &Ray) -> Ray {
        Ray::new(self.to_cube(ray.origin), self.world_to_medium.vector(ray.direction) * self.scale)
    }
}

/// The parameters between which `ray` is in the unit cube, at most `length`; `None` if it misses.
#[inline]
pub(super) fn clip_to_cube(ray: &Ray, length: f32) -> Option<[f32; 2]> {
    let [mut near, mut far] = [0.0_f32, length];
    for axis in 0..3 {
        let (o, d) = (ray.origin[axis], ray.direction[axis]);
        if d == 0.0 {
            if !(0.0..=1.0).contains(&o) {
                return None;
            }
            continue;
        }
        let (a, b) = (-o / d, (1.0 - o) / d);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    (near < far).then_some([near, far])
}
