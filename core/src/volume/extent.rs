//! The size of a box of voxels.

use serde::{Deserialize, Serialize};

/// Size in voxels along x, y and z; never zero along any axis. Serialised as `[x, y, z]`.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "[u32; 3]", into = "[u32; 3]")]
pub struct Extent {
    x: u32,
    y: u32,
    z: u32,
}

/// Why three numbers are not an extent.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ExtentError {
    /// One axis has no voxels.
    #[error("dimensions {0}×{1}×{2}: every axis needs at least one voxel")]
    Empty(u32, u32, u32),
    /// The voxel count does not fit the 2^40 that this software indexes.
    #[error("dimensions {0}×{1}×{2}: more than 2^40 voxels")]
    TooLarge(u32, u32, u32),
}

impl Extent {
    /// One voxel.
    pub const ONE: Self = Self { x: 1, y: 1, z: 1 };

    /// # Errors
    /// When an axis is zero or the product exceeds 2^40 voxels.
    pub const fn new(x: u32, y: u32, z: u32) -> Result<Self, ExtentError> {
        if x == 0 || y == 0 || z == 0 {
            return Err(ExtentError::Empty(x, y, z));
        }
        if x as u128 * y as u128 * z as u128 > 1 << 40 {
            return Err(ExtentError::TooLarge(x, y, z));
        }
        Ok(Self { x, y, z })
    }

    /// A cube of `edge` voxels per axis.
    ///
    /// # Errors
    /// As [`Extent::new`].
    pub const fn cube(edge: u32) -> Result<Self, ExtentError> {
        Self::new(edge, edge, edge)
    }

    /// Voxels along x.
    #[must_use]
    pub const fn x(self) -> u32 {
        self.x
    }

    /// Voxels along y.
    #[must_use]
    pub const fn y(self) -> u32 {
        self.y
    }

    /// Voxels along z.
    #[must_use]
    pub const fn z(self) -> u32 {
        self.z
    }

    /// Number of voxels.
    #[must_use]
    pub const fn voxels(self) -> u64 {
        self.x as u64 * self.y as u64 * self.z as u64
    }

    /// Index of voxel `p` in memory order (x fastest). `p` must lie inside.
    #[must_use]
    pub const fn index(self, p: [u32; 3]) -> usize {
        debug_assert!(p[0] < self.x && p[1] < self.y && p[2] < self.z);
        (p[2] as usize * self.y as usize + p[1] as usize) * self.x as usize + p[0] as usize
    }

    /// The voxel at index `i` of memory order; the inverse of [`Extent::index`].
    #[must_use]
    pub const fn position(self, i: usize) -> [u32; 3] {
        let row = i / self.x as usize;
        let (x, y, z) = (i % self.x as usize, row % self.y as usize, row / self.y as usize);
        [x as u32, y as u32, z as u32]
    }

    /// The extent at a resolution: each step halves every axis and rounds up.
    #[must_use]
    pub fn at_resolution(self, resolution: u8) -> Self {
        let halved = |axis: u32| u64::from(axis).div_ceil(1 << resolution.min(32)) as u32;
        Self { x: halved(self.x), y: halved(self.y), z: halved(self.z) }
    }

    /// Number of blocks of size `block` along each axis. Cut blocks at the faces count.
    #[must_use]
    pub const fn blocks_of(self, block: Self) -> Self {
        Self { x: self.x.div_ceil(block.x), y: self.y.div_ceil(block.y), z: self.z.div_ceil(block.z) }
    }

    /// `[x, y, z]`.
    #[must_use]
    pub const fn to_array(self) -> [u32; 3] {
        [self.x, self.y, self.z]
    }
}

impl TryFrom<[u32; 3]> for Extent {
    type Error = ExtentError;

    fn try_from([x, y, z]: [u32; 3]) -> Result<Self, ExtentError> {
        Self::new(x, y, z)
    }
}

impl From<Extent> for [u32; 3] {
    fn from(extent: Extent) -> Self {
        extent.to_array()
    }
}

impl std::fmt::Display for Extent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}×{}×{}", self.x, self.y, self.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_empty_and_overflowing_extents() {
        assert_eq!(Extent::new(4, 0, 4), Err(ExtentError::Empty(4, 0, 4)));
        assert_eq!(Extent::cube(u32::MAX), Err(ExtentError::TooLarge(u32::MAX, u32::MAX, u32::MAX)));
        assert_eq!(Extent::cube(1), Ok(Extent::ONE));
    }

    #[test]
    fn counts_cut_edge_blocks() {
        let extent = Extent::new(13, 17, 23).unwrap();
        assert_eq!(extent.blocks_of(Extent::cube(4).unwrap()).to_array(), [4, 5, 6]);
        assert_eq!(extent.index([12, 16, 22]) as u64, extent.voxels() - 1);
        assert_eq!(extent.position(extent.index([12, 3, 22])), [12, 3, 22]);
    }

    #[test]
    fn resolutions_halve_and_keep_the_rest() {
        let extent = Extent::new(13, 16, 1).unwrap();
        assert_eq!(
            [0, 1, 2, 255].map(|r| extent.at_resolution(r).to_array()),
            [[13, 16, 1], [7, 8, 1], [4, 4, 1], [1, 1, 1]]
        );
    }
}
