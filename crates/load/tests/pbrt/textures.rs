//! Textures: what each of pbrt-v4's becomes.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use sahl_image::Encoding;
use sahl_load::{Loaded, MemoryAssets, load_pbrt};
use sahl_math::{Transform, Vec3};
use sahl_scene::{
    FaceTexels, FaceTexture, FloatParam, SolidNoise, Spectrum, SpectrumParam, Texture, TextureFilter,
    TextureMapping, UvMapping, Wrap,
};

/// The textures of a world that gives no message; `t` stands for a one-pixel image.
fn textures(text: &str) -> Vec<Texture> {
    let mut assets = MemoryAssets::default();
    assets.insert("t.pfm", *b"PF\n1 1\n-1.0\n\0\0\0\0\0\0\0\0\0\0\0\0");
    let loaded = load_pbrt("test.pbrt", format!("WorldBegin {text}").into_bytes(), &assets);
    let messages = loaded.diagnostics.render_text(&loaded.sources, false);
    assert!(loaded.diagnostics.is_empty(), "{messages}");
    let faults = loaded.scene.validate();
    assert!(!faults.has_errors(), "{}", faults.render_text(&loaded.sources, false));
    loaded.scene.textures.values().to_vec()
}

fn texture(definition: &str) -> Texture {
    textures(&format!("Texture \"t\" {definition}")).pop().expect("a definition makes a texture")
}

fn number(value: f32) -> SpectrumParam {
    SpectrumParam::Constant(Spectrum::Constant(value))
}

#[test]
fn defaults_are_those_of_pbrt() {
    let mapping = TextureMapping::default();
    let world_to_texture = Transform::IDENTITY;
    let noise = SolidNoise { world_to_texture, octaves: 8, roughness: 0.5 };
    assert_eq!(texture("\"float\" \"constant\""), Texture::Constant(Spectrum::Constant(1.0)));
    assert_eq!(
        texture("\"float\" \"mix\""),
        Texture::Mix { first: number(0.0), second: number(1.0), amount: FloatParam::Constant(0.5) }
    );
    assert_eq!(
        texture("\"spectrum\" \"directionmix\""),
        Texture::DirectionMix { first: number(0.0), second: number(1.0), direction: Vec3::Y }
    );
    let corners = [0.0, 0.0, 1.0, 1.0].map(number);
    assert_eq!(texture("\"float\" \"bilerp\""), Texture::Bilerp { mapping, corners });
    assert_eq!(
        texture("\"spectrum\" \"checkerboard\""),
        Texture::Checkerboard { mapping, even: number(1.0), odd: number(0.0) }
    );
    // As pbrt-v4 renders them, though its manual has them the other way round.
    assert_eq!(
        texture("\"float\" \"dots\""),
        Texture::Dots { mapping, inside: number(0.0), outside: number(1.0) }
    );
    assert_eq!(texture("\"float\" \"fbm\""), Texture::Fbm(noise));
    assert_eq!(texture("\"float\" \"wrinkled\""), Texture::Wrinkled(noise));
    assert_eq!(texture("\"float\" \"windy\""), Texture::Windy { world_to_texture });
    assert_eq!(texture("\"spectrum\" \"marble\""), Texture::Marble { noise, scale: 1.0, variation: 0.2 });
}

#[test]
fn parameters_arrive() {
    let red = SpectrumParam::Constant(Spectrum::srgb([1.0, 0.0, 0.0]));
    let Texture::Bilerp { corners, .. } = texture("\"spectrum\" \"bilerp\" \"rgb v10\" [ 1 0 0 ]") else {
        panic!("no bilerp")
    };
    assert_eq!(corners, [number(0.0), red, number(1.0), number(1.0)]);
    let Texture::Wrinkled(noise) =
        texture("\"float\" \"wrinkled\" \"integer octaves\" 3 \"float roughness\" 0.7")
    else {
        panic!("not wrinkled")
    };
    assert_eq!((noise.octaves, noise.roughness), (3, 0.7));
    let text = "\"spectrum\" \"marble\" \"float scale\" 4 \"float variation\" 0.4 \"integer octaves\" 6";
    let Texture::Marble { noise, scale, variation } = texture(text) else { panic!("no marble") };
    assert_eq!((noise.octaves, scale, variation), (6, 4.0, 0.4));
}

#[test]
fn spaces_are_those_of_the_definition() {
    let placed = "AttributeBegin Translate 0 0 5 Scale 2 2 2 Rotate 90 1 0 0";
    let at_definition =
        |definition: &str| textures(&format!("{placed} Texture \"t\" {definition}")).pop().unwrap();
    let Texture::SolidCheckerboard { world_to_texture, .. } =
        at_definition("\"float\" \"checkerboard\" \"integer dimension\" 3 AttributeEnd")
    else {
        panic!("no checkerboard in space")
    };
    // Ten above the origin of the definition, along the world's y, which is −z there.
    let p = world_to_texture.point(Vec3::new(0.0, 10.0, 5.0));
    assert!((p - Vec3::new(0.0, 0.0, -5.0)).length() < 1e-5, "{p:?}");
    let Texture::DirectionMix { direction, .. } =
        at_definition("\"float\" \"directionmix\" \"vector3 dir\" [ 0 0 3 ] AttributeEnd")
    else {
        panic!("no mix by direction")
    };
    assert!((direction - Vec3::new(0.0, -1.0, 0.0)).length() < 1e-6, "{direction:?}");
}

