//! Loop subdivision of triangle meshes, up to the limit surface.
//!
//! Each level cuts every triangle in four: new vertices on the edges, old ones moved towards their neighbours. What borders on
//! nothing follows the cubic B-spline of its border. At the end the vertices are moved to where they would come after
//! infinitely many levels, with the normals that the surface has there.
//!
//! Done while loading, since the result is a mesh like any other. In a scene file:
//! `Shape "loopsubdiv" "integer levels" 3 "integer indices" [ … ] "point3 P" [ … ]`.
//!
//! Source: Loop, *Smooth Subdivision Surfaces Based on Triangles*, 1987; Hoppe et al., *Piecewise Smooth Surface Reconstruction*, 1994
//! (borders, limits and tangents); Pharr, Jakob, Humphreys, *Physically Based Rendering*, 3rd ed., 2016, section 3.8. The weight of a
//! vertex with three neighbours is 3/16, of one with n others 3/(8 n). Deviation: there a border vertex moves by a fifth of each neighbour to
//! its limit; by a sixth it comes where the steps of an eighth lead.
//!
//! Deliberately absent: creases, texture coordinates, and meshes that are no surface, which are errors.

use std::f32::consts::{PI, TAU};

use sahl_math::Vec3;
use sahl_scene::TriangleMesh;

/// More triangles are not made of one mesh.
pub(crate) const MOST_TRIANGLES: u64 = 1 << 22;

/// The half-edge across a border.
const NONE: u32 = u32::MAX;

/// Subdivides a mesh `levels` times and moves it to its limit.
///
/// The vertices keep their order, and those of the last level follow; vertices of no face stay where they are. A triangle
/// `v0 v1 v2` becomes its corners in that order and then its middle. The normals point to the side from which the
/// triangles are seen clockwise, as in pbrt-v4.
///
/// # Errors
/// What makes the mesh no surface, or too many triangles. Indices must be below the number of positions.
pub(crate) fn loop_subdivide(
    indices: &[[u32; 3]],
    positions: &[Vec3],
    levels: u32,
) -> Result<TriangleMesh, String> {
    let triangles = (indices.len() as u64).saturating_mul(4_u64.checked_pow(levels).unwrap_or(u64::MAX));
    if triangles > MOST_TRIANGLES {
        return Err(format!("{levels} levels of {} triangles are more than {MOST_TRIANGLES}", indices.len()));
    }
    let (mut faces, mut positions) = (indices.to_vec(), positions.to_vec());
    let mut topology = Topology::new(&faces, positions.len())?;
    topology.check_sheets(&faces)?;
    for _ in 0..levels {
        (faces, positions) = topology.refine(&faces, &positions);
        topology = Topology::new(&faces, positions.len())?;
    }
    let limit = topology.moved(&faces, &positions, &LIMIT);
    let normals = topology.normals(&faces, &positions, &limit);
    Ok(TriangleMesh {
        indices: faces.into(),
        positions: limit.into(),
        normals: Some(normals.into()),
        ..TriangleMesh::default()
    })
}

/// How far vertices move towards the sum of their neighbours.
struct Rule {
    /// Inside, by the number of neighbours.
    interior: fn(f32) -> f32,
    /// On a border, where the two neighbours on it count.
    border: f32,
}

/// From one level to the next.
const STEP: Rule = Rule { interior: step_weight, border: 1.0 / 8.0 };

/// To the limit.
const LIMIT: Rule = Rule { interior: |n| 1.0 / (n + 3.0 / (8.0 * step_weight(n))), border: 1.0 / 6.0 };

fn step_weight(neighbours: f32) -> f32 {
    if neighbours == 3.0 { 3.0 / 16.0 } else { 3.0 / (8.0 * neighbours) }
}

/// Which faces meet where. Half-edge `3 f + k` leads along face `f` from its vertex `k` to the next.
struct Topology {
    /// The half-edge that leads the other way, or [`NONE`] at a border.
    opposite: Vec<u32>,
    /// The edge of each half-edge.
    edge: Vec<u32>,
    edges: u32,
    /// A half-edge that leaves each vertex, or [`NONE`].
    leaving: Vec<u32>,
    is_border: Vec<bool>,
}

fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
}

fn previous(half_edge: u32) -> u32 {
    if half_edge.is_multiple_of(3) { half_edge + 2 } else { half_edge - 1 }
}

fn origin(faces: &[[u32; 3]], half_edge: u32) -> u32 {
    faces[half_edge as usize / 3][half_edge as usize % 3]
}

impl Topology {
    fn new(faces: &[[u32; 3]], vertices: usize) -> Result<Self, String> {
        let count = 3 * faces.len() as u32;
        let ends = |half_edge: u32| [origin(faces, half_edge), origin(faces, next(half_edge))];
        let mut sorted: Vec<(u32, u32, u32)> = (0..count)
            .map(|half_edge| {
                let [a, b] = ends(half_edge);
                (a.min(b), a.max(b), half_edge)
            })
            .collect();
        sorted.sort_unstable();
        let mut topology = Self {
            opposite: vec![NONE; count as usize],
            edge: vec![0; count as usize],
            edges: 0,
            leaving: vec![NONE; vertices],
            is_border: vec![false; vertices],
        };
        for same in sorted.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            topology.join(same, ends)?;
        }
        for half_edge in (0..count).rev() {
            topology.leaving[origin(faces, half_edge) as usize] = half_edge;
        }
        Ok(topology)
    }

    /// Notes the half-edges `same` that share their ends.
    fn join(&mut self, same: &[(u32, u32, u32)], ends: impl Fn(u32) -> [u32; 2]) -> Result<(), String> {
        let (a, b, first) = same[0];
        if a == b {
            return Err(format!("face {} has vertex {a} twice", first / 3));
        }
        match *same {
            [_] => {
                self.is_border[a as usize] = true;
                self.is_border[b as usize] = true;
            }
            [_, (_, _, second)] if ends(first) != ends(second) => {
                self.opposite[first as usize] = second;
                self.opposite[second as usize] = first;
            }
            [_, (_, _, second)] => {
                let (f, g) = (first / 3, second / 3);
                return Err(format!("faces {f} and {g} are oriented differently along edge {a} {b}"));
            }
            _ => return Err(format!("{} faces share edge {a} {b}: expected two at most", same.len())),
        }
        for &(_, _, half_edge) in same {
            self.edge[half_edge as usize] = self.edges;
        }
        self.edges += 1;
        Ok(())
    }

    /// Complains about vertices in which sheets meet that share no edge.
    fn check_sheets(&self, faces: &[[u32; 3]]) -> Result<(), String> {
        let mut counts = vec![0_usize; self.leaving.len()];
        for &vertex in faces.as_flattened() {
            counts[vertex as usize] += 1;
        }
        let mut ring = Vec::new();
        for (vertex, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            self.ring(faces, vertex, &mut ring);
            if ring.len() != count + usize::from(self.is_border[vertex]) {
                return Err(format!("the faces about vertex {vertex} are more than one sheet"));
            }
        }
        Ok(())
    }

    /// The neighbours of a vertex of a face in their order; on a border from end to end.
    fn ring(&self, faces: &[[u32; 3]], vertex: usize, ring: &mut Vec<u32>) {
        ring.clear();
        let opposite = |half_edge: u32| self.opposite[half_edge as usize];
        let start = self.leaving[vertex];
        let mut at = start;
        if !self.is_border[vertex] {
            loop {
                ring.push(origin(faces, next(at)));
                at = next(opposite(at));
                if at == start {
                    return;
                }
            }
        }
        while opposite(at) != NONE && next(opposite(at)) != start {
            at = next(opposite(at));
        }
        let first = at;
        ring.push(origin(faces, next(at)));
        loop {
            ring.push(origin(faces, previous(at)));
            at = opposite(previous(at));
            if at == NONE || at == first {
                return;
            }
        }
    }

    /// The next level: faces and positions.
    fn refine(&self, faces: &[[u32; 3]], positions: &[Vec3]) -> (Vec<[u32; 3]>, Vec<Vec3>) {
        let mut refined = self.moved(faces, positions, &STEP);
        let first = refined.len() as u32;
        refined.resize(positions.len() + self.edges as usize, Vec3::ZERO);
        for half_edge in 0..self.opposite.len() as u32 {
            let at = |half_edge: u32| positions[origin(faces, half_edge) as usize];
            let ends = at(half_edge) + at(next(half_edge));
            let opposite = self.opposite[half_edge as usize];
            refined[(first + self.edge[half_edge as usize]) as usize] = if opposite == NONE {
                ends * 0.5
            } else if half_edge < opposite {
                ends * (3.0 / 8.0) + (at(previous(half_edge)) + at(previous(opposite))) * (1.0 / 8.0)
            } else {
                continue;
            };
        }
        let quarters = faces.iter().zip(self.edge.as_chunks::<3>().0).flat_map(|(&[a, b, c], edges)| {
            let [ab, bc, ca] = edges.map(|edge| first + edge);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        (quarters.collect(), refined)
    }

    /// The vertices moved towards their neighbours.
    fn moved(&self, faces: &[[u32; 3]], positions: &[Vec3], rule: &Rule) -> Vec<Vec3> {
        // The neighbours that count, and how many they are.
        let mut sums = vec![(Vec3::ZERO, 0.0_f32); positions.len()];
        let mut add = |vertex: u32, neighbour: u32| {
            let (sum, count) = &mut sums[vertex as usize];
            *sum += positions[neighbour as usize];
            *count += 1.0;
        };
        for half_edge in 0..self.opposite.len() as u32 {
            let [a, b] = [origin(faces, half_edge), origin(faces, next(half_edge))];
            if !self.is_border[a as usize] {
                add(a, b);
            }
            if self.opposite[half_edge as usize] == NONE {
                add(a, b);
                add(b, a);
            }
        }
        let moved = |((&p, &is_border), &(sum, count)): ((&Vec3, &bool), &(Vec3, f32))| match count {
            0.0 => p,
            _ => {
                let weight = if is_border { rule.border } else { (rule.interior)(count) };
                p * (1.0 - count * weight) + sum * weight
            }
        };
        positions.iter().zip(&self.is_border).zip(&sums).map(moved).collect()
    }

    /// Normals of the limit surface, not of unit length: cross products of two tangents.
    fn normals(&self, faces: &[[u32; 3]], positions: &[Vec3], limit: &[Vec3]) -> Vec<Vec3> {
        let (mut indices, mut ring) = (Vec::new(), Vec::new());
        let normal = |(vertex, &center): (usize, &Vec3)| {
            if self.leaving[vertex] == NONE {
                return Vec3::Z;
            }
            self.ring(faces, vertex, &mut indices);
            ring.clear();
            ring.extend(indices.iter().map(|&index| positions[index as usize]));
            let [s, t] =
                if self.is_border[vertex] { border_tangents(&ring, center) } else { tangents(&ring) };
            s.cross(t)
        };
        limit.iter().enumerate().map(normal).collect()
    }
}

/// Tangents of the limit surface from the neighbours of a vertex inside.
fn tangents(ring: &[Vec3]) -> [Vec3; 2] {
    let mut tangents = [Vec3::ZERO; 2];
    for (i, &p) in ring.iter().enumerate() {
        let (sin, cos) = (TAU * i as f32 / ring.len() as f32).sin_cos();
        tangents[0] += p * cos;
        tangents[1] += p * sin;
    }
    tangents
}

/// Tangents of the limit surface along and across a border; `center` is where its vertex lies in the limit.
fn border_tangents(ring: &[Vec3], center: Vec3) -> [Vec3; 2] {
    let last = ring[ring.len() - 1];
    let across = match *ring {
        [a, b] => a + b - center * 2.0,
        [_, middle, _] => middle - center,
        [a, b, c, d] => (b + c) * 2.0 - a - d - center * 2.0,
        _ => {
            let step = PI / (ring.len() - 1) as f32;
            let mut sum = (ring[0] + last) * step.sin();
            for (k, &p) in ring.iter().enumerate().take(ring.len() - 1).skip(1) {
                sum += p * ((2.0 * step.cos() - 2.0) * (k as f32 * step).sin());
            }
            -sum
        }
    };
    [last - ring[0], across]
}

#[cfg(test)]
mod tests;
