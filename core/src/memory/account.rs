//! Memory in use, and its limit.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{PoisonError, RwLock};

/// Origin of a memory limit.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// The user.
    User,
    /// Free memory of the machine.
    Machine,
    /// Free memory of this process's control group (a container, a batch job).
    ControlGroup,
}

/// A limit on memory.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Bound {
    /// Limit in bytes for all buffers of voxels and streams together.
    pub bytes: u64,
    /// Who says so.
    pub source: Source,
}

/// Something needs more memory than there is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutOfMemory {
    /// What needs it, as a noun phrase.
    pub what: String,
    /// Bytes that it needs.
    pub needed: u64,
    /// Bytes that are taken already.
    pub taken: u64,
    /// The limit; `None` if the system refused memory that no limit forbids.
    pub bound: Option<Bound>,
}

impl std::error::Error for OutOfMemory {}

impl fmt::Display for OutOfMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, needed, taken, bound } = self;
        write!(f, "{what} needs {} of memory", gigabytes(*needed))?;
        let Some(Bound { bytes, source }) = bound else {
            return f.write_str(", which the system does not give; take less at a time");
        };
        let source = match source {
            Source::User => "--max-gb",
            Source::Machine => "what the machine has free",
            Source::ControlGroup => "what the control group of this process has free",
        };
        write!(f, ", and {} may be taken ({source})", gigabytes(*bytes))?;
        if *taken > 0 {
            write!(f, "; {} are taken already", gigabytes(*taken))?;
        }
        f.write_str("; take less at a time, or allow more with --max-gb")
    }
}

/// `275 GB`, `1.5 GB`, `12 MB`: 10⁹ bytes, as `--max-gb` counts them.
#[must_use]
pub fn gigabytes(bytes: u64) -> String {
    match bytes {
        0..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        1_000_000..100_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        100_000_000..1_000_000_000 => format!("{:.0} MB", bytes as f64 / 1e6),
        1_000_000_000..100_000_000_000 => format!("{:.1} GB", bytes as f64 / 1e9),
        _ => format!("{:.0} GB", bytes as f64 / 1e9),
    }
}

/// A sum and its limit.
struct Account {
    bound: RwLock<Option<Bound>>,
    taken: AtomicU64,
}

impl Account {
    const fn new() -> Self {
        Self { bound: RwLock::new(None), taken: AtomicU64::new(0) }
    }

    fn bound(&self) -> Option<Bound> {
        *self.bound.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn check(&self, needed: u64, what: impl FnOnce() -> String) -> Result<(), OutOfMemory> {
        let Some(bound) = self.bound() else { return Ok(()) };
        let taken = self.taken.load(Ordering::Relaxed);
        if taken.saturating_add(needed) <= bound.bytes {
            return Ok(());
        }
        Err(OutOfMemory { what: what(), needed, taken, bound: Some(bound) })
    }
}

static PROCESS: Account = Account::new();

/// Sets the limit of this process.
pub fn allow(bound: Bound) {
    *PROCESS.bound.write().unwrap_or_else(PoisonError::into_inner) = Some(bound);
}

/// The limit of this process. `None` if there is none.
#[must_use]
pub fn allowed() -> Option<Bound> {
    PROCESS.bound()
}

/// Checks that this many more bytes fit within the limit. `what` names their use in the error.
///
/// # Errors
/// When they exceed the limit.
pub fn check(bytes: u64, what: impl FnOnce() -> String) -> Result<(), OutOfMemory> {
    PROCESS.check(bytes, what)
}

/// A vector of zeros, after a check that it fits within the limit.
///
/// # Errors
/// When the limit or the system refuses them.
pub fn zeroed<T: Clone + Default>(count: u64, what: impl Fn() -> String) -> Result<Vec<T>, OutOfMemory> {
    let needed = count.saturating_mul(size_of::<T>() as u64);
    check(needed, &what)?;
    let refused = || OutOfMemory { what: what(), needed, taken: 0, bound: None };
    let count = usize::try_from(count).map_err(|_| refused())?;
    // The probe asks the system without touching a page. `vec!` then gets pages that are already zero.
    Vec::<T>::new().try_reserve_exact(count).map_err(|_| refused())?;
    Ok(vec![T::default(); count])
}

/// Counts bytes as used while it lives. It is a field next to the buffer. All `Held` values are equal, so owners
/// compare by their contents.
#[derive(Debug, Default)]
pub struct Held(u64);

impl Held {
    /// Counts an existing buffer. Its size was checked before it was reserved.
    #[must_use]
    pub fn new(bytes: u64) -> Self {
        PROCESS.taken.fetch_add(bytes, Ordering::Relaxed);
        Self(bytes)
    }

