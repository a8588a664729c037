//! Surface scattering at a point.
//!
//! Design decision: a [`Bsdf`] is a small `Copy` value made at a hit; its kinds are a closed set. Each kind is one
//! struct in one file, a private trait forces the contract on it, and one macro writes the arms that lead to it. Kinds
//! with many parameters stay in a [`BsdfRoom`], a place on the stack of whoever asks for the BSDF, and are referred to:
//! the frequent kinds are not made larger by the rare ones.
//!
//! Contract. Directions are unit vectors in the local frame: +z is the shading normal, `wo` points to where light is
//! going (the camera), `wi` to where it comes from and is what [`Bsdf::sample`] draws. Every value is that of radiance:
//! transmission carries the factor 1/η² (η: index on the side of `wi` over that of `wo`). Densities are per steradian.
//! Delta lobes have no density: [`Bsdf::eval`] and [`Bsdf::pdf`] leave them out, and a sample of one has the
//! probability of its lobe for `pdf`. A direction exactly in the surface scatters nothing.
//!
//! Kinds that walk through layers ([`Bsdf::is_stochastic`]) differ in two points. `eval` and `pdf` are estimates, whose
//! random numbers are hashed from the directions and the place: the same arguments give the same value, and the mean over
//! places is what is meant. And `pdf` only resembles the density of `sample`: it integrates to at most one, and is positive
//! wherever `eval` is. That is enough to weigh strategies against each other, which is all that a density is for, since
//! `weight` does not come from it.
//!
//! Deliberately absent: transport of importance, whose transmission lacks 1/η².

mod coated;
mod conductor;
mod dielectric;
mod diffuse;
mod diffuse_transmission;
mod entry;
pub mod fresnel;
mod hair;
mod measured;
pub mod microfacet;
mod open_pbr;
pub(crate) mod room;
mod thin_dielectric;

use sahl_math::{Vec2, Vec3};

use crate::spectrum::Spectrum;

pub use coated::{Coat, Coated, CoatedConductor, CoatedDiffuse};
pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use diffuse_transmission::DiffuseTransmission;
pub use entry::Entry;
pub use hair::{Hair, HairShape};
pub use measured::{Measured, MeasuredTables};
pub use open_pbr::{OpenPbr, OpenPbrParameters};
pub use room::BsdfRoom;
pub use thin_dielectric::ThinDielectric;

/// A direction drawn by [`Bsdf::sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The direction from which light comes.
    pub wi: Vec3,
    /// `f |cos θi| / pdf`.
    pub weight: Spectrum,
    /// Density of `wi` per steradian, equal to [`Bsdf::pdf`]; for a delta lobe the probability of the lobe.
    pub pdf: f32,
    /// What happened.
    pub kind: ScatterKind,
    /// Index of refraction on the side of `wi` over that on the side of `wo`: 1 for a reflection.
    pub eta: f32,
}

/// What happened to the light: which lobe scattered it, and whether it went through the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScatterKind {
    lobe: Lobe,
    transmission: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lobe {
    Diffuse,
    Glossy,
    Specular,
}

impl ScatterKind {
    /// Reflection spread over the hemisphere.
    pub const DIFFUSE_REFLECTION: Self = Self { lobe: Lobe::Diffuse, transmission: false };
    /// Transmission spread over the hemisphere.
    pub const DIFFUSE_TRANSMISSION: Self = Self { lobe: Lobe::Diffuse, transmission: true };
    /// Reflection about the mirror direction.
    pub const GLOSSY_REFLECTION: Self = Self { lobe: Lobe::Glossy, transmission: false };
    /// Refraction about the direction of Snell's law.
    pub const GLOSSY_TRANSMISSION: Self = Self { lobe: Lobe::Glossy, transmission: true };
    /// Reflection into the mirror direction alone.
    pub const SPECULAR_REFLECTION: Self = Self { lobe: Lobe::Specular, transmission: false };
    /// Refraction into the direction of Snell's law alone.
    pub const SPECULAR_TRANSMISSION: Self = Self { lobe: Lobe::Specular, transmission: true };

    /// Whether the lobe is a delta function, which no other strategy can sample.
    #[inline]
    pub const fn is_specular(self) -> bool {
        matches!(self.lobe, Lobe::Specular)
    }

    /// Whether the lobe spreads over a whole hemisphere.
    #[inline]
    pub const fn is_diffuse(self) -> bool {
        matches!(self.lobe, Lobe::Diffuse)
    }

    /// Whether the light went through the surface.
    #[inline]
    pub const fn is_transmission(self) -> bool {
        self.transmission
    }
}

