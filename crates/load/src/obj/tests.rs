use proptest::prelude::*;
use sahl_math::{Vec2, Vec3};
use sahl_scene::{Severity, TriangleMesh};

use super::*;
use crate::MemoryAssets;

fn load_text(text: &str) -> Loaded {
    load("a.obj", text.as_bytes().to_vec(), &MemoryAssets::default())
}

/// The mesh of the only material.
fn only_mesh(text: &str) -> TriangleMesh {
    let loaded = load_text(text);
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics.render_text(&loaded.sources, false));
    let [mesh] = loaded.scene.triangle_meshes.values() else { panic!("one mesh") };
    mesh.clone()
}

fn told(text: &str) -> String {
    let loaded = load_text(text);
    loaded.diagnostics.render_text(&loaded.sources, false)
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn polygons_become_triangles() {
    let mesh = only_mesh(&format!("# a square\no square\ng side\n{SQUARE}s off\nf 1 2 3 4\n"));
    assert_eq!(&*mesh.indices, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(&*mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    assert_eq!((mesh.normals, mesh.uvs), (None, None));
}

#[test]
fn negative_indices_count_back_from_the_latest() {
    let mesh = only_mesh("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -1 -4 -3\n");
    let corners: Vec<Vec3> =
        mesh.indices.as_flattened().iter().map(|&index| mesh.positions[index as usize]).collect();
    assert_eq!(corners, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::ZERO, Vec3::X]);
}

#[test]
fn corners_that_agree_share_a_vertex() {
    let text = format!(
        "{SQUARE}vt 0 0\nvt 1 0\nvt 1 1 0\nvt 0.5\nvn 0 0 1\nvn 0 0 2\n\
         f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\nf 1/1/2 2/2/1 3/1/1\n"
    );
    let mesh = only_mesh(&text);
    assert_eq!(&*mesh.indices, [[0, 1, 2], [0, 2, 3], [4, 1, 5]]);
    let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.0], [0.0, 0.0], [0.0, 0.0]].map(Vec2::from);
    assert_eq!(&**mesh.uvs.as_ref().unwrap(), uvs);
    assert_eq!(mesh.normals.as_ref().unwrap()[4], Vec3::new(0.0, 0.0, 2.0));
}

#[test]
fn corners_without_normals_among_others_are_flat() {
    let mesh = only_mesh(&format!("{SQUARE}vn 1 0 0\nf 1//1 2//1 3//1\nf 1 3 4\nf 2 3//1 4\n"));
    let normals = mesh.normals.as_ref().unwrap();
    let of = |face: usize| mesh.indices[face].map(|index| normals[index as usize]);
    assert_eq!(of(0), [Vec3::X; 3]);
    assert_eq!(of(1), [Vec3::Z; 3]);
    assert_eq!(of(2), [Vec3::Z, Vec3::X, Vec3::Z]);
}

#[test]
fn each_material_becomes_a_shape() {
    let mut assets = MemoryAssets::default();
    assets.insert(
        "dir/m.mtl",
        *b"newmtl red\nKd 1 0 0\nnewmtl dark green\nKd 0 0.1 0\nKe 1 2 3\nnewmtl unused\nKs 1 1 1\n",
    );
    let text = format!(
        "mtllib m.mtl\n{SQUARE}f 1 2 3\nusemtl red\nf 1 2 4\nusemtl dark green\nf 2 3 4\nusemtl red\nf 1 3 4\n"
    );
    let loaded = load("dir/a.obj", text.into_bytes(), &assets);
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics.render_text(&loaded.sources, false));
    let scene = &loaded.scene;
    let counts: Vec<usize> = scene.triangle_meshes.values().iter().map(|mesh| mesh.indices.len()).collect();
    assert_eq!(counts, [1, 2, 1]);
    let names: Vec<Option<&str>> =
        scene.shapes.iter().take(3).map(|(shape, _)| scene.shapes.origin(shape).name.as_deref()).collect();
    assert_eq!(names, [None, Some("red"), Some("dark green")]);
    let emitting: Vec<bool> =
        scene.shapes.values().iter().take(3).map(|shape| shape.area_light.is_some()).collect();
    assert_eq!(emitting, [false, false, true]);
    assert_eq!(scene.materials[scene.shapes.values()[0].material], Material::default());
}

