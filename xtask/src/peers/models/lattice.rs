//! The surface of a cube of lattice points: a closed mesh with shared vertices, from which others are made by moving them.

use std::collections::HashMap;

use sahl_math::Vec3;

/// The surface of the cube from −1 to 1, each face `n × n` squares of two triangles that face outwards: `12 n²` triangles over
/// `6 n² + 2` vertices. `n` is at most 1 000.
pub(crate) fn cube(n: u16) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::with_capacity(6 * usize::from(n) * usize::from(n) + 2);
    let mut numbers: HashMap<[u16; 3], u32> = HashMap::with_capacity(positions.capacity());
    let mut vertex = |point: [u16; 3]| {
        *numbers.entry(point).or_insert_with(|| {
            positions.push(Vec3::from(point.map(|i| coordinate(f32::from(i), n))));
            positions.len() as u32 - 1
        })
    };
    let mut triangles = Vec::with_capacity(12 * usize::from(n) * usize::from(n));
    for axis in 0..3 {
        for (side, outwards) in [(0, false), (n, true)] {
            for i in 0..n {
                for j in 0..n {
                    let mut corner = |i: u16, j: u16| {
                        let mut point = [side; 3];
                        point[(axis + 1) % 3] = i;
                        point[(axis + 2) % 3] = j;
                        vertex(point)
                    };
                    let [a, b, c, d] =
                        [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                    triangles.extend(if outwards { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
                }
            }
        }
    }
    (positions, triangles)
}

/// The coordinate of place `i` along an axis of the lattice: −1 at 0, 1 at `n`.
fn coordinate(i: f32, n: u16) -> f32 {
    2.0 * i / f32::from(n) - 1.0
}

/// The point of the lattice, continued over all space, that is nearest.
pub(crate) fn nearest(p: Vec3, n: u16) -> Vec3 {
    p.map(|x| coordinate(((x + 1.0) * 0.5 * f32::from(n)).round(), n))
}

/// Where a point of the cube lies on the unit sphere, such that squares of the faces become cells of like size.
///
/// Source: the equiangular cubed sphere, Ronchi, Iacono, Paolucci, 1996.
pub(crate) fn on_sphere(p: Vec3) -> Vec3 {
    p.map(|x| (x * std::f32::consts::FRAC_PI_4).tan()).normalize()
}
