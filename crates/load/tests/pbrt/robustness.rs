//! Damaged scenes: whatever the bytes, reading ends, tells what is wrong in few words, and makes no more of them than
//! was there.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use sahl_load::{Loaded, MemoryAssets, load_pbrt};

use crate::support;

/// Messages that one scene may give.
const MOST_MESSAGES: usize = 2500;

/// The valid scenes, as seeds of damage.
fn seeds() -> Vec<Vec<u8>> {
    let scenes = support::scenes(support::VALID);
    scenes
        .iter()
        .map(|path| std::fs::read(support::root().join(path)).expect("listed files can be read"))
        .collect()
}

/// Reads `text` as if it stood among the test scenes, and checks what must hold of any input.
fn read(text: &[u8], assets: &MemoryAssets) -> Loaded {
    let loaded = load_pbrt("shapes/damaged.pbrt", text.to_vec(), assets);
    assert!(loaded.diagnostics.iter().count() <= MOST_MESSAGES);
    // No entity takes less than a few bytes of the text (files included here are short).
    assert!(loaded.scene.shapes.len() <= text.len() + 64);
    for entry in loaded.diagnostics.iter() {
        let Some(span) = entry.span else { continue };
        assert!(span.start <= span.end, "{entry:?}");
        assert!(span.end as usize <= loaded.sources.file(span.file).text.len(), "{entry:?}");
    }
    // Messages must be printable wherever they point.
    loaded.diagnostics.render_text(&loaded.sources, true);
    loaded
}

/// One kind of damage.
#[derive(Clone, Debug)]
enum Damage {
    Truncate(usize),
    Replace(usize, u8),
    Remove(usize, usize),
    Repeat(usize, usize),
    Insert(usize, &'static str),
}

/// Pieces that change what the text around them means.
const PIECES: &[&str] = &[
    "\"",
    "[",
    "]",
    "#",
    "\n",
    "\\",
    "nan",
    "-1",
    "1e999",
    "99999999999",
    "AttributeBegin ",
    "AttributeEnd ",
    "ObjectBegin \"x\" ",
    "ObjectEnd ",
    "WorldBegin ",
    "Include \"damaged.pbrt\" ",
    "Include \"meshes.pbrt\" ",
    "Import \"quadrics.pbrt\" ",
    "Scale 0 0 0 ",
    "\"integer indices\" [ -1 7 ] ",
    "\"float x\" ",
    "true",
    "\0",
    "\u{fc}",
    "Shape \"sphere\" ",
    "Attribute \"shape\" ",
    "NamedMaterial \"x\" ",
];

fn damage() -> impl Strategy<Value = Damage> {
    let at = 0_usize..2000;
    prop_oneof![
        at.clone().prop_map(Damage::Truncate),
        (at.clone(), any::<u8>()).prop_map(|(at, byte)| Damage::Replace(at, byte)),
        (at.clone(), 1_usize..60).prop_map(|(at, length)| Damage::Remove(at, length)),
        (at.clone(), 1_usize..200).prop_map(|(at, length)| Damage::Repeat(at, length)),
        (at, prop::sample::select(PIECES)).prop_map(|(at, piece)| Damage::Insert(at, piece)),
    ]
}

fn apply(text: &mut Vec<u8>, damage: &Damage) {
    let length = text.len();
    let range = |at: usize, size: usize| {
        let start = at % (length + 1);
        start..(start + size).min(length)
    };
    match *damage {
        Damage::Truncate(at) => text.truncate(at % (length + 1)),
        Damage::Replace(at, byte) => {
            if let Some(old) = text.get_mut(at % (length + 1)) {
                *old = byte;
            }
        }
        Damage::Remove(at, size) => drop(text.drain(range(at, size))),
        Damage::Repeat(at, size) => {
            let piece = text[range(at, size)].to_vec();
            let end = range(at, size).end;
            text.splice(end..end, piece);
        }
        Damage::Insert(at, piece) => {
            let start = at % (length + 1);
            text.splice(start..start, piece.bytes());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1500,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(7),
        ..ProptestConfig::default()
    })]

    #[test]
    fn damaged_scenes_are_survived(seed in any::<prop::sample::Index>(), damages in prop::collection::vec(damage(), 1..12)) {
        let assets = support::assets();
        let seeds = seeds();
        let mut text = seed.get(&seeds).clone();
        for damage in &damages {
            apply(&mut text, damage);
        }
        read(&text, assets);
    }

    #[test]
    fn bytes_are_survived(text in prop::collection::vec(any::<u8>(), 0..600)) {
        read(&text, &MemoryAssets::default());
        read(&[b"WorldBegin Shape \"sphere\" ", &*text].concat(), &MemoryAssets::default());
    }

    #[test]
    fn words_in_any_order_are_survived(words in prop::collection::vec(prop::sample::select(WORDS), 0..60)) {
        read(words.join(" ").as_bytes(), &MemoryAssets::default());
    }
}

