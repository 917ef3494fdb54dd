//! Steps that draw slices from a ring of decoded layers: the site *ring*.
//!
//! Layer `i` lies in slot `i mod` [`RING_LAYERS`]. Beyond the volume's border the outermost layer is repeated. The ring
//! is therefore a small texture that repeats along its third axis. Filters need no special case for it.

use std::ops::Range;

/// Number of layers in the ring. A sample between two layers interpolates these two. Its gradient by central
/// differences needs one more on each side (Fout and Ma 2007, section 5: a cache of four slices).
pub const RING_LAYERS: u32 = 4;

/// One step of a pass that draws triangles in pieces. Between the pieces it decodes the layers that the next piece
/// reads ([`super::Stage::Layers`]).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LayerStep {
    /// Decodes this layer into a buffer that holds one.
    Decode(u32),
    /// Copies the layer in the buffer into this slot of the ring.
    Place(u32),
    /// Draws the ray samples of triangles that lie between the centres of two layers.
    Draw {
        /// The lower layer. −1 and the last layer stand for the half voxel beyond the outermost centres.
        between: i32,
        /// Range of the pass's vertices.
        vertices: Range<u32>,
    },
}
