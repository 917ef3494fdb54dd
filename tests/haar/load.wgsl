// The coefficients, from the stream's buffer to where they are lifted.
@compute @workgroup_size(64)
fn haar_load(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i < haar_samples {
        haar_set_to(i, haar_coefficients(i));
    }
}
