// One axis of one level, from one buffer to another: sums lie before differences, and become neighbours.
fn haar_index(at: vec3<u32>, channel: u32) -> u32 {
    return ((at.z * haar_extent.y + at.y) * haar_extent.x + at.x) * haar_channels + channel;
}

@compute @workgroup_size(64)
fn haar_lift(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = vec3<u32>(id.x / haar_channels, id.yz);
    let channel = id.x % haar_channels;
    if at.x >= haar_box.x {
        return;
    }
    let count = haar_box[haar_axis];
    let k = at[haar_axis];
    var low = at;
    low[haar_axis] = k / 2u;
    var high = at;
    high[haar_axis] = (count + 1u) / 2u + k / 2u;
    var value = bitcast<i32>(haar_from(haar_index(low, channel)));
    // The last of an odd number has no partner.
    if (k | 1u) < count {
        let difference = bitcast<i32>(haar_from(haar_index(high, channel)));
        value = value - (difference >> 1u) + difference * i32(k & 1u);
    }
    haar_set_to(haar_index(at, channel), bitcast<u32>(value));
}
