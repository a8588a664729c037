//! Nodes of the tree, and the estimate of what a group of lights contributes.

use sahl_math::{Vec3, safe_sqrt};

use super::LightBounds;
use crate::light::select::{Facing, Vantage};

/// The bounds of two groups of lights, and where they lead: one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    children: [Child; 2],
}

/// A group of lights.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Child {
    /// A sphere about the points that emit.
    center: Vec3,
    radius: f32,
    /// Radiant intensity, see [`LightBounds`].
    intensity: f32,
    /// Axis of the cone of directions that surfaces face, on the octahedron.
    axis: [i16; 2],
    /// Cosine of the half angle of that cone, rounded down.
    cos_facing: i16,
    /// Cosine of the angle from it beyond which nothing is emitted, rounded down.
    cos_reach: i16,
    /// [`IS_LIGHT`], [`IS_TWO_SIDED`], and the number of a light or of a node.
    link: u32,
}

/// Where a child leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    /// To a light of the scene.
    Light(u32),
    /// To a node of the tree.
    Node(u32),
}

const IS_LIGHT: u32 = 1 << 31;
const IS_TWO_SIDED: u32 = 1 << 30;

/// The first number that a link can't hold.
pub(super) const MOST_LIGHTS: usize = IS_TWO_SIDED as usize;

/// What a stored cosine or coordinate of one is.
const UNIT: f32 = i16::MAX as f32;

/// A stored axis is off by less than this many steps of a cosine.
const AXIS_STEPS: f32 = 4.0;

/// The cosine of the smallest reach: the border of a beam without one is given some width.
const SHARPEST: f32 = 0.99;

/// Estimates end here, so that their sum is finite.
const LARGEST: f32 = 0.25 * f32::MAX;

impl Node {
    pub(super) const fn new(children: [Child; 2]) -> Self {
        Self { children }
    }

    /// Where the first or the second child leads.
    #[inline]
    pub(super) fn link(&self, turn: usize) -> Link {
        let link = self.children[turn].link;
        let number = link & !(IS_LIGHT | IS_TWO_SIDED);
        if link & IS_LIGHT != 0 { Link::Light(number) } else { Link::Node(number) }
    }

    /// An estimate of what arrives at `from` from both children.
    #[inline]
    pub(super) fn contribution(&self, from: &Vantage) -> f32 {
        let [first, second] = &self.children;
        first.contribution(from) + second.contribution(from)
    }

    /// The first child's share of what arrives at `from`; `None` if nothing can.
    #[inline]
    pub(super) fn first_share(&self, from: &Vantage) -> Option<f32> {
        let [first, second] = &self.children;
        let (first, second) = (first.contribution(from), second.contribution(from));
        let sum = first + second;
        (sum > 0.0).then(|| first / sum)
    }
}

impl Child {
    /// The group with the given bounds, which leads to `link`.
    pub(super) fn new(bounds: &LightBounds, link: Link) -> Self {
        let (center, radius) = bounds.bounds.bounding_sphere().unwrap_or((Vec3::ZERO, 0.0));
        let (flag, number) = match link {
            Link::Light(light) => (IS_LIGHT, light),
            Link::Node(node) => (0, node),
        };
        let rounded_down = |cos: f32, steps: f32| (cos * UNIT - steps).floor().max(-UNIT) as i16;
        Self {
            center,
            // The centre is rounded, and so is the distance to it.
            radius: radius + (radius + center.abs().max_component()) * f32::EPSILON,
            intensity: bounds.intensity,
            axis: octahedral(bounds.facing.axis),
            cos_facing: rounded_down(bounds.facing.cos, AXIS_STEPS),
            cos_reach: rounded_down(bounds.cos_reach.min(SHARPEST), 0.0),
            link: number | flag | if bounds.two_sided { IS_TWO_SIDED } else { 0 },
        }
    }

