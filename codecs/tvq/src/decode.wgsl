// One voxel out of a mean and sums of codewords: the twin of decode.rs, function for function.
//
// Constants: tvq_grid, tvq_sub_blocks, tvq_sub_grid, tvq_bricks (vec3<u32>), tvq_channels, tvq_variable, tvq_books,
// tvq_table_words, tvq_entry_bits, tvq_lanes_log2, tvq_offset, tvq_unit.
// Resources: tvq_tables, tvq_codebook, tvq_index, tvq_heads.

fn tvq_value(sum: i32) -> f32 {
    return tvq_offset + tvq_unit * f32(clamp(sum, 0, 65535));
}

fn tvq_number(first: u32, bit: u32, width: u32) -> u32 {
    if width == 0u {
        return 0u;
    }
    let word = first + (bit >> 5u);
    let shift = bit & 31u;
    var number = tvq_index(word) >> shift;
    if shift + width > 32u {
        number |= tvq_index(word + 1u) << (32u - shift);
    }
    return number & ((1u << width) - 1u);
}

fn tvq_entry(i: u32) -> i32 {
    let lane = i & ((1u << tvq_lanes_log2) - 1u);
    let code = (tvq_codebook(i >> tvq_lanes_log2) >> (lane * tvq_entry_bits)) & ((1u << tvq_entry_bits) - 1u);
    return i32(code) - i32(1u << (tvq_entry_bits - 1u));
}

fn tvq_width(form: u32) -> u32 {
    return form & 31u;
}

fn tvq_shown(form: u32) -> bool {
    return (form >> 16u) < tvq_stages();
}

fn tvq_term(book: u32, form: u32, code: u32, place: u32) -> i32 {
    return tvq_entry(tvq_tables(book) + code * 64u + place) * i32(1u << ((form >> 8u) & 31u));
}

fn tvq_numbered(p: vec3<u32>, size: vec3<u32>) -> u32 {
    return (p.z * size.y + p.y) * size.x + p.x;
}

fn tvq_table(block: vec3<u32>) -> u32 {
    return tvq_numbered(block / tvq_sub_blocks, tvq_sub_grid) * tvq_table_words;
}

fn tvq_mean(table: u32, code: u32) -> i32 {
    return i32(code << tvq_tables(table));
}

fn tvq_fixed(block: vec3<u32>, channel: u32, place: u32) -> i32 {
    let table = tvq_table(block);
    let first = block / tvq_sub_blocks * tvq_sub_blocks;
    let size = min(tvq_sub_blocks, tvq_grid - first);
    let n = tvq_numbered(block - first, size);
    let count = size.x * size.y * size.z;
    let start = tvq_tables(table + 3u) + channel * tvq_tables(table + 4u);
    let width = tvq_tables(table + 1u);
    var sum = tvq_mean(table, tvq_tables(table + 2u) + tvq_number(start, n * width, width));
    var bit = count * width;
    for (var b = 0u; b < tvq_books; b++) {
        let book = table + 5u + 3u * b;
        let form = tvq_tables(book + 2u);
        let width = tvq_width(form);
        if tvq_shown(form) {
            sum += tvq_term(book, form, tvq_number(start, bit + n * width, width), place);
        }
        bit += count * width;
    }
    return sum;
}

fn tvq_below(low: u32, high: u32, n: u32) -> u32 {
    if n < 32u {
        return countOneBits(low & ((1u << n) - 1u));
    }
    return countOneBits(low) + countOneBits(high & ((1u << (n - 32u)) - 1u));
}

fn tvq_bit(low: u32, high: u32, n: u32) -> u32 {
    if n < 32u {
        return (low >> n) & 1u;
    }
    return (high >> (n - 32u)) & 1u;
}

fn tvq_kept(block: vec3<u32>, channel: u32, place: u32) -> i32 {
    let table = tvq_table(block);
    let brick = block / 4u;
    let size = min(vec3<u32>(4u), tvq_grid - brick * 4u);
    let n = tvq_numbered(block - brick * 4u, size);
    let bricks = tvq_bricks.x * tvq_bricks.y * tvq_bricks.z;
    let head = (channel * bricks + tvq_numbered(brick, tvq_bricks)) * 2u;
    var start = tvq_heads(head);
    let form = tvq_heads(head + 1u);
    let planes = form >> 24u;
    var before = 0u;
    var count = 0u;
    for (var j = 0u; j < planes; j++) {
        let low = tvq_index(start);
        let high = tvq_index(start + 1u);
        before += tvq_below(low, high, n) << j;
        count += tvq_bit(low, high, n) << j;
        start += 2u;
    }
    let mean_width = (form >> 16u) & 31u;
    var sum = tvq_mean(table, (form & 0xffffu) + tvq_number(start, n * mean_width, mean_width));
    let width = tvq_tables(table + 1u);
    let bit = size.x * size.y * size.z * mean_width + before * width;
    for (var b = 0u; b < count; b++) {
        let book = table + 5u + 3u * b;
        let form = tvq_tables(book + 2u);
        if tvq_shown(form) {
            sum += tvq_term(book, form, tvq_number(start, bit + b * width, width), place);
        }
    }
    return sum;
}

fn tvq_sum(block: vec3<u32>, channel: u32, place: u32) -> i32 {
    if tvq_variable == 1u {
        return tvq_kept(block, channel, place);
    }
    return tvq_fixed(block, channel, place);
}

fn tvq_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    let block = v / 4u;
    let place = tvq_numbered(v - block * 4u, vec3<u32>(4u));
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < tvq_channels; c++) {
        out[c] = tvq_value(tvq_sum(block, c, place));
    }
    return out;
}
