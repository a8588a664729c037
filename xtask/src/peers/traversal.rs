//! Rays a second: Sahl's queries against Embree's on the same rays.

use std::hint::black_box;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use rayon::ThreadPool;
use sahl_accel::{Accel, Hit};
use sahl_math::Ray;

use super::timing::{alternate_parts, thread_seconds, wall_seconds};
use crate::embree::{self, INVALID, RayHit, RayHit16, Scene};

/// Rays a call of Sahl's batch queries.
const CHUNK: usize = 4_096;
/// Rays that a contender answers before the next one answers the same: few, so that all meet the machine in the same state, and
/// enough to fill the caches with what the one before has driven out.
const PART: usize = 8 * CHUNK;
/// Rays of a turn of a thread where there are several: few enough that all end at nearly the same time.
const TURN: usize = 1_024;

/// A way to ask Sahl for nearest hits.
pub(crate) struct NearestQuery {
    pub(crate) name: &'static str,
    /// Whether it is meant for rays that are alike, and is measured with camera rays only.
    pub(crate) coherent: bool,
    pub(crate) run: fn(&Accel, &[Ray], &mut [Option<Hit>]),
}

/// A way to ask Sahl for occlusion.
pub(crate) struct OcclusionQuery {
    pub(crate) name: &'static str,
    pub(crate) run: fn(&Accel, &[Ray], &mut [bool]),
}

/// Sahl's queries for nearest hits.
pub(crate) const NEAREST: &[NearestQuery] = &[
    NearestQuery {
        name: "single",
        coherent: false,
        run: |accel, rays, hits| {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = accel.intersect(ray);
            }
        },
    },
    NearestQuery { name: "batch", coherent: false, run: Accel::intersect_batch },
    NearestQuery { name: "coherent", coherent: true, run: Accel::intersect_coherent },
];

/// Sahl's queries for occlusion.
pub(crate) const OCCLUSION: &[OcclusionQuery] = &[
    OcclusionQuery {
        name: "single",
        run: |accel, rays, occluded| {
            for (ray, occluded) in rays.iter().zip(occluded) {
                *occluded = accel.occluded(ray);
            }
        },
    },
    OcclusionQuery { name: "batch", run: Accel::occluded_batch },
];

/// One configuration of Embree with its tree.
pub(crate) struct Rival {
    pub(crate) name: String,
    pub(crate) scene: Scene,
    /// Whether it is shown for information and does not count as Embree's best.
    pub(crate) informative: bool,
}

/// What was measured on one workload.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Outcome {
    pub(crate) rates: Vec<Rate>,
    /// Rays to which Sahl and Embree give other answers.
    pub(crate) differing: usize,
    /// Rays to which two of Sahl's queries give other answers, to the last bit: there should be none.
    pub(crate) inconsistent: usize,
}

/// A rate that was measured.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rate {
    pub(crate) name: String,
    pub(crate) side: Side,
    /// Rays a second.
    pub(crate) rate: f64,
}

/// Whose rate it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Sahl,
    Embree,
    /// Does not count.
    Information,
}

impl Outcome {
    /// The fastest of one side.
    pub(crate) fn best(&self, side: Side) -> Option<&Rate> {
        self.rates.iter().filter(|rate| rate.side == side).max_by(|a, b| a.rate.total_cmp(&b.rate))
    }

    /// Sahl's fastest over Embree's fastest.
    pub(crate) fn ratio(&self) -> Option<f64> {
        Some(self.best(Side::Sahl)?.rate / self.best(Side::Embree)?.rate)
    }
}

/// Who answers the rays.
#[derive(Clone, Copy, Debug)]
enum Contender {
    Sahl(Tree, usize),
    Single(usize),
    Packets(usize, bool),
}

/// Which of Sahl's trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tree {
    Default,
    High,
}

impl Tree {
    /// How it is called before the name of a query.
    fn prefix(self) -> &'static str {
        match self {
            Self::Default => "",
            Self::High => "high quality, ",
        }
    }
}

/// What is measured.
#[derive(Clone, Copy)]
pub(crate) struct Bench<'a> {
    pub(crate) accel: &'a Accel,
    /// The tree of the builder that takes its time, as Embree's high quality does.
    pub(crate) high: &'a Accel,
    pub(crate) rivals: &'a [Rival],
    pub(crate) rounds: usize,
}

