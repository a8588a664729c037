//! Emitting triangles.

use sahl_math::{Bounds3, Vec2, Vec3, gamma};

use super::{EmitterPoint, per_solid_angle};
use crate::light::Cone;
use crate::warp;

/// A triangle, sampled uniformly by area.
#[derive(Clone, Debug)]
pub(crate) struct TriangleEmitter {
    vertices: [Vec3; 3],
    /// Unit normal, before shading normals turn it; zero if the triangle has no area.
    n: Vec3,
    area: f32,
    /// Shading normals, which decide the side.
    normals: Option<Box<[Vec3; 3]>>,
}

impl TriangleEmitter {
    /// The triangle with the given vertices. Its normal is (p₁ − p₀) × (p₂ − p₀), turned round if `flip`, and then to
    /// the side of the interpolated shading normals if there are any.
    pub(crate) fn new(vertices: [Vec3; 3], flip: bool, normals: Option<[Vec3; 3]>) -> Self {
        let [p0, p1, p2] = vertices;
        let cross = (p1 - p0).cross(p2 - p0);
        let n = cross.try_normalize().unwrap_or(Vec3::ZERO);
        Self {
            vertices,
            n: if flip { -n } else { n },
            area: 0.5 * cross.length(),
            normals: normals.map(Box::new),
        }
    }

    pub(crate) fn area(&self) -> f32 {
        self.area
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        Bounds3::from_points(self.vertices)
    }

    /// The normal, or all directions where shading normals put different parts on different sides.
    pub(super) fn facing(&self) -> Cone {
        let normals = self.normals.as_deref().map_or(&[][..], |normals| normals);
        let all = |sign: f32| normals.iter().all(|ns| sign * self.n.dot(*ns) > 0.0);
        match (all(1.0), all(-1.0)) {
            (true, _) => Cone::of(self.n),
            (false, true) => Cone::of(-self.n),
            (false, false) => Cone::ALL,
        }
    }

    #[inline]
    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> (EmitterPoint, f32) {
        let [b0, b1] = warp::uniform_triangle(u);
        let [p0, p1, p2] = self.vertices;
        let b2 = 1.0 - b0 - b1;
        let (q0, q1, q2) = (p0 * b0, p1 * b1, p2 * b2);
        let p = q0 + q1 + q2;
        let n = match &self.normals {
            Some(normals) => self.n.face_forward(normals[0] * b0 + normals[1] * b1 + normals[2] * b2),
            None => self.n,
        };
        let p_error = (q0.abs() + q1.abs() + q2.abs()) * gamma(6);
        let point = EmitterPoint { p, p_error, n, uv: Vec2::new(b1, b2) };
        (point, per_solid_angle(1.0 / self.area, from, p, n))
    }

    #[inline]
    pub(super) fn pdf(&self, from: Vec3, point: &EmitterPoint) -> f32 {
        per_solid_angle(1.0 / self.area, from, point.p, self.n)
    }
}
