//! An open adapter: its requested features and its capabilities.

use std::sync::{Arc, OnceLock};

use cvr_core::shader::BindingLimits;

use crate::pipelines::Pipelines;
use crate::reports::Reports;
use crate::{Capabilities, DeviceInfo};

/// An open device. Clones share it.
///
/// On GL, only one thread at a time may use it or drop its resources. wgpu 30 panics in a thread that waits six seconds
/// for the context, and compiling a large shader in another thread takes longer.
#[derive(Clone, Debug)]
pub struct Device {
    open: Arc<Open>,
    limits: BindingLimits,
}

#[derive(Debug)]
struct Open {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: DeviceInfo,
    capabilities: Capabilities,
    blends_single: OnceLock<bool>,
    reports: Arc<Reports>,
    pipelines: Pipelines,
}

impl Device {
    /// What a driver has opened, with all that it claims.
    pub(crate) fn claimed(device: wgpu::Device, queue: wgpu::Queue, info: DeviceInfo) -> Self {
        let reports = Reports::of(&device);
        let capabilities = Capabilities::of(&device);
        let limits = capabilities.binding_limits();
        let (blends_single, pipelines) = (OnceLock::new(), Pipelines::default());
        let open = Open { device, queue, info, capabilities, blends_single, reports, pipelines };
        Self { open: Arc::new(open), limits }
    }

    /// The same device with other capabilities. Only the driver is shared.
    pub(crate) fn with_capabilities(&self, capabilities: Capabilities) -> Self {
        let Open { device, queue, info, reports, .. } = &*self.open;
        let open = Open {
            device: device.clone(),
            queue: queue.clone(),
            info: info.clone(),
            capabilities,
            blends_single: OnceLock::new(),
            reports: Arc::clone(reports),
            pipelines: Pipelines::default(),
        };
        Self { open: Arc::new(open), limits: self.limits }
    }

    /// The same device, used as if its texture units decoded no blocks. The fallback can thus be tested on any device.
    #[must_use]
    pub fn without_block_textures(&self) -> Self {
        let bc_sliced_3d = Err(crate::BlockFallback::NotDecoded);
        self.with_capabilities(Capabilities { bc_sliced_3d, ..self.capabilities().clone() })
    }

    /// The same device with all capabilities that its driver claims, regardless of the probes.
    #[cfg(test)]
    pub(crate) fn as_claimed(&self) -> Self {
        self.with_capabilities(Capabilities::of(self.wgpu()))
    }

    /// The same device, used as if its binding limits were `limits`. Buffers of a smaller device can thus be tested.
    /// Limits above its own, or of zero words, are clamped.
    #[must_use]
    pub fn with_binding_limits(&self, limits: BindingLimits) -> Self {
        let own = self.open.capabilities.binding_limits();
        let limits = BindingLimits {
            storage_words: limits.storage_words.clamp(1, own.storage_words),
            storage_buffers: limits.storage_buffers.min(own.storage_buffers),
        };
        Self { open: Arc::clone(&self.open), limits }
    }

    /// Description of the adapter.
    #[must_use]
    pub fn info(&self) -> &DeviceInfo {
        &self.open.info
    }

    /// Its capabilities for drawing.
    #[must_use]
    pub fn capabilities(&self) -> &Capabilities {
        &self.open.capabilities
    }

    /// What the shader generator must keep to.
    #[must_use]
    pub const fn binding_limits(&self) -> BindingLimits {
        self.limits
    }

    /// Whether sums are blended in single precision, once that is known.
    pub(crate) fn known_blending(&self) -> &OnceLock<bool> {
        &self.open.blends_single
    }

    pub(crate) fn wgpu(&self) -> &wgpu::Device {
        &self.open.device
    }

    pub(crate) fn queue(&self) -> &wgpu::Queue {
        &self.open.queue
    }

    pub(crate) fn pipelines(&self) -> &Pipelines {
        &self.open.pipelines
    }

    pub(crate) fn reports(&self) -> &Reports {
        &self.open.reports
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::test_device;

    #[test]
    fn limits_are_those_of_the_adapter_not_the_defaults() {
        let Some(device) = test_device("device::limits") else { return };
        println!("{}: {:?}", device.info(), device.capabilities());
        let limits = device.binding_limits();
        assert!(limits.storage_words >= (128 << 20) / 4 && limits.storage_buffers >= 8, "{limits:?}");
    }
}
