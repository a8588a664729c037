//! Measured surfaces that can't be read: errors at the name of the file. What a file holds is tested beside its reader.

use sahl_load::{MemoryAssets, load_pbrt};
use sahl_scene::Material;

/// The one error of a scene with this material, and what the error points at.
fn error(material: &str) -> (String, String) {
    let mut assets = MemoryAssets::default();
    assets.insert("picture.bsdf", b"P6 1 1 255".to_vec());
    assets.insert("short.bsdf", b"tensor_file\0\x01\0\x01\0\0\0\x04\0ndf".to_vec());
    let text = format!("WorldBegin Material \"measured\" {material}");
    let loaded = load_pbrt("test.pbrt", text.clone().into_bytes(), &assets);
    let diagnostics: Vec<_> = loaded.diagnostics.iter().collect();
    let [diagnostic] = &diagnostics[..] else { panic!("{diagnostics:?}") };
    assert!(loaded.diagnostics.has_errors());
    assert_eq!(loaded.scene.materials.values(), [Material::default()]);
    let Some(span) = diagnostic.span else { panic!("{diagnostic:?}") };
    (diagnostic.message.clone(), text[span.start as usize..span.end as usize].to_owned())
}

#[test]
fn what_can_not_be_read_is_told_at_its_name() {
    let (message, place) = error("\"string filename\" \"picture.bsdf\"");
    assert_eq!(message, "can't read the measured surface `picture.bsdf`: at byte 0: it is not a tensor file");
    assert!(place.contains("picture.bsdf"), "{place}");
    let (message, _) = error("\"string filename\" \"short.bsdf\"");
    assert_eq!(message, "can't read the measured surface `short.bsdf`: at byte 20: it ends too early");
    let (message, _) = error("\"string filename\" \"absent.bsdf\"");
    assert!(message.contains("no such file"), "{message}");
    let (message, place) = error("");
    assert_eq!(message, "material `measured` needs a `string filename`");
    assert!(place.contains("measured"), "{place}");
}
