//! Files that are written here, and read back.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use proptest::prelude::*;
use sahl_scene::FaceTexels;

use super::*;

/// How the pixels of a face are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Constant,
    ConstantFlag,
    Zipped,
    Differences,
    /// In tiles of these logarithms, the first of which is constant.
    Tiled(u8, u8),
}

/// A face: the logarithms of its size, what is beyond it, and its values as they are stored, pixel by pixel.
struct Written {
    log2: [u8; 2],
    neighbors: [(u32, u8); 4],
    way: Way,
    values: Vec<u32>,
}

fn zip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// Bytes of values of `size` bytes.
fn bytes(values: impl IntoIterator<Item = u32>, size: usize) -> Vec<u8> {
    values.into_iter().flat_map(|value| value.to_le_bytes()[..size].to_vec()).collect()
}

/// Values by channel, as they are or as differences, compressed.
fn block(values: &[u32], channels: usize, size: usize, differ: bool) -> Vec<u8> {
    let planes: Vec<u32> =
        (0..channels).flat_map(|c| values.iter().copied().skip(c).step_by(channels)).collect();
    let difference = |i: usize| planes[i].wrapping_sub(if i == 0 { 0 } else { planes[i - 1] });
    zip(&bytes((0..planes.len()).map(|i| if differ { difference(i) } else { planes[i] }), size))
}

fn number(size: usize, encoding: u32) -> u32 {
    size as u32 | encoding << 30
}

/// Encoding, and the data of a face.
fn data(face: &Written, channels: usize, size: usize) -> (u32, Vec<u8>) {
    match face.way {
        Way::ConstantFlag => (0, Vec::new()),
        Way::Constant => (0, bytes(face.values[..channels].iter().copied(), size)),
        Way::Zipped => (1, block(&face.values, channels, size, false)),
        Way::Differences => (2, block(&face.values, channels, size, true)),
        Way::Tiled(u, v) => {
            let [width, height] = face.log2.map(|log| 1_usize << log);
            let [tile_width, tile_height] = [u, v].map(|log| 1_usize << log);
            let (mut sizes, mut tiles) = (Vec::new(), Vec::new());
            for (y, x) in (0..height / tile_height).flat_map(|y| (0..width / tile_width).map(move |x| (y, x)))
            {
                let rows =
                    (0..tile_height).map(|j| ((y * tile_height + j) * width + x * tile_width) * channels);
                let values: Vec<u32> = rows
                    .flat_map(|start| face.values[start..start + tile_width * channels].to_vec())
                    .collect();
                let (encoding, stored) = match x + y {
                    0 => (0, bytes(values[..channels].iter().copied(), size)),
                    1 => (1, block(&values, channels, size, false)),
                    _ => (2, block(&values, channels, size, true)),
                };
                sizes.push(number(stored.len(), encoding));
                tiles.extend(stored);
            }
            let sizes = zip(&bytes(sizes, 4));
            (3, [vec![u, v], (sizes.len() as u32).to_le_bytes().to_vec(), sizes, tiles].concat())
        }
    }
}

/// A file of values of a type.
fn file(kind: u32, channels: usize, faces: &[Written]) -> Vec<u8> {
    let size = [1, 2, 2, 4][kind as usize];
    let (mut info, mut constants, mut sizes, mut level) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for face in faces {
        let edges = (0..4).fold(0, |edges, i| edges | face.neighbors[i].1 << (2 * i));
        info.extend([face.log2[0], face.log2[1], edges, u8::from(face.way == Way::ConstantFlag)]);
        info.extend(bytes(face.neighbors.map(|(beyond, _)| beyond), 4));
        constants.extend(bytes(face.values[..channels].iter().copied(), size));
        let (encoding, stored) = data(face, channels, size);
        sizes.push(number(stored.len(), encoding));
        level.extend(stored);
    }
    let (info, constants, sizes) = (zip(&info), zip(&constants), zip(&bytes(sizes, 4)));
    let level = [&sizes[..], &level].concat();
    let mut file = b"Ptex".to_vec();
    file.extend(bytes([1, 1, kind, u32::MAX, channels as u32 | 1 << 16, faces.len() as u32], 4));
    file.extend(bytes([40, info.len() as u32, constants.len() as u32, 16, 4], 4));
    file.extend((level.len() as u64).to_le_bytes());
    file.extend([0; 8 + 40]);
    file.extend([info, constants].concat());
    file.extend((level.len() as u64).to_le_bytes());
    file.extend(bytes([sizes.len() as u32, faces.len() as u32], 4));
    file.extend(level);
    file
}

