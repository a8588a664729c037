//! Curves against a dense walk along their axis in double precision.

mod common;

use common::{Random, build, world_of};
use sahl_accel::{Accel, Builder, CurveKind, CurveSet, Geometry};
use sahl_math::{Ray, Transform, Vec3};

const KINDS: [CurveKind; 3] = [CurveKind::Flat, CurveKind::Cylinder, CurveKind::Ribbon];

type D3 = [f64; 3];

fn d(v: Vec3) -> D3 {
    [v.x, v.y, v.z].map(f64::from)
}

fn dot(a: D3, b: D3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: D3) -> f64 {
    dot(a, a).sqrt()
}

fn set(kind: CurveKind, points: [Vec3; 4], widths: [f32; 2], split_depth: u32) -> CurveSet {
    let normals = if kind == CurveKind::Ribbon { vec![[Vec3::Z, Vec3::X]] } else { Vec::new() };
    CurveSet {
        kind,
        points: [points].into(),
        widths: [widths].into(),
        normals: normals.into(),
        split_depth,
        to_parent: Transform::IDENTITY,
    }
}

fn accel_of(set: CurveSet) -> Accel {
    build(&world_of(vec![Geometry::Curves(set)]), Builder::BinnedSah)
}

/// The point of the axis at `u`, by the Bernstein polynomials.
fn axis(points: &[Vec3; 4], u: f64) -> D3 {
    let v = 1.0 - u;
    let weights = [v * v * v, 3.0 * u * v * v, 3.0 * u * u * v, u * u * u];
    std::array::from_fn(|i| (0..4).map(|k| weights[k] * f64::from(points[k][i])).sum())
}

/// The parameter of a ray next to a point, and the distance between the two.
fn nearest(ray: &Ray, p: D3) -> (f64, f64) {
    let (o, direction) = (d(ray.origin), d(ray.direction));
    let to = [p[0] - o[0], p[1] - o[1], p[2] - o[2]];
    let t = dot(to, direction) / dot(direction, direction);
    let off: D3 = std::array::from_fn(|i| to[i] - direction[i] * t);
    (t, length(off))
}

/// How far outside the strip the ray passes at best, relative to its width, away from the ends; and whether an end is nearest.
fn clearance(ray: &Ray, points: &[Vec3; 4], widths: [f32; 2]) -> (f64, bool) {
    const STEPS: usize = 4000;
    let mut best = (f64::INFINITY, false);
    for step in 0..=STEPS {
        let u = step as f64 / STEPS as f64;
        let (t, distance) = nearest(ray, axis(points, u));
        let width = f64::from(widths[0]) * (1.0 - u) + f64::from(widths[1]) * u;
        let clearance = distance / width - 0.5;
        if t > 0.0 && clearance < best.0 {
            best = (clearance, !(20..=STEPS - 20).contains(&step));
        }
    }
    best
}

