//! Ids of primitives: one word that stands for geometry and primitive in the trees.
//!
//! Each geometry owns a range of ids, so that an id is named by a search among the ranges, and no list is as long as the
//! meshes. Ids ascend with (geometry, primitive). Those of primitives that were left out are not used.

use std::ops::Range;

use crate::geometry::curve::parts_of;
use crate::geometry::patch::PatchKind;
use crate::world::Geometry;

/// No id is as large: it stands for none.
const END_OF_IDS: u64 = u32::MAX as u64;

/// Pages of ids are at least this large.
const MIN_PAGE_BITS: u32 = 6;

/// About how many pages there are at most: their list has to stay in the nearest cache.
const MAX_PAGES: u64 = 2048;

/// What a primitive is to the traversal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A triangle of a mesh.
    Triangle,
    /// The half `p₀₀ p₁₁ p₀₁` (upper) or `p₀₀ p₁₀ p₁₁` of a planar patch.
    Half { upper: bool, parallelogram: bool },
    /// A patch that is not planar.
    Patch,
    /// A sphere, cylinder or disk.
    Quadric,
    /// A part of a curve's segment.
    Curve,
}

/// The name of a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PrimitiveName {
    pub(crate) geometry: u32,
    pub(crate) primitive: u32,
    pub(crate) kind: Kind,
}

impl PrimitiveName {
    /// Whether it is the upper half of a patch.
    pub(crate) fn is_upper(&self) -> bool {
        matches!(self.kind, Kind::Half { upper: true, .. })
    }
}

/// What a geometry is, with what was found out about its primitives.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    Triangles,
    /// How each patch is traced; empty before they were collected.
    Patches(Vec<PatchKind>),
    /// The place among the prepared quadrics, if it has a surface.
    Quadric(Option<u32>),
    /// How many parts a segment has, and the place among the prepared curves, once they are collected.
    Curves {
        parts: u32,
        place: Option<u32>,
    },
}

/// The ranges of ids of a world's geometries.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    /// The first id of each geometry, and at the end one more than the last id.
    starts: Vec<u32>,
    shapes: Vec<Shape>,
    /// The geometry of the first id of each page of `2^page_bits` ids, and at the end that of the last id.
    pages: Vec<u32>,
    page_bits: u32,
}

impl Names {
    pub(crate) fn new(geometries: &[Geometry]) -> Self {
        let mut starts = vec![0];
        let mut shapes = Vec::with_capacity(geometries.len());
        let mut end = 0_u64;
        for geometry in geometries {
            let (count, shape) = match geometry {
                Geometry::Triangles(mesh) => (mesh.indices.len() as u64, Shape::Triangles),
                Geometry::MovingTriangles(mesh) => (mesh.indices.len() as u64, Shape::Triangles),
                // Two a patch, for the halves of those that are planar.
                Geometry::Patches(mesh) => (2 * mesh.indices.len() as u64, Shape::Patches(Vec::new())),
                Geometry::Sphere(_) | Geometry::Disk(_) | Geometry::Cylinder(_) => (1, Shape::Quadric(None)),
                Geometry::Curves(set) => {
                    let parts = parts_of(set);
                    (set.points.len() as u64 * u64::from(parts), Shape::Curves { parts, place: None })
                }
            };
            end = END_OF_IDS.min(end + count);
            starts.push(end as u32);
            shapes.push(shape);
        }
        let page_bits = MIN_PAGE_BITS.max((end / MAX_PAGES).checked_ilog2().map_or(0, |bits| bits + 1));
        let mut names = Self { starts, shapes, pages: Vec::new(), page_bits };
        if geometries.len() > 1 {
            let ids = (0..end).step_by(1 << page_bits).chain(end.checked_sub(1));
            names.pages = ids.map(|id| names.search(id as u32, 0, geometries.len() - 1)).collect();
        }
        names
    }

    /// The ids of a geometry; fewer than it has primitives where there are not enough.
    pub(crate) fn ids(&self, geometry: u32) -> Range<u32> {
        self.starts[geometry as usize]..self.starts[geometry as usize + 1]
    }

    /// How many ids some geometries have, those that do not exist having none.
    pub(crate) fn count(&self, geometries: &[u32]) -> usize {
        let exists = |geometry: &&u32| (**geometry as usize) < self.shapes.len();
        geometries.iter().filter(exists).map(|&geometry| self.ids(geometry).len()).sum()
    }

    pub(crate) fn shape(&self, geometry: u32) -> Option<&Shape> {
        self.shapes.get(geometry as usize)
    }

    pub(crate) fn set_patch_kinds(&mut self, geometry: u32, kinds: Vec<PatchKind>) {
        self.shapes[geometry as usize] = Shape::Patches(kinds);
    }

    pub(crate) fn set_quadric(&mut self, geometry: u32, place: u32) {
        self.shapes[geometry as usize] = Shape::Quadric(Some(place));
    }

    /// Says where the prepared curves of a geometry are.
    pub(crate) fn set_curves(&mut self, geometry: u32, prepared: u32) {
        if let Shape::Curves { place, .. } = &mut self.shapes[geometry as usize] {
            *place = Some(prepared);
        }
    }

