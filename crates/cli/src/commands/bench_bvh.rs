//! `sahl bench bvh`: how good the trees of the two builders are.
//!
//! Traces one ray through the centre of each pixel, and from where it hits, one ray in a cosine-weighted direction: the
//! first are coherent and mostly seen by the camera, the second go everywhere, as most rays of a path do.

use std::f32::consts::TAU;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use sahl::image::{EncodeOptions, Format, Image, false_color};
use sahl::math::{Frame, Ray, Vec2, Vec3};
use sahl::render::accel::{Accel, Builder, Stats, TraversalCount};
use sahl::render::{BuildOptions, Scene};
use serde_json::json;

use crate::args::BvhArgs;
use crate::commands::bench::{resize, timed};
use crate::commands::print;
use crate::console::Console;
use crate::failure::{Failure, Reason};
use crate::format;
use crate::output::Output;
use crate::settings::build_with;
use crate::source::Source;

/// Times are the best of this many runs, against the noise of a busy machine.
const RUNS: usize = 3;

/// One builder's tree and how rays fare in it.
struct Tree {
    name: &'static str,
    stats: Stats,
    build: Duration,
    camera: Batch,
    bounce: Batch,
    /// Steps of the camera's ray, a pixel.
    steps: Vec<f32>,
}

/// Rays of one kind.
struct Batch {
    rays: usize,
    nodes: u64,
    primitives: u64,
    time: Duration,
}

impl Batch {
    fn steps_per_ray(&self) -> f64 {
        (self.nodes + self.primitives) as f64 / self.rays.max(1) as f64
    }

    fn rays_per_second(&self) -> f64 {
        self.rays as f64 / self.time.as_secs_f64().max(1e-9)
    }
}

