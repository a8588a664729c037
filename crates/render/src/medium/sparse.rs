//! A density on a sparse grid, such as those that simulations write.
//!
//! In a scene file: `MakeNamedMedium "explosion" "string type" "nanovdb" "string filename" "explosion.nvdb"`.

use std::sync::Arc;

use sahl_math::{Bounds3, Transform, Vec3};
use sahl_scene::{Diagnostics, Region, Span, SparseGrid, SparseMedium, TemperatureScale};

use super::coefficients::Coefficients;
use super::fire::Fire;
use super::grid::{Frame, Mix};
use super::majorant::MajorantGrid;
use super::walk::{self, Collision, Next};
use super::{HenyeyGreenstein, Properties, Way};
use crate::sampler::Stream;
use crate::spectrum::{Spectrum, Wavelengths};

/// Cells of the majorant along each axis, as in pbrt-v4.
const MAJORANT_CELLS: usize = 64;

/// Matter whose density is given on a sparse grid.
#[derive(Clone, Debug)]
pub(crate) struct Sparse {
    coefficients: Coefficients,
    frame: Frame,
    density: Lattice,
    heat: Option<Heat>,
    majorant: MajorantGrid,
    pub(super) phase: HenyeyGreenstein,
}

/// What the matter emits.
#[derive(Clone, Debug)]
struct Heat {
    values: Lattice,
    scale: TemperatureScale,
    fire: Fire,
    factor: f32,
}

/// Values at the points of an integer lattice, trilinear between.
#[derive(Clone, Debug)]
struct Lattice {
    medium_to_index: Transform,
    origin: [i32; 3],
    blocks: [u32; 3],
    table: Arc<[u32]>,
    values: Arc<[f32]>,
    background: f32,
}

/// Lattice points along an edge of a block, and how many bits count them.
const EDGE: i32 = 8;

impl Lattice {
    fn new(grid: &SparseGrid) -> Self {
        Self {
            medium_to_index: grid.index_to_medium.inverse(),
            origin: grid.origin,
            blocks: grid.blocks,
            table: grid.table.clone(),
            values: grid.values.clone(),
            background: grid.background,
        }
    }

    /// The value at a point of the medium's space.
    fn at(&self, p: Vec3) -> f32 {
        let place = self.medium_to_index.point(p);
        let cell = place.map(f32::floor);
        let t = place - cell;
        let [x, y, z] = [cell.x, cell.y, cell.z].map(|x| x as i32);
        let value = |dx: i32, dy: i32, dz: i32| {
            self.point([x.saturating_add(dx), y.saturating_add(dy), z.saturating_add(dz)])
        };
        let along_x = |dy, dz| value(0, dy, dz).mix(value(1, dy, dz), t.x);
        let along_y = |dz| along_x(0, dz).mix(along_x(1, dz), t.y);
        along_y(0).mix(along_y(1), t.z)
    }
    /// The value at a lattice point.
    #[inline]
    fn point(&self, point: [i32; 3]) -> f32 {
        self.find(point).unwrap_or(self.background)
    }

    #[inline]
    fn find(&self, point: [i32; 3]) -> Option<f32> {
        let (mut block, mut offset) = (0, 0);
        for axis in [2, 1, 0] {
            let steps = point[axis].checked_sub(self.origin[axis])?;
            let index = u32::try_from(steps / EDGE).ok().filter(|&i| steps >= 0 && i < self.blocks[axis])?;
            block = block * self.blocks[axis] as usize + index as usize;
        }
        for axis in [0, 1, 2] {
            offset = offset * EDGE as usize + (point[axis] - self.origin[axis]) as usize % EDGE as usize;
        }
        let block = *self.table.get(block).filter(|&&block| block != SparseGrid::NO_BLOCK)?;
        self.values.get(block as usize * SparseGrid::BLOCK + offset).copied()
    }