/// From where light can be scattered to a viewer, for the choice among many lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// From the viewer's side of the surface, weighted by the cosine.
    OneSide,
    /// From both sides, weighted by the cosine.
    BothSides,
    /// From all directions alike: the cosine does not matter, as for a fibre.
    Everywhere,
}

/// What each kind of BSDF has to provide: see the methods of [`Bsdf`].
trait Scatter: Copy {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum;
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32;
    fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample>;
    fn is_specular(&self) -> bool;
    fn reach(&self) -> Reach;
    fn albedo(&self, wo: Vec3) -> Spectrum;

    /// Whether values are estimates: see the documentation of the module.
    #[inline]
    fn is_stochastic(&self) -> bool {
        false
    }
}

/// Writes the enum of all kinds, and leads each method of the contract to the kind at hand.
macro_rules! bsdfs {
    ($($(#[$doc:meta])* $Kind:ident($Type:ty)),+ $(,)?) => {
        /// How light scatters at a point of a surface; see the contract in the documentation of the module.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Bsdf<'a> {
            $($(#[$doc])* $Kind($Type)),+
        }

        impl<'a> Bsdf<'a> {
            /// `f(wo, wi) |cos θi|` without delta lobes, per steradian.
            #[inline]
            pub fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
                match self { $(Self::$Kind(bsdf) => bsdf.eval(wo, wi)),+ }
            }

            /// Density per steradian with which [`Bsdf::sample`] draws `wi`, without delta lobes.
            ///
            /// Its integral is the probability that a sample exists and is no delta sample: at most one.
            #[inline]
            pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
                match self { $(Self::$Kind(bsdf) => bsdf.pdf(wo, wi)),+ }
            }

            /// Draws `wi` given `wo`: `u_lobe` chooses among lobes, `u` the direction; both uniform in [0, 1).
            ///
            /// `None`: nothing is scattered in this case, which counts as a sample of weight zero. A returned sample
            /// has a positive and finite `pdf`.
            #[inline]
            pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
                match self { $(Self::$Kind(bsdf) => bsdf.sample(wo, u_lobe, u)),+ }
            }

            /// Whether there are only delta lobes, so that light can't be connected to the point.
            #[inline]
            pub fn is_specular(&self) -> bool {
                match self { $(Self::$Kind(bsdf) => bsdf.is_specular()),+ }
            }

            /// From where light can be scattered to the viewer; lights elsewhere need not be asked.
            #[inline]
            pub fn reach(&self) -> Reach {
                match self { $(Self::$Kind(bsdf) => bsdf.reach()),+ }
            }

            /// A cheap estimate of the share of light scattered to `wo`, for the albedo AOV.
            #[inline]
            pub fn albedo(&self, wo: Vec3) -> Spectrum {
                match self { $(Self::$Kind(bsdf) => bsdf.albedo(wo)),+ }
            }

            /// Whether `eval` and `pdf` are estimates: see the documentation of the module.
            #[inline]
            pub fn is_stochastic(&self) -> bool {
                match self { $(Self::$Kind(bsdf) => bsdf.is_stochastic()),+ }
            }
        }

        $(impl<'a> From<$Type> for Bsdf<'a> {
            #[inline]
            fn from(bsdf: $Type) -> Self {
                Self::$Kind(bsdf)
            }
        })+
    };
}

bsdfs! {
    /// Lambertian reflection.
    Diffuse(Diffuse),
    /// A metal.
    Conductor(Conductor),
    /// Glass, water: reflects and refracts.
    Dielectric(Dielectric),
    /// A pane: reflects and lets through.
    ThinDielectric(ThinDielectric),
    /// Lambertian reflection and transmission.
    DiffuseTransmission(DiffuseTransmission),
    /// Lambertian reflection below a coat.
    CoatedDiffuse(&'a CoatedDiffuse),
    /// A metal below a coat.
    CoatedConductor(&'a CoatedConductor),
    /// A fibre.
    Hair(&'a Hair),
    /// The layers of OpenPBR.
    OpenPbr(&'a OpenPbr),
    /// Where light enters that comes out elsewhere.
    Entry(Entry),
    /// A measured surface.
    Measured(Measured<'a>),
}

/// Mirrors `w` in the tangent plane where `flip` is set.
#[inline]
fn flip_z(w: Vec3, flip: bool) -> Vec3 {
    Vec3::new(w.x, w.y, if flip { -w.z } else { w.z })
}

#[cfg(test)]
mod tests;
