//! Pixel filters.

use sahl_scene::Filter;

use super::super::reader::Reader;
use super::lookup;

/// Reads one kind of filter.
type Read = fn(&Reader<'_>) -> Filter;

const FILTERS: &[(&str, Read)] = &[
    ("box", |p| Filter::Box { radius: radius(p, 0.5) }),
    ("triangle", |p| Filter::Triangle { radius: radius(p, 2.0) }),
    ("gaussian", |p| Filter::Gaussian { radius: radius(p, 1.5), sigma: p.positive("sigma", 0.5) }),
    ("mitchell", |p| Filter::Mitchell {
        radius: radius(p, 2.0),
        b: p.float("B", 1.0 / 3.0),
        c: p.float("C", 1.0 / 3.0),
    }),
    ("sinc", |p| Filter::Sinc { radius: radius(p, 4.0), tau: p.positive("tau", 3.0) }),
];

/// The filter called `name`.
pub(in super::super) fn filter(name: &str, p: &Reader<'_>) -> Option<Filter> {
    lookup(FILTERS, name, p).map(|read| read(p))
}

fn radius(p: &Reader<'_>, default: f32) -> [f32; 2] {
    [p.positive("xradius", default), p.positive("yradius", default)]
}
