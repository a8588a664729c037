use sahl_math::{Bounds3, Vec3};

use super::*;
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

const TREES: [Builder; 2] = [Builder::Median, Builder::BinnedSah];

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
            let references = &tree.references[node.range()];
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
    assert!(found == missing, "the tree holds something else than it was built over");
    assert_eq!(visited, tree.nodes.len(), "a node hangs nowhere");
    assert!(deepest <= MAX_DEPTH, "{deepest}");
    deepest
}

fn built(builder: Builder, bounds: &[Bounds3]) -> BinaryTree {
    build(triangles(bounds), &options(builder)).expect("there are primitives")
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
    assert!(build(Vec::new(), &options(Builder::BinnedSah)).is_none());
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
    check(&build(triangles(&bounds), &few_bins).expect("primitives"), &triangles(&bounds));
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
    let item = |i: u32| match i % 5 {
        0 => Item::Patch(i),
        1 => Item::Quadric(i),
        2 => Item::Instance(i),
        _ => Item::Triangle(i),
    };
    let input: Vec<Reference> =
        bounds.iter().zip(0..).map(|(bounds, i)| Reference::new(bounds, item(i))).collect();
    for builder in TREES {
        let tree = build(input.clone(), &options(builder)).expect("there are primitives");
        check(&tree, &input);
        let mut items: Vec<u32> = tree.references.iter().map(|one| one.place()).collect();
        assert!(tree.references.iter().all(|one| one.item() == item(one.place())));
        items.sort_unstable();
        assert!(items.into_iter().eq(0..700));
    }
}

#[test]
fn the_tree_depends_on_neither_threads_nor_instruction_set() {
    let bounds = boxes(&scattered(200_000), 0.001);
    for builder in TREES {
        let tree_of = |threads, tier| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let options = BuildOptions { tier: Some(tier), ..options(builder) };
            let tree = pool.install(|| build(triangles(&bounds), &options)).expect("there are primitives");
            let order: Vec<_> = tree.references.iter().map(Reference::key).collect();
            (tree, order)
        };
        let first = tree_of(1, Tier::Scalar);
        check(&first.0, &triangles(&bounds));
        for threads in [1, 2, 5] {
            for tier in Tier::ALL.into_iter().filter(|tier| tier.is_available()) {
                let other = tree_of(threads, tier);
                assert!(
                    first.0.nodes == other.0.nodes && first.1 == other.1,
                    "{builder:?} {threads} {tier:?}"
                );
            }
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