    /// Counts the elements of a slice.
    #[must_use]
    pub fn of<T>(buffer: &[T]) -> Self {
        Self::new(size_of_val(buffer) as u64)
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        PROCESS.taken.fetch_sub(self.0, Ordering::Relaxed);
    }
}

impl Clone for Held {
    fn clone(&self) -> Self {
        Self::new(self.0)
    }
}

impl PartialEq for Held {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn account(bytes: u64, taken: u64) -> Account {
        let account = Account::new();
        *account.bound.write().unwrap() = Some(Bound { bytes, source: Source::User });
        account.taken.store(taken, Ordering::Relaxed);
        account
    }

    #[test]
    fn what_is_taken_counts() {
        let account = account(1000, 400);
        assert_eq!(account.check(600, String::new), Ok(()));
        let refused = account.check(601, || "a frame".to_owned()).unwrap_err();
        assert_eq!((refused.needed, refused.taken), (601, 400));
        assert!(account.check(u64::MAX, String::new).is_err(), "sums do not overflow");
        assert_eq!(Account::new().check(u64::MAX, String::new), Ok(()), "without a bound nothing is refused");
    }

    #[test]
    fn a_refusal_names_need_bound_and_way_out() {
        let refused = account(2_000_000_000, 0).check(274_877_906_944, || "the decoded frame".to_owned());
        assert_eq!(
            refused.unwrap_err().to_string(),
            "the decoded frame needs 275 GB of memory, and 2.0 GB may be taken (--max-gb); take less at a time, or \
             allow more with --max-gb"
        );
        let bound = Some(Bound { bytes: 64_000_000, source: Source::ControlGroup });
        let refused = OutOfMemory { what: "x".to_owned(), needed: 999, taken: 500_000_000, bound };
        assert_eq!(
            refused.to_string(),
            "x needs 1.0 kB of memory, and 64.0 MB may be taken (what the control group of this process has free); \
             500 MB are taken already; take less at a time, or allow more with --max-gb"
        );
    }

    #[test]
    fn what_the_system_does_not_give_is_an_error_and_no_abort() {
        let refused = zeroed::<u64>(1 << 58, || "a table".to_owned()).unwrap_err();
        assert_eq!(refused.bound, None);
        assert!(refused.to_string().starts_with("a table needs 2305843009 GB of memory"), "{refused}");
        assert!(zeroed::<u64>(u64::MAX, || "a table".to_owned()).is_err());
        assert_eq!(zeroed::<f32>(3, String::new).unwrap(), [0.0; 3]);
    }

    /// Other tests of this process hold buffers at the same time. Only a size that no other test uses is conclusive.
    #[test]
    fn a_buffer_counts_as_long_as_it_lives() {
        const LARGE: u64 = 1 << 50;
        let taken = || PROCESS.taken.load(Ordering::Relaxed) / LARGE;
        let held = Held::new(LARGE);
        let copy = held.clone();
        assert_eq!(taken(), 2);
        drop(held);
        assert_eq!(taken(), 1);
        drop(copy);
        assert_eq!(taken(), 0);
        assert_eq!(Held::of(&[0_u32; 3]).0, 12);
    }
}
