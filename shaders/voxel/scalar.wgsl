// A scalar volume: a voxel is one number in data units.
alias Voxel = f32;

fn voxel_of(value: vec4<f32>) -> Voxel {
    return value.x;
}
