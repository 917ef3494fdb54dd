//! Opening an adapter: which one, what is asked of it, and what it does of all that it claims.

use crate::adapter::{NATIVE, adapters, all_adapters, choose};
use crate::{Device, DeviceChoice, DeviceInfo, EngineError, probes};

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
        let claimed = Self::claimed(device, queue, info);
        let capabilities = probes::of(&claimed);
        Ok(claimed.with_capabilities(capabilities))
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
}
