//! The questions that every way of holding a volume answers.

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

/// Decodes the frame on the CPU, or gives what has been decoded.
pub type DecodeOnCpu<'a> = &'a dyn Fn() -> Result<Arc<DecodedFrame>, String>;

/// Says what holds a frame on a target; or, in a sentence, why the target cannot hold it.
pub type SayHolder = fn(CodedFrame<'_>, &Target) -> Result<String, String>;

/// A way of holding a volume.
///
/// Whether a codec and a renderer can be combined with it is no question to it: that follows from the properties of its
/// [`Site`], in [`cvr_core::pipeline::unsupported`] and [`cvr_core::pipeline::undrawable`].
pub trait Holding: Sync {
    /// The site that it stands for.
    fn site(&self) -> Site;

    /// The passes that draw a view from it.
    ///
    /// # Errors
    /// As [`Renderer::plan`].
    fn plan(&self, renderer: &dyn Renderer, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
        renderer.plan(view, layout)
    }

    /// Makes a frame drawable on a target. Where a run is to report what that takes, `timed` is true; it may then be made
    /// several times over.
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

    /// What the shaders of a plan are generated for, were `target` to draw.
    ///
    /// # Errors
    /// A sentence, when codec or target refuse.
    fn source<'a>(&self, coded: CodedFrame<'a>, plan: &Plan, target: &Target) -> Result<Source<'a>, String>;

    /// The texts of the passes that decode before those of a plan draw, or between them, on a device that offers what every
    /// device does.
    ///
    /// # Errors
    /// A sentence, when the codec or the generator refuses.
    fn passes(&self, _coded: CodedFrame<'_>, _plan: &Plan) -> Result<Vec<String>, String> {
        Ok(Vec::new())
    }

    /// Bytes on a device for a frame of a volume of this layout, of which `trial` is a small likeness.
    ///
    /// # Errors
    /// A sentence, when the stream lacks what a shader reads.
    fn device_bytes(
        &self,
        trial: CodedFrame<'_>,
        target: &Target,
        layout: &VolumeLayout,
    ) -> Result<f64, String>;

    /// What says what holds a frame on a target, where that depends on codec and target.
    fn holder(&self) -> Option<SayHolder> {
        None
    }

    /// Whether a device decodes what is drawn. A picture of the CPU mirror then leaves that untried.
    fn device_decodes(&self, _coded: CodedFrame<'_>) -> bool {
        self.site().decoded_by().on_device()
    }

    /// What a record notes where the CPU mirror draws.
    fn mirror_remark(&self) -> Option<&'static str> {
        None
    }

    /// Whether a run draws and times a cell although the device decodes other voxels than the CPU, so that the fault can be
    /// looked at. The cell fails all the same.
    fn draws_mismatches(&self) -> bool {
        false
    }
}

/// A frame as a site holds it on one target, ready to be drawn from. Pictures share it; its memory is freed with the last
/// of them.
pub trait HeldFrame: Debug + Send + Sync {
    /// What the CPU mirror draws from; `None` where it decodes at every fetch.
    fn decoded(&self) -> Option<Arc<DecodedFrame>> {
        None
    }

    /// What a device draws from.
    ///
    /// # Errors
    /// When the frame is not held on a device.
    fn source<'a>(&self, coded: CodedFrame<'a>) -> Result<DrawSource<'a>, EngineError>;

    /// Every voxel as it is held, or as the shader of the site fetches it, against the CPU decoder; `None` where the target
    /// decodes nothing by itself, and where it does so only while it draws. With `as_cells` also through the codec's
    /// `fetch_cell`, if the site calls that.
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

    /// The same of what is decoded while a drawing draws; `None` where nothing is.
    ///
    /// # Errors
    /// A sentence, when the device fails.
    fn check_drawing(&self, _drawing: &Drawing, _expected: &Expected<'_>) -> Result<Option<Checked>, String> {
        Ok(None)
    }

    /// What preparing it took, and what stands in for what.
    fn preparation(&self) -> Preparation {
        Preparation::default()
    }

    /// Whether it holds memory beside the stream.
    fn holds_memory(&self) -> bool {
        true
    }
}

/// What preparing a frame took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preparation {
    /// Milliseconds in which the device decodes the frame, where it was timed.
    pub device_decode_ms: Option<f64>,
    /// Bytes on the device while it decodes.
    pub device_decode_bytes: Option<u64>,
    /// Fallbacks, and what else a record notes.
    pub remarks: Vec<String>,
}

/// A frame that the CPU mirror draws from; a device draws nothing from it.
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
