// The voxel that covers x, clamped at the border. Voxel i covers i..i+1 along each axis. In views along an axis, whole
// rows of samples lie on faces between voxels, and rounding would choose. They go to the upper voxel. Mirror:
// `Filter::NEAREST_TIE` in cvr-core.
const nearest_tie: f32 = 0.0017;

fn volume_sample(x: vec3<f32>) -> Voxel {
    let last = vec3<i32>(volume_extent) - 1;
    // Not floor(x + nearest_tie): a compiler may add the offset to what x is computed from, one shader otherwise than
    // the next, and one rounds to another voxel than the other.
    let below = floor(x);
    let voxel = select(below, below + 1.0, x - below >= vec3<f32>(1.0 - nearest_tie));
    return voxel_fetch(clamp(vec3<i32>(voxel), vec3<i32>(0), last));
}
