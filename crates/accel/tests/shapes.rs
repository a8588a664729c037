//! Shapes against references in double precision.

mod common;

use std::f32::consts::{PI, TAU};

use common::{Random, build, world_of};
use sahl_accel::{
    Accel, Builder, Cylinder, Disk, Geometry, Hit, Instance, PatchMesh, Sphere, SurfacePoint, TriangleMesh,
    World, triangle,
};
use sahl_math::{Ray, Transform, Vec3};

type D3 = [f64; 3];

fn d(v: Vec3) -> D3 {
    [v.x, v.y, v.z].map(f64::from)
}

fn sub(a: D3, b: D3) -> D3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: D3, b: D3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: D3, b: D3) -> D3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: D3) -> f64 {
    dot(a, a).sqrt()
}

fn accel_of(geometry: Geometry) -> Accel {
    build(&world_of(vec![geometry]), Builder::BinnedSah)
}

/// The hit with its surface point, which has to hold `on_surface` within its error box: the signed distance, given the
/// normal, must not exceed the box's reach along it.
fn hit_point(accel: &Accel, ray: &Ray) -> Option<(Hit, SurfacePoint)> {
    accel.intersect(ray).map(|hit| (hit, accel.surface_point(ray, &hit)))
}

#[test]
fn triangles_agree_with_double_precision() {
    let mut random = Random(1);
    let (mut compared, mut hits) = (0, 0);
    for i in 0..200_000 {
        let scale = 10.0_f32.powi(i % 8 - 3);
        let vertices = [0; 3].map(|_| random.point(scale));
        let ray = Ray::new(random.point(3.0 * scale), random.direction());
        let [p0, p1, p2] = vertices.map(d);
        let (e1, e2, s) = (sub(p1, p0), sub(p2, p0), sub(d(ray.origin), p0));
        let p = cross(d(ray.direction), e2);
        let det = dot(e1, p);
        let (b1, q) = (dot(s, p) / det, cross(s, e1));
        let (b2, t) = (dot(d(ray.direction), q) / det, dot(e2, q) / det);
        // How far the ray passes from an edge, against what f32 can tell; grazing rays cannot be compared.
        let margin = b1.min(b2).min(1.0 - b1 - b2);
        let grazing = det.abs() < 1e-2 * f64::from(scale * scale);
        if grazing || margin.abs() < 1e-3 || t.abs() < 1e-3 * f64::from(scale) {
            continue;
        }
        compared += 1;
        let hit = triangle::intersect(&ray, vertices);
        assert_eq!(hit.is_some(), margin > 0.0 && t > 0.0, "{ray:?} {vertices:?}");
        let textbook = triangle::moller_trumbore(&ray, vertices);
        assert_eq!(hit.is_some(), textbook.is_some());
        for hit in [hit, textbook].into_iter().flatten() {
            hits += 1;
            assert!((f64::from(hit.t) - t).abs() < 1e-4 * f64::from(scale), "{} against {t}", hit.t);
            assert!((f64::from(hit.b1) - b1).abs() < 1e-4 && (f64::from(hit.b2) - b2).abs() < 1e-4);
        }
    }
    assert!(compared > 50_000 && hits > 1_500, "{compared} compared, {hits} hits");
}

#[test]
fn triangle_surface_points_lie_within_their_error() {
    let mut random = Random(2);
    for i in 0..20_000 {
        let scale = 10.0_f32.powi(i % 8 - 3);
        let offset = random.point(100.0 * scale);
        let vertices = [0; 3].map(|_| offset + random.point(scale));
        let mesh = TriangleMesh { indices: [[0, 1, 2]].into(), positions: vertices.into() };
        let accel = accel_of(Geometry::Triangles(mesh));
        let origin = offset + random.point(3.0 * scale);
        let target = (vertices[0] + vertices[1] + vertices[2]) * (1.0 / 3.0);
        let Some((hit, point)) = hit_point(&accel, &Ray::new(origin, target - origin)) else { continue };
        let [p0, p1, p2] = vertices.map(d);
        let n = cross(sub(p1, p0), sub(p2, p0));
        let off_plane = dot(n, sub(d(point.p), p0)).abs();
        let reach = dot(n.map(f64::abs), d(point.p_error));
        assert!(off_plane <= reach, "{off_plane} beyond {reach}");
        assert!(dot(n, d(point.n)) > 0.999_999 * length(n), "normal {:?}", point.n);
        assert_eq!((hit.geometry, hit.primitive, hit.instance), (0, 0, Hit::NO_INSTANCE));
        // Tight: about half a unit in the last place.
        assert!(point.p_error.max_component() <= 1e-7 * point.p.abs().max_component().max(1e-30));
    }
}

