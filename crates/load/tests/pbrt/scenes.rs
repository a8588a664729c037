//! Valid scenes: what they become.

use std::io::Write;

use sahl_image::{ColorSpace, Encoding};
use sahl_load::{Loaded, MemoryAssets, load, load_pbrt};
use sahl_math::{Transform, Vec3};
use sahl_scene::{
    Coat, ConductorReflectance, CurveKind, FloatParam, Geometry, Hair, HairColor, Light, Material,
    Projection, Radiance, Relief, Roughness, SceneDesc, Spectrum, SpectrumParam, Texture, TextureFilter,
    TextureMapping, UvMapping, Wrap,
};

use crate::support;

fn loaded(name: &str) -> Loaded {
    let loaded = load(name.as_ref(), support::assets());
    let text = loaded.diagnostics.render_text(&loaded.sources, false);
    assert!(loaded.diagnostics.is_empty(), "{name}:\n{text}");
    loaded
}

fn scene(text: &str) -> SceneDesc {
    let loaded = load_pbrt("test.pbrt", text.as_bytes().to_vec(), &MemoryAssets::default());
    let messages = loaded.diagnostics.render_text(&loaded.sources, false);
    assert!(loaded.diagnostics.is_empty(), "{messages}");
    loaded.scene
}

#[test]
fn valid_scenes_give_no_message_and_are_sound() {
    let scenes = support::scenes(support::VALID);
    assert!(scenes.len() >= 12, "{} scenes", scenes.len());
    for path in scenes {
        let loaded = loaded(&path.to_string_lossy());
        let faults = loaded.scene.validate();
        assert!(faults.is_empty(), "{}:\n{}", path.display(), faults.render_text(&loaded.sources, false));
    }
}

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

#[test]
fn transforms_compose_from_the_last_to_the_first() {
    let scene = scene("WorldBegin Translate 1 2 3 Rotate 90 0 0 1 Scale 2 1 1 Shape \"sphere\"");
    let to_world = scene.shapes.values()[0].shape_to_world;
    assert!(close(to_world.point(Vec3::X), Vec3::new(1.0, 4.0, 3.0)));
}

#[test]
fn matrices_are_listed_by_columns() {
    let scene = scene("WorldBegin Transform [ 0 1 0 0  -1 0 0 0  0 0 1 0  5 6 7 1 ] Shape \"sphere\"");
    let to_world = scene.shapes.values()[0].shape_to_world;
    assert!(close(to_world.point(Vec3::X), Vec3::new(5.0, 7.0, 7.0)));
}

#[test]
fn the_camera_looks_where_look_at_says() {
    let text = "LookAt 1 2 3  1 2 -4  0 1 0 Camera \"perspective\" \"float fov\" 60 WorldBegin
        CoordSysTransform \"camera\" Translate 0 0 7 LightSource \"point\" Shape \"sphere\"";
    let scene = scene(text);
    assert!(close(scene.camera.camera_to_world.point(Vec3::new(0.0, 0.0, 7.0)), Vec3::new(1.0, 2.0, -4.0)));
    assert_eq!(scene.camera.projection, Projection::Perspective { fov: 60_f32.to_radians() });
    let Light::Point { position, .. } = &scene.lights.values()[0] else { panic!("{:?}", scene.lights) };
    assert!(close(*position, Vec3::new(1.0, 2.0, -4.0)));
}

#[test]
fn blocks_restore_the_whole_state() {
    let scene = loaded("structure/blocks.pbrt").scene;
    let shapes = scene.shapes.values();
    let radius = |i: usize| match shapes[i].geometry {
        Geometry::Sphere { radius, .. } | Geometry::Cylinder { radius, .. } => radius,
        _ => panic!("shape {i}"),
    };
    assert_eq!([radius(0), radius(1), radius(2), radius(3)], [0.3, 0.4, 0.3, 0.3]);
    let reversed: Vec<bool> = shapes.iter().map(|shape| shape.reverse_orientation).collect();
    assert_eq!(reversed, [false, true, true, false]);
    let position = |i: usize| shapes[i].shape_to_world.point(Vec3::ZERO);
    assert!(close(position(0), Vec3::X));
    assert!(close(position(1), -Vec3::X));
    assert!(close(position(2), Vec3::Z));
    assert!(close(position(3), Vec3::X));
    let colour = |i: usize| &scene.materials[shapes[i].material];
    let blue = SpectrumParam::Constant(Spectrum::srgb([0.1, 0.2, 0.3]));
    assert_eq!(*colour(0), Material::Diffuse { reflectance: blue });
    assert_eq!(*colour(3), Material::default());
}

