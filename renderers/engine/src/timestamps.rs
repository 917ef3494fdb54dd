//! Timing passes on the device, and when to believe it.

use std::time::{Duration, Instant};

use crate::cpu_time::process_cpu_time;
use crate::timing::FrameTime;
use crate::{Device, EngineError};

/// Runs `submit`, which submits work to the device, and waits for it. The message of an error begins with `step`. The
/// device's own time is returned only if it agrees with the wall clock.
pub(crate) fn timed(
    device: &Device,
    step: &str,
    timestamps: Option<&FrameTimestamps>,
    submit: impl FnOnce() -> Result<(), EngineError>,
) -> Result<FrameTime, EngineError> {
    device.guarded(step, || {
        let cpu_before = process_cpu_time();
        let start = Instant::now();
        submit()?;
        device.wait()?;
        let wall_ms = milliseconds(start.elapsed());
        let cpu = process_cpu_time().zip(cpu_before).and_then(|(now, before)| now.checked_sub(before));
        let gpu_ms = match timestamps {
            Some(timestamps) => accepted(timestamps.read_ms(device)?, wall_ms),
            None => None,
        };
        Ok(FrameTime { wall_ms, gpu_ms, cpu_ms: cpu.map(milliseconds) })
    })
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1000.0
}

/// The device's own time of a picture in milliseconds, from the start of the first pass to the end of the last, if it
/// is plausible. It is compared with the wall clock around encode, submit and wait.
///
/// Some drivers report nonsense (0.04 ms for a picture that takes 104 ms). A plausible time is positive and at most the
/// wall clock (plus 5 % for two clocks). It is shorter by at most the cost of submission and waiting: 1 ms, or half of
/// a long time.
pub(crate) fn accepted(gpu_ms: f64, wall_ms: f64) -> Option<f64> {
    let believable = gpu_ms > 0.0 && gpu_ms <= wall_ms * 1.05 && wall_ms - gpu_ms <= (0.5 * wall_ms).max(1.0);
    believable.then_some(gpu_ms)
}

/// A pair of timestamps around the passes of one picture.
#[derive(Debug)]
pub(crate) struct FrameTimestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
    period_ns: f64,
}

const BYTES: u64 = 16;

impl FrameTimestamps {
    /// `None` if the device has no timestamps. Call it inside a guard.
    pub(crate) fn new(device: &Device) -> Result<Option<Self>, EngineError> {
        if !device.capabilities().timestamps {
            return Ok(None);
        }
        let queries = device.wgpu().create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("frame time"),
            ty: wgpu::QueryType::Timestamp,
            count: 2,
        });
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = device.empty_buffer("frame time", usage, BYTES)?;
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let staging = device.empty_buffer("frame time read-back", usage, BYTES)?;
        let period_ns = f64::from(device.queue().get_timestamp_period());
        Ok(Some(Self { queries, resolved, staging, period_ns }))
    }

    /// The timestamps that pass `index` of `passes` writes, if it is a compute pass.
    pub(crate) fn writes(&self, index: usize, passes: usize) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let [begin, end] = written(index, passes)?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }

    /// The same for a render pass.
    pub(crate) fn render_writes(
        &self,
        index: usize,
        passes: usize,
    ) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let [begin, end] = written(index, passes)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }

    /// After the last pass.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, BYTES);
    }

    /// Milliseconds between the two, after the picture is done. Call it inside a guard.
    pub(crate) fn read_ms(&self, device: &Device) -> Result<f64, EngineError> {
        let ticks: Vec<u64> = device.map_and_read(&self.staging)?;
        let [start, end] = ticks[..] else { return Ok(f64::NAN) };
        Ok(end.wrapping_sub(start) as f64 * self.period_ns / 1e6)
    }
}

/// The query that each end of a pass writes. The first pass begins the time, the last ends it.
fn written(index: usize, passes: usize) -> Option<[Option<u32>; 2]> {
    let (first, last) = (index == 0, index + 1 == passes);
    (first || last).then_some([first.then_some(0), last.then_some(1)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_believable_times_are_accepted() {
        for (gpu, wall, believable) in [
            (100.0, 104.0, true),
            (104.5, 104.0, true),
            (52.0, 104.0, true),
            (51.0, 104.0, false),
            (0.04, 104.0, false),
            (0.04, 0.2, true),
            (0.04, 1.1, false),
            (1.1, 2.0, true),
            (110.0, 104.0, false),
            (0.0, 0.2, false),
            (-3.0, 0.2, false),
            (f64::NAN, 1.0, false),
            (f64::INFINITY, 1.0, false),
        ] {
            assert_eq!(accepted(gpu, wall), believable.then_some(gpu), "{gpu} of {wall}");
        }
    }
}
