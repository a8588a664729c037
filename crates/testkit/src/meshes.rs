//! Triangle meshes as plain arrays, for tests and labs: closed, displaced, gridded, and very uneven ones.

use std::collections::BTreeMap;
use std::f32::consts::TAU;

use sahl_math::Vec3;

use crate::random::Rng;

/// Triangles: counter-clockwise seen from outside, where there is an outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Three vertices a triangle.
    pub indices: Vec<[u32; 3]>,
    /// Positions of the vertices.
    pub positions: Vec<Vec3>,
}

impl Mesh {
    /// The same mesh with `f` applied to each position.
    pub fn map(mut self, f: impl Fn(Vec3) -> Vec3) -> Self {
        self.positions.iter_mut().for_each(|p| *p = f(*p));
        self
    }

    /// The same mesh, larger by `factor` about the origin.
    pub fn scaled(self, factor: f32) -> Self {
        self.map(|p| p * factor)
    }

    /// The same mesh, moved by `offset`.
    pub fn translated(self, offset: Vec3) -> Self {
        self.map(|p| p + offset)
    }

    /// Both meshes in one.
    pub fn with(mut self, other: &Self) -> Self {
        let base = self.positions.len() as u32;
        self.indices.extend(other.indices.iter().map(|t| t.map(|i| i + base)));
        self.positions.extend_from_slice(&other.positions);
        self
    }

    /// The corners of triangle `i`.
    pub fn triangle(&self, i: usize) -> [Vec3; 3] {
        self.indices[i].map(|v| self.positions[v as usize])
    }

    /// The area of triangle `i`.
    pub fn area(&self, i: usize) -> f32 {
        let [a, b, c] = self.triangle(i);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Each undirected edge once, the smaller vertex first, in ascending order.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = self.directed_edges().map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Whether each directed edge occurs once and so does its opposite: a closed surface, consistently oriented.
    pub fn is_closed(&self) -> bool {
        let mut edges: Vec<[u32; 2]> = self.directed_edges().collect();
        edges.sort_unstable();
        let once = edges.windows(2).all(|pair| pair[0] != pair[1]);
        once && edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok())
    }

    /// The enclosed volume of a closed mesh: positive if the triangles are counter-clockwise from outside.
    pub fn volume(&self) -> f64 {
        let tetrahedron = |i: usize| {
            let [a, b, c] = self.triangle(i);
            f64::from(a.dot(b.cross(c))) / 6.0
        };
        (0..self.indices.len()).map(tetrahedron).sum()
    }

    fn directed_edges(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.indices.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
    }
}

/// The unit sphere from an icosahedron whose triangles are cut in four `subdivisions` times: `20 · 4ⁿ` triangles.
pub fn icosphere(subdivisions: u32) -> Mesh {
    let g = 0.5 * (1.0 + 5.0_f32.sqrt());
    let corners: [[f32; 3]; 12] = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ];
    let faces = "0b5 051 017 07a 0ab 159 5b4 ba2 a76 718 394 342 326 368 389 495 24b 62a 867 981";
    let digit = |c: char| c.to_digit(16).unwrap_or(0);
    let indices = faces.split(' ').map(|face| {
        let mut vertices = face.chars().map(digit);
        std::array::from_fn(|_| vertices.next().unwrap_or(0))
    });
    let positions = corners.iter().map(|&p| Vec3::from(p).normalize()).collect();
    let mut mesh = Mesh { indices: indices.collect(), positions };
    for _ in 0..subdivisions {
        mesh = subdivide_on_sphere(&mesh);
    }
    mesh
}

/// Cuts each triangle in four at the midpoints of its edges, which are moved out to the unit sphere.
fn subdivide_on_sphere(mesh: &Mesh) -> Mesh {
    let mut positions = mesh.positions.clone();
    let mut midpoints = BTreeMap::new();
    let mut midpoint = |a: u32, b: u32| {
        *midpoints.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            positions.push((positions[a as usize] + positions[b as usize]).normalize());
            positions.len() as u32 - 1
        })
    };
    let mut indices = Vec::with_capacity(mesh.indices.len() * 4);
    for &[a, b, c] in &mesh.indices {
        let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
        indices.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    Mesh { indices, positions }
}

