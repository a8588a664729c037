use proptest::prelude::*;
use sahl_math::{Vec2, Vec3};

use super::*;

const TETRAHEDRON: &str = "ply
format ascii 1.0
comment four faces
element vertex 4
property float x
property float y
property float z
element face 4
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
0 0 1
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
";

fn ascii(header: &str, body: &str) -> Vec<u8> {
    format!("ply\nformat ascii 1.0\n{header}end_header\n{body}").into_bytes()
}

/// The header of vertices with positions and of faces.
fn plain(vertices: u32, faces: u32) -> String {
    format!(
        "element vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\n"
    )
}

fn error(bytes: &[u8]) -> String {
    read(bytes).expect_err("an error").to_string()
}

#[test]
fn a_tetrahedron_is_read() {
    let mesh = read(TETRAHEDRON.as_bytes()).unwrap();
    let triangles = mesh.triangles.unwrap();
    assert_eq!(&*triangles.indices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    assert_eq!(&*triangles.positions, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]);
    assert_eq!((triangles.normals, triangles.uvs, mesh.patches), (None, None, None));
    assert!(mesh.warnings.is_empty());
}

#[test]
fn lines_may_end_in_three_ways() {
    let unix = read(TETRAHEDRON.as_bytes()).unwrap();
    assert_eq!(read(TETRAHEDRON.replace('\n', "\r\n").as_bytes()).unwrap(), unix);
    assert_eq!(read(TETRAHEDRON.replace('\n', "\r").as_bytes()).unwrap(), unix);
}

#[test]
fn binary_values_may_start_with_the_byte_of_a_line_end() {
    // 0x0A0A0A0A as a float, right after a header with Unix line ends.
    let mut bytes = ascii(&plain(3, 1), "");
    bytes = String::from_utf8(bytes).unwrap().replace("ascii", "binary_little_endian").into_bytes();
    for _ in 0..9 {
        bytes.extend([0x0A; 4]);
    }
    bytes.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    let triangles = read(&bytes).unwrap().triangles.unwrap();
    assert_eq!(triangles.positions[0], Vec3::splat(f32::from_bits(0x0A0A_0A0A)));
}

#[test]
fn a_quadrilateral_becomes_a_patch_with_the_last_two_corners_swapped() {
    let mesh = read(&ascii(&plain(4, 1), "0 0 0 1 0 0 1 1 0 0 1 0\n4 0 1 2 3\n")).unwrap();
    assert_eq!(&*mesh.patches.unwrap().indices, [[0, 1, 3, 2]]);
    assert_eq!(mesh.triangles, None);
}

#[test]
fn both_kinds_of_faces_share_vertices() {
    let body = "0 0 0 1 0 0 1 1 0 0 1 0\n4 0 1 2 3\n3 0 1 2\n";
    let mesh = read(&ascii(&plain(4, 2), body)).unwrap();
    let (triangles, patches) = (mesh.triangles.unwrap(), mesh.patches.unwrap());
    assert!(Arc::ptr_eq(&triangles.positions, &patches.positions));
}

#[test]
fn faces_keep_the_numbers_that_the_file_gives_them() {
    let header = plain(5, 4) + "property int face_indices\n";
    let vertices = "0 0 0 1 0 0 1 1 0 0 1 0 2 2 2\n";
    // A quadrilateral, a triangle, a face without area, and a polygon that becomes three triangles.
    let mesh =
        read(&ascii(&header, &format!("{vertices}4 0 1 2 3 7\n3 0 1 2 5\n3 0 0 1 6\n5 0 1 2 3 4 9\n")))
            .unwrap();
    assert_eq!(mesh.patches.unwrap().face_indices.as_deref(), Some(&[7][..]));
    assert_eq!(mesh.triangles.unwrap().face_indices.as_deref(), Some(&[5, 9, 9, 9][..]));
    let negative = ascii(&header, &format!("{vertices}4 0 1 2 3 -7\n3 0 1 2 5\n3 0 0 1 6\n3 0 1 2 9\n"));
    assert!(error(&negative).contains("face index -7 is out of range"), "{}", error(&negative));
    let list = header.replace("int face_indices", "float face_indices");
    assert!(
        error(&ascii(&list, &format!("{vertices}4 0 1 2 3 7\n")))
            .contains("`face_indices` must be an integer")
    );
}