/// A rotation and a translation, times a scale.
fn placed(random: &mut Random, scale: f32, distance: f32) -> Transform {
    let axis = d(random.direction());
    let moved = d(random.direction() * distance);
    let turned = Transform::rotate(f64::from(random.range(0.0, 6.0)), axis).expect("a regular matrix");
    let s = f64::from(scale);
    let scaled =
        turned.after(&Transform::scale(s, s, s).expect("a regular matrix")).expect("a regular matrix");
    Transform::translate(moved[0], moved[1], moved[2])
        .expect("a regular matrix")
        .after(&scaled)
        .expect("a regular matrix")
}

#[test]
fn spheres_of_all_sizes_are_round_and_do_not_hit_themselves() {
    let mut random = Random(3);
    for radius in [1e-3, 1.0, 37.5, 1e4] {
        for distance in [0.0, 3.0 * radius, 100.0 * radius] {
            let to_parent = placed(&mut random, 1.0, distance);
            let center = d(to_parent.point(Vec3::ZERO));
            let sphere = Sphere { radius, z_min: -radius, z_max: radius, phi_max: TAU, to_parent };
            let accel = accel_of(Geometry::Sphere(sphere));
            let bounds = accel.bounds();
            let grown = 2.0 * f64::from(radius) + 1e-5 * f64::from(radius + distance);
            assert!((0..3).all(|i| f64::from(bounds.diagonal()[i]) <= grown));
            let mut hits = 0;
            for _ in 0..3000 {
                let inside = random.unit() < 0.5;
                let away = if inside { random.range(0.0, 0.9) } else { random.range(1.1, 50.0) };
                let origin = to_parent.point(random.direction() * (radius * away));
                let aim = to_parent.point(random.direction() * (radius * random.range(0.0, 0.99)));
                let ray = Ray::new(origin, aim - origin);
                let Some((hit, point)) = hit_point(&accel, &ray) else {
                    panic!("a ray at the sphere of radius {radius} missed")
                };
                hits += 1;
                let from_center = sub(d(point.p), center);
                let off = (length(from_center) - f64::from(radius)).abs();
                // The centre itself is known to the rounding of the transformation only.
                let known = length(d(point.p_error)) + 1e-6 * length(center) + 1e-7 * f64::from(radius);
                assert!(off <= known, "off by {off}, radius {radius}, known to {known}");
                let cosine = dot(d(point.n), from_center) / length(from_center);
                let blunt = length(d(point.p_error)) / f64::from(radius);
                assert!(cosine > 1.0 - 1e-6 - 2.0 * blunt, "the normal points outwards: {cosine}");
                let through =
                    f64::from(hit.t) - length(sub(d(point.p), d(origin))) / length(d(ray.direction));
                assert!(through.abs() < 1e-4 + 10.0 * blunt);
                // Outwards from the surface of a sphere nothing is left to hit; inwards the far side is.
                let outwards = random.direction().face_forward(point.n);
                let spawned = Ray::spawn(point.p, point.p_error, point.n, outwards);
                assert_eq!(accel.intersect(&spawned), None, "radius {radius} at {distance}");
                let inwards = -outwards;
                let spawned = Ray::spawn(point.p, point.p_error, point.n, inwards);
                let next = accel.intersect(&spawned).expect("a ray inside a sphere hits it");
                let chord = 2.0 * f64::from(radius) * -dot(d(inwards), d(point.n));
                // A ray that grazes moves its far end by the error over the cosine.
                let cosine = -dot(d(inwards), d(point.n));
                let tolerance = 1e-3 * f64::from(radius) + 8.0 * length(d(point.p_error)) / cosine.max(1e-9);
                assert!(
                    (f64::from(next.t) - chord).abs() <= tolerance,
                    "{} against the chord {chord}",
                    next.t
                );
            }
            assert_eq!(hits, 3000);
        }
    }
}