impl Bench<'_> {
    /// Nearest hits on one thread; `coherent` says whether the rays are alike, so that packets are tried.
    pub(crate) fn nearest(&self, rays: &[Ray], coherent: bool) -> Outcome {
        let contenders = self.contenders(&nearest_queries(coherent), coherent);
        let mut hits = vec![None; rays.len()];
        let mut singles: Vec<RayHit> = rays.iter().map(RayHit::new).collect();
        let mut packed: Vec<RayHit16> = if coherent { embree::pack(rays) } else { Vec::new() };
        let medians = self.medians(&contenders, rays.len(), PART, |contender, part| match contender {
            Contender::Sahl(tree, query) => by_chunks(&rays[part.clone()], &mut hits[part], |rays, hits| {
                (NEAREST[query].run)(self.tree(tree), rays, hits);
            }),
            Contender::Single(rival) => {
                let singles = &mut singles[part.clone()];
                reset(singles, &rays[part]);
                thread_seconds(|| embree::intersect(&self.rivals[rival].scene, singles))
            }
            Contender::Packets(rival, coherent) => {
                let packed = &mut packed[part.start / 16..part.end / 16];
                for (packet, rays) in packed.iter_mut().zip(rays[part].chunks_exact(16)) {
                    packet.reset(rays);
                }
                thread_seconds(|| embree::intersect_packets(&self.rivals[rival].scene, packed, coherent))
            }
        });
        let rates = self.rates(&contenders, &medians, rays.len(), |query| NEAREST[query].name);
        (NEAREST[0].run)(self.accel, rays, &mut hits);
        let differing = hits.iter().zip(&singles).filter(|(hit, single)| !is_alike(**hit, single)).count();
        Outcome { rates, differing, inconsistent: self.inconsistent_hits(rays, &hits, coherent) }
    }

    /// Occlusion on one thread.
    pub(crate) fn occlusion(&self, rays: &[Ray]) -> Outcome {
        let contenders = self.contenders(&(0..OCCLUSION.len()).collect::<Vec<_>>(), false);
        let mut occluded = vec![false; rays.len()];
        let mut singles: Vec<embree::Ray> = rays.iter().map(embree::single).collect();
        let medians = self.medians(&contenders, rays.len(), PART, |contender, part| match contender {
            Contender::Sahl(tree, query) => {
                by_chunks(&rays[part.clone()], &mut occluded[part], |rays, occluded| {
                    (OCCLUSION[query].run)(self.tree(tree), rays, occluded);
                })
            }
            Contender::Single(rival) | Contender::Packets(rival, _) => {
                let singles = &mut singles[part.clone()];
                for (single, ray) in singles.iter_mut().zip(&rays[part]) {
                    single.tfar = ray.t_max;
                }
                thread_seconds(|| embree::occluded(&self.rivals[rival].scene, singles))
            }
        });
        let rates = self.rates(&contenders, &medians, rays.len(), |query| OCCLUSION[query].name);
        (OCCLUSION[0].run)(self.accel, rays, &mut occluded);
        let expected = singles.iter().map(|single| single.tfar == f32::NEG_INFINITY);
        let differing = expected.zip(&occluded).filter(|(theirs, ours)| theirs != *ours).count();
        Outcome { rates, differing, inconsistent: self.inconsistent_occlusion(rays, &occluded) }
    }

    /// Nearest hits on several threads, by the clock on the wall.
    pub(crate) fn threads(&self, rays: &[Ray], pool: &ThreadPool) -> Outcome {
        let threads = pool.current_num_threads();
        let contenders = self.contenders(&nearest_queries(false), false);
        let mut hits = vec![None; rays.len()];
        let mut singles: Vec<RayHit> = rays.iter().map(RayHit::new).collect();
        let medians =
            self.medians(&contenders, rays.len(), threads * PART, |contender, part| match contender {
                Contender::Sahl(tree, query) => {
                    let (rays, hits) = (&rays[part.clone()], &mut hits[part]);
                    on_threads(pool, rays, hits, |rays, hits| {
                        (NEAREST[query].run)(self.tree(tree), rays, hits);
                    })
                }
                Contender::Single(rival) | Contender::Packets(rival, _) => {
                    let (rays, singles) = (&rays[part.clone()], &mut singles[part]);
                    reset(singles, rays);
                    let scene = &self.rivals[rival].scene;
                    on_threads(pool, rays, singles, |_, singles| embree::intersect(scene, singles))
                }
            });
        let rates = self.rates(&contenders, &medians, rays.len(), |query| NEAREST[query].name);
        Outcome { rates, ..Outcome::default() }
    }

    /// How much faster Sahl's fastest query is on two threads than on one that is started alike.
    pub(crate) fn scaling(&self, rays: &[Ray], [one, two]: [&ThreadPool; 2]) -> f64 {
        let mut hits = vec![None; rays.len()];
        let contenders: Vec<(usize, &ThreadPool)> =
            nearest_queries(false).into_iter().flat_map(|query| [(query, one), (query, two)]).collect();
        let medians = self.medians(&contenders, rays.len(), 4 * PART, |(query, pool), part| {
            let (rays, hits) = (&rays[part.clone()], &mut hits[part]);
            on_threads(pool, rays, hits, |rays, hits| (NEAREST[query].run)(self.accel, rays, hits))
        });
        // The contenders take turns: one thread, two threads.
        let fastest = |times: &mut dyn Iterator<Item = &f64>| times.copied().fold(f64::INFINITY, f64::min);
        fastest(&mut medians.iter().step_by(2)) / fastest(&mut medians.iter().skip(1).step_by(2))
    }

    /// The median seconds of each contender for all rays, of which all answer one part before the next.
    fn medians<C: Copy>(
        &self,
        contenders: &[C],
        rays: usize,
        part: usize,
        mut run: impl FnMut(C, Range<usize>) -> f64,
    ) -> Vec<f64> {
        alternate_parts(contenders, self.rounds, rays.div_ceil(part), |contender, index| {
            run(contender, index * part..rays.min((index + 1) * part))
        })
    }

    /// How many rays some query for nearest hits answers otherwise than the first one, whose answers are given.
    fn inconsistent_hits(&self, rays: &[Ray], hits: &[Option<Hit>], coherent: bool) -> usize {
        let mut others = vec![None; rays.len()];
        let count = |query: usize| {
            (NEAREST[query].run)(self.accel, rays, &mut others);
            others.iter().zip(hits).filter(|(a, b)| a != b).count()
        };
        nearest_queries(coherent).into_iter().map(count).max().unwrap_or(0)
    }

    /// As above for occlusion.
    fn inconsistent_occlusion(&self, rays: &[Ray], occluded: &[bool]) -> usize {
        let mut others = vec![false; rays.len()];
        let count = |query: &OcclusionQuery| {
            (query.run)(self.accel, rays, &mut others);
            others.iter().zip(occluded).filter(|(a, b)| a != b).count()
        };
        OCCLUSION[1..].iter().map(count).max().unwrap_or(0)
    }

    fn tree(&self, tree: Tree) -> &Accel {
        match tree {
            Tree::Default => self.accel,
            Tree::High => self.high,
        }
    }

    fn contenders(&self, queries: &[usize], packets: bool) -> Vec<Contender> {
        // One ray a call is measured with the default tree alone.
        let of = |tree: Tree, queries: &[usize]| -> Vec<Contender> {
            queries.iter().map(|&query| Contender::Sahl(tree, query)).collect()
        };
        let mut contenders = of(Tree::Default, queries);
        contenders.extend(of(Tree::High, &queries[1..]));
        for rival in 0..self.rivals.len() {
            contenders.push(Contender::Single(rival));
            if packets {
                contenders.extend([false, true].map(|coherent| Contender::Packets(rival, coherent)));
            }
        }
        contenders
    }

    fn rates(
        &self,
        contenders: &[Contender],
        seconds: &[f64],
        rays: usize,
        query_name: impl Fn(usize) -> &'static str,
    ) -> Vec<Rate> {
        let rate = |(&contender, &seconds): (&Contender, &f64)| {
            let (name, side) = match contender {
                Contender::Sahl(tree, query) => {
                    (format!("Sahl {}{}", tree.prefix(), query_name(query)), Side::Sahl)
                }
                Contender::Single(rival) => self.label(rival, ""),
                Contender::Packets(rival, false) => self.label(rival, ", packets"),
                Contender::Packets(rival, true) => self.label(rival, ", coherent packets"),
            };
            Rate { name, side, rate: rays as f64 / seconds }
        };
        contenders.iter().zip(seconds).map(rate).collect()
    }

    fn label(&self, rival: usize, suffix: &str) -> (String, Side) {
        let rival = &self.rivals[rival];
        let side = if rival.informative { Side::Information } else { Side::Embree };
        (format!("Embree {}{suffix}", rival.name), side)
    }
}

