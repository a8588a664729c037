//! Seconds to build, and the size of what was built.

use std::sync::Arc;

use rayon::ThreadPoolBuilder;
use sahl_accel::{Accel, BuildOptions, Builder, TriangleMesh};

use super::timing::{alternate, thread_seconds, wall_seconds};
use super::world;
use crate::Result;
use crate::embree::{Device, Draft, Embree, Isa, Quality, Settings};

/// Sahl's ways to build. The first is what the summary compares.
fn presets() -> [(&'static str, BuildOptions); 2] {
    let with = |builder| BuildOptions { builder, ..BuildOptions::default() };
    [("Sahl default", BuildOptions::default()), ("Sahl fast", with(Builder::Fast))]
}

/// Seconds of one contender.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BuildTime {
    pub(crate) name: &'static str,
    pub(crate) seconds: f64,
}

/// What was built with on how many threads.
#[derive(Clone, Copy, Debug)]
enum Contender {
    Sahl(usize),
    Embree,
}

/// Seconds on `threads` threads: Sahl's presets, Embree at medium quality (medians) and at high quality (one run), in this order.
///
/// One thread is measured in processor time of the thread that builds, several on the wall: with one thread, Embree leaves another
/// spinning as long as its device lives. No other device of Embree's may exist, since it would lend its threads.
///
/// # Errors
/// Embree fails, or no threads can be had.
pub(crate) fn seconds(
    embree: &Embree,
    mesh: &TriangleMesh,
    threads: usize,
    rounds: usize,
) -> Result<Vec<BuildTime>> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    let device = Arc::new(device(embree, threads, false)?);
    let clock: fn(&mut dyn FnMut()) -> f64 =
        if threads == 1 { |work| thread_seconds(work) } else { |work| wall_seconds(work) };
    let presets = presets();
    let build_sahl = |options: &BuildOptions| {
        let world = world(mesh);
        pool.install(|| {
            // Freed after the clock has stopped.
            let mut accel = None;
            clock(&mut || accel = Some(Accel::build(world.clone(), options)))
        })
    };
    let build_embree = |quality: Quality| -> Result<f64> {
        let mut draft = Some(Draft::new(&device, mesh, quality, false)?);
        // Released after the clock has stopped.
        let mut scene = None;
        let seconds = clock(&mut || scene = draft.take().map(Draft::commit));
        scene.transpose()?;
        Ok(seconds)
    };
    let mut failure = None;
    let contenders: Vec<Contender> =
        (0..presets.len()).map(Contender::Sahl).chain([Contender::Embree]).collect();
    let medians = alternate(&contenders, rounds, |contender| match contender {
        Contender::Sahl(preset) => build_sahl(&presets[preset].1),
        Contender::Embree => build_embree(Quality::Medium).unwrap_or_else(|error| {
            failure = Some(error);
            f64::NAN
        }),
    });
    if let Some(error) = failure {
        return Err(error);
    }
    let names = presets.map(|(name, _)| name).into_iter().chain(["Embree medium", "Embree high"]);
    let seconds = medians.into_iter().chain([build_embree(Quality::High)?]);
    Ok(names.zip(seconds).map(|(name, seconds)| BuildTime { name, seconds }).collect())
}

/// Each of Sahl's presets over Embree's medium quality, the default first; with the names of such rows.
pub(crate) fn ratios(times: &[BuildTime]) -> Option<[(String, f64); 2]> {
    let of = |name: &str| times.iter().find(|time| time.name == name).map(|time| time.seconds);
    let theirs = of("Embree medium")?;
    let [(first, _), (second, _)] = presets();
    let ratio = |name: &str| Some((format!("{name} / Embree medium"), of(name)? / theirs));
    Some([ratio(first)?, ratio(second)?])
}

/// Bytes that Embree keeps for the mesh in its default settings, the shared buffers of the mesh not counted.
///
/// # Errors
/// Embree fails.
pub(crate) fn embree_bytes(embree: &Embree, mesh: &TriangleMesh, threads: usize) -> Result<u64> {
    let device = Arc::new(device(embree, threads, true)?);
    let before = device.bytes();
    // Alive while its memory is counted.
    let _scene = Draft::new(&device, mesh, Quality::Medium, false)?.commit()?;
    Ok(device.bytes().saturating_sub(before))
}

fn device(embree: &Embree, threads: usize, counts_memory: bool) -> Result<Device> {
    let settings = Settings { isa: Isa::Automatic, threads, counts_memory };
    embree.device(settings)?.ok_or_else(|| "Embree does not run on this processor".into())
}
