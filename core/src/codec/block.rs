//! The block: the unit that a codec codes on its own.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::volume::{Extent, Region};

/// Size of a block in voxels. Its text form is `8` (a cube) or `8x8x4`. No edge is zero.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Block(pub Extent);

impl Block {
    /// Number of blocks along each axis. Blocks cut by the border count.
    #[must_use]
    pub const fn grid(self, volume: Extent) -> Extent {
        volume.blocks_of(self.0)
    }

    /// The voxels of the block at grid position `b`, cut at the volume's border.
    #[must_use]
    pub fn region(self, b: [u32; 3], volume: Extent) -> Region {
        let [bx, by, bz] = self.0.to_array();
        let [vx, vy, vz] = volume.to_array();
        let origin = [b[0] * bx, b[1] * by, b[2] * bz];
        let cut = |o: u32, size: u32, end: u32| size.min(end - o);
        let extent = Extent::new(cut(origin[0], bx, vx), cut(origin[1], by, vy), cut(origin[2], bz, vz));
        Region { origin, extent: extent.unwrap_or(Extent::ONE) }
    }
}

impl FromStr for Block {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let axis = |part: &str| part.trim().parse::<u32>().map_err(|_| ());
        let sizes: Result<Vec<u32>, ()> = s.split('x').map(axis).collect();
        let extent = match sizes.as_deref() {
            Ok([edge]) => Extent::cube(*edge),
            Ok([x, y, z]) => Extent::new(*x, *y, *z),
            _ => return Err(format!("`{s}` is no block size: write an edge (`8`) or three (`8x8x4`)")),
        };
        extent.map(Self).map_err(|e| e.to_string())
    }
}

impl fmt::Display for Block {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.to_array() {
            [x, y, z] if x == y && y == z => write!(f, "{x}"),
            [x, y, z] => write!(f, "{x}x{y}x{z}"),
        }
    }
}

impl TryFrom<String> for Block {
    type Error = String;

    fn try_from(s: String) -> Result<Self, String> {
        s.parse()
    }
}

impl From<Block> for String {
    fn from(block: Block) -> Self {
        block.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_cubes_and_boxes() {
        assert_eq!("8".parse::<Block>().unwrap().to_string(), "8");
        assert_eq!("8x8x4".parse::<Block>().unwrap().0.to_array(), [8, 8, 4]);
        assert!("8x8".parse::<Block>().is_err());
        assert!("0".parse::<Block>().is_err());
    }

    #[test]
    fn cuts_edge_blocks() {
        let region = "4".parse::<Block>().unwrap().region([3, 0, 0], Extent::new(13, 5, 4).unwrap());
        assert_eq!(region.origin, [12, 0, 0]);
        assert_eq!(region.extent.to_array(), [1, 4, 4]);
    }
}
