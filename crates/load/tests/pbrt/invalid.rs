//! Broken scenes: each gives an error with its place, and the text of its messages is kept.

use sahl_load::{MemoryAssets, load, load_pbrt};
use sahl_scene::{Diagnostics, Severity};

use crate::support;

fn has_error_with_a_place(diagnostics: &Diagnostics) -> bool {
    diagnostics.iter().any(|entry| entry.severity == Severity::Error && entry.span.is_some())
}

#[test]
fn every_invalid_scene_gives_its_messages() {
    let assets = support::assets();
    let scenes = support::scenes(&["invalid"]);
    assert!(scenes.len() >= 50, "{} scenes", scenes.len());
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_snapshot_path("../snapshots");
    settings.bind(|| {
        for path in scenes {
            let loaded = load(&path, assets);
            assert!(has_error_with_a_place(&loaded.diagnostics), "{}", path.display());
            let name = path.file_name().unwrap().to_string_lossy().replace(".pbrt", "");
            let text = loaded.diagnostics.render_text(&loaded.sources, false);
            insta::assert_snapshot!(format!("invalid_{name}"), text);
        }
    });
}

#[test]
fn a_missing_file_is_named_once_where_one_place_was_looked_at() {
    let text = |folder: &str| {
        let scene = br#"WorldBegin Texture "t" "spectrum" "imagemap" "string filename" "no.png""#;
        let loaded = load_pbrt(&format!("{folder}scene.pbrt"), scene.to_vec(), &MemoryAssets::default());
        loaded.diagnostics.render_text(&loaded.sources, false)
    };
    assert!(text("").contains("can't read `no.png`") && !text("").contains("looked for"), "{}", text(""));
    assert!(text("folder/").contains("looked for `folder/no.png` and `no.png`"), "{}", text("folder/"));
}

#[test]
fn a_scene_that_is_not_there_is_an_error() {
    let loaded = load("nowhere/none.pbrt".as_ref(), &MemoryAssets::default());
    let error = loaded.diagnostics.iter().next().unwrap();
    assert_eq!(error.message, "can't read `nowhere/none.pbrt`: no such file");
    let loaded = load("a.blend".as_ref(), &{
        let mut assets = MemoryAssets::default();
        assets.insert("a.blend", *b"x");
        assets
    });
    assert_eq!(loaded.diagnostics.iter().next().unwrap().code, "unknown-format");
}
