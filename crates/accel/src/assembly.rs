//! The steps from a world to an acceleration structure.

use sahl_math::Bounds3;

use crate::accel::{Accel, Structure};
use crate::build::{self, BinaryTree, Reference};
use crate::filter::Filtered;
use crate::instance::PlacedGroup;
use crate::kernel::Machine;
use crate::layout::{self, WideTree, WideTrees};
use crate::options::{BuildOptions, Builder};
use crate::primitive::{Item, Primitives, TreeInput};
use crate::refit::Measures;
use crate::stats::Stats;
use crate::traverse::{ListTree, StackSize};
use crate::vertices::TriangleVertices;
use crate::world::World;

/// The cost of testing a primitive that is neither triangle nor instance against that of visiting a node.
pub(crate) const OTHER_COST: f32 = 2.0;

/// The steps of [`Accel::build`].
pub(crate) struct Assembly<'a> {
    world: World,
    options: &'a BuildOptions,
    primitives: Primitives,
    stats: Stats,
    /// Primitives of trees for which there was no room.
    unplaced: u64,
    measures: Measures,
}

impl<'a> Assembly<'a> {
    pub(crate) fn new(world: World, options: &'a BuildOptions) -> Self {
        let primitives = Primitives::for_geometries(&world.geometries);
        Self {
            world,
            options,
            primitives,
            stats: Stats::default(),
            unplaced: 0,
            measures: Measures::default(),
        }
    }

    pub(crate) fn finish(mut self) -> Accel {
        let (world, primitives) = (&self.world, &mut self.primitives);
        let groups: Vec<TreeInput> =
            world.groups.iter().map(|group| primitives.collect(world, group)).collect();
        let local_bounds: Vec<Bounds3> = groups.iter().map(TreeInput::total_bounds).collect();
        let placed: Vec<PlacedGroup> = (world.instances.iter().zip(0..))
            .map(|(instance, index)| {
                let local = local_bounds.get(instance.group as usize).copied().unwrap_or(Bounds3::EMPTY);
                PlacedGroup::new(index, instance, local)
            })
            .collect();
        let mut input = primitives.collect(world, &world.world);
        primitives.collect_instances(&placed, &mut input);
        let bounds = input.total_bounds();
        let references: usize = groups.iter().chain([&input]).map(|input| input.references.len()).sum();
        // A moving mesh is one reference to many triangles.
        let moving: usize = self.primitives.moving.iter().map(|mesh| mesh.count - 1).sum();
        self.stats.primitives = (references + moving) as u64;
        let structure = match self.options.builder {
            Builder::BruteForce => self.list_structure(&groups, &input),
            _ => self.wide_structure(groups, input, &placed),
        };
        let mut stats = self.stats;
        stats.dropped = self.primitives.dropped + self.unplaced;
        let motions = placed.iter().map(PlacedGroup::bytes).sum::<u64>();
        stats.bytes += self.primitives.bytes() + size_of_val(placed.as_slice()) as u64 + motions;
        let filtered = Filtered::new(&self.world.filtered, self.world.geometries.len(), |geometry| {
            self.primitives.ids(geometry)
        });
        let measures = Measures { built_cost: stats.sah_cost, group_bounds: local_bounds, ..self.measures };
        Accel {
            world: self.world,
            primitives: self.primitives,
            placed,
            structure,
            bounds,
            stats,
            filtered,
            options: *self.options,
            measures,
        }
    }

    fn list_structure(&mut self, groups: &[TreeInput], input: &TreeInput) -> Structure {
        let vertices = TriangleVertices { world: &self.world, primitives: &self.primitives };
        let list = |input: &TreeInput| {
            let items: Vec<Item> = input.references.iter().map(Reference::item).collect();
            ListTree::new(&items, &vertices)
        };
        let (groups, world): (Vec<_>, _) = (groups.iter().map(list).collect(), list(input));
        self.stats.bytes = groups.iter().chain([&world]).map(ListTree::bytes).sum();
        Structure::List { groups, world }
    }

    fn wide_structure(
        &mut self,
        groups: Vec<TreeInput>,
        input: TreeInput,
        placed: &[PlacedGroup],
    ) -> Structure {
        let mut trees = WideTrees::default();
        let moving = self.moving_trees();
        let cost_in_group = |item: Item| match item {
            Item::MovingMesh(place) => moving[place as usize],
            _ => OTHER_COST,
        };
        let built: Vec<(WideTree, f32)> =
            groups.into_iter().map(|group| self.wide_tree(&mut trees, group, &cost_in_group)).collect();
        // An instance costs its box test and what its group costs.
        let cost = |item: Item| match item {
            Item::Instance(place) | Item::MovingInstance(place) => {
                built.get(placed[place as usize].group as usize).map_or(1.0, |tree| 1.0 + tree.1)
            }
            other => cost_in_group(other),
        };
        let (world, sah_cost) = self.wide_tree(&mut trees, input, &cost);
        let (groups, group_costs): (Vec<WideTree>, Vec<f32>) = built.into_iter().unzip();
        (self.measures.group_costs, self.measures.moving_costs) = (group_costs, moving);
        let of_moving = || self.primitives.moving.iter().filter_map(|mesh| mesh.tree.as_ref());
        let moving_depths = of_moving().map(|moving| moving.tree.depth);
        let depth = groups.iter().map(|tree| tree.depth).chain(moving_depths).fold(world.depth, u32::max);
        self.stats.nodes = trees.nodes + of_moving().map(|moving| moving.trees().nodes).sum::<u64>();
        self.stats.leaves = trees.leaves + of_moving().map(|moving| moving.trees().leaves).sum::<u64>();
        self.stats.depth = depth;
        self.stats.sah_cost = sah_cost;
        self.stats.bytes = trees.bytes();
        let machine = (Machine::choose(self.options.tier), StackSize::for_depth(depth));
        Structure::Wide { trees, groups, world, machine }
    }

    /// Builds the trees of the moving meshes; returns their costs.
    fn moving_trees(&mut self) -> Vec<f32> {
        let mut costs = Vec::with_capacity(self.primitives.moving.len());
        for mesh in &mut self.primitives.moving {
            let (cost, unplaced) = mesh.build_tree(self.options);
            self.unplaced += unplaced;
            costs.push(1.0 + cost);
        }
        costs
    }

    /// Builds and appends one tree; returns it with its cost.
    fn wide_tree(
        &mut self,
        trees: &mut WideTrees,
        input: TreeInput,
        cost: &(impl Fn(Item) -> f32 + Sync),
    ) -> (WideTree, f32) {
        let vertices = TriangleVertices { world: &self.world, primitives: &self.primitives };
        let count = input.references.len() as u64;
        let nothing = (WideTree { root: None, end: 0, depth: 0 }, 0.0);
        let Some(mut tree) = build::build(input.references, input.extent, self.options, &vertices) else {
            return nothing;
        };
        let machine = Machine::choose(self.options.tier);
        let mut append = |tree: &mut BinaryTree| layout::append_tree(trees, tree, &vertices, cost, machine);
        let appended =
            append(&mut tree).or_else(|layout::TooLarge| append(&mut build::build_compact(&tree, &vertices)));
        appended.unwrap_or_else(|layout::TooLarge| {
            // All references are taken, by this tree or those before it.
            self.unplaced += count;
            nothing
        })
    }
}
