//! "Teapot in a stadium": one small thing of very many triangles in the middle of a huge one of few and long ones.
//!
//! The case is that of Wald's and others' talks on trees over uneven scenes. The teapot is a torus knot here.

use std::f32::consts::TAU;

use sahl_accel::TriangleMesh;
use sahl_math::Vec3;

use super::{Light, Model, View};

/// Rows of seats.
const TIERS: u32 = 96;
/// Seats a row.
const SEATS: u32 = 1_024;
/// Flat pieces round the bowl of each step.
const PIECES: u32 = 64;
/// Cables of the roof.
const CABLES: u32 = 360;
/// Cross-sections of the knot, and corners of each.
const KNOT: [u32; 2] = [2_048, 256];

/// About 2.3 million triangles, of which one million are the knot: 2 m of 200 m.
pub(crate) fn stadium() -> Model {
    let mut mesh = Soup::default();
    field(&mut mesh);
    tiers(&mut mesh);
    seats(&mut mesh);
    cables(&mut mesh);
    knot(&mut mesh);
    Model {
        name: "stadium",
        mesh: TriangleMesh { indices: mesh.triangles.into(), positions: mesh.positions.into() },
        view: View { eye: Vec3::new(2.2, 2.4, 3.6), target: Vec3::new(0.0, 1.3, 0.0), field: 60.0 },
        light: Light {
            corner: Vec3::new(-30.0, 60.0, -20.0),
            edges: [Vec3::new(60.0, 0.0, 0.0), Vec3::new(0.0, 0.0, 40.0)],
        },
    }
}

/// Triangles under construction.
#[derive(Default)]
struct Soup {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Soup {
    fn vertex(&mut self, p: Vec3) -> u32 {
        self.positions.push(p);
        self.positions.len() as u32 - 1
    }

    /// A quadrilateral by its corners in order.
    fn quad(&mut self, corners: [Vec3; 4]) {
        let [a, b, c, d] = corners.map(|p| self.vertex(p));
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// A box by a lower corner and its edges: twelve triangles over eight vertices.
    fn parallelepiped(&mut self, corner: Vec3, edges: [Vec3; 3]) {
        let [a, b, c] = edges;
        let base = self.positions.len() as u32;
        for offset in [Vec3::ZERO, a, a + b, b] {
            self.positions.extend([corner + offset, corner + offset + c]);
        }
        for [p, q, r, s] in
            [[0, 2, 4, 6], [1, 7, 5, 3], [0, 1, 3, 2], [2, 3, 5, 4], [4, 5, 7, 6], [6, 7, 1, 0]]
        {
            self.triangles.extend([[p, q, r].map(|i| base + i), [p, r, s].map(|i| base + i)]);
        }
    }
}

/// A point of the bowl: `turn` in [0, 1] round, `tier` outwards and upwards.
fn bowl(turn: f32, tier: f32, height: f32) -> Vec3 {
    let (sin, cos) = (turn * TAU).sin_cos();
    Vec3::new((55.0 + 0.8 * tier) * cos, height, (40.0 + 0.8 * tier) * sin)
}

/// How high a tier is.
fn rise(tier: u32) -> f32 {
    1.0 + 0.42 * tier as f32
}

/// The grass: two triangles.
fn field(mesh: &mut Soup) {
    let corners = [[-140.0, -125.0], [-140.0, 125.0], [140.0, 125.0], [140.0, -125.0]];
    mesh.quad(corners.map(|[x, z]| Vec3::new(x, 0.0, z)));
}

/// The steps: a tread and a riser for each tier and piece, long and narrow.
fn tiers(mesh: &mut Soup) {
    for tier in 0..TIERS {
        let (inner, outer) = (tier as f32, tier as f32 + 1.0);
        let (low, high) = (if tier == 0 { 0.0 } else { rise(tier - 1) }, rise(tier));
        for piece in 0..PIECES {
            let [from, to] = [piece, piece + 1].map(|i| i as f32 / PIECES as f32);
            mesh.quad([
                bowl(from, inner, low),
                bowl(to, inner, low),
                bowl(to, inner, high),
                bowl(from, inner, high),
            ]);
            mesh.quad([
                bowl(from, inner, high),
                bowl(to, inner, high),
                bowl(to, outer, high),
                bowl(from, outer, high),
            ]);
        }
    }
}

/// A box a seat, facing the field.
fn seats(mesh: &mut Soup) {
    for tier in 0..TIERS {
        for seat in 0..SEATS {
            let turn = (seat as f32 + 0.5 * (tier % 2) as f32) / SEATS as f32;
            let center = bowl(turn, tier as f32 + 0.5, rise(tier));
            let (sin, cos) = (turn * TAU).sin_cos();
            let (outwards, along) = (Vec3::new(cos, 0.0, sin), Vec3::new(-sin, 0.0, cos));
            let edges = [along * 0.24, outwards * 0.3, Vec3::Y * 0.35];
            mesh.parallelepiped(center - edges[0] * 0.5 - edges[1] * 0.5, edges);
        }
    }
}

/// The cables that hold a roof which is not there: 80 m long and 6 cm wide, at all angles.
fn cables(mesh: &mut Soup) {
    for cable in 0..CABLES {
        let turn = cable as f32 / CABLES as f32;
        let from = bowl(turn, TIERS as f32, 58.0);
        let to = bowl(turn + 0.13, -20.0, 47.0 + 4.0 * (turn * TAU * 9.0).sin());
        let across = (to - from).cross(Vec3::Y).normalize() * 0.06;
        mesh.parallelepiped(from, [to - from, across, Vec3::Y * 0.06]);
    }
}

/// A tube along the (2, 3) torus knot, standing on the middle of the field: a closed surface.
fn knot(mesh: &mut Soup) {
    let [sections, corners] = KNOT;
    let center = |s: f32| {
        let (sin, cos) = (3.0 * s).sin_cos();
        let ring = 0.65 + 0.28 * cos;
        Vec3::new(ring * (2.0 * s).cos(), ring * (2.0 * s).sin() + 1.15, 0.28 * sin)
    };
    let base = mesh.positions.len() as u32;
    for section in 0..sections {
        let s = section as f32 / sections as f32 * TAU;
        let tangent = (center(s + 1e-3) - center(s - 1e-3)).normalize();
        let outwards = (center(s) - Vec3::Y * 1.15).normalize();
        let a = outwards.cross(tangent).normalize();
        let b = tangent.cross(a);
        for corner in 0..corners {
            let (sin, cos) = (corner as f32 / corners as f32 * TAU).sin_cos();
            let rib = 0.14 + 0.012 * (40.0 * s).sin() * (6.0 * corner as f32 / corners as f32 * TAU).sin();
            mesh.vertex(center(s) + (a * cos + b * sin) * rib);
        }
    }
    for section in 0..sections {
        for corner in 0..corners {
            let at = |i: u32, j: u32| base + i % sections * corners + j % corners;
            let [p, q] = [at(section, corner), at(section + 1, corner)];
            let [r, s] = [at(section + 1, corner + 1), at(section, corner + 1)];
            mesh.triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
}