#[test]
fn strips_are_met_where_the_axis_passes_within_half_a_width() {
    let mut random = Random(31);
    let (mut hits, mut misses) = (0, 0);
    for i in 0..6000 {
        let points = [0; 4].map(|_| random.point(1.0));
        let widths = [random.range(0.02, 0.2), random.range(0.02, 0.2)];
        let kind = KINDS[i % 2];
        let accel = accel_of(set(kind, points, widths, i as u32 % 5));
        let origin = random.direction() * 4.0;
        let aim = axis(&points, f64::from(random.unit())).map(|x| x as f32);
        let ray = Ray::new(origin, Vec3::from(aim) + random.point(0.15) - origin);
        let (clearance, is_end) = clearance(&ray, &points, widths);
        if is_end {
            continue;
        }
        let hit = accel.intersect(&ray);
        // A part that counts as straight is off by a twentieth of the width.
        if clearance < -0.1 {
            assert!(hit.is_some(), "missed by {clearance}: {ray:?} {points:?} {widths:?}");
        } else if clearance > 0.1 {
            assert!(hit.is_none(), "hit at {clearance}: {ray:?} {points:?} {widths:?}");
            misses += 1;
        }
        let Some(hit) = hit else { continue };
        hits += 1;
        let u = f64::from(hit.u);
        let (t, distance) = nearest(&ray, axis(&points, u));
        let width = f64::from(widths[0]) * (1.0 - u) + f64::from(widths[1]) * u;
        assert!(distance < 0.6 * width, "{distance} of {width}");
        assert!(((f64::from(hit.v) - 0.5).abs() - distance / width).abs() < 0.1, "{hit:?}: {distance}");
        let off = (f64::from(hit.t) - t) * length(d(ray.direction));
        assert!(off.abs() < width, "{hit:?} against {t}");
        let point = accel.surface_point(&ray, &hit);
        assert!((point.p - ray.at(hit.t)).length() < 1e-5);
        assert!((point.n.length() - 1.0).abs() < 1e-6 && point.n.dot(ray.direction) >= -1e-5, "{point:?}");
        // The next part of the ray finds nothing nearer.
        let before = accel.intersect(&ray.with_t_max(hit.t));
        assert!(before.is_none(), "{before:?} before {hit:?}");
    }
    assert!(hits > 2000 && misses > 500, "{hits} hits, {misses} misses");
}

#[test]
fn ribbons_turn_away_and_have_the_given_normal() {
    let points = [0.0, 1.0, 2.0, 3.0].map(|x| Vec3::new(x, 0.0, 0.0));
    let straight =
        CurveSet { normals: [[Vec3::Z * 2.0; 2]].into(), ..set(CurveKind::Ribbon, points, [0.2; 2], 2) };
    let accel = accel_of(straight);
    for degrees in [0.0_f32, 30.0, 60.0, 85.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let from = Vec3::new(0.0, -sin, cos);
        // The half width as seen under the angle, across the ray.
        let across = Vec3::new(0.0, cos, sin);
        for (share, is_hit) in [(0.0, true), (0.98, true), (-0.98, true), (1.02, false), (-1.02, false)] {
            let middle = Vec3::new(1.3, 0.0, 0.0) + across * (0.1 * cos * share);
            let ray = Ray::new(middle + from * 5.0, -from);
            let hit = accel.intersect(&ray);
            assert_eq!(hit.is_some(), is_hit, "{degrees} degrees, {share} of the width");
            let Some(hit) = hit else { continue };
            let expected = 0.5 + 0.5 * share;
            let v = if ray.direction.dot(Vec3::Z) > 0.0 { 1.0 - hit.v } else { hit.v };
            assert!((v - expected).abs() < 1e-4 || (1.0 - v - expected).abs() < 1e-4, "{hit:?}: {expected}");
            assert!((hit.u - 1.3 / 3.0).abs() < 1e-5 && (hit.t - 5.0).abs() < 1e-5, "{hit:?}");
            assert!((accel.surface_point(&ray, &hit).n - Vec3::Z).length() < 1e-5);
        }
    }
    // A normal that turns from z to x about y along a ribbon along y.
    let points = [0.0, 1.0, 2.0, 3.0].map(|y| Vec3::new(0.0, y, 0.0));
    let accel = accel_of(set(CurveKind::Ribbon, points, [0.2; 2], 2));
    let ray = Ray::new(Vec3::new(0.03, 1.5, 5.0), -Vec3::Z);
    let hit = accel.intersect(&ray).expect("seen under 45 degrees");
    let n = accel.surface_point(&ray, &hit).n;
    assert!((n - Vec3::new(0.5_f32.sqrt(), 0.0, 0.5_f32.sqrt())).length() < 1e-5, "{n:?}");
    assert!(accel.intersect(&Ray::new(Vec3::new(0.075, 1.5, 5.0), -Vec3::Z)).is_none(), "narrowed by 0.7");
}

