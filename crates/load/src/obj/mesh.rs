//! The polygons of one material as a mesh of triangles.

use sahl_math::{Vec2, Vec3};
use sahl_scene::TriangleMesh;

use super::parse::{Corner, Group, NONE, ObjFile};
use super::polygon;
use crate::normals;

/// Vertices at one position that a corner is compared with. Where a file puts more there, vertices may repeat, which
/// harms nothing; a search through all of them would take quadratic time.
const MOST_COMPARED: usize = 32;

/// What became of the polygons.
#[derive(Debug, Default)]
pub(super) struct Built {
    pub(super) mesh: TriangleMesh,
    /// Triangles with fewer than three different vertices, left out.
    pub(super) degenerate: usize,
    /// Normals that were zero or not finite, computed from the faces.
    pub(super) repaired: usize,
}

/// Builds the meshes of the groups of a file, one after the other.
pub(super) struct MeshBuilder<'a> {
    file: &'a ObjFile,
    /// For each position of the file the latest vertex made of it, or [`NONE`].
    latest: Vec<u32>,
}

/// The mesh that is being built: each vertex is a position with one texture coordinate and one normal.
#[derive(Default)]
struct Mesh {
    corners: Vec<Corner>,
    /// For each vertex an earlier one at the same position, or [`NONE`].
    earlier: Vec<u32>,
    /// Normals of faces, for corners without one; they count on after the normals of the file.
    face_normals: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    degenerate: usize,
}

impl<'a> MeshBuilder<'a> {
    pub(super) fn new(file: &'a ObjFile) -> Self {
        Self { file, latest: vec![NONE; file.positions.len()] }
    }

    /// The mesh of a group. Equal corners share a vertex. Where some corners have a normal and others do not, those get
    /// the normal of their face; where some have no texture coordinates, those get zero.
    pub(super) fn build(&mut self, group: &Group) -> Built {
        let has_normals = group.corners.iter().any(|corner| corner.normal != NONE);
        let has_uvs = group.corners.iter().any(|corner| corner.uv != NONE);
        let mut mesh = Mesh::default();
        let mut start = 0;
        let mut positions = Vec::new();
        let mut polygon = Vec::new();
        for &end in &group.ends {
            let corners = &group.corners[start..end];
            start = end;
            positions.clear();
            positions.extend(corners.iter().map(|corner| self.file.positions[corner.position as usize]));
            polygon.clear();
            let face_normal = (has_normals && corners.iter().any(|corner| corner.normal == NONE))
                .then(|| mesh.add_face_normal(&positions, self.file.normals.len()));
            for &corner in corners {
                let normal = if corner.normal == NONE { face_normal.unwrap_or(NONE) } else { corner.normal };
                polygon.push(mesh.vertex(Corner { normal, ..corner }, &mut self.latest));
            }
            polygon::triangulate(&positions, |triangle| mesh.push(triangle.map(|corner| polygon[corner])));
        }
        for corner in &mesh.corners {
            self.latest[corner.position as usize] = NONE;
        }
        self.finish(mesh, has_normals, has_uvs)
    }

    fn finish(&self, mesh: Mesh, has_normals: bool, has_uvs: bool) -> Built {
        let file = self.file;
        let positions: Vec<Vec3> =
            mesh.corners.iter().map(|corner| file.positions[corner.position as usize]).collect();
        let uvs = has_uvs.then(|| {
            let uv = |corner: &Corner| file.uvs.get(corner.uv as usize).copied().unwrap_or(Vec2::ZERO);
            mesh.corners.iter().map(uv).collect()
        });
        let mut repaired = 0;
        let normals = has_normals.then(|| {
            let normal = |corner: &Corner| {
                let index = corner.normal as usize;
                let count = file.normals.len();
                if index < count { file.normals[index] } else { mesh.face_normals[index - count] }
            };
            let mut normals: Vec<Vec3> = mesh.corners.iter().map(normal).collect();
            repaired = normals::repair(&mut normals, &positions, mesh.indices.iter().copied());
            normals.into()
        });
        let mesh_degenerate = mesh.degenerate;
        let mesh = TriangleMesh {
            indices: mesh.indices.into(),
            positions: positions.into(),
            normals,
            tangents: None,
            uvs,
            face_indices: None,
        };
        Built { mesh, degenerate: mesh_degenerate, repaired }
    }
}

impl Mesh {
    /// The vertex for a corner, made if there is none. `latest` leads to the vertices at each position.
    fn vertex(&mut self, corner: Corner, latest: &mut [u32]) -> u32 {
        let latest = &mut latest[corner.position as usize];
        let mut vertex = *latest;
        for _ in 0..MOST_COMPARED {
            if vertex == NONE {
                break;
            }
            if self.corners[vertex as usize] == corner {
                return vertex;
            }
            vertex = self.earlier[vertex as usize];
        }
        // No overflow: a file has fewer than 2^32 corners, or it would not be in memory.
        let vertex = self.corners.len() as u32;
        self.corners.push(corner);
        self.earlier.push(std::mem::replace(latest, vertex));
        vertex
    }

    /// Adds the normal of a polygon (Newell's method) and gives its index, counted on from `first`.
    fn add_face_normal(&mut self, positions: &[Vec3], first: usize) -> u32 {
        let fan = positions.get(1..).unwrap_or_default().windows(2);
        let sum =
            fan.fold(Vec3::ZERO, |sum, pair| sum + (pair[0] - positions[0]).cross(pair[1] - positions[0]));
        self.face_normals.push(sum.try_normalize().unwrap_or(Vec3::ZERO));
        (first + self.face_normals.len() - 1) as u32
    }

    fn push(&mut self, triangle: [u32; 3]) {
        let [a, b, c] = triangle.map(|vertex| self.corners[vertex as usize].position);
        if a == b || b == c || c == a {
            self.degenerate += 1;
        } else {
            self.indices.push(triangle);
        }
    }
}
