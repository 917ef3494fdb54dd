//! Driver errors as values: every call into wgpu that can fail runs inside [`Device::guarded`].

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::{Device, EngineError};

impl Device {
    /// Runs `calls` with scopes for every kind of driver error. The message of an error begins with `step`.
    ///
    /// Scopes belong to a thread, so drawings on several threads do not see each other's errors. `calls` must not pass
    /// wgpu work to other threads.
    pub(crate) fn guarded<T>(
        &self,
        step: &str,
        calls: impl FnOnce() -> Result<T, EngineError>,
    ) -> Result<T, EngineError> {
        self.check_alive()?;
        let device = self.wgpu();
        let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
        let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let result = calls();
        // On native backends these futures are ready at once. All three are popped before the first error returns,
        // innermost first, as wgpu requires.
        let validation = pollster::block_on(validation.pop());
        let internal = pollster::block_on(internal.pop());
        let memory = pollster::block_on(memory.pop());
        // Only a callback reports a loss, and callbacks run when the device is polled.
        self.poll(wgpu::PollType::Poll)?;
        self.check_alive()?;
        if let Some(error) = memory {
            return Err(EngineError::OutOfMemory(format!("{step}: {}", with_source(&error))));
        }
        if let Some(error) = validation.or(internal) {
            return Err(EngineError::Gpu(format!("{step}: {}", with_source(&error))));
        }
        if let Some(text) = self.reports().take_uncaptured() {
            return Err(EngineError::Gpu(format!("{step}: {text}")));
        }
        result
    }

    /// Why the device is lost. Every later call on it fails. `None` if it works.
    #[must_use]
    pub fn lost(&self) -> Option<String> {
        self.reports().lost()
    }

    /// Fails once the device is gone.
    fn check_alive(&self) -> Result<(), EngineError> {
        self.lost().map_or(Ok(()), |reason| Err(EngineError::DeviceLost(reason)))
    }

    /// Waits until all submitted work is done and its callbacks have run.
    pub(crate) fn wait(&self) -> Result<(), EngineError> {
        self.poll(wgpu::PollType::wait_indefinitely())
    }

    fn poll(&self, how: wgpu::PollType) -> Result<(), EngineError> {
        // wgpu panics if the wait itself fails, for instance when a device is lost under a running shader. It holds no
        // lock and leaves no incomplete state of this crate, so unwinding is safe here.
        match catch_unwind(AssertUnwindSafe(|| self.wgpu().poll(how))) {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(EngineError::Gpu(format!("waiting for the device: {error}"))),
            Err(panic) => {
                let text = panic.downcast_ref::<String>().map_or("waiting failed", String::as_str);
                self.reports().set_lost(text.trim().to_owned());
                Err(EngineError::DeviceLost(text.trim().to_owned()))
            }
        }
    }
}

/// Out-of-memory errors have their reason only in the source.
fn with_source(error: &wgpu::Error) -> String {
    let mut text = error.to_string();
    if matches!(error, wgpu::Error::OutOfMemory { .. })
        && let Some(source) = std::error::Error::source(error)
    {
        text = format!("{text}: {source}");
    }
    text.trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{another_device, test_device};

    #[test]
    fn a_validation_error_is_a_value_and_the_device_lives_on() {
        let Some(device) = test_device("guard::validation_error") else { return };
        let broken = || {
            let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::STORAGE;
            let bad = wgpu::BufferDescriptor { label: None, size: 3, usage, mapped_at_creation: true };
            Ok(device.wgpu().create_buffer(&bad))
        };
        let error = device.guarded("a bad buffer", broken).unwrap_err();
        assert!(matches!(&error, EngineError::Gpu(text) if text.starts_with("a bad buffer: ")), "{error}");
        device.guarded("nothing", || Ok(())).unwrap();
    }

    #[test]
    fn wrong_wgsl_is_an_error_with_text() {
        let Some(device) = test_device("guard::wrong_wgsl") else { return };
        let source = wgpu::ShaderSource::Wgsl("fn f() -> u32 { return 1.5; }".into());
        let module = wgpu::ShaderModuleDescriptor { label: None, source };
        let broken = || Ok(device.wgpu().create_shader_module(module));
        let error = device.guarded("shader", broken).unwrap_err();
        assert!(matches!(&error, EngineError::Gpu(text) if text.contains("return")), "{error}");
    }

    #[test]
    fn a_lost_device_fails_every_later_call() {
        // Its own device, since it dies.
        if test_device("guard::lost_device").is_none() {
            return;
        }
        let device = another_device();
        device.guarded("before", || Ok(())).unwrap();
        device.wgpu().destroy();
        for _ in 0..2 {
            let usage = wgpu::BufferUsages::STORAGE;
            let buffer = wgpu::BufferDescriptor { label: None, size: 16, usage, mapped_at_creation: false };
            let create = || Ok(device.wgpu().create_buffer(&buffer));
            let error = device.guarded("after", create).unwrap_err();
            assert!(matches!(error, EngineError::DeviceLost(_)), "{error}");
        }
    }

    #[test]
    fn an_impossible_buffer_is_an_error() {
        let Some(device) = test_device("guard::impossible_buffer") else { return };
        let size = device.wgpu().limits().max_buffer_size + 4;
        let usage = wgpu::BufferUsages::STORAGE;
        let buffer = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        let create = || Ok(device.wgpu().create_buffer(&buffer));
        let error = device.guarded("a huge buffer", create).unwrap_err();
        assert!(matches!(error, EngineError::Gpu(_) | EngineError::OutOfMemory(_)), "{error}");
    }
}