#[test]
fn mappings_arrive() {
    let board =
        |mapping: &str| match texture(&format!("\"float\" \"checkerboard\" \"string mapping\" {mapping}")) {
            Texture::Checkerboard { mapping, .. } => mapping,
            other => panic!("{other:?}"),
        };
    let world_to_texture = Transform::IDENTITY;
    assert_eq!(
        board("\"uv\" \"float uscale\" 2 \"float vdelta\" 0.5"),
        TextureMapping::Uv(UvMapping { scale: [2.0, 1.0], offset: [0.0, 0.5] })
    );
    assert_eq!(board("\"spherical\""), TextureMapping::Spherical { world_to_texture });
    assert_eq!(board("\"cylindrical\""), TextureMapping::Cylindrical { world_to_texture });
    assert_eq!(
        board("\"planar\" \"vector3 v2\" [ 0 0 2 ] \"float udelta\" 0.25"),
        TextureMapping::Planar { world_to_texture, s: Vec3::X, t: Vec3::Z * 2.0, offset: [0.25, 0.0] }
    );
}

#[test]
fn filters_and_wraps_arrive() {
    let image = |parameters: &str| match texture(&format!(
        "\"spectrum\" \"imagemap\" \"string filename\" \"t.pfm\" {parameters}"
    )) {
        Texture::Image(image) => image,
        other => panic!("{other:?}"),
    };
    let filter = |name: &str| image(&format!("\"string filter\" \"{name}\"")).filter;
    assert_eq!(image("").filter, TextureFilter::Bilinear);
    assert_eq!(filter("point"), TextureFilter::Nearest);
    assert_eq!(filter("trilinear"), TextureFilter::Trilinear);
    assert_eq!(filter("ewa"), TextureFilter::Ewa { max_anisotropy: 8.0 });
    assert_eq!(
        image("\"string filter\" \"EWA\" \"float maxanisotropy\" 16").filter,
        TextureFilter::Ewa { max_anisotropy: 16.0 }
    );
    assert_eq!(image("\"string wrap\" \"octahedralsphere\"").wrap, Wrap::OctahedralSphere);
}

#[test]
fn mistakes_are_told() {
    let errors = |definition: &str| {
        let text = format!("WorldBegin Texture \"t\" {definition}").into_bytes();
        let loaded = load_pbrt("test.pbrt", text, &MemoryAssets::default());
        let found: Vec<String> = loaded.diagnostics.iter().map(|entry| entry.message.clone()).collect();
        assert!(loaded.diagnostics.has_errors() && found.len() == 1, "{definition}: {found:?}");
        found[0].clone()
    };
    assert!(errors("\"float\" \"fbm\" \"integer octaves\" 100").contains("from 0 to 32"));
    assert!(errors("\"float\" \"directionmix\" \"vector3 dir\" [ 0 0 0 ]").contains("direction"));
    assert!(errors("\"float\" \"dots\" \"string mapping\" \"sperical\"").contains("unknown value"));
    assert!(errors("\"spectrum\" \"fbm\"").contains("`float` values only"));
    assert!(errors("\"float\" \"dots\" \"vector3 v1\" [ 0 0 1 0 ]").contains('3'), "a multiple of three");
}

/// A Ptex file of faces of one colour each, 255 of red in the first.
fn ptex_file(faces: u32) -> Vec<u8> {
    let zip = |bytes: &[u8]| {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).expect("memory can be written");
        encoder.finish().expect("memory can be written")
    };
    // Four by two pixels, constant, without neighbours.
    let info = [&[2, 1, 0, 1][..], &[255; 16]].concat().repeat(faces as usize);
    let colors: Vec<u8> = (0..faces as u8).flat_map(|face| [255 - face, 2 * face, 7]).collect();
    let (info, colors, sizes) = (zip(&info), zip(&colors), zip(&vec![0; 4 * faces as usize]));
    let header = [1, 1, 0, u32::MAX, 3 | 1 << 16, faces, 0, info.len() as u32, colors.len() as u32, 16, 4];
    let mut file = b"Ptex".to_vec();
    file.extend(header.map(u32::to_le_bytes).concat());
    file.extend((sizes.len() as u64).to_le_bytes());
    file.extend([0; 8]);
    file.extend([info, colors, (sizes.len() as u64).to_le_bytes().to_vec()].concat());
    file.extend([sizes.len() as u32, faces].map(u32::to_le_bytes).concat());
    file.extend(sizes);
    file
}

