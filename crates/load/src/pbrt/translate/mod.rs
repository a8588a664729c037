//! Plugins to parts of a scene.
//!
//! Each kind of plugin has a file here, and each file a table of names and functions: a new plugin is a function and a
//! line of its table.

mod area_light;
mod camera;
mod curve;
mod film;
mod filter;
pub(super) mod image;
mod integrator;
mod lens_file;
mod light;
mod material;
mod medium;
mod open_pbr;
mod option;
mod preset;
mod sampler;
mod shape;
mod sky;
mod spectrum;
mod texture;

pub(super) use area_light::area_light;
pub(super) use camera::camera;
pub(super) use film::{FilmSettings, film};
pub(super) use filter::filter;
pub(super) use integrator::integrator;
pub(super) use light::{LightFrame, light};
pub(super) use material::{MaterialKind, material};
pub(super) use medium::medium;
pub(super) use option::{Options, option};
pub(super) use sampler::{accelerator, sampler};
pub(super) use shape::{Surfaces, shape};
pub(super) use texture::texture;

use sahl_scene::Diagnostic;

use super::reader::Reader;
use super::report::quote;

/// The row of `table` for the plugin that a file calls `name`; a name that is not there is an error at the plugin.
fn lookup<'t, T>(table: &'t [(&'static str, T)], name: &str, p: &Reader<'_>) -> Option<&'t T> {
    if let Some((_, found)) = table.iter().find(|(plugin, _)| *plugin == name) {
        return Some(found);
    }
    p.ignore_all();
    let what = p.what().split(" `").next().unwrap_or_default();
    let message = format!("unknown {what} {}", quote(name.as_bytes()));
    p.report().push_with_choices(
        Diagnostic::error("unknown-plugin", p.span(), message),
        name,
        table.iter().map(|(plugin, _)| *plugin),
    );
    None
}
