//! From a pixel beyond the edges of a face to the face that it lies on.
//!
//! The edges of a face go around it: along v = 0, u = 1, v = 1 and u = 0. A place near one is told by how far along it lies and how far
//! beyond. The face on the other side goes along the same edge the other way.

use sahl_math::Vec2;
use sahl_scene::{Face, Neighbor};

use super::pyramid::Pyramid;

/// A walk around a corner crosses two edges, and one more between two parts of a face.
const MOST_STEPS: usize = 3;

/// A place on a face or, before a walk, beyond its edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) face: u32,
    pub(super) uv: Vec2,
    /// The logarithm to base two of the pixels that a face has where the place comes from, in this face's coordinates and units.
    pub(super) grid: [i32; 2],
}

impl Place {
    /// The centre of a pixel of a face that has `2^log2` along each axis.
    pub(super) fn of_tap(face: u32, [i, j]: [i32; 2], log2: [u32; 2]) -> Self {
        let center = |i: i32, log: u32| (i as f32 + 0.5) / (1_u32 << log) as f32;
        let uv = Vec2::new(center(i, log2[0]), center(j, log2[1]));
        Self { face, uv, grid: log2.map(|log| log as i32) }
    }

    /// The edges beyond which the place lies: v = 0 or 1, and u = 0 or 1.
    fn beyond(&self) -> [Option<usize>; 2] {
        let outside = |x: f32, low: usize, high: usize| match x {
            x if x < 0.0 => Some(low),
            x if x > 1.0 => Some(high),
            _ => None,
        };
        [outside(self.uv.y, 0, 2), outside(self.uv.x, 3, 1)]
    }

    /// How far along an edge and how far beyond it.
    fn along(&self, edge: usize) -> [f32; 2] {
        let Vec2 { x: u, y: v } = self.uv;
        match edge {
            0 => [u, -v],
            1 => [v, u - 1.0],
            2 => [1.0 - u, v - 1.0],
            _ => [1.0 - v, -u],
        }
    }

    /// The same place in the coordinates of the face beyond an edge.
    fn across(&self, edge: usize, from: &Face, neighbor: Neighbor, to: &Face) -> Self {
        let [along, beyond] = self.along(edge);
        // A part of a face is half as long as its neighbour, which names the part at the start of its edge.
        let is_first = to.neighbors[usize::from(neighbor.edge)].is_some_and(|back| back.face == self.face);
        let (along, beyond, finer) = match (from.is_part, to.is_part) {
            (false, true) => (1.0 - 2.0 * along, 2.0 * beyond, -1),
            (true, false) if is_first => (0.5 - 0.5 * along, 0.5 * beyond, 1),
            (true, false) => (1.0 - 0.5 * along, 0.5 * beyond, 1),
            _ => (1.0 - along, beyond, 0),
        };
        let (u, v) = match neighbor.edge {
            0 => (along, beyond),
            1 => (1.0 - beyond, along),
            2 => (1.0 - along, 1.0 - beyond),
            _ => (beyond, 1.0 - along),
        };
        let [a, b] = self.grid.map(|log| log + finer);
        let is_turned = (edge + usize::from(neighbor.edge)) % 2 == 1;
        Self { face: neighbor.face, uv: Vec2::new(u, v), grid: if is_turned { [b, a] } else { [a, b] } }
    }
}

impl Pyramid {
    /// Where a place that may lie beyond the edges of its face is; `None` if that is nowhere in particular.
    #[inline]
    pub(super) fn place(&self, place: Place) -> Option<Place> {
        match place.beyond() {
            [None, None] => Some(place),
            edges => self.place_beyond(place, edges),
        }
    }

    fn place_beyond(&self, mut place: Place, edges: [Option<usize>; 2]) -> Option<Place> {
        let [v_edge, u_edge] =
            edges.map(|edge| edge.filter(|&edge| self.neighbor(place.face, edge).is_some()));
        // What lies beyond a border is as the border is.
        if u_edge.is_none() {
            place.uv.x = place.uv.x.clamp(0.0, 1.0);
        }
        if v_edge.is_none() {
            place.uv.y = place.uv.y.clamp(0.0, 1.0);
        }
        match (u_edge, v_edge) {
            (None, None) => Some(place),
            (Some(edge), None) | (None, Some(edge)) => self.walk(place, edge),
            (Some(u_edge), Some(v_edge)) => {
                // Where four faces meet, both ways around the corner lead to the same.
                let [one, other] = [self.walk(place, u_edge)?, self.walk(place, v_edge)?];
                (one.face == other.face).then_some(one)
            }
        }
    }

    /// Crosses an edge, and others as long as the place lies beyond one.
    fn walk(&self, mut place: Place, mut edge: usize) -> Option<Place> {
        for _ in 0..MOST_STEPS {
            let neighbor = self.neighbor(place.face, edge)?;
            let (from, to) = (self.face(place.face)?, self.face(neighbor.face)?);
            place = place.across(edge, from, neighbor, to);
            match place.beyond() {
                [None, None] => return Some(place),
                [Some(next), _] | [None, Some(next)] => edge = next,
            }
        }
        None
    }

    fn neighbor(&self, face: u32, edge: usize) -> Option<Neighbor> {
        self.face(face)?.neighbors.get(edge).copied().flatten()
    }
}
