// Writes every voxel as the template fetches it: the device's side of a parity test. Voxels are numbered x fastest,
// then y. A dispatch writes a range of them to the beginning of the buffer.
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
    let p = vec3<u32>(i % volume_extent.x, row % volume_extent.y, row / volume_extent.y);
    let voxel = voxel_fetch(vec3<i32>(p));
    for (var c = 0u; c < voxel_channels; c++) {
        dump_values[(i - inputs.dumped.first) * voxel_channels + c] = voxel_channel(voxel, c);
    }
}
