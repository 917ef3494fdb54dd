//! A texture in pieces that fit into a buffer: whole slices, or rows of one slice if a slice is too large.

use cvr_core::codec::{DecodedForm, TexelFormat};
use cvr_core::render::Contents;
use cvr_core::volume::Extent;

use crate::EngineError;

/// Invocations of one workgroup of shaders/deferred/decode.wgsl, along x.
pub(crate) const WORKGROUP: u32 = 64;
/// Bytes of the uniform `slab`.
pub(crate) const SLAB_UNIFORM_BYTES: u64 = 32;

/// Adjacent rows of some slices of a texture.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(crate) struct Slab {
    pub(crate) first_row: u32,
    pub(crate) first_slice: u32,
    pub(crate) rows: u32,
    pub(crate) slices: u32,
}

/// How a texture is cut. In the buffer, rows begin every [`Slabs::row_bytes`].
#[derive(Copy, Clone, Debug)]
pub(crate) struct Slabs {
    extent: Extent,
    row_bytes: u64,
    /// Rows and slices of a piece that the border does not cut.
    rows: u32,
    slices: u32,
}

impl Slabs {
    /// Pieces of at most `most_bytes`.
    ///
    /// # Errors
    /// [`EngineError::TooLarge`] when a single row has more.
    pub(crate) fn new(extent: Extent, texel_bytes: usize, most_bytes: u64) -> Result<Self, EngineError> {
        let [width, height, depth] = extent.to_array();
        let alignment = u64::from(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let row_bytes = (u64::from(width) * texel_bytes as u64).next_multiple_of(alignment);
        let rows = most_bytes / row_bytes;
        if rows == 0 {
            let what = "a row of texels".to_owned();
            return Err(EngineError::TooLarge {
                what,
                requested: row_bytes,
                limit: most_bytes,
                unit: "bytes",
            });
        }
        let slices = (rows / u64::from(height)).clamp(1, u64::from(depth)) as u32;
        Ok(Self { extent, row_bytes, rows: rows.min(u64::from(height)) as u32, slices })
    }

    /// All pieces, in the order of memory.
    pub(crate) fn iter(self) -> impl Iterator<Item = Slab> {
        let [_, height, depth] = self.extent.to_array();
        (0..depth).step_by(self.slices as usize).flat_map(move |first_slice| {
            let slices = self.slices.min(depth - first_slice);
            let rows = move |first_row| self.rows.min(height - first_row);
            let slab = move |first_row| Slab { first_row, first_slice, rows: rows(first_row), slices };
            (0..height).step_by(self.rows as usize).map(slab)
        })
    }

    /// Bytes of one row.
    pub(crate) const fn row_bytes(self) -> usize {
        self.row_bytes as usize
    }

    /// Bytes of a slab.
    pub(crate) const fn bytes(self, slab: Slab) -> u64 {
        self.row_bytes * slab.rows as u64 * slab.slices as u64
    }

    /// Bytes of the largest piece.
    pub(crate) const fn most_bytes(self) -> u64 {
        self.row_bytes * self.rows as u64 * self.slices as u64
    }

    /// Layout of a piece in a buffer.
    pub(crate) const fn buffer_layout(self, slab: Slab) -> wgpu::TexelCopyBufferLayout {
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(self.row_bytes as u32),
            rows_per_image: Some(slab.rows),
        }
    }

    /// Size of the copy of a piece.
    pub(crate) const fn size(self, slab: Slab) -> wgpu::Extent3d {
        wgpu::Extent3d { width: self.extent.x(), height: slab.rows, depth_or_array_layers: slab.slices }
    }
}

/// The uniform `slab` before a slab is named.
pub(crate) fn no_slab() -> Contents {
    Contents { name: "slab", bytes: vec![0; SLAB_UNIFORM_BYTES as usize] }
}

/// The struct `Slab` of shaders/deferred/decode.wgsl, for rows of this many voxels.
pub(crate) fn slab_uniform(
    slab: Slab,
    slabs: Slabs,
    form: DecodedForm,
    row_voxels: u32,
) -> [u8; SLAB_UNIFORM_BYTES as usize] {
    let steps = match form.format {
        TexelFormat::Unorm8 => 255.0,
        TexelFormat::Unorm16 => 65535.0,
        TexelFormat::Float16 | TexelFormat::Float32 => 1.0,
    };
    let per_unit = (steps / f64::from(form.scale)) as f32;
    let row_words = slabs.row_bytes() as u32 / 4;
    let [offset, per_unit] = [form.offset, per_unit].map(f32::to_bits);
    bytemuck::cast([slab.first_row, slab.first_slice, slab.rows, row_words, offset, per_unit, row_voxels, 0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_cover_every_row_once_and_keep_to_the_limit() {
        let extent = Extent::new(13, 17, 23).unwrap();
        for most_bytes in [256, 256 * 5, 256 * 17, 256 * 17 * 4, 256 * 17 * 22 + 255, 1 << 30] {
            let slabs = Slabs::new(extent, 4, most_bytes).unwrap();
            let mut rows = Vec::new();
            for slab in slabs.iter() {
                assert!(slabs.bytes(slab) <= slabs.most_bytes() && slabs.most_bytes() <= most_bytes);
                let slices = slab.first_slice..slab.first_slice + slab.slices;
                rows.extend(
                    slices.flat_map(|z| (slab.first_row..slab.first_row + slab.rows).map(move |y| (z, y))),
                );
            }
            let all: Vec<_> = (0..23).flat_map(|z| (0..17).map(move |y| (z, y))).collect();
            assert_eq!(rows, all, "{most_bytes}");
        }
        let error = Slabs::new(extent, 32, 256).unwrap_err();
        assert_eq!(error.to_string(), "a row of texels needs 512 bytes, this device offers 256");
    }
}
