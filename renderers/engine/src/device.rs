//! An open adapter: its requested features and its capabilities.

use std::sync::{Arc, OnceLock};

use cvr_core::shader::BindingLimits;

use crate::adapter::{NATIVE, adapters, all_adapters, choose};
use crate::guard::Reports;
use crate::pipelines::Pipelines;
use crate::{Capabilities, DeviceChoice, DeviceInfo, EngineError, probes};

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
    /// Opens an adapter with all its limits and the optional features that this crate uses. Tests those features that
    /// some drivers claim but do not implement.
    ///
    /// # Errors
    /// [`EngineError::NoAdapter`] when none fits, [`EngineError::Gpu`] when the driver refuses to open it.
    pub fn open(choice: &DeviceChoice) -> Result<Self, EngineError> {
        // Indices refer to the whole list. Otherwise GL is queried only if nothing better fits.
        let mut candidates = match choice {
            DeviceChoice::Index(_) => all_adapters(),
            DeviceChoice::Backend(backend) => adapters(backend.flag()),
            DeviceChoice::Auto | DeviceChoice::Named(_) => adapters(NATIVE),
        };
        let describe = |adapters: &[wgpu::Adapter]| adapters.iter().map(DeviceInfo::of).collect::<Vec<_>>();
        let mut infos = describe(&candidates);
        if choose(choice, &infos).is_none() {
            candidates = all_adapters();
            infos = describe(&candidates);
        }
        let Some(taken) = choose(choice, &infos) else {
            return Err(EngineError::NoAdapter {
                wanted: (*choice != DeviceChoice::Auto).then(|| choice.to_string()),
                known: infos.iter().map(ToString::to_string).collect(),
            });
        };
        Self::open_adapter(&candidates[taken], infos[taken].clone())
    }

    fn open_adapter(adapter: &wgpu::Adapter, info: DeviceInfo) -> Result<Self, EngineError> {
        let wanted = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM
            | wgpu::Features::FLOAT32_FILTERABLE
            | wgpu::Features::FLOAT32_BLENDABLE
            | wgpu::Features::TEXTURE_COMPRESSION_BC
            | wgpu::Features::TEXTURE_COMPRESSION_BC_SLICED_3D
            | wgpu::Features::TIMESTAMP_QUERY;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("cvr"),
            required_features: adapter.features() & wanted,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| EngineError::Gpu(format!("opening {info}: {e}")))?;
        let reports = Reports::of(&device);
        let capabilities = Capabilities::of(&device);
        let claimed = Self::of(Open {
            device,
            queue,
            info,
            capabilities,
            blends_single: OnceLock::new(),
            reports,
            pipelines: Pipelines::default(),
        });
        let capabilities = probes::of(&claimed);
        Ok(claimed.with_capabilities(capabilities))
    }

    fn of(open: Open) -> Self {
        let limits = open.capabilities.binding_limits();
        Self { open: Arc::new(open), limits }
    }

    /// The same device with other capabilities. Only the driver is shared.
    fn with_capabilities(&self, capabilities: Capabilities) -> Self {
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

    /// Whether sums can be blended in single precision: the driver claims it, and a probe at the first call succeeded.
    /// If not, half precision is used.
    #[must_use]
    pub fn blends_single(&self) -> bool {
        *self.open.blends_single.get_or_init(|| {
            self.capabilities().float32_blendable && probes::blends(self, wgpu::TextureFormat::Rgba32Float)
        })
    }

    /// Limits for the shader generator.
    #[must_use]
    pub const fn binding_limits(&self) -> BindingLimits {
        self.limits
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
    use super::*;
    use crate::testing::test_device;

    #[test]
    fn an_unknown_name_lists_the_adapters_that_exist() {
        let Some(device) = test_device("device::unknown_name") else { return };
        let wanted = DeviceChoice::Named("no such adapter".to_owned());
        let Err(EngineError::NoAdapter { known, .. }) = Device::open(&wanted) else { panic!("it opened") };
        assert!(known.contains(&device.info().to_string()), "{known:?}");
    }

    #[test]
    fn limits_are_those_of_the_adapter_not_the_defaults() {
        let Some(device) = test_device("device::limits") else { return };
        println!("{}: {:?}", device.info(), device.capabilities());
        let limits = device.binding_limits();
        assert!(limits.storage_words >= (128 << 20) / 4 && limits.storage_buffers >= 8, "{limits:?}");
    }
}