#[test]
fn an_emitting_model_gets_no_other_lamp() {
    let mut assets = MemoryAssets::default();
    assets.insert("m.mtl", *b"newmtl lamp\nKe 5 5 5\n");
    let loaded = load("a.obj", format!("mtllib m.mtl\nusemtl lamp\n{SQUARE}f 1 2 3\n").into_bytes(), &assets);
    let emitters = loaded.scene.shapes.values().iter().filter(|shape| shape.area_light.is_some()).count();
    assert_eq!((emitters, loaded.scene.lights.len()), (1, 1));
}

#[test]
fn mistakes_are_told_with_their_places() {
    insta::assert_snapshot!(told(&format!(
        "{SQUARE}v 1 x 0\nv 1 nan 2\nv 1 2\nf 1 2 9\nf 0 1 2\nf 1 2 3/4\nf 1/ 2//\nf a b c\nf 1/1/1/1 2 3\n\
         f 1 2\nusemtl\nmtllib\nfaces 1 2 3\nf 1 2 3\n"
    )), @r"
    error[bad-number]: expected a finite number, found `x`
     --> a.obj:5:5
      |
    5 | v 1 x 0
      |     ^

    error[bad-number]: expected a finite number, found `nan`
     --> a.obj:6:5
      |
    6 | v 1 nan 2
      |     ^^^

    error[bad-number]: too few numbers after `v`
     --> a.obj:7:1
      |
    7 | v 1 2
      | ^

    error[bad-face]: vertex 9 is out of range: 7 are defined before this line
     --> a.obj:8:7
      |
    8 | f 1 2 9
      |       ^

    error[bad-face]: vertex 0: numbers start from one
     --> a.obj:9:3
      |
    9 | f 0 1 2
      |   ^

    error[bad-face]: texture coordinate 4 is out of range: 0 are defined before this line
      --> a.obj:10:7
       |
    10 | f 1 2 3/4
       |       ^^^

    warning[degenerate-face]: a face with 2 corners is left out
      --> a.obj:11:1
       |
    11 | f 1/ 2//
       | ^

    error[bad-face]: expected the number of a vertex, found `a`
      --> a.obj:12:3
       |
    12 | f a b c
       |   ^

    error[bad-face]: texture coordinate 1 is out of range: 0 are defined before this line
      --> a.obj:13:3
       |
    13 | f 1/1/1/1 2 3
       |   ^^^^^^^

    warning[degenerate-face]: a face with 2 corners is left out
      --> a.obj:14:1
       |
    14 | f 1 2
       | ^

    error[bad-statement]: `usemtl` without a name
      --> a.obj:15:1
       |
    15 | usemtl
       | ^^^^^^

    error[bad-statement]: `mtllib` without a file name
      --> a.obj:16:1
       |
    16 | mtllib
       | ^^^^^^

    warning[unknown-statement]: unknown statement `faces`
      --> a.obj:17:1
       |
    17 | faces 1 2 3
       | ^^^^^
    ");
}

#[test]
fn what_is_not_honoured_is_told() {
    insta::assert_snapshot!(told(&format!(
        "mtllib none.mtl\nv 0 0 0 1 0.5 0.5\n{SQUARE}usemtl gold\ns 1\nl 1 2\nl 2 3\np 1\ncstype bezier\ncurv 0 1 1 2\nf 1 2 3\n"
    )), @r"
    warning[not-honoured]: the colours of vertices are not honoured
     --> a.obj:2:15
      |
    2 | v 0 0 0 1 0.5 0.5
      |               ^^^

    warning[not-honoured]: `l` is not honoured: lines have no surface
     --> a.obj:9:1
      |
    9 | l 1 2
      | ^

    warning[not-honoured]: `p` is not honoured: points have no surface
      --> a.obj:11:1
       |
    11 | p 1
       | ^

    warning[not-honoured]: `cstype` is not honoured: free-form curves and surfaces are left out
      --> a.obj:12:1
       |
    12 | cstype bezier
       | ^^^^^^

    warning[not-honoured]: smoothing groups are not honoured: without normals (`vn`) every face is flat
     --> a.obj:8:1
      |
    8 | s 1
      | ^

    warning[unreadable-file]: can't read `none.mtl`: no such file
     --> a.obj:1:8
      |
    1 | mtllib none.mtl
      |        ^^^^^^^^
      |
      = note: surfaces with materials of this file are grey
    ");
}

#[test]
fn a_material_that_is_missing_is_told_with_the_nearest() {
    let mut assets = MemoryAssets::default();
    assets.insert("m.mtl", *b"newmtl brick\n");
    let loaded =
        load("a.obj", format!("mtllib m.mtl\n{SQUARE}usemtl birck\nf 1 2 3\n").into_bytes(), &assets);
    insta::assert_snapshot!(loaded.diagnostics.render_text(&loaded.sources, false), @r"
    warning[unknown-material]: no material is called `birck`; grey is used
     --> a.obj:6:8
      |
    6 | usemtl birck
      |        ^^^^^
      |
      = help: did you mean `brick`?
    ");
}

#[test]
fn a_file_without_faces_is_an_error() {
    for text in ["", "v 0 0 0\n", "v 0 0 0\nf 1 1 1\n", "\0\u{1}\u{2}binary"] {
        assert!(load_text(text).diagnostics.has_errors(), "{text:?}");
    }
}

#[test]
fn a_flood_of_mistakes_is_counted() {
    let text = format!("{SQUARE}{}f 1 2 3\n", "f 1 2 9\n".repeat(10_000));
    let loaded = load_text(&text);
    assert_eq!(loaded.diagnostics.iter().count(), 9);
    assert!(loaded.diagnostics.iter().last().unwrap().message.contains("9992 more"));
}

#[test]
fn many_different_corners_at_one_place_take_no_quadratic_time() {
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for i in 0..200_000 {
        text.push_str(&format!("vt {i} 0\n"));
    }
    for i in 0..200_000 {
        text.push_str(&format!("f 1/{} 2 3\n", i + 1));
    }
    assert_eq!(only_mesh(&text).indices.len(), 200_000);
}

/// Lines as they occur, sound and broken.
fn lines() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        (-4i32..9).prop_map(|n| n.to_string()),
        Just("1e39".to_owned()),
        Just("nan".to_owned()),
        Just("x".to_owned()),
        Just("99999999999999999999".to_owned())
    ];
    let part = proptest::collection::vec(number.clone(), 1..4).prop_map(|parts| parts.join("/"));
    let words = proptest::collection::vec(prop_oneof![3 => number, 1 => part], 0..7)
        .prop_map(|words| words.join(" "));
    let keyword = prop_oneof![
        Just("v"),
        Just("vt"),
        Just("vn"),
        Just("f"),
        Just("usemtl"),
        Just("mtllib"),
        Just("s"),
        Just("q")
    ];
    let end = prop_oneof![4 => Just("\n"), 1 => Just(" \\\n"), 1 => Just("\r\n"), 1 => Just(" # c\n")];
    (keyword, words, end).prop_map(|(keyword, words, end)| format!("{keyword} {words}{end}"))
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(5),
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_lines_give_a_valid_scene(lines in proptest::collection::vec(lines(), 0..60), cut in any::<prop::sample::Index>()) {
        let text = SQUARE.to_owned() + &lines.concat();
        let text = &text[..SQUARE.len() + cut.index(text.len() - SQUARE.len() + 1)];
        let loaded = load_text(text);
        let wrong = loaded.scene.validate().into_iter().find(|diagnostic| diagnostic.severity == Severity::Error);
        prop_assert_eq!(wrong, None);
        loaded.diagnostics.render_text(&loaded.sources, true);
    }

    #[test]
    fn any_bytes_do_no_harm(bytes in proptest::collection::vec(prop_oneof![any::<u8>(), Just(b'\n'), Just(b' '), Just(b'f'), Just(b'1')], 0..300)) {
        let mut assets = MemoryAssets::default();
        assets.insert("m.mtl", bytes.clone());
        load("a.obj", bytes, &assets);
        load("a.obj", format!("mtllib m.mtl\n{SQUARE}f 1 2 3\n").into_bytes(), &assets);
    }
}