#[test]
fn objects_keep_their_shapes_and_instances_their_places() {
    let scene = loaded("structure/objects.pbrt").scene;
    assert!(scene.world.is_empty());
    assert_eq!(scene.objects.values()[0].shapes.len(), 2);
    let [first, second] = scene.instances.values() else { panic!("{:?}", scene.instances) };
    assert!(close(first.object_to_world.point(Vec3::X), Vec3::X));
    assert!(close(second.object_to_world.point(Vec3::X), Vec3::new(0.0, 1.0, 5.0)));
    let inner = scene.shapes.values()[1].shape_to_world;
    assert!(close(inner.point(Vec3::ZERO), Vec3::X));
}

#[test]
fn inclusion_shares_the_state_and_import_does_not() {
    let loaded = loaded("structure/included.pbrt");
    let scene = loaded.scene;
    let places: Vec<f32> =
        scene.shapes.values().iter().map(|shape| shape.shape_to_world.point(Vec3::ZERO).x).collect();
    assert_eq!(places, [0.0, 2.0, 2.0]);
    let imported = SpectrumParam::Constant(Spectrum::srgb([0.2, 0.5, 0.2]));
    let material = &scene.materials[scene.shapes.values()[2].material];
    assert_eq!(*material, Material::Diffuse { reflectance: imported });
    let names: Vec<&str> = loaded.sources.files().iter().map(|file| file.name.as_str()).collect();
    assert_eq!(
        names,
        ["structure/included.pbrt", "structure/parts/sphere.pbrt", "structure/parts/definitions.pbrt"]
    );
}

#[test]
fn film_settings_arrive() {
    let scene = loaded("film/settings.pbrt").scene;
    assert_eq!(scene.film.resolution, [64, 48]);
    assert_eq!(scene.film.crop, Some([16, 48, 5, 44]));
    assert_eq!((scene.film.max_component, scene.film.color_space), (10.0, ColorSpace::Rec2020));
    assert_eq!(scene.film.filename.as_deref(), Some("settings.exr"));
    assert_eq!((scene.film.exposure, scene.sampler.seed, scene.sampler.samples), (1.0, 7, 32));
    assert_eq!(loaded("cameras/orthographic.pbrt").scene.film.exposure, 1.0);
    let text = "Film \"rgb\" \"float iso\" 50 Camera \"perspective\" \"float shutterclose\" 0.5 WorldBegin";
    assert_eq!(self::scene(text).film.exposure, 0.25);
    let text = "Film \"rgb\" \"integer pixelbounds\" [ 10 20 30 40 ] Option \"seed\" 9 WorldBegin";
    assert_eq!(self::scene(text).film.crop, Some([10, 20, 30, 40]));
    assert_eq!(self::scene(text).sampler.seed, 9);
}

#[test]
fn textures_arrive() {
    let scene = loaded("textures/basic.pbrt").scene;
    let by_name = |name: &str| {
        let found = scene
            .textures
            .iter()
            .find(|(handle, _)| scene.textures.origin(*handle).name.as_deref() == Some(name));
        found.unwrap()
    };
    let (half, _) = by_name("half");
    let (checks, texture) = by_name("checks");
    let Texture::Checkerboard { mapping, .. } = texture else { panic!("{texture:?}") };
    let expected = UvMapping { scale: [8.0, 4.0], offset: [0.0; 2] };
    assert_eq!(*mapping, TextureMapping::Uv(expected));
    let scaled = Texture::Scale { texture: SpectrumParam::Texture(checks), scale: FloatParam::Texture(half) };
    assert_eq!(*by_name("darker").1, scaled);
    let Texture::Image(picture) = by_name("picture").1 else { panic!("no image") };
    assert_eq!((picture.wrap, picture.filter), (Wrap::Clamp, TextureFilter::Nearest));
    assert_eq!((picture.scale, picture.invert), (0.9, true));
    let image = &scene.images[picture.image];
    assert_eq!((image.width, image.encoding), (4, Encoding::Linear));
}

