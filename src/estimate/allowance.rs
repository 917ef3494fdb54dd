//! Time limits of trials.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time limits of trials, and the time used.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Allowance {
    /// Limit for one codec at one site. Encoding counts as a site.
    pub each: Duration,
    /// All together.
    pub all: Duration,
}

impl Default for Allowance {
    fn default() -> Self {
        Self { each: Duration::from_secs(2), all: Duration::from_secs(20) }
    }
}

/// What trials have taken.
#[derive(Debug)]
pub(super) struct Spending {
    allowance: Allowance,
    all: Duration,
    each: BTreeMap<String, Duration>,
}

impl Spending {
    /// Nothing yet.
    pub(super) const fn new(allowance: Allowance) -> Self {
        Self { allowance, all: Duration::ZERO, each: BTreeMap::new() }
    }

    /// Time left for one codec at one site.
    pub(super) fn left(&self, of: &str) -> Duration {
        let own = self.each.get(of).copied().unwrap_or_default();
        let left = self.allowance.each.saturating_sub(own);
        left.min(self.allowance.all.saturating_sub(self.all))
    }

    /// One has taken so long.
    pub(super) fn add(&mut self, of: &str, took: Duration) {
        *self.each.entry(of.to_owned()).or_default() += took;
        self.all += took;
    }
}

/// Work on a thread of its own that was not done in its time. It is asked to stop between its steps. A driver that compiles
/// a shader cannot be interrupted.
#[derive(Debug)]
pub(super) struct Unfinished {
    thread: JoinHandle<()>,
    /// Closed once the work is done and all that it held is dropped.
    running: Receiver<()>,
}

impl Unfinished {
    /// Waits for the end of the thread. A process must not end before: it would free what a driver still uses in the thread.
    ///
    /// # Errors
    /// Itself, where the thread runs on after `limit`.
    pub(super) fn end(self, limit: Duration) -> Result<(), Self> {
        match self.running.recv_timeout(limit) {
            Err(RecvTimeoutError::Timeout) => Err(self),
            // What is left of the thread is its own end. A panic has been printed, and the work has no result.
            Ok(()) | Err(RecvTimeoutError::Disconnected) => {
                _ = self.thread.join();
                Ok(())
            }
        }
    }
}

/// What work on a thread of its own sends within `limit`, and the thread if it has not ended by then. Work gets a sender, and
/// a flag that turns true once nobody waits for it any more.
pub(super) fn within<T: Send + 'static>(
    limit: Duration,
    work: impl FnOnce(&Sender<T>, &AtomicBool) + Send + 'static,
) -> (Vec<T>, Option<Unfinished>) {
    let end = Instant::now() + limit;
    let (tell, told) = channel();
    let (runs, running) = channel();
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = stop.clone();
    let thread = std::thread::spawn(move || {
        // The last to be dropped, whatever work comes to.
        let _runs = runs;
        work(&tell, &stopped);
        drop(tell);
    });
    let unfinished = Unfinished { thread, running };
    let mut all = Vec::new();
    loop {
        match told.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(one) => all.push(one),
            Err(RecvTimeoutError::Disconnected) => {
                _ = unfinished.thread.join();
                return (all, None);
            }
            Err(RecvTimeoutError::Timeout) => {
                stop.store(true, Ordering::Relaxed);
                return (all, Some(unfinished));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neither_one_nor_all_take_more_than_they_may() {
        let seconds = Duration::from_secs;
        let mut spending = Spending::new(Allowance { each: seconds(2), all: seconds(5) });
        assert_eq!(spending.left("a"), seconds(2));
        spending.add("a", seconds(1));
        assert_eq!((spending.left("a"), spending.left("b")), (seconds(1), seconds(2)));
        spending.add("b", seconds(3));
        assert_eq!(
            (spending.left("a"), spending.left("b"), spending.left("c")),
            (seconds(1), seconds(0), seconds(1))
        );
        spending.add("c", seconds(1));
        assert_eq!(spending.left("d"), seconds(0));
    }

    #[test]
    fn what_ends_in_its_time_has_ended() {
        let quick = |tell: &Sender<u32>, _: &AtomicBool| {
            _ = tell.send(1);
            _ = tell.send(2);
        };
        let (told, unfinished) = within(Duration::from_secs(600), quick);
        assert_eq!((told, unfinished.is_none()), (vec![1, 2], true));
    }

    #[test]
    fn what_does_not_is_stopped_and_waited_for() {
        let held = Arc::new(());
        let own = held.clone();
        let work = move |tell: &Sender<u32>, stop: &AtomicBool| {
            _ = tell.send(1);
            while !stop.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
            // As a driver: for some time more, whoever waits.
            std::thread::sleep(Duration::from_millis(50));
            _ = tell.send(2);
            drop(own);
        };
        let (told, unfinished) = within(Duration::from_millis(20), work);
        assert_eq!(told, [1]);
        assert!(unfinished.unwrap().end(Duration::from_secs(600)).is_ok());
        assert_eq!(Arc::strong_count(&held), 1, "the thread holds nothing any more");
    }

    /// The twin: nobody waits for ever.
    #[test]
    fn what_never_ends_is_left_to_itself() {
        let stuck = |tell: &Sender<u32>, _: &AtomicBool| {
            _ = tell.send(1);
            std::thread::sleep(Duration::from_secs(3600));
            _ = tell.send(2);
        };
        let (told, unfinished) = within(Duration::from_millis(20), stuck);
        assert_eq!(told, [1]);
        let still = unfinished.unwrap().end(Duration::from_millis(20)).unwrap_err();
        assert!(!still.thread.is_finished());
    }
}
