// A colour volume: a voxel is three numbers in data units.
alias Voxel = vec3<f32>;
const voxel_channels: u32 = 3u;

fn voxel_of(value: vec4<f32>) -> Voxel {
    return value.xyz;
}

fn voxel_channel(voxel: Voxel, channel: u32) -> f32 {
    return voxel[channel];
}