#[test]
fn lights_arrive() {
    let scene = loaded("lights/all.pbrt").scene;
    let lights = scene.lights.values();
    assert_eq!(lights.len(), 10);
    let Light::Spot { intensity, direction, angle, penumbra, .. } = &lights[4] else { panic!("{lights:?}") };
    assert_eq!(*intensity, Spectrum::Blackbody(4000.0));
    assert!(close(*direction, -Vec3::Z));
    assert!((angle.to_degrees() - 25.0).abs() < 1e-4 && (penumbra.to_degrees() - 8.0).abs() < 1e-4);
    let Light::Distant { illuminance, radiance, direction, .. } = &lights[5] else { panic!("{lights:?}") };
    assert_eq!((*illuminance, radiance), (Some(10.0), &Spectrum::Named("stdillum-D65".to_owned())));
    assert!(close(*direction, Vec3::Z));
    assert!(matches!(&lights[6], Light::Infinite { radiance: Radiance::EqualArea(_), .. }));
    let Light::Goniometric { intensity, power, light_to_world, .. } = &lights[7] else {
        panic!("{lights:?}")
    };
    assert_eq!((intensity, *power), (&Spectrum::srgb([1.0, 2.0, 3.0]), Some(30.0)));
    // The table's z is pbrt's y.
    assert!(
        close(light_to_world.vector(Vec3::Z), Vec3::Y)
            && close(light_to_world.point(Vec3::ZERO), Vec3::Z * 2.0)
    );
    let Light::Projection { fov, scale, light_to_world, .. } = &lights[8] else { panic!("{lights:?}") };
    assert!((fov.to_degrees() - 40.0).abs() < 1e-4 && *scale == 3.0);
    assert!(close(light_to_world.point(Vec3::ZERO), Vec3::Z * 2.0));
    let Light::Infinite { radiance: Radiance::Constant(_), portal: Some(portal), .. } = &lights[9] else {
        panic!("{lights:?}")
    };
    assert_eq!(portal[1], Vec3::new(-1.0, 5.0, 2.0));
    let emission = scene.shapes.values()[0].area_light.as_ref().unwrap();
    assert!(emission.two_sided);
    assert_eq!(emission.radiance, SpectrumParam::Constant(Spectrum::srgb([5.0; 3])));
    assert_eq!(scene.shapes.values()[1].area_light, None);
}

#[test]
fn colours_know_the_space_in_which_they_were_written() {
    let text = "WorldBegin ColorSpace \"rec2020\" Material \"diffuse\" \"rgb reflectance\" [ 1 0 0 ]
        AttributeBegin ColorSpace \"srgb\" AttributeEnd LightSource \"infinite\"";
    let scene = scene(text);
    let red = Spectrum::Rgb { rgb: [1.0, 0.0, 0.0], space: ColorSpace::Rec2020 };
    assert_eq!(scene.materials.values(), [Material::Diffuse { reflectance: SpectrumParam::Constant(red) }]);
    let white = Spectrum::Rgb { rgb: [1.0; 3], space: ColorSpace::Rec2020 };
    let Light::Infinite { radiance, .. } = &scene.lights.values()[0] else { panic!("{:?}", scene.lights) };
    assert_eq!(*radiance, Radiance::Constant(white));
}

#[test]
fn spectra_of_files_are_read() {
    let mut assets = MemoryAssets::default();
    assets.insert("scenes/eta.spd", *b"# wavelength, value\n400 1.5 # blue\n700 1.25\n");
    let text = b"WorldBegin Material \"dielectric\" \"spectrum eta\" \"eta.spd\"".to_vec();
    let loaded = load_pbrt("scenes/a.pbrt", text, &assets);
    assert!(loaded.diagnostics.is_empty());
    let Material::Dielectric { eta, .. } = &loaded.scene.materials.values()[0] else { panic!() };
    assert_eq!(*eta, Spectrum::Sampled(vec![(400.0, 1.5), (700.0, 1.25)]));
}