/// Words of the format, to be put in any order.
const WORDS: &[&str] = &[
    "WorldBegin",
    "AttributeBegin",
    "AttributeEnd",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "\"a\"",
    "\"b\"",
    "Shape",
    "\"sphere\"",
    "\"trianglemesh\"",
    "\"point3 P\"",
    "\"integer indices\"",
    "[",
    "]",
    "0",
    "1",
    "2",
    "-3.5",
    "\"float radius\"",
    "\"rgb reflectance\"",
    "Material",
    "\"diffuse\"",
    "\"mix\"",
    "\"string materials\"",
    "MakeNamedMaterial",
    "\"string type\"",
    "NamedMaterial",
    "Texture",
    "\"spectrum\"",
    "\"float\"",
    "\"scale\"",
    "\"texture tex\"",
    "Transform",
    "Rotate",
    "Scale",
    "LookAt",
    "Camera",
    "\"perspective\"",
    "Film",
    "\"rgb\"",
    "true",
    "Option",
    "CoordSysTransform",
    "ActiveTransform",
    "EndTime",
    "MediumInterface",
    "Attribute",
    "\"shape\"",
    "\"spectrum L\"",
    "LightSource",
    "\"infinite\"",
    "AreaLightSource",
    "ReverseOrientation",
    "#",
    "\n",
];

#[test]
fn every_truncation_is_survived() {
    let assets = support::assets();
    for text in seeds() {
        for end in 0..text.len() {
            read(&text[..end], assets);
        }
    }
}

#[test]
fn floods_of_one_mistake_give_few_messages() {
    for line in ["Bogus\n", "Shape \"nothing\"\n", "AttributeEnd\n", "ObjectEnd\n", "[ ", "\"", "1 "] {
        let text = ["WorldBegin\n", &line.repeat(100_000)].concat();
        let loaded = load_pbrt("flood.pbrt", text.into_bytes(), &MemoryAssets::default());
        assert!(loaded.diagnostics.has_errors(), "{line}");
        assert!(loaded.diagnostics.iter().count() <= 16, "{line}");
    }
    let text: String = (0..100_000).map(|i| format!("Bogus{i}\n")).collect();
    let loaded = load_pbrt("flood.pbrt", text.into_bytes(), &MemoryAssets::default());
    assert!(loaded.diagnostics.iter().count() <= 80);
}

#[test]
fn unclosed_blocks_are_kept_in_bounds() {
    let text = ["WorldBegin\n", &"AttributeBegin ".repeat(1_000_000)].concat();
    let loaded = load_pbrt("deep.pbrt", text.into_bytes(), &MemoryAssets::default());
    assert!(loaded.diagnostics.has_errors());
}

/// What `Attribute` holds is copied by all that follows: a mesh in it would let a short text ask for any memory.
#[test]
fn attributes_hold_no_meshes() {
    let mesh = "0 0 0 ".repeat(1000);
    let text = format!("WorldBegin Attribute \"shape\" \"point3 P\" [ {mesh} ]");
    let text = [text, "\nShape \"bilinearmesh\"".repeat(1000)].concat();
    let loaded = load_pbrt("attribute.pbrt", text.into_bytes(), &MemoryAssets::default());
    assert_eq!(loaded.diagnostics.iter().next().map(|entry| entry.code), Some("too-many-parameters"));
    assert!(loaded.scene.shapes.is_empty());
    let many: String = (0..1000).map(|i| format!("Attribute \"shape\" \"float x{i}\" 1\n")).collect();
    let loaded = load_pbrt("attribute.pbrt", many.into_bytes(), &MemoryAssets::default());
    assert!(loaded.diagnostics.has_errors());
}

/// Each of these is quadratic for a reader that looks back at the text, at all names or along the chain every time.
#[test]
fn a_hundred_thousand_of_anything_takes_no_quadratic_time() {
    let count = 100_000;
    let repeat =
        |line: &dyn Fn(usize) -> String| ["WorldBegin\n".to_owned(), (0..count).map(line).collect()].concat();
    let texts = [
        repeat(&|_| "Shape \"sphere\" \"float radius\" 1 \"float radius\" 2\n".to_owned()),
        repeat(&|i| {
            format!(
                "Texture \"t{i}\" \"float\" \"constant\" Material \"diffuse\" \"texture reflectance\" \"u{i}\"\n"
            )
        }),
        repeat(&|i| {
            let next = i + 1;
            format!(
                "MakeNamedMaterial \"m{i}\" \"string type\" \"mix\" \"string materials\" [ \"m{next}\" \"m{next}\" ]\n"
            )
        }),
        repeat(&|i| format!("ObjectInstance \"o{i}\"\nNamedMaterial \"n{i}\"\n")),
    ];
    for text in texts {
        let loaded = load_pbrt("many.pbrt", text.into_bytes(), &MemoryAssets::default());
        assert!(!loaded.diagnostics.is_empty());
    }
}
