//! Splits of space: planes that cut triangles in two.
//!
//! Where two sides of the best object split overlap much, a plane is looked for that cuts what lies on both sides. Only triangles
//! that are large against the whole are cut, which are few: they alone are binned by where they begin and end and clipped, all others by
//! their centres.
//!
//! Source: Stich, Friedrich, Dietrich, *Spatial Splits in Bounding Volume Hierarchies*, High Performance Graphics 2009. Deviations: the
//! restriction to large triangles, and to ranges where the cut of the two sides' overlap would be worth it.

use rayon::prelude::*;

use super::binning::{Binning, ObjectSplit};
use super::bins::{Bins, MAX_BINS, Plane};
use super::clip;
use super::cut_bins::{AxisBins, Fill, Side, SpatialSplit};
use super::mapping::Mapping;
use super::nodes::NodeLists;
use super::reference::{Box8, Extent, Reference};
use super::sah::{split_in_the_middle, split_small};
use super::split::{Halves, Range, Splitter, build_nodes};
use super::sweep;
use crate::layout::Vertices;

/// When and how much to cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cutting {
    /// The most parts that are added, relative to the number of triangles.
    share: f32,
    /// The box of a triangle that may be cut has at least this share of the area of the box about all.
    divisible: f32,
    /// The overlap of two sides that may be worth a cut has at least this share of that area.
    overlap: f32,
    /// The sides lose at least this share of their area by cutting their overlap in the middle.
    gain: f32,
}

impl Cutting {
    /// Nothing is cut.
    pub(super) const NONE: Self =
        Self { share: 0.0, divisible: f32::INFINITY, overlap: f32::INFINITY, gain: 1.0 };
    /// Costs nothing where triangles are even, and a tenth of the time where they are not.
    pub(super) const DEFAULT: Self = Self { share: 0.2, divisible: 1e-4, overlap: 3e-4, gain: 0.03 };
    /// What is worth it where time does not count.
    pub(super) const HIGH: Self = Self { share: 0.3, divisible: 1e-5, overlap: 1e-5, gain: 0.02 };
}

/// Builds by SAH with spatial splits; returns the nodes, and what the leaves' ranges are of.
pub(super) fn build(
    references: Vec<Reference>,
    extent: Extent,
    binning: Binning,
    cutting: Cutting,
    vertices: &impl Vertices,
) -> (NodeLists, Vec<Reference>) {
    let root_area = extent.bounds.half_area();
    let count = references.len();
    let mut slots = references;
    let divisible = gather_divisible(&mut slots, cutting.divisible * root_area);
    let free = (count as f32 * cutting.share) as usize;
    slots.resize(count + free.min(MAX_PARTS * divisible), Reference::NONE);
    let splitter = SpatialSah { binning, cutting, vertices, min_overlap: cutting.overlap * root_area };
    let nodes = build_nodes(Range { slots: &mut slots, count, divisible, extent }, &splitter);
    (nodes, slots)
}

/// The most parts a divisible triangle is cut into on average.
const MAX_PARTS: usize = 16;

/// Moves the triangles with at least this area to the front; returns how many these are.
fn gather_divisible(references: &mut [Reference], area: f32) -> usize {
    let chunks = references.par_chunks(GATHER_CHUNK).enumerate();
    let places: Vec<usize> = chunks
        .flat_map_iter(|(chunk, references)| {
            let is_divisible = |one: &Reference| one.bounds().half_area() >= area && one.is_triangle();
            let found = references.iter().enumerate().filter(move |(_, one)| is_divisible(one));
            found.map(move |(place, _)| chunk * GATHER_CHUNK + place)
        })
        .collect();
    for (divisible, &place) in places.iter().enumerate() {
        references.swap(place, divisible);
    }
    places.len()
}

/// How many references one task looks at.
const GATHER_CHUNK: usize = 1 << 13;

struct SpatialSah<'a, V> {
    binning: Binning,
    cutting: Cutting,
    vertices: &'a V,
    min_overlap: f32,
}

impl<V: Vertices> Splitter for SpatialSah<'_, V> {
    fn split(&self, range: &mut Range<'_>) -> Option<Halves> {
        if range.count <= sweep::MAX_COUNT {
            return split_small(&self.binning, range);
        }
        let Some(object) = self.binning.find(range) else {
            return Some(split_in_the_middle(range));
        };
        // Halves are large: combinators would copy them at each step.
        let mut halves = None;
        if range.divisible > 0 && self.is_promising(&object) {
            halves = self.cut_range(range, &object);
        }
        if halves.is_none() {
            halves = self.binning.make(range, &object);
        }
        if halves.is_none() {
            halves = Some(split_in_the_middle(range));
        }
        halves
    }
}

