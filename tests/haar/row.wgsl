// The axis x of one level in place: a workgroup takes a row of one channel, which it keeps in its own memory.
var<workgroup> haar_row_values: array<i32, haar_length>;

fn haar_index(x: u32, group: vec3<u32>) -> u32 {
    return ((group.z * haar_extent.y + group.y) * haar_extent.x + x) * haar_channels + group.x;
}

@compute @workgroup_size(64)
fn haar_row(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    for (var x = local; x < haar_length; x += 64u) {
        haar_row_values[x] = bitcast<i32>(haar_sample(haar_index(x, group)));
    }
    workgroupBarrier();
    for (var x = local; x < haar_length; x += 64u) {
        var value = haar_row_values[x / 2u];
        if (x | 1u) < haar_length {
            let difference = haar_row_values[(haar_length + 1u) / 2u + x / 2u];
            value = value - (difference >> 1u) + difference * i32(x & 1u);
        }
        haar_set_sample(haar_index(x, group), bitcast<u32>(value));
    }
}
