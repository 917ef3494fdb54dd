// Voxels and cells out of means and sums of codewords: the twin of decode.rs.
//
// Constants: tvq_grid, tvq_sub_blocks, tvq_sub_grid, tvq_bricks (vec3<u32>), tvq_channels, tvq_variable, tvq_books,
// tvq_table_words, tvq_entry_bits, tvq_lanes_log2, tvq_offset, tvq_unit. If tvq_one_table is 1, words of the only table:
// tvq_one_means, tvq_one_planes, and of its first three codebooks tvq_one_firsts, tvq_one_forms (vec3<u32>).
// Resources: tvq_tables, tvq_codebook, tvq_index, tvq_heads.

// What a block is the sum of, but for the place in it. Codes of codebook after codebook begin at a bit: as many of each as
// there are codes, of which the block's is number n.
struct tvq_Terms {
    mean: i32,
    table: u32,
    // How many codebooks there are codes of, and the bits of a code, where all have as many.
    count: u32,
    width: u32,
    start: u32,
    bit: u32,
    codes: u32,
    n: u32,
}

// The blocks at both ends of a cell's row along x.
struct tvq_Row {
    low: tvq_Terms,
    high: tvq_Terms,
}

// The codewords there: first entries and scales.
struct tvq_Codewords {
    low: vec2<u32>,
    high: vec2<u32>,
}

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

fn tvq_start(table: u32, channel: u32) -> u32 {
    if tvq_one_table == 1u {
        return tvq_one_planes.x + channel * tvq_one_planes.y;
    }
    return tvq_tables(table + 3u) + channel * tvq_tables(table + 4u);
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
    return 1u << ((form >> 8u) & 31u);
}

fn tvq_sub(block: vec3<u32>) -> vec3<u32> {
    if tvq_one_table == 1u {
        return vec3<u32>(0u);
    }
    return block / tvq_sub_blocks;
}

fn tvq_fixed(block: vec3<u32>, channel: u32) -> tvq_Terms {
    let sub = tvq_sub(block);
    let table = tvq_numbered(sub, tvq_sub_grid) * tvq_table_words;
    let first = sub * tvq_sub_blocks;
    let size = min(tvq_sub_blocks, tvq_grid - first);
    let n = tvq_numbered(block - first, size);
    let count = size.x * size.y * size.z;
    let means = tvq_means(table);
    let start = tvq_start(table, channel);
    let mean = i32((means.z + tvq_number(start, n * means.y, means.y)) << means.x);
    return tvq_Terms(mean, table, tvq_books, 0u, start, count * means.y, count, n);
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

fn tvq_kept(block: vec3<u32>, channel: u32) -> tvq_Terms {
    let table = tvq_numbered(tvq_sub(block), tvq_sub_grid) * tvq_table_words;
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
    let means = tvq_means(table);
    let mean_width = (form >> 16u) & 31u;
    let mean = i32(((form & 0xffffu) + tvq_number(start, n * mean_width, mean_width)) << means.x);
    let bit = size.x * size.y * size.z * mean_width + before * means.y;
    return tvq_Terms(mean, table, count, means.y, start, bit, 1u, 0u);
}

fn tvq_terms(block: vec3<u32>, channel: u32) -> tvq_Terms {
    if tvq_variable == 1u {
        return tvq_kept(block, channel);
    }
    return tvq_fixed(block, channel);
}

fn tvq_width(terms: tvq_Terms, form: u32) -> u32 {
    if tvq_variable == 1u {
        return terms.width;
    }
    return form & 31u;
}

// Bits of a block's codes of the codebooks before codebook b.
fn tvq_before(terms: tvq_Terms, b: u32) -> u32 {
    if tvq_variable == 1u {
        return b * terms.width;
    }
    var bits = 0u;
    for (var before = 0u; before < b; before++) {
        bits += tvq_book(terms.table, before).y & 31u;
    }
    return bits;
}

// First entry of the codeword of codebook b, and the scale of its entries: 0 where the block has none.
fn tvq_codeword(terms: tvq_Terms, b: u32) -> vec2<u32> {
    let book = tvq_book(terms.table, b);
    if b >= terms.count || !tvq_shown(book.y) {
        return vec2<u32>(book.x, 0u);
    }
    let width = tvq_width(terms, book.y);
    let bit = terms.bit + terms.codes * tvq_before(terms, b) + terms.n * width;
    return vec2<u32>(book.x + tvq_number(terms.start, bit, width) * 64u, tvq_scale(book.y));
}

fn tvq_sum(terms: tvq_Terms, place: u32) -> i32 {
    var sum = terms.mean;
    for (var b = 0u; b < terms.count; b++) {
        let word = tvq_codeword(terms, b);
        if word.y != 0u {
            sum += tvq_entry(word.x + place) * i32(word.y);
        }
    }
    return sum;
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

// What the codewords of a row add at its ends, the word fetched once when both entries are in it, as they are in one
// block where entries have 8 bits.
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

// The sums of a channel at the corners of a cell: x from 0 to 1 in a pair, y and z from pair to pair.
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
    var sum_00 = vec2<i32>(row_00.low.mean, row_00.high.mean);
    var sum_10 = vec2<i32>(row_10.low.mean, row_10.high.mean);
    var sum_01 = vec2<i32>(row_01.low.mean, row_01.high.mean);
    var sum_11 = vec2<i32>(row_11.low.mean, row_11.high.mean);
    var books = tvq_books;
    if tvq_variable == 1u {
        books = max(
            max(max(row_00.low.count, row_00.high.count), max(row_10.low.count, row_10.high.count)),
            max(max(row_01.low.count, row_01.high.count), max(row_11.low.count, row_11.high.count)),
        );
    }
    let a = v & vec3<u32>(3u);
    let b = w & vec3<u32>(3u);
    let place_00 = 16u * a.z + 4u * a.y;
    let place_10 = 16u * a.z + 4u * b.y;
    let place_01 = 16u * b.z + 4u * a.y;
    let place_11 = 16u * b.z + 4u * b.y;
    for (var book = 0u; book < books; book++) {
        let words_00 = tvq_codewords(row_00, book, crossed.x);
        var words_10 = words_00;
        if crossed.y {
            words_10 = tvq_codewords(row_10, book, crossed.x);
        }
        var words_01 = words_00;
        var words_11 = words_10;
        if crossed.z {
            words_01 = tvq_codewords(row_01, book, crossed.x);
            words_11 = words_01;
            if crossed.y {
                words_11 = tvq_codewords(row_11, book, crossed.x);
            }
        }
        sum_00 += tvq_pair(words_00, place_00 + a.x, place_00 + b.x);
        sum_10 += tvq_pair(words_10, place_10 + a.x, place_10 + b.x);
        sum_01 += tvq_pair(words_01, place_01 + a.x, place_01 + b.x);
        sum_11 += tvq_pair(words_11, place_11 + a.x, place_11 + b.x);
    }
    return array<vec2<i32>, 4>(sum_00, sum_10, sum_01, sum_11);
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
