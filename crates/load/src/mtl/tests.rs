use proptest::prelude::*;
use sahl_scene::{
    ConductorReflectance, FloatParam, ImageTexture, Roughness, Spectrum, SpectrumParam, Texture,
    TextureMapping, UvMapping, Wrap,
};

use super::*;
use crate::MemoryAssets;

/// A picture of two by one pixels, black and white.
const PFM: &[u8] = b"Pf\n2 1\n-1.0\n\0\0\0\0\0\0\x80\x3f";

/// What became of the material `m` of an MTL file, beside which lies an image.
struct Read {
    scene: SceneDesc,
    built: MtlMaterial,
    told: String,
}

fn read(mtl: &str) -> Read {
    let mut assets = MemoryAssets::default();
    assets.insert("dir/maps/a.pfm", PFM);
    assets.insert("dir/b c.pfm", PFM);
    assets.insert("dir/text.png", *b"no image");
    let (mut library, mut scene) = (Library::default(), SceneDesc::default());
    let (mut sources, mut diagnostics) = (Sources::default(), Diagnostics::default());
    library.read(Path::new("dir/m.mtl"), mtl.as_bytes().to_vec(), &mut sources, &mut diagnostics);
    let built = library.material("m", &mut scene, &mut diagnostics, &assets).expect("the material");
    assert_eq!(library.material("m", &mut scene, &mut diagnostics, &assets).as_ref(), Some(&built));
    assert_eq!(scene.materials.len(), 1);
    library.report(&mut diagnostics);
    Read { scene, built, told: diagnostics.render_text(&sources, false) }
}

/// The material, about which there is nothing to tell.
fn silent(mtl: &str) -> Material {
    let Read { scene, built, told } = read(mtl);
    assert_eq!(told, "");
    scene.materials[built.material].clone()
}

fn diffuse(rgb: [f32; 3]) -> Material {
    Material::Diffuse { reflectance: SpectrumParam::Constant(Spectrum::srgb(rgb)) }
}

fn conductor(rgb: [f32; 3], alpha: f32) -> Material {
    let alpha = FloatParam::Constant(alpha);
    Material::Conductor {
        reflectance: ConductorReflectance::Normal(SpectrumParam::Constant(Spectrum::srgb(rgb))),
        roughness: Roughness { u: alpha, v: alpha, remap: false },
    }
}

fn glass(eta: f32) -> Material {
    Material::Dielectric { eta: Spectrum::Constant(eta), roughness: Roughness::SMOOTH }
}

fn image_texture(read: &Read) -> &ImageTexture {
    match read.scene.textures.values() {
        [Texture::Image(texture)] => texture,
        other => panic!("{other:?}"),
    }
}

#[test]
fn matte_materials_are_diffuse() {
    assert_eq!(
        silent("newmtl m\nKa 1 1 1\nKd 0.1 0.2 0.3\nKs 0 0 0\nNs 10\nd 1\nillum 2\n"),
        diffuse([0.1, 0.2, 0.3])
    );
    assert_eq!(silent("newmtl m\nkd .25\n"), diffuse([0.25; 3]));
    assert_eq!(silent("newmtl m\n"), Material::default());
}

#[test]
fn transparent_materials_are_glass() {
    for illum in [4, 6, 7, 9] {
        assert_eq!(silent(&format!("newmtl m\nillum {illum}\nNi 1.33\nKs 1 1 1\n")), glass(1.33));
    }
    assert_eq!(silent("newmtl m\nd 0.2\n"), glass(1.5));
    assert_eq!(silent("newmtl m\nTr 0.8\nNi 1.0\nTf 1 1 1\n"), glass(1.5));
}

#[test]
fn mirrors_are_conductors() {
    assert_eq!(silent("newmtl m\nillum 3\nKd 0 0 0\nKs 0.9 0.8 0.7\n"), conductor([0.9, 0.8, 0.7], 0.0));
    assert_eq!(silent("newmtl m\nillum 5\nKs 0.9 0.8 0.7\nNs 198\n"), conductor([0.9, 0.8, 0.7], 0.1));
    assert_eq!(silent("newmtl m\nPm 1\nPr 0.5\nKd 0.9 0.6 0.2\n"), conductor([0.9, 0.6, 0.2], 0.25));
    let Read { scene, built, told } = read("newmtl m\nillum 3\nKd 0.8 0.1 0.1\nKs 0.04 0.04 0.04\n");
    assert_eq!(scene.materials[built.material], diffuse([0.8, 0.1, 0.1]));
    assert!(told.contains("highlights (`Ks`)"), "{told}");
}