/// An icosphere whose radius varies smoothly by up to `amplitude` (below one) about one: a closed, curved "blob".
///
/// The displacement is a sum of eight waves along random directions. Subdivisions 6 give 81 920 triangles.
pub fn blob(subdivisions: u32, amplitude: f32, seed: u64) -> Mesh {
    let mut rng = Rng::new(seed);
    let waves: [(Vec3, f32); 8] =
        std::array::from_fn(|i| (rng.direction() * (2.0 + i as f32), TAU * rng.next_f32()));
    let displacement = |p: Vec3| waves.iter().map(|&(k, phase)| (k.dot(p) + phase).sin()).sum::<f32>() / 8.0;
    icosphere(subdivisions).map(|p| p * (1.0 + amplitude * displacement(p)))
}

/// The cube [−1, 1]³ with `n × n` squares a face, two triangles a square: closed, and all edges axis-parallel or diagonal.
pub fn cube(n: u32) -> Mesh {
    let n = n.max(1);
    let mut positions = Vec::new();
    let mut numbers = BTreeMap::new();
    let mut vertex = |lattice: [u32; 3]| {
        *numbers.entry(lattice).or_insert_with(|| {
            positions.push(Vec3::from(lattice.map(|i| 2.0 * i as f32 / n as f32 - 1.0)));
            positions.len() as u32 - 1
        })
    };
    let mut indices = Vec::new();
    for axis in 0..3 {
        for far in [false, true] {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let mut corner = |di: u32, dj: u32| {
                    let mut lattice = [0; 3];
                    lattice[axis] = if far { n } else { 0 };
                    lattice[(axis + 1) % 3] = i + di;
                    lattice[(axis + 2) % 3] = j + dj;
                    vertex(lattice)
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                indices.extend(if far { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    Mesh { indices, positions }
}

/// A torus about the z axis: `around` segments of the ring of radius `major`, `across` of the tube of radius `minor`.
///
/// Both counts are at least three.
pub fn torus(major: f32, minor: f32, around: u32, across: u32) -> Mesh {
    let (around, across) = (around.max(3), across.max(3));
    let position = |i: u32, j: u32| {
        let (sin_ring, cos_ring) = (TAU * i as f32 / around as f32).sin_cos();
        let (sin_tube, cos_tube) = (TAU * j as f32 / across as f32).sin_cos();
        let radius = major + minor * cos_tube;
        Vec3::new(radius * cos_ring, radius * sin_ring, minor * sin_tube)
    };
    let grid = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let number = |i: u32, j: u32| (i % around) * across + j % across;
    let indices = grid.clone().flat_map(|(i, j)| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    Mesh { indices: indices.collect(), positions: grid.map(|(i, j)| position(i, j)).collect() }
}

/// Triangles whose sizes span four orders of magnitude: a floor of two, walls of long slivers, and clusters of tiny ones.
///
/// The scene on which a split at the median fails: most triangles sit in few small clusters, and the large ones
/// overlap all of them. About `triangles` in all, within [−100, 100]³.
pub fn uneven(triangles: u32, seed: u64) -> Mesh {
    let mut rng = Rng::new(seed);
    let mut mesh = Mesh::default();
    let mut push = |corners: [Vec3; 3]| {
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.indices.push([base, base + 1, base + 2]);
    };
    let [low, high] = [Vec3::splat(-100.0), Vec3::splat(100.0)];
    push([low, Vec3::new(100.0, -100.0, -100.0), Vec3::new(100.0, 100.0, -100.0)]);
    push([low, Vec3::new(100.0, 100.0, -100.0), Vec3::new(-100.0, 100.0, -100.0)]);
    let slivers = triangles / 50;
    for _ in 0..slivers {
        let (a, b) = (rng.point(low, high), rng.point(low, high));
        push([a, b, b + rng.direction() * 0.05]);
    }
    let centres: [Vec3; 12] = std::array::from_fn(|_| rng.point(low * 0.95, high * 0.95));
    for i in 0..triangles.saturating_sub(slivers + 2) {
        // The radius of a cluster and the size of its triangles shrink from cluster to cluster.
        let cluster = i as usize % centres.len();
        let radius = 4.0 * 0.6_f32.powi(cluster as i32);
        let p = centres[cluster] + rng.direction() * (radius * rng.next_f32());
        let size = radius * 0.03;
        push([p, p + rng.direction() * size, p + rng.direction() * size]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vertices less edges plus faces: two for a sphere, zero for a torus.
    fn euler(mesh: &Mesh) -> i64 {
        mesh.positions.len() as i64 - mesh.edges().len() as i64 + mesh.indices.len() as i64
    }

    #[test]
    fn closed_meshes_are_closed_and_face_outward() {
        let sphere = 4.0 / 3.0 * std::f64::consts::PI;
        let ring = 2.0 * std::f64::consts::PI.powi(2) * 2.0 * 0.25;
        for (name, mesh, triangles, characteristic, volume) in [
            ("icosphere", icosphere(4), 20 * 256, 2, sphere),
            ("cube", cube(5), 12 * 25, 2, 8.0),
            ("torus", torus(2.0, 0.5, 64, 32), 2 * 64 * 32, 0, ring),
            ("blob", blob(4, 0.2, 1), 20 * 256, 2, sphere),
        ] {
            assert_eq!(mesh.indices.len(), triangles, "{name}");
            assert!(mesh.is_closed(), "{name}");
            assert_eq!(euler(&mesh), characteristic, "{name}");
            assert!((mesh.volume() / volume - 1.0).abs() < 0.15, "{name}: {}", mesh.volume());
            assert!((0..mesh.indices.len()).all(|i| mesh.area(i) > 0.0), "{name}");
        }
    }

    #[test]
    fn an_open_or_turned_mesh_is_not_closed() {
        let mut open = icosphere(0);
        open.indices.pop();
        assert!(!open.is_closed());
        let mut turned = icosphere(0);
        turned.indices[3].swap(0, 1);
        assert!(!turned.is_closed());
    }

    #[test]
    fn the_blob_is_bumpy_and_belongs_to_its_seed() {
        let radii: Vec<f32> = blob(3, 0.3, 5).positions.iter().map(|p| p.length()).collect();
        let (low, high) = radii.iter().fold((f32::MAX, 0.0_f32), |(low, high), &r| (low.min(r), high.max(r)));
        assert!(low > 0.7 && low < 0.95 && high > 1.05 && high < 1.3, "{low} to {high}");
        assert_eq!(blob(2, 0.3, 5), blob(2, 0.3, 5));
        assert_ne!(blob(2, 0.3, 5), blob(2, 0.3, 6));
    }

    #[test]
    fn uneven_triangles_span_orders_of_magnitude() {
        let mesh = uneven(10_000, 1);
        assert_eq!(mesh.indices.len(), 10_000);
        let mut areas: Vec<f32> = (0..mesh.indices.len()).map(|i| mesh.area(i)).collect();
        areas.sort_by(f32::total_cmp);
        assert!(areas[9_999] > 1e8 * areas[5_000], "{} and {}", areas[9_999], areas[5_000]);
        assert!(mesh.positions.iter().all(|p| p.abs().max_component() < 110.0));
    }

    #[test]
    fn meshes_are_moved_scaled_and_joined() {
        let two = cube(1).scaled(2.0).translated(Vec3::X * 10.0).with(&cube(1));
        assert!(two.is_closed());
        assert!((two.volume() - 72.0).abs() < 1e-3, "{}", two.volume());
        assert_eq!(two.indices.len(), 24);
    }
}