    /// Calls `visit` with each lattice point in a block and its value.
    fn for_each(&self, mut visit: impl FnMut([i32; 3], f32)) {
        let [nx, ny, _] = self.blocks.map(|n| n as usize);
        for (index, &block) in
            self.table.iter().enumerate().filter(|(_, block)| **block != SparseGrid::NO_BLOCK)
        {
            let place = [index % nx, index / nx % ny, index / (nx * ny)];
            let first = block as usize * SparseGrid::BLOCK;
            let values = self.values.get(first..first + SparseGrid::BLOCK).unwrap_or_default();
            for (offset, &value) in values.iter().enumerate() {
                let within = [offset >> 6, offset >> 3 & 7, offset & 7];
                let point = |axis: usize| self.origin[axis] + EDGE * place[axis] as i32 + within[axis] as i32;
                visit([point(0), point(1), point(2)], value);
            }
        }
    }
}

impl Sparse {
    /// The medium of a scene; `span` is what messages point at.
    pub(crate) fn new(description: &SparseMedium, span: Option<Span>, diagnostics: &mut Diagnostics) -> Self {
        let SparseMedium { coefficients, medium_to_world, density, temperature, emission_scale } =
            description;
        let coefficients = Coefficients::new(coefficients, span, diagnostics);
        let phase = coefficients.phase;
        let bounds = match temperature {
            Some((temperature, _)) => density.bounds.union(temperature.bounds),
            None => density.bounds,
        };
        let frame = Frame::new(&Region { bounds, medium_to_world: *medium_to_world });
        let heat = temperature.as_ref().map(|(grid, scale)| {
            let hottest = grid.values.iter().map(|&value| scale.kelvin(value)).fold(0.0, f32::max);
            Heat {
                values: Lattice::new(grid),
                scale: *scale,
                fire: Fire::new(hottest),
                factor: *emission_scale,
            }
        });
        let lattice = Lattice::new(density);
        let majorant = majorant(&lattice, &density.index_to_medium, &bounds);
        Self { coefficients, frame, density: lattice, heat, majorant, phase }
    }

    pub(super) fn walk(
        &self,
        way: &Way,
        u: f32,
        stream: &mut Stream,
        visit: impl FnMut(&Collision) -> Next,
    ) -> Spectrum {
        let (sigma_a, sigma_s) = self.coefficients.at(&way.wavelengths);
        let ray = self.frame.ray_to_cube(&way.ray);
        let stretches = self.majorant.stretches(&ray, way.length, sigma_a + sigma_s);
        let properties = |p| {
            let p = self.frame.to_medium(p);
            let density = self.density.at(p).max(0.0);
            let emission = self.heat.as_ref().map_or(Spectrum::ZERO, |heat| heat.at(p, &way.wavelengths));
            Properties { sigma_a: sigma_a * density, sigma_s: sigma_s * density, emission }
        };
        walk::walk(way, u, stream, stretches, properties, visit)
    }
}

impl Heat {
    fn at(&self, p: Vec3, wavelengths: &Wavelengths) -> Spectrum {
        self.fire.at(self.scale.kelvin(self.values.at(p)), wavelengths) * self.factor
    }
}

/// Bounds of the density in the cells of `bounds`: each value counts wherever interpolation reaches it.
fn majorant(density: &Lattice, index_to_medium: &Transform, bounds: &Bounds3) -> MajorantGrid {
    let n = MAJORANT_CELLS as f32;
    let scale = bounds.diagonal().map(|edge| if edge > 0.0 { n / edge } else { 0.0 });
    let mut cells = vec![density.background.max(0.0); MAJORANT_CELLS.pow(3)];
    density.for_each(|point, value| {
        if value <= 0.0 {
            return;
        }
        let center = Vec3::from(point.map(|x| x as f32));
        let reach = Bounds3 { min: center - Vec3::ONE, max: center + Vec3::ONE };
        let reach = index_to_medium.bounds(&reach);
        let cell = |p: Vec3| {
            let place = (p - bounds.min) * scale;
            [place.x, place.y, place.z].map(|x| x.clamp(0.0, n - 1.0) as usize)
        };
        let (first, last) = (cell(reach.min), cell(reach.max));
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let bound = &mut cells[(z * MAJORANT_CELLS + y) * MAJORANT_CELLS + x];
                    *bound = bound.max(value);
                }
            }
        }
    });
    MajorantGrid::from_bounds(MAJORANT_CELLS, cells)
}