    /// A group of nothing.
    pub(super) const fn nothing() -> Self {
        Self {
            center: Vec3::ZERO,
            radius: 0.0,
            intensity: 0.0,
            axis: [0; 2],
            cos_facing: -i16::MAX,
            cos_reach: 0,
            link: IS_LIGHT,
        }
    }

    /// An estimate of the irradiance at `from`: the intensity over the squared distance, by the cosines of the smallest
    /// angles that are possible at both ends. Zero only if nothing can arrive.
    ///
    /// Pharr, Jakob, Humphreys 2023, equation 12.1 and what follows.
    #[inline]
    pub(super) fn contribution(&self, from: &Vantage) -> f32 {
        let to_group = self.center - from.p;
        let (d2, r2) = (to_group.length_squared(), self.radius * self.radius);
        if d2 <= r2 {
            // Amid the group all angles are possible.
            return (self.intensity / r2.max(f32::MIN_POSITIVE)).min(LARGEST);
        }
        let distance = d2.sqrt();
        let wi = to_group / distance;
        // The angle under which the sphere appears, from its centre to its border.
        let sphere = Angle { sin: self.radius / distance, cos: safe_sqrt(1.0 - r2 / d2) };

        // The smallest angle between a direction that a surface faces and a way to the point.
        let emitted = self.axis().dot(-wi);
        let off_axis = Angle::of(if self.link & IS_TWO_SIDED != 0 { emitted.abs() } else { emitted });
        let off_cone = off_axis.minus(Angle::of(f32::from(self.cos_facing) / UNIT)).minus(sphere);
        // What is emitted falls to zero at the reach: as the cosine for surfaces, and nearly so in the borders of spots.
        let cos_reach = f32::from(self.cos_reach) / UNIT;
        let excess = off_cone.cos - cos_reach;
        if excess <= 0.0 {
            return 0.0;
        }

        // The smallest angle between the surface's normal and a way to the group.
        let received = match from.facing {
            Facing::All => 1.0,
            Facing::Side(n) => Angle::of(n.dot(wi)).minus(sphere).cos,
            Facing::Sides(n) => Angle::of(n.dot(wi).abs()).minus(sphere).cos,
        };
        (self.intensity * excess * received / (d2 * (1.0 - cos_reach))).clamp(0.0, LARGEST)
    }

    #[inline]
    fn axis(&self) -> Vec3 {
        let [x, y] = self.axis.map(|x| f32::from(x) / UNIT);
        let z = 1.0 - x.abs() - y.abs();
        // The lower half is folded over the edges of the square.
        let fold = (-z).max(0.0);
        let v = Vec3::new(x - fold.copysign(x), y - fold.copysign(y), z);
        v / v.length()
    }
}

/// An angle between 0 and π.
#[derive(Clone, Copy, Debug)]
struct Angle {
    sin: f32,
    cos: f32,
}

impl Angle {
    #[inline]
    fn of(cos: f32) -> Self {
        Self { sin: safe_sqrt(1.0 - cos * cos), cos }
    }

    /// This angle less `other`, at least zero.
    #[inline]
    fn minus(self, other: Self) -> Self {
        if self.cos >= other.cos {
            return Self { sin: 0.0, cos: 1.0 };
        }
        Self {
            sin: self.sin * other.cos - self.cos * other.sin,
            cos: self.cos * other.cos + self.sin * other.sin,
        }
    }
}

/// A unit vector on the octahedron |x| + |y| + |z| = 1, unfolded to a square.
fn octahedral(v: Vec3) -> [i16; 2] {
    let sum = v.x.abs() + v.y.abs() + v.z.abs();
    let (x, y) = (v.x / sum, v.y / sum);
    let folded = |a: f32, b: f32| (1.0 - b.abs()).copysign(a);
    let (x, y) = if v.z < 0.0 { (folded(x, y), folded(y, x)) } else { (x, y) };
    [x, y].map(|x| (x * UNIT).round() as i16)
}
