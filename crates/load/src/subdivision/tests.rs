use std::collections::BTreeMap;

use super::*;

/// The cube from −1 to 1, its faces seen counter-clockwise from outside.
fn cube() -> (Vec<[u32; 3]>, Vec<Vec3>) {
    let positions = (0..8).map(|i| {
        let coordinate = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        Vec3::new(coordinate(0), coordinate(1), coordinate(2))
    });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    (faces.collect(), positions.collect())
}

/// A flat grid of `n × n` squares of edge one.
fn grid(n: u32) -> (Vec<[u32; 3]>, Vec<Vec3>) {
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let positions = (0..=n).flat_map(|j| (0..=n).map(move |i| Vec3::new(i as f32, j as f32, 0.0)));
    let faces = (0..n).flat_map(|j| (0..n).map(move |i| (i, j))).flat_map(|(i, j)| {
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    });
    (faces.collect(), positions.collect())
}

fn subdivided((faces, positions): &(Vec<[u32; 3]>, Vec<Vec3>), levels: u32) -> TriangleMesh {
    loop_subdivide(faces, positions, levels).unwrap()
}

/// How many half-edges lead from one vertex to another.
fn half_edges(mesh: &TriangleMesh) -> BTreeMap<(u32, u32), u32> {
    let mut counts = BTreeMap::new();
    for &[a, b, c] in mesh.indices.iter() {
        for edge in [(a, b), (b, c), (c, a)] {
            *counts.entry(edge).or_default() += 1;
        }
    }
    counts
}

#[test]
fn a_closed_mesh_stays_closed() {
    for levels in 0..5 {
        let mesh = subdivided(&cube(), levels);
        assert_eq!(mesh.indices.len(), 12 << (2 * levels));
        let edges = half_edges(&mesh);
        assert!(edges.iter().all(|(&(a, b), &count)| count == 1 && edges.contains_key(&(b, a))));
        // Euler: V − E + F = 2.
        assert_eq!(mesh.positions.len() + mesh.indices.len(), edges.len() / 2 + 2);
    }
}

#[test]
fn levels_approach_the_same_surface() {
    let meshes: Vec<TriangleMesh> = (0..5).map(|levels| subdivided(&cube(), levels)).collect();
    let finest = &meshes[4];
    for mesh in &meshes {
        for (i, p) in mesh.positions.iter().enumerate() {
            assert!(
                (*p - finest.positions[i]).length() < 1e-5,
                "vertices keep their numbers and their limits"
            );
        }
    }
}

#[test]
fn normals_are_perpendicular_to_the_limit() {
    let (coarse, fine) = (subdivided(&cube(), 2), subdivided(&cube(), 5));
    let face_normal = |mesh: &TriangleMesh, face: &[u32; 3]| {
        let [p, q, r] = face.map(|i| mesh.positions[i as usize]);
        (q - p).cross(r - p)
    };
    let mut sums = vec![Vec3::ZERO; fine.positions.len()];
    for face in fine.indices.iter() {
        for &vertex in face {
            sums[vertex as usize] += face_normal(&fine, face);
        }
    }
    for (normal, sum) in coarse.normals.unwrap().iter().zip(&sums) {
        let cosine = normal.normalize().dot(sum.normalize());
        assert!(cosine < -0.999, "pbrt's normals look against those of the triangles: {cosine}");
    }
}

#[test]
fn a_plane_stays_flat_and_its_border_becomes_a_spline() {
    let mesh = subdivided(&grid(4), 3);
    assert!(mesh.positions.iter().all(|p| p.z == 0.0));
    assert!(mesh.normals.as_ref().unwrap().iter().all(|n| (n.normalize() + Vec3::Z).length() < 1e-5));
    // The inside of a regular grid stays where it is; a straight border too, but for its corners, which are cut.
    let middle = mesh.positions[12];
    assert!((middle - Vec3::new(2.0, 2.0, 0.0)).length() < 1e-5, "{middle:?}");
    assert!((mesh.positions[2] - Vec3::new(2.0, 0.0, 0.0)).length() < 1e-5);
    // The limit of a uniform cubic B-spline at a control point is (1 4 1) / 6. Next to a corner these are (1, 0) and (0, 1).
    let corner = mesh.positions[0];
    assert!((corner - Vec3::new(1.0 / 6.0, 1.0 / 6.0, 0.0)).length() < 1e-5, "{corner:?}");
    let edges = half_edges(&mesh);
    let border = edges.keys().filter(|&&(a, b)| !edges.contains_key(&(b, a))).count();
    assert_eq!(border, 16 << 3);
}

#[test]
fn odd_valences_have_normals_on_borders_too() {
    for spokes in 1..9_u32 {
        let rim = (0..=spokes).map(|i| {
            let (sin, cos) = (i as f32 * 0.3).sin_cos();
            Vec3::new(cos, sin, 0.0)
        });
        let positions: Vec<Vec3> = [Vec3::ZERO].into_iter().chain(rim).collect();
        let faces: Vec<[u32; 3]> = (1..=spokes).map(|i| [0, i, i + 1]).collect();
        let mesh = loop_subdivide(&faces, &positions, 2).unwrap();
        for normal in mesh.normals.unwrap().iter() {
            assert!((normal.normalize() + Vec3::Z).length() < 1e-4, "{spokes} spokes: {normal:?}");
        }
    }
}

#[test]
fn meshes_that_are_no_surface_are_errors() {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE];
    let error = |faces: &[[u32; 3]], levels| loop_subdivide(faces, &positions, levels).unwrap_err();
    assert_eq!(error(&[[0, 1, 2], [0, 1, 3]], 1), "faces 0 and 1 are oriented differently along edge 0 1");
    assert_eq!(error(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]], 1), "3 faces share edge 0 1: expected two at most");
    assert_eq!(error(&[[0, 1, 2], [3, 3, 4]], 1), "face 1 has vertex 3 twice");
    assert_eq!(error(&[[0, 1, 2], [0, 3, 4]], 1), "the faces about vertex 0 are more than one sheet");
    assert_eq!(error(&[[0, 1, 2]], 12), "12 levels of 1 triangles are more than 4194304");
    assert_eq!(error(&[[0, 1, 2]], u32::MAX), "4294967295 levels of 1 triangles are more than 4194304");
    let unused = loop_subdivide(&[[0, 1, 2]], &positions, 1).unwrap();
    assert_eq!(unused.positions[3], Vec3::Z, "a vertex of no face stays");
}
