// The coefficients of the lower resolution, which are the first ones along each axis of all that the stream's buffer holds.
@compute @workgroup_size(64)
fn haar_low(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i < haar_samples {
        let row = i / haar_channels / haar_extent.x;
        let at = vec3<u32>(i / haar_channels % haar_extent.x, row % haar_extent.y, row / haar_extent.y);
        let first = ((at.z * haar_stored.y + at.y) * haar_stored.x + at.x) * haar_channels;
        haar_set_to(i, haar_coefficients(first + i % haar_channels));
    }
}
