use sahl_math::{Bounds3, Vec3};

use super::*;
use crate::kernel::Tier;
use crate::primitive::Item;

fn boxes(centers: &[Vec3], half: f32) -> Vec<Bounds3> {
    centers.iter().map(|&c| Bounds3 { min: c - Vec3::splat(half), max: c + Vec3::splat(half) }).collect()
}

fn triangles(bounds: &[Bounds3]) -> Vec<Reference> {
    bounds.iter().zip(0..).map(|(bounds, id)| Reference::new(bounds, Item::Triangle(id))).collect()
}

fn scattered(count: usize) -> Vec<Vec3> {
    let mut state = 5_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    (0..count).map(|_| Vec3::new(next(), next() * 0.3, next() * 5.0)).collect()
}

fn options(builder: Builder) -> BuildOptions {
    BuildOptions { builder, ..BuildOptions::default() }
}

/// Those whose leaves hold primitives.
const TREES: [Builder; 3] = [Builder::Median, Builder::BinnedSah, Builder::HighQuality];

/// Triangles that fill their boxes.
struct Diagonals<'a>(&'a [Bounds3]);

impl Vertices for Diagonals<'_> {
    fn triangle(&self, id: u32) -> [Vec3; 3] {
        let Bounds3 { min, max } = self.0[id as usize];
        [min, max, Vec3::new(max.x, min.y, min.z)]
    }
}

fn tree_of(input: &[Reference], options: &BuildOptions, vertices: &impl Vertices) -> BinaryTree {
    build(input.to_vec(), Extent::of(input), options, vertices).expect("there are primitives")
}

/// What a leaf holds.
fn in_leaf(tree: &BinaryTree, leaf: &BinaryNode) -> Vec<Reference> {
    assert!(!tree.is_of_groups());
    let references = tree.spare[leaf.range()].iter().map(|&row| Reference::part(Box8::from_row(row)));
    let references: Vec<Reference> = references.collect();
    let items = tree.primitives[leaf.range()].iter().map(|key| key.item());
    assert!(references.iter().map(Reference::item).eq(items));
    references
}

/// What the leaves hold, from left to right.
fn in_leaves(tree: &BinaryTree) -> impl Iterator<Item = Reference> {
    let leaves = tree.nodes.iter().filter(|node| node.is_leaf());
    leaves.flat_map(|leaf| in_leaf(tree, leaf))
}

/// Checks the shape of a tree and returns its depth.
fn check(tree: &BinaryTree, input: &[Reference]) -> u32 {
    let mut missing: Vec<_> = input.iter().map(Reference::key).collect();
    missing.sort_unstable();
    let mut found = Vec::new();
    let mut pending = vec![(0_u32, 0_u32)];
    let (mut deepest, mut visited) = (0, 0);
    while let Some((place, depth)) = pending.pop() {
        deepest = deepest.max(depth);
        visited += 1;
        let node = &tree.nodes[place as usize];
        if node.is_leaf() {
            let references = in_leaf(tree, node);
            assert!(references.len() <= MAX_LEAF);
            assert!(references.len() == 1 || references.iter().all(Reference::is_triangle));
            let total = references.iter().fold(Box8::EMPTY, |all, one| all.union(*one.bounds()));
            assert_eq!(total.bounds(), node.bounds);
            found.extend(references.iter().map(Reference::key));
        } else {
            let children = node.children(place);
            let [left, right] = children.map(|child| tree.nodes[child as usize].bounds);
            assert_eq!(left.union(right), node.bounds);
            pending.extend(children.map(|child| (child, depth + 1)));
        }
    }
    found.sort_unstable();
    found.dedup();
    assert!(found == missing, "the tree holds something else than it was built over");
    assert_eq!(visited, tree.nodes.len(), "a node hangs nowhere");
    assert!(deepest <= MAX_DEPTH, "{deepest}");
    deepest
}

fn built(builder: Builder, bounds: &[Bounds3]) -> BinaryTree {
    tree_of(&triangles(bounds), &options(builder), &Diagonals(bounds))
}

