//! Lights: from spectra, factors and photometric totals to what is sampled.

use std::collections::BTreeSet;
use std::f32::consts::PI;
use std::sync::Arc;

use sahl_image::{ColorSpace, Image};
use sahl_math::{Transform, Vec3};
use sahl_scene::{
    Diagnostic, Diagnostics, Handle, Integrator, Light as Description, Material, Radiance, SceneDesc, Span,
    Spectrum,
};

use super::displacement::MOST_TRIANGLES;
use crate::light::{
    AreaLight, DistantLight, Emission, EmissionTexture, GoniometricLight, ImageEnvironment, Light,
    PointLight, Portal, PortalEnvironment, Presence, ProjectionLight, Sampled, Sky, SphereMap, SpotLight,
    is_rigid,
};
use crate::material::OpenPbrSource;
use crate::shape::{Emitter, SurfaceMap};
use crate::spectrum::{ColorRole, SpectralCurve, Wavelengths};
use crate::texture::{SpectrumSource, Textures};

/// A shape that emits.
pub(super) struct EmittingSurface {
    /// Its primitives.
    pub(super) emitters: Vec<Emitter>,
    /// How textures lie on each of them; needed only if the radiance is one.
    pub(super) maps: Vec<SurfaceMap>,
    /// How much of it is there.
    pub(super) presence: Presence,
    /// The material whose layers its light has to pass.
    pub(super) veil: Option<Arc<OpenPbrSource>>,
}

/// Collects the lights of a scene.
///
/// A `power` or an `illuminance` takes the place of the magnitude of a spectrum of luminance one. An RGB triple has a
/// magnitude of its own, which stays a factor: so does pbrt-v4.
pub(super) struct LightBuilder<'a> {
    description: &'a SceneDesc,
    textures: &'a Textures,
    diagnostics: &'a mut Diagnostics,
    pub(super) lights: Vec<Light>,
}

impl<'a> LightBuilder<'a> {
    pub(super) fn new(
        description: &'a SceneDesc,
        textures: &'a Textures,
        diagnostics: &'a mut Diagnostics,
    ) -> Self {
        Self { description, textures, diagnostics, lights: Vec::new() }
    }

    /// Adds a light for each of the primitives of a shape; returns their indices, or `None` if they are black.
    ///
    /// `power` is that of the whole shape. pbrt-v4 gives it to each triangle of a mesh.
    pub(super) fn add_area(
        &mut self,
        light: &sahl_scene::AreaLight,
        surface: EmittingSurface,
        span: Option<Span>,
    ) -> Option<Box<[u32]>> {
        let first = self.lights.len() as u32;
        let role = ColorRole::Illuminant;
        match self.textures.spectrum_source(&light.radiance, role, span, self.diagnostics) {
            SpectrumSource::Constant(curve) if surface.veil.is_none() => {
                self.add_plain(light, surface, curve);
            }
            source => self.add_textured(light, surface, &source),
        }
        let added = first..self.lights.len() as u32;
        (!added.is_empty()).then(|| added.collect())
    }

    /// Lights of the same radiance everywhere.
    fn add_plain(&mut self, light: &sahl_scene::AreaLight, surface: EmittingSurface, curve: SpectralCurve) {
        let EmittingSurface { emitters, presence, .. } = surface;
        let area: f32 = emitters.iter().map(Emitter::area).sum();
        let scale = light.scale * light.power.map_or(1.0, |power| power / (PI * area * sides(light)));
        let radiance = Emission { curve, scale };
        if !radiance.is_black() {
            let new = emitters
                .into_iter()
                .map(|emitter| AreaLight::new(emitter, radiance.clone(), light.two_sided, presence));
            self.lights.extend(new.map(Light::Area));
        }
    }

    /// Lights whose radiance is a texture, or depends on the direction; each is chosen by its own mean.
    fn add_textured(
        &mut self,
        light: &sahl_scene::AreaLight,
        surface: EmittingSurface,
        source: &SpectrumSource,
    ) {
        let EmittingSurface { emitters, maps, presence, veil } = surface;
        // Some thousand points of a shape, and some of each primitive.
        let side = (64.0 / (emitters.len() as f32).sqrt()).ceil().max(4.0) as usize;
        let mut flux = 0.0;
        let mut parts = Vec::with_capacity(emitters.len());
        for (emitter, map) in emitters.into_iter().zip(maps) {
            let texture = EmissionTexture::new(source.clone(), 1.0, map).below(veil.clone());
            let mean = texture.mean(&emitter, self.textures, side);
            flux += PI * emitter.area() * sides(light) * ColorSpace::Srgb.luminance(mean);
            parts.push((emitter, texture, mean));
        }
        let factor = light.power.map_or(1.0, |power| power / flux);
        let scale = if factor.is_finite() { light.scale * factor } else { 0.0 };
        for (emitter, texture, mean) in parts {
            // The mean of what is in gamut already has nothing to complain about.
            let mean = Spectrum::srgb(mean);
            let curve = SpectralCurve::new(&mean, ColorRole::Illuminant, None, &mut Diagnostics::default());
            let area_light = AreaLight::new(emitter, Emission { curve, scale }, light.two_sided, presence);
            self.lights.push(Light::Area(area_light.with_texture(texture.scaled(scale))));
        }
    }

