//! Participating media.

use sahl_image::ColorSpace;
use sahl_math::{Bounds3, Transform, Vec3};
use sahl_scene::{
    CloudMedium, Coefficients, Emission, Grid, GridEmission, GridMedium, GridSource, Medium, Region,
    RgbGridMedium, SparseGrid, SparseMedium, Spectrum, TemperatureScale,
};

use super::super::context::Context;
use super::super::reader::Reader;
use super::super::report::quote;
use super::super::statement::Name;
use super::lookup;
use super::preset::{self, Measured};
use super::spectrum::{Role, spectrum};
use crate::nanovdb;

/// Reads one kind of medium, whose own space the transform leads out of; `None` where it can't be read, which is
/// reported.
type Read = fn(&Context<'_>, &Reader<'_>, &Transform) -> Option<Medium>;

const MEDIA: &[(&str, Read)] = &[
    ("homogeneous", homogeneous),
    ("uniformgrid", uniform_grid),
    ("rgbgrid", rgb_grid),
    ("cloud", cloud),
    ("nanovdb", nano_vdb),
];

/// The sum of all ȳ of the CIE 1931 observer. pbrt-v4 leaves the emission of `rgbgrid` and that of temperatures without
/// its photometric normalisation, so that they are brighter by as much than light of the same numbers elsewhere.
const PBRT_PHOTOMETRIC: f32 = 106.856_9;

/// The medium of the kind `name`, described in a space from which `to_world` leads.
pub(in super::super) fn medium(
    cx: &Context<'_>,
    name: &str,
    p: &Reader<'_>,
    to_world: &Transform,
) -> Option<Medium> {
    lookup(MEDIA, name, p).and_then(|read| read(cx, p, to_world))
}

fn homogeneous(cx: &Context<'_>, p: &Reader<'_>, _: &Transform) -> Option<Medium> {
    let coefficients = coefficients(cx, p, preset::named(p, "preset"));
    let scale = p.non_negative("Lescale", 1.0);
    let emission = emitted(cx, p).map(|radiance| Emission { radiance, scale });
    Some(Medium::Homogeneous { coefficients, emission })
}

/// Absorption and scattering, by default one per metre, with the phase function. What was measured comes before what is
/// given, as in pbrt-v4.
fn coefficients(cx: &Context<'_>, p: &Reader<'_>, measured: Option<Measured>) -> Coefficients {
    let coefficient = |name, measured: Option<[f32; 3]>| {
        let given = spectrum(cx, p, name, Role::Unbounded);
        let measured = measured.map(|rgb| Spectrum::Rgb { rgb, space: ColorSpace::Srgb });
        measured.or(given).unwrap_or(Spectrum::Constant(1.0))
    };
    Coefficients {
        sigma_a: coefficient("sigma_a", measured.map(|measured| measured.sigma_a)),
        sigma_s: coefficient("sigma_s", measured.map(|measured| measured.sigma_s)),
        scale: p.non_negative("scale", 1.0),
        g: asymmetry(p),
    }
}

fn asymmetry(p: &Reader<'_>) -> f32 {
    p.float_where("g", 0.0, |g| g > -1.0 && g < 1.0, "greater than -1 and less than 1")
}

/// The emission `Le`, unless it is black.
fn emitted(cx: &Context<'_>, p: &Reader<'_>) -> Option<Spectrum> {
    let is_black = |spectrum: &Spectrum| match spectrum {
        Spectrum::Constant(value) => *value == 0.0,
        Spectrum::Rgb { rgb, .. } => *rgb == [0.0; 3],
        _ => false,
    };
    spectrum(cx, p, "Le", Role::Illuminant).filter(|spectrum| !is_black(spectrum))
}

fn region(p: &Reader<'_>, to_world: &Transform) -> Region {
    let corners = [p.point("p0", Vec3::ZERO), p.point("p1", Vec3::ONE)];
    Region { bounds: Bounds3::from_points(corners), medium_to_world: *to_world }
}

fn temperature_scale(p: &Reader<'_>) -> TemperatureScale {
    let offset = p.float("temperaturecutoff", 0.0);
    TemperatureScale {
        offset: p.float("temperatureoffset", offset),
        scale: p.non_negative("temperaturescale", 1.0),
    }
}

fn resolution(p: &Reader<'_>) -> [u32; 3] {
    ["nx", "ny", "nz"].map(|name| p.integer(name, 1, 1, i32::MAX).unsigned_abs())
}

/// The values of `name`, one for each cell; another number of them is an error.
fn grid<T: Clone>(p: &Reader<'_>, name: &'static str, values: Option<&[T]>) -> Option<Grid<T>> {
    let grid = Grid { resolution: resolution(p), values: values?.into() };
    if !grid.is_complete() {
        let [x, y, z] = grid.resolution;
        let span = p.find(name).map_or(p.span(), |parameter| parameter.value_span);
        let message =
            format!("{} has {x} x {y} x {z} cells, but {} values of `{name}`", p.what(), grid.values.len());
        p.report().error("wrong-count", span, message);
        return None;
    }
    Some(grid)
}

