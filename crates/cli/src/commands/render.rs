//! `sahl render`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use sahl::image::{Attribute, EncodeOptions, Format, Layer, Metadata, Picture, ToneMap};
use sahl::render::{Film, RenderOptions, Rendered, Scene};
use sahl::scene::{Integrator, PathTracer, SceneDesc};
use serde_json::json;

use crate::args::{ProgressKind, RenderArgs};
use crate::commands::compare::VARIANCE_LAYER;
use crate::commands::print;
use crate::console::Console;
use crate::failure::{Failure, Reason};
use crate::format;
use crate::interrupt;
use crate::memory;
use crate::output::Output;
use crate::progress::Monitor;
use crate::settings::Settings;
use crate::source::Source;

/// Loads, builds, renders, develops and writes.
pub(crate) fn run(args: &RenderArgs, console: Console) -> Result<ExitCode, Failure> {
    let settings = Settings::new(args)?;
    // What is typed is checked before the scene is read, what the scene says after that.
    let mut target = settings.output.as_deref().map(|path| Target::check(path, &settings)).transpose()?;
    let mut source = Source::load(&args.scenes)?;
    source.report(args.messages.strict, &console)?;
    settings.edits.apply(&mut source.loaded.scene, &mut source.loaded.diagnostics)?;
    source.report(args.messages.strict, &console)?;
    if settings.pixel.is_none() {
        let channels = settings.aovs.iter().map(|aov| aov.channel_names().len()).sum();
        memory::check_room(&source.loaded.scene.film, channels, memory::available())?;
    }
    if target.is_none() && settings.pixel.is_none() {
        target = Some(Target::check(&default_output(&source), &settings)?);
    }
    if let Some(target) = &target {
        target.output.spare(&source.files)?;
    }
    let scene = source.build(&settings.build, args.messages.strict, &console)?;
    if let Some(pixel) = settings.pixel {
        return replay(&scene, &source.loaded.scene, pixel);
    }
    interrupt::listen();
    let target = target.expect("every render but that of a pixel has a file to write");
    let job = Job { settings: &settings, source: &source, scene: &scene, console };
    job.run(&target, args.work.progress)
}

/// A file to write, with its format.
struct Target {
    output: Output,
    format: Format,
    tone_map: ToneMap,
}

impl Target {
    /// Finds out whether the image can be written as it is asked for.
    fn check(path: &Path, settings: &Settings) -> Result<Self, Failure> {
        let format = Format::from_path(path).ok_or_else(|| {
            Failure::usage(format!("`{}` does not tell an image format", path.display()))
                .with_help("name a file with `-o` that ends in .exr, .hdr, .pfm, .png or .ppm")
        })?;
        if (settings.variance || !settings.aovs.is_empty()) && format != Format::Exr {
            return Err(Failure::usage(format!(
                "`--aov` needs layers, which `{}` can't hold",
                path.display()
            ))
            .with_help("name a file with `-o` that ends in .exr"));
        }
        if matches!(format, Format::Jpeg | Format::Tga) {
            return Err(Failure::usage(format!("`{}`: this format can only be read", path.display()))
                .with_help("name a file with `-o` that ends in .exr, .hdr, .pfm, .png or .ppm"));
        }
        let is_display = matches!(format, Format::Png | Format::Ppm);
        if settings.tone_map.is_some() && !is_display {
            let message = format!("`--exposure` and `--tonemap` do not apply to `{}`", path.display());
            return Err(
                Failure::usage(message).with_help("it holds light as it is; .png and .ppm hold pictures")
            );
        }
        let output = Output::check(path)?;
        Ok(Self { output, format, tone_map: settings.tone_map.unwrap_or_default() })
    }
}

/// Where the scene wants its image, else a name like its own.
fn default_output(source: &Source) -> PathBuf {
    let asked = source.loaded.scene.film.filename.as_ref().map(PathBuf::from);
    asked.unwrap_or_else(|| PathBuf::from(format!("{}.exr", source.stem)))
}

/// Everything that a render needs to know.
struct Job<'a> {
    settings: &'a Settings,
    source: &'a Source,
    scene: &'a Scene,
    console: Console,
}

