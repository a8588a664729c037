//! Noise of a thousand lights, against one light of the same shape and against choosing all of them alike.

use sahl_math::{Transform, Vec3};
use sahl_scene::{Geometry, Integrator, LightSampler, Origin, PatchMesh, PathTracer, SceneDesc};

use crate::common::*;

/// Half the length and half the width of the strip of light.
const STRIP: [f32; 2] = [40.0, 0.15];

/// A long hall with a strip of light under its ceiling, of `parts` emitters, seen along a stretch of its floor and the boxes
/// that stand there.
fn hall(parts: usize, samples: u32, seed: u32) -> SceneDesc {
    let mut scene = empty(16, samples);
    scene.sampler.seed = u64::from(seed);
    let material = diffuse(&mut scene, 0.5);
    let floor =
        patch(&mut scene, [[-50.0, -3.0, 0.0], [50.0, -3.0, 0.0], [-50.0, 3.0, 0.0], [50.0, 3.0, 0.0]]);
    add(&mut scene, floor, material);
    for i in 0..8 {
        let (x, y) = (i as f64 * 0.45 - 1.6, if i % 2 == 0 { 0.6 } else { -0.7 });
        let placed = Transform::translate(x, y, 0.2).unwrap();
        add_placed(&mut scene, sphere(0.2), material, placed);
    }
    let black = diffuse(&mut scene, 0.0);
    let strip = strip(&mut scene, parts);
    let strip = add(&mut scene, strip, black);
    emit(&mut scene, strip, 5.0);
    scene.camera.camera_to_world =
        Transform::look_at([0.0, -2.5, 1.2], [0.0, 0.0, 0.1], [0.0, 0.0, 1.0]).unwrap().inverse();
    scene
}

/// A strip along x at height 2 that shines down, cut into equal rectangles.
fn strip(scene: &mut SceneDesc, parts: usize) -> Geometry {
    let [length, width] = STRIP;
    let mut mesh = (Vec::new(), Vec::new());
    for i in 0..=parts {
        let x = (2.0 * i as f32 / parts as f32 - 1.0) * length;
        mesh.1.extend([Vec3::new(x, width, 2.0), Vec3::new(x, -width, 2.0)]);
        if i > 0 {
            let first = 2 * i as u32 - 2;
            mesh.0.push([first, first + 2, first + 1, first + 3]);
        }
    }
    let mesh = PatchMesh { indices: mesh.0.into(), positions: mesh.1.into(), ..PatchMesh::default() };
    Geometry::Patches(scene.patch_meshes.push(mesh, Origin::default()))
}

fn image(parts: usize, samples: u32, seed: u32, light_sampler: LightSampler) -> Vec<f32> {
    let mut scene = hall(parts, samples, seed);
    scene.integrator = Integrator::Path(PathTracer { max_depth: 1, light_sampler, ..PathTracer::default() });
    values(&rendered(&scene).film.develop()).iter().step_by(3).copied().collect()
}

/// The mean of the squared relative error over pixels and seeds.
fn error(reference: &[f32], render: impl Fn(u32) -> Vec<f32>) -> f64 {
    const SEEDS: u32 = 3;
    let mut sum = 0.0;
    for seed in 0..SEEDS {
        for (found, expected) in render(seed + 1).iter().zip(reference) {
            let relative = f64::from(found - expected) / (f64::from(*expected) + 0.01);
            sum += relative * relative;
        }
    }
    sum / f64::from(SEEDS) / reference.len() as f64
}

#[test]
fn a_thousand_lights_are_nearly_as_quiet_as_one() {
    let reference = image(1, 4096, 99, LightSampler::Tree);
    let one = error(&reference, |seed| image(1, 64, seed, LightSampler::Tree));
    let tree = error(&reference, |seed| image(1000, 64, seed, LightSampler::Tree));
    let uniform = error(&reference, |seed| image(1000, 64, seed, LightSampler::Uniform));
    println!("relative squared error: one light {one:.3e}, tree {tree:.3e}, uniform {uniform:.3e}");
    assert!(tree < 1.5 * one, "{tree:.3e} against {one:.3e}");
    assert!(tree * 10.0 < uniform, "{tree:.3e} against {uniform:.3e}");
}
