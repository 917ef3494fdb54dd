//! A look at what is blended: a device that ends loops before they are done draws fragments wrong.

use std::sync::OnceLock;

use cvr_core::render::{Filter, RasterPass};

use super::canvas::Canvas;
use crate::bindings::{Parts, Supplies};
use crate::raster::{BoundRaster, blend};
use crate::source::Voxels;
use crate::{Device, EngineError};

/// A pass that blends, compiled so that its fragments tell where loops were ended. It draws one frame, before all others: what
/// does the same in fewer rounds needs no second look.
#[derive(Debug)]
pub(super) struct Check {
    bound: BoundRaster,
    view: wgpu::TextureView,
    passed: OnceLock<()>,
}

impl Check {
    /// `None` where fragments cannot tell. `parts` hold the codec's buffers, which are uploaded already.
    pub(super) fn new(
        device: &Device,
        pass: &RasterPass,
        voxels: &Voxels<'_>,
        filter: Filter,
        (canvas, parts): (&wgpu::Texture, &mut Parts),
    ) -> Result<Option<Self>, EngineError> {
        let Some(pass) = pass.checked() else { return Ok(None) };
        let bindings: Vec<_> = pass.inputs.iter().map(|input| input.kind.clone()).collect();
        let template = (&pass.templates[..], pass.fragment, &bindings[..]);
        let shader = voxels.shader(template, Some(filter), device.binding_limits())?;
        let supplies = Supplies { inputs: &pass.inputs, buffers: &voxels.buffers, ..Supplies::default() };
        let bound = BoundRaster::new(device, &pass, &shader, canvas.format(), &supplies, parts)?;
        let view = canvas.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Some(Self { bound, view, passed: OnceLock::new() }))
    }

    /// Draws and looks, unless that is done.
    ///
    /// # Errors
    /// [`EngineError::CutOff`] when the device has ended loops; what the driver refuses.
    pub(super) fn pass(&self, device: &Device, canvas: &Canvas) -> Result<(), EngineError> {
        if self.passed.get().is_some() {
            return Ok(());
        }
        device.guarded("drawing a frame that is looked at", || {
            let mut encoder =
                device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = blend(&mut encoder, &self.view, true, None);
            self.bound.draw(&mut pass);
            drop(pass);
            device.queue().submit([encoder.finish()]);
            Ok(())
        })?;
        match canvas.below_zero(device)? {
            0 => {
                self.passed.get_or_init(|| ());
                Ok(())
            }
            pixels => Err(EngineError::CutOff { pixels }),
        }
    }
}
