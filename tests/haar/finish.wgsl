// Integers to floats, in place.
@compute @workgroup_size(64)
fn haar_finish(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i < haar_samples {
        haar_set_sample(i, bitcast<u32>(f32(bitcast<i32>(haar_sample(i)))));
    }
}
