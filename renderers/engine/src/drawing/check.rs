//! A check of blended pictures: a device that ends loops early draws fragments wrong.

use std::sync::OnceLock;

use cvr_core::render::{Filter, Inputs, Pass};

use crate::bindings::{Parts, Supplies};
use crate::canvas::{Canvas, blend};
use crate::raster::BoundRaster;
use crate::source::Voxels;
use crate::{Device, EngineError};

/// A pass that blends, compiled so that its fragments mark ended loops. It draws one picture before all others. The
/// pass without marks needs fewer rounds, so it needs no check.
#[derive(Debug)]
pub(super) struct Check {
    bound: BoundRaster,
    view: wgpu::TextureView,
    passed: OnceLock<()>,
}

impl Check {
    /// `None` if fragments cannot mark anything. `parts` hold the codec's uploaded buffers.
    pub(super) fn new(
        device: &Device,
        Pass { pipeline, inputs }: &Pass,
        voxels: &Voxels<'_>,
        filter: Filter,
        (canvas, parts): (&wgpu::Texture, &mut Parts),
    ) -> Result<Option<Self>, EngineError> {
        let (Some(program), Some(proxies)) = (pipeline.guarded_program(), pipeline.proxies()) else {
            return Ok(None);
        };
        let shader = voxels.shader(device, &program, Some(filter))?;
        let supplies = Supplies { inputs: &inputs.contents, buffers: &voxels.buffers, ..Supplies::default() };
        let triangles = (proxies, &inputs.vertices[..]);
        let bound = BoundRaster::new(device, triangles, &shader, canvas.format(), &supplies, parts)?;
        let view = canvas.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Some(Self { bound, view, passed: OnceLock::new() }))
    }

    /// Takes other inputs, which it has not looked at.
    pub(super) fn set_inputs(&mut self, device: &Device, inputs: &Inputs) -> Result<(), EngineError> {
        self.passed = OnceLock::new();
        self.bound.set_inputs(device, inputs)
    }

    /// Whether it has drawn and found nothing.
    pub(super) fn passed(&self) -> bool {
        self.passed.get().is_some()
    }

    /// Draws and checks, unless already done. The result is an ordinary picture.
    ///
    /// # Errors
    /// [`EngineError::CutOff`] if the device has ended loops, and errors of the driver.
    pub(super) fn pass(&self, device: &Device, canvas: &Canvas) -> Result<(), EngineError> {
        if self.passed() {
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