#[test]
fn a_distant_small_sphere_is_hit_where_it_is() {
    let sphere =
        Sphere { radius: 1e-3, z_min: -1.0, z_max: 1.0, phi_max: TAU, to_parent: Transform::IDENTITY };
    let accel = accel_of(Geometry::Sphere(sphere));
    for offset in [0.0, 0.5e-3, 0.999e-3, 1.001e-3] {
        let ray = Ray::new(Vec3::new(offset, 0.0, 1e4), -Vec3::Z);
        let hit = accel.intersect(&ray);
        assert_eq!(hit.is_some(), offset < 1e-3, "offset {offset}");
        if let Some(hit) = hit {
            let height = accel.surface_point(&ray, &hit).p.z;
            assert!((height - (1e-6 - offset * offset).sqrt()).abs() < 1e-6, "{height}");
        }
    }
}

#[test]
fn parameters_of_quadrics_are_those_of_the_file_format() {
    let identity = Transform::IDENTITY;
    // From the positive x axis towards y: azimuth 30 degrees.
    let (sin, cos) = (PI / 6.0).sin_cos();
    let side = Vec3::new(cos, sin, 0.0);
    let sphere = Sphere { radius: 2.0, z_min: -2.0, z_max: 2.0, phi_max: TAU, to_parent: identity };
    let sphere = accel_of(Geometry::Sphere(sphere));
    let (hit, point) = hit_point(&sphere, &Ray::new(side * 5.0, -side)).unwrap();
    assert!(
        (hit.t - 3.0).abs() < 1e-6 && (hit.u - 1.0 / 12.0).abs() < 1e-6 && (hit.v - 0.5).abs() < 1e-6,
        "{hit:?}"
    );
    assert!((point.n - side).length() < 1e-6);
    let below = sphere.intersect(&Ray::new(Vec3::new(1e-5, 0.0, -5.0), Vec3::Z)).unwrap();
    assert!(below.v < 1e-4, "v is zero at the lower pole: {below:?}");

    let cylinder = Cylinder { radius: 1.0, z_min: -1.0, z_max: 3.0, phi_max: PI, to_parent: identity };
    let cylinder = accel_of(Geometry::Cylinder(cylinder));
    let (hit, point) = hit_point(&cylinder, &Ray::new(side * 5.0 + Vec3::Z, -side)).unwrap();
    assert!(
        (hit.u - 1.0 / 6.0).abs() < 1e-6 && (hit.v - 0.5).abs() < 1e-6 && (hit.t - 4.0).abs() < 1e-6,
        "{hit:?}"
    );
    assert!((point.n - side).length() < 1e-6);
    // The other half is cut away: the ray passes it and hits this half from within.
    let (hit, point) = hit_point(&cylinder, &Ray::new(Vec3::new(0.0, -5.0, 0.0), Vec3::Y)).unwrap();
    assert!((hit.t - 6.0).abs() < 1e-6 && (point.n - Vec3::Y).length() < 1e-6);
    assert_eq!(cylinder.intersect(&Ray::new(Vec3::new(0.2, 0.3, -5.0), Vec3::Z)), None, "there are no caps");

    let disk = Disk { height: 0.5, radius: 2.0, inner_radius: 1.0, phi_max: TAU, to_parent: identity };
    let disk = accel_of(Geometry::Disk(disk));
    let (hit, point) = hit_point(&disk, &Ray::new(side * 1.25 - Vec3::Z, Vec3::Z)).unwrap();
    assert!(
        (hit.u - 1.0 / 12.0).abs() < 1e-6 && (hit.v - 0.75).abs() < 1e-6 && (hit.t - 1.5).abs() < 1e-6,
        "{hit:?}"
    );
    assert_eq!((point.n, point.p.z), (Vec3::Z, 0.5));
    for x in [0.9, 2.1] {
        assert_eq!(disk.intersect(&Ray::new(Vec3::new(x, 0.0, 3.0), -Vec3::Z)), None);
    }
}

#[test]
fn a_full_turn_leaves_no_slit_however_it_was_rounded() {
    // Just before the positive x axis is reached again, between a full turn and the `f32` below it.
    let ray = Ray::new(Vec3::new(0.5, -0.5e-7, 1.0), -Vec3::Z);
    let below = TAU.next_down();
    for (phi_max, is_whole) in [(f32::INFINITY, true), (TAU, true), (below, true), (below.next_down(), false)]
    {
        let to_parent = Transform::IDENTITY;
        let disk = Disk { height: 0.0, radius: 1.0, inner_radius: 0.0, phi_max, to_parent };
        assert_eq!(accel_of(Geometry::Disk(disk)).occluded(&ray), is_whole, "{phi_max}");
    }
}

