//! Uploads large data in pieces, so that staging memory stays bounded.

use crate::{Device, EngineError};

/// Bytes staged at a time. wgpu keeps a copy of everything written until the next submission is done.
pub(crate) const SLAB_BYTES: usize = 32 << 20;

impl Device {
    /// A buffer of these bytes. Their number is a multiple of 4 and not 0. Call it inside a guard.
    pub(crate) fn filled_buffer(
        &self,
        label: &str,
        usage: wgpu::BufferUsages,
        bytes: &[u8],
    ) -> Result<wgpu::Buffer, EngineError> {
        let size = bytes.len() as u64;
        let buffer = self.empty_buffer(label, usage | wgpu::BufferUsages::COPY_DST, size)?;
        for (i, slab) in bytes.chunks(SLAB_BYTES).enumerate() {
            self.queue().write_buffer(&buffer, (i * SLAB_BYTES) as u64, slab);
            self.flush(bytes.len() > SLAB_BYTES)?;
        }
        Ok(buffer)
    }

    /// A zeroed buffer. Call it inside a guard.
    pub(crate) fn empty_buffer(
        &self,
        label: &str,
        usage: wgpu::BufferUsages,
        size: u64,
    ) -> Result<wgpu::Buffer, EngineError> {
        let limit = self.capabilities().buffer_bytes;
        if size > limit {
            let what = format!("a buffer of `{label}`");
            return Err(EngineError::TooLarge { what, requested: size, limit, unit: "bytes" });
        }
        let label = Some(label);
        Ok(self.wgpu().create_buffer(&wgpu::BufferDescriptor {
            label,
            size,
            usage,
            mapped_at_creation: false,
        }))
    }

    /// Submits what was written so far, if more follows than should be staged at once.
    pub(crate) fn flush(&self, much: bool) -> Result<(), EngineError> {
        if much {
            self.queue().submit([]);
            self.wait()?;
        }
        Ok(())
    }
}
