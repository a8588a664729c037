//! The tree of a moving mesh.

use sahl_math::{Bounds3, Vec3};

use super::Weights;
use super::mesh::MovingTriangle;
use crate::build::{self, Extent, Reference};
use crate::kernel::{BLOCK_ROWS, Isa, Machine, NODE_ROWS, Row, RowsView};
use crate::layout::{self, Child, MovedLeaf, MovedPrimitives, WideTree, WideTrees};
use crate::options::BuildOptions;
use crate::primitive::Item;

/// Two copies of the same nodes and blocks: when the shutter opens and when it closes.
#[derive(Clone, Debug)]
pub(crate) struct MovingTree {
    ends: [WideTrees; 2],
    pub(crate) tree: WideTree,
}

impl MovingTree {
    /// Builds over the triangles as they lie half of the time, and puts them where they are at both ends. The ids begin at `first`.
    /// Returns the tree with its expected cost; `None` if nothing can be hit, or there is no room.
    pub(super) fn build(
        triangles: &[Option<MovingTriangle>],
        first: u32,
        options: &BuildOptions,
    ) -> Option<(Self, f32)> {
        let halfway = |triangle: &MovingTriangle| Weights::at(0.5).triangle(triangle);
        let reference = |(id, triangle): (u32, &Option<MovingTriangle>)| {
            Some(Reference::around(halfway(triangle.as_ref()?), Item::Triangle(id)))
        };
        let references: Vec<Reference> = (first..).zip(triangles).filter_map(reference).collect();
        let extent = Extent::of(&references);
        let mut tree = build::build_uncut(references, extent, options)?;
        let triangle = |id: u32| triangles.get((id - first) as usize).copied().flatten();
        let vertices = |id: u32| triangle(id).as_ref().map_or([Vec3::splat(f32::NAN); 3], halfway);
        let mut trees = WideTrees::default();
        let machine = Machine::choose(options.tier);
        let (tree, _) = layout::append_tree(&mut trees, &mut tree, &vertices, &|_| 1.0, machine).ok()?;
        let mut moving = Self { ends: [trees.clone(), trees], tree };
        let cost = moving.refit(triangle);
        Some((moving, cost))
    }

    /// Puts the triangles, by their ids, where they are now at both ends; returns the mean of the expected costs there.
    pub(crate) fn refit(&mut self, triangle: impl Fn(u32) -> Option<MovingTriangle> + Sync) -> f32 {
        let costs = [0, 1].map(|end| {
            let moved = AtEnd(|id| triangle(id).map(|ends| ends[end]));
            self.ends[end].refit(&self.tree, &moved).cost
        });
        costs.iter().sum::<f32>() * 0.5
    }

    pub(crate) fn trees(&self) -> &WideTrees {
        &self.ends[0]
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.ends.iter().map(WideTrees::bytes).sum()
    }

    /// The nodes and blocks as they are at a time.
    #[inline(always)]
    pub(super) fn at(&self, time: f32) -> RowsAtTime<'_> {
        let [open, close] = &self.ends;
        RowsAtTime { open: open.view(), close: close.view(), weights: Weights::at(time) }
    }
}

/// Nodes and blocks at a time.
#[derive(Clone, Copy)]
pub(super) struct RowsAtTime<'a> {
    open: RowsView<'a>,
    close: RowsView<'a>,
    weights: Weights,
}

impl RowsAtTime<'_> {
    /// The node to whose first row this refers.
    #[inline(always)]
    pub(super) fn node<I: Isa>(self, isa: I, reference: u32) -> [Row; NODE_ROWS] {
        self.weights.rows(isa, self.open.node(reference).0, self.close.node(reference).0)
    }

    /// The block to whose first row this refers.
    #[inline(always)]
    pub(super) fn block<I: Isa>(self, isa: I, reference: u32) -> [Row; BLOCK_ROWS] {
        self.weights.rows(isa, self.open.block(reference).0, self.close.block(reference).0)
    }
}

/// The triangles at one end of their motion.
struct AtEnd<F>(F);

impl<F: Fn(u32) -> Option<[Vec3; 3]> + Sync> MovedPrimitives for AtEnd<F> {
    /// Finite, so that mixing it with itself by a weight of zero does not give NaN.
    const NOTHING: Bounds3 = Bounds3 { min: Vec3::splat(f32::MAX), max: Vec3::splat(f32::MIN) };

    fn triangle(&self, id: u32) -> Option<[Vec3; 3]> {
        self.0(id)
    }

    fn other(&self, child: Child) -> MovedLeaf {
        // There are none.
        MovedLeaf { child, bounds: Self::NOTHING, cost: 0.0 }
    }
}
