//! PLY files: reading ends, and whatever was understood can be validated and reported.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use sahl_load::{MemoryAssets, load};

fuzz_target!(|bytes: &[u8]| {
    let mut assets = MemoryAssets::default();
    assets.insert("input.ply", bytes);
    let loaded = load(Path::new("input.ply"), &assets);
    let _ = loaded.scene.validate();
    let _ = loaded.diagnostics.render_text(&loaded.sources, false);
});
