//! Slices drawn from a ring of decoded layers, as data: the site *ring*.

use std::ops::Range;

use super::RasterPass;
use crate::volume::Axis;

/// Layers that the ring holds: a sample between two layers is interpolated from these, and its gradient by central
/// differences from one more on each side (Fout and Ma 2007, section 5: a cache of four slices).
pub const RING_LAYERS: u32 = 4;

/// A pass that draws triangles piece by piece, and decodes the layers of voxels that each piece reads in between.
///
/// Layer `i` lies in slot `i mod` [`RING_LAYERS`]; layers beyond the volume's border are its outermost ones. So the ring
/// is a small texture that repeats along its third axis, and whatever filters it need not know that it is one.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerPass {
    /// Shader, inputs and triangles. The instance that its vertex shader is drawn with is [`LayerStep::Draw::between`]
    /// plus 1.
    pub raster: RasterPass,
    /// What layers lie across.
    pub axis: Axis,
    /// What is done, in this order, into an image that is transparent at first. A slot is read only once it is filled.
    pub steps: Vec<LayerStep>,
}

/// One step of a [`LayerPass`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LayerStep {
    /// Decodes this layer into a buffer that holds one.
    Decode(u32),
    /// Copies the layer in the buffer into this slot of the ring.
    Place(u32),
    /// Draws triangles: of their samples those that lie between the centres of two layers.
    Draw {
        /// The lower of the two; −1 and the last layer stand for the half voxel beyond the outermost centres.
        between: i32,
        /// Which of the pass's vertices.
        vertices: Range<u32>,
    },
}