/// Builds, traces, prints and draws.
pub(crate) fn run(args: &BvhArgs, console: Console) -> Result<ExitCode, Failure> {
    let mut source = Source::load(&args.scenes)?;
    source.report(args.messages.strict, &console)?;
    resize(&mut source.loaded.scene, args.resolution);
    source.build(&BuildOptions::default(), args.messages.strict, &console)?;
    let prefix = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}-steps", source.stem)));
    let outputs = [heat_map_of(&prefix, "median")?, heat_map_of(&prefix, "sah")?];

    let builders = [("median", Builder::Median), ("sah", Builder::BinnedSah)];
    let mut trees = Vec::new();
    for (name, builder) in builders {
        let (scene, time) = build(&source, builder)?;
        trees.push(measure(name, &scene, time, &pixels(&source)));
    }
    let brightest = trees.iter().flat_map(|tree| &tree.steps).fold(0.0_f32, |most, &steps| most.max(steps));
    for (tree, output) in trees.iter().zip(&outputs) {
        draw(&tree.steps, extent(&source), brightest, output)?;
    }
    let paths = outputs.map(|output| output.name().display().to_string());
    if args.json {
        print(&format!("{:#}\n", json(&source, &trees, &paths, brightest)))?;
    } else {
        print(&text(&source, &trees, &paths, brightest))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn heat_map_of(prefix: &std::path::Path, tree: &str) -> Result<Output, Failure> {
    let mut name = prefix.file_name().unwrap_or_default().to_os_string();
    name.push(format!("-{tree}.png"));
    Output::check(&prefix.with_file_name(name))
}

/// The scene, and the time of the fastest of several builds.
fn build(source: &Source, builder: Builder) -> Result<(Scene, Duration), Failure> {
    let options = build_with(builder);
    let mut best = Duration::MAX;
    let mut built = None;
    for _ in 0..RUNS {
        let ((scene, _), time) = timed(|| sahl::render::build(&source.loaded.scene, &options));
        best = best.min(time);
        built = scene;
    }
    let failed = || Failure::new(Reason::Scene, format!("`{}` can't be built", source.name));
    Ok((built.ok_or_else(failed)?, best))
}

/// The pixels of the image, row by row.
fn pixels(source: &Source) -> Vec<[u32; 2]> {
    let [x0, x1, y0, y1] = bounds(source);
    (y0..y1).flat_map(|y| (x0..x1).map(move |x| [x, y])).collect()
}

fn bounds(source: &Source) -> [u32; 4] {
    let film = &source.loaded.scene.film;
    film.crop.unwrap_or([0, film.resolution[0], 0, film.resolution[1]])
}

fn extent(source: &Source) -> [usize; 2] {
    let [x0, x1, y0, y1] = bounds(source);
    [(x1 - x0) as usize, (y1 - y0) as usize]
}

fn measure(name: &'static str, scene: &Scene, build: Duration, pixels: &[[u32; 2]]) -> Tree {
    let accel = scene.accel();
    let centre = |[x, y]: [u32; 2]| Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
    let camera: Vec<Ray> = pixels.iter().map(|&pixel| scene.camera_ray(centre(pixel))).collect();
    let bounce: Vec<Ray> =
        camera.iter().enumerate().filter_map(|(index, ray)| bounced(accel, ray, index as u32)).collect();
    let (camera, steps) = trace(accel, &camera);
    let (bounce, _) = trace(accel, &bounce);
    Tree { name, stats: accel.stats(), build, camera, bounce, steps }
}

/// A ray from where `ray` hits into a direction that depends on `index` alone, so that both trees get the same rays.
fn bounced(accel: &Accel, ray: &Ray, index: u32) -> Option<Ray> {
    let hit = accel.intersect(ray)?;
    let point = accel.surface_point(ray, &hit);
    let normal = point.n.face_forward(-ray.direction);
    // Points of a lattice by the golden ratio and its square's companion (Roberts 2018, the sequence R2).
    let u = (0.5 + 0.754_877_67 * f64::from(index)).fract() as f32;
    let v = (0.5 + 0.569_840_3 * f64::from(index)).fract() as f32;
    let (sine, cosine) = (TAU * v).sin_cos();
    let radius = u.sqrt();
    let local = Vec3::new(radius * cosine, radius * sine, (1.0 - u).max(0.0).sqrt());
    let direction = Frame::from_z(normal).to_world(local);
    Some(Ray::spawn(point.p, point.p_error, normal, direction))
}

/// Counts steps, then times the same rays without counting.
fn trace(accel: &Accel, rays: &[Ray]) -> (Batch, Vec<f32>) {
    let mut total = TraversalCount::default();
    let mut steps = Vec::with_capacity(rays.len());
    for ray in rays {
        let mut count = TraversalCount::default();
        accel.intersect_counted(ray, &mut count);
        steps.push((count.nodes + count.primitives) as f32);
        total.nodes += count.nodes;
        total.primitives += count.primitives;
    }
    let time = (0..RUNS)
        .map(|_| {
            let (hits, time) = timed(|| rays.iter().filter(|ray| accel.intersect(ray).is_some()).count());
            std::hint::black_box(hits);
            time
        })
        .min()
        .unwrap_or_default();
    (Batch { rays: rays.len(), nodes: total.nodes, primitives: total.primitives, time }, steps)
}

/// Writes one tree's steps in false colours; `brightest` steps are the top of the scale.
fn draw(steps: &[f32], [width, height]: [usize; 2], brightest: f32, output: &Output) -> Result<(), Failure> {
    let bytes = Image::y_f32(width, height, steps.to_vec())
        .map(|image| false_color::colorize(&image, 0.0, brightest))
        .and_then(|image| image.encode(Format::Png, &EncodeOptions::default()))
        .map_err(|error| Failure::new(Reason::Render, format!("the heat map can't be encoded: {error}")))?;
    output.write(&bytes)
}

fn text(source: &Source, trees: &[Tree], paths: &[String], brightest: f32) -> String {
    let [width, height] = extent(source);
    let mut text = format!("{}, {width}x{height} camera rays\n\n{:24}", source.name, "tree");
    for tree in trees {
        let _ = write!(text, "{:>12}", tree.name);
    }
    text.push('\n');
    let mut row = |label: &str, value: &dyn Fn(&Tree) -> String| {
        let _ = write!(text, "{label:24}");
        for tree in trees {
            let _ = write!(text, "{:>12}", value(tree));
        }
        text.push('\n');
    };
    row("build s", &|tree| format!("{:.4}", tree.build.as_secs_f64()));
    row("nodes", &|tree| tree.stats.nodes.to_string());
    row("leaves", &|tree| tree.stats.leaves.to_string());
    row("depth", &|tree| tree.stats.depth.to_string());
    row("SAH cost", &|tree| format!("{:.1}", tree.stats.sah_cost));
    row("memory", &|tree| format::bytes(tree.stats.bytes));
    for (kind, batch) in [("camera", camera as fn(&Tree) -> &Batch), ("bounce", bounce)] {
        row(&format!("{kind}: rays"), &|tree| batch(tree).rays.to_string());
        row(&format!("{kind}: nodes a ray"), &|tree| per_ray(batch(tree).nodes, batch(tree)));
        row(&format!("{kind}: primitives a ray"), &|tree| per_ray(batch(tree).primitives, batch(tree)));
        row(&format!("{kind}: steps a ray"), &|tree| format!("{:.2}", batch(tree).steps_per_ray()));
        row(&format!("{kind}: trace s"), &|tree| format!("{:.4}", batch(tree).time.as_secs_f64()));
        row(&format!("{kind}: rays/s"), &|tree| format::count(batch(tree).rays_per_second()));
    }
    text.push_str(&ratios(trees));
    let _ = writeln!(text, "\nheat maps, up to {brightest} steps: {}", paths.join(", "));
    text
}

/// How much more the first tree takes than the second.
fn ratios(trees: &[Tree]) -> String {
    let mut text = "\n".to_owned();
    if let [median, sah] = trees {
        for (kind, batch) in [("camera", camera as fn(&Tree) -> &Batch), ("bounce", bounce)] {
            let steps = batch(median).steps_per_ray() / batch(sah).steps_per_ray().max(1e-9);
            let time = batch(median).time.as_secs_f64() / batch(sah).time.as_secs_f64().max(1e-9);
            let _ = writeln!(
                text,
                "{kind} rays: median takes {steps:.2} times the steps and {time:.2} times the time of SAH"
            );
        }
    }
    text
}

fn camera(tree: &Tree) -> &Batch {
    &tree.camera
}

fn bounce(tree: &Tree) -> &Batch {
    &tree.bounce
}

fn per_ray(count: u64, batch: &Batch) -> String {
    format!("{:.2}", count as f64 / batch.rays.max(1) as f64)
}

fn json(source: &Source, trees: &[Tree], paths: &[String], brightest: f32) -> serde_json::Value {
    let batch = |batch: &Batch| {
        json!({
            "rays": batch.rays,
            "nodes": batch.nodes,
            "primitives": batch.primitives,
            "steps_per_ray": batch.steps_per_ray(),
            "seconds": batch.time.as_secs_f64(),
            "rays_per_second": batch.rays_per_second(),
        })
    };
    let trees: Vec<_> = trees
        .iter()
        .zip(paths)
        .map(|(tree, path)| {
            json!({
                "builder": tree.name,
                "build_seconds": tree.build.as_secs_f64(),
                "nodes": tree.stats.nodes,
                "leaves": tree.stats.leaves,
                "depth": tree.stats.depth,
                "sah_cost": tree.stats.sah_cost,
                "bytes": tree.stats.bytes,
                "camera": batch(&tree.camera),
                "bounce": batch(&tree.bounce),
                "heat_map": path,
            })
        })
        .collect();
    json!({ "scene": source.name, "resolution": extent(source), "heat_map_top": brightest, "trees": trees })
}
