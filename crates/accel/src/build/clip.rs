//! Cutting a triangle's box in two.

use sahl_math::Vec3;

use super::reference::Box8;

/// How much wider than computed the box about a part of a triangle is made, relative to the largest extent of the triangle.
///
/// The watertight test shears vertices, and a sheared coordinate is off by up to 7 ε m, ε being the unit roundoff and m the vertex's largest
/// coordinate relative to the ray's origin. The widened exit of boxes covers what is relative to the distance of the hit; the
/// rest, relative to how far beyond the part the triangle reaches, is covered here: 16 ε of its extent.
const WIDENING: f32 = 8.0 * f32::EPSILON;

/// The boxes about the parts of a triangle below and above the plane at `position` on `axis`, as far as they lie in `within`; `None`
/// for a part that is empty.
///
/// They are rounded outwards, so that a ray that hits the triangle in `within` meets one of them.
pub(super) fn parts(triangle: &[Vec3; 3], within: &Box8, axis: usize, position: f32) -> [Option<Box8>; 2] {
    let mut sides = [Box8::EMPTY; 2];
    let mut whole = Box8::EMPTY;
    for (i, &from) in triangle.iter().enumerate() {
        let to = triangle[(i + 1) % 3];
        let point = Box8::at(from);
        whole = whole.union(point);
        if from[axis] <= position {
            sides[0] = sides[0].union(point);
        }
        if from[axis] >= position {
            sides[1] = sides[1].union(point);
        }
        if (from[axis] < position) != (to[axis] < position) && from[axis] != position && to[axis] != position
        {
            let crossing = Box8::at(crossing(from, to, axis, position));
            sides = sides.map(|side| side.union(crossing));
        }
    }
    let [x, y, z] = whole.diagonal();
    let widening = x.max(y).max(z) * WIDENING;
    sides
        .map(|side| side.widened(widening).intersection(within))
        .map(|side| (!side.is_empty()).then_some(side))
}

/// Where an edge crosses a plane, each coordinate within a rounding of `f32`.
fn crossing(from: Vec3, to: Vec3, axis: usize, position: f32) -> Vec3 {
    let share = (f64::from(position) - f64::from(from[axis])) / (f64::from(to[axis]) - f64::from(from[axis]));
    let mut point = from.zip(to, |a, b| (f64::from(a) + (f64::from(b) - f64::from(a)) * share) as f32);
    point[axis] = position;
    point
}
