//! The progress of the audit, on one line of stderr, if that is a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use scanbound::audit::{Progress, Share};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

static HIDDEN: AtomicBool = AtomicBool::new(false);

/// Hides the progress from here on.
pub fn hide() {
    HIDDEN.store(true, Ordering::Relaxed);
}

/// The progress line. Shows nothing if stderr is not a terminal.
pub struct Line(ProgressBar);

impl Line {
    /// Begins the line.
    pub fn new() -> Line {
        if HIDDEN.load(Ordering::Relaxed) || !std::io::stderr().is_terminal() {
            return Line(ProgressBar::hidden());
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed} {wide_msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Line(bar)
    }

    /// Shows how far it is.
    pub fn show(&self, progress: Progress) {
        if self.0.is_hidden() {
            return;
        }
        self.0.set_message(match progress {
            Progress::Stage(stage) => stage.to_owned(),
            Progress::Bounds { upper, lower, group, solved, groups } => {
                let gap = Share::of(upper.checked_sub(lower).unwrap_or_default(), upper);
                format!(
                    "searching group {group}: {} to {upper} (difference {gap}), {solved} of {groups} groups solved",
                    lower.text_like(upper)
                )
            }
        });
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
