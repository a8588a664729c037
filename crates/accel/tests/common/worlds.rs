//! Worlds made to be awkward, and rays that are no better.

use std::f32::consts::TAU;

use sahl_accel::{
    CurveKind, CurveSet, Cylinder, Disk, Geometry, Instance, PatchMesh, Sphere, TriangleMesh, World,
};
use sahl_math::{Ray, Transform, Vec3};

use super::Random;

/// Triangles that have nothing to do with each other.
pub(crate) fn soup(random: &mut Random, count: usize, size: f32) -> TriangleMesh {
    let mut positions = Vec::new();
    for _ in 0..count {
        let center = random.point(1.0);
        positions.extend((0..3).map(|_| center + random.point(size)));
    }
    loose_triangles(positions)
}

/// One triangle from each three vertices.
pub(crate) fn loose_triangles(positions: Vec<Vec3>) -> TriangleMesh {
    let indices: Vec<[u32; 3]> =
        (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh { indices: indices.into(), positions: positions.into() }
}

/// A rotation, an uneven scale with a reflection, and a translation.
pub(crate) fn placement(random: &mut Random) -> Transform {
    let moved = random.point(1.0);
    let axis: [f32; 3] = random.direction().into();
    let scale = [random.range(0.1, 0.6), random.range(0.1, 0.6), random.range(-0.6, -0.1)].map(f64::from);
    let turned =
        Transform::rotate(f64::from(random.range(0.0, 6.0)), axis.map(f64::from)).expect("a regular matrix");
    let turned = turned
        .after(&Transform::scale(scale[0], scale[1], scale[2]).expect("a regular matrix"))
        .expect("a regular matrix");
    Transform::translate(f64::from(moved.x), f64::from(moved.y), f64::from(moved.z))
        .expect("a regular matrix")
        .after(&turned)
        .expect("a regular matrix")
}

fn quadrics(random: &mut Random) -> Vec<Geometry> {
    let mut geometries = Vec::new();
    for i in 0..8 {
        let phi_max = if i % 2 == 0 { TAU } else { 2.5 };
        let (z_min, z_max) = if i % 3 == 0 { (-1.0, 1.0) } else { (0.7, -0.2) };
        let to_parent = placement(random);
        geometries.push(Geometry::Sphere(Sphere { radius: 1.0, z_min, z_max, phi_max, to_parent }));
        let to_parent = placement(random);
        geometries.push(Geometry::Cylinder(Cylinder { radius: 0.8, z_min, z_max, phi_max, to_parent }));
        let inner_radius = if i % 3 == 0 { 0.4 } else { 0.0 };
        let to_parent = placement(random);
        geometries.push(Geometry::Disk(Disk { height: 0.1, radius: 1.0, inner_radius, phi_max, to_parent }));
    }
    geometries
}

/// Curves of a kind, wide against their length or thin, some straight, some closed.
pub(crate) fn curves(random: &mut Random, kind: CurveKind, count: usize, to_parent: Transform) -> CurveSet {
    let mut points = Vec::new();
    for i in 0..count {
        let (from, step) = (random.point(0.8), random.direction() * 0.3);
        points.push(match i % 4 {
            0 => [from, from + step, from + step * 2.0, from + step * 3.0],
            1 => [from, random.point(0.8), random.point(0.8), from],
            _ => [from, random.point(0.8), random.point(0.8), random.point(0.8)],
        });
    }
    let widths: Vec<[f32; 2]> =
        (0..count).map(|_| [random.range(0.01, 0.2), random.range(0.0, 0.1)]).collect();
    let normals: Vec<[Vec3; 2]> =
        (0..count).map(|_| [random.direction(), random.direction() * 3.0]).collect();
    let normals = if kind == CurveKind::Ribbon { normals } else { Vec::new() };
    CurveSet {
        kind,
        points: points.into(),
        widths: widths.into(),
        normals: normals.into(),
        split_depth: count as u32 % 4,
        to_parent,
    }
}

/// All kinds of shapes, two groups and instances of them.
pub(crate) fn zoo(random: &mut Random) -> World {
    let mut geometries = quadrics(random);
    for (i, kind) in [CurveKind::Flat, CurveKind::Cylinder, CurveKind::Ribbon].into_iter().enumerate() {
        let to_parent = placement(random);
        geometries.push(Geometry::Curves(curves(random, kind, 5 + i, to_parent)));
    }
    let instances = (0..12).map(|i| Instance { group: i % 2, to_world: placement(random).into() }).collect();
    geometries.push(Geometry::Triangles(soup(random, 60, 0.4)));
    let corners: Vec<Vec3> = (0..80).map(|_| random.point(1.0)).collect();
    let mut indices: Vec<[u32; 4]> = (0..20).map(|i| [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3]).collect();
    let mut positions = corners;
    // Some that are flat.
    for _ in 0..10 {
        let (p, a, b) = (random.point(1.0), random.point(0.5), random.point(0.5));
        let first = positions.len() as u32;
        positions.extend([p, p + a, p + b, p + a + b]);
        indices.push([first, first + 1, first + 2, first + 3]);
    }
    geometries.push(Geometry::Patches(PatchMesh { indices: indices.into(), positions: positions.into() }));
    let all: Vec<u32> = (0..geometries.len() as u32).collect();
    World {
        groups: vec![all[..10].to_vec(), all[10..].to_vec()],
        world: all,
        geometries,
        instances,
        ..World::default()
    }
}

/// Rays from the cube of half edge `half`: some along an axis, some in a plane of two, some with an interval.
pub(crate) fn rays(random: &mut Random, count: usize, half: f32) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let origin = random.point(half);
            let direction = match i % 4 {
                0 => [Vec3::X, -Vec3::Y, Vec3::Z][i / 4 % 3],
                1 => Vec3::new(random.range(-1.0, 1.0), 0.0, random.range(-1.0, 1.0)),
                _ => random.direction() * random.range(0.01, 10.0),
            };
            let ray = Ray::new(origin, direction);
            if i % 3 == 0 { Ray { t_min: 0.1, t_max: random.range(0.0, 2.0 * half), ..ray } } else { ray }
        })
        .collect()
}

