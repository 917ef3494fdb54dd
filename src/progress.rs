//! Progress bars, only on a terminal.

use cvr_core::codec::Progress;
use indicatif::{ProgressBar, ProgressStyle};

fn bar(length: u64, template: &str) -> ProgressBar {
    // indicatif draws to standard error, and only if it is a terminal.
    let bar = ProgressBar::new(length);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// Progress of one encoding.
pub struct VoxelBar(ProgressBar);

impl VoxelBar {
    /// A bar over a number of voxels.
    #[must_use]
    pub fn new(voxels: u64) -> Self {
        Self(bar(voxels, "{bar:40} {percent:>3} %  {eta} left"))
    }

    /// Progress for the encoder to report to.
    #[must_use]
    pub fn progress(&self) -> Progress<'_> {
        Progress::new(|voxels| self.0.inc(voxels), None)
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// Shows the current trial, for estimates that take some seconds.
pub struct TrialBar(ProgressBar);

impl TrialBar {
    /// A line with nothing to say yet.
    #[must_use]
    pub fn new() -> Self {
        let bar = bar(0, "{spinner} {elapsed}  {wide_msg}");
        bar.enable_steady_tick(std::time::Duration::from_millis(200));
        Self(bar)
    }

    /// This begins.
    pub fn begins(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }

    /// Removes the line.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}

impl Default for TrialBar {
    fn default() -> Self {
        Self::new()
    }
}

/// Progress of a run.
pub struct CellBar(ProgressBar);

impl CellBar {
    /// A bar over a number of cells.
    #[must_use]
    pub fn new(cells: usize) -> Self {
        Self(bar(cells as u64, "{bar:30} {pos}/{len} cells, {eta} left  {wide_msg}"))
    }

    /// The cell `name` begins, when `done` others are done.
    pub fn cell(&self, done: usize, name: &str) {
        let jumps = done as u64 > self.0.position() + 1;
        self.0.set_position(done as u64);
        if jumps {
            // Cells that were taken over took no time, so they say nothing about the remaining time.
            self.0.reset_eta();
        }
        self.0.set_message(name.to_owned());
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
