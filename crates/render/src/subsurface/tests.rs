//! The tables against what they stand for: a walk through a half space; and what is drawn against its density.

use sahl_math::{Vec2, Vec3};
use sahl_testkit::chi2::LineTest;
use sahl_testkit::random::Rng;

use super::*;
use crate::bsdf::fresnel;

fn at_origin() -> Interaction {
    Interaction::test(Frame::from_z(Vec3::Z), Vec2::ZERO)
}

fn bssrdf(table: &DiffusionTable, sigma_a: f32, sigma_s: f32) -> Bssrdf<'_> {
    Bssrdf::new(&at_origin(), 1.33, table, [sigma_a, sigma_s].map(Spectrum::splat))
}

#[test]
fn effective_albedos_grow_with_the_albedo_and_end_below_one() {
    for (g, eta) in [(0.0, 1.33), (0.0, 1.0), (0.5, 1.5), (-0.3, 1.2)] {
        let table = DiffusionTable::new(g, eta);
        let mut before = -1.0;
        for i in 0..=100 {
            let albedo = i as f32 / 100.0;
            let effective = table.profile(albedo).effective_albedo();
            assert!(
                effective > before - 1e-6 && effective < 1.0 + 1e-5,
                "{g} {eta} {albedo}: {effective} {before}"
            );
            before = effective;
            let inverse = table.albedo_of(effective);
            let again = table.profile(inverse).effective_albedo();
            assert!((again - effective).abs() < 1e-4, "{albedo}: {inverse}");
        }
        // Matter that absorbs nothing gives nearly everything back.
        assert!(before > 0.8, "{g} {eta}: {before}");
        assert_eq!(table.albedo_of(2.0), 1.0);
    }
}

#[test]
fn distances_follow_the_profile() {
    let table = DiffusionTable::new(0.0, 1.33);
    for albedo in [0.2, 0.7, 0.95, 0.999] {
        let profile = table.profile(albedo);
        let test = LineTest { range: [0.0, 20.0], tests: 4, samples: 200_000, ..LineTest::default() };
        let density = |r| profile.radial(r) / profile.effective_albedo();
        test.run(|u| Some(profile.sample(u)).filter(|r| *r < 20.0), density)
            .unwrap_or_else(|message| panic!("{albedo}: {message}"));
    }
}

/// A random walk of a photon that enters a half space at right angles: how far from there it leaves.
fn walk(albedo: f32, eta: f32, rng: &mut Rng) -> Option<f32> {
    let (mut p, mut w) = (Vec3::ZERO, -Vec3::Z);
    loop {
        let flight = -(1.0 - rng.next_f32()).ln();
        let next = p + w * flight;
        if next.z > 0.0 {
            let at = p + w * (-p.z / w.z);
            if rng.next_f32() >= fresnel::dielectric(w.z, 1.0 / eta).reflectance {
                return Some(at.x.hypot(at.y));
            }
            // Flights have no memory: a new one begins at the surface.
            (p, w) = (Vec3::new(at.x, at.y, 0.0), Vec3::new(w.x, w.y, -w.z));
            continue;
        }
        p = next;
        if rng.next_f32() >= albedo {
            return None;
        }
        w = warp::uniform_sphere(Vec2::new(rng.next_f32(), rng.next_f32()));
    }
}

