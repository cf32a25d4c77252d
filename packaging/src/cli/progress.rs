//! What is being done, on a terminal only.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// Between two movements.
const TICK: Duration = Duration::from_millis(100);

/// A line on the standard error output that says what is being done.
pub struct Progress(ProgressBar);

impl Progress {
    /// Shows nothing where the standard error output is no terminal.
    pub fn new() -> Self {
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed:>4} {msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(TICK);
        Self(bar)
    }

    /// The same, that says `what` from the start.
    pub fn saying(what: impl std::fmt::Display) -> Self {
        let progress = Self::new();
        progress.say(what);
        progress
    }

    /// A bar with room for `total`, of which [`Self::advance`] tells. It moves while one of them takes long, too.
    pub fn bar(total: u64) -> Self {
        let bar = ProgressBar::new(total);
        let template = "{spinner} {elapsed:>4} {wide_bar} {pos} of {len} {msg} eta {eta}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(TICK);
        Self(bar)
    }

    /// Moves the bar on.
    pub fn advance(&self, by: u64) {
        self.0.inc(by);
    }

    /// Writes a line above it that stays, on a terminal or not.
    pub fn note(&self, what: &str) {
        self.0.suspend(|| eprintln!("{what}"));
    }

    /// Replaces the line.
    pub fn say(&self, what: impl std::fmt::Display) {
        self.0.set_message(what.to_string());
    }
}

impl Default for Progress {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
