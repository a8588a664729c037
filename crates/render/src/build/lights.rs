//! Lights: from spectra, factors and photometric totals to what is sampled.

use std::f32::consts::PI;
use std::sync::Arc;

use sahl_image::Image;
use sahl_math::Transform;
use sahl_scene::{
    Diagnostic, Diagnostics, Handle, Light as Description, Radiance, SceneDesc, Span, Spectrum,
};

use super::displacement::MOST_TRIANGLES;
use crate::light::{
    AreaLight, DistantLight, Emission, ImageEnvironment, Light, PointLight, Presence, SphereMap, SpotLight,
    is_rigid,
};
use crate::shape::Emitter;
use crate::spectrum::{ColorRole, SpectralCurve};

/// Collects the lights of a scene.
///
/// A `power` or an `illuminance` takes the place of the magnitude of a spectrum of luminance one. An RGB triple has a
/// magnitude of its own, which stays a factor: so does pbrt-v4.
pub(super) struct LightBuilder<'a> {
    description: &'a SceneDesc,
    diagnostics: &'a mut Diagnostics,
    pub(super) lights: Vec<Light>,
}

impl<'a> LightBuilder<'a> {
    pub(super) fn new(description: &'a SceneDesc, diagnostics: &'a mut Diagnostics) -> Self {
        Self { description, diagnostics, lights: Vec::new() }
    }

    /// Adds a light for each of the primitives of a shape; returns their indices, or `None` if they are black.
    ///
    /// `power` is that of the whole shape. pbrt-v4 gives it to each triangle of a mesh.
    pub(super) fn add_area(
        &mut self,
        light: &sahl_scene::AreaLight,
        emitters: Vec<Emitter>,
        presence: Presence,
        span: Option<Span>,
    ) -> Option<Box<[u32]>> {
        let area: f32 = emitters.iter().map(Emitter::area).sum();
        let sides = if light.two_sided { 2.0 } else { 1.0 };
        let scale = light.scale * light.power.map_or(1.0, |power| power / (PI * area * sides));
        let radiance = self.emission(&light.radiance, scale, span);
        if radiance.is_black() {
            return None;
        }
        let first = self.lights.len() as u32;
        let new = emitters
            .into_iter()
            .map(|emitter| AreaLight::new(emitter, radiance.clone(), light.two_sided, presence));
        self.lights.extend(new.map(Light::Area));
        Some((first..self.lights.len() as u32).collect())
    }

    /// Tells that a shape of an object does not emit, as in pbrt-v4.
    pub(super) fn refuse_instanced(&mut self, span: Option<Span>) {
        self.diagnostics.push(
            Diagnostic::warning("instanced-area-light", span, "a shape of an object can't be an area light")
                .with_note("the shape is rendered without emission"),
        );
    }

    /// Tells that a mesh would become too large.
    pub(super) fn refuse_displacement(&mut self, span: Option<Span>) {
        let message = format!("a displaced mesh would have more than {MOST_TRIANGLES} triangles");
        let help = "make `edgelength` longer; it is measured in the world";
        self.diagnostics.push(Diagnostic::error("displacement-too-fine", span, message).with_help(help));
    }

    /// Tells that a curve does not emit: its surface depends on where it is seen from, and has no points to be sampled.
    pub(super) fn refuse_curve(&mut self, span: Option<Span>) {
        self.diagnostics.push(
            Diagnostic::warning("curve-area-light", span, "a curve can't be an area light")
                .with_note("the curve is rendered without emission; nor can pbrt-v4 sample one"),
        );
    }

    /// Adds the lights that are not shapes.
    pub(super) fn add_lights(&mut self) {
        for (handle, light) in self.description.lights.iter() {
            let span = self.description.lights.origin(handle).span;
            let new = match light {
                Description::Point { intensity, scale, power, position } => {
                    let scale = scale * power.map_or(1.0, |power| power / (4.0 * PI));
                    let intensity = self.emission(intensity, scale, span);
                    Some(Light::Point(PointLight { position: *position, intensity }))
                }
                Description::Spot { .. } => self.spot(light, span),
                Description::Distant { radiance, scale, illuminance, direction } => {
                    let irradiance = self.emission(radiance, scale * illuminance.unwrap_or(1.0), span);
                    direction
                        .try_normalize()
                        .map(|direction| Light::Distant(DistantLight { direction, irradiance }))
                }
                Description::Infinite { radiance, scale, illuminance, light_to_world } => {
                    self.infinite(radiance, (*scale, *illuminance), light_to_world, span)
                }
            };
            self.lights.extend(new);
        }
    }

    fn emission(&mut self, spectrum: &Spectrum, scale: f32, span: Option<Span>) -> Emission {
        let curve = SpectralCurve::new(spectrum, ColorRole::Illuminant, span, self.diagnostics);
        Emission { curve, scale }
    }

    fn spot(&mut self, light: &Description, span: Option<Span>) -> Option<Light> {
        let Description::Spot { intensity, scale, power, position, direction, angle, penumbra } = light
        else {
            return None;
        };
        let mut spot = SpotLight {
            position: *position,
            direction: direction.try_normalize()?,
            intensity: self.emission(intensity, *scale, span),
            cos_inner: (angle - penumbra).max(0.0).cos(),
            cos_outer: angle.cos(),
        };
        if let Some(power) = power {
            spot.intensity.scale *= power / spot.effective_solid_angle();
        }
        Some(Light::Spot(spot))
    }

    fn infinite(
        &mut self,
        radiance: &Radiance,
        (scale, illuminance): (f32, Option<f32>),
        light_to_world: &Transform,
        span: Option<Span>,
    ) -> Option<Light> {
        let (image, map) = match radiance {
            Radiance::Constant(spectrum) => {
                // The irradiance of a sky of radiance one is π.
                let scale = scale * illuminance.map_or(1.0, |illuminance| illuminance / PI);
                return Some(Light::Uniform(self.emission(spectrum, scale, span)));
            }
            Radiance::EqualArea(image) => (image, SphereMap::EqualArea),
            Radiance::LatLong(image) => (image, SphereMap::LatLong),
        };
        let light = self.image_environment(*image, map, light_to_world, span)?;
        let factor = match illuminance {
            Some(illuminance) => illuminance / light.illuminance(),
            None => 1.0,
        };
        Some(Light::Image(Box::new(light.scaled(if factor.is_finite() { scale * factor } else { 0.0 }))))
    }

    fn image_environment(
        &mut self,
        image: Handle<Arc<Image>>,
        map: SphereMap,
        light_to_world: &Transform,
        span: Option<Span>,
    ) -> Option<ImageEnvironment> {
        let image = &self.description.images[image];
        if map == SphereMap::EqualArea && image.width != image.height {
            let (width, height) = (image.width, image.height);
            self.diagnostics.push(
                Diagnostic::error(
                    "environment-not-square",
                    span,
                    format!(
                        "an equal-area environment must be a square image, found {width} x {height} pixels"
                    ),
                )
                .with_help("convert a latitude-longitude image with `imgtool makeequiarea`"),
            );
            return None;
        }
        if !is_rigid(light_to_world) {
            let message =
                "the transform of an environment is not a rotation: shear and uneven scaling are ignored";
            self.diagnostics.push(Diagnostic::warning("environment-deformed", span, message));
        }
        ImageEnvironment::new(image, map, light_to_world)
    }
}