#[test]
fn larger_polygons_become_fans() {
    let body = "0 0 0 1 0 0 2 1 0 1 2 0 0 1 0\n5 0 1 2 3 4\n";
    let mesh = read(&ascii(&plain(5, 1), body)).unwrap();
    assert_eq!(&*mesh.triangles.unwrap().indices, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    assert_eq!(mesh.warnings, ["1 faces with more than four vertices are split into fans"]);
}

#[test]
fn degenerate_faces_are_left_out_and_told() {
    let body = "0 0 0 1 0 0 1 1 0 0 1 0\n3 0 0 1\n2 0 1\n0\n4 0 1 1 2\n4 0 1 0 1\n3 0 1 2\n";
    let mesh = read(&ascii(&plain(4, 6), body)).unwrap();
    assert_eq!(&*mesh.triangles.unwrap().indices, [[0, 1, 2], [0, 1, 2]]);
    assert_eq!(mesh.patches, None);
    assert_eq!(mesh.warnings, ["4 faces with fewer than three different vertices are left out"]);
}

#[test]
fn properties_of_any_type_and_order_are_found_and_others_skipped() {
    let header = "element camera 1\nproperty list uint8 double stuff\nproperty float focus\n\
         element vertex 3\nproperty uchar red\nproperty double z\nproperty list uchar short tags\nproperty short y\n\
         property float t\nproperty int8 x\nproperty float s\nproperty float quality\n\
         property float nx\nproperty float nz\nproperty float ny\n\
         element edge 2\nproperty int a\nproperty int b\n\
         element face 1\nproperty uchar flags\nproperty list int uint vertex_index\nproperty list uchar float texcoord\n\
         property int face_indices\n";
    let body = "2 0.5 0.25 7\n\
         255 3.5 2 9 9 2 0.75 1 0.25 99 1 3 2\n\
         255 6 0 5 0.5 4 0 99 0 0 1\n\
         255 9 1 1 8 0 7 1 99 0 0 1\n\
         0 1 1 2\n\
         7 3 2 1 0 2 0.1 0.2 5\n";
    let triangles = read(&ascii(header, body)).unwrap().triangles.unwrap();
    assert_eq!(&*triangles.indices, [[2, 1, 0]]);
    assert_eq!(&*triangles.positions, [[1.0, 2.0, 3.5], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]].map(Vec3::from));
    assert_eq!(
        &**triangles.normals.as_ref().unwrap(),
        [[1.0, 2.0, 3.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3::from)
    );
    assert_eq!(&**triangles.uvs.as_ref().unwrap(), [[0.25, 0.75], [0.0, 0.5], [1.0, 0.0]].map(Vec2::from));
}

#[test]
fn faces_may_come_before_vertices() {
    let header = "element face 1\nproperty list uchar int vertex_indices\n\
         element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let mesh = read(&ascii(header, "3 0 1 2\n0 0 0 1 0 0 0 1 0\n")).unwrap();
    assert_eq!(&*mesh.triangles.unwrap().indices, [[0, 1, 2]]);
}

#[test]
fn normals_without_direction_and_infinite_texture_coordinates_are_repaired() {
    let header = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v\n\
         element face 1\nproperty list uchar int vertex_indices\n";
    let body = "0 0 0 0 0 0 0 0\n1 0 0 nan 0 0 1 inf\n0 1 0 1 0 0 0 1\n3 0 1 2\n";
    let mesh = read(&ascii(header, body)).unwrap();
    let triangles = mesh.triangles.unwrap();
    assert_eq!(&**triangles.normals.as_ref().unwrap(), [Vec3::Z, Vec3::Z, Vec3::X]);
    assert_eq!(triangles.uvs.as_ref().unwrap()[1], Vec2::ZERO);
    insta::assert_debug_snapshot!(mesh.warnings, @r#"
    [
        "1 texture coordinates that are not finite are taken for zero",
        "2 normals without direction are computed from the faces",
    ]
    "#);
}

#[test]
fn integers_may_be_printed_as_floats() {
    let mesh = read(&ascii(&plain(3, 1), "0 0 0 1 0 0 0 1 0\n3.0 0.0 1e0 +2\n")).unwrap();
    assert_eq!(&*mesh.triangles.unwrap().indices, [[0, 1, 2]]);
}

#[test]
fn damaged_headers_are_told_with_their_lines() {
    let errors: Vec<String> = [
        "",
        "plywood\n",
        "ply\nformat ascii 1.0\n",
        "ply\nelement vertex 1\nend_header\n",
        "ply\nformat ascii 2.0\nend_header\n",
        "ply\nformat binary_middle_endian 1.0\nend_header\n",
        "ply\nformat ascii 1.0\nformat ascii 1.0\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex many\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex -3\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 3 4\nend_header\n",
        "ply\nformat ascii 1.0\nproperty float x\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty flaot x\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty list float int x\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty list float x\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 3\nelement vertex 3\nend_header\n",
        "ply\nformat ascii 1.0\nelemnt vertex 3\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 3\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nelement face 0\nend_header\n",
        "ply\nformat ascii 1.0\nelement verteces 3\nelement face 1\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty int vertex_indices\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty list int int z\nelement face 1\nend_header\n",
    ]
    .iter()
    .map(|header| error(header.as_bytes()))
    .collect();
    insta::assert_snapshot!(errors.join("\n"), @r"
    line 1: not a PLY file: the first line is not `ply`
    line 1: not a PLY file: the first line is not `ply`
    line 3: the header does not end: expected `end_header`
    line 1: the header has no `format`
    line 2: unknown PLY version `2.0`: expected `1.0`
    line 2: unknown format `binary_middle_endian`: expected `ascii`, `binary_little_endian` or `binary_big_endian`
    line 3: a second `format`
    line 3: expected the number of `vertex`, found `many`
    line 3: expected the number of `vertex`, found `-3`
    line 3: `element` with too few or too many words
    line 3: a `property` before the first `element`
    line 4: unknown type `flaot`; did you mean `float`?
    line 4: the length of a list must have an integer type
    line 4: expected `property TYPE NAME` or `property list TYPE TYPE NAME`
    line 4: a second element `vertex`
    line 3: unknown word `elemnt` in the header; did you mean `element`?
    line 1: no element `face`; the file has `vertex`
    line 3: the vertices have no properties `x`, `y` and `z`
    line 1: no element `vertex`; the file has `verteces`, `face`
    line 3: 99999999999 vertices are more than indices can tell
    line 8: `vertex_indices` must be a list of integers
    line 6: the property `z` is a list: expected a number
    ");
}

#[test]
fn damaged_values_are_told_with_their_lines() {
    let errors: Vec<String> = [
        (plain(3, 1), "0 0 0\n1 0 0\n0 1"),
        (plain(3, 1), "0 0 0\n1 0,5 0\n0 1 0\n3 0 1 2"),
        (plain(3, 1), "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2"),
        (plain(3, 1), "0 0 0\n1 1e39 0\n0 1 0\n3 0 1 2"),
        (plain(3, 1), "0 0 0\n1 0 0\n0 1 0\n3 0 1 3"),
        (plain(3, 1), "0 0 0\n1 0 0\n0 1 0\n3 0 -1 2"),
        (plain(3, 1), "0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2"),
        (plain(3, 1), "0 0 0\n1 0 0\n0 1 0\n2000000000 0 1 2"),
        (plain(3, 1), "0 0 0\n1 0 0\n0 1 0\n-3 0 1 2"),
        (plain(3, 2), "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        (plain(3, 0), "0 0 0\n1 0 0\n0 1 0\n"),
        (plain(3, 1), "0 0 0\n1 0 0\n0 1 0\n3 1 1 1\n"),
    ]
    .iter()
    .map(|(header, body)| error(&ascii(header, body)))
    .collect();
    insta::assert_snapshot!(errors.join("\n"), @r"
    line 12: the file ends early (in row 3 of 3 of `vertex`)
    line 11: expected a number, found `0,5` (in row 2 of 3 of `vertex`)
    line 11: the position of vertex 1 is not finite: 1 NaN 0
    line 11: the position of vertex 1 is not finite: 1 inf 0
    line 13: vertex 3 of 3: the index is out of range (in row 1 of 1 of `face`)
    line 13: vertex -1 of 3: the index is out of range (in row 1 of 1 of `face`)
    line 13: expected an integer, found `1.5` (in row 1 of 1 of `face`)
    line 13: a list of 2000000000 values, which the file is too short for (in row 1 of 1 of `face`)
    line 13: a list of -3 values (in row 1 of 1 of `face`)
    line 14: the file ends early (in row 2 of 2 of `face`)
    line 7: no face has an area: there is nothing to render
    line 7: no face has an area: there is nothing to render
    ");
}

#[test]
fn damaged_binaries_are_told_with_their_offsets() {
    let sample =
        Sample { vertices: vec![[0.0; 8], [1.0; 8], [2.0; 8]], faces: vec![vec![0, 1, 2], vec![2, 1, 0]] };
    let whole = sample.write(Format::BigEndian);
    let body = whole.len() - 2 * 13 - 3 * 32;
    let mut errors = vec![error(&whole[..body + 40]), error(&whole[..whole.len() - 4])];
    let mut wrong_index = whole.clone();
    wrong_index[body + 3 * 32 + 4] = 3;
    errors.push(error(&wrong_index));
    let mut infinite = whole.clone();
    infinite[body + 32..body + 36].copy_from_slice(&f32::INFINITY.to_be_bytes());
    errors.push(error(&infinite));
    insta::assert_snapshot!(errors.join("\n"), @r"
    byte 294: the file ends early (in row 2 of 3 of `vertex`)
    byte 363: a list of 3 values, which the file is too short for (in row 2 of 2 of `face`)
    byte 351: vertex 3 of 3: the index is out of range (in row 1 of 2 of `face`)
    byte 286: the position of vertex 1 is not finite: inf 1 1
    ");
    assert_eq!(text(&whole).len(), body);
}

#[test]
fn absurd_counts_cost_neither_time_nor_memory() {
    let vertices = "property float x\nproperty float y\nproperty float z\n";
    let huge = [
        format!(
            "element vertex 4000000000\n{vertices}element face 1\nproperty list uchar int vertex_indices\n"
        ),
        format!(
            "element nothing 18446744073709551615\nelement vertex 4294967295\n{vertices}element face 1\nproperty list uchar int vertex_indices\n"
        ),
        format!(
            "element vertex 3\n{vertices}element face 18446744073709551615\nproperty list uint uint vertex_indices\n"
        ),
    ];
    for header in huge {
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let mut bytes = format!("ply\nformat {format} 1.0\n{header}end_header\n").into_bytes();
            bytes.extend([b'1', b' '].repeat(40));
            assert!(read(&bytes).is_err());
        }
    }
}

#[test]
fn bytes_beyond_the_end_are_told() {
    let mesh = read(format!("{TETRAHEDRON}\n\n").as_bytes()).unwrap();
    assert!(mesh.warnings.is_empty());
    let mesh = read(format!("{TETRAHEDRON}3 0 1 2").as_bytes()).unwrap();
    assert_eq!(mesh.warnings.len(), 1, "{:?}", mesh.warnings);
}

/// A mesh with all that is read, to be written in each format.
#[derive(Clone, Debug)]
struct Sample {
    vertices: Vec<[f32; 8]>,
    faces: Vec<Vec<u32>>,
}

impl Sample {
    fn write(&self, format: Format) -> Vec<u8> {
        let name = match format {
            Format::Ascii => "ascii",
            Format::LittleEndian => "binary_little_endian",
            Format::BigEndian => "binary_big_endian",
        };
        let properties: String = ["x", "y", "z", "nx", "ny", "nz", "u", "v"]
            .iter()
            .map(|name| format!("property float {name}\n"))
            .collect();
        let mut bytes = format!(
            "ply\nformat {name} 1.0\nelement vertex {}\n{properties}element face {}\n\
             property list uchar int vertex_indices\nend_header\n",
            self.vertices.len(),
            self.faces.len()
        )
        .into_bytes();
        let mut number = |bits: u32, text: String| match format {
            Format::Ascii => bytes.extend(text.into_bytes()),
            Format::LittleEndian => bytes.extend(bits.to_le_bytes()),
            Format::BigEndian => bytes.extend(bits.to_be_bytes()),
        };
        for &value in self.vertices.as_flattened() {
            number(value.to_bits(), format!("{value} "));
        }
        for face in &self.faces {
            if format == Format::Ascii {
                bytes.extend(format!("\n{}", face.len()).into_bytes());
            } else {
                bytes.push(face.len() as u8);
            }
            for &index in face {
                match format {
                    Format::Ascii => bytes.extend(format!(" {index}").into_bytes()),
                    Format::LittleEndian => bytes.extend(index.to_le_bytes()),
                    Format::BigEndian => bytes.extend(index.to_be_bytes()),
                }
            }
        }
        bytes
    }
}

fn samples() -> impl Strategy<Value = Sample> {
    let number = prop_oneof![-1e3f32..1e3, Just(0.1f32), Just(-0.0f32), Just(f32::MAX), Just(1e-42f32)];
    let vertex = proptest::array::uniform8(number);
    proptest::collection::vec(vertex, 3..30).prop_flat_map(|vertices| {
        let index = 0..vertices.len() as u32;
        let face = proptest::collection::vec(index, 0..7);
        (Just(vertices), proptest::collection::vec(face, 1..30))
            .prop_map(|(vertices, faces)| Sample { vertices, faces })
    })
}

/// Bytes to put somewhere.
fn edits() -> impl Strategy<Value = Vec<(usize, u8)>> {
    let byte = prop_oneof![any::<u8>(), Just(b'\n'), Just(b' '), Just(b'9'), Just(0xFF)];
    proptest::collection::vec((any::<usize>(), byte), 1..6)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(5),
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_three_formats_agree(sample in samples()) {
        let ascii = read(&sample.write(Format::Ascii));
        let little = read(&sample.write(Format::LittleEndian));
        let big = read(&sample.write(Format::BigEndian));
        match (ascii, little, big) {
            (Ok(ascii), Ok(little), Ok(big)) => {
                let positions = |mesh: &PlyMesh| {
                    let triangles = mesh.triangles.as_ref().map(|mesh| mesh.positions.clone());
                    triangles.or(mesh.patches.as_ref().map(|mesh| mesh.positions.clone())).unwrap()
                };
                let expected: Vec<Vec3> = sample.vertices.iter().map(|v| Vec3::new(v[0], v[1], v[2])).collect();
                prop_assert_eq!(&*positions(&ascii), expected.as_slice());
                prop_assert_eq!(&ascii, &little);
                prop_assert_eq!(&ascii, &big);
            }
            (Err(ascii), Err(little), Err(big)) => {
                prop_assert_eq!(&ascii.message, &little.message);
                prop_assert_eq!(&ascii.message, &big.message);
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }

    #[test]
    fn damaged_files_do_no_harm(
        sample in samples(),
        format in prop_oneof![Just(Format::Ascii), Just(Format::LittleEndian), Just(Format::BigEndian)],
        edits in edits(),
        keep in 0.0f64..=1.2,
    ) {
        let mut bytes = sample.write(format);
        for (at, byte) in edits {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        bytes.truncate((bytes.len() as f64 * keep) as usize);
        match read(&bytes) {
            Ok(mesh) => {
                let triangles = mesh.triangles.unwrap_or_default();
                prop_assert!(triangles.indices.as_flattened().iter().all(|&i| (i as usize) < triangles.positions.len()));
                prop_assert!(triangles.positions.iter().all(|p| p.is_finite()));
                let patches = mesh.patches.unwrap_or_default();
                prop_assert!(patches.indices.as_flattened().iter().all(|&i| (i as usize) < patches.positions.len()));
            }
            Err(error) => prop_assert!(error.offset <= bytes.len()),
        }
    }
}
