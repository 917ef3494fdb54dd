// Decodes one voxel from indices and codewords. The twin of decode.rs, function for function.
//
// Constants: vq_block, vq_grid (vec3<u32>), vq_channels, vq_dimension (codes of a codeword), vq_index_bits,
// vq_codeword_bits, vq_lanes_log2, vq_offset, vq_step. Resources: vq_index, vq_codebook.

fn vq_value(code: u32) -> f32 {
    return vq_offset + vq_step * f32(code);
}

fn vq_lane(word: u32, i: u32) -> u32 {
    let lane = i & ((1u << vq_lanes_log2) - 1u);
    return (word >> (lane * vq_codeword_bits)) & ((1u << vq_codeword_bits) - 1u);
}

fn vq_code(i: u32) -> u32 {
    return vq_lane(vq_codebook(i >> vq_lanes_log2), i);
}

fn vq_index_of(block: vec3<u32>) -> u32 {
    let b = (block.z * vq_grid.y + block.y) * vq_grid.x + block.x;
    let bit = (b & 31u) * vq_index_bits;
    let word = (b >> 5u) * vq_index_bits + (bit >> 5u);
    let shift = bit & 31u;
    var index = vq_index(word) >> shift;
    if shift + vq_index_bits > 32u {
        index |= vq_index(word + 1u) << (32u - shift);
    }
    return index & ((1u << vq_index_bits) - 1u);
}

fn vq_codeword(block: vec3<u32>) -> u32 {
    return vq_index_of(block) * vq_dimension;
}

fn vq_place(inside: vec3<u32>) -> u32 {
    return ((inside.z * vq_block.y + inside.y) * vq_block.x + inside.x) * vq_channels;
}

fn vq_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    let block = v / vq_block;
    let first = vq_codeword(block) + vq_place(v - block * vq_block);
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < vq_channels; c++) {
        out[c] = vq_value(vq_code(first + c));
    }
    return out;
}

fn vq_codewords(from_x: u32, to_x: u32, y: u32, z: u32) -> vec2<u32> {
    let first = vq_codeword(vec3<u32>(from_x, y, z));
    if from_x == to_x {
        return vec2<u32>(first, first);
    }
    return vec2<u32>(first, vq_codeword(vec3<u32>(to_x, y, z)));
}

fn vq_pair(first: u32, second: u32) -> vec2<f32> {
    let first_word = vq_codebook(first >> vq_lanes_log2);
    var second_word = first_word;
    if (second >> vq_lanes_log2) != (first >> vq_lanes_log2) {
        second_word = vq_codebook(second >> vq_lanes_log2);
    }
    return vec2<f32>(vq_value(vq_lane(first_word, first)), vq_value(vq_lane(second_word, second)));
}

fn vq_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    let v = vec3<u32>(p);
    let w = vec3<u32>(q);
    let from_block = v / vq_block;
    let to_block = w / vq_block;
    let a = v - from_block * vq_block;
    let b = w - to_block * vq_block;
    let words_00 = vq_codewords(from_block.x, to_block.x, from_block.y, from_block.z);
    var words_10 = words_00;
    if to_block.y != from_block.y {
        words_10 = vq_codewords(from_block.x, to_block.x, to_block.y, from_block.z);
    }
    var words_01 = words_00;
    var words_11 = words_10;
    if to_block.z != from_block.z {
        words_01 = vq_codewords(from_block.x, to_block.x, from_block.y, to_block.z);
        words_11 = words_01;
        if to_block.y != from_block.y {
            words_11 = vq_codewords(from_block.x, to_block.x, to_block.y, to_block.z);
        }
    }
    let row_00 = words_00 + vec2<u32>(vq_place(a), vq_place(vec3<u32>(b.x, a.y, a.z)));
    let row_10 = words_10 + vec2<u32>(vq_place(vec3<u32>(a.x, b.y, a.z)), vq_place(vec3<u32>(b.x, b.y, a.z)));
    let row_01 = words_01 + vec2<u32>(vq_place(vec3<u32>(a.x, a.y, b.z)), vq_place(vec3<u32>(b.x, a.y, b.z)));
    let row_11 = words_11 + vec2<u32>(vq_place(vec3<u32>(a.x, b.y, b.z)), vq_place(b));
    var out: array<vec4<f32>, 8>;
    for (var c = 0u; c < vq_channels; c++) {
        let pair_00 = vq_pair(row_00.x + c, row_00.y + c);
        let pair_10 = vq_pair(row_10.x + c, row_10.y + c);
        let pair_01 = vq_pair(row_01.x + c, row_01.y + c);
        let pair_11 = vq_pair(row_11.x + c, row_11.y + c);
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
