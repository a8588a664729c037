//! A scene that is ready to be rendered.

use std::sync::Arc;

use sahl_accel::{Accel, Hit};
use sahl_math::{Bounds3, Ray, Vec2, Vec3};
use sahl_scene::{ColorMode, Quirks};

use crate::bsdf::{Bsdf, BsdfRoom};
use crate::camera::Camera;
use crate::film::Sensor;
use crate::filter::PixelFilter;
use crate::integrator::TileRenderer;
use crate::interaction::Interaction;
use crate::light::Light;
use crate::material::{Composition, Material, Query, Relief, SubsurfaceSource};
use crate::medium::Medium;
use crate::sampler::Sampler;
use crate::shape::{Attributes, Border};
use crate::spectrum::Wavelengths;
use crate::texture::{Footprint, TexturePoint, Textures};

/// A scene that is ready to be rendered: immutable, cheap to clone, shared between threads.
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) data: Arc<SceneData>,
}

/// How much there is of everything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneStats {
    /// Triangles, each counted once however often it is placed.
    pub triangles: u64,
    /// Bilinear patches, likewise.
    pub patches: u64,
    /// Spheres, disks and cylinders, likewise.
    pub quadrics: u64,
    /// Segments of curves, likewise.
    pub curves: u64,
    /// Placements of objects.
    pub instances: u64,
    /// Materials.
    pub materials: u64,
    /// Textures.
    pub textures: u64,
    /// Decoded images.
    pub images: u64,
    /// Lights; a mesh that emits counts as many as it has primitives.
    pub lights: u64,
    /// Bytes of vertices, indices and images.
    pub data_bytes: u64,
    /// The acceleration structure.
    pub accel: sahl_accel::Stats,
}

/// One sample of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Its colour on the film: linear, exposed, in the film's colour space.
    pub rgb: [f32; 3],
    /// The pixel filter's weight: the pixel is the mean of its samples' colours weighted by it.
    pub weight: f32,
    /// Whether the film adds it: not if it is NaN, infinite or negative.
    pub is_kept: bool,
}

/// Everything that is needed to compute a sample.
#[derive(Debug)]
pub(crate) struct SceneData {
    pub(crate) accel: Accel,
    /// By geometry of the accelerator.
    pub(crate) attributes: Vec<Attributes>,
    /// Whether some of them are partly there.
    pub(crate) has_alpha: bool,
    pub(crate) materials: Vec<Material>,
    pub(crate) textures: Textures,
    /// None if the integrator leaves them out.
    pub(crate) media: Vec<Medium>,
    /// In which of them the camera is, or [`Border::VACUUM`].
    pub(crate) camera_medium: u32,
    pub(crate) lights: Vec<Light>,
    /// Which lights rays find that leave the scene.
    pub(crate) environments: Vec<u32>,
    pub(crate) camera: Camera,
    pub(crate) film: sahl_scene::Film,
    pub(crate) filter: PixelFilter,
    pub(crate) sampler: Sampler,
    /// Of a pixel's side, what one sample stands for: textures are smoothed over so much.
    pub(crate) footprint_scale: f32,
    /// Whether anything moves while the shutter is open: only then has a sample a time.
    pub(crate) moves: bool,
    /// Samples a pixel.
    pub(crate) samples: u32,
    pub(crate) integrator: Box<dyn TileRenderer>,
    /// What the lanes of paths mean.
    pub(crate) color: ColorMode,
    pub(crate) quirks: Quirks,
    pub(crate) stats: SceneStats,
}

impl Scene {
    /// How much there is of everything.
    pub fn stats(&self) -> SceneStats {
        self.data.stats
    }

    /// The box about all surfaces, in the world.
    pub fn bounds(&self) -> Bounds3 {
        self.data.accel.bounds()
    }

    /// Samples that a complete render takes for each pixel.
    pub fn samples_per_pixel(&self) -> u32 {
        self.data.samples
    }

    /// The acceleration structure.
    pub fn accel(&self) -> &Accel {
        &self.data.accel
    }

    /// The ray through a place on the film, in pixels from the upper left corner, and the middle of the lens, when the shutter
    /// opens; an empty one where a lens of glass lets nothing through.
    pub fn camera_ray(&self, film: Vec2) -> Ray {
        self.data.camera.ray(film, Vec2::splat(0.5), 0.0).ray
    }

    /// Sample `index` of `pixel` alone, the same that [`crate::render`] adds to the film: any sample can be replayed.
    pub fn sample(&self, pixel: [u32; 2], index: u32) -> Sample {
        let sample = self.data.integrator.sample(&self.data, pixel, index);
        let sensor = Sensor::new(&self.data.film);
        Sample {
            rgb: sensor.color(sample.radiance, &sample.tracer.wavelengths),
            weight: sample.weight,
            is_kept: sensor.kept_color(sample.radiance, &sample.tracer.wavelengths).is_some(),
        }
    }
}

