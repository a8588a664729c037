//! The two meshes, by arithmetic that is exact everywhere: no sine, no random numbers but an integer hash. So every
//! machine makes the same bytes, which a test compares with the committed files.

use sahl::math::Vec3;

/// Triangles that share vertices.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) indices: Vec<[u32; 3]>,
}

impl Mesh {
    fn vertex(&mut self, p: Vec3) -> u32 {
        self.positions.push(p);
        self.positions.len() as u32 - 1
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.indices.extend([[a, b, c], [a, c, d]]);
    }

    /// A box with edges along the axes.
    fn cuboid(&mut self, low: Vec3, high: Vec3) {
        let corner = |i: u32, axis: u32, low: f32, high: f32| if i >> axis & 1 == 0 { low } else { high };
        let first = self.positions.len() as u32;
        for i in 0..8 {
            let p = Vec3::new(
                corner(i, 0, low.x, high.x),
                corner(i, 1, low.y, high.y),
                corner(i, 2, low.z, high.z),
            );
            self.vertex(p);
        }
        let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        for side in sides {
            self.quad(side.map(|corner| first + corner));
        }
    }
}

/// A sphere of radius about one whose surface has hills and pores: 20 × 4^`levels` triangles of about equal size.
pub(crate) fn bumpy_sphere(levels: u32) -> Mesh {
    let mut mesh = icosahedron();
    for _ in 0..levels {
        mesh = subdivide(&mesh);
    }
    for p in &mut mesh.positions {
        let height = 0.16 * noise(*p * 2.5) + 0.07 * noise(*p * 6.0) + 0.03 * noise(*p * 15.0);
        *p *= 1.0 + height;
        // Coarser numbers make a smaller file; the step is far below the size of a triangle.
        *p = Vec3::new(quantised(p.x), quantised(p.y), quantised(p.z));
    }
    mesh
}

fn quantised(x: f32) -> f32 {
    (x * 16384.0).round() / 16384.0
}

fn icosahedron() -> Mesh {
    let long = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let mut mesh = Mesh::default();
    for (a, b) in [(-1.0, long), (1.0, long), (-1.0, -long), (1.0, -long)] {
        mesh.vertex(Vec3::new(a, b, 0.0).normalize());
    }
    for (a, b) in [(-1.0, long), (1.0, long), (-1.0, -long), (1.0, -long)] {
        mesh.vertex(Vec3::new(0.0, a, b).normalize());
    }
    for (a, b) in [(-1.0, long), (1.0, long), (-1.0, -long), (1.0, -long)] {
        mesh.vertex(Vec3::new(b, 0.0, a).normalize());
    }
    mesh.indices = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    mesh
}

/// Cuts each triangle into four, with the new vertices on the unit sphere.
fn subdivide(mesh: &Mesh) -> Mesh {
    let mut finer = Mesh { positions: mesh.positions.clone(), indices: Vec::new() };
    let mut middles = std::collections::BTreeMap::new();
    for &[a, b, c] in &mesh.indices {
        let mut middle = |i: u32, j: u32| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                let p = (mesh.positions[i as usize] + mesh.positions[j as usize]).normalize();
                finer.vertex(p)
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        finer.indices.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    finer
}

/// Value noise between −1 and 1: random values at whole coordinates, smooth between them.
fn noise(p: Vec3) -> f32 {
    let cell = [p.x.floor(), p.y.floor(), p.z.floor()];
    let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
    let t = [smooth(p.x - cell[0]), smooth(p.y - cell[1]), smooth(p.z - cell[2])];
    let mut sum = 0.0;
    for corner in 0..8_u32 {
        let mut weight = 1.0;
        let mut key = 0_u32;
        for axis in 0..3 {
            let up = corner >> axis & 1;
            weight *= if up == 1 { t[axis as usize] } else { 1.0 - t[axis as usize] };
            let coordinate = cell[axis as usize] as i32 + up as i32;
            key = hash(key ^ coordinate as u32);
        }
        sum += weight * ((key >> 8) as f32 / 8_388_608.0 - 1.0);
    }
    sum
}

/// Wellons' `lowbias32`, an integer hash that mixes well (2018).
fn hash(mut x: u32) -> u32 {
    x = x.wrapping_add(0x9E37_79B9);
    x = (x ^ x >> 16).wrapping_mul(0x7FEB_352D);
    x = (x ^ x >> 15).wrapping_mul(0x846C_A68B);
    x ^ x >> 16
}

/// An oval stadium, 216 m long: a pitch of two triangles, stands of long thin steps, pillars and a roof of beams.
pub(crate) fn stadium() -> Mesh {
    const SEGMENTS: u32 = 96;
    const ROWS: u32 = 40;
    let mut mesh = Mesh::default();
    let pitch = [(-150.0, -110.0), (-150.0, 110.0), (150.0, 110.0), (150.0, -110.0)];
    let corners = pitch.map(|(x, z)| mesh.vertex(Vec3::new(x, 0.0, z)));
    mesh.quad(corners);

    // Each ring of vertices is joined to the one before: the riser of a row, then its tread.
    let mut before: Option<u32> = None;
    for row in 0..ROWS {
        for (out, up) in [(0.0, 0.0), (0.0, 0.5), (0.8, 0.5)] {
            if row > 0 && up == 0.0 {
                continue;
            }
            let ring = mesh.positions.len() as u32;
            for segment in 0..SEGMENTS {
                let radius = 40.0 + 0.8 * row as f32 + out;
                let height = 0.5 * row as f32 + up;
                mesh.vertex(oval(segment, SEGMENTS, radius, height));
            }
            if let Some(before) = before {
                for i in 0..SEGMENTS {
                    let j = (i + 1) % SEGMENTS;
                    mesh.quad([before + i, ring + i, ring + j, before + j]);
                }
            }
            before = Some(ring);
        }
    }
    for segment in (0..SEGMENTS).step_by(2) {
        let foot = oval(segment, SEGMENTS, 73.0, 0.0);
        let half = Vec3::new(0.3, 0.0, 0.3);
        mesh.cuboid(foot - half, foot + half + Vec3::new(0.0, 30.0, 0.0));
        beam(&mut mesh, oval(segment, SEGMENTS, 73.0, 30.0), oval(segment, SEGMENTS, 45.0, 34.0));
    }
    mesh
}

/// A beam of triangular section, 30 m long and 40 cm thick.
fn beam(mesh: &mut Mesh, from: Vec3, to: Vec3) {
    let offsets = [Vec3::new(-0.2, 0.0, -0.2), Vec3::new(0.2, 0.0, 0.2), Vec3::new(0.0, 0.4, 0.0)];
    let start = offsets.map(|offset| mesh.vertex(from + offset));
    let end = offsets.map(|offset| mesh.vertex(to + offset));
    for side in 0..3 {
        let next = (side + 1) % 3;
        mesh.quad([start[side], start[next], end[next], end[side]]);
    }
}

/// A point of an oval by Pythagoras' rational circle: each quarter runs over ((1 − t²), 2t) / (1 + t²), t in [0, 1).
fn oval(segment: u32, segments: u32, radius: f32, height: f32) -> Vec3 {
    let quarter = segments / 4;
    let t = (segment % quarter) as f32 / quarter as f32;
    let (c, s) = ((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t));
    let (x, z) = match segment / quarter {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    };
    Vec3::new(1.5 * radius * x, height, radius * z)
}