#[test]
fn files_are_looked_for_beside_the_scene_and_then_by_their_own_path() {
    let mut assets = MemoryAssets::default();
    assets.insert("scenes/a.pbrt", *b"Shape \"sphere\" \"float radius\" 2");
    assets.insert("a.pbrt", *b"Shape \"sphere\" \"float radius\" 3");
    assets.insert("b.pbrt", *b"Shape \"sphere\" \"float radius\" 4");
    let text = b"WorldBegin Include \"a.pbrt\" Include \"b.pbrt\"".to_vec();
    let loaded = load_pbrt("scenes/main.pbrt", text, &assets);
    assert!(loaded.diagnostics.is_empty());
    let radii: Vec<f32> = loaded
        .scene
        .shapes
        .values()
        .iter()
        .map(|shape| match shape.geometry {
            Geometry::Sphere { radius, .. } => radius,
            _ => f32::NAN,
        })
        .collect();
    assert_eq!(radii, [2.0, 4.0]);
}

#[test]
fn compressed_scenes_are_read() {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(b"WorldBegin Shape \"sphere\"").unwrap();
    let loaded = load_pbrt("-", encoder.finish().unwrap(), &MemoryAssets::default());
    assert!(loaded.diagnostics.is_empty());
    assert_eq!(loaded.scene.world.len(), 1);
    assert_eq!(&*loaded.sources.files()[0].text, b"WorldBegin Shape \"sphere\"");
}

#[test]
fn curves_of_every_basis_become_bezier_segments() {
    let scene = loaded("shapes/curves.pbrt").scene;
    let curves = scene.curves.values();
    let segments: Vec<usize> = curves.iter().map(|curves| curves.points.len()).collect();
    assert_eq!(segments, [1, 2, 2, 1, 2]);
    assert_eq!((curves[0].kind, curves[0].split_depth, curves[1].split_depth), (CurveKind::Flat, 3, 1));
    assert_eq!(curves[0].widths[0], [0.2, 0.0]);
    assert_eq!(curves[1].points[1][0], curves[1].points[0][3]);
    // A uniform B-spline: its ends are (1 4 1) / 6, and its segments meet.
    let [first, second] = &*curves[2].points else { panic!("two segments") };
    assert!(close(first[0], Vec3::new(5.0, 0.0, 1.0) * (1.0 / 6.0)), "{first:?}");
    assert!(close(first[3], second[0]));
    assert_eq!(curves[2].normals[1], [Vec3::Y, Vec3::X]);
    // A parabola, elevated: its middle is a quarter, a half, a quarter.
    let [a, b, c, d] = curves[3].points[0];
    assert!(close(a + b * 3.0 + c * 3.0 + d, Vec3::new(1.0, 0.5, 0.0) * 8.0));
    let [first, second] = &*curves[4].points else { panic!("two segments") };
    assert!(close(first[0], Vec3::new(0.5, 0.5, 1.0)) && close(first[3], second[0]));
    let [subdivided, framed] = scene.triangle_meshes.values() else { panic!("two meshes") };
    assert_eq!((subdivided.indices.len(), subdivided.normals.is_some()), (64, true));
    assert_eq!(framed.tangents.as_deref(), Some(&[Vec3::X, Vec3::X, Vec3::ZERO][..]));
}

#[test]
fn alpha_and_displacement_arrive() {
    let scene = loaded("shapes/alpha.pbrt").scene;
    let shapes = scene.shapes.values();
    assert_eq!([shapes[0].alpha, shapes[2].alpha], [0.25, 0.75].map(FloatParam::Constant));
    let holes = shapes[1].alpha;
    assert!(matches!(holes, FloatParam::Texture(_)));
    let Geometry::Displaced { mesh, displacement, edge_length } = shapes[2].geometry else {
        panic!("{:?}", shapes[2].geometry)
    };
    assert_eq!((displacement, edge_length), (holes, 0.25), "the option halves the length");
    // A quadrilateral is two triangles beside the one of the file.
    assert_eq!(scene.triangle_meshes[mesh].indices.len(), 3);
    assert_eq!(shapes.len(), 3);
}

