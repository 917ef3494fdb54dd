//! Buffers back into memory.

use std::sync::mpsc;
use std::time::Duration;

use bytemuck::Pod;

use crate::{Device, EngineError};

/// Longest time for a result that is already complete.
const ANSWER: Duration = Duration::from_secs(10);

impl Device {
    /// The first `bytes` of a buffer (a multiple of 4, not 0) as a vector, after all submitted work is done.
    pub(crate) fn read_buffer<T: Pod>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
    ) -> Result<Vec<T>, EngineError> {
        self.guarded("reading back", || {
            let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
            let staging = self.empty_buffer("read-back", usage, bytes)?;
            let mut encoder = self.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
            self.queue().submit([encoder.finish()]);
            self.map_and_read(&staging)
        })
    }

    /// Everything in a mappable buffer. Unmaps it again. Call it inside a guard.
    pub(crate) fn map_and_read<T: Pod>(&self, staging: &wgpu::Buffer) -> Result<Vec<T>, EngineError> {
        let (done, mapped) = mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver outlives the wait below. A later callback finds no receiver.
            let _ = done.send(result);
        });
        self.wait()?;
        // Another thread that polls at the same time may have taken the callback and may be about to run it. So the
        // result can come shortly after the wait.
        match mapped.recv_timeout(ANSWER) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(EngineError::Gpu(format!("mapping a buffer: {error}"))),
            Err(_) => return Err(EngineError::Gpu("mapping a buffer: the driver gave no answer".to_owned())),
        }
        let values = staging
            .get_mapped_range(..)
            .map(|view| bytemuck::pod_collect_to_vec(&view))
            .map_err(|e| EngineError::Gpu(format!("reading a mapped buffer: {e}")));
        staging.unmap();
        values
    }
}
