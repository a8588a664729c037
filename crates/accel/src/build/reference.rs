//! The working copy of a primitive, and boxes in the form in which builders compute with them.

use sahl_math::{Bounds3, Vec3};

use crate::kernel::{Isa, Lanes, Row};
use crate::primitive::Item;

/// A box as eight lanes: the smallest x, y, z, then, from lane 4, the negated largest ones. The union of two is then a
/// single minimum. Lanes 3 and 7 are free.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub(crate) struct Box8(Row);

impl Box8 {
    /// The box about nothing: neutral for [`Self::union`]; its half area is infinite.
    pub(crate) const EMPTY: Self = Self(Row([f32::INFINITY; 8]));

    #[inline(always)]
    pub(crate) fn new(bounds: &Bounds3) -> Self {
        let (min, max) = (bounds.min, bounds.max);
        Self(Row([min.x, min.y, min.z, 0.0, -max.x, -max.y, -max.z, 0.0]))
    }

    #[inline(always)]
    pub(crate) fn bounds(&self) -> Bounds3 {
        let [x0, y0, z0, _, x1, y1, z1, _] = self.0.0;
        Bounds3 { min: Vec3::new(x0, y0, z0), max: Vec3::new(-x1, -y1, -z1) }
    }

    /// The box about both.
    #[inline(always)]
    pub(crate) fn union(self, other: Self) -> Self {
        let smaller = |a: f32, b: f32| if a < b { a } else { b };
        Self(Row(std::array::from_fn(|lane| smaller(self.0.0[lane], other.0.0[lane]))))
    }

    /// [`Self::union`] in code that is compiled for an instruction set.
    #[inline(always)]
    pub(crate) fn union_on<I: Isa>(&self, isa: I, other: &Self) -> Self {
        Self(Row(isa.load(&self.0).min(isa.load(&other.0)).to_array()))
    }

    /// Twice the middle of the box; lane 3 means nothing.
    #[inline(always)]
    pub(crate) fn doubled_center(&self) -> [f32; 4] {
        std::array::from_fn(|lane| self.0.0[lane] - self.0.0[lane + 4])
    }

    /// The box with all coordinates doubled.
    pub(crate) fn doubled(self) -> Self {
        Self(Row(self.0.0.map(|lane| 2.0 * lane)))
    }

    /// A box that holds one point.
    #[inline(always)]
    pub(crate) fn at(point: Vec3) -> Self {
        Self::point([point.x, point.y, point.z, 0.0])
    }

    /// The box about a triangle.
    #[inline(always)]
    pub(crate) fn around([a, b, c]: [Vec3; 3]) -> Self {
        Self::at(a).union(Self::at(b)).union(Self::at(c))
    }

    /// Whether no coordinate reaches beyond `limit`; NaN, which is in no box about points, counts as reaching beyond.
    #[inline(always)]
    pub(crate) fn is_within(&self, limit: f32) -> bool {
        self.0.0.iter().fold(true, |within, &lane| within & (lane >= -limit))
    }

    /// The part in both, with the free lanes of `other`.
    #[inline(always)]
    pub(crate) fn intersection(self, other: &Self) -> Self {
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let mut both = Self(Row(std::array::from_fn(|lane| larger(self.0.0[lane], other.0.0[lane]))));
        (both.0.0[3], both.0.0[7]) = (other.0.0[3], other.0.0[7]);
        both
    }

    /// [`Self::intersection`], but for the free lanes, in code that is compiled for an instruction set.
    #[inline(always)]
    pub(crate) fn intersection_on<I: Isa>(&self, isa: I, other: &Self) -> Self {
        Self(Row(isa.load(&self.0).max(isa.load(&other.0)).to_array()))
    }

    #[inline(always)]
    pub(crate) fn row(&self) -> &Row {
        &self.0
    }

    /// The box with its faces moved outwards by `distance` and a rounding.
    pub(crate) fn widened(self, distance: f32) -> Self {
        Self(Row(self.0.0.map(|lane| (lane - distance).next_down())))
    }

    /// The part below a plane.
    pub(crate) fn below(mut self, axis: usize, position: f32) -> Self {
        self.0.0[axis + 4] = self.0.0[axis + 4].max(-position);
        self
    }

    /// The part above a plane.
    pub(crate) fn above(mut self, axis: usize, position: f32) -> Self {
        self.0.0[axis] = self.0.0[axis].max(position);
        self
    }

    /// Whether the box holds no point.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        // Negated, so that NaN counts as empty.
        !(0..3).all(|axis| self.0.0[axis] <= -self.0.0[axis + 4])
    }

    #[inline(always)]
    pub(crate) fn from_row(row: Row) -> Self {
        Self(row)
    }

    /// The least coordinates; lane 3 means nothing.
    #[inline(always)]
    pub(crate) fn min(&self) -> [f32; 4] {
        let [x, y, z, w, ..] = self.0.0;
        [x, y, z, w]
    }

    /// A box that holds one point, with a fourth coordinate.
    #[inline(always)]
    pub(crate) fn point(point: [f32; 4]) -> Self {
        let [x, y, z, w] = point;
        Self(Row([x, y, z, w, -x, -y, -z, -w]))
    }

    /// The least and the largest coordinate on an axis.
    #[inline(always)]
    pub(crate) fn range(&self, axis: usize) -> [f32; 2] {
        [self.0.0[axis], -self.0.0[axis + 4]]
    }

    /// Edge lengths.
    #[inline(always)]
    pub(crate) fn diagonal(&self) -> [f32; 3] {
        std::array::from_fn(|axis| -(self.0.0[axis] + self.0.0[axis + 4]))
    }

    /// The axis of the longest edge; the first of equals.
    pub(crate) fn longest_axis(&self) -> usize {
        let [x, y, z] = self.diagonal();
        if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) }
    }

    /// Half the surface area; infinite for [`Self::EMPTY`].
    #[inline(always)]
    pub(crate) fn half_area(&self) -> f32 {
        // Both factors of each product have the same wrong sign.
        let [x0, y0, z0, _, x1, y1, z1, _] = self.0.0;
        let (x, y, z) = (x0 + x1, y0 + y1, z0 + z1);
        x * y + (y * z + z * x)
    }
}

