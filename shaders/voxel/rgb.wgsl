// A colour volume: a voxel is three numbers in data units.
alias Voxel = vec3<f32>;

fn voxel_of(value: vec4<f32>) -> Voxel {
    return value.xyz;
}
