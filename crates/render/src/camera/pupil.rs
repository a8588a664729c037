//! Where on the hindmost element of a lens light from a point of the film gets through.
//!
//! For rings of the film a box about that region is found in advance, so that samples are not spent on glass that the stop or a rim
//! hides. A box must hold the whole region, or the image loses light. A ring has all directions from the axis, and a stop that is not
//! round looks different from each: it counts as the disk about it.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 5.3.5. Deviation: pbrt-v4 tries a million random
//! points a ring, on a square three times as wide as the element. Here grids of a few thousand points are laid over that square and over
//! the surroundings of the region of the ring before, and once more over what they found; a small stop is not missed, and a start takes
//! a fraction of a second.

use std::ops::RangeInclusive;

use glam::DVec3;

use super::lens::{Stack, Way};

/// Rings of the film.
const RINGS: usize = 64;

/// Points of a grid across the axis in x; half as many cover one side of the axis in y, to which the region is symmetric.
const GRID: u32 = 96;

/// How far beyond the hindmost element its plane is searched, in radii: light that comes in at a slant meets its dome farther out.
const REACH: f64 = 1.5;

/// A box on the plane of the hindmost element; x along the line from the axis to the point of the film, symmetric in y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PupilBox {
    pub(super) x: [f64; 2],
    pub(super) y: f64,
}

/// The boxes of all rings.
#[derive(Clone, Debug)]
pub(super) struct Pupils {
    /// From the axis to the corner of the film; `None` where nothing gets through.
    rings: Box<[Option<PupilBox>]>,
    /// Rings a metre.
    per_length: f64,
}

impl PupilBox {
    /// The area.
    pub(super) fn area(&self) -> f64 {
        (self.x[1] - self.x[0]) * 2.0 * self.y
    }

    fn union(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        match (a, b) {
            (Some(a), Some(b)) => Some(Self { x: [a.x[0].min(b.x[0]), a.x[1].max(b.x[1])], y: a.y.max(b.y) }),
            (a, b) => a.or(b),
        }
    }

    /// Wider by so many cells of a grid over it.
    fn widened(&self, cells: f64) -> Self {
        let dx = cells * (self.x[1] - self.x[0]) / f64::from(GRID);
        let dy = cells * 2.0 * self.y / f64::from(GRID);
        Self { x: [self.x[0] - dx, self.x[1] + dx], y: self.y + dy }
    }

    /// The box about the points of a grid over this one through which light from the film point (`radius`, 0) gets, widened by the
    /// distance of two of them.
    fn search(&self, stack: &Stack, radius: f64) -> Option<Self> {
        let film = DVec3::new(radius, 0.0, 0.0);
        let (dx, dy) = ((self.x[1] - self.x[0]) / f64::from(GRID), 2.0 * self.y / f64::from(GRID));
        let mut found: Option<(RangeInclusive<u32>, u32)> = None;
        for j in 0..GRID / 2 {
            for i in 0..GRID {
                let x = self.x[0] + (f64::from(i) + 0.5) * dx;
                let rear = DVec3::new(x, f64::from(j) * dy, stack.rear_z());
                if stack.may_pass(Way { origin: film, direction: rear - film }) {
                    found = Some(match found {
                        Some((columns, _)) => ((*columns.start()).min(i)..=(*columns.end()).max(i), j),
                        None => (i..=i, j),
                    });
                }
            }
        }
        let (columns, row) = found?;
        let edge = |column: f64| self.x[0] + column * dx;
        Some(Self {
            x: [edge(f64::from(*columns.start()) - 0.5), edge(f64::from(*columns.end()) + 1.5)],
            y: (f64::from(row) + 1.0) * dy,
        })
    }
}

impl Pupils {
    /// The boxes for a film whose corners are at the distance `film_radius` from the axis.
    pub(super) fn new(stack: &Stack, film_radius: f64) -> Self {
        let reach = REACH * stack.rear_radius();
        let whole = PupilBox { x: [-reach, reach], y: reach };
        // On the axis the region is a disk about it, however small.
        let mut near = (0..12).find_map(|halvings| {
            let part = 0.5_f64.powi(halvings);
            PupilBox { x: [-reach * part, reach * part], y: reach * part }.search(stack, 0.0)
        });
        let mut edges = Vec::with_capacity(RINGS + 1);
        for ring in 0..=RINGS {
            let radius = film_radius * ring as f64 / RINGS as f64;
            let nearby = near.and_then(|near| near.widened(0.5 * f64::from(GRID)).search(stack, radius));
            let found = PupilBox::union(nearby, whole.search(stack, radius));
            let found = found.and_then(|found| found.search(stack, radius)).map(|found| found.widened(1.0));
            near = found.or(near);
            edges.push(found);
        }
        let rings = edges.windows(2).map(|edges| PupilBox::union(edges[0], edges[1])).collect();
        Self { rings, per_length: RINGS as f64 / film_radius }
    }

    /// The box for points at a distance from the axis.
    pub(super) fn at(&self, radius: f64) -> Option<&PupilBox> {
        let ring = ((radius * self.per_length) as usize).min(self.rings.len() - 1);
        self.rings[ring].as_ref()
    }
}
