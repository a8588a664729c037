//! The render loop: passes, tiles, pixels, samples, over all cores.
//!
//! Design decision: passes take 1, 1, 2, 4, 8, 16, 16, … samples a pixel, so that a first image is there at once and the
//! whole image improves evenly. A tile belongs to one thread during a pass, and a sample depends on its pixel and number
//! alone: the image is the same to the last bit for every number of threads and every tile size.
//!
//! Deliberately absent: clocks. Who wants rates measures time in its [`Progress`].

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::film::{Film, Tile};
use crate::integrator::Pass;
use crate::scene::SceneData;
use crate::{Aov, Scene};

/// The most samples that one pass takes for a pixel.
const MAX_SAMPLES_PER_PASS: u32 = 16;

/// More threads than this are not started, whatever is asked for.
const MOST_THREADS: usize = 1024;

/// Settings of [`render`] that do not change the image.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// How many threads render; zero for one a core. There are never more than tiles, nor more than 1024.
    pub threads: usize,
    /// Width and height of a tile in pixels.
    pub tile_size: u32,
    /// Features of the first surface to record beside the image. Each is recorded once.
    pub aovs: Vec<Aov>,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { threads: 0, tile_size: 16, aovs: Vec::new() }
    }
}

/// How far a render has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Camera samples taken, over all pixels.
    pub samples_done: u64,
    /// Camera samples of a complete render.
    pub samples_total: u64,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// The number of the current pass, from zero; of the last one at the end.
    pub pass: u32,
    /// Samples left out because their colour was NaN, infinite or negative.
    pub dropped: u64,
}

/// Who is told how a render gets on, and may end it.
pub trait Progress: Sync {
    /// A tile is done; called by the thread that did it, at any time and by several threads at once.
    ///
    /// [`ControlFlow::Break`] ends the render once the tiles that other threads work on are done.
    fn tile_done(&self, _status: &Status) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// A pass is done: every pixel of `film` has the same number of samples. Called between passes.
    fn pass_done(&self, _status: &Status, _film: &Film) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// The progress of nobody who cares.
impl Progress for () {}

/// What a render came to.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The image in sums: valid in any case; pixels that were not reached are black.
    pub film: Film,
    /// Whether every sample was taken.
    pub completed: bool,
    /// The final figures.
    pub status: Status,
}

/// Renders `scene`, and tells `progress` of every tile and pass.
///
/// The image is a function of the scene alone: `options` change neither a bit of it nor of its features.
pub fn render(scene: &Scene, options: &RenderOptions, progress: &dyn Progress) -> Rendered {
    let scene = &*scene.data;
    let mut film = Film::new(&scene.film, &without_repetition(&options.aovs), options.tile_size);
    let run = Run {
        scene,
        progress,
        pixels: film.pixel_count(),
        samples_done: AtomicU64::new(0),
        rays: AtomicU64::new(0),
        dropped: AtomicU64::new(0),
        stopped: AtomicBool::new(false),
    };
    let workers = Workers::new(options.threads.min(film.tiles_mut().len()).min(MOST_THREADS));
    let mut status = run.status(0);
    let mut number = 0;
    let mut first = 0;
    while first < scene.samples && !run.stopped.load(Ordering::Relaxed) {
        let count = first.clamp(1, MAX_SAMPLES_PER_PASS).min(scene.samples - first);
        let pass = Pass { number, samples: first..first + count };
        run.pass(&workers, &mut film, &pass);
        status = run.status(number);
        let complete = status.samples_done == run.pixels * u64::from(first + count);
        if complete && progress.pass_done(&status, &film).is_break() {
            break;
        }
        first += count;
        number += 1;
    }
    Rendered { film, completed: status.samples_done == status.samples_total, status }
}

fn without_repetition(aovs: &[Aov]) -> Vec<Aov> {
    let mut unique: Vec<Aov> = Vec::new();
    for &aov in aovs {
        if !unique.contains(&aov) {
            unique.push(aov);
        }
    }
    unique
}

/// One render, as all threads see it.
struct Run<'a> {
    scene: &'a SceneData,
    progress: &'a dyn Progress,
    pixels: u64,
    samples_done: AtomicU64,
    rays: AtomicU64,
    dropped: AtomicU64,
    stopped: AtomicBool,
}

impl Run<'_> {
    fn status(&self, pass: u32) -> Status {
        Status {
            samples_done: self.samples_done.load(Ordering::Relaxed),
            samples_total: self.pixels * u64::from(self.scene.samples),
            rays: self.rays.load(Ordering::Relaxed),
            pass,
            dropped: self.dropped.load(Ordering::Relaxed),
        }
    }

    /// Adds the samples of `pass` to every tile, unless somebody ends the render.
    fn pass(&self, workers: &Workers, film: &mut Film, pass: &Pass) {
        let aovs = film.aovs().to_vec();
        let work = |tile: &mut Tile| {
            if !self.stopped.load(Ordering::Relaxed) {
                self.tile(tile, &aovs, pass);
            }
        };
        match workers {
            Workers::Pool(pool) => {
                pool.install(|| film.tiles_mut().par_iter_mut().with_max_len(1).for_each(work));
            }
            Workers::Caller => film.tiles_mut().iter_mut().for_each(work),
        }
    }

    fn tile(&self, tile: &mut Tile, aovs: &[Aov], pass: &Pass) {
        let dropped_before = tile.dropped();
        let rays = self.scene.integrator.render_tile(self.scene, aovs, tile, pass);
        let samples = tile.pixel_count() * pass.samples.len() as u64;
        self.samples_done.fetch_add(samples, Ordering::Relaxed);
        self.rays.fetch_add(rays, Ordering::Relaxed);
        self.dropped.fetch_add(tile.dropped() - dropped_before, Ordering::Relaxed);
        if self.progress.tile_done(&self.status(pass.number)).is_break() {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }
}

/// The threads that render.
enum Workers {
    Pool(ThreadPool),
    /// The thread that asked for the image.
    Caller,
}

impl Workers {
    /// `threads` of them, or one a core if zero. Where the system refuses to start threads, the caller does the work.
    fn new(threads: usize) -> Self {
        if threads == 1 {
            return Self::Caller;
        }
        let pool =
            ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("render {i}")).build();
        pool.map_or(Self::Caller, Self::Pool)
    }
}
