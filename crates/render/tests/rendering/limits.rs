//! What is asked for without measure is bounded, and told.

use crate::common::*;
use sahl_render::{BuildOptions, RenderOptions, build, render};
use sahl_scene::{
    ConductorReflectance, Film, Integrator, Material, Origin, Roughness, Spectrum, SpectrumParam,
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
