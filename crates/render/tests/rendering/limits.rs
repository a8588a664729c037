//! What is asked for without measure is bounded, and told.

use crate::common::*;
use sahl_math::Transform;
use sahl_render::{BuildOptions, RenderOptions, build, render};
use sahl_scene::{
    ConductorReflectance, Film, Integrator, Material, Origin, PathTracer, Roughness, Spectrum, SpectrumParam,
};

#[test]
fn whitted_ends_between_perfect_mirrors() {
    let mut scene = empty(2, 1);
    let reflectance = ConductorReflectance::Normal(SpectrumParam::Constant(Spectrum::Constant(1.0)));
    let mirror = Material::Conductor { reflectance, roughness: Roughness::SMOOTH };
    let mirror = scene.materials.push(mirror, Origin::default());
    add(&mut scene, sphere(1.0), mirror);
    scene.integrator = Integrator::Whitted { max_depth: u32::MAX };
    let (built, diagnostics) = build(&scene, &BuildOptions::default());
    assert!(diagnostics.iter().any(|diagnostic| diagnostic.code == "depth-limited"));
    let built = built.expect("warnings do not stop a build");
    for threads in [1, 2] {
        let rendered = render(&built, &RenderOptions { threads, ..RenderOptions::default() }, &());
        assert!(rendered.completed);
        assert!(rendered.status.rays > 256, "{} rays", rendered.status.rays);
    }
}

#[test]
fn a_host_of_threads_is_not_started() {
    let mut scene = empty(40, 1);
    let material = diffuse(&mut scene, 0.5);
    add(&mut scene, sphere(1.0), material);
    let rendered =
        render(&built(&scene), &RenderOptions { threads: usize::MAX, ..RenderOptions::default() }, &());
    assert!(rendered.completed);
}

#[test]
fn an_image_that_fits_no_memory_is_an_error() {
    let mut scene = empty(1, 1);
    scene.film.resolution = [1 << 15, 1 << 14];
    assert!(u64::from(scene.film.resolution[0]) * u64::from(scene.film.resolution[1]) > Film::MOST_PIXELS);
    let (built, diagnostics) = build(&scene, &BuildOptions::default());
    assert!(built.is_none() && diagnostics.has_errors());
}

#[test]
fn what_overflows_on_the_film_is_dropped_everywhere_alike() {
    let mut scene = empty(4, 3);
    sky(&mut scene, grey(1e37));
    scene.film.exposure = 100.0;
    let scene = built(&scene);
    let rendered = render(&scene, &RenderOptions::default(), &());
    assert_eq!(rendered.film.dropped(), 4 * 4 * 3);
    assert!(values(&rendered.film.develop()).iter().all(|&value| value == 0.0));
    assert!(!scene.sample([0, 0], 0).is_kept);
}

#[test]
fn clamping_leaves_direct_light_alone() {
    let lit = |settings: PathTracer| {
        let mut scene = empty(12, 16);
        look_down(&mut scene, 3.0, 1.0);
        let paper = diffuse(&mut scene, 0.7);
        let floor = patch(&mut scene, square(4.0, 0.0));
        add(&mut scene, floor, paper);
        add_placed(&mut scene, sphere(0.5), paper, Transform::translate(0.0, 0.0, 0.5).unwrap());
        sky(&mut scene, grey(1.0));
        scene.integrator = Integrator::Path(settings);
        values(&rendered(&scene).film.develop()).to_vec()
    };
    let free = lit(PathTracer::default());
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<u32>>();
    let loose = lit(PathTracer { clamp_indirect: Some(1e30), ..PathTracer::default() });
    assert!(bits(&free) == bits(&loose), "a limit that nothing reaches changes nothing");
    let tight = lit(PathTracer { clamp_indirect: Some(1e-6), ..PathTracer::default() });
    let direct = lit(PathTracer { max_depth: 1, ..PathTracer::default() });
    assert!(tight.iter().zip(&direct).all(|(tight, direct)| (tight - direct).abs() < 1e-4));
    assert!(free.iter().sum::<f32>() > 1.02 * tight.iter().sum::<f32>());
}

#[test]
fn only_light_that_was_spread_sees_rougher_mirrors() {
    let lit = |regularize: bool, mirrored: bool| {
        let mut scene = empty(12, 64);
        look_down(&mut scene, 3.0, 0.4);
        let reflectance = ConductorReflectance::Normal(SpectrumParam::Constant(Spectrum::Constant(0.9)));
        let mirror = Material::Conductor { reflectance, roughness: Roughness::SMOOTH };
        let mirror = scene.materials.push(mirror, Origin::default());
        let paper = diffuse(&mut scene, 0.7);
        let (floor, wall) = (patch(&mut scene, square(1.0, 0.0)), patch(&mut scene, square(0.6, 0.7)));
        add(&mut scene, floor, if mirrored { mirror } else { paper });
        // A mirror that faces down and is not in the camera's way.
        let aside = Transform::translate(1.2, 0.0, 0.0).unwrap();
        let wall = add_placed(&mut scene, wall, mirror, aside);
        scene.shapes[wall].reverse_orientation = true;
        let lamp = patch(&mut scene, square(0.2, 2.0));
        let lamp = add_placed(&mut scene, lamp, paper, Transform::translate(-1.0, 0.0, 0.0).unwrap());
        scene.shapes[lamp].reverse_orientation = true;
        emit(&mut scene, lamp, 5.0);
        scene.integrator = Integrator::Path(PathTracer { regularize, ..PathTracer::default() });
        values(&rendered(&scene).film.develop()).to_vec()
    };
    assert_eq!(lit(false, true), lit(true, true), "mirrors alone spread nothing");
    assert_ne!(lit(false, false), lit(true, false));
}
