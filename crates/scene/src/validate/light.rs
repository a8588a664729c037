//! Lights and emission.

use super::{Check, Range, called};
use crate::{AreaLight, Light, Origin, Radiance};

impl Check<'_> {
    pub(super) fn area_light(&mut self, owner: &str, light: &AreaLight, origin: &Origin) {
        self.spectrum_param(owner, "the emission", &light.radiance, origin);
        self.number(
            || format!("the scale of the emission of {owner}"),
            light.scale,
            Range::NotNegative,
            origin,
        );
        self.magnitude(owner, "power", light.power, origin);
    }

    /// A photometric quantity that replaces the magnitude of an emission.
    fn magnitude(&mut self, owner: &str, what: &str, value: Option<f32>, origin: &Origin) {
        if let Some(value) = value {
            self.number(|| format!("`{what}` of {owner}"), value, Range::NotNegative, origin);
        }
    }

    pub(super) fn lights(&mut self) {
        for (handle, light) in self.scene.lights.iter() {
            let origin = self.scene.lights.origin(handle);
            let owner = called("light", origin);
            self.light(&owner, light, origin);
        }
    }

    fn light(&mut self, owner: &str, light: &Light, origin: &Origin) {
        let (Light::Point { scale, .. }
        | Light::Spot { scale, .. }
        | Light::Goniometric { scale, .. }
        | Light::Projection { scale, .. }
        | Light::Distant { scale, .. }
        | Light::Infinite { scale, .. }) = *light;
        self.number(|| format!("the scale of {owner}"), scale, Range::NotNegative, origin);
        match light {
            Light::Point { intensity, power, position, .. } => {
                self.spectrum(&format!("the intensity of {owner}"), intensity, origin);
                self.magnitude(owner, "power", *power, origin);
                self.vector(owner, "position", position.is_finite(), origin);
            }
            Light::Spot { intensity, power, position, direction, angle, penumbra, .. } => {
                self.spectrum(&format!("the intensity of {owner}"), intensity, origin);
                self.magnitude(owner, "power", *power, origin);
                self.vector(owner, "position", position.is_finite(), origin);
                self.vector(owner, "direction", direction.try_normalize().is_some(), origin);
                if !(*angle > 0.0 && *angle <= std::f32::consts::PI && (0.0..=*angle).contains(penumbra)) {
                    let message = format!(
                        "the cone of {owner} has a half angle of {} degrees with a border of {}: expected 0 to 180 and no \
                         wider border",
                        angle.to_degrees(),
                        penumbra.to_degrees()
                    );
                    self.error("bad-number", origin, message);
                }
            }
            Light::Goniometric { intensity, power, image, .. } => {
                self.spectrum(&format!("the intensity of {owner}"), intensity, origin);
                self.magnitude(owner, "power", *power, origin);
                self.handle("image", *image, &self.scene.images, owner, origin);
            }
            Light::Projection { power, image, fov, .. } => {
                self.magnitude(owner, "power", *power, origin);
                self.handle("image", *image, &self.scene.images, owner, origin);
                if !(*fov > 0.0 && *fov < std::f32::consts::PI) {
                    let message = format!(
                        "the angle of the picture of {owner} is {} degrees: expected between 0 and 180",
                        fov.to_degrees()
                    );
                    self.error("bad-number", origin, message);
                }
            }
            Light::Distant { radiance, illuminance, direction, .. } => {
                self.spectrum(&format!("the radiance of {owner}"), radiance, origin);
                self.magnitude(owner, "illuminance", *illuminance, origin);
                self.vector(owner, "direction", direction.try_normalize().is_some(), origin);
            }
            Light::Infinite { radiance, illuminance, portal, .. } => {
                if let Some(corners) = portal {
                    self.vector(owner, "portal", corners.iter().all(|p| p.is_finite()), origin);
                }
                self.magnitude(owner, "illuminance", *illuminance, origin);
                match radiance {
                    Radiance::Constant(spectrum) => {
                        self.spectrum(&format!("the radiance of {owner}"), spectrum, origin);
                    }
                    Radiance::EqualArea(image) | Radiance::LatLong(image) => {
                        self.handle("image", *image, &self.scene.images, owner, origin);
                    }
                }
            }
        }
    }

    fn vector(&mut self, owner: &str, what: &str, is_valid: bool, origin: &Origin) {
        if !is_valid {
            let message = format!("the {what} of {owner} is not finite, or has no direction");
            self.error("bad-number", origin, message);
        }
    }
}
