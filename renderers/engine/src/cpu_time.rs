//! CPU time of this process.

use std::time::Duration;

/// CPU time of all threads of this process, ended ones included, in nanoseconds. `None` if the system does not report
/// it. The ticks of `/proc/self/stat` are too long: a picture often takes less than one.
#[cfg(any(target_os = "linux", target_os = "macos"))]
#[must_use]
pub fn process_cpu_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(Duration::new(time.tv_sec.try_into().ok()?, time.tv_nsec.try_into().ok()?))
}

/// `None`: this system does not report it.
#[cfg(not(any(target_os = "linux", target_os = "macos")))]
#[must_use]
pub fn process_cpu_time() -> Option<Duration> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_of_a_thread_that_ended_counts() {
        let Some(before) = process_cpu_time() else { return };
        let spin = || {
            let start = std::time::Instant::now();
            while start.elapsed() < Duration::from_millis(40) {
                std::hint::spin_loop();
            }
        };
        std::thread::spawn(spin).join().unwrap();
        // On a busy machine the thread may get only a part of the time.
        assert!(process_cpu_time().unwrap() > before + Duration::from_millis(2));
    }
}
