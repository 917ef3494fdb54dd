// The payload variable: as many codes as a block needs, which its group says; and what is coded directly.
//
// Constants of this payload: tvq_groups (vec3<u32>), tvq_parts. Functions of groups.wgsl stand behind this file.

// What a block is the sum of, but for the place in it.
struct tvq_Terms {
    mean: i32,
    table: u32,
    // How many codebooks there are codes of.
    count: u32,
    // Bits of a code, and where the codes begin.
    width: u32,
    start: u32,
    bit: u32,
    // First word of what is coded directly, and bits of a voxel there: 0 where nothing is.
    rest: u32,
    rest_bits: u32,
}

fn tvq_terms(block: vec3<u32>, channel: u32) -> tvq_Terms {
    let table = tvq_numbered(tvq_sub(block), tvq_sub_grid) * tvq_table_words;
    let group = block / 4u;
    let size = min(vec3<u32>(4u), tvq_grid - group * 4u);
    let n = tvq_numbered(block - group * 4u, size);
    let groups = tvq_groups.x * tvq_groups.y * tvq_groups.z;
    let head = (channel * groups + tvq_numbered(group, tvq_groups)) * 2u;
    let means = tvq_means(table);
    let kept = tvq_block(head, n, size.x * size.y * size.z, means.y);
    let mean = i32(kept.mean << means.x);
    return tvq_Terms(mean, table, kept.count, means.y, kept.start, kept.bit, kept.rest, kept.rest_bits);
}

fn tvq_code(terms: tvq_Terms, b: u32, form: u32) -> u32 {
    return tvq_number(terms.start, terms.bit + b * terms.width, terms.width);
}

// What is coded directly belongs to the last stage.
fn tvq_rest(terms: tvq_Terms, place: u32) -> i32 {
    if terms.rest_bits == 0u || tvq_stages() < 4u {
        return 0;
    }
    return tvq_part_value(terms.rest, terms.rest_bits, place);
}

fn tvq_sum(terms: tvq_Terms, place: u32) -> i32 {
    var sum = terms.mean + tvq_rest(terms, place);
    for (var b = 0u; b < terms.count; b++) {
        sum += tvq_part(terms, b, place);
    }
    return sum;
}

fn tvq_row_rest(row: tvq_Row, places: vec2<u32>) -> vec2<i32> {
    return vec2<i32>(tvq_rest(row.low, places.x), tvq_rest(row.high, places.y));
}

// What is added to the means at the corners of a cell: see tvq_added.
fn tvq_all_added(rows: tvq_Rows, places: array<vec2<u32>, 4>, means: array<vec2<i32>, 4>) -> array<vec2<i32>, 4> {
    var sums = means;
    let counts_0 = vec4<u32>(rows.row_00.low.count, rows.row_00.high.count, rows.row_10.low.count, rows.row_10.high.count);
    let counts_1 = vec4<u32>(rows.row_01.low.count, rows.row_01.high.count, rows.row_11.low.count, rows.row_11.high.count);
    let counts = max(counts_0, counts_1);
    let books = max(max(counts.x, counts.y), max(counts.z, counts.w));
    for (var book = 0u; book < books; book++) {
        sums = tvq_plus(sums, tvq_added(rows, places, book));
    }
    let rests_0 = vec4<u32>(rows.row_00.low.rest_bits, rows.row_00.high.rest_bits, rows.row_10.low.rest_bits, rows.row_10.high.rest_bits);
    let rests_1 = vec4<u32>(rows.row_01.low.rest_bits, rows.row_01.high.rest_bits, rows.row_11.low.rest_bits, rows.row_11.high.rest_bits);
    if any((rests_0 | rests_1) != vec4<u32>(0u)) {
        sums[0] += tvq_row_rest(rows.row_00, places[0]);
        sums[1] += tvq_row_rest(rows.row_10, places[1]);
        sums[2] += tvq_row_rest(rows.row_01, places[2]);
        sums[3] += tvq_row_rest(rows.row_11, places[3]);
    }
    return sums;
}
