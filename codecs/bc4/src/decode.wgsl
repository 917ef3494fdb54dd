// Decodes one voxel of a block. The twin of decode.rs, function for function. It has a fetch and a cell of its own,
// because the kit's cell would read the words of a block for every corner.
//
// Constants: bc4_grid (vec3<u32>: blocks along x and y, slices), bc4_channels, bc4_offset, bc4_step, bc4_high,
// bc4_part. Resource: bc4_blocks.

fn bc4_index(words: vec2<u32>, texel: u32) -> u32 {
    let bit = 16u + 3u * texel;
    if bit >= 32u {
        return (words.y >> (bit - 32u)) & 7u;
    }
    return ((words.x >> bit) | (words.y << (32u - bit))) & 7u;
}

fn bc4_level(words: vec2<u32>, index: u32) -> u32 {
    let first = words.x & 255u;
    let second = (words.x >> 8u) & 255u;
    let eight = first > second;
    if !eight && index >= 6u {
        return (index - 6u) * 8925u;
    }
    let whole = select(5u, 7u, eight);
    let share = select(index - 1u, index * whole, index < 2u);
    return ((whole - share) * first + share * second) * select(7u, 5u, eight);
}

fn bc4_value(level: u32) -> f32 {
    let code = f32(level / 35u) + f32(level % 35u) * bc4_part;
    return min(bc4_offset + bc4_step * code, bc4_high);
}

fn bc4_voxel(words: vec2<u32>, texel: u32) -> f32 {
    return bc4_value(bc4_level(words, bc4_index(words, texel)));
}

fn bc4_texel(x: u32, y: u32) -> u32 {
    return (y % 4u) * 4u + x % 4u;
}

fn bc4_words(p: vec3<u32>, c: u32) -> vec2<u32> {
    let row = (p.z * bc4_channels + c) * bc4_grid.y + p.y / 4u;
    let word = 2u * (row * bc4_grid.x + p.x / 4u);
    return vec2<u32>(bc4_blocks(word), bc4_blocks(word + 1u));
}

fn bc4_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < bc4_channels; c++) {
        let words = bc4_words(v, c);
        out[c] = bc4_voxel(words, bc4_texel(v.x, v.y));
    }
    return out;
}

fn bc4_corners(start: vec2<u32>, end: vec2<u32>, z: u32, c: u32) -> vec4<f32> {
    let across = end.x / 4u != start.x / 4u;
    let block_00 = bc4_words(vec3<u32>(start, z), c);
    var block_10 = block_00;
    if across {
        block_10 = bc4_words(vec3<u32>(end.x, start.y, z), c);
    }
    var block_01 = block_00;
    var block_11 = block_10;
    if end.y / 4u != start.y / 4u {
        block_01 = bc4_words(vec3<u32>(start.x, end.y, z), c);
        block_11 = block_01;
        if across {
            block_11 = bc4_words(vec3<u32>(end, z), c);
        }
    }
    return vec4<f32>(
        bc4_voxel(block_00, bc4_texel(start.x, start.y)),
        bc4_voxel(block_10, bc4_texel(end.x, start.y)),
        bc4_voxel(block_01, bc4_texel(start.x, end.y)),
        bc4_voxel(block_11, bc4_texel(end.x, end.y)),
    );
}

fn bc4_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    let v = vec3<u32>(p);
    let w = vec3<u32>(q);
    var out: array<vec4<f32>, 8>;
    for (var c = 0u; c < bc4_channels; c++) {
        let near = bc4_corners(v.xy, w.xy, v.z, c);
        var far = near;
        if w.z != v.z {
            far = bc4_corners(v.xy, w.xy, w.z, c);
        }
        out[0][c] = near.x;
        out[1][c] = near.y;
        out[2][c] = near.z;
        out[3][c] = near.w;
        out[4][c] = far.x;
        out[5][c] = far.y;
        out[6][c] = far.z;
        out[7][c] = far.w;
    }
    return out;
}
