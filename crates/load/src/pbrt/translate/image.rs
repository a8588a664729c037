//! Image files, each decoded once for an encoding, and files of images of faces, each decoded once.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use sahl_image::{Encoding, Image, Pixels};
use sahl_scene::{FaceImages, Handle, Origin};

use super::super::context::Context;
use super::super::report::quote;
use super::super::statement::Name;
use crate::ptex;

/// The images of a scene by file and encoding; `None` for those that could not be read.
#[derive(Debug, Default)]
pub(in super::super) struct ImageCache {
    found: BTreeMap<(PathBuf, String), Option<Handle<Arc<Image>>>>,
    faces: BTreeMap<PathBuf, Option<Arc<FaceImages>>>,
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

/// The images of faces in the Ptex file called `name`.
pub(super) fn face_images(cx: &mut Context<'_>, name: &Name) -> Option<Arc<FaceImages>> {
    for path in cx.files.candidates(&name.text) {
        if let Some(images) = cx.images.faces.get(&path) {
            return images.clone();
        }
    }
    let (path, bytes) = cx.read_file(name)?;
    let file = quote(name.text.as_bytes());
    let images = match ptex::read(&bytes) {
        Ok(read) => {
            for warning in read.warnings {
                cx.report.warning("unsupported-texture", name.span, format!("{file}: {warning}"));
            }
            Some(Arc::new(read.images))
        }
        Err(error) => {
            let message = format!("can't read the images of faces {file}: {error}");
            cx.report.error("bad-image", name.span, message);
            None
        }
    };
    cx.images.faces.insert(path, images.clone());
    images
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