#[test]
fn motion_arrives_in_fractions_of_the_time_that_the_shutter_is_open() {
    let scene = loaded("structure/motion.pbrt").scene;
    let shape = &scene.shapes[scene.world[0]];
    let motion = shape.motion.as_ref().unwrap();
    assert_eq!(motion.times(), [0.25, 0.75]);
    assert_eq!(
        *motion.ends(),
        [[0.0, 0.0, 0.5], [1.0, 0.0, 0.5]].map(|[x, y, z]| { Transform::translate(x, y, z).unwrap() })
    );
    assert_eq!(shape.shape_to_world, motion.ends()[0]);
    let [moving, still] = scene.instances.values() else { panic!("{:?}", scene.instances) };
    let turned = moving.motion.as_ref().unwrap().at(1.0);
    assert!(close(turned.point(Vec3::X), Vec3::new(0.0, 3.0, 0.0)));
    // Halfway, the point of the object that is where the camera is has gone half of a straight line, from (0, −4, 2) to (6, 2, 2).
    let halfway = moving.motion.as_ref().unwrap().at(0.5);
    assert!(close(halfway.point(Vec3::new(0.0, -6.0, 2.0)), Vec3::new(3.0, -1.0, 2.0)));
    assert!(still.motion.is_none() && close(moving.object_to_world.point(Vec3::X), Vec3::new(1.0, 2.0, 0.0)));
    // Open for a moment, in the middle of the motion.
    let text = "Camera \"perspective\" \"float shutteropen\" 0.5 \"float shutterclose\" 0.5 WorldBegin
        ActiveTransform EndTime Translate 1 0 0 Shape \"sphere\"";
    let frozen = load_pbrt("test.pbrt", text.as_bytes().to_vec(), &MemoryAssets::default()).scene;
    let shape = &frozen.shapes.values()[0];
    assert!(shape.motion.is_none() && close(shape.shape_to_world.point(Vec3::ZERO), Vec3::X * 0.5));
}

#[test]
fn mesh_files_are_read_once() {
    let scene = loaded("shapes/ply.pbrt").scene;
    assert_eq!((scene.triangle_meshes.len(), scene.patch_meshes.len(), scene.world.len()), (1, 1, 4));
    let shapes = scene.shapes.values();
    assert_eq!(shapes[0].geometry, shapes[2].geometry);
    assert!(!shapes[0].reverse_orientation && shapes[2].reverse_orientation);
}

#[test]
fn layered_and_thin_materials_keep_their_parameters() {
    let scene = scene(
        r#"WorldBegin
        Material "coateddiffuse" "rgb reflectance" [ .1 .2 .3 ] "float roughness" .09 "float eta" 1.4
            "float thickness" .2 "float g" .3 "rgb albedo" [ .5 .5 .5 ] "integer maxdepth" 20 "integer nsamples" 4
        Material "coatedconductor" "float interface.uroughness" .3 "float interface.eta" 1.3
            "float conductor.roughness" .2
        Material "thindielectric" "float eta" 1.3
        Material "diffusetransmission" "rgb transmittance" [ .1 .1 .1 ] "float scale" .5
        Material "coatedconductor" "rgb reflectance" [ .9 .8 .7 ]"#,
    );
    let [paper, metal, pane, sheet, colour] = scene.materials.values() else {
        panic!("{:?}", scene.materials)
    };
    let both = |u, v| Roughness { u: FloatParam::Constant(u), v: FloatParam::Constant(v), remap: true };
    let grey = |value| SpectrumParam::Constant(Spectrum::Constant(value));
    let coat = Coat {
        roughness: both(0.09, 0.09),
        eta: Spectrum::Constant(1.4),
        thickness: FloatParam::Constant(0.2),
        g: FloatParam::Constant(0.3),
        albedo: SpectrumParam::Constant(Spectrum::srgb([0.5; 3])),
        max_depth: 20,
        samples: 4,
    };
    let reflectance = SpectrumParam::Constant(Spectrum::srgb([0.1, 0.2, 0.3]));
    assert_eq!(*paper, Material::CoatedDiffuse { reflectance, coat });
    let named = |name: &str| SpectrumParam::Constant(Spectrum::Named(name.to_owned()));
    let copper = ConductorReflectance::Index { eta: named("metal-Cu-eta"), k: named("metal-Cu-k") };
    let coat = Coat { roughness: both(0.3, 0.0), eta: Spectrum::Constant(1.3), ..Coat::default() };
    let expected = Material::CoatedConductor { reflectance: copper, roughness: both(0.2, 0.2), coat };
    assert_eq!(*metal, expected);
    assert_eq!(*pane, Material::ThinDielectric { eta: Spectrum::Constant(1.3) });
    let transmittance = SpectrumParam::Constant(Spectrum::srgb([0.1; 3]));
    let expected = Material::DiffuseTransmission { reflectance: grey(0.25), transmittance, scale: 0.5 };
    assert_eq!(*sheet, expected);
    assert!(matches!(colour, Material::CoatedConductor { reflectance: ConductorReflectance::Normal(_), .. }));
}

