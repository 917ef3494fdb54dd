// The three numbers of a colour voxel, for templates that write voxels.
const voxel_channels: u32 = 3u;

fn voxel_channel(voxel: Voxel, channel: u32) -> f32 {
    return voxel[channel];
}