impl SceneData {
    /// What the surface is like where `ray` hit it.
    #[inline]
    pub(crate) fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        let attributes = &self.attributes[hit.geometry as usize];
        let mut at = attributes.interaction(&self.accel, ray, hit, self.quirks.leaky_normals);
        if attributes.is_composed {
            self.decompose(&mut at, ray, hit);
        }
        at
    }

    /// Finds out which part of its material the surface is made of at this point, and its relief.
    #[inline(never)]
    fn decompose(&self, at: &mut Interaction, ray: &Ray, hit: &Hit) {
        let (point, mut wavelengths) = (self.texture_point(at), Wavelengths::default());
        let query =
            Query { textures: &self.textures, at: &point, wavelengths: &mut wavelengths, regularize: false };
        at.material = Composition::resolve(&self.materials, at.material, &query, |relief| {
            self.emboss(relief, at, ray, hit);
        });
    }

    /// Gives the surface the shading normals of `relief`.
    fn emboss(&self, relief: &Relief, at: &mut Interaction, ray: &Ray, hit: &Hit) {
        // Bumps compare heights half a pixel apart.
        let footprint = self.footprint(at);
        let point = TexturePoint { uv: at.uv, p: at.p, n: at.ng, face: self.face(at), footprint };
        let mut wavelengths = Wavelengths::default();
        let query =
            Query { textures: &self.textures, at: &point, wavelengths: &mut wavelengths, regularize: false };
        let attributes = &self.attributes[hit.geometry as usize];
        let derivatives = |at: &Interaction| attributes.derivatives(&self.accel, hit, at);
        relief.shape(at, -ray.direction, &query, derivatives);
    }

    /// Where textures of the surface are evaluated.
    #[inline]
    pub(crate) fn texture_point(&self, at: &Interaction) -> TexturePoint {
        let needed = self.textures.need_footprint();
        let footprint = if needed { self.footprint(at) } else { Footprint::default() };
        TexturePoint { uv: at.uv, p: at.p, n: at.ng, face: self.face(at), footprint }
    }

    /// The number of the face for textures that ask for it.
    #[inline]
    pub(crate) fn face(&self, at: &Interaction) -> u32 {
        if !self.textures.need_face() {
            return 0;
        }
        self.attributes[at.place.geometry as usize].face(at.place.primitive)
    }

    /// What the part of a pixel that one sample stands for covers of the surface.
    #[inline(never)]
    fn footprint(&self, at: &Interaction) -> Footprint {
        let footprint = self.camera.footprint(at.p, at.ng, at.time);
        let [dp_dx, dp_dy] = [footprint.dp_dx, footprint.dp_dy].map(|dp| dp * self.footprint_scale);
        let attributes = &self.attributes[at.place.geometry as usize];
        let derivatives = attributes.derivatives(&self.accel, &at.hit(), at);
        let [duv_dx, duv_dy] = [dp_dx, dp_dy].map(|dp| derivatives.coordinates(dp));
        Footprint { dp_dx, dp_dy, duv_dx, duv_dy }
    }

    /// How the surface scatters light, and glass may drop all wavelengths but the first; `room` is where a BSDF with many
    /// parameters is kept.
    #[inline]
    pub(crate) fn bsdf<'r>(
        &'r self,
        at: &Interaction,
        wavelengths: &mut Wavelengths,
        regularize: bool,
        room: &'r mut BsdfRoom,
    ) -> Bsdf<'r> {
        let point = self.texture_point(at);
        let mut query = Query { textures: &self.textures, at: &point, wavelengths, regularize };
        self.materials[at.material as usize].bsdf(&mut query, room)
    }

    /// The matter below the surface, if light spreads in it.
    #[inline]
    pub(crate) fn subsurface(&self, material: u32) -> Option<&SubsurfaceSource> {
        match &self.materials[material as usize] {
            Material::Subsurface(source) => Some(source),
            _ => None,
        }
    }

    /// Whether `hit` lies on no surface, but on the border of a medium alone.
    #[inline]
    pub(crate) fn is_border(&self, hit: &Hit) -> bool {
        self.attributes[hit.geometry as usize].border.is_open
    }

    /// The medium of light that leaves `at`, which `hit` found from within `medium`, along `direction`.
    #[inline]
    pub(crate) fn medium_beyond(&self, hit: &Hit, at: &Interaction, direction: Vec3, medium: u32) -> u32 {
        match self.attributes[hit.geometry as usize].border {
            Border { sides: Some([inside, outside]), .. } => {
                if direction.dot(at.ng) > 0.0 {
                    outside
                } else {
                    inside
                }
            }
            Border { sides: None, .. } => medium,
        }
    }

    /// The light that the surface is, if it emits.
    #[inline]
    pub(crate) fn light(&self, at: &Interaction) -> Option<&Light> {
        self.lights.get(at.light as usize)
    }
}