/// Photon beam diffusion is an approximation: Habel et al. report errors of some per cent, most where little is scattered.
#[test]
fn the_table_is_near_to_walks_through_a_half_space() {
    let mut rng = Rng::new(0x5eb5);
    for (eta, albedo, tolerance) in [(1.33, 0.9, 0.12), (1.33, 0.99, 0.1), (1.0, 0.9, 0.15)] {
        let table = DiffusionTable::new(0.0, eta);
        let profile = table.profile(albedo);
        let (walks, mut left, mut near) = (20_000, 0, 0);
        for _ in 0..walks {
            if let Some(r) = walk(albedo, eta, &mut rng) {
                left += 1;
                near += u32::from(r < 1.0);
            }
        }
        let share = |count: u32| f64::from(count) / f64::from(walks);
        let expected = f64::from(profile.effective_albedo());
        assert!(
            (share(left) / expected - 1.0).abs() < tolerance,
            "{eta} {albedo}: {} {expected}",
            share(left)
        );
        let within: f64 =
            (0..1000).map(|i| f64::from(profile.radial((i as f32 + 0.5) / 1000.0)) / 1000.0).sum();
        assert!(
            (share(near) - within).abs() < 2.0 * tolerance * expected,
            "{eta} {albedo}: {} {within}",
            share(near)
        );
    }
}

/// On a plane, the probes along the normal estimate the whole reflectance; those along the tangents meet nothing.
#[test]
fn probes_of_a_plane_find_the_effective_albedo() {
    let table = DiffusionTable::new(0.0, 1.33);
    // Lanes of different reach, and one in which nothing scatters.
    let sigma_t = [1.0, 3.0, 10.0, 2.0];
    let albedo = [0.95, 0.9, 0.5, 0.0];
    let sigma_s = std::array::from_fn(|lane| sigma_t[lane] * albedo[lane]);
    let sigma_a = std::array::from_fn(|lane| sigma_t[lane] * (1.0 - albedo[lane]));
    let bssrdf = Bssrdf::new(&at_origin(), 1.33, &table, [sigma_a, sigma_s].map(Spectrum::from_lanes));
    let (mut rng, mut sum, count) = (Rng::new(0x9a0be), Spectrum::ZERO, 400_000);
    for _ in 0..count {
        let [choice, x, y] = rng.uniform();
        let Some(Probe { start, end }) = bssrdf.probe(choice, Vec2::new(x, y)) else { continue };
        let through = start.z * end.z < 0.0;
        if through {
            let p = start + (end - start) * (start.z / (start.z - end.z));
            sum += bssrdf.value(p) / bssrdf.pdf(p, Vec3::Z);
        }
    }
    for lane in 0..LANES {
        let (found, expected) = (sum.lanes()[lane] / count as f32, bssrdf.lanes[lane].effective_albedo);
        assert!((found - expected).abs() < 0.02 * expected + 1e-6, "{lane}: {found} instead of {expected}");
    }
}

/// The integral of the density over a sphere is the share of probes that meet it, counted as often as they do.
#[test]
fn probes_of_a_sphere_follow_their_density() {
    let table = DiffusionTable::new(0.0, 1.33);
    let bssrdf = bssrdf(&table, 0.1, 0.9);
    let (centre, radius) = (Vec3::new(0.0, 0.0, -1.0), 1.0_f32);
    let (mut rng, count) = (Rng::new(0x5fe4e), 200_000);
    let (mut met, mut integral) = ([0.0_f64; 2], [0.0_f64; 2]);
    for _ in 0..count {
        let [choice, x, y] = rng.uniform();
        if let Some(Probe { start, end }) = bssrdf.probe(choice, Vec2::new(x, y)) {
            let (o, d) = (start - centre, end - start);
            let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - radius * radius);
            let root = sahl_math::safe_sqrt(b * b - a * c);
            for t in [(-b - root) / a, (-b + root) / a] {
                if root > 0.0 && (0.0..=1.0).contains(&t) {
                    met[usize::from((start + d * t).z < -0.5)] += 1.0 / f64::from(count);
                }
            }
        }
        let [x, y] = rng.uniform();
        let n = warp::uniform_sphere(Vec2::new(x, y));
        let p = centre + n * radius;
        integral[usize::from(p.z < -0.5)] +=
            f64::from(bssrdf.pdf(p, n)) * 2.0 * f64::from(TAU) / f64::from(count);
    }
    for (met, integral) in met.iter().zip(integral) {
        assert!((met - integral).abs() < 0.03 * integral, "{met} {integral}");
    }
}
