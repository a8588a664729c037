//! Ctrl-C and the other signals that ask for the end.

use std::sync::atomic::{AtomicBool, Ordering};

/// Signal handlers are the process's own, so is this.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From here on, the first SIGINT, SIGTERM or SIGHUP is noted, and a second one ends the process at once.
pub(crate) fn listen() {
    let handler = || {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            #[expect(clippy::exit, reason = "whoever asks twice does not want to wait for the image")]
            std::process::exit(130);
        }
    };
    // It fails where no handler can be installed: then a signal ends the process without an image, as ever.
    let _ = ctrlc::set_handler(handler);
}

/// Whether a signal has come.
pub(crate) fn requested() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}
