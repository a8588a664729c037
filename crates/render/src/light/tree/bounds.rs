//! What is known of a light or of a group of lights: where it is, where it shines, how strongly.

use std::f32::consts::{FRAC_PI_2, PI};

use sahl_math::{Bounds3, Vec3, safe_acos, safe_sqrt};

/// Bounds of one light or of several.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightBounds {
    /// A box about the points that emit.
    pub(crate) bounds: Bounds3,
    /// A cone about the directions that the surfaces face.
    pub(crate) facing: Cone,
    /// Cosine of the angle from such a direction beyond which nothing is emitted; at most π.
    pub(crate) cos_reach: f32,
    /// Whether surfaces emit to both sides.
    pub(crate) two_sided: bool,
    /// Radiant intensity in W/sr along the strongest direction, summed over the lights.
    pub(crate) intensity: f32,
}

/// A cone of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cone {
    /// Its unit axis.
    pub(crate) axis: Vec3,
    /// Cosine of its half angle; −1 for all directions.
    pub(crate) cos: f32,
}

impl LightBounds {
    /// A point that shines in all directions.
    pub(crate) fn point(position: Vec3, intensity: f32) -> Self {
        let facing = Cone { axis: Vec3::Z, cos: -1.0 };
        Self { bounds: Bounds3::from_points([position]), facing, cos_reach: 0.0, two_sided: false, intensity }
    }

    /// The bounds of both.
    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            facing: self.facing.union(&other.facing),
            cos_reach: self.cos_reach.min(other.cos_reach),
            two_sided: self.two_sided || other.two_sided,
            intensity: self.intensity + other.intensity,
        }
    }

    /// What the group costs in the choice of a split: intensity by extent by the solid angle it may shine into.
    ///
    /// Conty Estevez and Kulla, equations 1 and 2; the extent is that of the sphere, not the box, which vanishes for
    /// lights in a row.
    pub(super) fn cost(&self) -> f32 {
        let d = self.bounds.diagonal();
        self.intensity * d.length_squared() * self.directions()
    }

    /// M_Ω: the solid angle of directions at some angle to the cone, weighted by the cosine beyond it.
    fn directions(&self) -> f32 {
        let cos = self.facing.cos;
        if cos <= -1.0 {
            return 4.0 * PI;
        }
        let angle = safe_acos(cos);
        let widest = (angle + safe_acos(self.cos_reach)).min(PI);
        let sin = safe_sqrt(1.0 - cos * cos);
        2.0 * PI * (1.0 - cos)
            + FRAC_PI_2 * (2.0 * widest * sin - (angle - 2.0 * widest).cos() - 2.0 * angle * sin + cos)
    }
}

impl Cone {
    /// The cone of one direction.
    pub(crate) const fn of(axis: Vec3) -> Self {
        Self { axis, cos: 1.0 }
    }

    /// All directions.
    pub(crate) const ALL: Self = Self { axis: Vec3::Z, cos: -1.0 };

    /// A cone about unit vectors that lie within a right angle of their sum, else all directions.
    pub(crate) fn about(directions: &[Vec3]) -> Self {
        let sum = directions.iter().fold(Vec3::ZERO, |sum, &direction| sum + direction);
        let Some(axis) = sum.try_normalize() else { return Self::ALL };
        let cos = directions.iter().fold(1.0_f32, |cos, direction| cos.min(direction.dot(axis)));
        if cos > 0.0 { Self { axis, cos } } else { Self::ALL }
    }

    /// A cone that holds both, the smallest but for rounding.
    pub(super) fn union(&self, other: &Self) -> Self {
        let (wide, narrow) = if self.cos <= other.cos { (self, other) } else { (other, self) };
        if wide.cos <= -1.0 {
            return *wide;
        }
        let (sin_wide, sin_narrow) =
            (safe_sqrt(1.0 - wide.cos * wide.cos), safe_sqrt(1.0 - narrow.cos * narrow.cos));
        let between = wide.axis.dot(narrow.axis);
        // The cosine of the difference of the half angles: no need for the angles themselves.
        if between >= wide.cos * narrow.cos + sin_wide * sin_narrow {
            return *wide;
        }
        let angle_wide = safe_acos(wide.cos);
        let angle = 0.5 * (safe_acos(between) + angle_wide + safe_acos(narrow.cos));
        // The axis turns from that of the wide cone toward that of the narrow one.
        let toward = (narrow.axis - wide.axis * between).try_normalize();
        match toward {
            Some(toward) if angle < PI => {
                let (sin, cos) = (angle - angle_wide).sin_cos();
                let axis = (wide.axis * cos + toward * sin).try_normalize().unwrap_or(wide.axis);
                Self { axis, cos: angle.cos() }
            }
            _ => Self::ALL,
        }
    }
}
