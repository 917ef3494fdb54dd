//! Slices drawn from a ring of decoded layers, as data: the site *ring*.
//!
//! Layer `i` lies in slot `i mod` [`RING_LAYERS`]; layers beyond the volume's border are its outermost ones. So the ring
//! is a small texture that repeats along its third axis, and whatever filters it need not know that it is one.

use std::ops::Range;

/// Layers that the ring holds: a sample between two layers is interpolated from these, and its gradient by central
/// differences from one more on each side (Fout and Ma 2007, section 5: a cache of four slices).
pub const RING_LAYERS: u32 = 4;

/// One step of a pass that draws triangles piece by piece, and decodes the layers of voxels that each piece reads in
/// between ([`super::Stage::Layers`]).
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
