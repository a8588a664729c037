use std::sync::Arc;

use sahl_image::{ColorSpace, Encoding, Image, Pixels};
use sahl_math::{Transform, Vec2, Vec3};

use crate::*;

/// A lit sphere, a mesh and an object, without anything wrong.
fn sound() -> SceneDesc {
    let mut scene = SceneDesc::default();
    let material = scene.materials.push(Material::default(), Origin::default());
    let sphere = Geometry::Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0, phi_max: std::f32::consts::TAU };
    let mesh = TriangleMesh {
        indices: [[0, 1, 2]].into(),
        positions: [Vec3::ZERO, Vec3::X, Vec3::Y].into(),
        ..TriangleMesh::default()
    };
    let mesh = scene.triangle_meshes.push(mesh, Origin::default());
    for geometry in [sphere, Geometry::Triangles(mesh)] {
        let shape = Shape::new(geometry, Transform::IDENTITY, material);
        let shape = scene.shapes.push(shape, Origin::default());
        scene.world.push(shape);
    }
    let light = Light::Point {
        intensity: Spectrum::Constant(1.0),
        scale: 1.0,
        power: None,
        position: Vec3::splat(5.0),
    };
    scene.lights.push(light, Origin::default());
    scene
}

/// The messages about a sound scene after `change`, one a line.
fn told(change: impl FnOnce(&mut SceneDesc)) -> String {
    let mut scene = sound();
    change(&mut scene);
    let line = |diagnostic: Diagnostic| {
        format!("{:?} {}: {}", diagnostic.severity, diagnostic.code, diagnostic.message)
    };
    scene.validate().into_iter().map(line).collect::<Vec<_>>().join("\n")
}

fn named(name: &str) -> Origin {
    Origin { name: Some(name.to_owned()), span: None }
}

fn first_shape(scene: &mut SceneDesc) -> &mut Shape {
    &mut scene.shapes[Handle::new(0)]
}

#[test]
fn a_sound_scene_has_nothing_wrong() {
    assert_eq!(told(|_| {}), "");
}

