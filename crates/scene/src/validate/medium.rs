//! Media, and the surfaces that part them.

use super::{Check, NOWHERE, Range, called};
use crate::{Coefficients, Emission, Handle, Medium, MediumInterface, Origin};

impl Check<'_> {
    pub(super) fn media(&mut self) {
        for (handle, medium) in self.scene.media.iter() {
            let origin = self.scene.media.origin(handle);
            let owner = called("medium", origin);
            match medium {
                Medium::Homogeneous { coefficients, emission } => {
                    self.coefficients(&owner, coefficients, origin);
                    self.emission(&owner, emission.as_ref(), origin);
                }
            }
        }
        self.medium("the camera", self.scene.camera.medium, &NOWHERE);
    }

    fn coefficients(&mut self, owner: &str, coefficients: &Coefficients, origin: &Origin) {
        let Coefficients { sigma_a, sigma_s, scale, g } = coefficients;
        self.spectrum(&format!("`sigma_a` of {owner}"), sigma_a, origin);
        self.spectrum(&format!("`sigma_s` of {owner}"), sigma_s, origin);
        self.number(|| format!("the scale of {owner}"), *scale, Range::NotNegative, origin);
        self.asymmetry(owner, *g, origin);
    }

    /// The parameter of the phase function.
    fn asymmetry(&mut self, owner: &str, g: f32, origin: &Origin) {
        if !(g > -1.0 && g < 1.0) {
            let message = format!("`g` of {owner} is {g}: expected more than -1 and less than 1");
            self.error("bad-number", origin, message);
        }
    }

    fn emission(&mut self, owner: &str, emission: Option<&Emission>, origin: &Origin) {
        if let Some(Emission { radiance, scale }) = emission {
            self.spectrum(&format!("the emission of {owner}"), radiance, origin);
            self.number(
                || format!("the scale of the emission of {owner}"),
                *scale,
                Range::NotNegative,
                origin,
            );
        }
    }

    pub(super) fn medium_interface(&mut self, owner: &str, media: Option<MediumInterface>, origin: &Origin) {
        if let Some(MediumInterface { inside, outside }) = media {
            self.medium(owner, inside, origin);
            self.medium(owner, outside, origin);
        }
    }

    fn medium(&mut self, owner: &str, medium: Option<Handle<Medium>>, origin: &Origin) {
        if let Some(medium) = medium {
            self.handle("medium", medium, &self.scene.media, owner, origin);
        }
    }
}
