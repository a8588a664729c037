//! Cameras by what they measure: under a sky that is the same everywhere every picture is known.

use std::f64::consts::PI;

use crate::common::*;
use sahl_math::{AnimatedTransform, Transform};

use sahl_render::{Aov, RenderOptions, render};
use sahl_scene::{Aperture, Camera, Filter, LensElement, LensSystem, Projection, SceneDesc, SphereLayout};

/// Nothing but a sky of radiance two.
fn under_the_sky(camera: Camera) -> SceneDesc {
    let mut scene = empty(8, 64);
    scene.camera = camera;
    sky(&mut scene, grey(2.0));
    scene
}

#[test]
fn a_uniform_sky_is_uniform_in_every_projection() {
    let lens = Camera { lens_radius: 0.4, focal_distance: 3.0, ..Camera::default() };
    for camera in [
        Camera::default(),
        lens.clone(),
        Camera { projection: Projection::Orthographic, ..lens },
        Camera { projection: Projection::Spherical(SphereLayout::EqualArea), ..Camera::default() },
        Camera { projection: Projection::Spherical(SphereLayout::Equirectangular), ..Camera::default() },
    ] {
        for filter in [Filter::Box { radius: [0.5; 2] }, Filter::Box { radius: [2.0; 2] }] {
            let mut scene = under_the_sky(camera.clone());
            scene.filter = filter;
            for &value in values(&rendered(&scene).film.develop()) {
                assert!((value - 2.0).abs() < 1e-5, "{:?} {value}", camera.projection);
            }
        }
    }
}

/// A lens of one glass and a stop right behind it, which is its own exit pupil.
fn simple_lens(aperture_diameter: f32) -> LensSystem {
    let element =
        |curvature_radius, thickness, eta| LensElement { curvature_radius, thickness, eta, diameter: 0.03 };
    LensSystem {
        elements: vec![element(0.05, 0.006, 1.5), element(-0.05, 0.001, 1.0), element(0.0, 0.0, 1.0)],
        aperture_diameter,
        aperture: Aperture::Round,
        focus_distance: 5.0,
    }
}

#[test]
fn glass_casts_the_irradiance_of_its_exit_pupil() {
    for diameter in [0.006, 0.012] {
        let projection = Projection::Realistic(simple_lens(diameter));
        let mut scene = under_the_sky(Camera { projection, ..Camera::default() });
        // A film of a few millimetres: all of it is near the axis.
        scene.film.diagonal = 0.004;
        let (found, deviation) = mean(&scene);
        // π L r² / (r² + Z²), Z being the distance of the stop from the film: by the lensmaker's formula 51.0 mm of focal length, an image
        // 51.5 mm behind the principal plane, which lies 3.0 mm before the stop.
        let (radius, z) = (f64::from(diameter) * 0.5, 0.0485);
        let expected = 2.0 * PI * radius * radius / (radius * radius + z * z);
        assert!((found / expected - 1.0).abs() < 0.04, "{found} ± {deviation}, not {expected}");
    }
}

#[test]
fn a_shaped_stop_lets_as_much_light_through_as_a_round_one() {
    let brightness = |aperture| {
        let lens = LensSystem { aperture, ..simple_lens(0.008) };
        let mut scene =
            under_the_sky(Camera { projection: Projection::Realistic(lens), ..Camera::default() });
        scene.film.diagonal = 0.004;
        mean(&scene).0
    };
    let round = brightness(Aperture::Round);
    for shape in [Aperture::Gaussian, Aperture::Square, Aperture::Pentagon, Aperture::Star] {
        let shaped = brightness(shape);
        assert!((shaped / round - 1.0).abs() < 0.05, "{shape:?}: {shaped}, not {round}");
    }
}

#[test]
fn a_lens_focuses_where_it_says() {
    // The image of a small bright disk in the plane of focus is 1.2 pixels wide and lies on four; out of focus it is blurred over five.
    let mut scene = empty(16, 64);
    scene.film.diagonal = 0.02;
    let black = diffuse(&mut scene, 0.0);
    let to_world = Transform::translate(0.0, 0.0, 5.0).unwrap();
    let disk = sahl_scene::Geometry::Disk {
        height: 0.0,
        radius: 0.05,
        inner_radius: 0.0,
        phi_max: std::f32::consts::TAU,
    };
    let disk = add_placed(&mut scene, disk, black, to_world);
    emit(&mut scene, disk, 1.0);
    scene.shapes[disk].area_light =
        scene.shapes[disk].area_light.clone().map(|light| sahl_scene::AreaLight { two_sided: true, ..light });
    let lit = |focus_distance: f32, scene: &mut SceneDesc| {
        let lens = LensSystem { focus_distance, ..simple_lens(0.012) };
        scene.camera.projection = Projection::Realistic(lens);
        let image = rendered(scene).film.develop();
        let brightest = values(&image).iter().copied().fold(0.0, f32::max);
        values(&image).iter().step_by(3).filter(|&&value| value > 0.02 * brightest).count()
    };
    let (sharp, blurred) = (lit(5.0, &mut scene), lit(0.3, &mut scene));
    assert!(sharp <= 8 && blurred > 2 * sharp, "{sharp} {blurred}");
}

#[test]
fn blocked_samples_are_black_in_features_too() {
    // A stop so far behind the glass that the corners of the film see its rim through it.
    let mut lens = simple_lens(0.01);
    lens.elements[1].thickness = 0.03;
    let mut scene = under_the_sky(Camera { projection: Projection::Realistic(lens), ..Camera::default() });
    scene.film.diagonal = 0.1;
    let options =
        RenderOptions { threads: 1, aovs: vec![Aov::Depth, Aov::Albedo], ..RenderOptions::default() };
    let film = render(&built(&scene), &options, &()).film;
    assert!(values(&film.develop()).iter().all(|value| value.is_finite()));
    assert_eq!(values(&film.develop())[0], 0.0);
}

#[test]
fn a_moving_camera_sees_each_place_for_its_time() {
    // The camera looks down on a light that covers x > 0, through a keyhole, and passes from x = −1 to x = 3.
    let mut scene = empty(4, 256);
    let material = diffuse(&mut scene, 0.0);
    let plane = patch(&mut scene, [[0.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0], [9.0, 9.0, 0.0]]);
    let plane = add(&mut scene, plane, material);
    emit(&mut scene, plane, 2.0);
    look_down(&mut scene, 5.0, 1e-3);
    let placed = scene.camera.camera_to_world;
    let ends = [-1.0, 3.0].map(|x| Transform::translate(x, 0.0, 0.0).unwrap().after(&placed).unwrap());
    scene.camera.camera_to_world = ends[0];
    expect_mean(&scene, 0.0, 0.0, "a camera that stands beside the light");
    scene.camera.motion = AnimatedTransform::new(ends[0], ends[1], [0.0, 1.0]).map(Box::new);
    expect_mean(&scene, 1.5, 0.01, "a camera that passes over it");
}
