//! The vertices of triangles by their ids, for those who build trees.

use sahl_math::Vec3;

use crate::geometry::patch;
use crate::layout::{MOST_AT_ONCE, Vertices};
use crate::primitive::{Primitives, vertices};
use crate::world::{Geometry, TriangleMesh, World};

/// The vertices of the triangles of a world. Ids are given to those that have them; NaN, which nothing hits, stands for what
/// cannot be.
pub(crate) struct TriangleVertices<'a> {
    pub(crate) world: &'a World,
    pub(crate) primitives: &'a Primitives,
}

const NO_TRIANGLE: [Vec3; 3] = [Vec3::splat(f32::NAN); 3];

impl Vertices for TriangleVertices<'_> {
    fn triangle(&self, id: u32) -> [Vec3; 3] {
        let name = self.primitives.name(id);
        let primitive = name.primitive as usize;
        let found = match self.world.geometries.get(name.geometry as usize) {
            Some(Geometry::Triangles(mesh)) => {
                mesh.indices.get(primitive).and_then(|&indices| vertices(&mesh.positions, indices))
            }
            Some(Geometry::Patches(mesh)) => (mesh.indices.get(primitive))
                .and_then(|&indices| vertices(&mesh.positions, indices))
                .map(|corners| patch::halves(&corners)[usize::from(name.is_upper())]),
            _ => None,
        };
        found.unwrap_or(NO_TRIANGLE)
    }

    fn triangles(&self, ids: &[u32], mut found: impl FnMut(usize, [Vec3; 3])) {
        let mut start = 0;
        while start < ids.len() {
            // Those of the same mesh.
            let geometry = self.primitives.name(ids[start]).geometry;
            let of_mesh = self.primitives.ids(geometry);
            let others = ids[start + 1..].iter().position(|id| !of_mesh.contains(id));
            let end = others.map_or(ids.len(), |count| start + 1 + count);
            if let Some(Geometry::Triangles(mesh)) = self.world.geometries.get(geometry as usize) {
                gather(mesh, of_mesh.start, &ids[start..end], |place, vertices| {
                    found(start + place, vertices);
                });
            } else {
                (start..end).for_each(|place| found(place, self.triangle(ids[place])));
            }
            start = end;
        }
    }
}

/// Calls `found` with the place of each of some ids of a mesh, which begin at `first`, and with the vertices.
///
/// All indices are loaded first, then all positions, so that the processor waits for many of them at a time.
#[inline(always)]
fn gather(mesh: &TriangleMesh, first: u32, ids: &[u32], mut found: impl FnMut(usize, [Vec3; 3])) {
    let mut corners = [[u32::MAX; 3]; MOST_AT_ONCE];
    for (corners, &id) in corners.iter_mut().zip(ids) {
        if let Some(&indices) = mesh.indices.get((id - first) as usize) {
            *corners = indices;
        }
    }
    let vertex = |index: u32| mesh.positions.get(index as usize).copied();
    for (place, &[a, b, c]) in corners[..ids.len().min(MOST_AT_ONCE)].iter().enumerate() {
        let vertices = match (vertex(a), vertex(b), vertex(c)) {
            (Some(a), Some(b), Some(c)) => [a, b, c],
            _ => NO_TRIANGLE,
        };
        found(place, vertices);
    }
}
