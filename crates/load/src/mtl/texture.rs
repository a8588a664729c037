//! The textures of MTL files.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sahl_image::Image;
use sahl_scene::{
    Diagnostic, Diagnostics, Handle, ImageTexture, Origin, SceneDesc, Span, Texture, TextureFilter,
    TextureMapping,
};

use super::statement::Statements;
use crate::AssetSource;

/// The image files of a scene, each read and decoded once.
#[derive(Default)]
pub(super) struct Textures {
    /// By path as written and directory; `None` for those that could not be read, which was told.
    images: BTreeMap<(PathBuf, String), Option<Handle<Arc<Image>>>>,
}

impl Textures {
    /// Adds the texture of `map_Kd`, multiplied by `Kd`; `None` if there is none or the image can't be read, which is
    /// told.
    pub(super) fn add(
        &mut self,
        entry: &Statements,
        scene: &mut SceneDesc,
        diagnostics: &mut Diagnostics,
        assets: &dyn AssetSource,
        unheeded: &mut Vec<(&'static str, Span)>,
    ) -> Option<Handle<Texture>> {
        let map = entry.map_kd.as_ref()?;
        let key = (entry.directory.clone(), map.path.clone());
        let image =
            *self.images.entry(key).or_insert_with(|| match read(&entry.directory, &map.path, assets) {
                Ok((path, image)) => {
                    let origin = Origin::named(path.to_string_lossy(), map.span);
                    Some(scene.images.push(Arc::new(image), origin))
                }
                Err(message) => {
                    let diagnostic = Diagnostic::warning("unreadable-file", map.span, message);
                    diagnostics.push(diagnostic.with_note("the colour `Kd` is used alone"));
                    None
                }
            });
        let texture = Texture::Image(ImageTexture {
            image: image?,
            mapping: TextureMapping::Uv(map.mapping),
            wrap: map.wrap,
            filter: TextureFilter::Bilinear,
            scale: factor(entry, unheeded),
            invert: false,
        });
        Some(scene.textures.push(texture, Origin::at(map.span)))
    }
}

/// The factor on the texture: `Kd`, as far as it is grey; one for black.
fn factor(entry: &Statements, unheeded: &mut Vec<(&'static str, Span)>) -> f32 {
    let Some(kd) = entry.kd.filter(|kd| kd.max() > 0.0) else { return 1.0 };
    if kd.rgb != [kd.rgb[0]; 3] {
        unheeded.push((
            "a coloured `Kd` beside `map_Kd` is not honoured: its largest component dims the map",
            kd.span,
        ));
    }
    kd.max()
}

/// Reads an image, looked for as `path` from `directory` and then in it by its name alone: programs write paths of the
/// machine they ran on.
fn read(directory: &Path, path: &str, assets: &dyn AssetSource) -> Result<(PathBuf, Image), String> {
    let relative = path.replace('\\', "/");
    let name = relative.rsplit('/').next().unwrap_or(&relative);
    let mut refusal = String::new();
    for candidate in [directory.join(&relative), directory.join(name)] {
        match assets.read(&candidate) {
            Ok(bytes) => {
                let shown = candidate.to_string_lossy();
                return match sahl_image::read(&bytes, &shown) {
                    Ok(image) => Ok((candidate, image)),
                    Err(error) => Err(format!("can't decode `{shown}`: {error}")),
                };
            }
            Err(error) if refusal.is_empty() || error.kind() != io::ErrorKind::NotFound => {
                refusal =
                    format!("can't read `{}`: {}", candidate.display(), crate::assets::describe(&error));
            }
            Err(_) => {}
        }
    }
    Err(refusal)
}
