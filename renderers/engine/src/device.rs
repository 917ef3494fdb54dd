//! An adapter that is open: what is asked of it, and what it can do.

use std::sync::{Arc, OnceLock};

use cvr_core::shader::BindingLimits;

use crate::adapter::{NATIVE, adapters, all_adapters, choose};
use crate::guard::Reports;
use crate::pipelines::Pipelines;
use crate::{Capabilities, DeviceChoice, DeviceInfo, EngineError, probes};

/// An open device. Clones share it.
///
/// On GL only one thread at a time may use it, also to drop what lies on it: wgpu 30 panics in a thread that has waited for the
/// context for six seconds, which a large shader takes to compile in another.
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
    /// Opens an adapter with all its limits and those optional features that this crate uses, and tries the ones that
    /// drivers are known to offer without having them.
    ///
    /// # Errors
    /// [`EngineError::NoAdapter`] when none fits, [`EngineError::Gpu`] when the driver refuses to open it.
    pub fn open(choice: &DeviceChoice) -> Result<Self, EngineError> {
        // Places are those of the whole list; else GL is asked only when nothing better fits.
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

    /// The same device under other capabilities, as a device of its own to everything but the driver.
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

    /// The same device, to be used as if its texture units decoded no blocks: the fallback can so be tried on any device.
    #[must_use]
    pub fn without_block_textures(&self) -> Self {
        let bc_sliced_3d = Err(crate::BlockFallback::NotDecoded);
        self.with_capabilities(Capabilities { bc_sliced_3d, ..self.capabilities().clone() })
    }

    /// The same device with all that its driver claims, whatever was found when it was opened.
    #[cfg(test)]
    pub(crate) fn as_claimed(&self) -> Self {
        self.with_capabilities(Capabilities::of(self.wgpu()))
    }

    /// The same device, to be used as if it bound no more than `limits`: what a codec's buffers look like on a
    /// lesser device can so be tried on this one. Limits above its own, or of no word at all, are clamped.
    #[must_use]
    pub fn with_binding_limits(&self, limits: BindingLimits) -> Self {
        let own = self.open.capabilities.binding_limits();
        let limits = BindingLimits {
            storage_words: limits.storage_words.clamp(1, own.storage_words),
            storage_buffers: limits.storage_buffers.min(own.storage_buffers),
        };
        Self { open: Arc::clone(&self.open), limits }
    }

    /// What the adapter says of itself.
    #[must_use]
    pub fn info(&self) -> &DeviceInfo {
        &self.open.info
    }

    /// What it can do, as far as drawing is concerned.
    #[must_use]
    pub fn capabilities(&self) -> &Capabilities {
        &self.open.capabilities
    }

    /// Whether sums can be blended in single precision: the driver says so, and did it once, when this was first asked.
    /// Where it cannot, they are blended in half.
    #[must_use]
    pub fn blends_single(&self) -> bool {
        *self.open.blends_single.get_or_init(|| {
            self.capabilities().float32_blendable && probes::blends(self, wgpu::TextureFormat::Rgba32Float)
        })
    }

    /// What the shader generator must keep to.
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