#[test]
fn emission_lights_both_sides() {
    let light = read("newmtl m\nKe 1 2 3\n").built.area_light.unwrap();
    assert_eq!(
        (light.radiance, light.two_sided),
        (SpectrumParam::Constant(Spectrum::srgb([1.0, 2.0, 3.0])), true)
    );
    assert_eq!(read("newmtl m\nKe 0 0 0\n").built.area_light, None);
}

#[test]
fn a_texture_is_dimmed_by_a_grey_colour() {
    let read = read("newmtl m\nKd 0.5 0.5 0.5\nmap_Kd maps\\a.pfm\n");
    let texture = image_texture(&read);
    assert_eq!(
        (texture.scale, texture.wrap, texture.mapping),
        (0.5, Wrap::Repeat, TextureMapping::default())
    );
    assert_eq!(read.scene.images.len(), 1);
    assert_eq!(read.told, "");
}

#[test]
fn a_black_colour_beside_a_texture_counts_as_white() {
    assert_eq!(image_texture(&read("newmtl m\nKd 0 0 0\nmap_Kd maps/a.pfm\n")).scale, 1.0);
}

#[test]
fn texture_options_are_read() {
    let read = read("newmtl m\nmap_Kd -s 2 3 1 -o 0.25 -clamp on b c.pfm\n");
    let texture = image_texture(&read);
    assert_eq!(texture.mapping, TextureMapping::Uv(UvMapping { scale: [2.0, 3.0], offset: [0.25, 0.0] }));
    assert_eq!(texture.wrap, Wrap::Clamp);
    assert_eq!(read.told, "");
}

#[test]
fn a_texture_of_another_machine_is_found_by_its_name() {
    assert_eq!(read("newmtl m\nmap_Kd C:\\Users\\me\\b c.pfm\n").scene.images.len(), 1);
}

#[test]
fn each_image_is_read_once() {
    let mut assets = MemoryAssets::default();
    assets.insert("a.pfm", PFM);
    let (mut library, mut scene) = (Library::default(), SceneDesc::default());
    let (mut sources, mut diagnostics) = (Sources::default(), Diagnostics::default());
    let mtl = b"newmtl m\nmap_Kd a.pfm\nnewmtl n\nmap_Kd -s 2 2 a.pfm\nnewmtl m\nKd 1 1 1\n";
    library.read(Path::new("m.mtl"), mtl.to_vec(), &mut sources, &mut diagnostics);
    for name in ["m", "n"] {
        library.material(name, &mut scene, &mut diagnostics, &assets).unwrap();
    }
    assert_eq!((scene.images.len(), scene.textures.len()), (1, 2));
    assert_eq!(diagnostics.iter().map(|diagnostic| diagnostic.code).collect::<Vec<_>>(), ["second-material"]);
}