/// Rays from one point through a grid, eight by eight in a row, as a camera shoots them.
pub(crate) fn camera_rays(origin: Vec3, target: Vec3, tiles: usize, width: f32) -> Vec<Ray> {
    let forward = target - origin;
    let helper = if forward.x.abs() < forward.z.abs() { Vec3::X } else { Vec3::Z };
    let right = forward.cross(helper).normalize() * width;
    let up = right.cross(forward).normalize() * width;
    let step = |i: usize| (i as f32 + 0.5) / (8 * tiles) as f32 - 0.5;
    let mut rays = Vec::with_capacity(64 * tiles * tiles);
    for tile in 0..tiles * tiles {
        for pixel in 0..64 {
            let (x, y) = (tile % tiles * 8 + pixel % 8, tile / tiles * 8 + pixel / 8);
            rays.push(Ray::new(origin, forward + right * step(x) + up * step(y)));
        }
    }
    rays
}

/// Rays at the vertices, edges and planes of a mesh: through them, along them, and from them.
pub(crate) fn rays_at(random: &mut Random, mesh: &TriangleMesh, count: usize, half: f32) -> Vec<Ray> {
    let pick = |random: &mut Random| {
        let face = mesh.indices[random.below(mesh.indices.len())];
        face.map(|vertex| mesh.positions[vertex as usize])
    };
    (0..count)
        .map(|i| {
            let [p, q, r] = pick(random);
            let inside = (p + q + r) * (1.0 / 3.0);
            let origin = random.point(half);
            match i % 8 {
                0 => Ray::new(origin, p - origin),
                1 => Ray::new(origin, (p + q) * 0.5 - origin),
                2 => Ray::new(p, q - p),
                3 => Ray::new(p - (q - p), q - p),
                4 => Ray::new(inside, random.direction()),
                5 => Ray::new(p, origin - p),
                6 => {
                    let mut aligned = p;
                    aligned[i / 8 % 3] = -half;
                    Ray::new(aligned, [Vec3::X, Vec3::Y, Vec3::Z][i / 8 % 3])
                }
                _ => Ray { t_max: 1.0, ..Ray::new(p, pick(random)[0] - p) },
            }
        })
        .collect()
}

/// Rays that are hardly any, or none: of extreme length, with odd intervals, not finite.
pub(crate) fn nasty_rays(random: &mut Random, count: usize, half: f32) -> Vec<Ray> {
    let odd = [0.0, -0.0, -1.0, 1e-30, 1e30, f32::MIN_POSITIVE, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    let lengths = [1e-30, 1e-20, 1e-6, 1e6, 1e20, 1e30];
    (0..count)
        .map(|i| {
            let ray = Ray::new(random.point(half), random.direction());
            let some = |random: &mut Random| odd[random.below(odd.len())];
            let axis = random.below(3);
            let mut nasty = ray;
            match i % 8 {
                0 => nasty.direction = ray.direction * lengths[random.below(lengths.len())],
                1 => nasty.t_min = some(random),
                2 => nasty.t_max = some(random),
                3 => nasty.direction[axis] = some(random),
                4 => nasty.origin[axis] = some(random),
                5 => nasty.direction = Vec3::ZERO,
                6 => (nasty.t_min, nasty.t_max) = (some(random), some(random)),
                _ => (nasty.direction[axis], nasty.direction[(axis + 1) % 3]) = (0.0, -0.0),
            }
            nasty
        })
        .collect()
}
