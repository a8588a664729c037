//! What was typed for `render`, resolved: one meaning, whichever of the spellings was used.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::ValueEnum;
use sahl::image::{Curve, ToneMap};
use sahl::render::accel::{self, Builder};
use sahl::render::{Aov, BuildOptions};
use sahl::scene::{Diagnostic, Diagnostics, Film, Integrator, PathTracer, SceneDesc, suggest};

use crate::args::{
    AccelName, AovName, ColorMode, Crop, CurveName, Definition, Fractions, IntegratorName, PixelPosition,
    RenderArgs, Resolution, Seconds,
};
use crate::failure::Failure;

/// The keys of `-D`.
const KEYS: [&str; 8] = ["spp", "seed", "threads", "width", "height", "integrator", "max_depth", "time"];

/// What `render` is asked to do, apart from the scene.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// Changes to the scene.
    pub(crate) edits: Edits,
    /// Threads; 0 for all.
    pub(crate) threads: usize,
    /// Width of a tile.
    pub(crate) tile_size: u32,
    /// Layers beside the image.
    pub(crate) aovs: Vec<Aov>,
    /// Whether the variance of the pixels is one of them.
    pub(crate) variance: bool,
    /// When to stop.
    pub(crate) time: Option<Duration>,
    /// What to write; the scene says it otherwise.
    pub(crate) output: Option<PathBuf>,
    /// How 8-bit pictures are made, if it was given.
    pub(crate) tone_map: Option<ToneMap>,
    /// How the scene is built.
    pub(crate) build: BuildOptions,
    /// The only pixel to render.
    pub(crate) pixel: Option<[u32; 2]>,
}

/// Changes to a scene; `None` leaves it as it is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Edits {
    spp: Option<u32>,
    seed: Option<u64>,
    integrator: Option<IntegratorName>,
    max_depth: Option<u32>,
    clamp_indirect: Option<f32>,
    regularize: bool,
    smooth_terminator: bool,
    color: Option<ColorMode>,
    width: Option<u32>,
    height: Option<u32>,
    crop: Option<Area>,
    camera: Option<u32>,
}

/// A part of the image.
#[derive(Clone, Copy, Debug)]
enum Area {
    Pixels([u32; 4]),
    Shares([f32; 4]),
}

impl Settings {
    /// Settles what `args` mean.
    pub(crate) fn new(args: &RenderArgs) -> Result<Self, Failure> {
        refuse_what_is_absent(args)?;
        let crop = |Crop(bounds)| Area::Pixels(bounds);
        let cropwindow = |Fractions(bounds)| Area::Shares(bounds);
        let resolution = args.frame.resolution.map(|Resolution(size)| size);
        let edits = Edits {
            spp: args.sampling.spp,
            seed: args.sampling.seed,
            integrator: args.sampling.integrator,
            max_depth: args.sampling.max_depth,
            clamp_indirect: args.sampling.clamp_indirect,
            regularize: args.sampling.regularize,
            smooth_terminator: args.sampling.smooth_terminator,
            color: args.sampling.color,
            width: resolution.map(|[width, _]| width),
            height: resolution.map(|[_, height]| height),
            crop: args.frame.crop.map(crop).or(args.frame.cropwindow.map(cropwindow)),
            camera: args.frame.camera,
        };
        let mut settings = Self {
            edits,
            threads: args.work.threads.unwrap_or(0),
            tile_size: args.work.tile_size,
            aovs: distinct(&args.picture.aov),
            variance: args.picture.aov.contains(&AovName::Variance),
            time: args.sampling.time.map(|Seconds(duration)| duration),
            output: args.output.clone(),
            tone_map: tone_map(args),
            build: build_with(match args.work.accel {
                AccelName::Median => Builder::Median,
                AccelName::Fast => Builder::Fast,
                AccelName::Sah => Builder::BinnedSah,
                AccelName::High => Builder::HighQuality,
            }),
            pixel: args.sampling.pixel.map(|PixelPosition(pixel)| pixel),
        };
        let mut threads = args.work.threads;
        for definition in &args.definitions {
            settings.define(definition, &mut threads)?;
        }
        settings.threads = threads.unwrap_or(0);
        Ok(settings)
    }

