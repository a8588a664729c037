//! Films.

use sahl_image::ColorSpace;
use sahl_scene::Film;

use super::super::reader::Reader;
use super::lookup;
use super::spectrum::SENSORS;

/// Pixels that a side may have.
const SIDE_LIMIT: i32 = 1 << 20;

/// A film, with the part of its exposure that the shutter does not tell.
#[derive(Debug)]
pub(in super::super) struct FilmSettings {
    pub(in super::super) film: Film,
    /// Its sensitivity; 100 is a factor of one.
    pub(in super::super) iso: f32,
}

/// Reads what one kind of film has beyond the others.
type Read = fn(&Reader<'_>);

const FILMS: &[(&str, Read)] = &[("rgb", |_| {}), ("gbuffer", gbuffer), ("spectral", spectral)];

/// The film called `name`.
pub(in super::super) fn film(name: &str, p: &Reader<'_>, color_space: ColorSpace) -> Option<FilmSettings> {
    lookup(FILMS, name, p)?(p);
    let resolution = resolution(p);
    let film = Film {
        resolution,
        crop: crop(p, resolution),
        diagonal: p.positive("diagonal", 35.0) / 1000.0,
        max_component: p.float_or_infinity("maxcomponentvalue"),
        color_space,
        filename: p.string("filename").map(|name| name.text.clone()),
        ..Film::default()
    };
    sensor(p);
    if p.bool("savefp16", false) {
        p.unsupported(&["savefp16"], "the image is written with 32 bits a channel");
    }
    Some(FilmSettings { film, iso: p.positive("iso", 100.0) })
}

fn gbuffer(p: &Reader<'_>) {
    p.choice("coordinatesystem", &[("camera", ()), ("world", ())], ());
    p.unsupported_plugin(
        "unsupported-film",
        "an `rgb` film is used; ask for further channels when rendering",
    );
}

fn spectral(p: &Reader<'_>) {
    p.without_effect(&["nbuckets", "lambdamin", "lambdamax"]);
    p.unsupported_plugin("unsupported-film", "an `rgb` film is used");
}

fn resolution(p: &Reader<'_>) -> [u32; 2] {
    let default = Film::default().resolution;
    let side = |name, default: u32| p.integer(name, default as i32, 1, SIDE_LIMIT).unsigned_abs();
    let [width, height] = [side("xresolution", default[0]), side("yresolution", default[1])];
    if u64::from(width) * u64::from(height) <= Film::MOST_PIXELS {
        return [width, height];
    }
    let span = p.find("xresolution").map_or(p.span(), |parameter| parameter.value_span);
    let message = format!("{} has {width} × {height} pixels: {} is the limit", p.what(), Film::MOST_PIXELS);
    p.report().error("invalid-value", span, message);
    default
}

/// The pixels to render, by `pixelbounds` or `cropwindow`.
fn crop(p: &Reader<'_>, resolution: [u32; 2]) -> Option<[u32; 4]> {
    let window = p.float_array::<4>("cropwindow");
    let bounds = p.integer_array::<4>("pixelbounds");
    let (name, crop) = match (bounds, window) {
        (Some(bounds), _) => {
            if window.is_some() {
                p.report().warning(
                    "repeated-parameter",
                    p.span(),
                    "of `pixelbounds` and `cropwindow` the first is used",
                );
            }
            ("pixelbounds", bounds.map(i64::from))
        }
        (None, Some(window)) => {
            // pbrt rounds both edges up, so that abutting windows share no pixel.
            let edge = |share: f32, side: usize| (share * resolution[side] as f32).ceil() as i64;
            ("cropwindow", [edge(window[0], 0), edge(window[1], 0), edge(window[2], 1), edge(window[3], 1)])
        }
        (None, None) => return None,
    };
    let clamped: [u32; 4] =
        std::array::from_fn(|i| crop[i].clamp(0, i64::from(resolution[i / 2])).unsigned_abs() as u32);
    if clamped[0] >= clamped[1] || clamped[2] >= clamped[3] {
        p.invalid(name, "leaves no pixel of the image");
        return None;
    }
    if clamped.map(i64::from) != crop {
        p.report().warning(
            "crop-range",
            p.span(),
            format!("`{name}` reaches beyond the image: it is cut to it"),
        );
    }
    Some(clamped)
}

fn sensor(p: &Reader<'_>) {
    let names: Vec<(&str, bool)> =
        SENSORS.iter().map(|&name| (name, false)).chain([("cie1931", true)]).collect();
    if !p.choice("sensor", &names, true) {
        p.unsupported(&["sensor"], "`cie1931` is used");
    }
    if p.non_negative("whitebalance", 0.0) != 0.0 {
        p.unsupported(&["whitebalance"], "colours are not balanced");
    }
}
