//! Affine transformations with their inverses.

use glam::{DAffine3, DMat3, DMat4, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Bounds3, Ray, Vec3, gamma};

/// An affine map with its inverse: `p ↦ M p + t`.
///
/// Composed in `f64`, so that a long chain of scene-file directives loses nothing, and applied in `f32`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "[[f64; 4]; 3]", into = "[[f64; 4]; 3]")]
pub struct Transform {
    /// Rows of the 3 × 4 matrix, as applied.
    rows: [[f32; 4]; 3],
    /// Rows of the 3 × 4 matrix of the inverse, as applied.
    inverse_rows: [[f32; 4]; 3],
    /// The map in the precision in which it is composed.
    exact: DAffine3,
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// The map that changes nothing.
    pub const IDENTITY: Self = {
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        Self { rows, inverse_rows: rows, exact: DAffine3::IDENTITY }
    };

    /// From the rows of a 3 × 4 matrix; `None` if it is singular or not finite.
    pub fn from_rows(rows: [[f64; 4]; 3]) -> Option<Self> {
        let column = |i: usize| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
        Self::from_exact(DAffine3 {
            matrix3: DMat3::from_cols(column(0), column(1), column(2)),
            translation: column(3),
        })
    }

    /// From the columns of a 4 × 4 matrix, as scene files list them.
    ///
    /// `None` if it is singular, not finite, or projective (last row other than a multiple of 0 0 0 1).
    pub fn from_columns(columns: [f64; 16]) -> Option<Self> {
        let m = DMat4::from_cols_array(&columns);
        let last = m.row(3);
        (last.truncate() == DVec3::ZERO && last.w != 0.0)
            .then(|| m * (1.0 / last.w))
            .and_then(|m| Self::from_exact(DAffine3::from_mat4(m)))
    }

    /// Moves points by (`x`, `y`, `z`) and leaves vectors and normals as they are; `None` if one of the three is not finite.
    pub fn translate(x: f64, y: f64, z: f64) -> Option<Self> {
        Self::from_exact(DAffine3::from_translation(DVec3::new(x, y, z)))
    }

    /// Scales along the axes; `None` if a factor is zero or not finite.
    pub fn scale(x: f64, y: f64, z: f64) -> Option<Self> {
        Self::from_exact(DAffine3::from_scale(DVec3::new(x, y, z)))
    }

    /// Rotates by `angle` radians about `axis`, counter-clockwise seen against the axis; `None` without an axis.
    pub fn rotate(angle: f64, axis: [f64; 3]) -> Option<Self> {
        let axis = DVec3::from_array(axis).try_normalize()?;
        Self::from_exact(DAffine3::from_axis_angle(axis, angle))
    }

    /// World to camera space for a camera at `eye` that looks at `target`, with `up` upwards: in camera space +z points
    /// forward, +y up and +x right (left-handed, as pbrt has it). `None` where the directions do not span a frame.
    pub fn look_at(eye: [f64; 3], target: [f64; 3], up: [f64; 3]) -> Option<Self> {
        let eye = DVec3::from_array(eye);
        let forward = (DVec3::from_array(target) - eye).try_normalize()?;
        let right = DVec3::from_array(up).try_normalize()?.cross(forward).try_normalize()?;
        let camera_to_world =
            DAffine3 { matrix3: DMat3::from_cols(right, forward.cross(right), forward), translation: eye };
        Self::from_exact(camera_to_world.inverse())
    }

    /// The map in the precision in which it is composed.
    #[inline]
    pub(crate) fn exact(&self) -> DAffine3 {
        self.exact
    }

    pub(crate) fn from_exact(exact: DAffine3) -> Option<Self> {
        let inverse = exact.inverse();
        let finite = |m: &DAffine3| to_f32(m).as_flattened().iter().all(|x| x.is_finite());
        (exact.matrix3.determinant() != 0.0 && finite(&exact) && finite(&inverse)).then(|| Self {
            rows: to_f32(&exact),
            inverse_rows: to_f32(&inverse),
            exact,
        })
    }

    /// The map that applies `first` and then `self`.
    ///
    /// The product of two maps that are finite may overflow; it is then `self`'s caller that cannot mean it, and the
    /// result is `None`.
    pub fn after(&self, first: &Self) -> Option<Self> {
        Self::from_exact(self.exact * first.exact)
    }

    /// The inverse map.
    pub fn inverse(&self) -> Self {
        Self { rows: self.inverse_rows, inverse_rows: self.rows, exact: self.exact.inverse() }
    }

    /// Rows of the 3 × 4 matrix.
    pub fn to_rows(&self) -> [[f64; 4]; 3] {
        rows_of(&self.exact)
    }

    /// Whether the map turns left-handed frames into right-handed ones.
    pub fn swaps_handedness(&self) -> bool {
        self.exact.matrix3.determinant() < 0.0
    }