    /// Applies one `-D key=value`.
    fn define(&mut self, definition: &Definition, threads: &mut Option<usize>) -> Result<(), Failure> {
        let edits = &mut self.edits;
        match definition.key.as_str() {
            "spp" => set(&mut edits.spp, definition, |&spp| spp > 0),
            "seed" => set(&mut edits.seed, definition, |_| true),
            "threads" => set(threads, definition, |_| true),
            "width" => set(&mut edits.width, definition, |&width| width > 0),
            "height" => set(&mut edits.height, definition, |&height| height > 0),
            "max_depth" => set(&mut edits.max_depth, definition, |_| true),
            "time" => {
                let mut time = self.time.map(Seconds);
                set(&mut time, definition, |_| true)?;
                self.time = time.map(|Seconds(duration)| duration);
                Ok(())
            }
            "integrator" => {
                let mut integrator = edits.integrator.map(Named);
                set(&mut integrator, definition, |_| true)?;
                edits.integrator = integrator.map(|Named(name)| name);
                Ok(())
            }
            unknown => {
                let failure = Failure::usage(format!("`-D` does not know the key `{unknown}`"));
                Err(match suggest::nearest(unknown, KEYS) {
                    Some(nearest) => failure.with_help(format!("did you mean `{nearest}`?")),
                    None => failure.with_help(format!("the keys are {}", KEYS.join(", "))),
                })
            }
        }
    }
}

/// The usual way to build, with this builder of trees.
pub(crate) fn build_with(builder: Builder) -> BuildOptions {
    BuildOptions { accel: accel::BuildOptions { builder, ..accel::BuildOptions::default() } }
}

/// Sets what was not set before.
fn set<T: FromStr>(
    target: &mut Option<T>,
    definition: &Definition,
    accepts: impl Fn(&T) -> bool,
) -> Result<(), Failure> {
    let Definition { key, value } = definition;
    if target.is_some() {
        return Err(Failure::usage(format!("`{key}` is given twice, the second time by `-D {key}={value}`")));
    }
    let parsed = value.parse().ok().filter(accepts);
    *target =
        Some(parsed.ok_or_else(|| Failure::usage(format!("`-D {key}={value}`: `{value}` is no {key}")))?);
    Ok(())
}

/// An integrator by the name that `--integrator` takes.
struct Named(IntegratorName);

impl FromStr for Named {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        IntegratorName::from_str(name, true).map(Self)
    }
}

impl Edits {
    /// Changes the scene; warns of what can be done in part only.
    pub(crate) fn apply(&self, scene: &mut SceneDesc, diagnostics: &mut Diagnostics) -> Result<(), Failure> {
        if let Some(camera) = self.camera.filter(|&camera| camera > 0) {
            let message = format!("`--camera {camera}`: the scene has one camera, number 0");
            return Err(Failure::usage(message));
        }
        scene.sampler.samples = self.spp.unwrap_or(scene.sampler.samples);
        scene.sampler.seed = self.seed.unwrap_or(scene.sampler.seed);
        scene.color = self.color.map_or(scene.color, ColorMode::mode);
        self.apply_integrator(&mut scene.integrator)?;
        self.apply_frame(&mut scene.film, diagnostics)
    }

    fn apply_integrator(&self, integrator: &mut Integrator) -> Result<(), Failure> {
        let path = match *integrator {
            Integrator::Path(path) => path,
            Integrator::Whitted { max_depth } => PathTracer { max_depth, ..PathTracer::default() },
            Integrator::Ao { .. } | Integrator::Normals => PathTracer::default(),
        };
        match self.integrator {
            None => {}
            // Whoever asks for it wants what the files of pbrt have `volpath` for, too.
            Some(IntegratorName::Path) => *integrator = Integrator::Path(PathTracer { media: true, ..path }),
            Some(IntegratorName::Whitted) => {
                *integrator = Integrator::Whitted { max_depth: path.max_depth };
            }
            Some(IntegratorName::Ao) if matches!(integrator, Integrator::Ao { .. }) => {}
            Some(IntegratorName::Ao) => *integrator = Integrator::Ao { max_distance: f32::INFINITY },
            Some(IntegratorName::Normals) => *integrator = Integrator::Normals,
        }
        self.tame(integrator)?;
        match (self.max_depth, integrator) {
            (
                Some(depth),
                Integrator::Path(PathTracer { max_depth, .. }) | Integrator::Whitted { max_depth },
            ) => {
                *max_depth = depth;
                Ok(())
            }
            (Some(_), Integrator::Ao { .. } | Integrator::Normals) => {
                Err(Failure::usage("`--max-depth` has no meaning for the integrators `ao` and `normals`"))
            }
            (None, _) => Ok(()),
        }
    }

