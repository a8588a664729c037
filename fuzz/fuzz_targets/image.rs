//! Image files: reading ends, and what was read has the size that the header told.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sahl_image::{probe, read};

fuzz_target!(|bytes: &[u8]| {
    // TGA has no signature: the name alone sends bytes to its reader.
    for name in ["input", "input.tga"] {
        if let (Ok(info), Ok(image)) = (probe(bytes, name), read(bytes, name)) {
            assert_eq!((info.width, info.height), (image.width, image.height));
            assert_eq!(image.pixels.len(), image.width * image.height * image.channels);
        }
    }
});
