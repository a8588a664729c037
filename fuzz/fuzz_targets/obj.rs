//! OBJ files: reading ends, and whatever was understood can be validated and reported.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use sahl_load::{MemoryAssets, load};

fuzz_target!(|bytes: &[u8]| {
    let mut assets = MemoryAssets::default();
    // The same bytes are the material library, should the mesh ask for one.
    assets.insert("input.obj", bytes);
    assets.insert("input.mtl", bytes);
    let loaded = load(Path::new("input.obj"), &assets);
    let _ = loaded.scene.validate();
    let _ = loaded.diagnostics.render_text(&loaded.sources, false);
});