#[test]
fn partial_spheres_end_at_their_limits() {
    let sphere =
        Sphere { radius: 1.0, z_min: 0.5, z_max: -0.25, phi_max: PI / 2.0, to_parent: Transform::IDENTITY };
    let accel = accel_of(Geometry::Sphere(sphere));
    let mut random = Random(4);
    let mut hits = 0;
    for _ in 0..5_000 {
        let origin = random.direction() * 3.0;
        let ray = Ray::new(origin, random.point(0.8) - origin);
        let Some((hit, point)) = hit_point(&accel, &ray) else { continue };
        hits += 1;
        assert!(point.p.z >= -0.25 - 1e-6 && point.p.z <= 0.5 + 1e-6, "{point:?}");
        assert!(point.p.x >= -1e-6 && point.p.y >= -1e-6, "{point:?}");
        assert!((0.0..=1.0).contains(&hit.u) && (0.0..=1.0).contains(&hit.v));
        let azimuth = point.p.y.atan2(point.p.x);
        assert!((hit.u * (PI / 2.0) - azimuth).abs() < 1e-5);
        let polar = [(-0.25_f32).acos(), 0.5_f32.acos()];
        assert!((polar[0] + hit.v * (polar[1] - polar[0]) - point.p.z.acos()).abs() < 1e-4);
    }
    assert!(hits > 300, "{hits}");
    let inside = Ray::new(Vec3::ZERO, Vec3::new(0.5, 0.5, 0.1));
    assert!(accel.intersect(&inside).is_some());
    assert_eq!(accel.intersect(&Ray::new(Vec3::ZERO, Vec3::new(0.5, -0.5, 0.1))), None);
}

#[test]
fn quadrics_do_not_hit_the_point_they_leave() {
    let mut random = Random(5);
    for scale in [1e-3, 1.0, 1e4] {
        for i in 0..3000 {
            let to_parent = placed(&mut random, scale, 3.0 * scale);
            let geometry = if i % 2 == 0 {
                Geometry::Disk(Disk { height: 0.3, radius: 1.0, inner_radius: 0.0, phi_max: TAU, to_parent })
            } else {
                Geometry::Cylinder(Cylinder { radius: 1.0, z_min: -1.0, z_max: 1.0, phi_max: TAU, to_parent })
            };
            let accel = accel_of(geometry);
            let origin = random.direction() * (6.0 * scale);
            let aim = to_parent.point(random.point(0.5) + Vec3::Z * 0.3);
            let Some((_, point)) = hit_point(&accel, &Ray::new(origin, aim - origin)) else { continue };
            for direction in [random.direction(), origin - point.p, point.p - origin] {
                let spawned = Ray::spawn(point.p, point.p_error, point.n, direction);
                if let Some(next) = accel.intersect(&spawned) {
                    assert!(i % 2 == 1, "a disk is flat");
                    assert!(next.t * direction.length() > 1e-4 * scale, "{next:?} at {scale}");
                }
            }
        }
    }
}

#[test]
fn curved_patches_agree_with_a_fine_triangulation() {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.7], [-1.0, 1.0, 0.4], [1.0, 1.0, -0.8]].map(Vec3::from);
    let patch = PatchMesh { indices: [[0, 1, 2, 3]].into(), positions: corners.into() };
    let patch = accel_of(Geometry::Patches(patch));
    let n = 96_u32;
    let at = |i: u32, j: u32| {
        let (u, v) = (i as f32 / n as f32, j as f32 / n as f32);
        let (low, high) =
            (corners[0] + (corners[1] - corners[0]) * u, corners[2] + (corners[3] - corners[2]) * u);
        low + (high - low) * v
    };
    let positions: Vec<Vec3> =
        (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect();
    let index = |i: u32, j: u32| i * (n + 1) + j;
    let indices: Vec<[u32; 3]> = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let quad = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
        })
        .collect();
    let mesh =
        accel_of(Geometry::Triangles(TriangleMesh { indices: indices.into(), positions: positions.into() }));
    let mut random = Random(6);
    let (mut agreed, mut differed) = (0, 0);
    for _ in 0..10_000 {
        let origin = random.direction() * 3.0;
        let ray = Ray::new(origin, random.point(1.2) - origin);
        match (hit_point(&patch, &ray), mesh.intersect(&ray)) {
            (Some((hit, point)), Some(expected)) if (hit.t - expected.t).abs() < 2e-2 => {
                agreed += 1;
                let (low, high) = (
                    corners[0] + (corners[1] - corners[0]) * hit.u,
                    corners[2] + (corners[3] - corners[2]) * hit.u,
                );
                assert!((point.p - (low + (high - low) * hit.v)).length() < 1e-6);
                assert!((point.p - ray.at(hit.t)).length() < 1e-5);
                let (du, dv) = (
                    corners[1] - corners[0] + (corners[3] - corners[2] - corners[1] + corners[0]) * hit.v,
                    high - low,
                );
                assert!(point.n.dot(du.cross(dv).normalize()) > 0.99999);
            }
            (None, None) => {}
            _ => differed += 1,
        }
    }
    assert!(agreed > 1500 && differed * 100 < agreed, "{agreed} agreed, {differed} differed");
}

