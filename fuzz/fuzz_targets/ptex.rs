//! Ptex files: reading ends, and what is read can be validated and reported.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sahl_load::{MemoryAssets, load_pbrt};

const SCENE: &[u8] = br#"WorldBegin
    Texture "t" "spectrum" "ptex" "string filename" "input.ptx""#;

fuzz_target!(|bytes: &[u8]| {
    let mut assets = MemoryAssets::default();
    assets.insert("input.ptx", bytes);
    let loaded = load_pbrt("input.pbrt", SCENE.to_vec(), &assets);
    assert!(!loaded.scene.validate().has_errors(), "what is read is whole");
    let _ = loaded.diagnostics.render_text(&loaded.sources, false);
});
