//! Bounds of a density, cell by cell, and the walk of a ray through them.

use sahl_math::{Bounds3, Ray};

use super::grid::clip_to_cube;
use super::walk::Stretch;
use crate::spectrum::Spectrum;

/// A bound of the density in each cell of the unit cube.
#[derive(Clone, Debug)]
pub(super) struct MajorantGrid {
    resolution: usize,
    /// x varies fastest.
    bounds: Box<[f32]>,
}

impl MajorantGrid {
    /// `resolution` cells along each axis; `bound` gives that of a part of the cube.
    pub(super) fn new(resolution: usize, bound: impl Fn(&Bounds3) -> f32) -> Self {
        let edge = |i: usize| i as f32 / resolution as f32;
        let mut bounds = Vec::with_capacity(resolution.pow(3));
        for z in 0..resolution {
            for y in 0..resolution {
                for x in 0..resolution {
                    let (min, max) = ([x, y, z].map(edge), [x + 1, y + 1, z + 1].map(edge));
                    bounds.push(bound(&Bounds3 { min: min.into(), max: max.into() }));
                }
            }
        }
        Self::from_bounds(resolution, bounds)
    }

    /// The given bounds of `resolution` cells along each axis, x varying fastest.
    pub(super) fn from_bounds(resolution: usize, bounds: Vec<f32>) -> Self {
        debug_assert_eq!(bounds.len(), resolution.pow(3));
        Self { resolution, bounds: bounds.into() }
    }

    /// The stretches of `ray`, given in the unit cube, up to the parameter `length`, with majorants of `sigma_t` times the
    /// density; none where it is outside.
    #[inline]
    pub(super) fn stretches(&self, ray: &Ray, length: f32, sigma_t: Spectrum) -> Stretches<'_> {
        Stretches::new(self, ray, length, sigma_t)
    }
}

/// The cells that a ray passes, in order.
///
/// Source: Amanatides and Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, Eurographics 1987.
pub(super) struct Stretches<'a> {
    grid: &'a MajorantGrid,
    sigma_t: Spectrum,
    /// Where the ray is, and where it leaves the cube.
    t: f32,
    end: f32,
    cell: [usize; 3],
    /// Parameter of the next border along each axis, and from one border to the next.
    next: [f32; 3],
    step: [f32; 3],
    /// Whether cells are passed upward.
    up: [bool; 3],
}

impl<'a> Stretches<'a> {
    #[inline]
    fn new(grid: &'a MajorantGrid, ray: &Ray, length: f32, sigma_t: Spectrum) -> Self {
        let n = grid.resolution as f32;
        let [t, end] = clip_to_cube(ray, length).unwrap_or([0.0, 0.0]);
        let entry = (ray.origin + ray.direction * t) * n;
        let mut stretches = Self {
            grid,
            sigma_t,
            t,
            end,
            cell: [0; 3],
            next: [f32::INFINITY; 3],
            step: [f32::INFINITY; 3],
            up: [true; 3],
        };
        for axis in 0..3 {
            let d = ray.direction[axis] * n;
            let cell = entry[axis].clamp(0.0, n - 1.0).floor();
            stretches.cell[axis] = cell as usize;
            if d != 0.0 {
                let border = if d > 0.0 { cell + 1.0 } else { cell };
                stretches.next[axis] = t + (border - entry[axis]) / d;
                stretches.step[axis] = 1.0 / d.abs();
                stretches.up[axis] = d > 0.0;
            }
        }
        stretches
    }
}

impl Iterator for Stretches<'_> {
    type Item = Stretch;

    #[inline]
    fn next(&mut self) -> Option<Stretch> {
        if self.t >= self.end {
            return None;
        }
        let n = self.grid.resolution;
        let [x, y, z] = self.cell;
        let density = self.grid.bounds[(z * n + y) * n + x];
        let [nx, ny, nz] = self.next;
        let axis = if nx <= ny && nx <= nz {
            0
        } else if ny <= nz {
            1
        } else {
            2
        };
        // Rounding may put a border before where the ray is.
        let to = self.next[axis].clamp(self.t, self.end);
        let stretch = Stretch { from: self.t, to, majorant: self.sigma_t * density };
        self.t = to;
        self.next[axis] += self.step[axis];
        let cell = self.cell[axis];
        match if self.up[axis] { Some(cell + 1).filter(|&cell| cell < n) } else { cell.checked_sub(1) } {
            Some(cell) => self.cell[axis] = cell,
            None => self.t = self.end,
        }
        Some(stretch)
    }
}
