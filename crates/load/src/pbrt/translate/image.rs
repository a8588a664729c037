//! Image files, each decoded once for an encoding.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use sahl_image::{Encoding, Image, Pixels};
use sahl_scene::{Handle, Origin};

use super::super::context::Context;
use super::super::report::quote;
use super::super::statement::Name;

/// The images of a scene by file and encoding; `None` for those that could not be read.
#[derive(Debug, Default)]
pub(in super::super) struct ImageCache {
    found: BTreeMap<(PathBuf, String), Option<Handle<Arc<Image>>>>,
}

/// The image in the file called `name`, its values taken to be in `encoding` if the file's format does not tell.
pub(super) fn image(
    cx: &mut Context<'_>,
    name: &Name,
    encoding: Option<Encoding>,
) -> Option<Handle<Arc<Image>>> {
    let tag = format!("{encoding:?}");
    for path in cx.files.candidates(&name.text) {
        if let Some(image) = cx.images.found.get(&(path, tag.clone())) {
            return *image;
        }
    }
    let (path, bytes) = cx.read_file(name)?;
    let handle = match sahl_image::read(&bytes, &name.text) {
        Ok(image) => Some(add(cx, name, with_encoding(image, encoding))),
        Err(error) => {
            let message = format!("can't read the image {}: {error}", quote(name.text.as_bytes()));
            cx.report.error("bad-image", name.span, message);
            None
        }
    };
    cx.images.found.insert((path, tag), handle);
    handle
}

fn add(cx: &mut Context<'_>, name: &Name, image: Image) -> Handle<Arc<Image>> {
    cx.scene.images.push(Arc::new(image), Origin::named(name.text.clone(), name.span))
}

/// Files of floats are linear whatever the scene says, as in pbrt.
fn with_encoding(mut image: Image, encoding: Option<Encoding>) -> Image {
    if let Some(encoding) = encoding
        && (matches!(image.pixels, Pixels::U8(_)) || image.encoding != Encoding::Linear)
    {
        image.encoding = encoding;
    }
    image
}
