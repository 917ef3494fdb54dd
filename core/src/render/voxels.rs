//! The voxels that a renderer's CPU mirror reads.

use super::RenderError;
use crate::codec::{DecodeError, DecodedFrame, Decoder, References};
use crate::volume::{BrickKey, Extent, FrameIndex, Level, Region, VolumeLayout};

/// Values at the corners of a grid cell. Corner `i` takes x from bit 0, y from bit 1, z from bit 2 of `i`. A scalar is
/// in the first component.
pub type Cell = [[f32; 4]; 8];

/// Random access to decoded voxels.
pub trait Voxels: Sync {
    /// Shape of the volume at the drawn level.
    fn layout(&self) -> &VolumeLayout;

    /// One voxel; `p` lies inside.
    ///
    /// # Errors
    /// When decoding fails.
    fn fetch(&self, p: [u32; 3]) -> Result<[f32; 4], RenderError>;

    /// The corners of the grid cell from `p` to `q`, both inside. `q` is `p` or `p + 1` along each axis.
    ///
    /// # Errors
    /// When decoding fails.
    fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Result<Cell, RenderError> {
        let mut cell = Cell::default();
        for (i, corner) in cell.iter_mut().enumerate() {
            *corner = self.fetch(std::array::from_fn(|a| if i >> a & 1 == 0 { p[a] } else { q[a] }))?;
        }
        Ok(cell)
    }
}

impl Voxels for DecodedFrame {
    fn layout(&self) -> &VolumeLayout {
        self.layout()
    }

    fn fetch(&self, p: [u32; 3]) -> Result<[f32; 4], RenderError> {
        let (at, values) = (self.layout().extent.index(p), self.values());
        Ok(match self.layout().channels {
            1 => [values[at], 0.0, 0.0, 0.0],
            _ => [values[3 * at], values[3 * at + 1], values[3 * at + 2], 0.0],
        })
    }

    fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Result<Cell, RenderError> {
        // One index and three strides instead of eight indices: this is the mirror's innermost loop.
        let &VolumeLayout { extent, channels, .. } = self.layout();
        let values = self.values();
        let first = extent.index(p);
        let (row, slice) = (extent.x() as usize, extent.x() as usize * extent.y() as usize);
        let step = [(q[0] - p[0]) as usize, (q[1] - p[1]) as usize * row, (q[2] - p[2]) as usize * slice];
        let mut cell = Cell::default();
        for (i, corner) in cell.iter_mut().enumerate() {
            let at = first + step[0] * (i & 1) + step[1] * (i >> 1 & 1) + step[2] * (i >> 2 & 1);
            for (c, value) in corner.iter_mut().enumerate().take(channels as usize) {
                *value = values[at * channels as usize + c];
            }
        }
        Ok(cell)
    }
}

/// Decodes at every fetch: the CPU's version of the site *inline*.
#[derive(Debug)]
pub struct DecoderVoxels<'a> {
    decoder: &'a dyn Decoder,
    frame: FrameIndex,
    level: Level,
    /// Shape of the volume at the level.
    layout: VolumeLayout,
    /// The frames that this frame is predicted from.
    references: References,
}

impl<'a> DecoderVoxels<'a> {
    /// Draws `frame` of `decoder` at a level.
    ///
    /// # Errors
    /// When what the frame is predicted from does not decode.
    pub fn new(decoder: &'a dyn Decoder, frame: FrameIndex, level: Level) -> Result<Self, DecodeError> {
        let references = decoder.references(frame, level)?;
        let layout = decoder.layout().at_resolution(level.resolution);
        Ok(Self { decoder, frame, level, layout, references })
    }

    fn decode(&self, region: Region, out: &mut [f32]) -> Result<(), RenderError> {
        let key = BrickKey { frame: self.frame, level: self.level, region };
        self.decoder.decode_brick(key, &self.references, out).map_err(|e| RenderError::Voxels(e.to_string()))
    }
}

impl Voxels for DecoderVoxels<'_> {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn fetch(&self, p: [u32; 3]) -> Result<[f32; 4], RenderError> {
        let mut value = [0.0; 4];
        self.decode(Region::voxel(p), &mut value[..self.layout().channels as usize])?;
        Ok(value)
    }

    fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Result<Cell, RenderError> {
        let channels = self.layout().channels as usize;
        let size: [u32; 3] = std::array::from_fn(|a| q[a] - p[a] + 1);
        let extent = Extent::try_from(size).map_err(|e| RenderError::Voxels(e.to_string()))?;
        let mut values = [0.0; 8 * 3];
        let used = size.iter().product::<u32>() as usize * channels;
        self.decode(Region { origin: p, extent }, &mut values[..used])?;
        let mut cell = Cell::default();
        for (i, corner) in cell.iter_mut().enumerate() {
            let local: [u32; 3] = std::array::from_fn(|a| (i as u32 >> a & 1).min(size[a] - 1));
            let at = extent.index(local) * channels;
            corner[..channels].copy_from_slice(&values[at..at + channels]);
        }
        Ok(cell)
    }
}
