// Trilinear between the eight voxel centres around x, clamped at the border.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let cell = cell_around(x);
    let p = cell.p;
    let q = cell.q;
    return trilinear(
        voxel_fetch(p),
        voxel_fetch(vec3<i32>(q.x, p.y, p.z)),
        voxel_fetch(vec3<i32>(p.x, q.y, p.z)),
        voxel_fetch(vec3<i32>(q.x, q.y, p.z)),
        voxel_fetch(vec3<i32>(p.x, p.y, q.z)),
        voxel_fetch(vec3<i32>(q.x, p.y, q.z)),
        voxel_fetch(vec3<i32>(p.x, q.y, q.z)),
        voxel_fetch(q),
        cell.t,
    );
}