#[test]
fn a_mix_refers_to_materials_that_may_follow() {
    let scene = scene(
        r#"WorldBegin
        MakeNamedMaterial "both" "string type" "mix" "string materials" [ "a" "b" ] "float amount" 0.7
        MakeNamedMaterial "a" "string type" "diffuse"
        MakeNamedMaterial "b" "string type" "dielectric"
        NamedMaterial "both" Shape "sphere""#,
    );
    let Material::Mix { materials: [a, b], amount } = &scene.materials[scene.shapes.values()[0].material]
    else {
        panic!("{:?}", scene.materials)
    };
    assert_eq!(*amount, FloatParam::Constant(0.7));
    assert!(matches!(scene.materials[*a], Material::Diffuse { .. }));
    assert!(matches!(scene.materials[*b], Material::Dielectric { .. }));
}

#[test]
fn bumps_and_normal_maps_are_materials_around_others() {
    let mut assets = MemoryAssets::default();
    assets.insert("n.ppm", *b"P6 1 1 255 \x80\x80\xff");
    let text = r#"WorldBegin
        Texture "h" "float" "constant" "float value" 2
        Material "dielectric" "texture displacement" "h"
        MakeNamedMaterial "m" "string type" "coateddiffuse" "string normalmap" "n.ppm""#;
    let loaded = load_pbrt("test.pbrt", text.as_bytes().to_vec(), &assets);
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
    let scene = loaded.scene;
    let relief = |i: usize| match &scene.materials.values()[i] {
        Material::Relief { material, relief } => (&scene.materials[*material], relief),
        other => panic!("{other:?}"),
    };
    let (glass, bump) = relief(0);
    assert!(matches!((glass, bump), (Material::Dielectric { .. }, Relief::Bump(FloatParam::Texture(_)))));
    let (paper, normals) = relief(2);
    assert!(matches!((paper, normals), (Material::CoatedDiffuse { .. }, Relief::Normals(_))));
    assert_eq!(scene.images.values()[0].encoding, Encoding::Linear);
    let both = r#"WorldBegin Material "diffuse" "float displacement" 1 "string normalmap" "n.ppm""#;
    let loaded = load_pbrt("test.pbrt", both.as_bytes().to_vec(), &assets);
    assert_eq!(
        loaded.diagnostics.iter().map(|entry| entry.code).collect::<Vec<_>>(),
        ["unsupported-parameter"]
    );
}

#[test]
fn hair_has_the_strongest_of_its_colours() {
    let colours = |text: &str| {
        let text = format!("WorldBegin Material \"hair\" {text}");
        let loaded = load_pbrt("test.pbrt", text.into_bytes(), &MemoryAssets::default());
        let warnings = loaded.diagnostics.iter().count();
        match &loaded.scene.materials.values()[0] {
            Material::Hair(hair) => (hair.color.clone(), warnings),
            other => panic!("{other:?}"),
        }
    };
    let rgb = |rgb| SpectrumParam::Constant(Spectrum::srgb(rgb));
    assert_eq!(colours("").0, Hair::default().color);
    let both = colours("\"rgb sigma_a\" [ 1 2 3 ] \"rgb reflectance\" [ .1 .2 .3 ]");
    assert_eq!(both, (HairColor::Absorption(rgb([1.0, 2.0, 3.0])), 1));
    let color = colours("\"rgb color\" [ .1 .2 .3 ]");
    assert_eq!(color, (HairColor::Reflectance(rgb([0.1, 0.2, 0.3])), 0));
    let red = colours("\"float pheomelanin\" 1.2");
    let expected =
        HairColor::Melanin { eumelanin: FloatParam::Constant(0.0), pheomelanin: FloatParam::Constant(1.2) };
    assert_eq!(red, (expected, 0));
}
