// The same value as filter/linear.wgsl through one call for all eight corners.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let cell = cell_around(x);
    let c = voxel_cell(cell.p, cell.q);
    return trilinear(
        voxel_of(c[0]), voxel_of(c[1]), voxel_of(c[2]), voxel_of(c[3]),
        voxel_of(c[4]), voxel_of(c[5]), voxel_of(c[6]), voxel_of(c[7]),
        cell.t,
    );
}
