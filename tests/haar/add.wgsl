// Adds the reference of a predicted frame to its stored differences.
@compute @workgroup_size(64)
fn haar_add(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i < haar_samples {
        let sum = bitcast<f32>(haar_sample(i)) + bitcast<f32>(haar_reference(i));
        haar_set_sample(i, bitcast<u32>(sum));
    }
}