fn depth(builder: Builder, bounds: &[Bounds3]) -> u32 {
    check(&built(builder, bounds), &triangles(bounds))
}

#[test]
fn trees_hold_everything_once_in_tight_boxes() {
    for count in (1..40).chain([63, 64, 65, 100, 5000]) {
        let bounds = boxes(&scattered(count), 0.01);
        for builder in TREES {
            assert!(depth(builder, &bounds) < 30);
        }
    }
    assert!(build(Vec::new(), Extent::EMPTY, &options(Builder::BinnedSah), &Diagonals(&[])).is_none());
}

#[test]
fn primitives_at_one_place_are_halved() {
    let bounds = boxes(&[Vec3::splat(0.25); 5000], 0.5);
    for builder in TREES {
        let depth = depth(builder, &bounds);
        assert!((9..=13).contains(&depth), "{builder:?}: {depth}");
    }
}

#[test]
fn the_depth_is_bounded_where_each_split_takes_one_off() {
    // Distances that grow by powers: the heuristic cuts the farthest off, again and again.
    let centers: Vec<Vec3> = (0..400).map(|i| Vec3::X * 1.15_f32.powi(i)).collect();
    let bounds: Vec<Bounds3> =
        centers.iter().map(|&c| Bounds3 { min: c * 0.99, max: c * 1.01 + Vec3::splat(1e-9) }).collect();
    for builder in TREES {
        depth(builder, &bounds);
    }
    let few_bins = BuildOptions { bins: 2, ..BuildOptions::default() };
    check(&tree_of(&triangles(&bounds), &few_bins, &Diagonals(&bounds)), &triangles(&bounds));
}

#[test]
fn extreme_extents_end_in_balanced_trees() {
    let centers: Vec<Vec3> = scattered(300).into_iter().map(|p| p * 1e17).collect();
    let line: Vec<Vec3> = centers.iter().map(|c| Vec3::new(c.x, 0.0, 0.0)).collect();
    for builder in TREES {
        for bounds in [boxes(&centers, 1e18), boxes(&centers, 0.0), boxes(&line, 0.0), boxes(&line, 1e-30)] {
            assert!(depth(builder, &bounds) < 20);
        }
    }
}

#[test]
fn leaves_hold_one_kind() {
    let bounds = boxes(&scattered(700), 0.05);
    let item = |i: u32| match i % 6 {
        0 => Item::Patch(i),
        1 => Item::Quadric(i),
        2 => Item::Instance(i),
        3 => Item::Curve(i),
        _ => Item::Triangle(i),
    };
    let input: Vec<Reference> =
        bounds.iter().zip(0..).map(|(bounds, i)| Reference::new(bounds, item(i))).collect();
    for builder in TREES {
        let tree = tree_of(&input, &options(builder), &Diagonals(&bounds));
        check(&tree, &input);
        let mut items: Vec<u32> = in_leaves(&tree).map(|one| one.place()).collect();
        assert!(in_leaves(&tree).all(|one| one.item() == item(one.place())));
        items.sort_unstable();
        items.dedup();
        assert!(items.into_iter().eq(0..700));
    }
}

#[test]
fn the_tree_depends_on_neither_threads_nor_instruction_set() {
    let mut bounds = boxes(&scattered(100_000), 0.001);
    bounds.extend(boxes(&scattered(2000), 0.1));
    for builder in TREES {
        let tree_by = |threads, tier| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let options = BuildOptions { tier: Some(tier), ..options(builder) };
            let tree = pool.install(|| tree_of(&triangles(&bounds), &options, &Diagonals(&bounds)));
            let order: Vec<_> = in_leaves(&tree).map(|one| one.key()).collect();
            (tree, order)
        };
        let first = tree_by(1, Tier::Scalar);
        check(&first.0, &triangles(&bounds));
        let tiers = Tier::ALL.into_iter().filter(|tier| tier.is_available()).map(|tier| (1, tier));
        for (threads, tier) in tiers.chain([(2, Tier::detect()), (5, Tier::detect())]) {
            let other = tree_by(threads, tier);
            assert!(first.0.nodes == other.0.nodes && first.1 == other.1, "{builder:?} {threads} {tier:?}");
        }
    }
}

