//! Departures of other renderers from the physics of their own scenes.

use serde::{Deserialize, Serialize};

/// What is computed as the renderer does that a scene was made for, though physics says otherwise.
///
/// A scene is finished when its author likes what that renderer shows. Loaders therefore ask for its departures; a scene
/// made in code has none, and `quirks = Quirks::default()` takes those of a file away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Quirks {
    /// Light follows shading normals even through the surface: what a bump or an interpolated normal reflects into the
    /// surface goes on behind it, mirror images below the surface are not turned back, and a normal that looks away from
    /// the viewer stays, so that light of the far side is seen.
    pub leaky_normals: bool,
    /// Rough coats are brighter than their parts make them. The two ways in which a walk through a coat finds its exit are
    /// weighed by densities of which one is that of the opposite direction, so that the weights add up to more than one:
    /// by up to a tenth of what comes from below.
    pub bright_coats: bool,
}

impl Quirks {
    /// Those of pbrt-v4, as of June 2026.
    pub const PBRT_V4: Self = Self { leaky_normals: true, bright_coats: true };
}
