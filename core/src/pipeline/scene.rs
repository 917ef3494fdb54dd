//! A scene: camera, transfer function, and everything else that a picture shows.

use std::sync::Arc;

use super::{FilePath, parse_colour};
use crate::render::{
    Camera, ClipBox, ColourOpacity, ControlPoint, Filter, Shading, TransferFunction, TransferFunctionError,
    View,
};
use crate::volume::{FrameIndex, ValueRange};

/// A scene of an experiment. It becomes a [`View`] when the value range of the volume is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name in records and file names.
    pub name: String,
    /// The volumes of this scene. `None`: all volumes that no other scene names.
    pub volumes: Option<Vec<String>>,
    /// Width and height in pixels, 1 to [`Scene::MAX_SIZE`]; default [`Scene::DEFAULT_SIZE`].
    pub size: [u32; 2],
    /// Camera.
    pub camera: Camera,
    /// At least two points. Values do not decrease, and are not all equal.
    pub control_points: Vec<ControlPoint>,
    /// The meaning of the control points' values.
    pub domain: TransferDomain,
    /// Distance between samples along a ray in voxel lengths, within [`number::STEP_VOXELS`](super::number::STEP_VOXELS).
    pub step_voxels: f32,
    /// A ray ends when its opacity reaches this value. Above 0 and at most 1 (= never). Default 0.999.
    pub early_termination: f32,
    /// Colour behind the volume, RGB, `0.0..=1.0`; default black.
    pub background: [f32; 3],
    /// How surfaces are lit. Default: unlit.
    pub shading: Option<Shading>,
    /// The part of the volume to draw. Default: all.
    pub clip: Option<ClipBox>,
    /// The origin of a colour's opacity. Default: its luminance.
    pub opacity: SceneOpacity,
    /// Frames to draw, each in its own picture. Default: the first.
    pub frames: FrameRange,
}

/// The origin of a colour's opacity in a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneOpacity {
    /// What is known.
    Known(ColourOpacity),
    /// A table over all colours in a file, stored as a volume: red along x, green along y, blue along z. The caller
    /// reads the file and replaces this value by [`ColourOpacity::Table`].
    File(FilePath),
}

impl Default for SceneOpacity {
    fn default() -> Self {
        Self::Known(ColourOpacity::default())
    }
}

/// Frames of a volume from `first` to `last`, both included.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameRange {
    /// First frame, counted from 0.
    pub first: u32,
    /// Last frame, not before the first.
    pub last: u32,
}

impl FrameRange {
    /// The frames in their order.
    pub fn iter(self) -> impl Iterator<Item = FrameIndex> {
        (self.first..=self.last).map(FrameIndex)
    }
}

impl std::fmt::Display for FrameRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { first, last } = self;
        if first == last { write!(f, "frame {first}") } else { write!(f, "frames {first} to {last}") }
    }
}

/// Why a scene does not give a view of a volume.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// Its transfer function has no meaning over the volume's range.
    #[error(transparent)]
    TransferFunction(#[from] TransferFunctionError),
    /// Its opacity table has not been read.
    #[error("the opacity table {0} has not been read")]
    Table(String),
}

/// The meaning of the control points' values.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum TransferDomain {
    /// Data values.
    #[default]
    Data,
    /// 0 = the volume's lowest value, 1 = its highest.
    Range,
}

impl TransferDomain {
    /// Name used in TOML.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Data => "data",
            Self::Range => "range",
        }
    }
}

impl Scene {
    /// Longest side of a picture in pixels.
    pub const MAX_SIZE: u32 = 8192;
    /// Width and height unless a configuration says otherwise.
    pub const DEFAULT_SIZE: [u32; 2] = [256, 256];
    /// Default background, as written in a configuration.
    pub const DEFAULT_BACKGROUND: &str = "#000000";

    /// [`Scene::DEFAULT_BACKGROUND`] as RGB.
    #[must_use]
    pub fn default_background() -> [f32; 3] {
        parse_colour(Self::DEFAULT_BACKGROUND).map_or([0.0; 3], |(rgb, _)| rgb)
    }

    /// The view of a volume whose values lie in `range`.
    ///
    /// # Errors
    /// When the control points coincide after they were mapped onto `range`, which takes a range of few
    /// floating-point steps; or when the scene's opacity table still lies in a file.
    pub fn view(&self, range: ValueRange, filter: Filter) -> Result<View, SceneError> {
        let colour_opacity = match &self.opacity {
            SceneOpacity::Known(opacity) => opacity.clone(),
            SceneOpacity::File(path) => return Err(SceneError::Table(path.written().to_owned())),
        };
        Ok(View {
            size: self.size,
            camera: self.camera,
            transfer_function: Arc::new(self.transfer_function(range)?),
            step_voxels: self.step_voxels,
            termination: self.early_termination,
            filter,
            colour_opacity,
            value_range: range,
            shading: self.shading,
            clip: self.clip,
            coarse: None,
            macrocells: None,
        })
    }

    /// The transfer function in data units. A volume with a single value gets a wider range: by 1, or by a thousandth
    /// of the value if that is more.
    ///
    /// # Errors
    /// When the control points coincide after they were mapped onto `range`.
    pub fn transfer_function(&self, range: ValueRange) -> Result<TransferFunction, TransferFunctionError> {
        if self.domain == TransferDomain::Data {
            return TransferFunction::new(self.control_points.clone());
        }
        let one_value = range.span() <= 0.0;
        let span = if one_value { (f64::from(range.min).abs() / 1000.0).max(1.0) } else { range.span() };
        // Above a single value near the largest `f32` there is no room.
        let no_room = one_value && f64::from(range.min) + span > f64::from(f32::MAX);
        let min = f64::from(range.min) - if no_room { span } else { 0.0 };
        let map = |p: &ControlPoint| {
            let value = (min + f64::from(p.value) * span).clamp(f64::from(f32::MIN), f64::from(f32::MAX));
            ControlPoint { value: value as f32, ..*p }
        };
        TransferFunction::new(self.control_points.iter().map(map).collect())
    }
}
