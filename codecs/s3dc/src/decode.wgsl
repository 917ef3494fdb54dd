// Decodes one voxel from the two volumes. The twin of decode.rs, function for function.
//
// Constants: s3dc_block, s3dc_grid (vec3<u32>), s3dc_height (voxels along y), s3dc_channels, s3dc_index_bits,
// s3dc_row_words, s3dc_endpoint_bits, s3dc_signed, s3dc_reciprocal. Resources: s3dc_minmax, s3dc_index.

fn s3dc_integer(code: u32) -> f32 {
    const shift = 32u - s3dc_endpoint_bits;
    let high = code << shift;
    if s3dc_signed != 0u {
        return f32(bitcast<i32>(high) >> shift);
    }
    return f32(high >> shift);
}

fn s3dc_endpoints(entry: u32) -> vec2<f32> {
    if s3dc_endpoint_bits == 32u {
        return vec2<f32>(bitcast<f32>(s3dc_minmax(2u * entry)), bitcast<f32>(s3dc_minmax(2u * entry + 1u)));
    }
    if s3dc_endpoint_bits == 16u {
        let word = s3dc_minmax(entry);
        return vec2<f32>(s3dc_integer(word), s3dc_integer(word >> 16u));
    }
    let word = s3dc_minmax(entry >> 1u) >> ((entry & 1u) * 16u);
    return vec2<f32>(s3dc_integer(word), s3dc_integer(word >> 8u));
}

fn s3dc_value(ends: vec2<f32>, index: u32) -> f32 {
    return min(ends.x + (ends.y - ends.x) * (f32(index) * s3dc_reciprocal), ends.y);
}

fn s3dc_entry(block: vec3<u32>) -> u32 {
    return ((block.z * s3dc_grid.y + block.y) * s3dc_grid.x + block.x) * s3dc_channels;
}

fn s3dc_row(y: u32, z: u32) -> u32 {
    return (z * s3dc_height + y) * s3dc_row_words;
}

fn s3dc_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    let entry = s3dc_entry(v / s3dc_block);
    let row = s3dc_row(v.y, v.z);
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < s3dc_channels; c++) {
        let bit = (v.x * s3dc_channels + c) * s3dc_index_bits;
        let word = s3dc_index(row + (bit >> 5u));
        let index = (word >> (bit & 31u)) & ((1u << s3dc_index_bits) - 1u);
        out[c] = s3dc_value(s3dc_endpoints(entry + c), index);
    }
    return out;
}

// Minimum and maximum at the row's first end in xy, at its second end in zw.
fn s3dc_ends(from_x: u32, to_x: u32, y: u32, z: u32, c: u32) -> vec4<f32> {
    let first = s3dc_endpoints(s3dc_entry(vec3<u32>(from_x, y, z)) + c);
    if from_x == to_x {
        return vec4<f32>(first, first);
    }
    return vec4<f32>(first, s3dc_endpoints(s3dc_entry(vec3<u32>(to_x, y, z)) + c));
}

fn s3dc_pair(ends: vec4<f32>, row: u32, from_x: u32, to_x: u32, c: u32) -> vec2<f32> {
    let from_bit = (from_x * s3dc_channels + c) * s3dc_index_bits;
    let to_bit = (to_x * s3dc_channels + c) * s3dc_index_bits;
    let from_word = s3dc_index(row + (from_bit >> 5u));
    var to_word = from_word;
    if (to_bit >> 5u) != (from_bit >> 5u) {
        to_word = s3dc_index(row + (to_bit >> 5u));
    }
    let from_index = (from_word >> (from_bit & 31u)) & ((1u << s3dc_index_bits) - 1u);
    let to_index = (to_word >> (to_bit & 31u)) & ((1u << s3dc_index_bits) - 1u);
    return vec2<f32>(s3dc_value(ends.xy, from_index), s3dc_value(ends.zw, to_index));
}

fn s3dc_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    let v = vec3<u32>(p);
    let w = vec3<u32>(q);
    let from_block = v / s3dc_block;
    let to_block = w / s3dc_block;
    var out: array<vec4<f32>, 8>;
    for (var c = 0u; c < s3dc_channels; c++) {
        let ends_00 = s3dc_ends(from_block.x, to_block.x, from_block.y, from_block.z, c);
        var ends_10 = ends_00;
        if to_block.y != from_block.y {
            ends_10 = s3dc_ends(from_block.x, to_block.x, to_block.y, from_block.z, c);
        }
        var ends_01 = ends_00;
        var ends_11 = ends_10;
        if to_block.z != from_block.z {
            ends_01 = s3dc_ends(from_block.x, to_block.x, from_block.y, to_block.z, c);
            ends_11 = ends_01;
            if to_block.y != from_block.y {
                ends_11 = s3dc_ends(from_block.x, to_block.x, to_block.y, to_block.z, c);
            }
        }
        let pair_00 = s3dc_pair(ends_00, s3dc_row(v.y, v.z), v.x, w.x, c);
        let pair_10 = s3dc_pair(ends_10, s3dc_row(w.y, v.z), v.x, w.x, c);
        let pair_01 = s3dc_pair(ends_01, s3dc_row(v.y, w.z), v.x, w.x, c);
        let pair_11 = s3dc_pair(ends_11, s3dc_row(w.y, w.z), v.x, w.x, c);
        out[0][c] = pair_00.x;
        out[1][c] = pair_00.y;
        out[2][c] = pair_10.x;
        out[3][c] = pair_10.y;
        out[4][c] = pair_01.x;
        out[5][c] = pair_01.y;
        out[6][c] = pair_11.x;
        out[7][c] = pair_11.y;
    }
    return out;
}
