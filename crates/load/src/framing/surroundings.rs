//! What lies around a point: the nearest surface in each of some hundred directions.

use sahl_math::Vec3;
use sahl_scene::SceneDesc;

use super::for_each_triangle;

/// Cells along the edge of each side of the cube of directions.
const SIDE: usize = 12;
/// A triangle seen smaller than a cell, as its longest edge over its distance, is put into the cell of its centre.
const SMALL: f32 = 0.12;
/// The most triangles that are tested against every direction: those seen largest.
const MOST_LARGE: usize = 512;

/// Larger meshes are thinned to about so many small triangles.
const MOST_SMALL: usize = 60_000;
/// Triangles with longer edges, in radii of the scene, are never left out: each may be a wall.
const WALL: f32 = 0.04;

/// The nearest surface in the direction of a cell.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    distance: f32,
    shows_front: bool,
}

/// The triangles of a scene, of small ones a sample: enough to know what is where.
pub(super) struct Soup {
    triangles: Vec<Piece>,
}

/// A triangle and a vector on its front side.
struct Piece {
    corners: [Vec3; 3],
    front: Vec3,
}

impl Soup {
    /// The triangles of a scene of the given radius.
    pub(super) fn new(scene: &SceneDesc, radius: f32) -> Self {
        let triangles: usize = scene.triangle_meshes.values().iter().map(|mesh| mesh.indices.len()).sum();
        let patches: usize = scene.patch_meshes.values().iter().map(|mesh| mesh.indices.len()).sum();
        let step = (triangles + 2 * patches).div_ceil(MOST_SMALL).max(1);
        let wall = (radius * WALL).powi(2);
        let mut soup = Self { triangles: Vec::new() };
        let mut count = 0;
        for_each_triangle(scene, |corners, normal| {
            count += 1;
            let [a, b, c] = corners;
            if count % step != 0 && longest_edge_squared(corners) < wall {
                return;
            }
            let geometric = (b - a).cross(c - a);
            if geometric != Vec3::ZERO {
                // As in the renderer, given normals decide which side is the front.
                let front = normal().map_or(geometric, |normal| geometric.face_forward(normal));
                soup.triangles.push(Piece { corners, front });
            }
        });
        soup
    }
}

fn longest_edge_squared([a, b, c]: [Vec3; 3]) -> f32 {
    (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared())
}

/// The nearest surfaces around a point, by cells on a cube about it.
///
/// An estimate: triangles that are seen smaller than a cell cover it, and of larger ones the largest are tested exactly.
pub(super) struct Surroundings {
    cells: Vec<Option<Nearest>>,
}

/// A triangle that is seen larger than a cell.
struct Large {
    corners: [Vec3; 3],
    shows_front: bool,
    /// Longest edge over distance.
    extent: f32,
}

impl Surroundings {
    /// What is seen from `eye`.
    pub(super) fn new(soup: &Soup, eye: Vec3) -> Self {
        let mut surroundings = Self { cells: vec![None; 6 * SIDE * SIDE] };
        let mut large = Vec::new();
        for piece in &soup.triangles {
            let corners = piece.corners.map(|corner| corner - eye);
            let shows_front = piece.front.dot(corners[0]) < 0.0;
            let middle = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
            let distance = middle.length();
            let edge = longest_edge_squared(corners).sqrt();
            if edge < SMALL * distance {
                surroundings.put(cell_of(middle), Nearest { distance, shows_front });
            } else {
                large.push(Large { corners, shows_front, extent: edge / distance });
            }
        }
        surroundings.put_large(large);
        surroundings
    }

    fn put(&mut self, cell: usize, nearest: Nearest) {
        let held = &mut self.cells[cell];
        if held.is_none_or(|held| nearest.distance < held.distance) {
            *held = Some(nearest);
        }
    }

    fn put_large(&mut self, mut large: Vec<Large>) {
        if large.len() > MOST_LARGE {
            large.select_nth_unstable_by(MOST_LARGE, |a, b| b.extent.total_cmp(&a.extent));
            large.truncate(MOST_LARGE);
        }
        let directions: Vec<Vec3> = (0..self.cells.len()).map(direction_of).collect();
        for triangle in large {
            let cone = Cone::new(triangle.corners);
            for (cell, &direction) in directions.iter().enumerate() {
                if let Some(distance) = cone.hit(direction) {
                    self.put(cell, Nearest { distance, shows_front: triangle.shows_front });
                }
            }
        }
    }

