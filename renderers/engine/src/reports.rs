//! Driver errors that come by callback: what a device reported outside of any scope, and its loss.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What the device reported. Shared with wgpu's callbacks, which may run on any thread.
#[derive(Debug, Default)]
pub(crate) struct Reports {
    lost: Mutex<Option<String>>,
    uncaptured: Mutex<Option<String>>,
}

impl Reports {
    /// Installs the callbacks of a new device. Without them, wgpu panics on an error outside a scope.
    pub(crate) fn of(device: &wgpu::Device) -> Arc<Self> {
        let reports = Arc::new(Self::default());
        let lost = Arc::clone(&reports);
        device.set_device_lost_callback(move |reason, message| {
            lost.set_lost(format!("{reason:?}: {}", message.trim()));
        });
        let uncaptured = Arc::clone(&reports);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let mut first = lock(&uncaptured.uncaptured);
            first.get_or_insert_with(|| error.to_string());
        }));
        reports
    }

    /// Records a loss; the first reason stays.
    pub(crate) fn set_lost(&self, reason: String) {
        lock(&self.lost).get_or_insert(reason);
    }

    pub(crate) fn lost(&self) -> Option<String> {
        lock(&self.lost).clone()
    }

    pub(crate) fn take_uncaptured(&self) -> Option<String> {
        lock(&self.uncaptured).take()
    }
}

/// A poisoned lock holds a whole message all the same.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
