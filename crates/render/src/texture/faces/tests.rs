//! Faces laid out in a plane: what a filter finds there must not tell where they meet.

use sahl_scene::{Face, FaceImages, FaceTexels, Neighbor};
use sahl_testkit::random::Rng;

use super::*;
use crate::texture::Footprint;

/// Corners of faces in the plane, the edges from one to the next being 0 to 3.
type Quad = [[f32; 2]; 4];

/// A face of `2^log2` pixels with the neighbours `(edge, face, edge of that)`.
fn face(log2: [u8; 2], neighbors: &[(usize, u32, u8)]) -> Face {
    let mut face =
        Face { size_log2: log2, is_constant: false, is_part: false, first: 0, neighbors: [None; 4] };
    for &(edge, face_beyond, edge_beyond) in neighbors {
        face.neighbors[edge] = Some(Neighbor { face: face_beyond, edge: edge_beyond });
    }
    face
}

/// Images whose pixels are what `value` says of a face and of the middle of a pixel.
fn images(mut faces: Vec<Face>, mut value: impl FnMut(usize, Vec2) -> f32) -> Arc<FaceImages> {
    let mut values = Vec::new();
    for (i, face) in faces.iter_mut().enumerate() {
        face.first = values.len() as u64;
        let [width, height] = face.size_log2.map(|log| 1 << log);
        for k in 0..face.stored() as usize {
            let middle = Vec2::new((k % width) as f32 + 0.5, (k / width) as f32 + 0.5);
            values.push(value(i, Vec2::new(middle.x / width as f32, middle.y / height as f32)));
        }
    }
    Arc::new(FaceImages { channels: 1, faces: faces.into(), texels: FaceTexels::F32(values.into()) })
}

/// The place of (u, v) on a quadrilateral with straight edges.
fn in_plane(quad: &Quad, uv: Vec2) -> Vec2 {
    let [a, b, c, d] = quad.map(Vec2::from);
    let (low, high) = (a * (1.0 - uv.x) + b * uv.x, d * (1.0 - uv.x) + c * uv.x);
    low * (1.0 - uv.y) + high * uv.y
}

/// A function that a B-spline of one pixel's width reproduces.
fn plane(p: Vec2) -> f32 {
    1.0 + 0.5 * p.x - 0.25 * p.y
}

/// `quad` with its corners renamed: its first becomes number `turn`.
fn turned(quad: Quad, turn: usize) -> Quad {
    std::array::from_fn(|i| quad[(i + 4 - turn) % 4])
}

/// The faces that touch along whole edges, found by their corners.
fn adjacent(quads: &[Quad], log2: [u8; 2]) -> Vec<Face> {
    let edge = |quad: &Quad, e: usize| [quad[e], quad[(e + 1) % 4]];
    let neighbors = |own: usize, e: usize| {
        let [from, to] = edge(&quads[own], e);
        let others =
            quads.iter().enumerate().flat_map(|(i, quad)| (0..4).map(move |f| (i, f, edge(quad, f))));
        let shared = |&(_, _, other): &(usize, usize, [[f32; 2]; 2])| other == [to, from];
        others.filter(shared).map(|(i, f, _)| (e, i as u32, f as u8)).next()
    };
    (0..quads.len())
        .map(|i| face(log2, &(0..4).filter_map(|e| neighbors(i, e)).collect::<Vec<_>>()))
        .collect()
}

fn value(pyramid: &Pyramid, face: u32, uv: Vec2, width: [f32; 2]) -> f32 {
    pyramid.filtered(face, uv, Vec2::from(width))[0]
}

const LEFT: Quad = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
const RIGHT: Quad = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];

#[test]
fn planes_go_on_across_every_pair_of_edges() {
    for (turn, other_turn) in (0..4).flat_map(|a| (0..4).map(move |b| (a, b))) {
        let quads = [turned(LEFT, turn), turned(RIGHT, other_turn)];
        let images = images(adjacent(&quads, [4, 4]), |i, uv| plane(in_plane(&quads[i], uv)));
        let pyramid = Pyramid::new(&images).unwrap();
        let mut tested = 0;
        for (i, quad) in quads.iter().enumerate() {
            for k in 0..33 * 33 {
                let uv = Vec2::new((k % 33) as f32, (k / 33) as f32) * (1.0 / 32.0);
                let p = in_plane(quad, uv);
                // Away from borders, which are continued as they are.
                if (0.2..=1.8).contains(&p.x) && (0.2..=0.8).contains(&p.y) {
                    let found = value(&pyramid, i as u32, uv, [0.0; 2]);
                    assert!((found - plane(p)).abs() < 1e-5, "{turn} {other_turn}: {found} at {p:?}");
                    tested += 1;
                }
            }
        }
        assert!(tested > 500, "{tested}");
    }
}