/// Two faces that touch, written in a certain way.
fn faces(way: Way, channels: usize, value: impl Fn(usize) -> u32) -> Vec<Written> {
    const NONE: (u32, u8) = (u32::MAX, 0);
    let count = 8 * 4 * channels;
    let mut values: Vec<u32> = (0..count).map(&value).collect();
    if let Way::Tiled(u, v) = way {
        // The first tile is constant.
        for (y, x) in (0..1 << v).flat_map(|y| (0..1 << u).map(move |x| (y, x))) {
            for c in 0..channels {
                values[(y * 8 + x) * channels + c] = values[c];
            }
        }
    }
    vec![
        Written { log2: [3, 2], neighbors: [NONE, (1, 3), NONE, NONE], way, values },
        Written {
            log2: [1, 1],
            neighbors: [(0, 2), NONE, NONE, (0, 1)],
            way: Way::Zipped,
            values: (0..4 * channels).map(|i| value(i + 100)).collect(),
        },
    ]
}

#[test]
fn every_type_comes_back_in_every_way() {
    let ways = [
        Way::Zipped,
        Way::Differences,
        Way::Tiled(1, 1),
        Way::Tiled(3, 0),
        Way::Tiled(2, 2),
        Way::Constant,
        Way::ConstantFlag,
    ];
    for (kind, channels, way) in
        (0..4).flat_map(|k| [1, 3].into_iter().flat_map(move |c| ways.map(move |w| (k, c, w))))
    {
        let stored = |i: usize| match kind {
            0 => (i * 37 % 256) as u32,
            1 => (i * 12_347 % 65_536) as u32,
            2 => (0x3000 + i * 51) as u32,
            _ => (i as f32 * 0.25 - 3.0).to_bits(),
        };
        // Differences are of integers only.
        if kind > 1 && matches!(way, Way::Differences | Way::Tiled(..)) {
            continue;
        }
        let written = faces(way, channels, stored);
        let PtexFile { images, warnings } = read(&file(kind, channels, &written)).unwrap();
        assert!(warnings.is_empty() && images.is_usable());
        assert_eq!(images.channels, channels);
        let [first, second] = [images.faces[0], images.faces[1]];
        assert_eq!((first.size_log2, second.size_log2), ([3, 2], [1, 1]));
        assert_eq!(first.neighbors, [None, Some(Neighbor { face: 1, edge: 3 }), None, None]);
        let back = [Some(Neighbor { face: 0, edge: 2 }), None, None, Some(Neighbor { face: 0, edge: 1 })];
        assert_eq!(second.neighbors, back);
        let is_constant = matches!(way, Way::Constant | Way::ConstantFlag);
        assert_eq!(first.is_constant, is_constant);
        let expected = written.iter().flat_map(|face| {
            let all = if face.way == way && is_constant { channels } else { face.values.len() };
            face.values[..all].to_vec()
        });
        let values: Vec<f32> = (0..images.texels.len()).map(|i| images.texels.value(i)).collect();
        let expected: Vec<f32> = expected
            .map(|bits| match kind {
                0 => bits as f32 / 255.0,
                1 => bits as f32 / 65_535.0,
                2 => f32::from_bits(((bits >> 10) + 112) << 23 | (bits & 1023) << 13),
                _ => f32::from_bits(bits),
            })
            .collect();
        assert_eq!(values, expected, "{kind} {channels} {way:?}");
    }
}

#[test]
fn small_halves_are_met() {
    let written = |bits: [u32; 4]| {
        let face =
            Written { log2: [1, 1], neighbors: [(u32::MAX, 0); 4], way: Way::Zipped, values: bits.into() };
        read(&file(2, 1, &[face])).map(|read| read.images.texels)
    };
    let expected = FaceTexels::F32([2.0_f32.powi(-24), -(2.0_f32.powi(-14)), -0.0, 65_504.0].into());
    assert_eq!(written([0x0001, 0x8400, 0x8000, 0x7BFF]), Ok(expected));
    assert_eq!(written([0, 0, 0x7C00, 0]), Err(PtexError::Infinite(0)));
    assert_eq!(written([0x7E00, 0, 0, 0]), Err(PtexError::Infinite(0)));
}