#[test]
fn the_heuristic_pays_off_on_uneven_sizes() {
    // Many small things in a corner of a place with a few large ones.
    let mut centers = scattered(3000);
    centers.extend(scattered(200).into_iter().map(|p| Vec3::new(p.x, p.y / 0.3, p.z / 5.0) * 100.0));
    let bounds: Vec<Bounds3> = (centers.iter().enumerate())
        .map(|(i, &c)| {
            let half = Vec3::splat(if i < 3000 { 0.02 } else { 3.0 });
            Bounds3 { min: c - half, max: c + half }
        })
        .collect();
    let cost =
        |builder| built(builder, &bounds).nodes.iter().map(|node| node.bounds.half_area()).sum::<f32>();
    let (median, sah) = (cost(Builder::Median), cost(Builder::BinnedSah));
    assert!(sah < 0.8 * median, "SAH {sah}, median {median}");
}

/// Small triangles with a few large and long ones through them.
fn uneven_soup() -> Vec<[Vec3; 3]> {
    let centers = scattered(6000);
    let triangle = |(i, c): (usize, &[Vec3])| {
        let size = if i % 100 == 0 { 1.0 } else { 0.01 };
        let middle = Vec3::new(0.5, 0.15, 2.5);
        [0, 1, 2].map(|k| c[0] + (c[k] - middle) * size)
    };
    centers.chunks_exact(3).enumerate().map(triangle).collect()
}

/// A point of a triangle by two of its barycentric weights.
fn point_of(triangle: [Vec3; 3], u: f64, v: f64) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let [a, b, c] = triangle.map(|vertex| f64::from(vertex[axis]));
        a + (b - a) * u + (c - a) * v
    })
}

/// Whether a box contains a point, but for the rounding of the point itself.
fn contains(bounds: &Bounds3, point: [f64; 3]) -> bool {
    (0..3).all(|axis| {
        let range = f64::from(bounds.min[axis]) - 1e-14..=f64::from(bounds.max[axis]) + 1e-14;
        range.contains(&point[axis])
    })
}

#[test]
fn the_parts_of_cut_triangles_cover_them() {
    let soup = uneven_soup();
    let bounds: Vec<Bounds3> = soup.iter().map(|triangle| Bounds3::from_points(*triangle)).collect();
    let input = triangles(&bounds);
    for builder in [Builder::BinnedSah, Builder::HighQuality] {
        let tree = tree_of(&input, &options(builder), &|id: u32| soup[id as usize]);
        check(&tree, &input);
        let mut parts = vec![Vec::new(); soup.len()];
        for reference in in_leaves(&tree) {
            parts[reference.place() as usize].push(reference.bounds().bounds());
        }
        let added: usize = parts.iter().map(|parts| parts.len() - 1).sum();
        assert!((20..soup.len() / 2).contains(&added), "{builder:?} {added} parts");
        for (triangle, parts) in soup.iter().zip(&parts) {
            let [a, b, c] = *triangle;
            for i in 0..=12 {
                for j in 0..=12 - i {
                    let point = point_of([a, b, c], f64::from(i) / 12.0, f64::from(j) / 12.0);
                    assert!(parts.iter().any(|part| contains(part, point)), "{builder:?} {point:?}");
                }
            }
        }
    }
}

#[test]
fn compact_trees_have_full_leaves_of_whole_triangles() {
    let soup = uneven_soup();
    let bounds: Vec<Bounds3> = soup.iter().map(|triangle| Bounds3::from_points(*triangle)).collect();
    let input = triangles(&bounds);
    let tree = tree_of(&input, &options(Builder::HighQuality), &|id: u32| soup[id as usize]);
    assert!(in_leaves(&tree).count() > soup.len());
    let compact = build_compact(&tree, &|id: u32| soup[id as usize]);
    check(&compact, &input);
    assert_eq!(in_leaves(&compact).count(), soup.len());
    let leaves = compact.nodes.iter().filter(|node| node.is_leaf()).count();
    assert!(leaves * MAX_LEAF <= 2 * soup.len(), "{leaves} leaves");
    for reference in in_leaves(&compact) {
        let (whole, tight) = (reference.bounds().bounds(), bounds[reference.place() as usize]);
        assert_eq!(whole.union(tight), whole);
    }
}