impl<V: Vertices> SpatialSah<'_, V> {
    /// Makes the best split of space, if there is one that costs less than the object split.
    #[inline(never)]
    fn cut_range(&self, range: &mut Range<'_>, object: &ObjectSplit) -> Option<Halves> {
        let best = self.best_split(range, object)?;
        if best.cost < object.cost() { self.apply(range, &best) } else { None }
    }

    /// Whether the sides of an object split overlap so much that a cut may pay.
    fn is_promising(&self, object: &ObjectSplit) -> bool {
        let (axis, [left, right]) = (object.axis(), object.bounds);
        let overlap = left.intersection(&right);
        if overlap.is_empty() || overlap.half_area() < self.min_overlap {
            return false;
        }
        let [low, high] = overlap.range(axis);
        let middle = 0.5 * low + 0.5 * high;
        let whole = left.half_area() + right.half_area();
        let cut = left.below(axis, middle).half_area() + right.above(axis, middle).half_area();
        whole - cut > self.cutting.gain * whole
    }

    /// The best plane on the longest axis; `None` if costs do not tell.
    ///
    /// That on the axis of the object split costs as much time again, for 0.2 % to 0.7 % of the expected cost of rays.
    fn best_split(&self, range: &Range<'_>, object: &ObjectSplit) -> Option<SpatialSplit> {
        let mapping = Mapping::new(&range.extent.bounds, MAX_BINS);
        let others = object.sample.filter(|_| self.binning.has_all_bins()).unwrap_or_else(|| {
            let mut others = Bins::EMPTY;
            // The centres of all others lie within the bounds, doubled.
            self.binning.fill_others(range, &mapping.doubled(), &mut others);
            others
        });
        let axis = range.extent.bounds.longest_axis();
        let mut bins = AxisBins::of_whole(&others, axis);
        let references = &range.slots[..range.divisible];
        let fill = Fill { references, mapping: &mapping, axis, vertices: self.vertices, bins: &mut bins };
        self.binning.machine.run(fill);
        let split = bins.best_split(mapping, axis);
        (split.cost > 0.0 && split.cost < f32::INFINITY).then_some(split)
    }

    /// Reorders the range that the split was found for; `None` if nothing is left on one side, and then nothing was cut either.
    fn apply(&self, range: &mut Range<'_>, split: &SpatialSplit) -> Option<Halves> {
        let SpatialSplit { mapping, axis, bin, .. } = *split;
        let plane = Plane { cost: split.cost, axis, bin: bin as u32 - 1 };
        let (divisible, count) = (range.divisible, range.count);
        let others = &mut range.slots[divisible..count];
        let other_count = others.len();
        let parted = self.binning.part(others, &mapping.doubled(), plane);
        let mut extents = parted.boxes.map(Extent::around);
        let mut unsplitter = Unsplitter { sides: split.sides };
        let (mut left_count, mut end) = (0, count);
        for place in 0..divisible {
            let mut reference = range.slots[place];
            let [below, above] = self.cut(&reference, split);
            let verdict = match (below, above) {
                (Some(below), Some(above)) => {
                    unsplitter.decide(&reference, [below, above], end < range.slots.len())
                }
                (Some(_), None) => Verdict::Left,
                _ => Verdict::Right,
            };
            if let Verdict::Both([below, above]) = verdict {
                let above = Reference::part(above);
                extents[1] = extents[1].including(&above);
                range.slots[end] = above;
                end += 1;
                reference = Reference::part(below);
            }
            if matches!(verdict, Verdict::Right) {
                extents[1] = extents[1].including(&reference);
            } else {
                extents[0] = extents[0].including(&reference);
                range.slots[place] = range.slots[left_count];
                range.slots[left_count] = reference;
                left_count += 1;
            }
        }
        let halves = Halves {
            divisible: [left_count, divisible - left_count],
            others: [parted.left_count, other_count - parted.left_count],
            added: end - count,
            extents,
        };
        (!halves.counts().contains(&0)).then_some(halves)
    }

    /// The parts of a reference on both sides of the plane.
    fn cut(&self, reference: &Reference, split: &SpatialSplit) -> [Option<Box8>; 2] {
        let &SpatialSplit { mapping, axis, bin, .. } = split;
        let whole = *reference.bounds();
        let [first, last] = whole.range(axis).map(|position| mapping.bin(position, axis));
        if last < bin {
            [Some(whole), None]
        } else if first >= bin {
            [None, Some(whole)]
        } else {
            let triangle = self.vertices.triangle(reference.place());
            clip::parts(&triangle, &whole, axis, mapping.position(bin, axis))
        }
    }
}

/// What becomes of a reference.
enum Verdict {
    Left,
    Right,
    Both([Box8; 2]),
}

/// Decides whether a reference that lies on both sides of a plane is cut, or had better stay whole on one of them.
struct Unsplitter {
    sides: [Side; 2],
}

impl Unsplitter {
    fn decide(&mut self, reference: &Reference, parts: [Box8; 2], there_is_room: bool) -> Verdict {
        let [left, right] = self.sides;
        let grown = self.sides.map(|side| side.bounds.union(*reference.bounds()));
        let cost = |bounds: &Box8, count: f32| bounds.half_area() * count;
        let [left_count, right_count] = [left.count as f32, right.count as f32];
        let only_left = cost(&grown[0], left_count) + cost(&right.bounds, right_count - 1.0);
        let only_right = cost(&left.bounds, left_count - 1.0) + cost(&grown[1], right_count);
        let both = cost(&left.bounds, left_count) + cost(&right.bounds, right_count);
        if there_is_room && both <= only_left && both <= only_right {
            Verdict::Both(parts)
        } else if only_left <= only_right {
            self.sides[0].bounds = grown[0];
            self.sides[1].count = right.count.saturating_sub(1);
            Verdict::Left
        } else {
            self.sides[1].bounds = grown[1];
            self.sides[0].count = left.count.saturating_sub(1);
            Verdict::Right
        }
    }
}