/// A primitive, or a part of one, as the builders move it about: its box with what it is in the free lanes.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(crate) struct Reference(Box8);

impl Reference {
    #[inline(always)]
    pub(crate) fn new(bounds: &Bounds3, item: Item) -> Self {
        let (kind, place) = item.encode();
        let mut lanes = Box8::new(bounds);
        lanes.0.0[3] = f32::from_bits(place);
        lanes.0.0[7] = f32::from_bits(kind);
        Self(lanes)
    }

    /// The reference to a triangle with this box, whose free lanes are overwritten.
    #[inline(always)]
    pub(crate) fn triangle(mut bounds: Box8, id: u32) -> Self {
        (bounds.0.0[3], bounds.0.0[7]) = (f32::from_bits(id), f32::from_bits(0));
        Self(bounds)
    }

    /// The reference to a part whose box it is; the free lanes say what of.
    #[inline(always)]
    pub(crate) fn part(bounds: Box8) -> Self {
        Self(bounds)
    }

    /// The reference to `count` primitives that stand together, the first of them at place `first`.
    #[inline(always)]
    pub(crate) fn group(bounds: &Box8, first: usize, count: usize) -> Self {
        let mut lanes = *bounds;
        lanes.0.0[3] = f32::from_bits(first as u32);
        lanes.0.0[7] = f32::from_bits(count as u32);
        Self(lanes)
    }

    /// The places of what [`Self::group`] refers to.
    #[inline]
    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        let first = self.place() as usize;
        first..first + self.0.0.0[7].to_bits() as usize
    }

    /// Stands for a primitive that is left out; neutral in an [`Extent`].
    pub(crate) const NONE: Self = Self(Box8::EMPTY);

    /// A triangle.
    #[inline(always)]
    pub(crate) fn around(vertices: [Vec3; 3], item: Item) -> Self {
        Self::new(&Bounds3::from_points(vertices), item)
    }

    #[inline(always)]
    pub(crate) fn into_row(self) -> Row {
        self.0.0
    }

    #[inline]
    pub(crate) fn is_none(&self) -> bool {
        self.0.0.0[0] == f32::INFINITY
    }

    /// The box; its free lanes mean nothing.
    #[inline(always)]
    pub(crate) fn bounds(&self) -> &Box8 {
        &self.0
    }

    #[inline(always)]
    pub(crate) fn doubled_center(&self) -> [f32; 4] {
        self.0.doubled_center()
    }

    /// The doubled middle as a box about this point; its free lanes mean nothing.
    #[inline(always)]
    pub(crate) fn doubled_center_on<I: Isa>(&self, isa: I) -> I::F32 {
        let lanes = isa.load(self.0.row());
        lanes - isa.swap_halves(lanes)
    }

    #[inline(always)]
    pub(crate) fn doubled_center_at(&self, axis: usize) -> f32 {
        self.0.0.0[axis] - self.0.0.0[axis + 4]
    }

    #[inline(always)]
    pub(crate) fn is_triangle(&self) -> bool {
        self.0.0.0[7].to_bits() == 0
    }

    /// The id of a triangle, or the place of another primitive.
    #[inline(always)]
    pub(crate) fn place(&self) -> u32 {
        self.0.0.0[3].to_bits()
    }

    pub(crate) fn item(&self) -> Item {
        Item::decode(self.0.0.0[7].to_bits(), self.place())
    }

    /// Orders references: triangles first, then by place.
    #[inline]
    pub(crate) fn key(&self) -> (u32, u32) {
        (self.0.0.0[7].to_bits(), self.place())
    }
}

/// The boxes about a range of references and about their doubled middles; the latter may be larger than need be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) bounds: Box8,
    pub(crate) centers: Box8,
}

impl Extent {
    pub(crate) const EMPTY: Self = Self { bounds: Box8::EMPTY, centers: Box8::EMPTY };

    /// The extent of a range of which only the box is known: the centres may be anywhere in it.
    pub(crate) fn around(bounds: Box8) -> Self {
        Self { bounds, centers: bounds.doubled() }
    }

    #[inline(always)]
    pub(crate) fn including(self, reference: &Reference) -> Self {
        Self {
            bounds: self.bounds.union(*reference.bounds()),
            // In this order NaN, the middle of no box, is not taken.
            centers: Box8::point(reference.doubled_center()).union(self.centers),
        }
    }

    #[inline(always)]
    pub(crate) fn union(self, other: Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), centers: self.centers.union(other.centers) }
    }

    pub(crate) fn of(references: &[Reference]) -> Self {
        references.iter().fold(Self::EMPTY, Self::including)
    }
}
