// Voxels and cells out of means and sums of codewords: the twin of decode.rs. What differs between the payloads stands behind
// it, in decode/fixed.wgsl or decode/variable.wgsl.
//
// Constants: tvq_grid, tvq_sub_blocks, tvq_sub_grid (vec3<u32>), tvq_channels, tvq_books, tvq_table_words,
// tvq_entry_bits, tvq_lanes_log2, tvq_offset, tvq_unit. If tvq_one_table is 1, words of the only table: tvq_one_means,
// tvq_one_planes, and of its first three codebooks tvq_one_firsts, tvq_one_forms (vec3<u32>).
// Resources: tvq_tables, tvq_codebook, tvq_index, tvq_heads.

// The blocks at both ends of a cell's row along x.
struct tvq_Row {
    low: tvq_Terms,
    high: tvq_Terms,
}

// The rows of a cell, and the axes along which it reaches into another block.
struct tvq_Rows {
    row_00: tvq_Row,
    row_10: tvq_Row,
    row_01: tvq_Row,
    row_11: tvq_Row,
    crossed: vec3<bool>,
}

// The codewords there: first entries and scales.
struct tvq_Codewords {
    low: vec2<u32>,
    high: vec2<u32>,
}

fn tvq_value(sum: i32) -> f32 {
    return tvq_offset + tvq_unit * f32(clamp(sum, 0, 65535));
}

fn tvq_lane(word: u32, i: u32) -> i32 {
    let lane = i & ((1u << tvq_lanes_log2) - 1u);
    let code = (word >> (lane * tvq_entry_bits)) & ((1u << tvq_entry_bits) - 1u);
    return i32(code) - i32(1u << (tvq_entry_bits - 1u));
}

fn tvq_entry(i: u32) -> i32 {
    return tvq_lane(tvq_codebook(i >> tvq_lanes_log2), i);
}

fn tvq_numbered(p: vec3<u32>, size: vec3<u32>) -> u32 {
    return (p.z * size.y + p.y) * size.x + p.x;
}

// Shift of the means, width, smallest mean.
fn tvq_means(table: u32) -> vec3<u32> {
    if tvq_one_table == 1u {
        return tvq_one_means;
    }
    return vec3<u32>(tvq_tables(table), tvq_tables(table + 1u), tvq_tables(table + 2u));
}

// First entry and form of a codebook.
fn tvq_book(table: u32, b: u32) -> vec2<u32> {
    if tvq_one_table == 1u && tvq_books <= 3u {
        return vec2<u32>(tvq_one_firsts[b], tvq_one_forms[b]);
    }
    let book = table + 5u + 3u * b;
    return vec2<u32>(tvq_tables(book), tvq_tables(book + 2u));
}

fn tvq_shown(form: u32) -> bool {
    return (form >> 16u) < tvq_stages();
}

fn tvq_scale(form: u32) -> u32 {
    return ((8u + ((form >> 13u) & 7u)) << ((form >> 8u) & 31u)) >> 3u;
}

fn tvq_sub(block: vec3<u32>) -> vec3<u32> {
    if tvq_one_table == 1u {
        return vec3<u32>(0u);
    }
    return block / tvq_sub_blocks;
}

// First entry of the codeword of codebook b, and the scale of its entries: 0 where the block has none.
fn tvq_codeword(terms: tvq_Terms, b: u32) -> vec2<u32> {
    let book = tvq_book(terms.table, b);
    if b >= terms.count || !tvq_shown(book.y) {
        return vec2<u32>(book.x, 0u);
    }
    return vec2<u32>(book.x + tvq_code(terms, b, book.y) * 64u, tvq_scale(book.y));
}

// The value that the codeword of codebook b adds.
fn tvq_part(terms: tvq_Terms, b: u32, place: u32) -> i32 {
    let word = tvq_codeword(terms, b);
    if word.y == 0u {
        return 0;
    }
    return tvq_entry(word.x + place) * i32(word.y);
}

fn tvq_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    let block = v / 4u;
    let place = tvq_numbered(v - block * 4u, vec3<u32>(4u));
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < tvq_channels; c++) {
        out[c] = tvq_value(tvq_sum(tvq_terms(block, c), place));
    }
    return out;
}

fn tvq_row(low_x: u32, high_x: u32, y: u32, z: u32, channel: u32) -> tvq_Row {
    let low = tvq_terms(vec3<u32>(low_x, y, z), channel);
    if high_x == low_x {
        return tvq_Row(low, low);
    }
    return tvq_Row(low, tvq_terms(vec3<u32>(high_x, y, z), channel));
}

