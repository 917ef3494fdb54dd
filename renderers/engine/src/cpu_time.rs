//! CPU time of this process, in nanoseconds where the system tells it.

use std::time::Duration;

/// CPU time that all living threads of this process have used; `None` where the system does not tell.
///
/// Linux: the sum of `/proc/self/task/*/schedstat`, in nanoseconds (`/proc/self/stat` counts ticks of 10 ms,
/// longer than many a frame). A thread that ends takes its time with it; drivers and thread pools keep theirs.
pub(crate) fn process_cpu_time() -> Option<Duration> {
    let mut total = 0;
    for thread in std::fs::read_dir("/proc/self/task").ok()? {
        // A thread may end between listing and reading.
        let Ok(text) = std::fs::read_to_string(thread.ok()?.path().join("schedstat")) else { continue };
        total += text.split_ascii_whitespace().next()?.parse::<u64>().ok()?;
    }
    (total > 0).then(|| Duration::from_nanos(total))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_of_any_thread_counts() {
        let Some(before) = process_cpu_time() else { return };
        let spin = || {
            let start = std::time::Instant::now();
            while start.elapsed() < Duration::from_millis(40) {
                std::hint::spin_loop();
            }
            process_cpu_time()
        };
        let after = std::thread::spawn(spin).join().unwrap().unwrap();
        // Other tests may run beside; a busy machine may give this thread less than all of its time.
        assert!(after > before + Duration::from_millis(4), "{before:?} {after:?}");
    }
}
