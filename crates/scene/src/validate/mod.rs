//! What can be wrong with a scene whatever file it comes from.
//!
//! Loaders check what they read; this checks the [`SceneDesc`] itself, so that the renderer can rely on it, and so that a
//! scene made or edited by a program gets messages rather than panics. A message points at the text that defines the
//! entity, if there is one.

mod light;
mod material;
mod medium;
mod mesh;
mod texture;

use crate::{
    Aperture, Arena, Camera, Diagnostic, Diagnostics, Film, Filter, FloatParam, Geometry, Handle, Integrator,
    LensSystem, Material, Medium, Object, Origin, PathTracer, Projection, SceneDesc, Shape, Spectrum,
    SpectrumParam,
};

impl SceneDesc {
    /// What is wrong with this scene: handles that lead nowhere, textures that contain themselves, numbers that are not
    /// finite or out of their range, meshes without faces, indices beyond the vertices, images without pixels, and, as
    /// warnings, a scene without shapes or without light.
    ///
    /// A scene without errors can be built without further checks of these.
    pub fn validate(&self) -> Diagnostics {
        let mut check = Check { scene: self, diagnostics: Diagnostics::default() };
        check.camera(&self.camera);
        check.film(&self.film);
        check.filter(&self.filter);
        if self.sampler.samples == 0 {
            check.error("bad-sampler", &NOWHERE, "zero samples a pixel: expected one or more".to_owned());
        }
        if let Integrator::Ao { max_distance } = self.integrator
            && (max_distance.is_nan() || max_distance <= 0.0)
        {
            let message =
                format!("the distance of ambient occlusion is {max_distance}: expected more than zero");
            check.error("bad-integrator", &NOWHERE, message);
        }
        if let Integrator::Path(PathTracer { clamp_indirect: Some(limit), .. }) = self.integrator
            && !(limit > 0.0 && limit.is_finite())
        {
            let message =
                format!("indirect light is clamped to {limit}: expected a finite number above zero");
            check.error("bad-integrator", &NOWHERE, message);
        }
        check.images();
        check.textures();
        check.materials();
        check.media();
        check.meshes();
        check.curves();
        check.shapes();
        check.objects();
        check.lights();
        check.emptiness();
        check.diagnostics
    }
}

const NOWHERE: Origin = Origin { name: None, span: None };

/// The checks with the messages so far.
struct Check<'a> {
    scene: &'a SceneDesc,
    diagnostics: Diagnostics,
}

/// An entity as messages call it: "material `name`".
fn called(kind: &str, origin: &Origin) -> String {
    match &origin.name {
        Some(name) => format!("{kind} `{name}`"),
        None => kind.to_owned(),
    }
}

