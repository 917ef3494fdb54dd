// The number of a scalar voxel, for templates that write voxels.
const voxel_channels: u32 = 1u;

fn voxel_channel(voxel: Voxel, channel: u32) -> f32 {
    return voxel;
}