#[test]
fn an_empty_scene_gives_warnings() {
    insta::assert_snapshot!(told(|scene| *scene = SceneDesc::default()), @r"
    Warning no-shape: the scene has no shapes
    Warning no-light: the scene has no light: the image is black
    ");
    assert_eq!(told(|scene| scene.lights = Arena::default()).lines().count(), 1);
    assert_eq!(
        told(|scene| {
            scene.lights = Arena::default();
            scene.integrator = Integrator::Normals;
        }),
        ""
    );
}

#[test]
fn camera_film_filter_and_sampler_are_checked() {
    insta::assert_snapshot!(told(|scene| {
        scene.camera = Camera {
            projection: Projection::Perspective { fov: 4.0 },
            screen_window: Some([1.0, -1.0, 0.0, 1.0]),
            lens_radius: -1.0,
            shutter: [1.0, 0.0],
            ..Camera::default()
        };
        scene.film.resolution = [0, 10];
        scene.film.crop = Some([0, 1, 5, 11]);
        scene.film.exposure = f32::NAN;
        scene.film.max_component = -1.0;
        scene.filter = Filter::Gaussian { radius: [0.0, 1.5], sigma: f32::INFINITY };
        scene.sampler.samples = 0;
        scene.integrator = Integrator::Ao { max_distance: f32::NAN };
    }), @r"
    Error bad-camera: the camera's angle of view is 229.18312 degrees: expected between 0 and 180
    Error bad-number: the lens radius is -1: expected zero or more
    Error bad-camera: the shutter opens at 1 and closes at 0: expected times in order
    Error bad-camera: the screen window is [1.0, -1.0, 0.0, 1.0]: expected x min < x max and y min < y max
    Error bad-film: the image has 0 × 10 pixels: expected 1 to 268435456
    Error bad-film: the crop from (0, 5) to (1, 11) is not a part of the 0 × 10 image
    Error bad-number: the exposure is NaN: expected more than zero
    Error bad-film: the largest component is -1: expected more than zero
    Error bad-number: the radius of the pixel filter is 0: expected more than zero
    Error bad-number: the width of the Gaussian filter is inf: expected more than zero
    Error bad-sampler: zero samples a pixel: expected one or more
    Error bad-integrator: the distance of ambient occlusion is NaN: expected more than zero
    ");
    let too_large = told(|scene| scene.film.resolution = [1 << 14, 1 << 14 | 1]);
    assert!(too_large.contains("16384 × 16385 pixels"), "{too_large}");
    assert_eq!(told(|scene| scene.film.resolution = [1 << 14, 1 << 14]), "");
}

#[test]
fn handles_must_lead_somewhere() {
    insta::assert_snapshot!(told(|scene| {
        let reflectance = SpectrumParam::Texture(Handle::new(5));
        scene.materials.push(Material::Diffuse { reflectance }, named("red"));
        first_shape(scene).material = Handle::new(9);
        first_shape(scene).geometry = Geometry::Patches(Handle::new(0));
        scene.world.push(Handle::new(7));
        scene.objects.push(Object { shapes: vec![Handle::new(8)] }, named("tree"));
        let instance = Instance::new(Handle::new(3), Transform::IDENTITY);
        scene.instances.push(instance, Origin::default());
        let light = Light::Infinite {
            radiance: Radiance::LatLong(Handle::new(0)),
            scale: 1.0,
            illuminance: None,
            light_to_world: Transform::IDENTITY,
            portal: None,
        };
        scene.lights.push(light, named("sky"));
    }), @r"
    Error dangling-handle: material `red` refers to texture 5, of which there are 0
    Error dangling-handle: shape refers to material 9, of which there are 2
    Error dangling-handle: shape refers to patch mesh 0, of which there are 0
    Error dangling-handle: the world refers to shape 7, of which there are 2
    Error dangling-handle: object `tree` refers to shape 8, of which there are 2
    Error dangling-handle: instance refers to object 3, of which there are 1
    Error dangling-handle: light `sky` refers to image 0, of which there are 0
    ");
}

#[test]
fn meshes_are_checked() {
    insta::assert_snapshot!(told(|scene| {
        scene.triangle_meshes.push(TriangleMesh::default(), named("empty"));
        let mesh = TriangleMesh {
            indices: [[0, 1, 2], [0, 1, 3]].into(),
            positions: [Vec3::ZERO, Vec3::X, Vec3::splat(f32::NAN)].into(),
            normals: Some([Vec3::X].into()),
            tangents: None,
            uvs: Some([Vec2::ZERO, Vec2::ZERO, Vec2::splat(f32::INFINITY)].into()),
            face_indices: Some([7].into()),
        };
        scene.triangle_meshes.push(mesh, named("torn"));
        let mesh = PatchMesh {
            indices: [[0, 0, 0, 4]].into(),
            positions: [Vec3::ZERO; 4].into(),
            ..PatchMesh::default()
        };
        scene.patch_meshes.push(mesh, Origin::default());
    }), @r"
    Error empty-mesh: triangle mesh `empty` has no faces
    Error index-out-of-range: face 1 of triangle mesh `torn` refers to vertex 3 of 3
    Error bad-number: the position of vertex 2 of triangle mesh `torn` is not finite
    Error attribute-count: triangle mesh `torn` has 1 normals for 3 vertices
    Error bad-number: the texture coordinate of vertex 2 of triangle mesh `torn` is not finite
    Error attribute-count: triangle mesh `torn` has 1 face indices for 2 faces
    Error index-out-of-range: face 0 of patch mesh refers to vertex 4 of 4
    ");
}

#[test]
fn shapes_and_emission_are_checked() {
    insta::assert_snapshot!(told(|scene| {
        let phi_max = 6.0;
        first_shape(scene).geometry = Geometry::Sphere { radius: -1.0, z_min: f32::NAN, z_max: 1.0, phi_max };
        first_shape(scene).area_light = Some(AreaLight {
            radiance: SpectrumParam::Constant(Spectrum::Blackbody(-5.0)),
            scale: f32::INFINITY,
            two_sided: false,
            power: Some(-1.0),
        });
        let disk = Geometry::Disk { height: 0.0, radius: 1.0, inner_radius: 2.0, phi_max };
        let shape = Shape { geometry: disk, ..scene.shapes[Handle::new(0)].clone() };
        scene.shapes.push(Shape { area_light: None, ..shape }, named("ring"));
    }), @r"
    Error bad-number: the radius of shape is -1: expected more than zero
    Error bad-number: the lower end of shape is NaN: expected a finite number
    Error bad-number: the temperature of the emission of shape is -5: expected more than zero
    Error bad-number: the scale of the emission of shape is inf: expected zero or more
    Error bad-number: `power` of shape is -1: expected zero or more
    Error bad-number: the hole of shape `ring` is as large as the disk: 2 of 1
    ");
}

#[test]
fn lights_are_checked() {
    insta::assert_snapshot!(told(|scene| {
        let spot = Light::Spot {
            intensity: Spectrum::Sampled(vec![(500.0, 1.0), (400.0, 1.0)]),
            scale: -1.0,
            power: Some(f32::NAN),
            position: Vec3::splat(f32::INFINITY),
            direction: Vec3::ZERO,
            angle: 0.5,
            penumbra: 0.6,
        };
        scene.lights.push(spot, named("stage"));
        let distant = Light::Distant {
            radiance: Spectrum::srgb([1.0, f32::NAN, 1.0]),
            scale: 1.0,
            illuminance: None,
            direction: Vec3::ZERO,
        };
        scene.lights.push(distant, Origin::default());
    }), @r"
    Error bad-number: the scale of light `stage` is -1: expected zero or more
    Error bad-spectrum: the samples of the intensity of light `stage` must be finite, at increasing wavelengths, and at least one
    Error bad-number: `power` of light `stage` is NaN: expected zero or more
    Error bad-number: the position of light `stage` is not finite, or has no direction
    Error bad-number: the direction of light `stage` is not finite, or has no direction
    Error bad-number: the cone of light `stage` has a half angle of 28.64789 degrees with a border of 34.37747: expected 0 to 180 and no wider border
    Error bad-number: a component of the radiance of light is NaN: expected a finite number
    Error bad-number: the direction of light is not finite, or has no direction
    ");
}

#[test]
fn materials_are_checked() {
    insta::assert_snapshot!(told(|scene| {
        let roughness = Roughness { u: FloatParam::Constant(-0.1), v: FloatParam::Texture(Handle::new(0)), remap: true };
        let eta = SpectrumParam::Constant(Spectrum::Sampled(Vec::new()));
        let k = SpectrumParam::Constant(Spectrum::Constant(f32::NAN));
        let reflectance = ConductorReflectance::Index { eta, k };
        scene.materials.push(Material::Conductor { reflectance, roughness }, named("gold"));
        let glass = Material::Dielectric { eta: Spectrum::Constant(0.0), roughness: Roughness::SMOOTH };
        scene.materials.push(glass, Origin::default());
    }), @r"
    Error bad-spectrum: the samples of `eta` of material `gold` must be finite, at increasing wavelengths, and at least one
    Error bad-number: `k` of material `gold` is NaN: expected a finite number
    Error bad-number: the roughness of material `gold` is -0.1: expected zero or more
    Error dangling-handle: material `gold` refers to texture 0, of which there are 0
    Error bad-number: `eta` of material is 0: expected more than zero
    ");
}

#[test]
fn images_must_have_their_pixels() {
    insta::assert_snapshot!(told(|scene| {
        let image = Image {
            width: usize::MAX,
            height: 2,
            channels: 3,
            pixels: Pixels::U8(vec![0; 5]),
            encoding: Encoding::Srgb,
            color_space: ColorSpace::Srgb,
        };
        scene.images.push(Arc::new(image), named("a.png"));
    }), @"Error bad-image: image `a.png` has 5 values for 18446744073709551615 × 2 pixels with 3 channels");
}

fn scaled(texture: u32) -> Texture {
    Texture::Scale { texture: SpectrumParam::Texture(Handle::new(texture)), scale: FloatParam::Constant(0.5) }
}

#[test]
fn textures_must_not_contain_themselves() {
    insta::assert_snapshot!(told(|scene| {
        let mix = Texture::Mix {
            first: SpectrumParam::Constant(Spectrum::Constant(0.0)),
            second: SpectrumParam::Texture(Handle::new(1)),
            amount: FloatParam::Texture(Handle::new(3)),
        };
        scene.textures.push(mix, named("a"));
        scene.textures.push(scaled(2), named("b"));
        scene.textures.push(scaled(0), named("c"));
        scene.textures.push(scaled(3), Origin::default());
        // Two ways to the same texture are no cycle.
        scene.textures.push(Texture::Constant(Spectrum::Constant(1.0)), named("leaf"));
        let even = SpectrumParam::Texture(Handle::new(4));
        let board = Texture::Checkerboard { mapping: TextureMapping::default(), even: even.clone(), odd: even };
        scene.textures.push(board, named("board"));
    }), @r"
    Error cyclic-texture: texture contains itself: #3 → #3
    Error cyclic-texture: texture `a` contains itself: `a` → `b` → `c` → `a`
    ");
}

#[test]
fn textures_have_numbers_in_range() {
    insta::assert_snapshot!(told(|scene| {
        let grey = SpectrumParam::Constant(Spectrum::Constant(0.5));
        let pixels = Pixels::F32(vec![0.0; 1]);
        let image = Image::new(1, 1, 1, pixels).unwrap();
        let image = scene.images.push(Arc::new(image), Origin::default());
        let noise = SolidNoise { world_to_texture: Transform::IDENTITY, octaves: 40, roughness: f32::NAN };
        scene.textures.push(Texture::Fbm(noise), named("noise"));
        let mix = Texture::DirectionMix { first: grey.clone(), second: grey.clone(), direction: Vec3::ZERO };
        scene.textures.push(mix, named("mix"));
        let mapping = TextureMapping::Planar {
            world_to_texture: Transform::IDENTITY,
            s: Vec3::new(1.0, f32::INFINITY, 0.0),
            t: Vec3::Y,
            offset: [0.0; 2],
        };
        scene.textures.push(Texture::Dots { mapping, inside: grey.clone(), outside: grey }, named("dots"));
        let picture = ImageTexture {
            image,
            mapping: TextureMapping::default(),
            wrap: Wrap::Repeat,
            filter: TextureFilter::Ewa { max_anisotropy: 0.5 },
            scale: 1.0,
            invert: false,
        };
        scene.textures.push(Texture::Image(picture), named("picture"));
    }), @r"
    Error bad-number: the roughness of texture `noise` is NaN: expected a finite number
    Error bad-number: texture `noise` has 40 octaves of noise: 32 is the limit
    Error bad-number: the direction of texture `mix` is (0, 0, 0): expected one that is not zero
    Error bad-number: the mapping of texture `dots` is inf: expected a finite number
    Error bad-number: the anisotropy of texture `picture` is 0.5: expected 1 to 64
    ");
}

#[test]
fn images_of_faces_are_checked() {
    let face = Face { first: 0, size_log2: [1, 0], is_constant: false, neighbors: [None; 4], is_part: false };
    let texture = |faces: Vec<Face>, channels: usize, values: Vec<f32>, scale: f32| {
        let images = FaceImages { channels, faces: faces.into(), texels: FaceTexels::F32(values.into()) };
        Texture::Faces(FaceTexture { images: Arc::new(images), encoding: Encoding::Linear, scale })
    };
    insta::assert_snapshot!(told(|scene| {
        scene.textures.push(texture(vec![face], 1, vec![0.5; 2], 1.0), named("sound"));
        scene.textures.push(texture(vec![face], 1, vec![0.5], 1.0), named("short"));
        scene.textures.push(texture(vec![face], 1, vec![0.5, f32::NAN], 1.0), named("not a number"));
        scene.textures.push(texture(vec![face], usize::MAX, vec![0.5; 2], 1.0), named("endless"));
        scene.textures.push(texture(vec![face], 2, vec![0.5; 4], f32::NAN), named("of two channels"));
        scene.textures.push(texture(Vec::new(), 1, Vec::new(), 1.0), named("empty"));
    }), @r"
    Error bad-image: face 0 of texture `short` has pixels that are not finite, or refers to what is not there
    Error bad-image: face 0 of texture `not a number` has pixels that are not finite, or refers to what is not there
    Error bad-image: face 0 of texture `endless` has pixels that are not finite, or refers to what is not there
    Error bad-number: the scale of texture `of two channels` is NaN: expected a finite number
    Error bad-image: texture `of two channels` has no faces, or neither one channel nor three
    Error bad-image: texture `empty` has no faces, or neither one channel nor three
    ");
}

#[test]
fn a_long_chain_of_textures_is_one_error() {
    let told = told(|scene| {
        scene.textures.push(Texture::Constant(Spectrum::Constant(1.0)), Origin::default());
        for previous in 0..200_000 {
            scene.textures.push(scaled(previous), Origin::default());
        }
    });
    assert_eq!(told, "Error deep-texture: texture holds more than 64 textures in each other");
}

#[test]
fn messages_point_at_the_text() {
    let mut scene = sound();
    let mut sources = Sources::default();
    let file = sources.add("a.pbrt", b"Texture \"t\" \"spectrum\" \"scale\"".as_slice());
    scene.textures.push(scaled(9), Origin::named("t", Span { file, start: 8, end: 11 }));
    insta::assert_snapshot!(scene.validate().render_text(&sources, false), @r#"
    error[dangling-handle]: texture `t` refers to texture 9, of which there are 1
     --> a.pbrt:1:9
      |
    1 | Texture "t" "spectrum" "scale"
      |         ^^^
    "#);
}

#[test]
fn materials_are_not_made_of_themselves() {
    let mut scene = SceneDesc::default();
    let mix = |a: u32, b: u32| Material::Mix {
        materials: [Handle::new(a), Handle::new(b)],
        amount: FloatParam::Constant(0.5),
    };
    // 0 and 1 contain each other; 2 contains a material twice, which is no circle; 4 leads nowhere.
    for material in [mix(1, 3), mix(0, 3), mix(3, 3), Material::default(), mix(3, 99)] {
        scene.materials.push(material, Origin::default());
    }
    assert_eq!(scene.cyclic_materials(), [Handle::new(1)]);
    let codes: Vec<_> = scene.validate().iter().map(|diagnostic| diagnostic.code).collect();
    assert!(codes.contains(&"cyclic-material") && codes.contains(&"dangling-handle"), "{codes:?}");
}

#[test]
fn materials_nest_so_deep_and_no_deeper() {
    let mut scene = SceneDesc::default();
    scene.materials.push(Material::default(), Origin::default());
    for i in 0..300 {
        let materials = [Handle::new(i), Handle::new(0)];
        scene
            .materials
            .push(Material::Mix { materials, amount: FloatParam::Constant(0.5) }, Origin::default());
    }
    let codes: Vec<_> = scene.validate().iter().map(|diagnostic| diagnostic.code).collect();
    assert!(codes.contains(&"material-too-deep"), "{codes:?}");
}