impl Check<'_> {
    fn error(&mut self, code: &'static str, origin: &Origin, message: String) {
        self.diagnostics.push(Diagnostic::error(code, origin.span, message));
    }

    /// Complains unless `value` lies in `range`, which NaN never does.
    fn number(&mut self, what: impl FnOnce() -> String, value: f32, range: Range, origin: &Origin) {
        if !range.contains(value) {
            let message = format!("{} is {value}: expected {}", what(), range.text());
            self.error("bad-number", origin, message);
        }
    }

    fn handle<T>(&mut self, kind: &str, handle: Handle<T>, arena: &Arena<T>, owner: &str, origin: &Origin) {
        if arena.get(handle).is_none() {
            let message =
                format!("{owner} refers to {kind} {}, of which there are {}", handle.index(), arena.len());
            self.error("dangling-handle", origin, message);
        }
    }

    fn camera(&mut self, camera: &Camera) {
        if let Projection::Perspective { fov } = camera.projection
            && !(fov > 0.0 && fov < std::f32::consts::PI)
        {
            let message = format!(
                "the camera's angle of view is {} degrees: expected between 0 and 180",
                fov.to_degrees()
            );
            self.error("bad-camera", &NOWHERE, message);
        }
        self.number(|| "the lens radius".to_owned(), camera.lens_radius, Range::NotNegative, &NOWHERE);
        if camera.lens_radius > 0.0 {
            self.number(|| "the focal distance".to_owned(), camera.focal_distance, Range::Positive, &NOWHERE);
        }
        if let Projection::Realistic(lens) = &camera.projection {
            self.lens(lens);
        }
        let [open, close] = camera.shutter;
        if !(open.is_finite() && close.is_finite() && open <= close) {
            let message =
                format!("the shutter opens at {open} and closes at {close}: expected times in order");
            self.error("bad-camera", &NOWHERE, message);
        }
        if let Some(window @ [x_min, x_max, y_min, y_max]) = camera.screen_window
            && !(window.iter().all(|x| x.is_finite()) && x_min < x_max && y_min < y_max)
        {
            let message =
                format!("the screen window is {window:?}: expected x min < x max and y min < y max");
            self.error("bad-camera", &NOWHERE, message);
        }
    }

    fn lens(&mut self, lens: &LensSystem) {
        if lens.elements.is_empty() {
            self.error("bad-camera", &NOWHERE, "the lens has no elements".to_owned());
        }
        for (i, element) in lens.elements.iter().enumerate() {
            let name = |what: &str| format!("the {what} of lens element {}", i + 1);
            self.number(|| name("curvature radius"), element.curvature_radius, Range::Finite, &NOWHERE);
            self.number(|| name("thickness"), element.thickness, Range::NotNegative, &NOWHERE);
            self.number(|| name("index of refraction"), element.eta, Range::NotNegative, &NOWHERE);
            self.number(|| name("diameter"), element.diameter, Range::Positive, &NOWHERE);
        }
        self.number(
            || "the aperture of the lens".to_owned(),
            lens.aperture_diameter,
            Range::Positive,
            &NOWHERE,
        );
        self.number(
            || "the focus distance of the lens".to_owned(),
            lens.focus_distance,
            Range::Positive,
            &NOWHERE,
        );
        if let Aperture::Image(image) = lens.aperture {
            self.handle("image", image, &self.scene.images, "the aperture of the lens", &NOWHERE);
        }
    }

    fn film(&mut self, film: &Film) {
        let [width, height] = film.resolution;
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || pixels > Film::MOST_PIXELS {
            let message =
                format!("the image has {width} × {height} pixels: expected 1 to {}", Film::MOST_PIXELS);
            self.error("bad-film", &NOWHERE, message);
        }
        if let Some([x_min, x_max, y_min, y_max]) = film.crop
            && !(x_min < x_max && x_max <= width && y_min < y_max && y_max <= height)
        {
            let message = format!(
                "the crop from ({x_min}, {y_min}) to ({x_max}, {y_max}) is not a part of the {width} × {height} image"
            );
            self.error("bad-film", &NOWHERE, message);
        }
        self.number(|| "the diagonal of the film".to_owned(), film.diagonal, Range::Positive, &NOWHERE);
        self.number(|| "the exposure".to_owned(), film.exposure, Range::Positive, &NOWHERE);
        if film.max_component.is_nan() || film.max_component <= 0.0 {
            let message = format!("the largest component is {}: expected more than zero", film.max_component);
            self.error("bad-film", &NOWHERE, message);
        }
    }

    fn filter(&mut self, filter: &Filter) {
        let (Filter::Box { radius }
        | Filter::Triangle { radius }
        | Filter::Gaussian { radius, .. }
        | Filter::Mitchell { radius, .. }
        | Filter::Sinc { radius, .. }) = *filter;
        for value in radius {
            self.number(|| "the radius of the pixel filter".to_owned(), value, Range::Positive, &NOWHERE);
        }
        match *filter {
            Filter::Gaussian { sigma, .. } => {
                self.number(
                    || "the width of the Gaussian filter".to_owned(),
                    sigma,
                    Range::Positive,
                    &NOWHERE,
                );
            }
            Filter::Sinc { tau, .. } => {
                self.number(|| "the window of the sinc filter".to_owned(), tau, Range::Positive, &NOWHERE);
            }
            Filter::Mitchell { b, c, .. } => {
                for value in [b, c] {
                    self.number(
                        || "a parameter of the Mitchell filter".to_owned(),
                        value,
                        Range::Finite,
                        &NOWHERE,
                    );
                }
            }
            Filter::Box { .. } | Filter::Triangle { .. } => {}
        }
    }

    fn spectrum(&mut self, what: &str, spectrum: &Spectrum, origin: &Origin) {
        match spectrum {
            Spectrum::Constant(value) => self.number(|| what.to_owned(), *value, Range::Finite, origin),
            Spectrum::Rgb { rgb, .. } => {
                for value in *rgb {
                    self.number(|| format!("a component of {what}"), value, Range::Finite, origin);
                }
            }
            Spectrum::Blackbody(kelvin) => {
                self.number(|| format!("the temperature of {what}"), *kelvin, Range::Positive, origin);
            }
            Spectrum::Sampled(samples) => {
                let finite =
                    samples.iter().all(|(wavelength, value)| wavelength.is_finite() && value.is_finite());
                let increasing = samples.windows(2).all(|pair| pair[0].0 < pair[1].0);
                if samples.is_empty() || !finite || !increasing {
                    let message = format!(
                        "the samples of {what} must be finite, at increasing wavelengths, and at least one"
                    );
                    self.error("bad-spectrum", origin, message);
                }
            }
            // Which names there are is the renderer's to know.
            Spectrum::Named(_) => {}
        }
    }

    fn spectrum_param(&mut self, owner: &str, what: &str, param: &SpectrumParam, origin: &Origin) {
        match param {
            SpectrumParam::Constant(spectrum) => {
                self.spectrum(&format!("{what} of {owner}"), spectrum, origin);
            }
            SpectrumParam::Texture(handle) => {
                self.handle("texture", *handle, &self.scene.textures, owner, origin);
            }
        }
    }

    fn float_param(&mut self, owner: &str, what: &str, param: FloatParam, range: Range, origin: &Origin) {
        match param {
            FloatParam::Constant(value) => self.number(|| format!("{what} of {owner}"), value, range, origin),
            FloatParam::Texture(handle) => {
                self.handle("texture", handle, &self.scene.textures, owner, origin);
            }
        }
    }

    fn shapes(&mut self) {
        for (handle, shape) in self.scene.shapes.iter() {
            let origin = self.scene.shapes.origin(handle);
            let owner = called("shape", origin);
            self.handle("material", shape.material, &self.scene.materials, &owner, origin);
            self.geometry(&owner, shape, origin);
            self.medium_interface(&owner, shape.media, origin);
            self.float_param(&owner, "the alpha", shape.alpha, Range::Finite, origin);
            if let Some(light) = &shape.area_light {
                self.area_light(&owner, light, origin);
                if self.scene.materials.get(shape.material) == Some(&Material::Interface) {
                    let message = format!("the emission of {owner} is left out: an interface has no surface");
                    self.diagnostics.push(Diagnostic::warning("dropped-light", origin.span, message));
                }
            }
        }
    }

    fn geometry(&mut self, owner: &str, shape: &Shape, origin: &Origin) {
        let scene = self.scene;
        match shape.geometry {
            Geometry::Triangles(mesh) => {
                self.handle("triangle mesh", mesh, &scene.triangle_meshes, owner, origin);
            }
            Geometry::Patches(mesh) => self.handle("patch mesh", mesh, &scene.patch_meshes, owner, origin),
            Geometry::Displaced { mesh, displacement, edge_length } => {
                self.handle("triangle mesh", mesh, &scene.triangle_meshes, owner, origin);
                self.float_param(owner, "the displacement", displacement, Range::Finite, origin);
                self.number(|| format!("the edge length of {owner}"), edge_length, Range::Positive, origin);
                if scene.triangle_meshes.get(mesh).is_some_and(|mesh| mesh.uvs.is_none()) {
                    let message = format!("the displaced mesh of {owner} has no texture coordinates");
                    self.error("missing-attribute", origin, message);
                }
            }
            Geometry::Curves(curves) => self.handle("curves", curves, &scene.curves, owner, origin),
            Geometry::Sphere { radius, z_min, z_max, phi_max }
            | Geometry::Cylinder { radius, z_min, z_max, phi_max } => {
                self.number(|| format!("the radius of {owner}"), radius, Range::Positive, origin);
                self.number(|| format!("the lower end of {owner}"), z_min, Range::Finite, origin);
                self.number(|| format!("the upper end of {owner}"), z_max, Range::Finite, origin);
                self.number(|| format!("the sweep of {owner}"), phi_max, Range::Positive, origin);
            }
            Geometry::Disk { height, radius, inner_radius, phi_max } => {
                self.number(|| format!("the height of {owner}"), height, Range::Finite, origin);
                self.number(|| format!("the radius of {owner}"), radius, Range::Positive, origin);
                self.number(
                    || format!("the inner radius of {owner}"),
                    inner_radius,
                    Range::NotNegative,
                    origin,
                );
                self.number(|| format!("the sweep of {owner}"), phi_max, Range::Positive, origin);
                if inner_radius >= radius && inner_radius.is_finite() && radius > 0.0 {
                    let message =
                        format!("the hole of {owner} is as large as the disk: {inner_radius} of {radius}");
                    self.error("bad-number", origin, message);
                }
            }
        }
    }

    fn objects(&mut self) {
        let scene = self.scene;
        for &shape in &scene.world {
            self.handle("shape", shape, &scene.shapes, "the world", &NOWHERE);
        }
        for (handle, Object { shapes }) in scene.objects.iter() {
            let origin = scene.objects.origin(handle);
            let owner = called("object", origin);
            for &shape in shapes {
                self.handle("shape", shape, &scene.shapes, &owner, origin);
            }
        }
        for (handle, instance) in scene.instances.iter() {
            let origin = scene.instances.origin(handle);
            self.handle("object", instance.object, &scene.objects, &called("instance", origin), origin);
        }
    }

    /// Warns of pictures that are black for certain.
    fn emptiness(&mut self) {
        let scene = self.scene;
        if scene.world.is_empty() && scene.instances.is_empty() {
            self.diagnostics.push(Diagnostic::warning("no-shape", None, "the scene has no shapes"));
        }
        let needs_light = matches!(scene.integrator, Integrator::Path(_) | Integrator::Whitted { .. });
        let emits = scene.shapes.values().iter().any(|shape| shape.area_light.is_some())
            || scene.materials.values().iter().any(Material::emits)
            || scene.media.values().iter().any(Medium::emits);
        if needs_light && scene.lights.is_empty() && !emits {
            self.diagnostics.push(Diagnostic::warning(
                "no-light",
                None,
                "the scene has no light: the image is black",
            ));
        }
    }
}

/// What a number may be.
#[derive(Clone, Copy)]
enum Range {
    Finite,
    NotNegative,
    Positive,
}

impl Range {
    fn contains(self, value: f32) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::NotNegative => value >= 0.0,
                Self::Positive => value > 0.0,
            }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Finite => "a finite number",
            Self::NotNegative => "zero or more",
            Self::Positive => "more than zero",
        }
    }
}

#[cfg(test)]
mod tests;