/// Numbers that are at least zero, one for each cell.
fn float_grid(p: &Reader<'_>, name: &'static str) -> Option<Grid<f32>> {
    let grid = grid(p, name, p.float_values(name))?;
    if let Some(index) = grid.values.iter().position(|&value| value < 0.0) {
        let span =
            p.find(name).map_or(p.span(), |parameter| p.report().value_span(parameter.value_span, index));
        let message = format!("`{name}` of {} is negative here: it counts as zero", p.what());
        p.report().warning("negative-density", span, message);
    }
    Some(grid)
}

fn uniform_grid(cx: &Context<'_>, p: &Reader<'_>, to_world: &Transform) -> Option<Medium> {
    let (coefficients, region) = (coefficients(cx, p, None), region(p, to_world));
    let (temperature, scale) = (float_grid(p, "temperature"), temperature_scale(p));
    let scales = float_grid(p, "Lescale");
    let source = match (temperature, emitted(cx, p)) {
        (Some(_), Some(_)) => {
            p.invalid("Le", "can't be given beside `temperature`: one of them says what is emitted");
            None
        }
        (Some(grid), None) => Some((GridSource::Temperature(grid, scale), PBRT_PHOTOMETRIC)),
        (None, spectrum) => spectrum.map(|spectrum| (GridSource::Spectrum(spectrum), 1.0)),
    };
    let Some(density) = float_grid(p, "density") else {
        missing(p, "density", "`float density`");
        return None;
    };
    let emission = source.map(|(source, scale)| GridEmission { source, scale, scales });
    Some(Medium::Grid(GridMedium { coefficients, region, density, emission }))
}

/// Reports that a grid is not given, unless it was given wrongly.
fn missing(p: &Reader<'_>, name: &'static str, what: &str) {
    if !p.has(name) {
        p.report().error("missing-parameter", p.span(), format!("{} needs {what}", p.what()));
    }
}

fn rgb_grid(_: &Context<'_>, p: &Reader<'_>, to_world: &Transform) -> Option<Medium> {
    let colors = |name| {
        let (values, space) = p.rgb_values(name)?;
        Some((grid(p, name, Some(values))?, space))
    };
    let [sigma_a, sigma_s, emission] = ["sigma_a", "sigma_s", "Le"].map(colors);
    let medium = RgbGridMedium {
        region: region(p, to_world),
        space: sigma_a.as_ref().or(sigma_s.as_ref()).map_or(ColorSpace::Srgb, |(_, space)| *space),
        sigma_a: sigma_a.map(|(grid, _)| grid),
        sigma_s: sigma_s.map(|(grid, _)| grid),
        scale: p.non_negative("scale", 1.0),
        g: asymmetry(p),
        emission: emission.map(|(grid, _)| grid),
        emission_scale: p.non_negative("Lescale", 1.0) * PBRT_PHOTOMETRIC,
    };
    if medium.sigma_a.is_none() && medium.sigma_s.is_none() {
        if !p.has("sigma_a") {
            missing(p, "sigma_s", "`rgb sigma_a` or `rgb sigma_s`");
        }
        return None;
    }
    if medium.emission.is_some() && medium.sigma_a.is_none() {
        missing(p, "sigma_a", "`rgb sigma_a` for `Le` to be seen");
        return None;
    }
    Some(Medium::RgbGrid(medium))
}

fn cloud(cx: &Context<'_>, p: &Reader<'_>, to_world: &Transform) -> Option<Medium> {
    Some(Medium::Cloud(CloudMedium {
        coefficients: coefficients(cx, p, None),
        region: region(p, to_world),
        density: p.non_negative("density", 1.0),
        wispiness: p.non_negative("wispiness", 1.0),
        frequency: p.non_negative("frequency", 5.0),
    }))
}

fn nano_vdb(cx: &Context<'_>, p: &Reader<'_>, to_world: &Transform) -> Option<Medium> {
    let (coefficients, scale) = (coefficients(cx, p, None), temperature_scale(p));
    let emission_scale = p.non_negative("Lescale", 1.0) * PBRT_PHOTOMETRIC;
    let text = |name, default: &str| p.string(name).map_or(default.to_owned(), |name| name.text.clone());
    let (density, temperature) = (text("gridname", "density"), text("temperaturename", "temperature"));
    let Some(file) = p.string("filename") else {
        missing(p, "filename", "a `string filename`");
        return None;
    };
    let (_, bytes) = cx.read_file(file)?;
    let read = |grid: &str| -> Result<Option<SparseGrid>, ()> {
        nanovdb::read(&bytes, grid).map_err(|error| bad_grid(cx, file, &error.to_string()))
    };
    let Some(density_grid) = read(&density).ok()? else {
        let found = nanovdb::names(&bytes).join("`, `");
        let message = format!("it has no grid {}, but `{found}`", quote(density.as_bytes()));
        bad_grid(cx, file, &message);
        return None;
    };
    let temperature = read(&temperature).ok()?.map(|grid| (grid, scale));
    Some(Medium::Sparse(Box::new(SparseMedium {
        coefficients,
        medium_to_world: *to_world,
        density: density_grid,
        temperature,
        emission_scale,
    })))
}

fn bad_grid(cx: &Context<'_>, file: &Name, problem: &str) {
    let message = format!("can't read the volume {}: {problem}", quote(file.text.as_bytes()));
    cx.report.error("bad-volume", file.span, message);
}