    /// Tells that a shape of an object does not emit, as in pbrt-v4.
    pub(super) fn refuse_instanced(&mut self, span: Option<Span>) {
        self.diagnostics.push(
            Diagnostic::warning("instanced-area-light", span, "a shape of an object can't be an area light")
                .with_note("the shape is rendered without emission"),
        );
    }

    /// What the material `material` of a shape makes it emit, with the material if the light has to pass layers of it; `None` if nothing.
    /// `span` is that of the shape.
    pub(super) fn emission_of(
        &mut self,
        material: Handle<Material>,
        span: Option<Span>,
    ) -> Option<(sahl_scene::AreaLight, Option<Arc<OpenPbrSource>>)> {
        let mut material = material;
        while let Material::Relief { material: inner, .. } = &self.description.materials[material] {
            material = *inner;
        }
        match &self.description.materials[material] {
            Material::OpenPbr(surface) if surface.emits() => {
                // Complaints about its parameters come from the material itself.
                let mut known = Diagnostics::default();
                let source = OpenPbrSource::new(surface, self.textures, None, &mut known);
                let light = sahl_scene::AreaLight {
                    radiance: surface.emission_color.clone(),
                    scale: surface.emission_luminance,
                    two_sided: surface.geometry_thin_walled,
                    power: None,
                };
                let veil = source.is_veiled().then(|| Arc::new(source));
                Some((light, veil))
            }
            Material::Mix { .. } => {
                if self.may_emit(material) {
                    let message = "a shape does not emit what a part of a mixed material emits";
                    self.diagnostics.push(
                        Diagnostic::warning("mixed-emission", span, message)
                            .with_note("the shape is rendered without emission")
                            .with_help("give the shape an area light"),
                    );
                }
                None
            }
            _ => None,
        }
    }

    /// Whether a material, or one among those that it is made of, emits. Each is looked at once, however many mixes share it.
    pub(super) fn may_emit(&self, material: Handle<Material>) -> bool {
        let (mut open, mut seen) = (vec![material], BTreeSet::new());
        while let Some(material) = open.pop() {
            let material = &self.description.materials[material];
            if material.emits() {
                return true;
            }
            open.extend(material.parts().iter().filter(|part| seen.insert(part.index())));
        }
        false
    }

