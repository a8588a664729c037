//! A moving mesh, prepared.

use sahl_math::{Bounds3, Vec3, gamma};

use super::{MovingTree, Weights};
use crate::geometry::double::DVec3;
use crate::geometry::triangle;
use crate::options::BuildOptions;
use crate::primitive::is_usable;
use crate::traverse::{Candidate, Counter, PreparedRay, Search};
use crate::world::MovingTriangleMesh;

/// A triangle at both ends of its motion.
pub(crate) type MovingTriangle = [[Vec3; 3]; 2];

/// The triangles of a moving mesh that can be hit.
#[derive(Clone, Debug)]
pub(crate) struct MovingMesh {
    pub(crate) geometry: u32,
    /// The id of the first triangle.
    pub(crate) first: u32,
    /// All triangles by their place in the mesh, `None` for those that were dropped; for the brute-force list, and empty for a tree.
    triangles: Vec<Option<MovingTriangle>>,
    /// How many can be hit.
    pub(crate) count: usize,
    pub(crate) tree: Option<MovingTree>,
    /// The box about the mesh at any time.
    pub(crate) bounds: Bounds3,
}

impl MovingMesh {
    /// Takes the triangles of a mesh that have a surface at some time; the first one has the id `first`, and `count` of them have one.
    pub(crate) fn new(geometry: u32, mesh: &MovingTriangleMesh, (first, count): (u32, usize)) -> Self {
        let triangles: Vec<Option<MovingTriangle>> =
            (0..count).map(|place| usable_triangle(mesh, place)).collect();
        let count = triangles.iter().flatten().count();
        let bounds = bounds_at_any_time(triangles.iter().flatten());
        Self { geometry, first, triangles, count, tree: None, bounds }
    }

    /// Puts a tree in the place of the list; returns the expected cost of a ray that meets the box, and how many triangles there was no
    /// room for.
    pub(crate) fn build_tree(&mut self, options: &BuildOptions) -> (f32, u64) {
        let triangles = std::mem::take(&mut self.triangles);
        match MovingTree::build(&triangles, self.first, options) {
            Some((tree, cost)) => {
                self.tree = Some(tree);
                (cost, 0)
            }
            None => (0.0, self.count as u64),
        }
    }

    /// Takes the triangles of the mesh as it is now; returns the expected cost of a ray that meets the box.
    pub(crate) fn refit(&mut self, mesh: &MovingTriangleMesh) -> f32 {
        let triangles = (0..mesh.indices.len()).filter_map(|place| usable_triangle(mesh, place));
        let triangles: Vec<MovingTriangle> = triangles.collect();
        self.count = triangles.len();
        self.bounds = bounds_at_any_time(triangles.iter());
        let first = self.first;
        self.tree.as_mut().map_or(0.0, |tree| tree.refit(|id| usable_triangle(mesh, (id - first) as usize)))
    }

    /// The ids of the triangles that were dropped.
    pub(crate) fn dropped(&self) -> impl Iterator<Item = u32> {
        (self.first..).zip(&self.triangles).filter(|(_, triangle)| triangle.is_none()).map(|(id, _)| id)
    }

    /// Offers all hits of the list; returns whether the search ended early.
    pub(crate) fn search<S: Search, C: Counter>(
        &self,
        ray: &PreparedRay,
        (search, counter): (&mut S, &mut C),
    ) -> bool {
        let weights = Weights::at(ray.ray().time);
        (self.first..).zip(&self.triangles).any(|(id, triangle)| {
            let Some(triangle) = triangle else { return false };
            counter.primitives(|| 1);
            let hit = triangle::intersect_sheared(&ray.ray(), &ray.shear(), weights.triangle(triangle));
            hit.is_some_and(|hit| {
                hit.t <= search.limit() && search.offer(Candidate { t: hit.t, id, weights: [hit.b1, hit.b2] })
            })
        })
    }

    /// The memory of the list and the tree in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        size_of_val(self.triangles.as_slice()) as u64 + self.tree.as_ref().map_or(0, MovingTree::bytes)
    }
}

/// A triangle of a moving mesh; `None` if it is not finite, or too far away, at one end of its motion, or has no surface at any time.
pub(crate) fn usable_triangle(mesh: &MovingTriangleMesh, place: usize) -> Option<MovingTriangle> {
    let triangle = mesh.ends(place)?;
    let usable = triangle.as_flattened().iter().all(|&vertex| is_usable(vertex));
    (usable && ever_has_area(&triangle)).then_some(triangle)
}

/// Whether a triangle has an area other than zero at some time: `e₁(t) × e₂(t)` is of second degree in `t`, and so vanishes always if it
/// does at three times.
fn ever_has_area([start, end]: &MovingTriangle) -> bool {
    let (start, end) = (start.map(DVec3::from), end.map(DVec3::from));
    [(1.0, 0.0), (0.5, 0.5), (0.0, 1.0)].into_iter().any(|(first, last)| {
        let [p0, p1, p2] = std::array::from_fn(|i| start[i] * first + end[i] * last);
        let n = (p1 - p0).cross(p2 - p0);
        n.x != 0.0 || n.y != 0.0 || n.z != 0.0
    })
}

/// The box about triangles at any time, with what the mixture of vertices, which takes three roundings, may stick out.
pub(crate) fn bounds_at_any_time<'a>(triangles: impl Iterator<Item = &'a MovingTriangle>) -> Bounds3 {
    let tight = Bounds3::from_points(triangles.flat_map(|triangle| triangle.as_flattened()).copied());
    if tight.is_empty() {
        return tight;
    }
    let slack = (tight.min.abs().max(tight.max.abs()) * gamma(3)).map(|x| x + f32::MIN_POSITIVE);
    Bounds3 { min: (tight.min - slack).map(f32::next_down), max: (tight.max + slack).map(f32::next_up) }
}
