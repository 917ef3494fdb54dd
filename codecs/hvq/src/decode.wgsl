// Decodes one voxel from a mean, two indices and two codewords. The twin of decode.rs, function for function.
//
// Constants: hvq_grid (vec3<u32>), hvq_channels, hvq_top, hvq_offset, hvq_step, hvq_codeword_bits, hvq_lanes_log2,
// hvq_mean_bits, hvq_mean_step; of both stages hvq_coarse_bits and hvq_detail_bits (of an index), hvq_coarse_plane and
// hvq_detail_plane (first word of the indices), hvq_coarse_dimension and hvq_detail_dimension (codes of a codeword),
// hvq_coarse_zero and hvq_detail_zero, hvq_coarse_step and hvq_detail_step, hvq_detail_first (word of the codewords).
// Resources: hvq_index, hvq_codebook.

fn hvq_value(level: i32) -> f32 {
    return hvq_offset + hvq_step * f32(clamp(level, 0, i32(hvq_top)));
}

fn hvq_number(plane: u32, bits: u32, i: u32) -> u32 {
    let bit = (i & 31u) * bits;
    let word = plane + (i >> 5u) * bits + (bit >> 5u);
    let shift = bit & 31u;
    var number = hvq_index(word) >> shift;
    if shift + bits > 32u {
        number |= hvq_index(word + 1u) << (32u - shift);
    }
    return number & ((1u << bits) - 1u);
}

fn hvq_lane(word: u32, i: u32) -> i32 {
    let lane = i & ((1u << hvq_lanes_log2) - 1u);
    return i32((word >> (lane * hvq_codeword_bits)) & ((1u << hvq_codeword_bits) - 1u));
}

fn hvq_code(first: u32, i: u32) -> i32 {
    return hvq_lane(hvq_codebook(first + (i >> hvq_lanes_log2)), i);
}

fn hvq_head(block: vec3<u32>) -> vec3<u32> {
    let b = (block.z * hvq_grid.y + block.y) * hvq_grid.x + block.x;
    var head = vec3<u32>(b, 0u, 0u);
    if hvq_stages() > 1u {
        head.y = hvq_number(hvq_coarse_plane, hvq_coarse_bits, b) * hvq_coarse_dimension;
    }
    if hvq_stages() > 2u {
        head.z = hvq_number(hvq_detail_plane, hvq_detail_bits, b) * hvq_detail_dimension;
    }
    return head;
}

fn hvq_mean(b: u32, c: u32) -> i32 {
    return i32(hvq_number(0u, hvq_mean_bits, b * hvq_channels + c) * hvq_mean_step);
}

fn hvq_coarse(code: i32) -> i32 {
    return (code - i32(hvq_coarse_zero)) * i32(hvq_coarse_step);
}

fn hvq_detail(code: i32) -> i32 {
    return (code - i32(hvq_detail_zero)) * i32(hvq_detail_step);
}

fn hvq_sub_block(inside: vec3<u32>) -> u32 {
    return (((inside.z & 2u) << 1u) | (inside.y & 2u) | (inside.x >> 1u)) * hvq_channels;
}

fn hvq_place(inside: vec3<u32>) -> u32 {
    return ((inside.z * 4u + inside.y) * 4u + inside.x) * hvq_channels;
}

fn hvq_voxel(head: vec3<u32>, inside: vec3<u32>, c: u32) -> f32 {
    var level = hvq_mean(head.x, c);
    if hvq_stages() > 1u {
        level += hvq_coarse(hvq_code(0u, head.y + hvq_sub_block(inside) + c));
    }
    if hvq_stages() > 2u {
        level += hvq_detail(hvq_code(hvq_detail_first, head.z + hvq_place(inside) + c));
    }
    return hvq_value(level);
}

fn hvq_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    let head = hvq_head(v / 4u);
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < hvq_channels; c++) {
        out[c] = hvq_voxel(head, v & vec3<u32>(3u), c);
    }
    return out;
}

struct hvq_heads {
    low: vec3<u32>,
    high: vec3<u32>,
}

