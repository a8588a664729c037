//! OpenPBR surfaces that emit.

use crate::common::*;
use sahl_render::{BuildOptions, build};
use sahl_scene::{
    ColorMode, FloatParam, Handle, Integrator, Material, OpenPbr, Origin, Relief, SceneDesc, Shape,
    SpectrumParam,
};

/// A surface that emits three units of white.
fn glowing() -> OpenPbr {
    OpenPbr {
        emission_luminance: 3.0,
        emission_color: SpectrumParam::Constant(grey(1.0)),
        ..OpenPbr::default()
    }
}

/// A surface that emits through a coat of which light that passes twice keeps a quarter.
fn coated() -> OpenPbr {
    let number = FloatParam::Constant;
    OpenPbr {
        coat_weight: number(1.0),
        coat_color: SpectrumParam::Constant(grey(0.25)),
        coat_ior: number(1.6),
        ..glowing()
    }
}

fn open_pbr(scene: &mut SceneDesc, surface: OpenPbr) -> Handle<Material> {
    scene.materials.push(Material::OpenPbr(Box::new(surface)), Origin::default())
}

/// A floor under a square of `material` that shows it its front, seen from above beside the square.
fn lit_floor(material: impl FnOnce(&mut SceneDesc) -> Handle<Material>) -> (SceneDesc, Handle<Shape>) {
    let mut scene = empty(8, 256);
    let paper = diffuse(&mut scene, 0.5);
    let floor = quad(&mut scene, square(5.0, 0.0));
    add(&mut scene, floor, paper);
    let material = material(&mut scene);
    let lamp = quad(&mut scene, [[1.0, -1.0, 1.0], [3.0, -1.0, 1.0], [1.0, 1.0, 1.0], [3.0, 1.0, 1.0]]);
    let lamp = add(&mut scene, lamp, material);
    scene.shapes[lamp].reverse_orientation = true;
    look_down(&mut scene, 4.0, 0.5);
    (scene, lamp)
}

fn codes(scene: &SceneDesc) -> Vec<&'static str> {
    build(scene, &BuildOptions::default()).1.iter().map(|diagnostic| diagnostic.code).collect()
}

#[test]
fn a_material_that_emits_makes_area_lights() {
    let (by_material, _) = lit_floor(|scene| open_pbr(scene, glowing()));
    let (mut by_shape, lamp) =
        lit_floor(|scene| open_pbr(scene, OpenPbr { emission_luminance: 0.0, ..glowing() }));
    emit(&mut by_shape, lamp, 1.0);
    if let Some(light) = &mut by_shape.shapes[lamp].area_light {
        light.scale = 3.0;
    }
    assert!(codes(&by_material).is_empty());
    for color in [ColorMode::Rgb, ColorMode::Spectral] {
        let image = |scene: &SceneDesc| rendered(&SceneDesc { color, ..scene.clone() }).film.develop();
        assert_eq!(image(&by_material), image(&by_shape), "{color:?}");
    }
}

#[test]
fn light_passes_the_coat_once() {
    let mut scene = empty(4, 64);
    let material = open_pbr(&mut scene, coated());
    let lamp = quad(&mut scene, square(5.0, 0.0));
    add(&mut scene, lamp, material);
    look_down(&mut scene, 4.0, 0.5);
    let lost = (0.6_f64 / 2.6).powi(2);
    let (found, _) = mean(&scene);
    assert!((found - 3.0 * 0.5 * (1.0 - lost)).abs() < 0.01, "{found}");
}

#[test]
fn light_through_a_coat_is_found_alike_in_every_way() {
    let (mut scene, _) = lit_floor(|scene| open_pbr(scene, coated()));
    scene.integrator = path(1);
    let by_both = mean(&scene);
    scene.integrator = Integrator::Whitted { max_depth: 1 };
    let by_light = mean(&scene);
    let noise = by_both.1.hypot(by_light.1);
    assert!((by_both.0 - by_light.0).abs() < 4.5 * noise, "{by_both:?} {by_light:?}");
    assert!(noise < 0.01 * by_both.0);
}

#[test]
fn emission_that_is_not_shown_is_reported() {
    let (mut twice, lamp) = lit_floor(|scene| open_pbr(scene, glowing()));
    emit(&mut twice, lamp, 3.0);
    assert_eq!(codes(&twice), ["second-emission"]);
    let (mut mixed, lamp) = lit_floor(|scene| {
        let parts = [open_pbr(scene, glowing()), diffuse(scene, 0.5)];
        let amount = FloatParam::Constant(0.5);
        scene.materials.push(Material::Mix { materials: parts, amount }, Origin::default())
    });
    sky(&mut mixed, grey(1.0));
    assert_eq!(codes(&mixed), ["mixed-emission"]);
    // It has the area light that it would be told to have.
    emit(&mut mixed, lamp, 3.0);
    assert_eq!(codes(&mixed), ["second-emission"]);
}

#[test]
fn bumps_leave_emission_as_it_is() {
    let (mut plain, _) = lit_floor(|scene| open_pbr(scene, glowing()));
    let (mut bumpy, _) = lit_floor(|scene| {
        let material = open_pbr(scene, glowing());
        let relief = Relief::Bump(FloatParam::Constant(1.0));
        scene.materials.push(Material::Relief { material, relief }, Origin::default())
    });
    assert!(codes(&bumpy).is_empty());
    plain.integrator = path(1);
    bumpy.integrator = path(1);
    assert_eq!(rendered(&plain).film.develop(), rendered(&bumpy).film.develop());
}
