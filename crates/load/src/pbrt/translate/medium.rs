//! Participating media: their names are known, light passes them unchanged.

use super::super::reader::Reader;
use super::lookup;

/// pbrt-v4's media.
const MEDIA: &[(&str, ())] =
    &[("homogeneous", ()), ("uniformgrid", ()), ("rgbgrid", ()), ("cloud", ()), ("nanovdb", ())];

/// Reports the medium called `name`.
pub(in super::super) fn medium(name: &str, p: &Reader<'_>) {
    if lookup(MEDIA, name, p).is_some() {
        p.ignore_all();
        p.unsupported_plugin("unsupported-medium", "light passes it unchanged");
    }
}
