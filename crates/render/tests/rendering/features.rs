//! Features of the first surface, exactly.

use std::sync::Arc;

use crate::common::*;
use sahl_image::{Encoding, Image};
use sahl_math::{Transform, Vec2, Vec3};
use sahl_render::{Aov, RenderOptions, render};
use sahl_scene::{
    Face, FaceImages, FaceTexels, FaceTexture, Filter, Geometry, Instance, Material, Object, Origin,
    PatchMesh, SceneDesc, SpectrumParam, Texture, TriangleMesh,
};

/// The layers of `aovs`, without the image.
fn layers(scene: &SceneDesc, aovs: &[Aov]) -> Vec<(Option<String>, Vec<String>, Image)> {
    let options = RenderOptions { threads: 1, aovs: aovs.to_vec(), ..RenderOptions::default() };
    let layers = render(&built(scene), &options, &()).film.layers();
    layers.into_iter().skip(1).map(|layer| (layer.name, layer.channel_names, layer.image)).collect()
}

fn assert_close(found: &[f32], expected: &[f32], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((a - b).abs() < 2e-5, "{what}, value {i}: {a}, not {b}");
    }
}

/// A square of side 2 with normals of its own and texture coordinates, of which the camera sees the right half; nothing
/// is to the right of it.
fn half_covered() -> SceneDesc {
    let mut scene = empty(2, 4);
    scene.filter = Filter::Box { radius: [1e-4; 2] };
    let material = diffuse(&mut scene, 0.25);
    let mesh = TriangleMesh {
        indices: [[0, 1, 3], [0, 3, 2]].into(),
        positions: square(1.0, 0.0).map(Vec3::from).into(),
        normals: Some([Vec3::new(0.6, 0.0, 0.8); 4].into()),
        tangents: None,
        face_indices: None,
        uvs: Some([[2.0, 0.0], [4.0, 0.0], [2.0, 1.0], [4.0, 1.0]].map(Vec2::from).into()),
    };
    let mesh = scene.triangle_meshes.push(mesh, Origin::default());
    add(&mut scene, Geometry::Triangles(mesh), material);
    look_down(&mut scene, 5.0, 1.0);
    // Columns look at x = 0.5 and 1.5, rows at y = 0.5 and −0.5.
    scene.camera.screen_window = Some([0.0, 2.0, -1.0, 1.0]);
    scene
}

#[test]
fn features_are_those_of_the_surface() {
    let found = layers(&half_covered(), &Aov::ALL);
    let expected: [(Option<&str>, &str, &[f32]); 6] = [
        (Some("Albedo"), "RGB", &[0.25, 0.25, 0.25]),
        (Some("Ns"), "XYZ", &[0.6, 0.0, 0.8]),
        (Some("N"), "XYZ", &[0.0, 0.0, 1.0]),
        (None, "Z", &[5.0]),
        (Some("P"), "XYZ", &[0.5, 0.5, 0.0]),
        (None, "uv", &[3.5, 0.75]),
    ];
    for ((name, channels, image), (expected_name, expected_channels, values_expected)) in
        found.iter().zip(expected)
    {
        assert_eq!((name.as_deref(), channels.concat().as_str()), (expected_name, expected_channels));
        let (count, all) = (image.channels, values(image));
        assert_close(&all[..count], values_expected, expected_channels);
        // Nothing is seen on the right.
        assert_close(&all[count..2 * count], &vec![0.0; count], expected_channels);
    }
    assert_close(&values(&found[4].2)[6..9], &[0.5, -0.5, 0.0], "the second row");
}

#[test]
fn partly_covered_pixels_average_normals_over_all_samples_and_depth_over_hits() {
    let mut scene = half_covered();
    scene.film.resolution = [1, 1];
    scene.filter = Filter::Box { radius: [0.5; 2] };
    scene.sampler.samples = 64;
    let found = layers(&scene, &[Aov::GeometricNormal, Aov::Depth, Aov::Albedo]);
    // Well-spread points cover a half exactly.
    assert_close(values(&found[0].2), &[0.0, 0.0, 0.5], "normal");
    assert_close(values(&found[1].2), &[5.0], "depth");
    assert_close(values(&found[2].2), &[0.125; 3], "albedo");
}

#[test]
fn repeated_features_are_recorded_once() {
    assert_eq!(layers(&half_covered(), &[Aov::Depth, Aov::Uv, Aov::Depth]).len(), 2);
}

#[test]
fn the_front_follows_orientation_and_mirroring() {
    let mirrored = Transform::scale(-1.0, 1.0, 1.0).unwrap();
    for (transform, reverse, expected) in [
        (Transform::IDENTITY, false, 1.0),
        (Transform::IDENTITY, true, -1.0),
        // A mirror turns the winding round and pbrt turns the normal back: the front stays the front.
        (mirrored, false, 1.0),
        (mirrored, true, -1.0),
    ] {
        let mut scene = empty(2, 1);
        let material = diffuse(&mut scene, 0.5);
        for make in [patch, quad] {
            let geometry = make(&mut scene, square(1.0, 0.0));
            let shape = add_placed(&mut scene, geometry, material, transform);
            scene.shapes[shape].reverse_orientation = reverse;
            look_down(&mut scene, 1.0, 0.5);
            let normal = &layers(&scene, &[Aov::GeometricNormal])[0].2;
            assert_close(&values(normal)[..3], &[0.0, 0.0, expected], "front");
            scene.world.clear();
        }
        let disk = Geometry::Disk { height: 0.0, radius: 2.0, inner_radius: 0.0, phi_max: 7.0 };
        let shape = add_placed(&mut scene, disk, material, transform);
        scene.shapes[shape].reverse_orientation = reverse;
        let normal = &layers(&scene, &[Aov::GeometricNormal])[0].2;
        assert_close(&values(normal)[..3], &[0.0, 0.0, expected], "front of a disk");
    }
}

