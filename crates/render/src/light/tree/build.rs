//! Building the tree: from the root, by the cheapest of a few splits along each axis.

use sahl_math::{Bounds3, Vec3};

use super::node::{Child, Link, MOST_LIGHTS, Node};
use super::{LightBounds, LightTree};

/// Centres are sorted into this many intervals along an axis.
const BUCKETS: usize = 12;

/// The depth of the lowest nodes: a trail has a bit for each turn and one to mark its end.
const MOST_DEPTH: u32 = 62;

type Item = (LightBounds, u32);

/// Makes the nodes and trails of a tree over `lights`.
pub(super) fn build(mut lights: Vec<Item>, tree: &mut LightTree) {
    // A scene holds fewer: its lights have numbers of 32 bits, and take a hundred bytes each.
    lights.truncate(MOST_LIGHTS);
    if let [(bounds, light)] = lights[..] {
        tree.trails[light as usize] = 0b10;
        tree.nodes.push(Node::new([Child::new(&bounds, Link::Light(light)), Child::nothing()]));
    } else if !lights.is_empty() {
        tree.nodes.reserve(lights.len() - 1);
        node(&mut lights, tree, Place { depth: 0, trail: 0 });
    }
}

/// Where in the tree a node is.
#[derive(Clone, Copy)]
struct Place {
    depth: u32,
    /// The turns that lead there.
    trail: u64,
}

impl Place {
    fn child(self, turn: u64) -> Self {
        Self { depth: self.depth + 1, trail: self.trail | turn << self.depth }
    }
}

/// Makes the node over two or more `lights` and those below it; returns its number and bounds.
fn node(lights: &mut [Item], tree: &mut LightTree, place: Place) -> (u32, LightBounds) {
    let number = tree.nodes.len();
    tree.nodes.push(Node::new([Child::nothing(); 2]));
    let middle = split(lights, place.depth);
    let (left, right) = lights.split_at_mut(middle);
    let (first, first_bounds) = child(left, tree, place.child(0));
    let (second, second_bounds) = child(right, tree, place.child(1));
    tree.nodes[number] = Node::new([Child::new(&first_bounds, first), Child::new(&second_bounds, second)]);
    (number as u32, first_bounds.union(&second_bounds))
}

fn child(lights: &mut [Item], tree: &mut LightTree, place: Place) -> (Link, LightBounds) {
    if let [(bounds, light)] = *lights {
        tree.trails[light as usize] = place.trail | 1 << place.depth;
        return (Link::Light(light), bounds);
    }
    let (number, bounds) = node(lights, tree, place);
    (Link::Node(number), bounds)
}

/// Puts `lights` in an order in which a first and a second group follow each other; returns where the second begins.
fn split(lights: &mut [Item], depth: u32) -> usize {
    let centers = lights.iter().map(|(bounds, _)| bounds.bounds.center());
    let centers = Bounds3::from_points(centers);
    let halvings = usize::BITS - lights.len().leading_zeros();
    if lights.len() > 2
        && depth + halvings < MOST_DEPTH
        && let Some(cut) = cheapest(lights, &centers)
    {
        let middle = partition(lights, |(bounds, _)| cut.bucket(bounds.bounds.center()) < cut.first);
        if middle > 0 && middle < lights.len() {
            return middle;
        }
    }
    // In halves along the longest axis; those in one place in the order of their numbers.
    let axis = centers.diagonal().max_axis();
    let middle = lights.len() / 2;
    lights.select_nth_unstable_by(middle, |(a, i), (b, j)| {
        a.bounds.center()[axis].total_cmp(&b.bounds.center()[axis]).then(i.cmp(j))
    });
    middle
}

/// A plane between two buckets.
#[derive(Clone, Copy)]
struct Cut {
    axis: usize,
    low: f32,
    /// Buckets a metre.
    scale: f32,
    /// The first bucket of the second group.
    first: usize,
}

impl Cut {
    fn bucket(&self, center: Vec3) -> usize {
        (((center[self.axis] - self.low) * self.scale) as usize).min(BUCKETS - 1)
    }
}

/// The cut with the lowest cost; `None` if all centres are in one place.
fn cheapest(lights: &[Item], centers: &Bounds3) -> Option<Cut> {
    let extent = centers.diagonal();
    let longest = extent[extent.max_axis()];
    let mut best: Option<(f32, Cut)> = None;
    for axis in 0..3 {
        if extent[axis] <= 0.0 {
            continue;
        }
        let mut cut = Cut { axis, low: centers.min[axis], scale: BUCKETS as f32 / extent[axis], first: 0 };
        let mut buckets: [Option<LightBounds>; BUCKETS] = [None; BUCKETS];
        for (bounds, _) in lights {
            let bucket = &mut buckets[cut.bucket(bounds.bounds.center())];
            *bucket = merged(*bucket, Some(*bounds));
        }
        // Costs of all second groups from behind, then of all first ones beside them.
        let mut behind = [0.0; BUCKETS];
        let mut group = None;
        for first in (1..BUCKETS).rev() {
            group = merged(group, buckets[first]);
            behind[first] = group.map_or(0.0, |group| group.cost());
        }
        let mut group = None;
        for first in 1..BUCKETS {
            group = merged(group, buckets[first - 1]);
            // Thin slices of a long group are no good: Conty Estevez and Kulla's regularisation.
            let cost = (group.map_or(0.0, |group| group.cost()) + behind[first]) * (longest / extent[axis]);
            if best.is_none_or(|(lowest, _)| cost < lowest) {
                cut.first = first;
                best = Some((cost, cut));
            }
        }
    }
    best.map(|(_, cut)| cut)
}

fn merged(a: Option<LightBounds>, b: Option<LightBounds>) -> Option<LightBounds> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.union(&b)),
        (a, b) => a.or(b),
    }
}

/// Moves what `is_first` to the front; returns how many that is.
fn partition<T>(items: &mut [T], is_first: impl Fn(&T) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        if is_first(&items[i]) {
            items.swap(count, i);
            count += 1;
        }
    }
    count
}
