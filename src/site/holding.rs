//! The interface of every way of holding a volume.

use std::fmt::Debug;
use std::sync::Arc;

use cvr_core::codec::Site;
use cvr_core::render::{DecodedFrame, Plan, RenderError, Renderer, View};
use cvr_core::shader::Source;
use cvr_core::volume::VolumeLayout;
use cvr_engine::{DrawSource, Drawing, EngineError};

use super::coded::CodedFrame;
use super::expected::{Checked, Expected};
use super::target::{DrawError, Target};

/// Decodes the frame on the CPU, or returns the decoded one.
pub type DecodeOnCpu<'a> = &'a dyn Fn() -> Result<Arc<DecodedFrame>, String>;

/// Names what holds a frame on a target. The error is a sentence about why the target cannot hold it.
pub type SayHolder = fn(CodedFrame<'_>, &Target) -> Result<String, String>;

/// A way of holding a volume.
///
/// It does not decide whether a codec and a renderer can be combined with it. That follows from the properties of its
/// [`Site`], in [`cvr_core::pipeline::unsupported`] and [`cvr_core::pipeline::undrawable`].
pub trait Holding: Sync {
    /// Its site.
    fn site(&self) -> Site;

    /// The passes that draw a view from it.
    ///
    /// # Errors
    /// As [`Renderer::plan`].
    fn plan(&self, renderer: &dyn Renderer, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
        renderer.plan(view, layout)
    }

    /// Prepares a frame for drawing on a target. `timed` is true if a run reports the time; the frame may then be
    /// prepared several times.
    ///
    /// # Errors
    /// When the frame cannot be decoded, or the target refuses it or cannot hold it.
    fn prepare(
        &self,
        target: &Target,
        coded: CodedFrame<'_>,
        decoded: DecodeOnCpu<'_>,
        timed: bool,
    ) -> Result<Arc<dyn HeldFrame>, DrawError>;

    /// The voxel source for the shaders of a plan, if `target` draws.
    ///
    /// # Errors
    /// A sentence, when codec or target refuse.
    fn source<'a>(&self, coded: CodedFrame<'a>, plan: &Plan, target: &Target) -> Result<Source<'a>, String>;

    /// The texts of the passes that decode before or between the passes of a plan, for a device with the limits that
    /// every device offers.
    ///
    /// # Errors
    /// A sentence, when the codec or the generator refuses.
    fn passes(&self, _coded: CodedFrame<'_>, _plan: &Plan) -> Result<Vec<String>, String> {
        Ok(Vec::new())
    }

    /// Bytes on a device for a frame of a volume of this layout. `trial` is a similar small frame.
    ///
    /// # Errors
    /// A sentence, when the stream lacks what a shader reads.
    fn device_bytes(
        &self,
        trial: CodedFrame<'_>,
        target: &Target,
        layout: &VolumeLayout,
    ) -> Result<f64, String>;

    /// Names what holds a frame on a target, if that depends on codec and target.
    fn holder(&self) -> Option<SayHolder> {
        None
    }

    /// Whether a device decodes the voxels that it draws. A picture of the CPU mirror does not test this.
    fn device_decodes(&self, _coded: CodedFrame<'_>) -> bool {
        self.site().decoded_by().on_device()
    }

    /// A remark for the record if the CPU mirror draws.
    fn mirror_remark(&self) -> Option<&'static str> {
        None
    }

    /// Whether a run draws and times a cell although the device decodes other voxels than the CPU, so that the error
    /// can be seen. The cell fails in any case.
    fn draws_mismatches(&self) -> bool {
        false
    }
}

/// A frame held by a site on one target, ready for drawing. Pictures share it. Its memory is freed with the last of
/// them.
pub trait HeldFrame: Debug + Send + Sync {
    /// The frame for the CPU mirror. `None` if it decodes at every fetch.
    fn decoded(&self) -> Option<Arc<DecodedFrame>> {
        None
    }

    /// The voxel source for a device.
    ///
    /// # Errors
    /// When the frame is not held on a device.
    fn source<'a>(&self, coded: CodedFrame<'a>) -> Result<DrawSource<'a>, EngineError>;

    /// Compares every voxel with the CPU decoder, as it is held, or as the shader of the site fetches it. `None` if the
    /// target decodes nothing, or decodes only while it draws. With `as_cells`, voxels are also read through the
    /// codec's `fetch_cell`, if the site calls it.
    ///
    /// # Errors
    /// A sentence, when the device fails.
    fn check(
        &self,
        _target: &Target,
        _expected: &Expected<'_>,
        _as_cells: bool,
    ) -> Result<Option<Checked>, String> {
        Ok(None)
    }

    /// The same for voxels that are decoded during a drawing. `None` if there are none.
    ///
    /// # Errors
    /// A sentence, when the device fails.
    fn check_drawing(&self, _drawing: &Drawing, _expected: &Expected<'_>) -> Result<Option<Checked>, String> {
        Ok(None)
    }

    /// Time and fallbacks of the preparation.
    fn preparation(&self) -> Preparation {
        Preparation::default()
    }

    /// Whether it holds memory in addition to the stream.
    fn holds_memory(&self) -> bool {
        true
    }
}

/// Results of preparing a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preparation {
    /// Milliseconds in which the device decodes the frame, if it was timed.
    pub device_decode_ms: Option<f64>,
    /// Bytes on the device while it decodes.
    pub device_decode_bytes: Option<u64>,
    /// Fallbacks, and other remarks for the record.
    pub remarks: Vec<String>,
}

/// A frame for the CPU mirror. A device cannot draw from it.
#[derive(Debug)]
pub(super) struct MirrorFrame(Arc<DecodedFrame>);

impl MirrorFrame {
    pub(super) fn held(decoded: DecodeOnCpu<'_>) -> Result<Arc<dyn HeldFrame>, DrawError> {
        Ok(Arc::new(Self(decoded().map_err(DrawError::Frame)?)))
    }
}

impl HeldFrame for MirrorFrame {
    fn decoded(&self) -> Option<Arc<DecodedFrame>> {
        Some(self.0.clone())
    }

    fn source<'a>(&self, _coded: CodedFrame<'a>) -> Result<DrawSource<'a>, EngineError> {
        Err(EngineError::Unsupported("the decoded frame does not lie on this device".to_owned()))
    }
}
