//! Brute force: every primitive, by the scalar kernels, without a box test. The oracle.

use sahl_math::Vec3;

use super::{Candidate, Counter, PreparedRay, Search, offer_crossings};
use crate::geometry::triangle;
use crate::instance::PlacedGroup;
use crate::layout::Vertices;
use crate::primitive::{Item, Primitives};

/// What stands in the place of a tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct ListTree {
    entries: Vec<Entry>,
}

#[derive(Clone, Debug)]
enum Entry {
    Triangle { vertices: [Vec3; 3], id: u32 },
    Other(Item),
}

impl ListTree {
    pub(crate) fn new(items: &[Item], vertices: &impl Vertices) -> Self {
        let entry = |item: &Item| match *item {
            Item::Triangle(id) => Entry::Triangle { vertices: vertices.triangle(id), id },
            other => Entry::Other(other),
        };
        Self { entries: items.iter().map(entry).collect() }
    }

    /// The memory of the entries in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        size_of_val(self.entries.as_slice()) as u64
    }
}

/// What the search reads.
#[derive(Clone, Copy)]
pub(crate) struct List<'a> {
    pub(crate) primitives: &'a Primitives,
    pub(crate) placed: &'a [PlacedGroup],
    pub(crate) groups: &'a [ListTree],
}

impl List<'_> {
    /// Offers all hits of a list; returns whether the search ended early.
    pub(crate) fn search<S: Search, C: Counter>(
        self,
        tree: &ListTree,
        ray: &PreparedRay,
        (search, counter): (&mut S, &mut C),
    ) -> bool {
        tree.entries.iter().any(|entry| {
            match entry {
                Entry::Other(Item::MovingMesh(place)) => {
                    let mesh = &self.primitives.moving[*place as usize];
                    return mesh.search(ray, (&mut *search, &mut *counter));
                }
                Entry::Other(Item::Instance(place) | Item::MovingInstance(place)) => {
                    return self.search_instance(*place, ray, (&mut *search, &mut *counter));
                }
                _ => counter.primitives(|| 1),
            }
            // A ray meets a triangle once, and other primitives perhaps again further on.
            if let Entry::Triangle { vertices, id } = entry {
                let hit = triangle::intersect_sheared(&ray.ray(), &ray.shear(), *vertices);
                return hit.is_some_and(|hit| {
                    let candidate = Candidate { t: hit.t, id: *id, weights: [hit.b1, hit.b2] };
                    hit.t <= search.limit() && search.offer(candidate)
                });
            }
            offer_crossings(search, ray, |ray, limit| match entry {
                Entry::Other(Item::Patch(place)) => self.primitives.patch_candidate(*place, ray),
                Entry::Other(Item::Quadric(place)) => self.primitives.quadric_candidate(*place, ray),
                Entry::Other(Item::Curve(place)) => self.primitives.curve_candidate(*place, ray, limit),
                _ => None,
            })
        })
    }

    fn search_instance<S: Search, C: Counter>(
        self,
        place: u32,
        ray: &PreparedRay,
        (search, counter): (&mut S, &mut C),
    ) -> bool {
        let placed = &self.placed[place as usize];
        let Some(tree) = self.groups.get(placed.group as usize) else { return false };
        let Some(local) = PreparedRay::new(&placed.local_ray_at_time(&ray.ray())) else { return false };
        search.enter_instance(placed.instance);
        let ended = self.search(tree, &local, (&mut *search, &mut *counter));
        search.enter_instance(u32::MAX);
        ended
    }
}