    /// Maps a point.
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        apply(&self.rows, p, 1.0)
    }

    /// Maps a direction or an offset between points.
    #[inline]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        apply(&self.rows, v, 0.0)
    }

    /// Maps a normal: by the transposed inverse, so that it stays perpendicular. Not renormalised.
    #[inline]
    pub fn normal(&self, n: Vec3) -> Vec3 {
        let m = &self.inverse_rows;
        Vec3::new(
            m[0][0] * n.x + m[1][0] * n.y + m[2][0] * n.z,
            m[0][1] * n.x + m[1][1] * n.y + m[2][1] * n.z,
            m[0][2] * n.x + m[1][2] * n.y + m[2][2] * n.z,
        )
    }

    /// Maps a point known to within `p_error`; returns the point and the absolute error bound of its coordinates.
    #[inline]
    pub fn point_with_error(&self, p: Vec3, p_error: Vec3) -> (Vec3, Vec3) {
        let error = |row: &[f32; 4]| {
            let abs = Vec3::new(row[0].abs(), row[1].abs(), row[2].abs());
            // The matrix itself was rounded once more than the three products and three sums that follow.
            (gamma(4) + 1.0) * abs.dot(p_error) + gamma(4) * (abs.dot(p.abs()) + row[3].abs())
        };
        (self.point(p), Vec3::new(error(&self.rows[0]), error(&self.rows[1]), error(&self.rows[2])))
    }

    /// Maps a ray; parameters keep their meaning, since the direction is not renormalised.
    #[inline]
    pub fn ray(&self, ray: &Ray) -> Ray {
        Ray { origin: self.point(ray.origin), direction: self.vector(ray.direction), ..*ray }
    }

    /// The box about the mapped box.
    pub fn bounds(&self, bounds: &Bounds3) -> Bounds3 {
        if bounds.is_empty() {
            return Bounds3::EMPTY;
        }
        Bounds3::from_points(bounds.corners().map(|corner| self.point(corner)))
    }
}

impl TryFrom<[[f64; 4]; 3]> for Transform {
    type Error = &'static str;

    fn try_from(rows: [[f64; 4]; 3]) -> Result<Self, Self::Error> {
        Self::from_rows(rows).ok_or("a singular or infinite matrix")
    }
}

impl From<Transform> for [[f64; 4]; 3] {
    fn from(transform: Transform) -> Self {
        transform.to_rows()
    }
}

pub(crate) fn rows_of(m: &DAffine3) -> [[f64; 4]; 3] {
    std::array::from_fn(|i| {
        let row = m.matrix3.row(i);
        [row.x, row.y, row.z, m.translation[i]]
    })
}

fn to_f32(m: &DAffine3) -> [[f32; 4]; 3] {
    rows_of(m).map(|row| row.map(|x| x as f32))
}

#[inline]
fn apply(rows: &[[f32; 4]; 3], v: Vec3, w: f32) -> Vec3 {
    let dot = |row: &[f32; 4]| row[0] * v.x + row[1] * v.y + row[2] * v.z + row[3] * w;
    Vec3::new(dot(&rows[0]), dot(&rows[1]), dot(&rows[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Transform {
        let rotated = Transform::rotate(0.7, [1.0, 2.0, -0.5]).unwrap();
        let scaled = Transform::scale(2.0, -0.5, 3.0).unwrap();
        Transform::translate(1.0, -2.0, 3.0).unwrap().after(&rotated.after(&scaled).unwrap()).unwrap()
    }

    #[test]
    fn the_inverse_undoes() {
        let (t, p) = (sample(), Vec3::new(0.3, -4.0, 2.0));
        assert!((t.inverse().point(t.point(p)) - p).length() < 1e-5);
        assert!(t.swaps_handedness());
    }

    #[test]
    fn normals_stay_perpendicular() {
        let (t, a, b) = (sample(), Vec3::new(1.0, 0.2, 0.0), Vec3::new(0.0, 1.0, -0.7));
        let n = t.normal(a.cross(b));
        assert!(n.dot(t.vector(a)).abs() < 1e-5 && n.dot(t.vector(b)).abs() < 1e-5);
    }

    #[test]
    fn look_at_puts_the_target_ahead() {
        let t = Transform::look_at([1.0, 2.0, 3.0], [1.0, 2.0, -4.0], [0.0, 1.0, 0.0]).unwrap();
        assert!((t.point(Vec3::new(1.0, 2.0, -4.0)) - Vec3::new(0.0, 0.0, 7.0)).length() < 1e-5);
        // Left-handed: looking along −z with y up, world +x is on the left.
        assert!((t.vector(Vec3::X) + Vec3::X).length() < 1e-6);
        assert_eq!(Transform::look_at([0.0; 3], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]), None);
    }

    #[test]
    fn singular_and_projective_matrices_are_refused() {
        assert_eq!(Transform::scale(1.0, 0.0, 1.0), None);
        assert_eq!(Transform::translate(f64::NAN, 0.0, 0.0), None);
        let mut columns = [0.0; 16];
        for i in 0..4 {
            columns[5 * i] = 2.0;
        }
        assert_eq!(Transform::from_columns(columns), Some(Transform::IDENTITY));
        columns[3] = 1.0;
        assert_eq!(Transform::from_columns(columns), None);
    }

    #[test]
    fn the_error_bound_holds_against_f64() {
        let t = sample();
        let rows = t.to_rows();
        for i in 0..1000 {
            let f = i as f32;
            let p = Vec3::new(f * 0.37 - 100.0, (f * 1.7).sin() * 1e3, 1.0 / (f + 0.1));
            let (mapped, error) = t.point_with_error(p, Vec3::ZERO);
            for axis in 0..3 {
                let row = rows[axis];
                let exact =
                    row[0] * f64::from(p.x) + row[1] * f64::from(p.y) + row[2] * f64::from(p.z) + row[3];
                assert!((f64::from(mapped[axis]) - exact).abs() <= f64::from(error[axis]));
            }
        }
    }
}