    /// Tells that a shape which is an area light emits nothing else.
    pub(super) fn refuse_second_emission(&mut self, span: Option<Span>) {
        self.diagnostics.push(
            Diagnostic::warning(
                "second-emission",
                span,
                "a shape with an area light has a material that emits",
            )
            .with_note("the area light is used alone"),
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

    /// Tells that a shape that moves does not emit, as in pbrt-v4.
    pub(super) fn refuse_moving(&mut self, span: Option<Span>) {
        self.diagnostics.push(
            Diagnostic::warning("moving-area-light", span, "a shape that moves can't be an area light")
                .with_note("the shape is rendered without emission"),
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
                Description::Goniometric { .. } => self.goniometric(light, span),
                Description::Projection { image, scale, power, fov, light_to_world } => {
                    self.warn_unless_rigid(light_to_world, "a projection light", span);
                    let image = &self.description.images[*image];
                    let light = ProjectionLight::new(image, *fov, light_to_world);
                    light.map(|light| Light::Projection(Box::new(with_power(light, *scale, *power))))
                }
                Description::Distant { radiance, scale, illuminance, direction } => {
                    let irradiance = self.emission(radiance, scale * illuminance.unwrap_or(1.0), span);
                    direction
                        .try_normalize()
                        .map(|direction| Light::Distant(DistantLight { direction, irradiance }))
                }
                Description::Infinite { radiance, scale, illuminance, light_to_world, portal } => {
                    let sky = self.sky(radiance, (*scale, *illuminance), light_to_world, span);
                    sky.and_then(|sky| match portal {
                        Some(corners) => self.portal(sky, *corners, span),
                        None => Some(match sky {
                            Sky::Uniform(radiance) => Light::Uniform(radiance),
                            Sky::Image(image) => Light::Image(Box::new(image)),
                        }),
                    })
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

    fn goniometric(&mut self, light: &Description, span: Option<Span>) -> Option<Light> {
        let Description::Goniometric { intensity, scale, power, image, light_to_world } = light else {
            return None;
        };
        self.warn_unless_rigid(light_to_world, "a goniometric light", span);
        let image = &self.description.images[*image];
        if !self.is_square(image, "the table of a goniometric light", span) {
            return None;
        }
        let intensity = self.emission(intensity, *scale, span);
        let mut light = GoniometricLight::new(image, intensity, light_to_world)?;
        if let Some(power) = power {
            let factor = power / light.effective_solid_angle();
            light.intensity.scale *= if factor.is_finite() { factor } else { 0.0 };
        }
        Some(Light::Goniometric(Box::new(light)))
    }

    /// The sky through the rectangle with the given corners, which must face out of the room.
    fn portal(&mut self, sky: Sky, corners: [Vec3; 4], span: Option<Span>) -> Option<Light> {
        let Some(portal) = Portal::new(corners) else {
            self.diagnostics.push(
                Diagnostic::error("portal-shape", span, "the portal of an infinite light is not a rectangle")
                    .with_help("give its four corners in order round it"),
            );
            return None;
        };
        if !portal.is_inside(self.description.camera.camera_to_world.point(Vec3::ZERO)) {
            let message =
                "the portal of an infinite light faces the camera: its light goes to the other side";
            self.diagnostics.push(
                Diagnostic::warning("portal-orientation", span, message)
                    .with_note("what is on the camera's side of the portal gets no light from this sky")
                    .with_help("if the camera stands in the room, give the corners in the opposite order"),
            );
        }
        Some(Light::Portal(Box::new(PortalEnvironment::new(sky, portal))))
    }

    fn sky(
        &mut self,
        radiance: &Radiance,
        (scale, illuminance): (f32, Option<f32>),
        light_to_world: &Transform,
        span: Option<Span>,
    ) -> Option<Sky> {
        let (image, map) = match radiance {
            Radiance::Constant(spectrum) => {
                // The irradiance of a sky of radiance one is π.
                let scale = scale * illuminance.map_or(1.0, |illuminance| illuminance / PI);
                return Some(Sky::Uniform(self.emission(spectrum, scale, span)));
            }
            Radiance::EqualArea(image) => (image, SphereMap::EqualArea),
            Radiance::LatLong(image) => (image, SphereMap::LatLong),
        };
        let light = self.image_environment(*image, map, light_to_world, span)?;
        let factor = match illuminance {
            Some(illuminance) => illuminance / light.illuminance(),
            None => 1.0,
        };
        Some(Sky::Image(light.scaled(if factor.is_finite() { scale * factor } else { 0.0 })))
    }

    fn image_environment(
        &mut self,
        image: Handle<Arc<Image>>,
        map: SphereMap,
        light_to_world: &Transform,
        span: Option<Span>,
    ) -> Option<ImageEnvironment> {
        let image = &self.description.images[image];
        if map == SphereMap::EqualArea && !self.is_square(image, "an equal-area environment", span) {
            return None;
        }
        self.warn_unless_rigid(light_to_world, "an environment", span);
        // Whitted's integrator has no other way to find the sky than sampling it.
        let sampled = match self.description.integrator {
            Integrator::Whitted { .. } => Sampled::Alone,
            _ => Sampled::WithBsdf,
        };
        ImageEnvironment::new(image, map, light_to_world, sampled)
    }

    /// Whether `image` is square, which is an error otherwise.
    fn is_square(&mut self, image: &Image, what: &str, span: Option<Span>) -> bool {
        let (width, height) = (image.width, image.height);
        if width != height {
            let message = format!("{what} must be a square image, found {width} x {height} pixels");
            self.diagnostics.push(
                Diagnostic::error("environment-not-square", span, message)
                    .with_help("convert a latitude-longitude image with `imgtool makeequiarea`"),
            );
        }
        width == height
    }

    fn warn_unless_rigid(&mut self, transform: &Transform, what: &str, span: Option<Span>) {
        if !is_rigid(transform) {
            let message =
                format!("the transform of {what} is not a rotation: shear and uneven scaling are ignored");
            self.diagnostics.push(Diagnostic::warning("environment-deformed", span, message));
        }
    }
}

/// The light at its magnitude by `scale`, or with the given luminous flux by it.
fn with_power(light: ProjectionLight, scale: f32, power: Option<f32>) -> ProjectionLight {
    let factor = power.map_or(1.0, |power| power / light.power(&Wavelengths::Rgb).luminance());
    light.scaled(if factor.is_finite() { scale * factor } else { 0.0 })
}

fn sides(light: &sahl_scene::AreaLight) -> f32 {
    if light.two_sided { 2.0 } else { 1.0 }
}