#[test]
fn both_sides_of_an_edge_agree_under_every_footprint() {
    for (turn, other_turn) in (0..4).flat_map(|a| (0..4).map(move |b| (a, b))) {
        let quads = [turned(LEFT, turn), turned(RIGHT, other_turn)];
        let mut rng = Rng::new(7);
        let pyramid = Pyramid::new(&images(adjacent(&quads, [3, 3]), |_, _| rng.next_f32())).unwrap();
        // The shared edge is 1 and 3 of the faces as they were, at (1, y).
        let place = |turn: usize, edge: usize, y: f32| {
            let along = if edge == 1 { y } else { 1.0 - y };
            [[along, 0.0], [1.0, along], [1.0 - along, 1.0], [0.0, 1.0 - along]][(edge + turn) % 4]
        };
        for widths in [[0.0, 0.0], [0.2, 0.2], [0.3, 0.125], [0.1, 0.5], [1.0, 1.0], [9.0, 0.0]] {
            let width = |turn: usize| if turn.is_multiple_of(2) { widths } else { [widths[1], widths[0]] };
            for y in [0.3, 0.5, 0.625] {
                let one = value(&pyramid, 0, place(turn, 1, y).into(), width(turn));
                let other = value(&pyramid, 1, place(other_turn, 3, y).into(), width(other_turn));
                assert!((one - other).abs() < 1e-5, "{turn} {other_turn} {widths:?} {y}: {one} {other}");
            }
        }
    }
}

#[test]
fn planes_go_on_around_a_corner_of_four_faces() {
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let unturned = corners.map(|[x, y]| [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]]);
    for turns in [[0, 0, 0, 0], [1, 2, 3, 0], [3, 3, 1, 2]] {
        let quads: [Quad; 4] = std::array::from_fn(|i| turned(unturned[i], turns[i]));
        let images = images(adjacent(&quads, [4, 4]), |i, uv| plane(in_plane(&quads[i], uv)));
        let pyramid = Pyramid::new(&images).unwrap();
        for (i, quad) in quads.iter().enumerate() {
            let corner = quad.iter().position(|&corner| corner == [1.0, 1.0]).unwrap();
            let uv = Vec2::from([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][corner]);
            for uv in [uv, uv * 0.9 + Vec2::splat(0.05)] {
                let (found, expected) = (value(&pyramid, i as u32, uv, [0.0; 2]), plane(in_plane(quad, uv)));
                assert!((found - expected).abs() < 1e-5, "{turns:?} {i}: {found} {expected}");
            }
        }
    }
}

#[test]
fn planes_go_on_between_faces_and_their_halves() {
    // Right of a face two parts of half its height, as beside a triangle that was split.
    let lower: Quad = [[1.0, 0.0], [1.5, 0.0], [1.5, 0.5], [1.0, 0.5]];
    let upper: Quad = [[1.0, 0.5], [1.5, 0.5], [1.5, 1.0], [1.0, 1.0]];
    for (turn, lower_turn, upper_turn) in [(0, 0, 0), (1, 2, 3), (3, 1, 1), (2, 3, 0)] {
        let quads = [turned(LEFT, turn), turned(lower, lower_turn), turned(upper, upper_turn)];
        let mut faces = adjacent(&quads, [3, 3]);
        faces[0] = face([4, 4], &[((1 + turn) % 4, 1, ((3 + lower_turn) % 4) as u8)]);
        for (part, turn_of_part) in [(1, lower_turn), (2, upper_turn)] {
            faces[part].is_part = true;
            let edge = ((1 + turn) % 4) as u8;
            faces[part].neighbors[(3 + turn_of_part) % 4] = Some(Neighbor { face: 0, edge });
        }
        let pyramid = Pyramid::new(&images(faces, |i, uv| plane(in_plane(&quads[i], uv)))).unwrap();
        for (i, quad) in quads.iter().enumerate() {
            for k in 0..33 * 33 {
                let uv = Vec2::new((k % 33) as f32, (k / 33) as f32) * (1.0 / 32.0);
                let p = in_plane(quad, uv);
                if (0.2..=1.3).contains(&p.x) && (0.2..=0.8).contains(&p.y) {
                    let found = value(&pyramid, i as u32, uv, [0.0; 2]);
                    assert!((found - plane(p)).abs() < 1e-5, "{turn} {i}: {found} at {p:?}");
                }
            }
        }
    }
}

#[test]
fn what_is_constant_stays_constant() {
    // Three faces about the corner of a cube, one of other sizes, one constant, one next to itself.
    let mut faces = vec![
        face([3, 5], &[(0, 1, 3), (3, 2, 0)]),
        face([0, 4], &[(3, 0, 0), (0, 2, 3), (1, 1, 1)]),
        face([6, 6], &[(3, 1, 0), (0, 0, 3)]),
    ];
    faces[2].is_constant = true;
    let pyramid = Pyramid::new(&images(faces, |_, _| 0.375)).unwrap();
    let mut rng = Rng::new(3);
    for _ in 0..20_000 {
        let uv = Vec2::new(rng.next_f32(), rng.next_f32()) * 1.2 - Vec2::splat(0.1);
        let width = [rng.next_f32(), rng.next_f32()].map(|x| (x * 12.0 - 9.0).exp2());
        let found = value(&pyramid, (rng.next_f32() * 3.0) as u32, uv, width);
        assert!((found - 0.375).abs() < 1e-6, "{found} at {uv:?} over {width:?}");
    }
}

