//! Closed bodies, of which no ray may pass the surface.

use std::collections::HashMap;

use sahl_accel::TriangleMesh;
use sahl_math::Vec3;

use super::lattice;

/// A closed body: every edge belongs to two triangles, which face outwards.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) name: &'static str,
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Points that lie closer to the origin than this are strictly inside; zero if none is known to be.
    pub(crate) inside: f32,
    /// The lattice of whose points rays should start, so that they run within planes of edges.
    pub(crate) grid: Option<u16>,
}

impl Body {
    /// The body of a mesh, with vertices of the same place made one; `None` if it is not closed.
    pub(crate) fn of_mesh(name: &'static str, mesh: &TriangleMesh) -> Option<Self> {
        let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
        let mut positions = Vec::new();
        let mut vertex = |index: u32| {
            let p = *mesh.positions.get(index as usize)?;
            // Adding zero makes one zero of the two.
            let key = <[f32; 3]>::from(p).map(|x| (x + 0.0).to_bits());
            Some(*numbers.entry(key).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            }))
        };
        let mut triangles = Vec::with_capacity(mesh.indices.len());
        for &[a, b, c] in mesh.indices.iter() {
            triangles.push([vertex(a)?, vertex(b)?, vertex(c)?]);
        }
        let body = Self { name, positions, triangles, inside: 0.0, grid: None };
        body.is_closed().then_some(body)
    }

    /// Whether each edge belongs to two triangles, which pass it in opposite directions.
    fn is_closed(&self) -> bool {
        let mut edges: HashMap<[u32; 2], u32> = HashMap::with_capacity(3 * self.triangles.len());
        for &[a, b, c] in &self.triangles {
            for edge in [[a, b], [b, c], [c, a]] {
                *edges.entry(edge).or_default() += 1;
            }
        }
        edges.iter().all(|(&[a, b], &count)| count == 1 && edges.get(&[b, a]) == Some(&1))
    }

    pub(crate) fn mesh(&self) -> TriangleMesh {
        TriangleMesh {
            indices: self.triangles.as_slice().into(),
            positions: self.positions.as_slice().into(),
        }
    }
}

/// The bodies whose vertices and edges are shot at.
pub(crate) fn bodies() -> Vec<Body> {
    vec![head(300), blob(24), grid_cube(30)]
}

/// A sphere with fine and coarse folds, of `12 n²` triangles.
pub(crate) fn head(n: u16) -> Body {
    displaced("head", n, |p| {
        let coarse = (3.0 * p.x + 0.5).sin() * (2.0 * p.y).sin() + (4.0 * p.z + p.x).cos();
        let middle = (11.0 * p.y + 3.0 * p.x).sin() * (9.0 * p.z).sin() * (13.0 * p.x + 1.0).sin();
        let fine = (61.0 * p.x + 7.0 * p.y).sin() * (53.0 * p.y - 5.0 * p.z).sin() * (47.0 * p.z).sin();
        1.0 + 0.08 * coarse + 0.06 * middle + 0.015 * fine
    })
}

/// A sphere with a few bumps.
pub(crate) fn blob(n: u16) -> Body {
    displaced("blob", n, |p| 1.0 + 0.15 * (9.0 * p.x).sin() * (7.0 * p.y + 1.0).sin() * (5.0 * p.z).cos())
}

/// The cube from −1 to 1 of `n × n` squares a face. Its coordinates are rounded unless `n` is a power of two.
fn grid_cube(n: u16) -> Body {
    let (positions, triangles) = lattice::cube(n);
    Body { name: "grid cube", positions, triangles, inside: 0.95, grid: Some(n) }
}

/// The unit sphere, each point moved to `radius(point)`.
fn displaced(name: &'static str, n: u16, radius: impl Fn(Vec3) -> f32) -> Body {
    let (mut positions, triangles) = lattice::cube(n);
    for p in &mut positions {
        let on_sphere = lattice::on_sphere(*p);
        *p = on_sphere * radius(on_sphere);
    }
    let nearest = positions.iter().map(|p| p.length()).fold(f32::INFINITY, f32::min);
    Body { name, positions, triangles, inside: 0.9 * nearest, grid: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_closed_and_what_lacks_a_triangle_is_not() {
        for mut body in [head(20), blob(9), grid_cube(7)] {
            assert!(body.is_closed(), "{}", body.name);
            body.triangles.pop();
            assert!(!body.is_closed(), "{}", body.name);
        }
    }

    #[test]
    fn vertices_of_one_place_become_one() {
        let body = grid_cube(3);
        let corners = body.triangles.iter().flatten().map(|&vertex| body.positions[vertex as usize]);
        let indices: Vec<[u32; 3]> =
            (0..body.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let soup = TriangleMesh { indices: indices.into(), positions: corners.collect() };
        let welded = Body::of_mesh("soup", &soup).unwrap();
        assert_eq!(welded.positions.len(), body.positions.len());
        let open = TriangleMesh { indices: soup.indices[1..].into(), ..soup };
        assert!(Body::of_mesh("open", &open).is_none());
    }

    #[test]
    fn counts_are_those_of_the_lattice() {
        for n in [1_u16, 2, 7] {
            let body = grid_cube(n);
            let squares = 6 * usize::from(n).pow(2);
            assert_eq!((body.positions.len(), body.triangles.len()), (squares + 2, 2 * squares));
        }
    }

    #[test]
    fn triangles_face_outwards() {
        for body in [head(40), blob(24), grid_cube(7)] {
            let volume: f64 = body
                .triangles
                .iter()
                .map(|triangle| {
                    let [a, b, c] = triangle.map(|index| body.positions[index as usize]);
                    f64::from(a.dot(b.cross(c))) / 6.0
                })
                .sum();
            assert!(volume > 2.0, "{}: {volume}", body.name);
        }
    }
}