/// The queries of [`NEAREST`] that are tried.
fn nearest_queries(coherent: bool) -> Vec<usize> {
    (0..NEAREST.len()).filter(|&query| coherent || !NEAREST[query].coherent).collect()
}

/// Whether Sahl and Embree mean the same hit. Its triangle may be another one where two meet.
fn is_alike(hit: Option<Hit>, single: &RayHit) -> bool {
    match hit {
        Some(hit) => single.hit.geometry != INVALID && (hit.t - single.ray.tfar).abs() <= 1e-3 * hit.t,
        None => single.hit.geometry == INVALID,
    }
}

fn reset(singles: &mut [RayHit], rays: &[Ray]) {
    for (single, ray) in singles.iter_mut().zip(rays) {
        single.reset(ray);
    }
}

/// Seconds that this thread takes to answer the rays, chunk by chunk.
fn by_chunks<T>(rays: &[Ray], answers: &mut [T], work: impl Fn(&[Ray], &mut [T])) -> f64 {
    thread_seconds(|| {
        for (rays, answers) in rays.chunks(CHUNK).zip(answers.chunks_mut(CHUNK)) {
            work(rays, answers);
        }
        black_box(&answers);
    })
}

/// Seconds on the wall in which the threads of a pool answer the rays, turn by turn as they get to it.
fn on_threads<T: Send>(
    pool: &ThreadPool,
    rays: &[Ray],
    answers: &mut [T],
    work: impl Fn(&[Ray], &mut [T]) + Sync,
) -> f64 {
    let queue = Mutex::new(rays.chunks(TURN).zip(answers.chunks_mut(TURN)));
    wall_seconds(|| {
        pool.broadcast(|_| {
            loop {
                let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some((rays, answers)) = next else { break };
                work(rays, answers);
            }
        });
    })
}
