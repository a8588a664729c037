//! Bare meshes through the public interface: found by extension, decompressed, framed, and told about.

use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use sahl_load::{Loaded, MemoryAssets, load};
use sahl_scene::{Geometry, Texture};

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
     element face 2\nproperty list uchar int vertex_indices\nend_header\n\
     0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2\n";

const OBJ: &str =
    "mtllib model.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl wall\nf 1/1 2/2 3/3\n";

const MTL: &str = "newmtl wall\nKd 1 1 1\nmap_Kd textures/wall.pfm\n";

/// A picture of one white pixel.
const PFM: &[u8] = b"PF\n1 1\n-1.0\n\0\0\x80\x3f\0\0\x80\x3f\0\0\x80\x3f";

fn assets() -> MemoryAssets {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(PLY.as_bytes()).expect("writing to memory");
    let mut assets = MemoryAssets::default();
    assets.insert("models/a.PLY", PLY);
    assets.insert("models/a.ply.gz", gzip.finish().expect("writing to memory"));
    assets.insert("models/model.obj", OBJ);
    assets.insert("models/model.mtl", MTL);
    assets.insert("models/textures/wall.pfm", PFM);
    assets.insert("models/bad.ply", PLY.replace("4 0 1 2 3", "4 0 1 2 9"));
    assets.insert("models/bad.obj", OBJ.replace("3/3", "3/7"));
    assets.insert("models/noise.obj", (0..=255).cycle().take(4000).collect::<Vec<u8>>());
    assets
}

fn read(path: &str) -> Loaded {
    load(Path::new(path), &assets())
}

fn told(loaded: &Loaded) -> String {
    loaded.diagnostics.render_text(&loaded.sources, false)
}

#[test]
fn a_ply_file_becomes_a_lit_scene_with_a_camera() {
    for path in ["models/a.PLY", "models/a.ply.gz"] {
        let loaded = read(path);
        assert_eq!(told(&loaded), "");
        let scene = &loaded.scene;
        assert!(scene.validate().is_empty());
        assert_eq!((scene.triangle_meshes.len(), scene.patch_meshes.len()), (1, 1));
        assert!(scene.shapes.values().iter().any(|shape| shape.area_light.is_some()));
        assert!(scene.shapes.values().iter().any(|shape| matches!(shape.geometry, Geometry::Disk { .. })));
        assert_ne!(scene.camera, sahl_scene::Camera::default());
    }
}

#[test]
fn an_obj_file_brings_its_materials_and_textures() {
    let loaded = read("models/model.obj");
    assert_eq!(told(&loaded), "");
    assert!(loaded.scene.validate().is_empty());
    assert_eq!(loaded.scene.images.len(), 1);
    assert!(matches!(loaded.scene.textures.values(), [Texture::Image(_)]));
    let names: Vec<&str> = loaded.sources.files().iter().map(|file| file.name.as_str()).collect();
    assert_eq!(names, ["models/model.obj", "models/model.mtl"]);
}

#[test]
fn damaged_files_give_errors_with_places() {
    insta::assert_snapshot!(told(&read("models/bad.ply")) + &told(&read("models/bad.obj")), @r"
    error[bad-mesh]: vertex 9 of 4: the index is out of range (in row 1 of 2 of `face`)
      --> models/bad.ply:14:9
       |
    14 | 4 0 1 2 9
       |         ^

    error[bad-face]: texture coordinate 7 is out of range: 3 are defined before this line
     --> models/bad.obj:9:11
      |
    9 | f 1/1 2/2 3/7
      |           ^^^
    ");
    assert!(read("models/noise.obj").diagnostics.has_errors());
    assert!(read("models/none.obj").diagnostics.has_errors());
}