fn tvq_codewords(row: tvq_Row, b: u32, crossed: bool) -> tvq_Codewords {
    let low = tvq_codeword(row.low, b);
    if !crossed {
        return tvq_Codewords(low, low);
    }
    return tvq_Codewords(low, tvq_codeword(row.high, b));
}

// The values that the codewords of a row add at its ends. If one word holds both entries, it is fetched once. This is
// so within a block if entries have 8 bits.
fn tvq_pair(words: tvq_Codewords, low_place: u32, high_place: u32) -> vec2<i32> {
    let low = words.low.x + low_place;
    let high = words.high.x + high_place;
    let low_word = tvq_codebook(low >> tvq_lanes_log2);
    var high_word = low_word;
    if (high >> tvq_lanes_log2) != (low >> tvq_lanes_log2) {
        high_word = tvq_codebook(high >> tvq_lanes_log2);
    }
    return vec2<i32>(tvq_lane(low_word, low), tvq_lane(high_word, high))
        * vec2<i32>(i32(words.low.y), i32(words.high.y));
}

// The values that one codebook adds at the corners of a cell. A pair is x = 0 and x = 1; y and z go from pair to pair.
// `places` are the low and high ends of the rows.
fn tvq_added(rows: tvq_Rows, places: array<vec2<u32>, 4>, b: u32) -> array<vec2<i32>, 4> {
    let words_00 = tvq_codewords(rows.row_00, b, rows.crossed.x);
    var words_10 = words_00;
    if rows.crossed.y {
        words_10 = tvq_codewords(rows.row_10, b, rows.crossed.x);
    }
    var words_01 = words_00;
    var words_11 = words_10;
    if rows.crossed.z {
        words_01 = tvq_codewords(rows.row_01, b, rows.crossed.x);
        words_11 = words_01;
        if rows.crossed.y {
            words_11 = tvq_codewords(rows.row_11, b, rows.crossed.x);
        }
    }
    return array<vec2<i32>, 4>(
        tvq_pair(words_00, places[0].x, places[0].y),
        tvq_pair(words_10, places[1].x, places[1].y),
        tvq_pair(words_01, places[2].x, places[2].y),
        tvq_pair(words_11, places[3].x, places[3].y),
    );
}

fn tvq_plus(a: array<vec2<i32>, 4>, b: array<vec2<i32>, 4>) -> array<vec2<i32>, 4> {
    return array<vec2<i32>, 4>(a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]);
}

// The sums of a channel at the corners of a cell.
fn tvq_corners(v: vec3<u32>, w: vec3<u32>, channel: u32) -> array<vec2<i32>, 4> {
    let low = v / 4u;
    let high = w / 4u;
    let crossed = low != high;
    let row_00 = tvq_row(low.x, high.x, low.y, low.z, channel);
    var row_10 = row_00;
    if crossed.y {
        row_10 = tvq_row(low.x, high.x, high.y, low.z, channel);
    }
    var row_01 = row_00;
    var row_11 = row_10;
    if crossed.z {
        row_01 = tvq_row(low.x, high.x, low.y, high.z, channel);
        row_11 = row_01;
        if crossed.y {
            row_11 = tvq_row(low.x, high.x, high.y, high.z, channel);
        }
    }
    let rows = tvq_Rows(row_00, row_10, row_01, row_11, crossed);
    let a = v & vec3<u32>(3u);
    let b = w & vec3<u32>(3u);
    let ends = vec2<u32>(a.x, b.x);
    let places = array<vec2<u32>, 4>(
        16u * a.z + 4u * a.y + ends,
        16u * a.z + 4u * b.y + ends,
        16u * b.z + 4u * a.y + ends,
        16u * b.z + 4u * b.y + ends,
    );
    let means = array<vec2<i32>, 4>(
        vec2<i32>(row_00.low.mean, row_00.high.mean),
        vec2<i32>(row_10.low.mean, row_10.high.mean),
        vec2<i32>(row_01.low.mean, row_01.high.mean),
        vec2<i32>(row_11.low.mean, row_11.high.mean),
    );
    return tvq_all_added(rows, places, means);
}

fn tvq_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    let v = vec3<u32>(p);
    let w = vec3<u32>(q);
    var out: array<vec4<f32>, 8>;
    for (var c = 0u; c < tvq_channels; c++) {
        let sums = tvq_corners(v, w, c);
        out[0][c] = tvq_value(sums[0].x);
        out[1][c] = tvq_value(sums[0].y);
        out[2][c] = tvq_value(sums[1].x);
        out[3][c] = tvq_value(sums[1].y);
        out[4][c] = tvq_value(sums[2].x);
        out[5][c] = tvq_value(sums[2].y);
        out[6][c] = tvq_value(sums[3].x);
        out[7][c] = tvq_value(sums[3].y);
    }
    return out;
}
