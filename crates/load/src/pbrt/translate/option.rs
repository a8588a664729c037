//! `Option` directives.

use sahl_scene::Diagnostic;

use super::super::report::{Report, quote};
use super::super::statement::Name;

/// What options change.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Options {
    /// The seed of the samplers that have none of their own.
    pub(in super::super) seed: Option<u32>,
    /// A factor on the edge lengths of displaced meshes.
    pub(in super::super) edge_scale: Option<f32>,
}

/// The type of an option's value, and what is done with it.
#[derive(Clone, Copy)]
enum Meaning {
    /// A truth value for something that Sahl never does (`true` asks for just that), or that changes no image.
    Bool,
    /// A truth value for something that Sahl does not do, and what it does instead.
    UnsupportedBool(&'static str),
    /// Another value for something that Sahl does not do, and what it does instead.
    Unsupported(&'static str),
    /// The space of rendering, which changes nothing but rounding.
    RenderSpace,
    Seed,
    EdgeScale,
}

/// The options by their names without case, hyphens and underscores.
const OPTIONS: &[(&str, Meaning)] = &[
    ("disablepixeljitter", Meaning::UnsupportedBool("samples are spread over the pixel")),
    ("disabletexturefiltering", Meaning::Bool),
    ("disablewavelengthjitter", Meaning::UnsupportedBool("wavelengths are sampled")),
    ("displacementedgescale", Meaning::EdgeScale),
    ("forcediffuse", Meaning::UnsupportedBool("materials stay as they are")),
    ("msereferenceimage", Meaning::Unsupported("compare the images after rendering")),
    ("msereferenceout", Meaning::Unsupported("compare the images after rendering")),
    ("pixelstats", Meaning::UnsupportedBool("no statistics a pixel are written")),
    ("rendercoordsys", Meaning::RenderSpace),
    ("seed", Meaning::Seed),
    ("wavefront", Meaning::Bool),
];

/// Applies the option `name` with the value `value`.
pub(in super::super) fn option(options: &mut Options, name: &Name, value: &Name, report: &Report) {
    let key: String =
        name.text.chars().filter(|c| !matches!(c, '-' | '_')).map(|c| c.to_ascii_lowercase()).collect();
    let Some((_, meaning)) = OPTIONS.iter().find(|(option, _)| *option == key) else {
        let message = format!("unknown option {}", quote(name.text.as_bytes()));
        let diagnostic = Diagnostic::error("unknown-option", name.span, message);
        report.push_with_choices(diagnostic, &key, OPTIONS.iter().map(|(option, _)| *option));
        return;
    };
    let unsupported = |instead: &str| {
        let message = format!("option `{key}` is not supported: {instead}");
        report.warning("unsupported-option", name.span, message);
    };
    let wrong = |expected: &str| {
        let message = format!("option `{key}` expects {expected}, found {}", quote(value.text.as_bytes()));
        report.error("wrong-type", value.span, message);
    };
    match *meaning {
        Meaning::Bool | Meaning::UnsupportedBool(_) if !matches!(&*value.text, "true" | "false") => {
            wrong("`true` or `false`");
        }
        Meaning::UnsupportedBool(instead) if value.text == "true" => unsupported(instead),
        Meaning::Bool | Meaning::UnsupportedBool(_) => {}
        Meaning::Unsupported(instead) => unsupported(instead),
        Meaning::RenderSpace if !matches!(&*value.text, "camera" | "cameraworld" | "world") => {
            wrong("`camera`, `cameraworld` or `world`");
        }
        Meaning::RenderSpace => {}
        Meaning::Seed => match value.text.parse() {
            Ok(seed) => options.seed = Some(seed),
            Err(_) => wrong("an integer that is not negative"),
        },
        Meaning::EdgeScale => match value.text.parse() {
            Ok(scale) if scale > 0.0 && f32::is_finite(scale) => options.edge_scale = Some(scale),
            _ => wrong("a number greater than zero"),
        },
    }
}
