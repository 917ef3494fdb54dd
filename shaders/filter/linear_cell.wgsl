// The same value as filter/linear.wgsl through one call for all eight corners.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let last = vec3<i32>(volume_extent) - 1;
    let base = floor(x - 0.5);
    let t = (x - 0.5) - base;
    let p = clamp(vec3<i32>(base), vec3<i32>(0), last);
    let q = clamp(vec3<i32>(base) + 1, vec3<i32>(0), last);
    let c = voxel_cell(p, q);
    return trilinear(
        voxel_of(c[0]), voxel_of(c[1]), voxel_of(c[2]), voxel_of(c[3]),
        voxel_of(c[4]), voxel_of(c[5]), voxel_of(c[6]), voxel_of(c[7]),
        t,
    );
}
