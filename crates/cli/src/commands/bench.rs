//! `sahl bench`: how fast a scene is.

use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use sahl::render::{BuildOptions, RenderOptions, Scene};
use sahl::scene::{Integrator, PathTracer, SceneDesc};
use serde_json::json;

use crate::args::{BenchArgs, BenchKind, ColorMode, Resolution, SpeedArgs};
use crate::commands::{bench_bvh, print};
use crate::console::Console;
use crate::failure::{Failure, Reason};
use crate::format;
use crate::memory;
use crate::source::Source;

/// Measures what is asked for.
pub(crate) fn run(args: &BenchArgs, console: Console) -> Result<ExitCode, Failure> {
    match &args.kind {
        Some(BenchKind::Bvh(args)) => bench_bvh::run(args, console),
        None => speed(&args.speed, console),
    }
}

/// One render.
struct Run {
    threads: usize,
    time: Duration,
    samples: u64,
    rays: u64,
}

/// Times loading, building, and rendering on one thread and on all.
fn speed(args: &SpeedArgs, console: Console) -> Result<ExitCode, Failure> {
    let (source, load_time) = timed(|| Source::load(&args.scenes));
    let mut source = source?;
    source.report(args.messages.strict, &console)?;
    edit(&mut source.loaded.scene, args)?;
    let (scene, build_time) =
        timed(|| source.build(&BuildOptions::default(), args.messages.strict, &console));
    let scene = scene?;
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let counts = if all > 1 { vec![1, all] } else { vec![1] };
    let runs: Vec<_> = counts.into_iter().map(|threads| measure(&scene, threads)).collect();
    if args.json {
        print(&format!("{:#}\n", json(&source, load_time, build_time, &runs)))?;
    } else {
        print(&text(&source, load_time, build_time, &runs))?;
    }
    Ok(ExitCode::SUCCESS)
}

pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed())
}

fn edit(scene: &mut SceneDesc, args: &SpeedArgs) -> Result<(), Failure> {
    scene.sampler.samples = args.spp;
    scene.color = args.color.map_or(scene.color, ColorMode::mode);
    resize(scene, args.resolution);
    match (args.max_depth, &mut scene.integrator) {
        (None, _) => Ok(()),
        (Some(depth), Integrator::Path(PathTracer { max_depth, .. }) | Integrator::Whitted { max_depth }) => {
            *max_depth = depth;
            Ok(())
        }
        (Some(_), _) => {
            Err(Failure::new(Reason::Usage, "`--max-depth` has no meaning for the scene's integrator"))
        }
    }
}

/// Sets the size of the image, all of which is rendered then.
pub(crate) fn resize(scene: &mut SceneDesc, resolution: Option<Resolution>) {
    if let Some(Resolution(size)) = resolution {
        scene.film.resolution = size;
        scene.film.crop = None;
    }
}

fn measure(scene: &Scene, threads: usize) -> Run {
    let options = RenderOptions { threads, ..RenderOptions::default() };
    let (rendered, time) = timed(|| sahl::render::render(scene, &options, &()));
    Run { threads, time, samples: rendered.status.samples_done, rays: rendered.status.rays }
}

impl Run {
    fn samples_per_second(&self) -> f64 {
        self.samples as f64 / self.time.as_secs_f64().max(1e-9)
    }

    fn rays_per_second(&self) -> f64 {
        self.rays as f64 / self.time.as_secs_f64().max(1e-9)
    }
}

fn text(source: &Source, load: Duration, build: Duration, runs: &[Run]) -> String {
    let [width, height] = source.loaded.scene.film.resolution;
    let spp = source.loaded.scene.sampler.samples;
    let mut text = format!("{}, {width}x{height}, {spp} samples a pixel\n", source.name);
    let _ = writeln!(text, "load   {:9.4} s\nbuild  {:9.4} s", load.as_secs_f64(), build.as_secs_f64());
    let _ = writeln!(text, "\nthreads    render s   samples/s      rays/s   s per million samples");
    for run in runs {
        let _ = writeln!(
            text,
            "{:7}  {:10.3}  {:>10}  {:>10}  {:22.3}",
            run.threads,
            run.time.as_secs_f64(),
            format::count(run.samples_per_second()),
            format::count(run.rays_per_second()),
            1e6 / run.samples_per_second()
        );
    }
    if let [one, all] = runs {
        let ratio = one.time.as_secs_f64() / all.time.as_secs_f64().max(1e-9);
        let _ = writeln!(text, "\n{} threads are {ratio:.2} times as fast as one", all.threads);
    }
    if let Some(bytes) = memory::peak() {
        let _ = writeln!(text, "peak memory {}", format::bytes(bytes));
    }
    text
}

fn json(source: &Source, load: Duration, build: Duration, runs: &[Run]) -> serde_json::Value {
    let runs: Vec<_> = runs
        .iter()
        .map(|run| {
            json!({
                "threads": run.threads,
                "seconds": run.time.as_secs_f64(),
                "samples": run.samples,
                "rays": run.rays,
                "samples_per_second": run.samples_per_second(),
                "rays_per_second": run.rays_per_second(),
            })
        })
        .collect();
    json!({
        "scene": source.name,
        "resolution": source.loaded.scene.film.resolution,
        "spp": source.loaded.scene.sampler.samples,
        "load_seconds": load.as_secs_f64(),
        "build_seconds": build.as_secs_f64(),
        "runs": runs,
        "peak_memory_bytes": memory::peak(),
    })
}
