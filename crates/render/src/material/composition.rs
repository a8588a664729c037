//! Materials made of others.

use sahl_scene::{FloatParam, Handle, SceneDesc};

use super::{Material, Query, Relief};
use crate::sampler::hash::{mix, to_unit};
use crate::texture::FloatSource;

/// A material made of others.
#[derive(Clone, Debug, PartialEq)]
pub enum Composition {
    /// One of two materials, chosen at random.
    Mix {
        /// Their indices.
        materials: [u32; 2],
        /// The probability of the second.
        amount: FloatSource,
    },
    /// A material with normals that are not the surface's own.
    Relief {
        /// Its index.
        material: u32,
        /// The normals.
        relief: Relief,
    },
}

impl Composition {
    pub(super) fn mix(materials: [Handle<sahl_scene::Material>; 2], amount: FloatSource) -> Self {
        Self::Mix { materials: materials.map(|handle| handle.index() as u32), amount }
    }

    /// Takes the material `index` apart, as far as needed to know what scatters light at a point; `shape` is given each
    /// relief on the way.
    ///
    /// Which material of a mix it is depends on a hash of the point, as in pbrt-v4: the mean over the points of a pixel is
    /// the mix, at the cost of one of its parts.
    pub(crate) fn resolve(
        materials: &[Material],
        mut index: u32,
        query: &Query<'_>,
        mut shape: impl FnMut(&Relief),
    ) -> u32 {
        while let Material::Composition(composition) = &materials[index as usize] {
            index = match composition {
                Self::Mix { materials: [first, second], amount } => {
                    // Written such that NaN and what is below zero choose the first.
                    if query.float(amount) > choice(query, index) { *second } else { *first }
                }
                Self::Relief { material, relief } => {
                    shape(relief);
                    *material
                }
            };
        }
        index
    }
}

/// A number in [0, 1) for the choice that material `index` makes at a point.
fn choice(query: &Query<'_>, index: u32) -> f32 {
    let [x, y, z] = <[f32; 3]>::from(query.at.p).map(|x| u64::from(x.to_bits()));
    to_unit((mix(mix(x << 32 | y).wrapping_add(z << 32 | u64::from(index))) >> 32) as u32)
}

/// What hits on a material have to provide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Traits {
    /// Tangents along ∂p/∂u: scattering depends on more than the normal.
    pub(crate) needs_tangent: bool,
    /// It has to be taken apart at each hit.
    pub(crate) is_composed: bool,
}

/// What hits on the material `handle` of a scene without faults have to provide.
pub(crate) fn traits(description: &SceneDesc, handle: Handle<sahl_scene::Material>) -> Traits {
    use sahl_scene::Material as Description;
    let is_composed =
        matches!(description.materials[handle], Description::Mix { .. } | Description::Relief { .. });
    let mut traits = Traits { needs_tangent: false, is_composed };
    let mut open = vec![handle];
    // A part is looked at once, however many mixes share it.
    let mut seen = std::collections::BTreeSet::from([handle.index()]);
    while let Some(handle) = open.pop() {
        let material = &description.materials[handle];
        open.extend(material.parts().iter().filter(|part| seen.insert(part.index())));
        traits.needs_tangent |= match material {
            Description::Conductor { roughness, .. } | Description::Dielectric { roughness, .. } => {
                is_anisotropic(roughness)
            }
            Description::CoatedDiffuse { coat, .. } => is_anisotropic(&coat.roughness),
            Description::CoatedConductor { roughness, coat, .. } => {
                is_anisotropic(roughness) || is_anisotropic(&coat.roughness)
            }
            Description::Relief { .. } | Description::Hair(_) => true,
            Description::OpenPbr(surface) => {
                surface.specular_roughness_anisotropy != FloatParam::Constant(0.0)
            }
            Description::Subsurface(subsurface) => is_anisotropic(&subsurface.roughness),
            Description::Measured(brdf) => brdf.phi.len() > 1,
            Description::Diffuse { .. }
            | Description::ThinDielectric { .. }
            | Description::DiffuseTransmission { .. }
            | Description::Mix { .. }
            | Description::Interface => false,
        };
    }
    traits
}

/// Whether the microfacets may differ along the tangents.
fn is_anisotropic(roughness: &sahl_scene::Roughness) -> bool {
    match (roughness.u, roughness.v) {
        (FloatParam::Constant(u), FloatParam::Constant(v)) => u != v,
        (FloatParam::Texture(u), FloatParam::Texture(v)) => u != v,
        _ => true,
    }
}
