//! What building a scene says, counts and refuses.

use std::sync::Arc;

use crate::common::*;
use sahl_image::Image;
use sahl_math::{Transform, Vec3};
use sahl_render::{BuildOptions, build};
use sahl_scene::{
    ConductorReflectance, Diagnostics, FileId, Instance, Light, Material, Object, Origin, Radiance,
    Roughness, SceneDesc, Severity, Span, Spectrum, SpectrumParam,
};

fn codes(diagnostics: &Diagnostics) -> Vec<(Severity, &'static str)> {
    diagnostics.iter().map(|diagnostic| (diagnostic.severity, diagnostic.code)).collect()
}

fn span() -> Span {
    let file: FileId = sahl_scene::Sources::default().add("a.pbrt", "text".as_bytes());
    Span { file, start: 1, end: 3 }
}

/// A floor under a sky: nothing to complain about.
fn floor() -> SceneDesc {
    let mut scene = empty(4, 1);
    let material = diffuse(&mut scene, 0.5);
    let geometry = quad(&mut scene, square(1.0, 0.0));
    add(&mut scene, geometry, material);
    sky(&mut scene, grey(1.0));
    scene
}

#[test]
fn a_good_scene_is_built_without_a_word() {
    let mut scene = floor();
    let material = diffuse(&mut scene, 0.5);
    let geometry = patch(&mut scene, square(1.0, 1.0));
    let lamp = add(&mut scene, geometry, material);
    emit(&mut scene, lamp, 1.0);
    let geometry = quad(&mut scene, square(1.0, 2.0));
    let lamp = add(&mut scene, geometry, material);
    emit(&mut scene, lamp, 1.0);
    add(&mut scene, sphere(1.0), material);
    let (built, diagnostics) = build(&scene, &BuildOptions::default());
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let stats = built.unwrap().stats();
    assert_eq!((stats.triangles, stats.patches, stats.quadrics), (4, 1, 1));
    assert_eq!((stats.materials, stats.lights, stats.instances), (2, 4, 0));
    // 3 meshes of 4 vertices, and their indices.
    assert_eq!(stats.data_bytes, 3 * 4 * 12 + 2 * 2 * 12 + 16);
}

#[test]
fn errors_leave_no_scene() {
    let mut scene = floor();
    scene.world.push(sahl_scene::Handle::new(99));
    let (built, diagnostics) = build(&scene, &BuildOptions::default());
    assert!(built.is_none() && diagnostics.has_errors());

    let mut scene = floor();
    let light = Light::Point {
        intensity: Spectrum::Named("stdilum-D65".into()),
        scale: 1.0,
        power: None,
        position: Vec3::ONE,
    };
    scene.lights.push(light, Origin::at(span()));
    let (built, diagnostics) = build(&scene, &BuildOptions::default());
    assert!(built.is_none());
    let error = diagnostics.iter().find(|d| d.severity == Severity::Error).unwrap();
    assert_eq!((error.code, error.span), ("unknown-spectrum", Some(span())));
    assert_eq!(error.help.as_deref(), Some("did you mean `stdillum-D65`?"));
}

#[test]
fn an_equal_area_sky_has_to_be_square_and_a_sheared_one_is_told() {
    for (size, transform, expected) in [
        ([4, 2], Transform::IDENTITY, vec![(Severity::Error, "environment-not-square")]),
        ([4, 4], Transform::scale(1.0, 2.0, 1.0).unwrap(), vec![(Severity::Warning, "environment-deformed")]),
        ([4, 4], Transform::scale(-2.0, 2.0, 2.0).unwrap(), vec![]),
    ] {
        let mut scene = floor();
        let image = Image::filled(size[0], size[1], 3, 1.0).unwrap();
        let image = scene.images.push(Arc::new(image), Origin::default());
        let light = Light::Infinite {
            radiance: Radiance::EqualArea(image),
            scale: 1.0,
            illuminance: None,
            light_to_world: transform,
            portal: None,
        };
        scene.lights.push(light, Origin::at(span()));
        let (built, diagnostics) = build(&scene, &BuildOptions::default());
        assert_eq!(codes(&diagnostics), expected);
        assert_eq!(built.is_none(), diagnostics.has_errors());
    }
}

#[test]
fn portals_are_rectangles_that_face_out_of_the_room() {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[x, y]| Vec3::new(x, y, 9.0));
    let [p0, p1, p2, p3] = corners;
    let turned = (Severity::Warning, "portal-orientation");
    let crossed = (Severity::Error, "portal-shape");
    let cases = [(corners, vec![]), ([p0, p3, p2, p1], vec![turned]), ([p0, p2, p1, p3], vec![crossed])];
    for (corners, expected) in cases {
        let mut scene = floor();
        let Light::Infinite { portal, .. } = &mut scene.lights[sahl_scene::Handle::new(0)] else { panic!() };
        *portal = Some(corners);
        let (built, diagnostics) = build(&scene, &BuildOptions::default());
        assert_eq!(codes(&diagnostics), expected);
        assert_eq!(built.is_none(), diagnostics.has_errors());
    }
}

#[test]
fn lamps_in_objects_are_dropped_with_a_warning() {
    let mut scene = floor();
    let material = diffuse(&mut scene, 0.5);
    let lamp = add(&mut scene, sphere(0.5), material);
    emit(&mut scene, lamp, 1.0);
    scene.world.pop();
    let object = scene.objects.push(Object { shapes: vec![lamp] }, Origin::default());
    for x in [0.0, 5.0] {
        let object_to_world = Transform::translate(x, 0.0, 0.0).unwrap();
        scene.instances.push(Instance::new(object, object_to_world), Origin::default());
    }
    let (built, diagnostics) = build(&scene, &BuildOptions::default());
    assert_eq!(codes(&diagnostics), [(Severity::Warning, "instanced-area-light")]);
    let stats = built.unwrap().stats();
    assert_eq!((stats.instances, stats.quadrics, stats.lights), (2, 1, 1));
}

#[test]
fn what_rgb_cannot_tell_is_told() {
    let mut scene = floor();
    let named = |name: &str| SpectrumParam::Constant(Spectrum::Named(name.into()));
    // Metals by name are averages of their measured curves, and give no warning.
    let copper = Material::Conductor {
        reflectance: ConductorReflectance::Index { eta: named("metal-Cu-eta"), k: named("metal-Cu-k") },
        roughness: Roughness::SMOOTH,
    };
    scene.materials.push(copper, Origin::at(span()));
    let glass =
        Material::Dielectric { eta: Spectrum::Named("glass-F11".into()), roughness: Roughness::SMOOTH };
    scene.materials.push(glass, Origin::at(span()));
    let samples = vec![(400.0, 0.2), (700.0, 0.8)];
    let reflectance = SpectrumParam::Constant(Spectrum::Sampled(samples));
    scene.materials.push(Material::Diffuse { reflectance }, Origin::at(span()));
    let (built, diagnostics) = build(&scene, &BuildOptions::default());
    assert!(built.is_some());
    assert_eq!(codes(&diagnostics), [(Severity::Warning, "spectrum-approximated"); 2]);
    assert!(diagnostics.iter().all(|diagnostic| diagnostic.span == Some(span())));
}

#[test]
fn a_scene_without_anything_renders_black() {
    let scene = empty(3, 1);
    let (built, _) = build(&scene, &BuildOptions::default());
    let rendered = sahl_render::render(&built.unwrap(), &sahl_render::RenderOptions::default(), &());
    assert!(values(&rendered.film.develop()).iter().all(|&value| value == 0.0));
}
