//! Media: from coefficients to what light walks through.

use sahl_scene::{Diagnostic, Diagnostics, Integrator, Material, MediumInterface, SceneDesc};

use crate::medium::{Cloud, DensityGrid, Homogeneous, Medium, RgbGrid, Sparse};

/// Whether the scene has media, about the camera or behind a surface, and its integrator renders them.
pub(super) fn are_honoured(description: &SceneDesc) -> bool {
    matches!(description.integrator, Integrator::Path(path) if path.media) && are_used(description)
}

fn are_used(description: &SceneDesc) -> bool {
    let parts = |media: Option<MediumInterface>| media.is_some_and(|media| media.is_transition());
    description.camera.medium.is_some() || description.shapes.values().iter().any(|shape| parts(shape.media))
}

/// Tells that media are not rendered.
pub(super) fn warn_of_absence(description: &SceneDesc, diagnostics: &mut Diagnostics) {
    let help = match description.integrator {
        Integrator::Path(path) if path.media => return,
        Integrator::Path(_) => "`Integrator \"volpath\"` in the file renders them, or `--integrator path`",
        Integrator::Whitted { .. } => "the integrator `path` renders them",
        Integrator::Ao { .. } | Integrator::Normals => return,
    };
    if are_used(description) {
        let message = "the integrator leaves out participating media: space is empty";
        diagnostics.push(Diagnostic::warning("media-left-out", None, message).with_help(help));
    }
}

/// Tells that light does not spread below surfaces.
pub(super) fn warn_of_solidity(description: &SceneDesc, diagnostics: &mut Diagnostics) {
    let spreads = |material: &Material| matches!(material, Material::Subsurface(_));
    if matches!(description.integrator, Integrator::Whitted { .. })
        && let Some((handle, _)) = description.materials.iter().find(|(_, material)| spreads(material))
    {
        let span = description.materials.origin(handle).span;
        let message = "`whitted` leaves out light below surfaces: this material is like glass";
        let warning = Diagnostic::warning("subsurface-left-out", span, message);
        diagnostics.push(warning.with_help("the integrator `path` renders it"));
    }
}

/// The media of the scene, in the order of its arena.
pub(super) fn media(description: &SceneDesc, diagnostics: &mut Diagnostics) -> Vec<Medium> {
    let mut media = Vec::with_capacity(description.media.len());
    for (handle, medium) in description.media.iter() {
        let span = description.media.origin(handle).span;
        media.push(match medium {
            sahl_scene::Medium::Homogeneous { coefficients, emission } => {
                Medium::Homogeneous(Homogeneous::new(coefficients, emission.as_ref(), span, diagnostics))
            }
            sahl_scene::Medium::Grid(medium) => {
                Medium::DensityGrid(Box::new(DensityGrid::new(medium, span, diagnostics)))
            }
            sahl_scene::Medium::RgbGrid(medium) => {
                Medium::RgbGrid(Box::new(RgbGrid::new(medium, span, diagnostics)))
            }
            sahl_scene::Medium::Cloud(medium) => {
                Medium::Cloud(Box::new(Cloud::new(medium, span, diagnostics)))
            }
            sahl_scene::Medium::Sparse(medium) => {
                Medium::Sparse(Box::new(Sparse::new(medium, span, diagnostics)))
            }
        });
    }
    media
}
