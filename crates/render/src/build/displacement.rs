//! Displaced meshes: triangles are cut until their edges are short, and their vertices moved along their normals.
//!
//! The longest edge of a triangle is cut in the middle as long as it is too long. Both triangles at an edge cut it at the same vertex or
//! not at all, so that a closed mesh stays closed. The work is done when the scene is built, and the result is a mesh like any other.
//!
//! Source: Rivara, *Algorithms for refining triangular grids suitable for adaptive and multigrid techniques*, 1984; pbrt-v4's `plymesh`.
//! Deviation: textures are evaluated at points of the space into which the shape is placed, not of its own.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;
use sahl_math::{Transform, Vec2, Vec3};
use sahl_scene::TriangleMesh;

use crate::texture::TexturePoint;

/// More triangles are not made of one mesh.
pub(super) const MOST_TRIANGLES: usize = 1 << 23;

/// The mesh, in its own space, with its vertices moved by `height` along their normals; `None` if it would take more than
/// [`MOST_TRIANGLES`].
///
/// No edge is as long as `edge_length` in the space to which `to_parent` leads before vertices are moved. Without texture coordinates,
/// which validation demands, nothing moves.
pub(super) fn displaced(
    mesh: &TriangleMesh,
    to_parent: &Transform,
    edge_length: f32,
    height: impl Fn(&TexturePoint) -> f32 + Sync,
) -> Option<TriangleMesh> {
    let Some(uvs) = &mesh.uvs else { return Some(mesh.clone()) };
    let normals = match &mesh.normals {
        Some(normals) => normals.to_vec(),
        None => face_normals(&mesh.indices, &mesh.positions),
    };
    let positions = mesh.positions.to_vec();
    let placed = positions.iter().map(|&p| to_parent.point(p)).collect();
    let mut cut = Cut { to_parent, positions, placed, normals, uvs: uvs.to_vec(), middles: HashMap::new() };
    let (indices, ends) = cut.refine(&mesh.indices, edge_length)?;
    let Cut { mut positions, placed, normals, uvs, .. } = cut;
    positions.par_iter_mut().enumerate().for_each(|(i, p)| {
        let n = to_parent.normal(normals[i]).try_normalize().unwrap_or(Vec3::Z);
        let at = TexturePoint { uv: uvs[i], p: placed[i], n, ..TexturePoint::default() };
        *p += normals[i] * height(&at);
    });
    let normals = face_normals(&indices, &positions);
    Some(TriangleMesh {
        indices: indices.into(),
        positions: positions.into(),
        normals: Some(normals.into()),
        tangents: None,
        uvs: Some(uvs.into()),
        face_indices: mesh.face_indices.as_ref().map(|numbers| repeated(numbers, &ends)),
    })
}

/// The number of each part of faces that were cut, given those of the faces and where the parts of each end.
fn repeated(numbers: &[u32], ends: &[usize]) -> Arc<[u32]> {
    let mut repeated = Vec::with_capacity(ends.last().copied().unwrap_or(0));
    for (&number, &end) in numbers.iter().zip(ends) {
        repeated.resize(end, number);
    }
    repeated.into()
}

/// The normalised sum of the unit normals of the faces about each vertex; zero where there are none, or they cancel.
fn face_normals(indices: &[[u32; 3]], positions: &[Vec3]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for &triangle in indices {
        let [p, q, r] = triangle.map(|vertex| positions[vertex as usize]);
        if let Some(n) = (q - p).cross(r - q).try_normalize() {
            for vertex in triangle {
                normals[vertex as usize] += n;
            }
        }
    }
    normals.iter().map(|n| n.try_normalize().unwrap_or(Vec3::ZERO)).collect()
}

/// The vertices of a mesh that is being cut.
struct Cut<'a> {
    to_parent: &'a Transform,
    positions: Vec<Vec3>,
    /// The positions in the space in which edges are measured.
    placed: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    /// The vertices in the middle of edges that have been cut. Looked up only, so that its order is of no matter.
    middles: HashMap<[u32; 2], u32>,
}

