//! The comparison with Embree, from the arguments to the last line.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "the tables are the result")]

use std::path::Path;
use std::sync::Arc;
use std::thread;

use rayon::{ThreadPool, ThreadPoolBuilder};
use sahl_accel::{Accel, BuildOptions, Builder, Tier, TriangleMesh};
use sahl_math::Ray;

use super::lost::{self, Tracer};
use super::models::{self, Body, Entry, MODELS, Model};
use super::rays::Rays;
use super::summary::Summary;
use super::table::{Table, figure, grouped};
use super::timing::free_share;
use super::traversal::{Bench, NEAREST, OCCLUSION, Outcome, Rival, Side};
use super::{builds, check, world};
use crate::Result;
use crate::args::{AccelArgs, Measurement, Peer};
use crate::embree::{self, Draft, Embree, INVALID, Isa, Quality, RayHit, Scene, Settings};

/// Compares `sahl-accel` with Embree and prints tables.
///
/// # Errors
/// Embree can't be had, a model can't be read, or one is asked for that does not exist.
pub(crate) fn run(args: &AccelArgs) -> Result<()> {
    let models = chosen(args)?;
    let threads = match args.threads {
        Some(threads) => threads.get(),
        None => thread::available_parallelism()?.get(),
    };
    let mut comparison = Comparison { args, embree: Embree::open()?, threads, summary: Summary::default() };
    println!("{}", check::check(&comparison.embree)?);
    println!("medians of {} alternating runs; {threads} threads where several are measured", args.runs);
    for entry in models {
        eprintln!("{}: loading", entry.name);
        let model = entry.load(args.scenes.as_deref().unwrap_or(Path::new("")))?;
        comparison.model(&model)?;
    }
    if args.measures(Measurement::Lost) {
        comparison.lost()?;
    }
    println!("\n{}", comparison.summary);
    Ok(())
}

/// The models that were asked for and can be had.
fn chosen(args: &AccelArgs) -> Result<Vec<&'static Entry>> {
    if let Some(unknown) = args.models.iter().find(|name| MODELS.iter().all(|entry| entry.name != **name)) {
        let names: Vec<&str> = MODELS.iter().map(|entry| entry.name).collect();
        return Err(format!("no model `{unknown}`; there are: {}", names.join(", ")).into());
    }
    let asked = |entry: &&Entry| match args.models.as_slice() {
        [] => !args.quick || entry.quick,
        names => names.iter().any(|name| name == entry.name),
    };
    let (there, missing): (Vec<&Entry>, Vec<&Entry>) =
        MODELS.iter().filter(asked).partition(|entry| !entry.needs_file() || args.scenes.is_some());
    if !missing.is_empty() {
        let names: Vec<&str> = missing.iter().map(|entry| entry.name).collect();
        println!("without {}, for want of --scenes DIR (or SAHL_SCENES)", names.join(", "));
    }
    Ok(there)
}

/// What is compared, and what has come out so far.
struct Comparison<'a> {
    args: &'a AccelArgs,
    embree: Embree,
    threads: usize,
    summary: Summary,
}

