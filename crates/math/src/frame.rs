//! Orthonormal frames.

use crate::Vec3;

/// A right-handed orthonormal basis with the normal along z: the space in which scattering is described.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent, a unit vector.
    pub x: Vec3,
    /// Second tangent, a unit vector, `z × x`.
    pub y: Vec3,
    /// Normal, a unit vector.
    pub z: Vec3,
}

impl Frame {
    /// The frame about the unit vector `z` whose tangents depend on `z` alone.
    ///
    /// Source: Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 6(1), 2017.
    #[inline]
    pub fn from_z(z: Vec3) -> Self {
        let sign = 1.0_f32.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Self {
            x: Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: Vec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// The frame about the unit vector `z` whose x lies in the plane of `z` and `tangent`.
    ///
    /// Where `tangent` is parallel to `z` or zero, the tangents are those of [`Frame::from_z`].
    #[inline]
    pub fn from_z_and_tangent(z: Vec3, tangent: Vec3) -> Self {
        match (tangent - z * z.dot(tangent)).try_normalize() {
            Some(x) if x.dot(z).abs() < 1e-3 => Self { x, y: z.cross(x), z },
            _ => Self::from_z(z),
        }
    }

    /// From world space to this frame.
    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// From this frame to world space.
    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_orthonormal(frame: &Frame) {
        for (a, b, expected) in [
            (frame.x, frame.x, 1.0),
            (frame.y, frame.y, 1.0),
            (frame.z, frame.z, 1.0),
            (frame.x, frame.y, 0.0),
            (frame.y, frame.z, 0.0),
            (frame.z, frame.x, 0.0),
        ] {
            assert!((a.dot(b) - expected).abs() < 1e-6, "{frame:?}");
        }
        assert!((frame.x.cross(frame.y) - frame.z).length() < 1e-6, "{frame:?}");
    }

    #[test]
    fn frames_are_orthonormal_and_invert() {
        for z in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(0.3, -0.4, -0.866), Vec3::new(1e-4, 0.0, -1.0)] {
            let z = z.normalize();
            for frame in [
                Frame::from_z(z),
                Frame::from_z_and_tangent(z, Vec3::new(0.2, 0.9, 0.1)),
                Frame::from_z_and_tangent(z, z),
                Frame::from_z_and_tangent(z, Vec3::ZERO),
            ] {
                assert_orthonormal(&frame);
                let v = Vec3::new(0.1, 0.7, -0.2);
                assert!((frame.to_world(frame.to_local(v)) - v).length() < 1e-6);
            }
        }
    }
}