#[test]
fn normals_of_tubes_turn_across_the_width() {
    let points = [0.0, 1.0, 2.0, 3.0].map(|x| Vec3::new(x, 0.0, 0.0));
    let accel = accel_of(set(CurveKind::Cylinder, points, [0.2; 2], 3));
    for share in [-0.999, -0.5, 0.0, 0.5, 0.999_f32] {
        let ray = Ray::new(Vec3::new(1.0, 0.1 * share, 5.0), -Vec3::Z);
        let hit = accel.intersect(&ray).expect("within the width");
        let n = accel.surface_point(&ray, &hit).n;
        let angle = share * std::f32::consts::FRAC_PI_2;
        assert!((n.y.abs() - angle.sin().abs()).abs() < 1e-4 && n.x.abs() < 1e-5, "{share}: {n:?}");
        assert!((n.z.abs() - angle.cos()).abs() < 1e-4, "{share}: {n:?}");
    }
}

#[test]
fn what_has_no_surface_is_dropped() {
    let points = [0.0, 1.0, 2.0, 3.0].map(|x| Vec3::new(x, 0.0, 0.0));
    let nan = [Vec3::ZERO, Vec3::splat(f32::NAN), Vec3::X, Vec3::Y];
    let bad = [
        set(CurveKind::Flat, points, [0.0; 2], 1),
        set(CurveKind::Flat, points, [-1.0, 1.0], 1),
        set(CurveKind::Flat, points, [f32::NAN, 1.0], 1),
        set(CurveKind::Flat, points, [f32::INFINITY, 1.0], 1),
        set(CurveKind::Flat, [Vec3::ONE; 4], [1.0; 2], 1),
        set(CurveKind::Flat, nan, [1.0; 2], 1),
        CurveSet { normals: [].into(), ..set(CurveKind::Ribbon, points, [1.0; 2], 1) },
        CurveSet { widths: [].into(), ..set(CurveKind::Flat, points, [1.0; 2], 1) },
    ];
    for set in bad {
        let accel = accel_of(set.clone());
        assert_eq!((accel.stats().primitives, accel.stats().dropped), (0, 2), "{set:?}");
        assert_eq!(accel.intersect(&Ray::new(Vec3::new(1.0, 0.0, 5.0), -Vec3::Z)), None);
    }
}

#[test]
fn rays_that_leave_a_straight_curve_do_not_hit_it() {
    let mut random = Random(32);
    let mut spawned = 0;
    for scale in [1e-3, 1.0, 1e4_f32] {
        for distance in [0.0, 100.0 * scale] {
            for i in 0..600 {
                let (from, step) = (random.direction() * distance, random.direction() * scale);
                let points = [0.0, 1.0, 2.0, 3.0].map(|k| from + step * k);
                let widths = [random.range(0.001, 0.3) * scale, random.range(0.001, 0.3) * scale];
                let accel = accel_of(set(KINDS[i % 2], points, widths, 3));
                let aim = from + step * random.range(0.2, 2.8);
                let origin = aim + random.direction() * (random.range(1.0, 20.0) * scale);
                let ray = Ray::new(origin, aim + random.direction() * (0.2 * widths[0]) - origin);
                let Some(hit) = accel.intersect(&ray) else { continue };
                let point = accel.surface_point(&ray, &hit);
                for direction in [random.direction(), point.n, -point.n, -ray.direction, ray.direction] {
                    let next = Ray::spawn(point.p, point.p_error, point.n, direction);
                    // A tube that widens is not straight: only rays away from where it does are sure to be clear.
                    let sideways = direction.dot(step).abs() < 0.5 * direction.length() * step.length();
                    if sideways {
                        spawned += 1;
                        assert_eq!(accel.intersect(&next), None, "{hit:?} of {ray:?} at {scale}");
                    }
                }
            }
        }
    }
    assert!(spawned > 3000, "{spawned}");
}