impl Job<'_> {
    fn run(&self, target: &Target, progress: ProgressKind) -> Result<ExitCode, Failure> {
        let monitor = Monitor::new(progress, self.console, self.settings.time);
        self.announce(progress);
        let options = RenderOptions {
            threads: self.settings.threads,
            tile_size: self.settings.tile_size,
            aovs: self.settings.aovs.clone(),
        };
        let rendered = sahl::render::render(self.scene, &options, &monitor);
        monitor.finish();
        let picture = Picture { layers: self.layers(&rendered.film), metadata: self.metadata(&rendered) };
        let options = EncodeOptions { tone_map: target.tone_map, ..EncodeOptions::default() };
        let bytes = sahl::image::encode(&picture, target.format, &options)
            .map_err(|error| Failure::new(Reason::Render, format!("the image can't be encoded: {error}")))?;
        target.output.write(&bytes)?;
        let end = if rendered.completed {
            End::Complete
        } else if monitor.timed_out() {
            End::TimeOver
        } else {
            End::Interrupted
        };
        self.summarize(&rendered, target.output.name(), monitor.elapsed(), end, progress);
        Ok(if end == End::Interrupted { Reason::Interrupted.into() } else { ExitCode::SUCCESS })
    }

    fn layers(&self, film: &Film) -> Vec<Layer> {
        let mut layers = film.layers();
        if self.settings.variance {
            layers.push(Layer {
                name: Some(VARIANCE_LAYER.to_owned()),
                channel_names: ["R", "G", "B"].map(str::to_owned).to_vec(),
                image: film.variance(),
            });
        }
        layers
    }

    /// The event `start`.
    fn announce(&self, progress: ProgressKind) {
        if progress != ProgressKind::Json || self.console.is_quiet() {
            return;
        }
        let scene = &self.source.loaded.scene;
        let [width, height] = scene.film.resolution;
        self.console.event(&json!({
            "event": "start",
            "version": env!("CARGO_PKG_VERSION"),
            "scene": self.source.name,
            "width": width,
            "height": height,
            "crop": scene.film.crop,
            "spp": scene.sampler.samples,
            "seed": scene.sampler.seed,
            "integrator": integrator_name(&scene.integrator),
        }));
    }

    /// Facts that are the same for every render of these samples, so that equal renders give equal files.
    fn metadata(&self, rendered: &Rendered) -> Metadata {
        let scene = &self.source.loaded.scene;
        let [x0, _, y0, _] = rendered.film.crop();
        let [least, most] = rendered.film.samples();
        let partial = format!("stopped after {least} to {most} of {} samples a pixel", scene.sampler.samples);
        Metadata {
            software: Some(format!("Sahl {}", env!("CARGO_PKG_VERSION"))),
            comments: (!rendered.completed).then_some(partial),
            samples: rendered.completed.then_some(scene.sampler.samples),
            seed: Some(scene.sampler.seed),
            offset: [x0 as i32, y0 as i32],
            full_size: Some(rendered.film.resolution().map(|size| size as usize)),
            attributes: attributes(&scene.integrator, &rendered.film),
        }
    }

    /// The line at the end, or the event `done`.
    fn summarize(
        &self,
        rendered: &Rendered,
        path: &Path,
        elapsed: Duration,
        end: End,
        progress: ProgressKind,
    ) {
        let status = &rendered.status;
        if self.console.is_quiet() {
            return;
        }
        if progress == ProgressKind::Json {
            let dropped: Vec<_> = rendered
                .film
                .dropped_samples()
                .iter()
                .map(|sample| json!({ "pixel": sample.pixel, "sample": sample.index }))
                .collect();
            self.console.event(&json!({
                "event": "done",
                "end": end.name(),
                "output": path.display().to_string(),
                "seconds": elapsed.as_secs_f64(),
                "samples": status.samples_done,
                "samples_total": status.samples_total,
                "rays": status.rays,
                "dropped": rendered.film.dropped(),
                "dropped_samples": dropped,
                "peak_memory_bytes": memory::peak(),
            }));
            return;
        }
        let seconds = elapsed.as_secs_f64().max(1e-9);
        let mut line = format!(
            "{}: {}{}, {} samples ({}/s), {} rays ({}/s)",
            path.display(),
            end.prefix(),
            format::duration(elapsed),
            format::count(status.samples_done as f64),
            format::count(status.samples_done as f64 / seconds),
            format::count(status.rays as f64),
            format::count(status.rays as f64 / seconds),
        );
        if let Some(bytes) = memory::peak() {
            let _ = write!(line, ", peak memory {}", format::bytes(bytes));
        }
        self.console.line(&line);
        self.tell_dropped(&rendered.film);
    }

    /// Samples that had no colour, with where they can be replayed.
    fn tell_dropped(&self, film: &Film) {
        if film.dropped() == 0 {
            return;
        }
        let mut line = format!("{} not finite or negative, and left out:", samples_were(film.dropped()));
        for sample in film.dropped_samples() {
            let [x, y] = sample.pixel;
            let _ = write!(line, " pixel {x},{y} sample {};", sample.index);
        }
        line.push_str(" replay one with `--pixel x,y`");
        self.console.line(&line);
    }
}

