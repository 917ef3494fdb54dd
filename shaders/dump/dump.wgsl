// Writes every voxel as the template would fetch it: the device's half of a parity test.
@compute @workgroup_size(64)
fn dump(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= volume_extent.x * volume_extent.y * volume_extent.z {
        return;
    }
    let row = i / volume_extent.x;
    let p = vec3<u32>(i % volume_extent.x, row % volume_extent.y, row / volume_extent.y);
    let voxel = voxel_fetch(vec3<i32>(p));
    for (var c = 0u; c < voxel_channels; c++) {
        dump_values[i * voxel_channels + c] = voxel_channel(voxel, c);
    }
}
