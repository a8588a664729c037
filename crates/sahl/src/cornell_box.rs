//! The scene that is always there.

use crate::load::{Loaded, MemoryAssets, load_pbrt};

const SCENE: &str = include_str!("../../../scenes/gallery/cornell-box.pbrt");
const ROOM: &str = include_str!("../../../scenes/gallery/cornell-box/room.pbrt");

/// The Cornell box (Goral, Torrance, Greenberg and Battaile 1984) with its measured corners: 512 × 512 pixels at 64
/// samples. The same as `scenes/gallery/cornell-box.pbrt`.
pub fn cornell_box() -> Loaded {
    let mut assets = MemoryAssets::default();
    assets.insert("cornell-box/room.pbrt", ROOM);
    load_pbrt("cornell-box.pbrt", SCENE.as_bytes().to_vec(), &assets)
}
