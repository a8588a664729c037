//! What a camera sees beside light: features of the first surface, one image each.

use crate::bsdf::BsdfRoom;
use crate::integrator::Tracer;
use crate::interaction::Interaction;
use crate::spectrum::{Spectrum, Wavelengths};

use sahl_math::Ray;

/// A feature of the first surface that the camera sees, averaged over the samples of a pixel.
///
/// Colours and normals are averaged over all samples, the ones that see nothing counting as zero, which is what
/// denoisers expect; depth, position and texture coordinates over those that see a surface. All are zero where no
/// sample sees one. Filter weights do not matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Aov {
    /// An estimate of the share of light that the surface scatters, linear sRGB.
    Albedo,
    /// Shading normal in the world, on the front of the surface.
    Normal,
    /// Geometric normal in the world, on the front of the surface.
    GeometricNormal,
    /// Distance from the plane of the camera along the axis of view, in metres.
    Depth,
    /// Position in the world.
    Position,
    /// Texture coordinates.
    Uv,
}

/// The most numbers that one sample adds: every feature once, and the count of hits.
const MAX_SUMS: usize = 16;

impl Aov {
    /// Every feature.
    pub const ALL: [Self; 6] =
        [Self::Albedo, Self::Normal, Self::GeometricNormal, Self::Depth, Self::Position, Self::Uv];

    /// The layer's name in an EXR file, after pbrt-v4's; `None` for channels that stand beside those of the image.
    pub const fn layer_name(self) -> Option<&'static str> {
        match self {
            Self::Albedo => Some("Albedo"),
            Self::Normal => Some("Ns"),
            Self::GeometricNormal => Some("N"),
            Self::Position => Some("P"),
            Self::Depth | Self::Uv => None,
        }
    }

    /// The names of the channels in their layer.
    pub const fn channel_names(self) -> &'static [&'static str] {
        match self {
            Self::Albedo => &["R", "G", "B"],
            Self::Normal | Self::GeometricNormal | Self::Position => &["X", "Y", "Z"],
            Self::Depth => &["Z"],
            Self::Uv => &["u", "v"],
        }
    }

    /// How many numbers a sample adds for `aovs`: their channels and the count of hits, or none at all.
    pub(crate) fn sums(aovs: &[Self]) -> usize {
        let channels: usize = aovs.iter().map(|aov| aov.channel_names().len()).sum();
        if aovs.is_empty() { 0 } else { channels + 1 }
    }

    /// Turns the sums of a pixel into its values.
    pub(crate) fn develop(self, sums: &[f64], hits: f64, samples: u32, out: &mut [f32]) {
        let count = match self {
            Self::Albedo | Self::Normal | Self::GeometricNormal => f64::from(samples),
            Self::Depth | Self::Position | Self::Uv => hits,
        };
        for (value, sum) in out.iter_mut().zip(sums) {
            *value = if count > 0.0 { (sum / count) as f32 } else { 0.0 };
        }
    }
}

/// The features of one sample, in the order of the film's sums.
pub(crate) struct Features {
    values: [f32; MAX_SUMS],
    len: usize,
}

impl Features {
    /// What `ray` sees first. Colours of features are no light: they are found in RGB in either mode, which leaves the tracer
    /// at the end of its sample in RGB mode.
    pub(crate) fn of(tracer: &mut Tracer<'_>, ray: &Ray, aovs: &[Aov]) -> Self {
        let mut features = Self { values: [0.0; MAX_SUMS], len: 0 };
        tracer.wavelengths = Wavelengths::Rgb;
        let Some(at) = tracer.nearest_surface(ray) else {
            features.len = Aov::sums(aovs).min(MAX_SUMS);
            return features;
        };
        for aov in aovs {
            match aov {
                Aov::Albedo => features.push(&albedo(tracer, &at, ray).to_rgb()),
                Aov::Normal => features.push(&<[f32; 3]>::from(at.shading.z)),
                Aov::GeometricNormal => features.push(&<[f32; 3]>::from(at.ng)),
                Aov::Depth => features.push(&[tracer.scene.camera.depth(at.p, at.time)]),
                Aov::Position => features.push(&<[f32; 3]>::from(at.p)),
                Aov::Uv => features.push(&<[f32; 2]>::from(at.uv)),
            }
        }
        features.push(&[1.0]);
        features
    }

    pub(crate) fn values(&self) -> &[f32] {
        &self.values[..self.len]
    }

    fn push(&mut self, values: &[f32]) {
        self.values[self.len..self.len + values.len()].copy_from_slice(values);
        self.len += values.len();
    }
}

fn albedo(tracer: &mut Tracer<'_>, at: &Interaction, ray: &Ray) -> Spectrum {
    let mut room = BsdfRoom::default();
    tracer.bsdf(at, false, &mut room).albedo(at.shading.to_local(-ray.direction))
}
