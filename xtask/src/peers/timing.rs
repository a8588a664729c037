//! Clocks, alternating runs, and what is made of their times.

use std::hint;
use std::thread;
use std::time::Instant;

/// Seconds that this thread computes while `work` runs; what other programs take of the machine does not count. Where there is no
/// such clock, seconds on the wall.
pub(crate) fn thread_seconds(work: impl FnOnce()) -> f64 {
    #[cfg(unix)]
    return cpu_seconds(rustix::time::ClockId::ThreadCPUTime, work);
    #[cfg(not(unix))]
    return wall_seconds(work);
}

/// Seconds that all threads of this program compute while `work` runs; on the wall where there is no such clock.
fn process_seconds(work: impl FnOnce()) -> f64 {
    #[cfg(unix)]
    return cpu_seconds(rustix::time::ClockId::ProcessCPUTime, work);
    #[cfg(not(unix))]
    return wall_seconds(work);
}

/// Seconds on the wall.
pub(crate) fn wall_seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

#[cfg(unix)]
fn cpu_seconds(clock: rustix::time::ClockId, work: impl FnOnce()) -> f64 {
    let now = || {
        let time = rustix::time::clock_gettime(clock);
        (time.tv_sec, time.tv_nsec)
    };
    let start = now();
    work();
    let end = now();
    (end.0 - start.0) as f64 + (end.1 - start.1) as f64 * 1e-9
}

/// How much of `threads` processors this program gets: about 1 on a machine with nothing else to do.
pub(crate) fn free_share(threads: usize) -> f64 {
    /// Seconds of the trial.
    const TRIAL: f64 = 0.1;
    let mut wall = 0.0;
    let busy = process_seconds(|| {
        wall = wall_seconds(|| {
            thread::scope(|scope| {
                for _ in 0..threads {
                    scope.spawn(|| {
                        let start = Instant::now();
                        while start.elapsed().as_secs_f64() < TRIAL {
                            hint::spin_loop();
                        }
                    });
                }
            });
        });
    });
    busy / (wall * threads as f64)
}

/// The medians of `rounds` runs of each contender. Each round runs all of them, beginning with another one; a round that does not
/// count comes first.
pub(crate) fn alternate<C: Copy>(contenders: &[C], rounds: usize, mut run: impl FnMut(C) -> f64) -> Vec<f64> {
    alternate_parts(contenders, rounds, 1, |contender, _| run(contender))
}

/// As [`alternate`], where each run consists of parts and all contenders run one part before any runs the next: what slows the
/// machine for a while slows all of them alike.
pub(crate) fn alternate_parts<C: Copy>(
    contenders: &[C],
    rounds: usize,
    parts: usize,
    mut run: impl FnMut(C, usize) -> f64,
) -> Vec<f64> {
    let mut times = vec![Vec::with_capacity(rounds); contenders.len()];
    for &contender in contenders {
        for part in 0..parts {
            run(contender, part);
        }
    }
    for round in 0..rounds {
        let mut seconds = vec![0.0; contenders.len()];
        for part in 0..parts {
            for i in 0..contenders.len() {
                let place = (i + round + part) % contenders.len();
                seconds[place] += run(contenders[place], part);
            }
        }
        times.iter_mut().zip(seconds).for_each(|(times, seconds)| times.push(seconds));
    }
    times.into_iter().map(median).collect()
}

/// The middle value, or the mean of the two in the middle; NaN of none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => f64::NAN,
        _ if n % 2 == 1 => values[n / 2],
        _ => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}

/// The geometric mean; `None` of none.
pub(crate) fn geometric_mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0_u32);
    for value in values {
        sum += value.ln();
        count += 1;
    }
    (count > 0).then(|| (sum / f64::from(count)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 3.0, 2.0]), 2.5);
        assert_eq!(median(vec![7.0]), 7.0);
        assert!(median(Vec::new()).is_nan());
    }

    #[test]
    fn geometric_means() {
        assert_eq!(geometric_mean([]), None);
        assert!((geometric_mean([2.0, 8.0]).unwrap() - 4.0).abs() < 1e-12);
        assert!((geometric_mean([0.5, 2.0, 1.0]).unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn each_contender_runs_once_a_round_and_begins_in_turn() {
        let mut order = Vec::new();
        let medians = alternate(&[0, 1, 2], 3, |contender| {
            order.push(contender);
            f64::from(contender)
        });
        assert_eq!(order, [0, 1, 2, 0, 1, 2, 1, 2, 0, 2, 0, 1]);
        assert_eq!(medians, [0.0, 1.0, 2.0]);
    }

    #[test]
    fn parts_of_a_run_are_added_up() {
        let mut order = Vec::new();
        let medians = alternate_parts(&[10, 20], 1, 2, |contender, part| {
            order.push((contender, part));
            (contender + part) as f64
        });
        assert_eq!(order, [(10, 0), (10, 1), (20, 0), (20, 1), (10, 0), (20, 0), (20, 1), (10, 1)]);
        assert_eq!(medians, [21.0, 41.0]);
    }

    #[test]
    fn clocks_go_forward() {
        let work = || (0..100_000_u64).for_each(|i| assert!(hint::black_box(i) < u64::MAX));
        for seconds in [thread_seconds(work), process_seconds(work), wall_seconds(work)] {
            assert!(seconds > 0.0);
        }
    }
}