/// What makes the image differ from the expectation of unbiased samples.
fn attributes(integrator: &Integrator, film: &Film) -> Vec<(String, Attribute)> {
    let mut attributes = Vec::new();
    if let Integrator::Path(PathTracer { clamp_indirect, regularize, smooth_terminator, .. }) = integrator {
        attributes.extend(clamp_indirect.map(|limit| ("clampIndirect".to_owned(), Attribute::Float(limit))));
        attributes.extend(regularize.then(|| ("regularize".to_owned(), Attribute::Int(1))));
        attributes.extend(smooth_terminator.then(|| ("smoothTerminator".to_owned(), Attribute::Int(1))));
    }
    if film.dropped() > 0 {
        // The samples that can be replayed, as column, row and number.
        let places: Vec<String> = film
            .dropped_samples()
            .iter()
            .map(|sample| format!("{},{},{}", sample.pixel[0], sample.pixel[1], sample.index))
            .collect();
        let count = i32::try_from(film.dropped()).unwrap_or(i32::MAX);
        attributes.push(("droppedSamples".to_owned(), Attribute::Int(count)));
        attributes.push(("droppedSamplePlaces".to_owned(), Attribute::Text(places.join(" "))));
    }
    attributes
}

/// How a render came to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Complete,
    TimeOver,
    Interrupted,
}

impl End {
    fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::TimeOver => "time",
            Self::Interrupted => "interrupted",
        }
    }

    fn prefix(self) -> &'static str {
        match self {
            Self::Complete => "",
            Self::TimeOver => "time over after ",
            Self::Interrupted => "interrupted after ",
        }
    }
}

fn samples_were(count: u64) -> String {
    if count == 1 { "1 sample was".to_owned() } else { format!("{count} samples were") }
}

/// Renders the samples of one pixel and prints them below a heading: number, red, green, blue, then their weighted mean, which is
/// the pixel. Samples that the film would drop are marked and left out.
fn replay(scene: &Scene, description: &SceneDesc, pixel: [u32; 2]) -> Result<ExitCode, Failure> {
    let [x, y] = pixel;
    let [width, height] = description.film.resolution;
    if x >= width || y >= height {
        return Err(Failure::usage(format!("the {width}x{height} image has no pixel {x},{y}")));
    }
    let mut text = "sample\tred\tgreen\tblue\n".to_owned();
    let (mut sum, mut weights) = ([0.0_f64; 3], 0.0_f64);
    for index in 0..scene.samples_per_pixel() {
        let sample = scene.sample(pixel, index);
        let [r, g, b] = sample.rgb;
        let is_kept = sample.is_kept;
        let _ = writeln!(text, "{index}\t{r}\t{g}\t{b}{}", if is_kept { "" } else { "\tdropped" });
        if is_kept {
            for (sum, value) in sum.iter_mut().zip(sample.rgb) {
                *sum += f64::from(value) * f64::from(sample.weight);
            }
            weights += f64::from(sample.weight);
        }
    }
    let [r, g, b] = sum.map(|sum| if weights == 0.0 { 0.0 } else { (sum / weights) as f32 });
    let _ = writeln!(text, "mean\t{r}\t{g}\t{b}");
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn integrator_name(integrator: &Integrator) -> &'static str {
    match integrator {
        Integrator::Path(_) => "path",
        Integrator::Whitted { .. } => "whitted",
        Integrator::Ao { .. } => "ao",
        Integrator::Normals => "normals",
    }
}
