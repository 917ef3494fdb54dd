//! Everything that decides a picture but the voxels.

use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Camera, ClipBox, Coarse, ColourOpacity, Macrocells, RayFrame, Shading, TransferFunction};
use crate::volume::{Extent, ValueRange, VolumeLayout};

/// How a value between voxel centres is computed.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// The voxel that covers the point.
    Nearest,
    /// Trilinear between the eight surrounding voxel centres, clamped at the border. At the site *host* the texture
    /// unit computes it if it can.
    Linear,
    /// The same value as [`Filter::Linear`], through the codec's `fetch_cell` (S3Dc's "optimised linear").
    OptimisedLinear,
}

impl Filter {
    /// All filters that a pipeline may name.
    pub const ALL: [Self; 3] = [Self::Nearest, Self::Linear, Self::OptimisedLinear];

    /// [`Filter::Nearest`] adds this to every coordinate, in voxels. In views along an axis, whole rows of samples lie
    /// on faces between voxels, and the rounding of each device would choose a side. The offset is larger than any such
    /// rounding, smaller than an eye can see, and not a likely fraction of a step.
    pub const NEAREST_TIE: f32 = 0.0017;

    /// Name used in TOML and in records.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Linear => "linear",
            Self::OptimisedLinear => "optimised-linear",
        }
    }
}

impl std::fmt::Display for Filter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Everything that decides a picture but the voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Camera.
    pub camera: Camera,
    /// Data value → colour and opacity per voxel length.
    pub transfer_function: Arc<TransferFunction>,
    /// Distance between ray samples, in voxel lengths (smallest spacing).
    pub step_voxels: f32,
    /// A ray ends when its opacity reaches this value, also within a sample. 1 = never. The picture then differs by at
    /// most 1 − this.
    pub termination: f32,
    /// Filter.
    pub filter: Filter,
    /// The origin of a colour's opacity. Scalar volumes ignore it.
    pub colour_opacity: ColourOpacity,
    /// Lowest and highest value of the volume. In colour volumes of floats they are black and white.
    pub value_range: ValueRange,
    /// How surfaces are lit. `None`: samples show the transfer function's colours.
    pub shading: Option<Shading>,
    /// The part of the volume to draw. `None`: all.
    pub clip: Option<ClipBox>,
    /// Set if a lower resolution of this volume is drawn, at the volume's size. Voxel coordinates are then the
    /// resolution's. `None`: the volume's own voxels are drawn.
    pub coarse: Option<Coarse>,
    /// Macrocells to skip, for this transfer function. They do not change the picture.
    pub macrocells: Option<Arc<Macrocells>>,
}

impl View {
    /// A plain view: 256 × 256 pixels, default camera, half a voxel per step, no early termination, linear, unlit, no
    /// clip box, no skipping, opacity of colours by luminance.
    #[must_use]
    pub fn new(transfer_function: impl Into<Arc<TransferFunction>>) -> Self {
        let transfer_function = transfer_function.into();
        Self {
            size: [256, 256],
            camera: Camera::default(),
            value_range: transfer_function.domain(),
            colour_opacity: ColourOpacity::default(),
            transfer_function,
            step_voxels: 0.5,
            termination: 1.0,
            filter: Filter::Linear,
            shading: None,
            clip: None,
            coarse: None,
            macrocells: None,
        }
    }

    /// The macrocells to skip. The transfer function classifies macrocells. If a table over all colours gives the
    /// opacity, nothing is skipped.
    #[must_use]
    pub fn skippable(&self, layout: &VolumeLayout) -> Option<&Macrocells> {
        let by_table = layout.channels != 1 && matches!(self.colour_opacity, ColourOpacity::Table(_));
        self.macrocells.as_deref().filter(|_| !by_table)
    }

    /// The same view of a volume of this shape, drawn from one of its resolutions, whose voxels have a shift
    /// ([`crate::codec::Decoder::coarse_shift`]). Macrocells are the resolution's.
    #[must_use]
    pub fn at_resolution(&self, volume: &VolumeLayout, resolution: u8, shift: f32) -> Self {
        Self { coarse: Coarse::of(volume, resolution, shift), ..self.clone() }
    }

    /// The rays of the picture, in coordinates of the drawn voxels, whose shape is `layout`.
    #[must_use]
    pub fn rays(&self, layout: &VolumeLayout) -> RayFrame {
        match &self.coarse {
            None => self.camera.rays(layout, self.size),
            Some(coarse) => coarse.rays(&self.camera, layout, self.size),
        }
    }

    /// Lower and upper corner of the drawn box, in coordinates of the drawn voxels. `extent` is their number along each
    /// axis.
    #[must_use]
    pub fn bounds(&self, extent: Extent) -> [Vec3; 2] {
        let clip = self.clip.unwrap_or(ClipBox::WHOLE);
        match &self.coarse {
            None => clip.corners(extent),
            Some(coarse) => clip.corners(coarse.extent()).map(|corner| coarse.corner(corner, extent)),
        }
    }

    /// Whether all voxels are drawn completely: no clip box, and no voxel of a lower resolution that extends beyond the
    /// volume.
    #[must_use]
    pub fn draws_whole(&self, extent: Extent) -> bool {
        self.clip.is_none() && self.bounds(extent) == ClipBox::WHOLE.corners(extent)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ControlPoint, MacrocellRanges, OpacityTable};
    use super::*;
    use crate::volume::SampleType;

    #[test]
    fn a_table_over_colours_lets_nothing_be_skipped() {
        let point = |value| ControlPoint { value, rgba: [0.0; 4] };
        let function = TransferFunction::new(vec![point(0.0), point(1.0)]).unwrap();
        let scalar = VolumeLayout::scalar(Extent::cube(9).unwrap(), SampleType::U8);
        let ranges = MacrocellRanges::of_constant(scalar.extent, 0.5);
        let mut view = View::new(function);
        view.macrocells = Some(Arc::new(ranges.classify(&view.transfer_function)));
        let colour = VolumeLayout { channels: 3, ..scalar.clone() };
        assert!(view.skippable(&scalar).is_some() && view.skippable(&colour).is_some());
        view.colour_opacity = ColourOpacity::Table(Arc::new(OpacityTable::new(2, &[0.5; 8]).unwrap()));
        assert!(view.skippable(&scalar).is_some() && view.skippable(&colour).is_none());
    }
}