    /// The memory of the lists in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let kinds = |shape: &Shape| match shape {
            Shape::Patches(kinds) => size_of_val(kinds.as_slice()),
            _ => 0,
        };
        let lists = size_of_val(self.starts.as_slice())
            + size_of_val(self.shapes.as_slice())
            + size_of_val(self.pages.as_slice());
        (lists + self.shapes.iter().map(kinds).sum::<usize>()) as u64
    }

    /// The geometry and the number of a primitive that is a triangle of a mesh.
    #[inline(always)]
    pub(crate) fn triangle(&self, id: u32) -> Option<[u32; 2]> {
        let geometry = self.geometry(id);
        let is_triangle = matches!(self.shapes[geometry as usize], Shape::Triangles);
        is_triangle.then(|| [geometry, id - self.starts[geometry as usize]])
    }

    /// The name of a primitive that was collected.
    #[inline]
    pub(crate) fn name(&self, id: u32) -> PrimitiveName {
        let geometry = self.geometry(id);
        let offset = id - self.starts[geometry as usize];
        match &self.shapes[geometry as usize] {
            Shape::Triangles => PrimitiveName { geometry, primitive: offset, kind: Kind::Triangle },
            Shape::Patches(kinds) => {
                let kind = match kinds[offset as usize / 2] {
                    PatchKind::Curved | PatchKind::Degenerate => Kind::Patch,
                    planar => Kind::Half {
                        upper: offset % 2 == 1,
                        parallelogram: planar == PatchKind::Parallelogram,
                    },
                };
                PrimitiveName { geometry, primitive: offset / 2, kind }
            }
            Shape::Quadric(_) => PrimitiveName { geometry, primitive: 0, kind: Kind::Quadric },
            Shape::Curves { parts, .. } => {
                PrimitiveName { geometry, primitive: offset / parts, kind: Kind::Curve }
            }
        }
    }

    #[inline(always)]
    fn geometry(&self, id: u32) -> u32 {
        if self.pages.is_empty() {
            return 0;
        }
        let page = (id >> self.page_bits) as usize;
        let (low, high) = (self.pages[page], self.pages[page + 1]);
        if low == high { low } else { self.search(id, low as usize, high as usize) }
    }

    /// The geometry of an id, known to be among those from `low` to `high`.
    #[inline(never)]
    fn search(&self, id: u32, low: usize, high: usize) -> u32 {
        // The last that starts at or before the id: those before it that start there are empty.
        let starts = &self.starts[low + 1..=high];
        (low + starts.partition_point(|&start| start <= id)) as u32
    }
}

#[cfg(test)]
mod tests {
    use sahl_math::{Transform, Vec3};

    use super::*;
    use crate::world::{Disk, PatchMesh, TriangleMesh};

    fn mesh(count: usize) -> Geometry {
        let indices = vec![[0, 0, 0]; count];
        Geometry::Triangles(TriangleMesh { indices: indices.into(), positions: [Vec3::ZERO].into() })
    }

    #[test]
    fn every_id_has_the_name_it_was_given() {
        let disk = || {
            let to_parent = Transform::IDENTITY;
            Geometry::Disk(Disk { height: 0.0, radius: 1.0, inner_radius: 0.0, phi_max: 1.0, to_parent })
        };
        let patches = PatchMesh { indices: vec![[0; 4]; 3].into(), positions: [Vec3::ZERO].into() };
        let geometries = [
            mesh(0),
            mesh(5),
            disk(),
            mesh(0),
            mesh(0),
            Geometry::Patches(patches),
            mesh(4000),
            disk(),
            mesh(0),
        ];
        let mut names = Names::new(&geometries);
        names.set_patch_kinds(5, vec![PatchKind::Planar, PatchKind::Curved, PatchKind::Parallelogram]);
        let name = |geometry, primitive, kind| PrimitiveName { geometry, primitive, kind };
        let half = |upper, parallelogram| Kind::Half { upper, parallelogram };
        let mut expected: Vec<PrimitiveName> = (0..5).map(|i| name(1, i, Kind::Triangle)).collect();
        expected.push(name(2, 0, Kind::Quadric));
        expected.extend([name(5, 0, half(false, false)), name(5, 0, half(true, false))]);
        expected.extend([name(5, 1, Kind::Patch); 2]);
        expected.extend([name(5, 2, half(false, true)), name(5, 2, half(true, true))]);
        expected.extend((0..4000).map(|i| name(6, i, Kind::Triangle)));
        expected.push(name(7, 0, Kind::Quadric));
        assert_eq!(names.ids(8), 4013..4013);
        for (id, name) in expected.into_iter().enumerate() {
            assert_eq!(names.name(id as u32), name, "{id}");
        }
    }

    #[test]
    fn one_geometry_needs_no_pages() {
        let names = Names::new(&[mesh(100_000)]);
        assert!(names.bytes() < 200);
        assert_eq!(
            names.name(99_999),
            PrimitiveName { geometry: 0, primitive: 99_999, kind: Kind::Triangle }
        );
        assert_eq!(Names::new(&[]).starts, [0]);
    }

    #[test]
    fn many_geometries_of_uneven_sizes() {
        let sizes: Vec<usize> = (0..3000).map(|i| [0, 1, 2, 70, 900][i * i % 5]).collect();
        let geometries: Vec<Geometry> = sizes.iter().map(|&size| mesh(size)).collect();
        let names = Names::new(&geometries);
        let mut id = 0;
        for (geometry, &size) in sizes.iter().enumerate() {
            for primitive in 0..size {
                let expected = PrimitiveName {
                    geometry: geometry as u32,
                    primitive: primitive as u32,
                    kind: Kind::Triangle,
                };
                assert_eq!(names.name(id), expected);
                id += 1;
            }
        }
    }
}