impl Cut<'_> {
    /// The triangles that `indices` are cut into, in their order, and where those of each end.
    fn refine(&mut self, indices: &[[u32; 3]], edge_length: f32) -> Option<(Vec<[u32; 3]>, Vec<usize>)> {
        if self.least_count(indices, edge_length) > MOST_TRIANGLES as f64 {
            return None;
        }
        let mut done = Vec::with_capacity(indices.len());
        let mut ends = Vec::with_capacity(indices.len());
        let mut open: Vec<[u32; 3]> = Vec::new();
        for &triangle in indices {
            open.push(triangle);
            while let Some([a, b, c]) = open.pop() {
                let length = |a: u32, b: u32| (self.placed[a as usize] - self.placed[b as usize]).length();
                let [ab, bc, ca] = [length(a, b), length(b, c), length(c, a)];
                if ab.max(bc).max(ca) < edge_length {
                    done.push([a, b, c]);
                    continue;
                }
                if done.len() + open.len() + 2 > MOST_TRIANGLES {
                    return None;
                }
                // The longest edge first.
                let [from, to, apex] = if ab > bc && ab > ca {
                    [a, b, c]
                } else if bc > ca {
                    [b, c, a]
                } else {
                    [c, a, b]
                };
                let middle = self.middle(from, to)?;
                open.extend([[middle, to, apex], [from, middle, apex]]);
            }
            ends.push(done.len());
        }
        Some((done, ends))
    }

    /// How many triangles it takes at least: none is larger than an equilateral one with edges of the limit's length.
    fn least_count(&self, indices: &[[u32; 3]], edge_length: f32) -> f64 {
        let area = |triangle: &[u32; 3]| {
            let [p, q, r] = triangle.map(|vertex| self.placed[vertex as usize]);
            f64::from((q - p).cross(r - p).length()) * 0.5
        };
        let largest = 0.25 * 3.0_f64.sqrt() * f64::from(edge_length).powi(2);
        indices.iter().map(area).sum::<f64>() / largest
    }

    /// The vertex in the middle of an edge; `None` if `f32` has none between its ends.
    fn middle(&mut self, a: u32, b: u32) -> Option<u32> {
        let key = [a.min(b), a.max(b)];
        if let Some(&middle) = self.middles.get(&key) {
            return Some(middle);
        }
        let (a, b) = (a as usize, b as usize);
        let middle = self.positions.len() as u32;
        let p = (self.positions[a] + self.positions[b]) * 0.5;
        if p == self.positions[a] || p == self.positions[b] || !p.is_finite() {
            return None;
        }
        self.positions.push(p);
        self.placed.push(self.to_parent.point(p));
        let n = self.normals[a] + self.normals[b];
        self.normals.push(n.try_normalize().unwrap_or(Vec3::ZERO));
        self.uvs.push((self.uvs[a] + self.uvs[b]) * 0.5);
        self.middles.insert(key, middle);
        Some(middle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square in the plane z = 0 of two triangles.
    fn square() -> TriangleMesh {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        TriangleMesh {
            indices: [[0, 1, 3], [0, 3, 2]].into(),
            positions: corners.map(|[x, y]| Vec3::new(x, y, 0.0)).into(),
            uvs: Some(corners.map(Vec2::from).into()),
            ..TriangleMesh::default()
        }
    }

    fn edges(mesh: &TriangleMesh) -> HashMap<[u32; 2], u32> {
        let mut counts = HashMap::new();
        for &[a, b, c] in mesh.indices.iter() {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                *counts.entry([p.min(q), p.max(q)]).or_default() += 1;
            }
        }
        counts
    }

    #[test]
    fn edges_are_short_and_none_is_torn() {
        let to_parent = Transform::scale(3.0, 1.0, 1.0).unwrap();
        for edge_length in [10.0, 1.0, 0.3, 0.05] {
            let mesh = displaced(&square(), &to_parent, edge_length, |_| 0.0).unwrap();
            let edges = edges(&mesh);
            for [a, b] in edges.keys() {
                let [p, q] = [a, b].map(|&vertex| to_parent.point(mesh.positions[vertex as usize]));
                assert!((p - q).length() < edge_length);
            }
            // Edges with one triangle lie on the border of the square.
            for [a, b] in edges.iter().filter(|(_, count)| **count == 1).map(|(edge, _)| *edge) {
                let [p, q] = [a, b].map(|vertex| mesh.positions[vertex as usize]);
                let on_border = |axis: usize| p[axis] == q[axis] && (p[axis] == 0.0 || p[axis] == 1.0);
                assert!(on_border(0) || on_border(1), "{p:?} {q:?}");
            }
            assert!(edges.values().all(|&count| count <= 2));
        }
    }

    #[test]
    fn vertices_move_along_their_normals_by_the_texture() {
        let to_parent = Transform::translate(0.0, 0.0, 5.0).unwrap();
        let height = |at: &TexturePoint| {
            assert!((at.p.z - 5.0).abs() < 1e-6 && (at.n - Vec3::Z).length() < 1e-6);
            2.0 * at.uv.x
        };
        let mesh = displaced(&square(), &to_parent, 0.2, height).unwrap();
        for (p, n) in mesh.positions.iter().zip(mesh.normals.as_ref().unwrap().iter()) {
            assert!((p.z - 2.0 * p.x).abs() < 1e-6, "in the shape's own space: {p:?}");
            assert!((*n - Vec3::new(-2.0, 0.0, 1.0).normalize()).length() < 1e-4, "{n:?}");
        }
    }

    #[test]
    fn too_many_triangles_are_refused() {
        assert!(displaced(&square(), &Transform::IDENTITY, 1e-6, |_| 0.0).is_none());
        assert!(displaced(&square(), &Transform::IDENTITY, f32::MIN_POSITIVE, |_| 0.0).is_none());
    }
}
