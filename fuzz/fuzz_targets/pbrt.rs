//! pbrt scenes: reading ends, and whatever was understood can be validated and reported.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sahl_load::{MemoryAssets, load_pbrt};

fuzz_target!(|bytes: &[u8]| {
    let mut assets = MemoryAssets::default();
    // Something to include, also itself.
    assets.insert("input.pbrt", bytes);
    assets.insert("shape.pbrt", *b"Shape \"sphere\"");
    let loaded = load_pbrt("input.pbrt", bytes.to_vec(), &assets);
    let _ = loaded.scene.validate();
    let _ = loaded.diagnostics.render_text(&loaded.sources, false);
});
