use sahl_math::{Bounds3, Vec3};

use super::*;

fn boxes(centers: &[Vec3], half: f32) -> Vec<Bounds3> {
    centers.iter().map(|&c| Bounds3 { min: c - Vec3::splat(half), max: c + Vec3::splat(half) }).collect()
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
fn check(tree: &BinaryTree, bounds: &[Bounds3]) -> u32 {
    let mut seen = vec![false; bounds.len()];
    let mut pending = vec![(0_u32, 0_u32)];
    let mut deepest = 0;
    while let Some((place, depth)) = pending.pop() {
        deepest = deepest.max(depth);
        let node = &tree.nodes[place as usize];
        if node.is_leaf() {
            let mut total = Bounds3::EMPTY;
            for &primitive in &tree.order[node.index as usize..(node.index + node.count) as usize] {
                assert!(!std::mem::replace(&mut seen[primitive as usize], true), "{primitive} stands twice");
                total = total.union(bounds[primitive as usize]);
            }
            assert_eq!(total, node.bounds);
        } else {
            let [left, right] = [place + 1, node.index].map(|child| tree.nodes[child as usize].bounds);
            assert_eq!(left.union(right), node.bounds);
            pending.extend([(place + 1, depth + 1), (node.index, depth + 1)]);
        }
    }
    assert!(seen.iter().all(|&seen| seen), "a primitive is missing");
    assert!(deepest <= MAX_DEPTH, "{deepest}");
    deepest
}

fn built(builder: Builder, centers: &[Vec3], bounds: &[Bounds3]) -> BinaryTree {
    build(BuildInput { bounds, centers }, &options(builder)).expect("there are primitives")
}

#[test]
fn trees_hold_everything_once_in_tight_boxes() {
    for count in [1, 2, 3, 4, 5, 8, 9, 100, 5000] {
        let centers = scattered(count);
        let bounds = boxes(&centers, 0.01);
        for builder in TREES {
            let tree = built(builder, &centers, &bounds);
            let depth = check(&tree, &bounds);
            assert!(count < 100 || depth < 30);
        }
    }
    assert_eq!(build(BuildInput { bounds: &[], centers: &[] }, &options(Builder::BinnedSah)), None);
}

#[test]
fn primitives_at_one_place_are_halved() {
    let centers = vec![Vec3::splat(0.25); 5000];
    let bounds = boxes(&centers, 0.5);
    for builder in TREES {
        let depth = check(&built(builder, &centers, &bounds), &bounds);
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
        check(&built(builder, &centers, &bounds), &bounds);
    }
    let input = BuildInput { bounds: &bounds, centers: &centers };
    check(
        &build(input, &BuildOptions { builder: Builder::BinnedSah, bins: 2 }).expect("primitives"),
        &bounds,
    );
}

#[test]
fn extreme_extents_end_in_balanced_trees() {
    let centers: Vec<Vec3> = scattered(300).into_iter().map(|p| p * 1e18).collect();
    let huge = boxes(&centers, 1e18);
    let flat: Vec<Bounds3> = centers.iter().map(|&c| Bounds3 { min: c, max: c }).collect();
    let line: Vec<Vec3> = centers.iter().map(|c| Vec3::new(c.x, 0.0, 0.0)).collect();
    for builder in TREES {
        check(&built(builder, &centers, &huge), &huge);
        check(&built(builder, &centers, &flat), &flat);
        let thin = boxes(&line, 0.0);
        check(&built(builder, &line, &thin), &thin);
    }
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let centers = scattered(200_000);
    let bounds = boxes(&centers, 0.001);
    for builder in TREES {
        let trees = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| built(builder, &centers, &bounds))
        });
        assert!(trees[0] == trees[1] && trees[1] == trees[2], "{builder:?}");
        check(&trees[0], &bounds);
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
    let cost = |builder| built(builder, &centers, &bounds).sah_cost(|_| 1.0);
    let (median, sah) = (cost(Builder::Median), cost(Builder::BinnedSah));
    assert!(sah < 0.8 * median, "SAH {sah}, median {median}");
}

#[test]
fn the_cost_of_a_known_tree() {
    // Two unit cubes side by side, each a leaf: one inner node of area 5 (halved), two leaves of area 3.
    let centers = [Vec3::splat(0.5), Vec3::new(1.5, 0.5, 0.5)];
    let bounds = boxes(&centers, 0.5);
    let leaf = |index: usize| BinaryNode { bounds: bounds[index], index: index as u32, count: 1 };
    let root = BinaryNode { bounds: bounds[0].union(bounds[1]), index: 2, count: 0 };
    let tree = BinaryTree { nodes: vec![root, leaf(0), leaf(1)], order: vec![0, 1] };
    assert_eq!(tree.sah_cost(|_| 1.0), 1.0 + (3.0 + 3.0) / 5.0);
    assert_eq!(tree.sah_cost(|_| 10.0), 1.0 + 10.0 * (3.0 + 3.0) / 5.0);
}