#[test]
fn an_instance_looks_like_the_shape_it_places() {
    let build = |instanced: bool| {
        let mut scene = empty(8, 1);
        let material = diffuse(&mut scene, 0.5);
        let mut shape_to_object = Transform::rotate(0.3, [1.0, 0.5, 0.0]).unwrap();
        let object_to_world = Transform::translate(0.1, -0.2, 0.3)
            .unwrap()
            .after(&Transform::scale(1.3, -1.3, 1.3).unwrap())
            .unwrap();
        if !instanced {
            shape_to_object = object_to_world.after(&shape_to_object).unwrap();
        }
        let mesh = TriangleMesh {
            indices: [[0, 1, 3], [0, 3, 2]].into(),
            positions: square(0.8, 0.1).map(Vec3::from).into(),
            normals: Some(
                [[0.1, 0.0, 1.0], [0.0, 0.3, 1.0], [-0.2, 0.0, 1.0], [0.0, 0.0, 1.0]].map(Vec3::from).into(),
            ),
            tangents: None,
            uvs: None,
            face_indices: None,
        };
        let mesh = scene.triangle_meshes.push(mesh, Origin::default());
        for geometry in [Geometry::Triangles(mesh), sphere(0.3)] {
            add_placed(&mut scene, geometry, material, shape_to_object);
        }
        if instanced {
            let shapes = std::mem::take(&mut scene.world);
            let object = scene.objects.push(Object { shapes }, Origin::default());
            scene.instances.push(Instance::new(object, object_to_world), Origin::default());
        }
        look_down(&mut scene, 4.0, 1.3);
        layers(&scene, &[Aov::Normal, Aov::GeometricNormal, Aov::Position, Aov::Uv])
    };
    for ((name, _, a), (_, _, b)) in build(true).iter().zip(build(false)) {
        assert!(values(a).iter().any(|&value| value != 0.0));
        assert_close(values(a), values(&b), &format!("{name:?}"));
    }
}

#[test]
fn every_face_of_a_mesh_shows_its_own_image() {
    let face = |first: u64| Face {
        size_log2: [3, 1],
        is_constant: true,
        is_part: false,
        first,
        neighbors: [None; 4],
    };
    let texels = FaceTexels::F32([0.8, 0.2, 0.4, 0.1, 0.5, 0.9].into());
    let images = Arc::new(FaceImages { channels: 3, faces: [face(0), face(3)].into(), texels });
    let corners = [[-1.0, -1.0], [0.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [0.0, 1.0], [1.0, 1.0]];
    let positions: Arc<[Vec3]> = corners.map(|[x, y]| Vec3::new(x, y, 0.0)).into();
    let render = |use_patches: bool, face_indices: Option<Arc<[u32]>>, instanced: bool| {
        let mut scene = empty(2, 4);
        scene.filter = Filter::Box { radius: [1e-4; 2] };
        let texture = FaceTexture { images: Arc::clone(&images), encoding: Encoding::Linear, scale: 0.5 };
        let texture = scene.textures.push(Texture::Faces(texture), Origin::default());
        let reflectance = SpectrumParam::Texture(texture);
        let material = scene.materials.push(Material::Diffuse { reflectance }, Origin::default());
        let geometry = if use_patches {
            let indices = [[0, 1, 3, 4], [1, 2, 4, 5]].into();
            let mesh = PatchMesh {
                indices,
                positions: Arc::clone(&positions),
                face_indices,
                ..PatchMesh::default()
            };
            Geometry::Patches(scene.patch_meshes.push(mesh, Origin::default()))
        } else {
            let indices = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]].into();
            let face_indices = face_indices.map(|all| all.iter().flat_map(|&face| [face; 2]).collect());
            let mesh = TriangleMesh {
                indices,
                positions: Arc::clone(&positions),
                face_indices,
                ..TriangleMesh::default()
            };
            Geometry::Triangles(scene.triangle_meshes.push(mesh, Origin::default()))
        };
        let shape = add(&mut scene, geometry, material);
        if instanced {
            let shapes = std::mem::take(&mut scene.world);
            assert_eq!(shapes, [shape]);
            let object = scene.objects.push(Object { shapes }, Origin::default());
            let object_to_world = Transform::translate(0.0, 0.0, -0.5).unwrap();
            scene.instances.push(Instance::new(object, object_to_world), Origin::default());
        }
        look_down(&mut scene, 5.0, 1.0);
        values(&layers(&scene, &[Aov::Albedo])[0].2).to_vec()
    };
    let (first, second) = ([0.4, 0.1, 0.2], [0.05, 0.25, 0.45]);
    for (use_patches, instanced) in [(false, false), (true, false), (true, true), (false, true)] {
        let found = render(use_patches, Some([1, 0].into()), instanced);
        assert_close(&found, &[second, first, second, first].concat(), "by number");
        let found = render(use_patches, None, instanced);
        assert_close(&found, &[first; 4].concat(), "without numbers");
    }
}