/// The world `text`, in which `t.ptx` has two faces and `q.ply` one quadrilateral that is face 5.
fn with_faces(text: &str) -> Loaded {
    let mut assets = MemoryAssets::default();
    assets.insert("t.ptx", ptex_file(2));
    assets.insert("cut.ptx", ptex_file(2)[..100].to_vec());
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_indices\nproperty int face_indices\nend_header\n\
               0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 5\n";
    assets.insert("q.ply", ply.as_bytes());
    load_pbrt("test.pbrt", format!("WorldBegin {text}").into_bytes(), &assets)
}

#[test]
fn images_of_faces_arrive() {
    let texture = |parameters: &str| {
        let loaded = with_faces(&format!(
            "Texture \"t\" \"float\" \"ptex\" \"string filename\" \"t.ptx\" {parameters}"
        ));
        assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
        assert!(!loaded.scene.validate().has_errors());
        match loaded.scene.textures.values() {
            [Texture::Faces(texture)] => texture.clone(),
            other => panic!("{other:?}"),
        }
    };
    let FaceTexture { images, encoding, scale } = texture("");
    assert_eq!((encoding, scale), (Encoding::Gamma(2.2), 1.0));
    assert_eq!(images.texels, FaceTexels::U8([255, 0, 7, 254, 2, 7].into()));
    assert!(images.faces.iter().all(|face| face.is_constant && face.size_log2 == [2, 1]));
    let linear = texture("\"float scale\" 3 \"string encoding\" \"linear\"");
    assert_eq!((linear.encoding, linear.scale), (Encoding::Linear, 3.0));
    assert_eq!(texture("\"string encoding\" \"sRGB\"").encoding, Encoding::Srgb);
    // A file is read once.
    let name = "\"ptex\" \"string filename\" \"t.ptx\"";
    let loaded = with_faces(&format!("Texture \"a\" \"float\" {name} Texture \"b\" \"spectrum\" {name}"));
    let [Texture::Faces(a), Texture::Faces(b)] = loaded.scene.textures.values() else {
        panic!("two textures of faces")
    };
    assert!(std::sync::Arc::ptr_eq(&a.images, &b.images));
}

#[test]
fn images_of_faces_that_cannot_be_read_are_told() {
    let error = |definition: &str| {
        let loaded = with_faces(&format!("Texture \"t\" {definition}"));
        assert!(loaded.diagnostics.has_errors());
        loaded.diagnostics.iter().map(|entry| entry.message.clone()).collect::<Vec<_>>().join("; ")
    };
    let cut = error("\"spectrum\" \"ptex\" \"string filename\" \"cut.ptx\"");
    assert_eq!(cut, "can't read the images of faces `cut.ptx`: it ends too early, or leads outside itself");
    assert!(error("\"spectrum\" \"ptex\" \"string filename\" \"none.ptx\"").contains("none.ptx"));
    assert_eq!(error("\"float\" \"ptex\""), "texture `ptex` needs a `string filename`");
}

#[test]
fn faces_of_meshes_keep_their_numbers() {
    let shape = |text: &str| {
        let loaded = with_faces(text);
        let messages: Vec<_> = loaded.diagnostics.iter().map(|entry| entry.message.clone()).collect();
        let scene = loaded.scene;
        let of_patches =
            scene.patch_meshes.values().iter().map(|mesh| mesh.face_indices.as_deref().map(<[u32]>::to_vec));
        let of_triangles = scene
            .triangle_meshes
            .values()
            .iter()
            .map(|mesh| mesh.face_indices.as_deref().map(<[u32]>::to_vec));
        (of_patches.chain(of_triangles).next_back().flatten(), messages.join("; "))
    };
    let corners = "\"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 0 ]";
    let patch = format!("Shape \"bilinearmesh\" {corners} \"integer indices\" [ 0 1 2 3 ]");
    assert_eq!(shape(&format!("{patch} \"integer faceIndices\" 4")), (Some(vec![4]), String::new()));
    assert_eq!(shape(&patch), (None, String::new()));
    let triangles = format!(
        "Shape \"trianglemesh\" {corners} \"integer indices\" [ 0 1 2 1 2 3 ] \"integer faceIndices\""
    );
    assert_eq!(shape(&format!("{triangles} [ 3 1 ]")), (Some(vec![3, 1]), String::new()));
    assert_eq!(
        shape(&format!("{triangles} 3")).1,
        "shape `trianglemesh` has 2 faces, but 1 values of `faceIndices`"
    );
    assert_eq!(shape(&format!("{triangles} [ 3 -1 ]")).1, "face index -1 is negative");
    let ply = "Shape \"plymesh\" \"string filename\" \"q.ply\"";
    assert_eq!(shape(ply), (Some(vec![5]), String::new()));
    // Both halves of a quadrilateral that is displaced.
    let displaced = format!("Texture \"h\" \"float\" \"constant\" {ply} \"texture displacement\" \"h\"");
    assert_eq!(shape(&displaced), (Some(vec![5, 5]), String::new()));
}
