//! Measured surfaces: reading ends, and whatever was understood can be validated and reported.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sahl_load::{MemoryAssets, load_pbrt};

const SCENE: &[u8] = br#"WorldBegin Material "measured" "string filename" "input.bsdf" Shape "sphere""#;

fuzz_target!(|bytes: &[u8]| {
    let mut assets = MemoryAssets::default();
    assets.insert("input.bsdf", bytes);
    let loaded = load_pbrt("input.pbrt", SCENE.to_vec(), &assets);
    let _ = loaded.scene.validate();
    let _ = loaded.diagnostics.render_text(&loaded.sources, false);
});
