//! What the CPU mirror of a renderer reads voxels from.

use super::RenderError;
use crate::codec::{DecodeError, Decoder, decode_stages};
use crate::memory::Held;
use crate::volume::{BrickKey, Extent, FrameIndex, Level, NoReferences, Region, VolumeLayout};

/// Values at the corners of a cell; corner `i` takes x from bit 0, y from bit 1, z from bit 2 of `i`. A scalar
/// lies in the first component.
pub type Cell = [[f32; 4]; 8];

/// Random access to decoded voxels.
pub trait Voxels: Sync {
    /// Shape of the volume.
    fn layout(&self) -> &VolumeLayout;

    /// One voxel; `p` lies inside.
    ///
    /// # Errors
    /// When decoding fails.
    fn fetch(&self, p: [u32; 3]) -> Result<[f32; 4], RenderError>;

    /// The corners of the cell from `p` to `q`, both inside; `q` is `p` or `p + 1` along each axis.
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

/// A decoded frame in memory: what the site *host* draws from.
#[derive(Clone, Debug)]
pub struct DecodedFrame {
    layout: VolumeLayout,
    values: Vec<f32>,
    _held: Held,
}

impl DecodedFrame {
    /// From values, x fastest, channels interleaved; `None` when their number does not fit.
    #[must_use]
    pub fn new(layout: VolumeLayout, values: Vec<f32>) -> Option<Self> {
        (values.len() as u64 == layout.samples_per_frame()).then(|| Self {
            layout,
            _held: Held::of(&values),
            values,
        })
    }

    /// Decodes a whole frame.
    ///
    /// # Errors
    /// As [`Decoder::decode_brick`].
    pub fn decode(decoder: &dyn Decoder, frame: FrameIndex) -> Result<Self, DecodeError> {
        Self::decode_stages(decoder, frame, Level::ALL_STAGES)
    }

    /// The same from the first `stages` alone.
    ///
    /// # Errors
    /// As [`Decoder::decode_brick`].
    pub fn decode_stages(decoder: &dyn Decoder, frame: FrameIndex, stages: u8) -> Result<Self, DecodeError> {
        let values = decode_stages(decoder, frame, stages, &NoReferences)?;
        Ok(Self { layout: decoder.layout().clone(), _held: Held::of(&values), values })
    }

    /// The values, x fastest, channels interleaved.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }
}

impl Voxels for DecodedFrame {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn fetch(&self, p: [u32; 3]) -> Result<[f32; 4], RenderError> {
        let at = self.layout.extent.index(p);
        Ok(match self.layout.channels {
            1 => [self.values[at], 0.0, 0.0, 0.0],
            _ => [self.values[3 * at], self.values[3 * at + 1], self.values[3 * at + 2], 0.0],
        })
    }

    fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Result<Cell, RenderError> {
        // One index and three strides instead of eight indices: this is the mirror's innermost loop.
        let VolumeLayout { extent, channels, .. } = self.layout;
        let first = extent.index(p);
        let (row, slice) = (extent.x() as usize, extent.x() as usize * extent.y() as usize);
        let step = [(q[0] - p[0]) as usize, (q[1] - p[1]) as usize * row, (q[2] - p[2]) as usize * slice];
        let mut cell = Cell::default();
        for (i, corner) in cell.iter_mut().enumerate() {
            let at = first + step[0] * (i & 1) + step[1] * (i >> 1 & 1) + step[2] * (i >> 2 & 1);
            for (c, value) in corner.iter_mut().enumerate().take(channels as usize) {
                *value = self.values[at * channels as usize + c];
            }
        }
        Ok(cell)
    }
}

/// Decodes at every fetch: what the site *inline* draws from on the CPU.
#[derive(Debug)]
pub struct DecoderVoxels<'a> {
    decoder: &'a dyn Decoder,
    frame: FrameIndex,
    level: Level,
}

impl<'a> DecoderVoxels<'a> {
    /// Draws `frame` of `decoder`.
    #[must_use]
    pub const fn new(decoder: &'a dyn Decoder, frame: FrameIndex) -> Self {
        Self { decoder, frame, level: Level::FULL }
    }

    /// The same from the first stages alone.
    #[must_use]
    pub const fn with_stages(self, stages: u8) -> Self {
        Self { level: Level { stages, ..self.level }, ..self }
    }

    fn decode(&self, region: Region, out: &mut [f32]) -> Result<(), RenderError> {
        let key = BrickKey { frame: self.frame, level: self.level, region };
        self.decoder.decode_brick(key, &NoReferences, out).map_err(|e| RenderError::Voxels(e.to_string()))
    }
}

impl Voxels for DecoderVoxels<'_> {
    fn layout(&self) -> &VolumeLayout {
        self.decoder.layout()
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