#[test]
fn what_cannot_be_read_is_told() {
    let good = file(0, 3, &faces(Way::Differences, 3, |i| i as u32));
    let change = |offset: usize, bytes: &[u8]| {
        let mut file = good.clone();
        file[offset..offset + bytes.len()].copy_from_slice(bytes);
        read(&file).map(|read| read.warnings)
    };
    assert_eq!(change(0, b"P"), Ok(vec![]));
    assert_eq!(change(0, b"p"), Err(PtexError::NoPtex));
    assert_eq!(read(&good[..63]).unwrap_err(), PtexError::NoPtex);
    assert_eq!(change(4, &[2]), Err(PtexError::Version(2)));
    assert_eq!(change(8, &[0]), Err(PtexError::Triangles));
    assert_eq!(change(8, &[9]), Err(PtexError::Mesh(9)));
    assert_eq!(change(12, &[4]), Err(PtexError::Type(4)));
    assert_eq!(change(20, &[4]), Err(PtexError::Channels(4)));
    assert_eq!(change(24, &[0]), Err(PtexError::NoFaces));
    assert_eq!(change(24, &[3]), Err(PtexError::Damaged("the faces")));
    assert_eq!(change(24, &[255; 4]), Err(PtexError::Damaged("the faces")));
    assert_eq!(change(28, &[255; 4]), Err(PtexError::Truncated));
    assert_eq!(change(110, &[255; 4]), Err(PtexError::Damaged("the faces")));
    // What is not honoured.
    assert_eq!(change(16, &[1, 0, 0, 0]).unwrap(), ["its alpha is taken for a colour"]);
    assert_eq!(
        change(68, &[2]).unwrap(),
        ["its borders are continued by their last pixels, not in black or periodically"]
    );
    assert_eq!(change(88, &[2]).unwrap(), ["edits at its end are left out"]);
    for length in 64..good.len() {
        assert!(read(&good[..length]).is_err(), "{length}");
    }
    // Faces that are not what they should be.
    let one = |log2: [u8; 2], beyond: u32, way: Way| {
        let values = vec![7; 1 << (log2[0].min(9) + log2[1].min(9))];
        read(&file(0, 1, &[Written { log2, neighbors: [(beyond, 0); 4], way, values }]))
            .map(|_| ())
            .unwrap_err()
    };
    assert_eq!(one([16, 0], u32::MAX, Way::Constant), PtexError::Size(0, 16));
    assert_eq!(one([0, 255], u32::MAX, Way::Constant), PtexError::Size(0, -1));
    assert_eq!(one([2, 2], 1, Way::Constant), PtexError::Neighbor(0, 1));
    assert_eq!(one([10, 9], u32::MAX, Way::Zipped), PtexError::Damaged("the pixels of a face"));
    assert!(matches!(one([15, 15], u32::MAX, Way::Zipped), PtexError::Expansion(_)));
}

fn damaged() -> impl Strategy<Value = Vec<u8>> {
    let ways = prop::sample::select(vec![
        Way::Zipped,
        Way::Differences,
        Way::Tiled(1, 1),
        Way::Tiled(2, 0),
        Way::Constant,
    ]);
    let changes = prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6);
    (ways, 0..2_u32, prop::sample::select(vec![1, 3]), changes).prop_map(|(way, kind, channels, changes)| {
        let mut file = file(kind, channels, &faces(way, channels, |i| (i * 11 % 256) as u32));
        for (place, byte) in changes {
            let place = place.index(file.len());
            file[place] = byte;
        }
        file
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(21),
        ..ProptestConfig::default()
    })]

    #[test]
    fn damaged_files_give_errors_or_images(file in damaged()) {
        if let Ok(read) = read(&file) {
            prop_assert!(read.images.is_usable());
        }
    }

    #[test]
    fn random_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(read(&bytes).is_err());
        prop_assert!(read(&[b"Ptex\x01\0\0\0\x01\0\0\0", &bytes[..]].concat()).is_err());
    }
}
