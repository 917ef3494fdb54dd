//! The ways in which the volume's border cuts blocks.

use cvr_core::codec::Block;
use cvr_core::volume::Extent;

/// All sizes in voxels of the blocks of a volume of `extent`, after the border cuts them: at most two along each axis,
/// the cut one first.
#[must_use]
pub fn cuts(block: Block, extent: Extent) -> Vec<[usize; 3]> {
    let (whole, grid) = (block.0.to_array(), block.grid(extent).to_array());
    let last = block.region(grid.map(|g| g - 1), extent).extent.to_array();
    let sizes = [0, 1, 2].map(|a| {
        let mut sizes = vec![last[a] as usize];
        if last[a] != whole[a] && grid[a] > 1 {
            sizes.push(whole[a] as usize);
        }
        sizes
    });
    let [xs, ys, zs] = &sizes;
    let lines = zs.iter().flat_map(|z| ys.iter().map(move |y| (*y, *z)));
    lines.flat_map(|(y, z)| xs.iter().map(move |x| [*x, y, z])).collect()
}

/// Which components of a block's vector lie in the volume, if the block is cut to `cut` voxels.
#[must_use]
pub fn inside(block: Block, channels: u32, cut: [usize; 3]) -> Vec<bool> {
    let [x, y, z] = block.0.to_array().map(|s| s as usize);
    let lines = (0..z).flat_map(|z| (0..y).map(move |y| z < cut[2] && y < cut[1]));
    lines
        .flat_map(|line| (0..x).map(move |x| line && x < cut[0]))
        .flat_map(|voxel| std::iter::repeat_n(voxel, channels as usize))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_inside_are_those_of_voxels_inside() {
        let [yes, no] = [true, false];
        let block: Block = "2x2x2".parse().unwrap();
        assert_eq!(inside(block, 1, [1, 1, 2]), [yes, no, no, no, yes, no, no, no]);
        let block: Block = "2x1x1".parse().unwrap();
        assert_eq!(inside(block, 3, [1, 1, 1]), [yes, yes, yes, no, no, no]);
    }

    #[test]
    fn a_border_cuts_each_axis_in_two_ways_at_most() {
        let cuts = |extent: [u32; 3]| cuts("4".parse().unwrap(), Extent::try_from(extent).unwrap());
        assert_eq!(cuts([8, 8, 8]), [[4, 4, 4]]);
        assert_eq!(cuts([9, 3, 8]), [[1, 3, 4], [4, 3, 4]]);
        assert_eq!(cuts([5, 6, 7]).len(), 8);
    }
}