    /// Sets what makes path tracing differ from the physics of the scene.
    fn tame(&self, integrator: &mut Integrator) -> Result<(), Failure> {
        if let Some(limit) = self.clamp_indirect
            && !(limit > 0.0 && limit.is_finite())
        {
            return Err(Failure::usage(format!("`--clamp-indirect {limit}`: expected a number above zero")));
        }
        if self.clamp_indirect.is_none() && !self.regularize && !self.smooth_terminator {
            return Ok(());
        }
        let Integrator::Path(path) = integrator else {
            let message = "`--clamp-indirect`, `--regularize` and `--smooth-terminator` have a meaning for the \
                           integrator `path` alone";
            return Err(Failure::usage(message));
        };
        path.smooth_terminator |= self.smooth_terminator;
        path.clamp_indirect = self.clamp_indirect.or(path.clamp_indirect);
        path.regularize |= self.regularize;
        Ok(())
    }

    /// Sets resolution and crop. A crop of the scene keeps its place in the picture when the resolution changes.
    fn apply_frame(&self, film: &mut Film, diagnostics: &mut Diagnostics) -> Result<(), Failure> {
        let before = film.resolution;
        film.resolution = [self.width.unwrap_or(before[0]), self.height.unwrap_or(before[1])];
        let [width, height] = film.resolution;
        let crop = match (self.crop, film.crop) {
            (Some(Area::Pixels(bounds)), _) => bounds,
            (Some(Area::Shares(shares)), _) => pixels_of(shares, film.resolution),
            (None, Some(bounds)) if before != film.resolution => {
                let share = |bound: u32, size: u32| bound as f32 / size.max(1) as f32;
                let [x0, x1, y0, y1] = bounds;
                let shares =
                    [share(x0, before[0]), share(x1, before[0]), share(y0, before[1]), share(y1, before[1])];
                pixels_of(shares, film.resolution)
            }
            (None, _) => return Ok(()),
        };
        let inside = [crop[0], crop[1].min(width), crop[2], crop[3].min(height)];
        if inside[0] >= inside[1] || inside[2] >= inside[3] {
            let [x0, x1, y0, y1] = crop;
            let message =
                format!("the crop {x0},{x1},{y0},{y1} holds no pixel of the {width}x{height} image");
            return Err(Failure::usage(message));
        }
        if inside != crop {
            let ([x0, x1, y0, y1], [left, right, top, bottom]) = (crop, inside);
            let message = format!(
                "the crop {x0},{x1},{y0},{y1} reaches beyond the {width}x{height} image: \
                 {left},{right},{top},{bottom} is rendered"
            );
            diagnostics.push(Diagnostic::warning("crop-outside", None, message));
        }
        film.crop = Some(inside);
        Ok(())
    }
}

/// pbrt's rule: bounds are rounded up, so that adjacent crops neither overlap nor leave a gap.
fn pixels_of(shares: [f32; 4], [width, height]: [u32; 2]) -> [u32; 4] {
    let bound = |share: f32, size: u32| (share * size as f32).ceil() as u32;
    [bound(shares[0], width), bound(shares[1], width), bound(shares[2], height), bound(shares[3], height)]
}

/// Each layer once, in the order of asking; the variance is not one of those that samples carry.
fn distinct(names: &[AovName]) -> Vec<Aov> {
    let mut aovs = Vec::new();
    for name in names {
        let aov = match name {
            AovName::Albedo => Aov::Albedo,
            AovName::Normal => Aov::Normal,
            AovName::GeometricNormal => Aov::GeometricNormal,
            AovName::Depth => Aov::Depth,
            AovName::Position => Aov::Position,
            AovName::Uv => Aov::Uv,
            AovName::Variance => continue,
        };
        if !aovs.contains(&aov) {
            aovs.push(aov);
        }
    }
    aovs
}

fn tone_map(args: &RenderArgs) -> Option<ToneMap> {
    if args.picture.exposure.is_none() && args.picture.tonemap.is_none() {
        return None;
    }
    let curve = match args.picture.tonemap {
        Some(CurveName::Filmic) => Curve::Filmic,
        Some(CurveName::Srgb) | None => Curve::Srgb,
    };
    Some(ToneMap { exposure_stops: args.picture.exposure.unwrap_or(0.0), curve })
}

/// Options that people know from the design or from other renderers, and that this version can't honour.
fn refuse_what_is_absent(args: &RenderArgs) -> Result<(), Failure> {
    let absent = &args.absent;
    let (option, help) = if absent.noise.is_some() {
        ("--noise", "`--spp` and `--time` limit the work")
    } else if absent.checkpoint.is_some() {
        ("--checkpoint", "`--time` and Ctrl-C write the image so far")
    } else if absent.resume.is_some() {
        ("--resume", "a render that is interrupted writes what it has")
    } else if absent.tev.is_some() {
        ("--tev", "`--progress json` tells how far the render is")
    } else {
        return Ok(());
    };
    Err(Failure::usage(format!("`{option}` is not available yet")).with_help(help))
}