#[test]
fn pixels_are_weighted_by_the_spline() {
    // One pixel of 64 is lit.
    let lit = |pixel: Vec2| {
        images(vec![face([3, 3], &[])], move |_, uv| f32::from(u8::from((uv * 8.0 - pixel).length() < 0.1)))
    };
    let pyramid = Pyramid::new(&lit(Vec2::new(3.5, 4.5))).unwrap();
    let at = |x: f32, y: f32| value(&pyramid, 0, Vec2::new(x, y) * (1.0 / 8.0), [0.0; 2]);
    for (x, y, expected) in [
        (3.5, 4.5, 4.0 / 9.0),
        (4.5, 4.5, 1.0 / 9.0),
        (4.5, 3.5, 1.0 / 36.0),
        (4.0, 4.5, 23.0 / 72.0),
        (5.5, 4.5, 0.0),
    ] {
        assert!((at(x, y) - expected).abs() < 1e-6, "{x} {y}: {} {expected}", at(x, y));
    }
    // At a border its pixels go on: the lit one is there three times.
    let pyramid = Pyramid::new(&lit(Vec2::new(0.5, 4.5))).unwrap();
    let found = value(&pyramid, 0, Vec2::new(0.5 / 8.0, 4.5 / 8.0), [0.0; 2]);
    assert!((found - (5.0 / 6.0) * (2.0 / 3.0)).abs() < 1e-6, "{found}");
}

#[test]
fn wide_footprints_see_the_mean() {
    let mut rng = Rng::new(9);
    let images = images(vec![face([5, 4], &[])], |_, _| rng.next_f32());
    let FaceTexels::F32(values) = &images.texels else { unreachable!() };
    let mean = values.iter().sum::<f32>() / values.len() as f32;
    let pyramid = Pyramid::new(&images).unwrap();
    let variance = |width: [f32; 2]| {
        let at = |k: u32| Vec2::new((k % 20) as f32 + 0.5, (k / 20) as f32 + 0.5) * (1.0 / 20.0);
        let squares = (0..400).map(|k| (value(&pyramid, 0, at(k), width) - mean).powi(2));
        squares.sum::<f32>() / 400.0
    };
    let found = [[0.0, 0.0], [0.1, 0.1], [0.3, 0.3], [5.0, 5.0]].map(variance);
    assert!(found.windows(2).all(|pair| pair[1] < 0.7 * pair[0]), "{found:?}");
    // Long ones smooth along their length.
    assert!(variance([0.5, 0.0]) < 0.7 * found[0]);
}

#[test]
fn decoding_comes_after_filtering() {
    let images = images(vec![face([1, 0], &[])], |_, uv| f32::from(u8::from(uv.x > 0.5)));
    let node = |encoding, scale| {
        let texture = FaceTexture { images: Arc::clone(&images), encoding, scale };
        FaceNode::new(&texture, Arc::new(Pyramid::new(&images).unwrap()))
    };
    let middle = TexturePoint { uv: Vec2::splat(0.5), ..TexturePoint::default() };
    let number = |node: FaceNode, at: &TexturePoint| match node.value(at) {
        FaceValue::Number(value) => value,
        FaceValue::Color(_) => panic!("there is one channel"),
    };
    assert!((number(node(Encoding::Linear, 3.0), &middle) - 1.5).abs() < 1e-6);
    assert!((number(node(Encoding::Gamma(2.0), 3.0), &middle) - 0.75).abs() < 1e-6);
    // Nothing is where no face is, and nothing stops a place that is none.
    assert_eq!(number(node(Encoding::Linear, 1.0), &TexturePoint { face: 1, ..middle }), 0.0);
    let duv_dx = Vec2::splat(f32::NAN);
    let wild = TexturePoint { uv: duv_dx, footprint: Footprint { duv_dx, ..Footprint::default() }, ..middle };
    assert!(number(node(Encoding::Linear, 1.0), &wild).is_finite());
}

#[test]
fn bytes_are_averaged_and_rounded() {
    let face = Face { first: 0, ..face([1, 1], &[]) };
    let texels = FaceTexels::U8([0, 3, 10, 20, 1, 30, 0, 3, 20, 255, 3, 30].into());
    let images = Arc::new(FaceImages { channels: 3, faces: [face].into(), texels });
    let pyramid = Pyramid::new(&images).unwrap();
    let place = Place { face: 0, uv: Vec2::splat(0.5), grid: [0, 0] };
    assert_eq!(pyramid.texel(&place), [69.0 / 255.0, 3.0 / 255.0, 23.0 / 255.0]);
    assert!(Pyramid::new(&Arc::new(FaceImages { channels: 2, ..(*images).clone() })).is_none());
}