    /// Whether the point is inside a place: see the documentation of [`super`]. Surfaces nearer than `least` do not
    /// count: the centre of a flat mesh lies in the mesh.
    pub(super) fn is_enclosed(&self, least: f32) -> bool {
        let seen = self.cells.iter().flatten().filter(|nearest| nearest.distance >= least).count();
        let shows_front = |nearest: &&Nearest| nearest.distance >= least && nearest.shows_front;
        let fronts = self.cells.iter().flatten().filter(shows_front).count();
        3 * seen >= 2 * self.cells.len() && 4 * fronts >= 3 * seen
    }

    /// Distance of the nearest surface in about a direction: the median of the cells within 15° of it, `None` if most
    /// are open.
    pub(super) fn distance(&self, direction: Vec3) -> Option<f32> {
        let mut distances = self.distances_about(direction, 0.966);
        distances.sort_unstable_by(f32::total_cmp);
        distances.get(distances.len() / 2).copied().filter(|distance| distance.is_finite())
    }

    /// How far one sees within 30° of a direction, on average, where nothing counts for more than `most`.
    pub(super) fn view(&self, direction: Vec3, most: f32) -> f32 {
        let distances = self.distances_about(direction, 0.866);
        distances.iter().map(|distance| distance.min(most)).sum::<f32>() / distances.len().max(1) as f32
    }

    /// Distances of the cells whose directions have at least this cosine to `direction`; infinite where nothing is.
    fn distances_about(&self, direction: Vec3, cosine: f32) -> Vec<f32> {
        let near = |cell: &usize| direction_of(*cell).dot(direction) >= cosine;
        let distance = |cell: usize| self.cells[cell].map_or(f32::INFINITY, |nearest| nearest.distance);
        (0..self.cells.len()).filter(near).map(distance).collect()
    }
}

/// The cell that a direction points into.
fn cell_of(direction: Vec3) -> usize {
    let axis = direction.max_axis();
    let side = 2 * axis + usize::from(direction[axis] < 0.0);
    let along = direction[axis].abs();
    let column = |other: usize| {
        let position = direction[other] / along * 0.5 + 0.5;
        // Casts saturate, so that a direction on the border falls into the last cell.
        ((position * SIDE as f32) as usize).min(SIDE - 1)
    };
    (side * SIDE + column((axis + 1) % 3)) * SIDE + column((axis + 2) % 3)
}

/// The unit vector to the middle of a cell.
fn direction_of(cell: usize) -> Vec3 {
    let (side, first, second) = (cell / (SIDE * SIDE), cell / SIDE % SIDE, cell % SIDE);
    let axis = side / 2;
    let position = |column: usize| (column as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
    let mut direction = Vec3::ZERO;
    direction[axis] = if side % 2 == 0 { 1.0 } else { -1.0 };
    direction[(axis + 1) % 3] = position(first);
    direction[(axis + 2) % 3] = position(second);
    direction.normalize()
}

/// A triangle as seen from the origin.
struct Cone {
    /// Normals of the planes through the origin and the edges: a direction into the triangle is on one side of all.
    edges: [Vec3; 3],
    normal: Vec3,
    /// Distance of the triangle's plane times the length of its normal.
    offset: f32,
}

impl Cone {
    fn new([a, b, c]: [Vec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        Self { edges: [a.cross(b), b.cross(c), c.cross(a)], normal, offset: normal.dot(a) }
    }

    /// Where the ray from the origin along `direction` meets the triangle.
    fn hit(&self, direction: Vec3) -> Option<f32> {
        let [u, v, w] = self.edges.map(|edge| edge.dot(direction));
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let distance = self.offset / self.normal.dot(direction);
        // A comparison with NaN fails, as it has to.
        (inside && distance > 0.0).then_some(distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_directions_agree() {
        for cell in 0..6 * SIDE * SIDE {
            assert_eq!(cell_of(direction_of(cell)), cell);
        }
    }

    #[test]
    fn rays_meet_triangles_from_both_sides() {
        let corners = [Vec3::new(-1.0, -1.0, 2.0), Vec3::new(1.0, -1.0, 2.0), Vec3::new(0.0, 1.0, 2.0)];
        let turned = [corners[0], corners[2], corners[1]];
        assert_eq!(Cone::new(corners).hit(Vec3::Z), Some(2.0));
        assert_eq!(Cone::new(turned).hit(Vec3::Z), Some(2.0));
        assert_eq!(Cone::new(corners).hit(-Vec3::Z), None);
        assert_eq!(Cone::new(corners).hit(Vec3::X), None);
    }
}