#[test]
fn flat_patches_have_bilinear_parameters() {
    let parallelogram = [[0.0, 0.0, 1.0], [2.0, 0.5, 1.0], [0.5, 2.0, 1.0], [2.5, 2.5, 1.0]].map(Vec3::from);
    let trapezoid = [[0.0, 0.0, 1.0], [3.0, 0.0, 1.0], [1.0, 2.0, 1.0], [2.0, 2.0, 1.0]].map(Vec3::from);
    let general = [[0.0, 0.0, 1.0], [3.0, -0.5, 1.0], [0.4, 2.0, 1.0], [4.0, 2.7, 1.0]].map(Vec3::from);
    let collapsed = [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [-1.0, 2.0, 1.0], [2.0, 2.0, 1.0]].map(Vec3::from);
    for corners in [parallelogram, trapezoid, general, collapsed] {
        let patch = PatchMesh { indices: [[0, 1, 2, 3]].into(), positions: corners.into() };
        let accel = accel_of(Geometry::Patches(patch));
        for i in 1..20 {
            for j in 1..20 {
                let (u, v) = (i as f32 / 20.0, j as f32 / 20.0);
                let low = corners[0] + (corners[1] - corners[0]) * u;
                let high = corners[2] + (corners[3] - corners[2]) * u;
                let p = low + (high - low) * v;
                let (hit, point) = hit_point(&accel, &Ray::new(p + Vec3::Z * 3.0, -Vec3::Z)).expect("inside");
                assert!((hit.u - u).abs() < 1e-5 && (hit.v - v).abs() < 1e-5, "{hit:?} against {u} {v}");
                assert!((point.p - p).length() < 1e-5 && (point.n.abs() - Vec3::Z).length() < 1e-6);
            }
        }
    }
}

#[test]
fn instances_carry_points_normals_and_errors_to_the_world() {
    let mut random = Random(8);
    for i in 0..3000 {
        let vertices = [0; 3].map(|_| random.point(1.0));
        let stretch = Transform::scale(2.0, if i % 2 == 0 { -0.5 } else { 0.5 }, 3.0).unwrap();
        let to_world = placed(&mut random, 1.0, 50.0).after(&stretch).unwrap();
        let world = World {
            geometries: vec![Geometry::Triangles(TriangleMesh {
                indices: [[0, 1, 2]].into(),
                positions: vertices.into(),
            })],
            groups: vec![vec![0]],
            instances: vec![Instance { group: 0, to_world: to_world.into() }],
            ..World::default()
        };
        let accel = build(&world, Builder::BinnedSah);
        let rows = to_world.to_rows();
        let image = |p: Vec3| rows.map(|row| dot([row[0], row[1], row[2]], d(p)) + row[3]);
        let [p0, p1, p2] = vertices.map(image);
        let middle = [0, 1, 2].map(|i| ((p0[i] + p1[i] + p2[i]) / 3.0) as f32);
        let origin = Vec3::from(middle) + random.direction() * random.range(0.5, 20.0);
        let ray = Ray::new(origin, Vec3::from(middle) - origin);
        let Some((hit, point)) = hit_point(&accel, &ray) else { continue };
        assert_eq!(hit.instance, 0);
        let mut n = cross(sub(p1, p0), sub(p2, p0));
        if i % 2 == 0 {
            n = n.map(|x| -x);
        }
        assert!(dot(n, d(point.n)) > 0.99999 * length(n), "a mirrored normal is not flipped");
        let off_plane = dot(n, sub(d(point.p), p0)).abs();
        assert!(off_plane <= dot(n.map(f64::abs), d(point.p_error)), "off by {off_plane}");
        for direction in [random.direction(), -ray.direction, ray.direction] {
            let spawned = Ray::spawn(point.p, point.p_error, point.n, direction);
            assert_eq!(accel.intersect(&spawned), None, "a flat thing was hit twice");
        }
    }
}
