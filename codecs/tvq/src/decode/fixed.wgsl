// The payload fixed: a mean and one code of every codebook for every block.

// What a block is the sum of, but for the place in it.
struct tvq_Terms {
    mean: i32,
    table: u32,
    // How many codebooks there are codes of.
    count: u32,
    // The mean's code and those of all codebooks, 64 bits at most.
    record: vec2<u32>,
}

// The bits from bit 0 of a record on: as many as are asked for, 64 at most, and others behind them.
fn tvq_record(first: u32, bit: u32, bits: u32) -> vec2<u32> {
    let word = first + (bit >> 5u);
    let shift = bit & 31u;
    var record = vec2<u32>(tvq_index(word) >> shift, 0u);
    if bits != 32u || shift != 0u {
        if shift + bits > 32u {
            let next = tvq_index(word + 1u);
            if shift == 0u {
                record.y = next;
            } else {
                record.x |= next << (32u - shift);
                record.y = next >> shift;
            }
        }
    }
    if bits > 32u && shift + bits > 64u {
        record.y |= tvq_index(word + 2u) << (32u - shift);
    }
    return record;
}

// The number of so many bits, 16 at most, from a bit of a record on.
fn tvq_field(record: vec2<u32>, bit: u32, width: u32) -> u32 {
    var number = 0u;
    if bit >= 32u {
        number = record.y >> (bit - 32u);
    } else {
        number = record.x >> bit;
        if bit + width > 32u {
            number |= record.y << (32u - bit);
        }
    }
    return number & ((1u << width) - 1u);
}

fn tvq_start(table: u32, channel: u32) -> u32 {
    if tvq_one_table == 1u {
        return tvq_one_planes.x + channel * tvq_one_planes.y;
    }
    return tvq_tables(table + 3u) + channel * tvq_tables(table + 4u);
}

// Bits of a block's mean and of its codes of the codebooks before codebook b, 3 at most.
fn tvq_before(table: u32, b: u32) -> u32 {
    var bits = tvq_means(table).y;
    if b > 0u {
        bits += tvq_book(table, 0u).y & 31u;
    }
    if b > 1u {
        bits += tvq_book(table, 1u).y & 31u;
    }
    if b > 2u {
        bits += tvq_book(table, 2u).y & 31u;
    }
    return bits;
}

fn tvq_terms(block: vec3<u32>, channel: u32) -> tvq_Terms {
    let sub = tvq_sub(block);
    let table = tvq_numbered(sub, tvq_sub_grid) * tvq_table_words;
    let first = sub * tvq_sub_blocks;
    let size = min(tvq_sub_blocks, tvq_grid - first);
    let n = tvq_numbered(block - first, size);
    let bits = tvq_before(table, tvq_books);
    let record = tvq_record(tvq_start(table, channel), n * bits, bits);
    let means = tvq_means(table);
    let mean = i32((means.z + tvq_field(record, 0u, means.y)) << means.x);
    return tvq_Terms(mean, table, tvq_books, record);
}

fn tvq_code(terms: tvq_Terms, b: u32, form: u32) -> u32 {
    return tvq_field(terms.record, tvq_before(terms.table, b), form & 31u);
}

// Three codebooks: without a loop their forms are constants.
fn tvq_sum(terms: tvq_Terms, place: u32) -> i32 {
    return terms.mean + tvq_part(terms, 0u, place) + tvq_part(terms, 1u, place) + tvq_part(terms, 2u, place);
}

// What is added to the means at the corners of a cell: see tvq_added.
fn tvq_all_added(rows: tvq_Rows, places: array<vec2<u32>, 4>, means: array<vec2<i32>, 4>) -> array<vec2<i32>, 4> {
    var sums = tvq_plus(means, tvq_added(rows, places, 0u));
    sums = tvq_plus(sums, tvq_added(rows, places, 1u));
    return tvq_plus(sums, tvq_added(rows, places, 2u));
}
