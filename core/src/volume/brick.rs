//! Boxes of voxels, and the key of a brick.

use super::{Extent, FrameIndex, Level};

/// A box of voxels: from `origin` (inclusive), `extent` voxels along each axis.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Region {
    /// Lowest voxel of the box.
    pub origin: [u32; 3],
    /// Size of the box.
    pub extent: Extent,
}

impl Region {
    /// The box from the origin that covers `extent`.
    #[must_use]
    pub const fn whole(extent: Extent) -> Self {
        Self { origin: [0; 3], extent }
    }

    /// The single voxel `p`.
    #[must_use]
    pub const fn voxel(p: [u32; 3]) -> Self {
        Self { origin: p, extent: Extent::ONE }
    }

    /// Whether the box lies inside a volume of size `extent`.
    #[must_use]
    pub fn fits(&self, extent: Extent) -> bool {
        (0..3).all(|a| {
            u64::from(self.origin[a]) + u64::from(self.extent.to_array()[a])
                <= u64::from(extent.to_array()[a])
        })
    }

    /// Block number `index` of the blocks of size `block` that cover `extent`, cut at its faces.
    #[must_use]
    pub fn block(index: [u32; 3], block: Extent, extent: Extent) -> Self {
        let (block, whole) = (block.to_array(), extent.to_array());
        let origin: [u32; 3] = std::array::from_fn(|a| (index[a] * block[a]).min(whole[a] - 1));
        Self::between(origin, std::array::from_fn(|a| (origin[a] + block[a]).min(whole[a])))
    }

    /// The box extended by up to `apron` voxels on each side, cut to a volume of size `extent`.
    #[must_use]
    pub fn with_apron(self, apron: u32, extent: Extent) -> Self {
        let (size, whole) = (self.extent.to_array(), extent.to_array());
        let end = std::array::from_fn(|a| (self.origin[a] + size[a] + apron).min(whole[a]));
        Self::between(self.origin.map(|o| o.saturating_sub(apron)), end)
    }

    /// The box from `origin` to `end` (exclusive). `end` is greater along every axis.
    fn between(origin: [u32; 3], end: [u32; 3]) -> Self {
        let size: [u32; 3] = std::array::from_fn(|a| end[a].saturating_sub(origin[a]).max(1));
        Self { origin, extent: Extent::try_from(size).unwrap_or(Extent::ONE) }
    }

    /// Rows along x, in memory order: the volume position of each row's first voxel. Row `n` starts at voxel `n *
    /// extent.x()` of the output.
    pub fn rows(self) -> impl Iterator<Item = [u32; 3]> {
        let [x, y, z] = self.origin;
        (z..z + self.extent.z()).flat_map(move |z| (y..y + self.extent.y()).map(move |y| [x, y, z]))
    }

    /// Positions of all voxels, x fastest.
    pub fn positions(self) -> impl Iterator<Item = [u32; 3]> {
        let width = self.extent.x();
        self.rows().flat_map(move |[x, y, z]| (x..x + width).map(move |x| [x, y, z]))
    }
}

/// A request to a decoder: one box of one frame at one level. `region` counts voxels of that level's resolution.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub struct BrickKey {
    /// Frame (time step).
    pub frame: FrameIndex,
    /// Resolution and stages.
    pub level: Level,
    /// The box, in voxels of `level.resolution`.
    pub region: Region,
}

impl BrickKey {
    /// `region` of `frame` at full quality.
    #[must_use]
    pub const fn full(frame: FrameIndex, region: Region) -> Self {
        Self { frame, level: Level::FULL, region }
    }
}
