//! A place for BSDFs that are too large to be values.

use super::{Bsdf, CoatedConductor, CoatedDiffuse, Hair, OpenPbr};

/// Room for one BSDF with many parameters, on the stack of the code that asks for it.
///
/// An empty room costs the writing of a tag.
#[derive(Clone, Copy, Debug, Default)]
pub struct BsdfRoom(Option<Large>);

/// A BSDF with many parameters.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "rooms are on the stack, and nothing of a kind that is not kept is written"
)]
pub(crate) enum Large {
    CoatedDiffuse(CoatedDiffuse),
    CoatedConductor(CoatedConductor),
    Hair(Hair),
    OpenPbr(OpenPbr),
}

impl BsdfRoom {
    /// Keeps `large` until the next one, and refers to it.
    pub(crate) fn keep(&mut self, large: Large) -> Bsdf<'_> {
        match self.0.insert(large) {
            Large::CoatedDiffuse(bsdf) => Bsdf::CoatedDiffuse(bsdf),
            Large::CoatedConductor(bsdf) => Bsdf::CoatedConductor(bsdf),
            Large::Hair(bsdf) => Bsdf::Hair(bsdf),
            Large::OpenPbr(bsdf) => Bsdf::OpenPbr(bsdf),
        }
    }
}
