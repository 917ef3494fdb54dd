// Trilinear between the eight voxel centres around x, clamped at the border.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let last = vec3<i32>(volume_extent) - 1;
    let base = floor(x - 0.5);
    let t = (x - 0.5) - base;
    let p = clamp(vec3<i32>(base), vec3<i32>(0), last);
    let q = clamp(vec3<i32>(base) + 1, vec3<i32>(0), last);
    return trilinear(
        voxel_fetch(p),
        voxel_fetch(vec3<i32>(q.x, p.y, p.z)),
        voxel_fetch(vec3<i32>(p.x, q.y, p.z)),
        voxel_fetch(vec3<i32>(q.x, q.y, p.z)),
        voxel_fetch(vec3<i32>(p.x, p.y, q.z)),
        voxel_fetch(vec3<i32>(q.x, p.y, q.z)),
        voxel_fetch(vec3<i32>(p.x, q.y, q.z)),
        voxel_fetch(q),
        t,
    );
}
