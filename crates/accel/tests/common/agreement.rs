//! Every builder on every tier by every query against the brute-force list.

use sahl_accel::{Accel, BuildOptions, Builder, Hit, Tier, TraversalCount, World};
use sahl_math::{Ray, Vec3};

use super::build;

/// The builders that make trees.
pub(crate) const TREES: [Builder; 4] =
    [Builder::BinnedSah, Builder::HighQuality, Builder::Fast, Builder::Median];

/// The tiers that this processor has.
pub(crate) fn tiers() -> impl Iterator<Item = Tier> {
    Tier::ALL.into_iter().filter(|tier| tier.is_available())
}

/// All trees on all tiers, the tiers of a builder in a row.
pub(crate) fn every_accel(world: &World) -> impl Iterator<Item = (BuildOptions, Accel)> {
    TREES.into_iter().flat_map(move |builder| {
        tiers().map(move |tier| {
            let options = BuildOptions { builder, tier: Some(tier), ..BuildOptions::default() };
            (options, Accel::build(world.clone(), &options))
        })
    })
}

/// A hit to the last bit.
pub(crate) fn bits(hit: Option<Hit>) -> Option<[u32; 6]> {
    hit.map(|hit| {
        [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.geometry, hit.primitive, hit.instance]
    })
}

/// A hit of nothing in particular: what stands in a slice before a query.
pub(crate) const STALE: Option<Hit> =
    Some(Hit { t: -1.0, u: 0.0, v: 0.0, geometry: 77, primitive: 77, instance: 77 });

pub(crate) fn intersect_batch(accel: &Accel, rays: &[Ray]) -> Vec<Option<Hit>> {
    let mut hits = vec![STALE; rays.len()];
    accel.intersect_batch(rays, &mut hits);
    hits
}

pub(crate) fn intersect_coherent(accel: &Accel, rays: &[Ray]) -> Vec<Option<Hit>> {
    let mut hits = vec![STALE; rays.len()];
    accel.intersect_coherent(rays, &mut hits);
    hits
}

pub(crate) fn occluded_batch(accel: &Accel, rays: &[Ray]) -> Vec<bool> {
    let mut occluded: Vec<bool> = (0..rays.len()).map(|i| i % 2 == 0).collect();
    accel.occluded_batch(rays, &mut occluded);
    occluded
}

/// Compares all queries of one structure with what is expected; returns the counts of the rays.
pub(crate) fn check_queries(
    context: &str,
    accel: &Accel,
    rays: &[Ray],
    expected: &[Option<Hit>],
) -> Vec<TraversalCount> {
    let (batch, coherent) = (intersect_batch(accel, rays), intersect_coherent(accel, rays));
    let occluded = occluded_batch(accel, rays);
    let mut counts = Vec::with_capacity(rays.len());
    for (i, ray) in rays.iter().enumerate() {
        let wanted = bits(expected[i]);
        assert_eq!(bits(accel.intersect(ray)), wanted, "{context}: {ray:?}");
        assert_eq!(bits(batch[i]), wanted, "{context}, batch: {ray:?}");
        assert_eq!(bits(coherent[i]), wanted, "{context}, coherent: {ray:?}");
        assert_eq!(accel.occluded(ray), wanted.is_some(), "{context}, occluded: {ray:?}");
        assert_eq!(occluded[i], wanted.is_some(), "{context}, occluded batch: {ray:?}");
        let mut count = TraversalCount::default();
        assert_eq!(bits(accel.intersect_counted(ray, &mut count)), wanted, "{context}, counted: {ray:?}");
        assert!(wanted.is_none() || count.nodes > 0 && count.primitives > 0);
        counts.push(count);
    }
    counts
}

/// Compares all queries of all trees on all tiers with brute force; returns how many rays hit.
///
/// Every ray that hits is also shot with intervals that begin and end at its hit.
pub(crate) fn compare(world: &World, rays: &[Ray]) -> usize {
    let oracle = build(world, Builder::BruteForce);
    let hits = rays.iter().filter(|ray| oracle.intersect(ray).is_some()).count();
    let mut rays = rays.to_vec();
    rays.extend(edge_intervals(&oracle, &rays));
    let expected: Vec<Option<Hit>> = rays.iter().map(|ray| oracle.intersect(ray)).collect();
    check_oracle(&oracle, &rays, &expected);
    let mut counts: Option<(BuildOptions, Vec<TraversalCount>)> = None;
    for (options, accel) in every_accel(world) {
        assert_eq!(accel.stats().dropped, oracle.stats().dropped, "{options:?}");
        assert_eq!(accel.bounds(), oracle.bounds(), "{options:?}");
        let counted = check_queries(&format!("{options:?}"), &accel, &rays, &expected);
        match &counts {
            Some((other, known)) if other.builder == options.builder => {
                assert_eq!(known, &counted, "{options:?} visits other things than {other:?}");
            }
            _ => counts = Some((options, counted)),
        }
    }
    hits
}