#[test]
fn what_is_not_honoured_is_told_once() {
    insta::assert_snapshot!(read(
        "newmtl m\nKd 1 0.5 0.5\nmap_Kd -mm 0 2 -blendu off maps/a.pfm\nmap_Bump -bm 0.2 a.png\nnorm a.png\nmap_d a.png\n\
         Ks 0.5 0.5 0.5\nd 0.75\nPc 1\nrefl -type sphere a.png\nKs xyz 1 2 3\n"
    ).told, @r"
    warning[not-honoured]: `Ks` `xyz` is not honoured: give red, green and blue
      --> dir/m.mtl:11:4
       |
    11 | Ks xyz 1 2 3
       |    ^^^

    warning[not-honoured]: a coloured `Kd` beside `map_Kd` is not honoured: its largest component dims the map
     --> dir/m.mtl:2:1
      |
    2 | Kd 1 0.5 0.5
      | ^^
      |
      = note: in material `m`

    warning[not-honoured]: bump and normal maps are not honoured: surfaces are smooth
     --> dir/m.mtl:4:1
      |
    4 | map_Bump -bm 0.2 a.png
      | ^^^^^^^^
      |
      = note: in material `m`

    warning[not-honoured]: highlights (`Ks`) of diffuse materials are not honoured
     --> dir/m.mtl:7:1
      |
    7 | Ks 0.5 0.5 0.5
      | ^^
      |
      = note: in material `m`

    warning[not-honoured]: of the options of textures only `-s`, `-o` and `-clamp` are honoured
     --> dir/m.mtl:3:8
      |
    3 | map_Kd -mm 0 2 -blendu off maps/a.pfm
      |        ^^^
      |
      = note: in material `m`

    warning[not-honoured]: opacity maps (`map_d`) are not honoured: surfaces are whole
     --> dir/m.mtl:6:1
      |
    6 | map_d a.png
      | ^^^^^
      |
      = note: in material `m`

    warning[not-honoured]: partial opacity (`d`, `Tr`) is not honoured: surfaces are opaque
     --> dir/m.mtl:8:1
      |
    8 | d 0.75
      | ^
      |
      = note: in material `m`

    warning[not-honoured]: reflection maps (`refl`) are not honoured
      --> dir/m.mtl:10:1
       |
    10 | refl -type sphere a.png
       | ^^^^
       |
       = note: in material `m`

    warning[not-honoured]: sheen and clear coat (`Ps`, `Pc`, `Pcr`) are not honoured
     --> dir/m.mtl:9:1
      |
    9 | Pc 1
      | ^^
      |
      = note: in material `m`
    ");
}

#[test]
fn mistakes_are_told_with_their_places() {
    insta::assert_snapshot!(read(
        "Kd 1 1 1\nnewmtl\nnewmtl m\nKd 1 2\nKd red\nKs -1 0 0\nNs\nd inf\nmap_Kd -s 2 2\nmap_Kd -o nan 0 missing.png\nKdd 1\n"
    ).told, @r"
    warning[bad-statement]: `Kd` before the first `newmtl` is left out
     --> dir/m.mtl:1:1
      |
    1 | Kd 1 1 1
      | ^^

    error[bad-statement]: `newmtl` without a name
     --> dir/m.mtl:2:1
      |
    2 | newmtl
      | ^^^^^^

    error[bad-number]: `Kd` with 2 numbers: expected three
     --> dir/m.mtl:4:1
      |
    4 | Kd 1 2
      | ^^

    error[bad-number]: expected a number of zero or more, found `red`
     --> dir/m.mtl:5:4
      |
    5 | Kd red
      |    ^^^

    error[bad-number]: expected a number of zero or more, found `-1`
     --> dir/m.mtl:6:4
      |
    6 | Ks -1 0 0
      |    ^^

    error[bad-number]: expected a finite number after `Ns`, found nothing
     --> dir/m.mtl:7:1
      |
    7 | Ns
      | ^^

    error[bad-number]: expected a finite number after `d`, found `inf`
     --> dir/m.mtl:8:3
      |
    8 | d inf
      |   ^^^

    error[bad-statement]: `map_Kd` without a file name
     --> dir/m.mtl:9:1
      |
    9 | map_Kd -s 2 2
      | ^^^^^^

    error[bad-number]: `-o` with a number that is not finite
      --> dir/m.mtl:10:8
       |
    10 | map_Kd -o nan 0 missing.png
       |        ^^

    warning[unknown-statement]: unknown statement `Kdd`; did you mean `Kd`?
      --> dir/m.mtl:11:1
       |
    11 | Kdd 1
       | ^^^

    warning[unreadable-file]: can't read `dir/missing.png`: no such file
      --> dir/m.mtl:10:17
       |
    10 | map_Kd -o nan 0 missing.png
       |                 ^^^^^^^^^^^
       |
       = note: the colour `Kd` is used alone
    ");
    insta::assert_snapshot!(read("newmtl m\nmap_Kd text.png\n").told, @r"
    warning[unreadable-file]: can't decode `dir/text.png`: not a valid PNG file: it does not begin as one
     --> dir/m.mtl:2:8
      |
    2 | map_Kd text.png
      |        ^^^^^^^^
      |
      = note: the colour `Kd` is used alone
    ");
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(5),
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_words_do_no_harm(words in proptest::collection::vec(prop_oneof![
        Just("\n"), Just("\nKd"), Just("\nd"), Just("\nmap_Kd"), Just("\nnewmtl"), Just("\nillum"), Just("\nNs"), Just("-s"), Just("-o"),
        Just("1"), Just("-1"), Just("0.5"), Just("nan"), Just("4"), Just("maps/a.pfm"), Just("\\"), Just("#")
    ], 0..80)) {
        let Read { mut scene, told, .. } = read(&format!("newmtl m\n{}", words.join(" ")));
        scene.integrator = sahl_scene::Integrator::Normals;
        prop_assert!(!scene.validate().has_errors(), "{told}");
    }
}