fn hvq_heads_of(low_x: u32, high_x: u32, y: u32, z: u32) -> hvq_heads {
    let low = hvq_head(vec3<u32>(low_x, y, z));
    if low_x == high_x {
        return hvq_heads(low, low);
    }
    return hvq_heads(low, hvq_head(vec3<u32>(high_x, y, z)));
}

fn hvq_code_pair(first: u32, low: u32, high: u32) -> vec2<i32> {
    let low_word = hvq_codebook(first + (low >> hvq_lanes_log2));
    var high_word = low_word;
    if (high >> hvq_lanes_log2) != (low >> hvq_lanes_log2) {
        high_word = hvq_codebook(first + (high >> hvq_lanes_log2));
    }
    return vec2<i32>(hvq_lane(low_word, low), hvq_lane(high_word, high));
}

fn hvq_means(heads: hvq_heads, c: u32) -> vec2<i32> {
    let low = hvq_mean(heads.low.x, c);
    if heads.low.x == heads.high.x {
        return vec2<i32>(low, low);
    }
    return vec2<i32>(low, hvq_mean(heads.high.x, c));
}

fn hvq_pair(heads: hvq_heads, means: vec2<i32>, a: vec3<u32>, b: vec3<u32>, c: u32) -> vec2<f32> {
    var levels = means;
    if hvq_stages() > 1u {
        let low = heads.low.y + hvq_sub_block(a) + c;
        let high = heads.high.y + hvq_sub_block(b) + c;
        let codes = hvq_code_pair(0u, low, high);
        levels += vec2<i32>(hvq_coarse(codes.x), hvq_coarse(codes.y));
    }
    if hvq_stages() > 2u {
        let low = heads.low.z + hvq_place(a) + c;
        let high = heads.high.z + hvq_place(b) + c;
        let codes = hvq_code_pair(hvq_detail_first, low, high);
        levels += vec2<i32>(hvq_detail(codes.x), hvq_detail(codes.y));
    }
    return vec2<f32>(hvq_value(levels.x), hvq_value(levels.y));
}

fn hvq_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    let v = vec3<u32>(p);
    let w = vec3<u32>(q);
    let low_block = v / 4u;
    let high_block = w / 4u;
    let a = v & vec3<u32>(3u);
    let b = w & vec3<u32>(3u);
    let across_y = high_block.y != low_block.y;
    let across_z = high_block.z != low_block.z;
    let heads_00 = hvq_heads_of(low_block.x, high_block.x, low_block.y, low_block.z);
    var heads_10 = heads_00;
    if across_y {
        heads_10 = hvq_heads_of(low_block.x, high_block.x, high_block.y, low_block.z);
    }
    var heads_01 = heads_00;
    var heads_11 = heads_10;
    if across_z {
        heads_01 = hvq_heads_of(low_block.x, high_block.x, low_block.y, high_block.z);
        heads_11 = heads_01;
        if across_y {
            heads_11 = hvq_heads_of(low_block.x, high_block.x, high_block.y, high_block.z);
        }
    }
    var out: array<vec4<f32>, 8>;
    for (var c = 0u; c < hvq_channels; c++) {
        let means_00 = hvq_means(heads_00, c);
        var means_10 = means_00;
        if across_y {
            means_10 = hvq_means(heads_10, c);
        }
        var means_01 = means_00;
        var means_11 = means_10;
        if across_z {
            means_01 = hvq_means(heads_01, c);
            means_11 = means_01;
            if across_y {
                means_11 = hvq_means(heads_11, c);
            }
        }
        let pair_00 = hvq_pair(heads_00, means_00, a, vec3<u32>(b.x, a.y, a.z), c);
        let pair_10 = hvq_pair(heads_10, means_10, vec3<u32>(a.x, b.y, a.z), vec3<u32>(b.x, b.y, a.z), c);
        let pair_01 = hvq_pair(heads_01, means_01, vec3<u32>(a.x, a.y, b.z), vec3<u32>(b.x, a.y, b.z), c);
        let pair_11 = hvq_pair(heads_11, means_11, vec3<u32>(a.x, b.y, b.z), b, c);
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
