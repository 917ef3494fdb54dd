// Writes every voxel as a corner of a cell. The corner changes from voxel to voxel, so that all eight are tested,
// within and across blocks. Voxels are numbered x fastest, then y. A dispatch writes a range of them to the beginning
// of the buffer.
struct Dumped {
    first: u32,
    end: u32,
}

@compute @workgroup_size(64)
fn dump(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = inputs.dumped.first + id.y * groups.x * 64u + id.x;
    if i >= inputs.dumped.end {
        return;
    }
    let row = i / volume_extent.x;
    let at = vec3<u32>(i % volume_extent.x, row % volume_extent.y, row / volume_extent.y);
    let mixed = (i * 2654435761u) >> 29u;
    let corner = min(vec3<u32>(mixed, mixed >> 1u, mixed >> 2u) & vec3<u32>(1u), at);
    let p = vec3<i32>(at - corner);
    let q = min(p + 1, vec3<i32>(volume_extent) - 1);
    var cell = voxel_cell(p, q);
    let voxel = voxel_of(cell[corner.x + 2u * corner.y + 4u * corner.z]);
    for (var c = 0u; c < voxel_channels; c++) {
        dump_values[(i - inputs.dumped.first) * voxel_channels + c] = voxel_channel(voxel, c);
    }
}
