//! Coarse meshes with the normals of spheres, lit as spheres are.

use std::f64::consts::PI;

use sahl_math::{Transform, Vec3};
use sahl_scene::{Geometry, Integrator, Light, Origin, PatchMesh, PathTracer, SceneDesc, TriangleMesh};

use crate::common::*;

const ALBEDO: f32 = 0.6;

/// The unit sphere as an octahedron whose faces were cut in four twice, with the sphere's normals: 128 triangles.
fn coarse_sphere(scene: &mut SceneDesc) -> Geometry {
    let corner = |axis: usize, sign: f32| {
        let mut v = Vec3::ZERO;
        v[axis] = sign;
        v
    };
    let mut faces = Vec::new();
    for octant in 0..8 {
        let sign = |axis: usize| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let [a, b, c] = [0, 1, 2].map(|axis| corner(axis, sign(axis)));
        faces.push(if sign(0) * sign(1) * sign(2) > 0.0 { [a, b, c] } else { [a, c, b] });
    }
    for _ in 0..2 {
        let cut = |[a, b, c]: [Vec3; 3]| {
            let (ab, bc, ca) = ((a + b).normalize(), (b + c).normalize(), (c + a).normalize());
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(cut).collect();
    }
    let positions: Vec<Vec3> = faces.iter().flatten().copied().collect();
    let indices: Vec<[u32; 3]> = (0..faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = TriangleMesh {
        indices: indices.into(),
        normals: Some(positions.clone().into()),
        positions: positions.into(),
        ..TriangleMesh::default()
    };
    Geometry::Triangles(scene.triangle_meshes.push(mesh, Origin::default()))
}

/// The sphere, turned so that nothing lies along an axis, seen from above.
fn sphere_scene(samples: u32) -> SceneDesc {
    let mut scene = empty(32, samples);
    let material = diffuse(&mut scene, ALBEDO);
    let mesh = coarse_sphere(&mut scene);
    let turned = Transform::rotate(0.7, [0.3, 0.8, 0.5]).unwrap();
    add_placed(&mut scene, mesh, material, turned);
    look_down(&mut scene, 3.0, 0.6);
    scene
}

fn sun(scene: &mut SceneDesc, direction: Vec3) {
    let light = Light::Distant { radiance: grey(1.0), scale: 1.0, illuminance: None, direction };
    scene.lights.push(light, Origin::default());
}

/// Red of each pixel.
fn red(scene: &SceneDesc, smooth_terminator: bool, max_depth: u32) -> Vec<f32> {
    let mut scene = scene.clone();
    scene.integrator = Integrator::Path(PathTracer { max_depth, smooth_terminator, ..PathTracer::default() });
    values(&rendered(&scene).film.develop()).iter().step_by(3).copied().collect()
}

#[test]
fn a_coarse_sphere_in_a_white_sky_shows_its_albedo() {
    let mut scene = sphere_scene(64);
    sky(&mut scene, grey(1.0));
    let mean = |values: &[f32]| values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64;
    let (facets, smooth) = (red(&scene, false, 1), red(&scene, true, 1));
    println!("mean {} and {}", mean(&facets), mean(&smooth));
    // Facets lose the directions between their horizon and that of the normal.
    assert!(mean(&facets) < 0.995 * f64::from(ALBEDO), "{}", mean(&facets));
    assert!(smooth.iter().all(|&value| (value - ALBEDO).abs() < 1e-4), "{smooth:?}");
    // Nor does light come from nowhere with more bounces.
    assert!(red(&scene, true, 9).iter().all(|&value| (value - ALBEDO).abs() < 1e-4));
}

#[test]
fn grazing_light_ends_where_it_ends_on_a_sphere() {
    let mut scene = sphere_scene(16);
    let light = Vec3::new(0.96, 0.0, 0.28);
    sun(&mut scene, -light);
    // Irradiance of the sphere in the middle of each pixel.
    let expected: Vec<f64> = (0..32 * 32)
        .map(|i| {
            let at = |i: usize| 0.6 * ((f64::from(i as u32) + 0.5) / 16.0 - 1.0);
            let (x, y) = (at(i % 32), -at(i / 32));
            let z = (1.0 - x * x - y * y).sqrt();
            f64::from(ALBEDO) / PI * (0.96 * x + 0.28 * z).max(0.0)
        })
        .collect();
    let error = |found: &[f32]| {
        let sum: f64 = found.iter().zip(&expected).map(|(&a, b)| (f64::from(a) - b).powi(2)).sum();
        (sum / expected.len() as f64).sqrt()
    };
    let (facets, smooth) = (error(&red(&scene, false, 1)), error(&red(&scene, true, 1)));
    println!("root of the mean squared error: facets {facets:.4}, smooth {smooth:.4}");
    assert!(smooth < 0.25 * facets, "{smooth} and {facets}");
    assert!(smooth < 0.01 * f64::from(ALBEDO) / PI, "{smooth}");
}

/// A square of half edge one half at z = 0, whose normals are those of a hill.
fn hill(scene: &mut SceneDesc) -> Geometry {
    let positions = square(0.5, 0.0).map(Vec3::from);
    let normals = positions.map(|p| (p + Vec3::Z * 0.5).normalize());
    let mesh = PatchMesh {
        indices: [[0, 1, 2, 3]].into(),
        positions: positions.into(),
        normals: Some(normals.into()),
        ..PatchMesh::default()
    };
    Geometry::Patches(scene.patch_meshes.push(mesh, Origin::default()))
}

#[test]
fn what_lies_close_above_a_facet_keeps_its_shadow() {
    let mut scene = empty(16, 16);
    let material = diffuse(&mut scene, ALBEDO);
    let hill = hill(&mut scene);
    add(&mut scene, hill, material);
    sun(&mut scene, -Vec3::Z);
    look_down(&mut scene, 0.01, 0.3);
    assert!(red(&scene, true, 1).iter().all(|&value| value > 0.1), "light from straight above arrives");
    // A roof between the facet and the lifted points, which reach to 0.2 and more; the camera is below it.
    let roof = patch(&mut scene, square(5.0, 0.02));
    add(&mut scene, roof, material);
    assert!(red(&scene, true, 1).iter().all(|&value| value == 0.0), "no light through the roof");
}

#[test]
fn facets_without_normals_are_as_they_were() {
    let mut scene = empty(16, 8);
    let material = diffuse(&mut scene, ALBEDO);
    let floor = quad(&mut scene, square(2.0, 0.0));
    add(&mut scene, floor, material);
    add_placed(&mut scene, sphere(0.4), material, Transform::translate(0.2, 0.1, 0.3).unwrap());
    sky(&mut scene, grey(0.5));
    sun(&mut scene, Vec3::new(0.6, 0.0, -0.8));
    look_down(&mut scene, 3.0, 1.0);
    assert_eq!(red(&scene, false, 3), red(&scene, true, 3));
}
