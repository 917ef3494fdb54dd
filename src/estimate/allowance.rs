//! Time limits of trials.

use std::collections::BTreeMap;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
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

/// The messages that work on its own thread sends within `limit`, and whether it has ended. Unfinished work goes on
/// alone: a driver that compiles a shader cannot be interrupted.
pub(super) fn within<T: Send + 'static>(
    limit: Duration,
    work: impl FnOnce(&Sender<T>) + Send + 'static,
) -> (Vec<T>, bool) {
    let end = Instant::now() + limit;
    let (tell, told) = channel();
    std::thread::spawn(move || work(&tell));
    let mut all = Vec::new();
    loop {
        match told.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(one) => all.push(one),
            Err(RecvTimeoutError::Disconnected) => return (all, true),
            Err(RecvTimeoutError::Timeout) => return (all, false),
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
    fn what_cannot_be_interrupted_is_left_to_itself() {
        let stuck = |tell: &Sender<u32>| {
            _ = tell.send(1);
            std::thread::sleep(Duration::from_secs(3600));
            _ = tell.send(2);
        };
        assert_eq!(within(Duration::from_millis(200), stuck), (vec![1], false));
        let quick = |tell: &Sender<u32>| {
            _ = tell.send(1);
            _ = tell.send(2);
        };
        assert_eq!(within(Duration::from_secs(600), quick), (vec![1, 2], true));
    }
}
