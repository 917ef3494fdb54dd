// A scalar volume: a voxel is one number in data units.
alias Voxel = f32;
const voxel_channels: u32 = 1u;

fn voxel_of(value: vec4<f32>) -> Voxel {
    return value.x;
}

fn voxel_channel(voxel: Voxel, channel: u32) -> f32 {
    return voxel;
}
