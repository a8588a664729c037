//! How far a render is: a bar, lines, or JSON objects; and whether it should stop.

use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use sahl::render::{Film, Progress, Status};
use serde_json::json;

use crate::args::ProgressKind;
use crate::console::Console;
use crate::format;
use crate::interrupt;

/// Steps of the bar.
const STEPS: u64 = 1000;

/// Watches a render from the outside: tells how far it is, and stops it on a signal or when its time is over.
pub(crate) struct Monitor {
    started: Instant,
    deadline: Option<Instant>,
    console: Console,
    display: Display,
    /// When to tell next, in milliseconds from the start: the thread that moves it on tells.
    next: AtomicU64,
    timed_out: AtomicBool,
}

/// What is shown.
enum Display {
    Bar(ProgressBar),
    /// For `--progress bar` without a terminal.
    Lines,
    Json,
    Nothing,
}

impl Display {
    fn new(kind: ProgressKind, quiet: bool) -> Self {
        let terminal =
            io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb");
        match kind {
            _ if quiet => Self::Nothing,
            ProgressKind::None => Self::Nothing,
            ProgressKind::Json => Self::Json,
            ProgressKind::Auto if !terminal => Self::Nothing,
            ProgressKind::Bar if !terminal => Self::Lines,
            ProgressKind::Auto | ProgressKind::Bar => {
                let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
                let style = ProgressStyle::with_template("{bar:32} {msg}");
                bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
                Self::Bar(bar)
            }
        }
    }

    /// Time between two tellings.
    fn interval(&self) -> Duration {
        match self {
            Self::Bar(_) => Duration::from_millis(100),
            Self::Json => Duration::from_millis(500),
            Self::Lines => Duration::from_secs(5),
            Self::Nothing => Duration::MAX,
        }
    }
}

impl Monitor {
    /// `time` is counted from here.
    pub(crate) fn new(kind: ProgressKind, console: Console, time: Option<Duration>) -> Self {
        let started = Instant::now();
        Self {
            started,
            deadline: time.and_then(|time| started.checked_add(time)),
            console,
            display: Display::new(kind, console.is_quiet()),
            next: AtomicU64::new(0),
            timed_out: AtomicBool::new(false),
        }
    }

    /// Time since the start.
    pub(crate) fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// Whether the time was over before the image was done.
    pub(crate) fn timed_out(&self) -> bool {
        self.timed_out.load(Ordering::Relaxed)
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }

    fn go_on(&self) -> ControlFlow<()> {
        if interrupt::requested() {
            return ControlFlow::Break(());
        }
        if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            self.timed_out.store(true, Ordering::Relaxed);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    /// Tells, if it was silent for long enough and no other thread does.
    fn tell(&self, status: &Status) {
        if matches!(self.display, Display::Nothing) {
            return;
        }
        let elapsed = self.elapsed();
        let now = elapsed.as_millis() as u64;
        let next = self.next.load(Ordering::Relaxed);
        let later = now + self.display.interval().as_millis() as u64;
        let is_mine = now >= next
            && self.next.compare_exchange(next, later, Ordering::Relaxed, Ordering::Relaxed).is_ok();
        if is_mine {
            self.show(status, elapsed);
        }
    }

    fn show(&self, status: &Status, elapsed: Duration) {
        let seconds = elapsed.as_secs_f64().max(1e-9);
        let share = status.samples_done as f64 / status.samples_total.max(1) as f64;
        let left = if share > 0.0 { Some(seconds / share - seconds) } else { None };
        let (samples, rays) = (status.samples_done as f64 / seconds, status.rays as f64 / seconds);
        let text = || {
            let left = left.and_then(|left| Duration::try_from_secs_f64(left).ok());
            let left = left.map_or_else(|| "?".to_owned(), format::duration);
            format!(
                "{:3.0} %  {}, {left} left  {}samples/s  {}rays/s",
                share * 100.0,
                format::duration(elapsed),
                format::count(samples),
                format::count(rays)
            )
        };
        match &self.display {
            Display::Nothing => {}
            Display::Lines => self.console.line(&text()),
            Display::Bar(bar) => {
                bar.set_position((share * STEPS as f64) as u64);
                bar.set_message(text());
            }
            Display::Json => self.console.event(&json!({
                "event": "progress",
                "share": share,
                "elapsed_seconds": seconds,
                "left_seconds": left,
                "samples": status.samples_done,
                "samples_total": status.samples_total,
                "rays": status.rays,
                "dropped": status.dropped,
                "samples_per_second": samples,
                "rays_per_second": rays,
            })),
        }
    }
}

impl Progress for Monitor {
    fn tile_done(&self, status: &Status) -> ControlFlow<()> {
        self.tell(status);
        self.go_on()
    }

    fn pass_done(&self, status: &Status, _film: &Film) -> ControlFlow<()> {
        self.tell(status);
        self.go_on()
    }
}