/// Compares all queries on all tiers with each other, and with brute force in whether there is a hit; returns how many rays
/// hit.
///
/// For triangles of which `f32` cannot tell the nearer: slivers, and large ones seen from next to them. Their parameters err by
/// more than the crossings of their boxes do, so that it depends on the tree which one is found.
pub(crate) fn agree(world: &World, rays: &[Ray]) -> usize {
    let oracle = build(world, Builder::BruteForce);
    let mut expected: Option<(Builder, Vec<Option<Hit>>)> = None;
    for (options, accel) in every_accel(world) {
        assert_eq!(accel.stats().dropped, oracle.stats().dropped, "{options:?}");
        if expected.as_ref().is_none_or(|(builder, _)| *builder != options.builder) {
            let hits: Vec<Option<Hit>> = rays.iter().map(|ray| accel.intersect(ray)).collect();
            for (ray, hit) in rays.iter().zip(&hits) {
                assert_eq!(hit.is_some(), oracle.occluded(ray), "{options:?} {ray:?}");
            }
            expected = Some((options.builder, hits));
        }
        if let Some((_, hits)) = &expected {
            check_queries(&format!("{options:?}"), &accel, rays, hits);
        }
    }
    expected.map_or(0, |(_, hits)| hits.iter().flatten().count())
}

/// The batches of the oracle itself, which have code of their own.
fn check_oracle(oracle: &Accel, rays: &[Ray], expected: &[Option<Hit>]) {
    let (batch, coherent) = (intersect_batch(oracle, rays), intersect_coherent(oracle, rays));
    let occluded = occluded_batch(oracle, rays);
    for (i, (ray, &hit)) in rays.iter().zip(expected).enumerate() {
        assert_eq!([bits(batch[i]), bits(coherent[i])], [bits(hit); 2], "oracle: {ray:?} {hit:?}");
        assert_eq!([occluded[i], oracle.occluded(ray)], [hit.is_some(); 2], "oracle: {ray:?}");
        assert!(hit.is_none_or(|hit| !hit.u.is_nan() && !hit.v.is_nan()), "oracle: {hit:?} of {ray:?}");
    }
}

/// Whether the parameter of a hit is as precise as the crossings of boxes. On grazed triangles, and where the ray starts on
/// the surface, it is not, and an interval that ends within its error may exclude the box about what is hit.
fn is_well_known(oracle: &Accel, ray: &Ray, hit: &Hit) -> bool {
    let point = oracle.surface_point(ray, hit);
    let coordinates = |v: Vec3| [v.x, v.y, v.z].map(f64::from);
    let (p, o, d) = (coordinates(point.p), coordinates(ray.origin), coordinates(ray.direction));
    let along: f64 = (0..3).map(|axis| (p[axis] - o[axis]) * d[axis]).sum();
    let t = along / d.map(|x| x * x).iter().sum::<f64>();
    (t - f64::from(hit.t)).abs() < 3e-7 * t
}

/// For some rays that hit, the same rays with intervals that begin and end at the hit and next to it.
fn edge_intervals(oracle: &Accel, rays: &[Ray]) -> Vec<Ray> {
    let mut cut = Vec::new();
    for ray in rays.iter().step_by(3) {
        let Some(hit) = oracle.intersect(ray) else { continue };
        if !is_well_known(oracle, ray, &hit) {
            continue;
        }
        assert!(hit.t > ray.t_min.max(0.0) && hit.t < ray.t_max, "{hit:?} of {ray:?}");
        for t in [hit.t, hit.t.next_up(), hit.t.next_down()] {
            cut.push(Ray { t_max: t, ..*ray });
            cut.push(Ray { t_min: t, ..*ray });
        }
    }
    cut
}
