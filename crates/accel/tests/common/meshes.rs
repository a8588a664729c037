//! Closed meshes.

use std::collections::HashMap;
use std::f32::consts::TAU;

use sahl_accel::{PatchMesh, TriangleMesh};
use sahl_math::Vec3;

/// A closed body: its faces by vertex indices, and points from which every ray hits it.
#[derive(Clone)]
pub(crate) struct Body {
    pub(crate) name: &'static str,
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Corners of quadrilaterals in the order round their outline.
    pub(crate) quads: Vec<[u32; 4]>,
    /// Strictly inside.
    pub(crate) inside: Vec<Vec3>,
    /// Where the middle of a cube lies.
    pub(crate) center: Vec3,
}

impl Body {
    pub(crate) fn scaled(mut self, factor: f32) -> Self {
        for p in self.positions.iter_mut().chain(&mut self.inside) {
            *p *= factor;
        }
        self.center *= factor;
        self
    }

    pub(crate) fn moved(mut self, offset: Vec3) -> Self {
        for p in self.positions.iter_mut().chain(&mut self.inside) {
            *p += offset;
        }
        self.center += offset;
        self
    }

    pub(crate) fn triangle_mesh(&self) -> TriangleMesh {
        TriangleMesh {
            indices: self.triangles.as_slice().into(),
            positions: self.positions.as_slice().into(),
        }
    }

    pub(crate) fn patch_mesh(&self) -> PatchMesh {
        let indices: Vec<[u32; 4]> = self.quads.iter().map(|&[a, b, c, d]| [a, b, d, c]).collect();
        PatchMesh { indices: indices.into(), positions: self.positions.as_slice().into() }
    }

    /// Every vertex, and the middle of every edge, as `f32` gives it.
    pub(crate) fn targets(&self) -> Vec<Vec3> {
        let mut targets = self.positions.clone();
        let mut outline = |face: &[u32]| {
            for (i, &a) in face.iter().enumerate() {
                let (p, q) =
                    (self.positions[a as usize], self.positions[face[(i + 1) % face.len()] as usize]);
                targets.push((p + q) * 0.5);
            }
        };
        if self.quads.is_empty() {
            self.triangles.iter().for_each(|face| outline(face));
        } else {
            self.quads.iter().for_each(|face| outline(face));
        }
        targets
    }
}

/// An icosahedron subdivided `levels` times, its vertices moved in and out.
pub(crate) fn blob(levels: u32) -> Body {
    let phi = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let mut positions: Vec<Vec3> = Vec::new();
    for (a, b) in [(1.0, phi), (-1.0, phi), (1.0, -phi), (-1.0, -phi)] {
        positions.extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)]);
    }
    // Faces: all triples at the distance of an edge, which is 2.
    let near = |p: Vec3, q: Vec3| ((p - q).length() - 2.0).abs() < 1e-3;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [p, q, r] = [positions[a], positions[b], positions[c]];
                if near(p, q) && near(q, r) && near(r, p) {
                    triangles.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    for _ in 0..levels {
        triangles = subdivide(&mut positions, &triangles);
    }
    for p in &mut positions {
        let n = p.normalize();
        let bump = (9.0 * n.x).sin() * (7.0 * n.y + 1.0).sin() + 0.5 * (31.0 * n.z + 17.0 * n.x).sin();
        *p = n * (1.0 + 0.1 * bump) + Vec3::new(0.3, -0.2, 0.1);
    }
    let inside = (0..64)
        .map(|i| {
            let f = i as f32;
            Vec3::new(f.sin(), (2.0 * f).cos(), (3.0 * f).sin()) * 0.3 + Vec3::new(0.3, -0.2, 0.1)
        })
        .collect();
    Body { name: "blob", positions, triangles, quads: Vec::new(), inside, center: Vec3::ZERO }
}

fn subdivide(positions: &mut Vec<Vec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::new();
    let mut result = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let mut middle = |p: u32, q: u32| {
            *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                positions.push(((positions[p as usize] + positions[q as usize]) * 0.5).normalize());
                positions.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        result.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    result
}

/// The cube from −1 to 1 with a grid of `n × n` squares a face.
pub(crate) fn grid_cube(n: u32) -> Body {
    let (mut positions, mut triangles, mut quads) = (Vec::new(), Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let base = positions.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let mut p = Vec3::splat(side);
                    p[(axis + 1) % 3] = 2.0 * i as f32 / n as f32 - 1.0;
                    p[(axis + 2) % 3] = 2.0 * j as f32 / n as f32 - 1.0;
                    positions.push(p);
                }
            }
            for i in 0..n {
                for j in 0..n {
                    let at = |i: u32, j: u32| base + i * (n + 1) + j;
                    push_quad(
                        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)],
                        &mut triangles,
                        &mut quads,
                    );
                }
            }
        }
    }
    let steps = [-0.75, -0.3, 0.0, 0.25, 0.9];
    let inside = (0..125).map(|i| Vec3::new(steps[i % 5], steps[i / 5 % 5], steps[i / 25])).collect();
    Body { name: "grid cube", positions, triangles, quads, inside, center: Vec3::ZERO }
}

/// A torus of `n × m` quadrilaterals that are not flat.
pub(crate) fn torus(n: u32, m: u32) -> Body {
    let (large, small) = (1.0, 0.4);
    let ring = |s: f32, t: f32, r: f32| {
        let (s, t) = (s * TAU, t * TAU);
        let across = large + r * t.cos();
        Vec3::new(across * s.cos(), across * s.sin(), r * t.sin()) + Vec3::new(-0.2, 0.7, 0.4)
    };
    let (mut positions, mut triangles, mut quads) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..n {
        for j in 0..m {
            // Twisted, so that the quadrilaterals are skew.
            positions.push(ring(i as f32 / n as f32, (j as f32 + 0.35 * (i % 2) as f32) / m as f32, small));
        }
    }
    for i in 0..n {
        for j in 0..m {
            let at = |i: u32, j: u32| (i % n) * m + j % m;
            push_quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], &mut triangles, &mut quads);
        }
    }
    let inside = (0..64).map(|i| ring(i as f32 / 64.0, i as f32 / 7.0, 0.15)).collect();
    Body { name: "torus", positions, triangles, quads, inside, center: Vec3::ZERO }
}

fn push_quad(quad: [u32; 4], triangles: &mut Vec<[u32; 3]>, quads: &mut Vec<[u32; 4]>) {
    let [a, b, c, d] = quad;
    quads.push(quad);
    triangles.extend([[a, b, c], [a, c, d]]);
}