/// Checks the shape of a tree of groups; returns what it holds in the order of the leaves.
fn check_groups(tree: &BinaryTree, input: &[Reference]) -> Vec<Item> {
    assert!(tree.is_of_groups());
    let mut items = Vec::new();
    let bounds_of = |item: Item| input.iter().find(|one| one.item() == item).map(|one| *one.bounds());
    let mut pending = vec![(0_u32, 0_u32)];
    while let Some((place, depth)) = pending.pop() {
        assert!(depth <= MAX_DEPTH);
        let node = &tree.nodes[place as usize];
        if !node.is_leaf() {
            let [left, right] = node.children(place);
            pending.extend([(right, depth + 1), (left, depth + 1)]);
            continue;
        }
        let groups = &tree.groups[node.range()];
        assert!(groups.len() <= crate::kernel::WIDTH);
        let all = groups.iter().fold(Box8::EMPTY, |all, one| all.union(*one.bounds()));
        assert_eq!(all.bounds(), node.bounds);
        for group in groups {
            let held: Vec<Item> = tree.primitives[group.range()].iter().map(|key| key.item()).collect();
            assert!((1..=MAX_LEAF).contains(&held.len()));
            assert!(held.len() == 1 || held.iter().all(|item| matches!(item, Item::Triangle(_))));
            let tight = held.iter().filter_map(|&item| bounds_of(item)).fold(Box8::EMPTY, Box8::union);
            assert_eq!(tight.bounds(), group.bounds().bounds());
            items.extend(held);
        }
    }
    items
}

#[test]
fn fast_trees_hold_everything_once_in_groups_of_one_kind() {
    let item = |i: u32| if i.is_multiple_of(11) { Item::Quadric(i) } else { Item::Triangle(i) };
    for count in [1, 2, 8, 9, 64, 65, 3000] {
        let bounds = boxes(&scattered(count), 0.01);
        let input: Vec<Reference> =
            bounds.iter().zip(0..).map(|(bounds, i)| Reference::new(bounds, item(i))).collect();
        let tree = tree_of(&input, &options(Builder::Fast), &Diagonals(&bounds));
        let mut places: Vec<u32> =
            check_groups(&tree, &input).into_iter().map(|item| item.encode().1).collect();
        places.sort_unstable();
        assert!(places.into_iter().eq(0..count as u32));
        let compact = build_compact(&tree, &Diagonals(&bounds));
        assert_eq!(in_leaves(&compact).count(), count);
    }
    let at_one_place = boxes(&[Vec3::splat(0.25); 5000], 0.5);
    let input = triangles(&at_one_place);
    check_groups(&tree_of(&input, &options(Builder::Fast), &Diagonals(&at_one_place)), &input);
}

#[test]
fn fast_trees_depend_on_neither_threads_nor_instruction_set() {
    let bounds = boxes(&scattered(150_000), 0.001);
    let by = |threads, tier| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let options = BuildOptions { tier: Some(tier), ..options(Builder::Fast) };
        let tree = pool.install(|| tree_of(&triangles(&bounds), &options, &Diagonals(&bounds)));
        let groups: Vec<_> = tree.groups.iter().map(Reference::range).collect();
        (tree.nodes, groups, tree.primitives)
    };
    let first = by(1, Tier::Scalar);
    let tiers = Tier::ALL.into_iter().filter(|tier| tier.is_available()).map(|tier| (1, tier));
    for (threads, tier) in tiers.chain([(2, Tier::detect()), (5, Tier::detect())]) {
        assert!(first == by(threads, tier), "{threads} {tier:?}");
    }
}