impl Comparison<'_> {
    fn model(&mut self, model: &Model) -> Result<()> {
        println!("\n{}: {} triangles", model.name, grouped(model.mesh.indices.len() as u64));
        let mut table = Table::new("build");
        // First, while no other device of Embree's exists.
        if self.args.measures(Measurement::Build) {
            self.build(model, &mut table)?;
        }
        eprintln!("{}: building", model.name);
        let options = BuildOptions { tier: self.args.tier()?, ..BuildOptions::default() };
        let accel = Accel::build(world(&model.mesh), &options);
        if self.args.measures(Measurement::Memory) {
            self.memory(model, &accel, &mut table)?;
        }
        if !table.is_empty() {
            println!("{table}\n");
        }
        let traversal =
            [Measurement::Primary, Measurement::Bounce, Measurement::Occlusion, Measurement::Threads];
        if traversal.iter().any(|&what| self.args.measures(what)) {
            let high = BuildOptions { builder: Builder::HighQuality, ..options };
            self.traversal(model, &accel, &Accel::build(world(&model.mesh), &high))?;
        }
        Ok(())
    }

    /// Tells if other programs use the machine, which spoils what is measured on the wall.
    fn warn_if_busy(&self) {
        let share = free_share(self.threads);
        if share < 0.9 {
            println!(
                "the machine is busy: {} threads get {:.0} % of as many processors; times of several threads mean little",
                self.threads,
                100.0 * share
            );
        }
    }

    fn build(&mut self, model: &Model, table: &mut Table) -> Result<()> {
        self.warn_if_busy();
        let mut counts = vec![1];
        counts.extend((self.threads > 1).then_some(self.threads));
        for threads in counts {
            eprintln!("{}: building on {threads} threads", model.name);
            let times = builds::seconds(&self.embree, &model.mesh, threads, self.args.runs.get())?;
            let column =
                if threads == 1 { "s, 1 thread".to_owned() } else { format!("s, {threads} threads") };
            for time in &times {
                table.set(time.name, &column, figure(time.seconds));
            }
            if let Some(ratios) = builds::ratios(&times) {
                for (row, ratio) in &ratios {
                    table.set(row, &column, figure(*ratio));
                }
                self.summary.ratios.push((Measurement::Build, model.name, ratios[0].1));
            }
        }
        Ok(())
    }

    fn memory(&mut self, model: &Model, accel: &Accel, table: &mut Table) -> Result<()> {
        let theirs = builds::embree_bytes(&self.embree, &model.mesh, self.threads)?;
        let (ours, theirs) = (accel.stats().bytes as f64, theirs as f64);
        for (row, value) in [
            ("Sahl default", ours * 1e-6),
            ("Embree medium", theirs * 1e-6),
            ("Sahl default / Embree medium", ours / theirs),
        ] {
            table.set(row, "MB", figure(value));
        }
        self.summary.ratios.push((Measurement::Memory, model.name, ours / theirs));
        Ok(())
    }

    fn traversal(&mut self, model: &Model, accel: &Accel, high: &Accel) -> Result<()> {
        let rivals = self.rivals(&model.mesh)?;
        let counted = &rivals[..rivals.iter().filter(|rival| !rival.informative).count()];
        let rays = Rays::new(model, accel, if self.args.quick { 512 } else { 1024 });
        let rounds = self.args.runs.get();
        let bench = Bench { accel, high, rivals: counted, rounds };
        let with_robust = Bench { rivals: &rivals, ..bench };
        let pool = pool(self.threads)?;
        let mut table = Table::new("Mrays/s");
        let workloads: [(Measurement, &str, usize, &dyn Fn() -> Outcome); 4] = [
            (Measurement::Primary, "primary", rays.primary.len(), &|| bench.nearest(&rays.primary, true)),
            (Measurement::Bounce, "bounce", rays.bounce.len(), &|| with_robust.nearest(&rays.bounce, false)),
            (Measurement::Occlusion, "occlusion", rays.occlusion.len(), &|| bench.occlusion(&rays.occlusion)),
            (Measurement::Threads, "threads", rays.bounce.len(), &|| bench.threads(&rays.bounce, &pool)),
        ];
        let mut notes = String::new();
        self.warn_if_busy();
        for (what, column, count, measure) in workloads {
            if !self.args.measures(what) {
                continue;
            }
            eprintln!("{}: {column}, {} rays", model.name, grouped(count as u64));
            let outcome = measure();
            notes += &note(column, count, &outcome);
            for rate in &outcome.rates {
                table.set(&rate.name, column, figure(rate.rate * 1e-6));
            }
            if let Some(ratio) = outcome.ratio() {
                table.set("Sahl / Embree", column, figure(ratio));
                self.summary.ratios.push((what, model.name, ratio));
            }
        }
        println!("{table}{notes}");
        if self.args.measures(Measurement::Threads) && self.threads > 1 {
            self.scaling(&bench, &rays.bounce)?;
        }
        Ok(())
    }

    fn scaling(&mut self, bench: &Bench<'_>, rays: &[Ray]) -> Result<()> {
        let scaling = bench.scaling(rays, [&pool(1)?, &pool(2)?]);
        println!("two threads / one: {scaling:.2}");
        self.summary.scaling.push(scaling);
        Ok(())
    }

    /// Embree's trees over the mesh in every configuration that was asked for and that the processor has; those for information come
    /// last.
    fn rivals(&self, mesh: &TriangleMesh) -> Result<Vec<Rival>> {
        let mut rivals = Vec::new();
        for (peer, name, isa, quality) in [
            (Some(Peer::Avx2Medium), "avx2 medium", Isa::Avx2, Quality::Medium),
            (Some(Peer::Avx2High), "avx2 high", Isa::Avx2, Quality::High),
            (Some(Peer::Avx512Medium), "avx512 medium", Isa::Avx512, Quality::Medium),
            (Some(Peer::Avx512High), "avx512 high", Isa::Avx512, Quality::High),
            (None, "avx2 robust", Isa::Avx2, Quality::Medium),
            (None, "avx512 robust", Isa::Avx512, Quality::Medium),
        ] {
            let wanted = match peer {
                Some(peer) => self.args.peers.is_empty() || self.args.peers.contains(&peer),
                None => !self.args.quick && self.args.peers.is_empty(),
            };
            if !wanted {
                continue;
            }
            let informative = peer.is_none();
            if let Some(scene) = self.scene(mesh, isa, quality, informative)? {
                rivals.push(Rival { name: name.to_owned(), scene, informative });
            }
        }
        Ok(rivals)
    }

    /// Embree's tree over the mesh; `None` if the processor lacks the instructions.
    fn scene(&self, mesh: &TriangleMesh, isa: Isa, quality: Quality, robust: bool) -> Result<Option<Scene>> {
        let settings = Settings { isa, threads: self.threads, counts_memory: false };
        let Some(device) = self.embree.device(settings)? else { return Ok(None) };
        Draft::new(&Arc::new(device), mesh, quality, robust)?.commit().map(Some)
    }

    /// Shoots at the vertices and edges of closed bodies.
    fn lost(&mut self) -> Result<()> {
        let total = if self.args.quick { 1_000_000 } else { 10_000_000 };
        let bodies = models::bodies(self.args.scenes.as_deref())?;
        let tiers: Vec<Tier> = Tier::ALL.into_iter().filter(|tier| tier.is_available()).collect();
        let mut table = Table::new("rays lost");
        for body in &bodies {
            eprintln!("lost rays: {}", body.name);
            let (shot, lost) = self.lost_of(body, total / bodies.len() as u64, &tiers)?;
            table.set("shot at vertices and edges", body.name, grouped(shot));
            for (name, lost) in lost {
                table.set(&name, body.name, grouped(lost));
                if name.starts_with("Sahl") {
                    self.summary.lost = Some(self.summary.lost.unwrap_or(0) + lost);
                }
            }
        }
        println!("\n{table}");
        Ok(())
    }

    /// How many rays were shot at one body, and who lost how many.
    fn lost_of(&self, body: &Body, count: u64, tiers: &[Tier]) -> Result<(u64, Vec<(String, u64)>)> {
        let mesh = body.mesh();
        let mut names = Vec::new();
        let mut accels = Vec::new();
        for &tier in tiers {
            names.push(format!("Sahl {tier:?}"));
            accels.push(Accel::build(
                world(&mesh),
                &BuildOptions { tier: Some(tier), ..BuildOptions::default() },
            ));
        }
        let mut scenes = Vec::new();
        if !self.args.quick {
            for (name, robust) in [("Embree avx2 fast", false), ("Embree avx2 robust", true)] {
                scenes.extend(self.scene(&mesh, Isa::Avx2, Quality::Medium, robust)?);
                names.push(name.to_owned());
            }
        }
        let ours = accels.iter().map(|accel| Box::new(|rays: &[Ray]| sahl_lost(accel, rays)) as Tracer<'_>);
        let theirs =
            scenes.iter().map(|scene| Box::new(|rays: &[Ray]| embree_lost(scene, rays)) as Tracer<'_>);
        let tracers: Vec<Tracer<'_>> = ours.chain(theirs).collect();
        let (shot, lost) = lost::shoot(body, count, self.threads, &tracers);
        Ok((shot, names.into_iter().zip(lost).collect()))
    }
}

fn pool(threads: usize) -> Result<ThreadPool> {
    Ok(ThreadPoolBuilder::new().num_threads(threads).build()?)
}

/// Rays of which one of Sahl's queries says that they hit nothing. Queries for rays that are alike are asked for a part of them, since
/// these are not.
fn sahl_lost(accel: &Accel, rays: &[Ray]) -> u64 {
    let mut lost = vec![false; rays.len()];
    for query in NEAREST {
        let part = if query.coherent { rays.len() / 16 } else { rays.len() };
        let mut hits = vec![None; part];
        (query.run)(accel, &rays[..part], &mut hits);
        lost.iter_mut().zip(&hits).for_each(|(lost, hit)| *lost |= hit.is_none());
    }
    let mut occluded = vec![false; rays.len()];
    for query in OCCLUSION {
        (query.run)(accel, rays, &mut occluded);
        lost.iter_mut().zip(&occluded).for_each(|(lost, occluded)| *lost |= !occluded);
    }
    lost.into_iter().filter(|&lost| lost).count() as u64
}

fn embree_lost(scene: &Scene, rays: &[Ray]) -> u64 {
    let mut singles: Vec<RayHit> = rays.iter().map(RayHit::new).collect();
    embree::intersect(scene, &mut singles);
    singles.iter().filter(|single| single.hit.geometry == INVALID).count() as u64
}

/// Which query of Sahl's was the fastest, and how far the answers agree.
fn note(workload: &str, rays: usize, outcome: &Outcome) -> String {
    let fastest = outcome.best(Side::Sahl).map_or("-", |rate| rate.name.as_str());
    let mut note = format!("\n{workload}: {} rays, fastest {fastest}", grouped(rays as u64));
    if outcome.differing > 0 {
        note += &format!("; {} answers differ from Embree's", outcome.differing);
    }
    if outcome.inconsistent > 0 {
        note += &format!("; WRONG: {} answers differ between Sahl's own queries", outcome.inconsistent);
    }
    note
}
