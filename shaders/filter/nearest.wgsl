// The voxel that covers x, clamped at the border. Voxel i covers i..i+1 along each axis. Views along an axis put
// whole rows of samples on the faces between voxels, where rounding would choose: they go to the upper voxel.
// Mirror: `Filter::NEAREST_TIE` in cvr-core.
const nearest_tie: f32 = 0.0017;

fn volume_sample(x: vec3<f32>) -> Voxel {
    let last = vec3<i32>(volume_extent) - 1;
    return voxel_fetch(clamp(vec3<i32>(floor(x + nearest_tie)), vec3<i32>(0), last));
}
