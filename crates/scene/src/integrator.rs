//! Light transport algorithms.

use serde::{Deserialize, Serialize};

/// A light transport algorithm with its settings. Depths count bounces: 0 shows emission, 1 adds direct light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Integrator {
    /// Path tracing with next-event estimation and multiple importance sampling.
    Path(PathTracer),
    /// Direct light, and mirror reflections and refractions followed as a tree (Whitted 1980).
    Whitted {
        /// Most reflections and refractions in a row.
        max_depth: u32,
    },
    /// Share of the hemisphere that is open within a distance.
    Ao {
        /// Occluders farther away do not count, in metres.
        max_distance: f32,
    },
    /// Shading normals as colours: (n + 1) / 2.
    Normals,
}

/// Settings of path tracing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathTracer {
    /// Most bounces: at surfaces and in media, but not where light passes the border of a medium.
    pub max_depth: u32,
    /// How one light is chosen of many.
    pub light_sampler: LightSampler,
    /// Whether media are there; without them space is empty, and [`crate::Material::Interface`] invisible.
    pub media: bool,
    /// Whether near-mirrors are seen as rougher surfaces by light that was spread before (pbrt's `regularize`). That is a
    /// bias, for less noise.
    pub regularize: bool,
    /// The greatest value in any lane that one contribution of indirect light may have: of light that was scattered more
    /// than once on its way to the camera. That is a bias, for fewer fireflies; `None` leaves light as it is.
    pub clamp_indirect: Option<f32>,
    /// Whether meshes with shading normals are lit as the smooth surfaces that they stand for, where they bulge: grazing light then
    /// ends where it ends on those, not at the edges of facets. Rays leave from points above the facets.
    pub smooth_terminator: bool,
}

impl Default for PathTracer {
    /// pbrt's default depth; media are there, nothing is biased, and facets are facets.
    fn default() -> Self {
        Self {
            max_depth: 5,
            light_sampler: LightSampler::Tree,
            media: true,
            regularize: false,
            clamp_indirect: None,
            smooth_terminator: false,
        }
    }
}

/// How one light is chosen of many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum LightSampler {
    /// By an estimate of the light that arrives at the point in question, through a tree over the lights (pbrt's `bvh`).
    #[default]
    Tree,
    /// In proportion to emitted power, wherever the point.
    Power,
    /// All alike.
    Uniform,
}

impl Default for Integrator {
    /// Path tracing to pbrt's default depth.
    fn default() -> Self {
        Self::Path(PathTracer::default())
    }
}
