// Voxels and cells out of codes and codewords: the twin of decode.rs. What differs between the payloads stands behind it, in
// decode/fixed.wgsl or decode/variable.wgsl.
//
// Constants: rvq_grid (vec3<u32>), rvq_channels, rvq_all_stages, rvq_codewords, rvq_index_bits, rvq_form (0 = entries of 8
// bits, 1 = 16, 2 = 11-11-10), rvq_firsts (vec3<u32>: first entry of the codewords of each resolution), rvq_one_table,
// rvq_scales_low (vec3<u32>) and rvq_scales_high (the scales of the only table), rvq_offset, rvq_unit.
// Resources: rvq_index, rvq_codebook, rvq_scales.

// A codeword: its first entry, and the units of the sums that its entries count.
struct rvq_Term {
    first: u32,
    units: i32,
}

struct rvq_Ends {
    low: rvq_Term,
    high: rvq_Term,
}

// The blocks at both ends of a cell's row along x.
struct rvq_Row {
    low: rvq_Codes,
    high: rvq_Codes,
}

fn rvq_value(sum: i32) -> f32 {
    return rvq_offset + rvq_unit * f32(clamp(sum, 0, 65535));
}

fn rvq_values(sum: vec3<i32>) -> vec4<f32> {
    if rvq_channels == 1u {
        return vec4<f32>(rvq_value(sum.x), 0.0, 0.0, 0.0);
    }
    return vec4<f32>(rvq_value(sum.x), rvq_value(sum.y), rvq_value(sum.z), 0.0);
}

fn rvq_edge() -> u32 {
    return 4u >> rvq_resolution();
}

fn rvq_shown() -> u32 {
    return min(rvq_stages(), rvq_all_stages);
}

// Units of the sums that an entry of a stage counts.
fn rvq_units(stage: u32) -> i32 {
    var word = 0u;
    if rvq_one_table == 0u {
        word = rvq_scales(stage >> 2u);
    } else if stage < 12u {
        word = rvq_scales_low[stage >> 2u];
    } else {
        word = rvq_scales_high;
    }
    let scale = word >> (8u * (stage & 3u));
    return i32(((8u + ((scale >> 5u) & 7u)) << (scale & 31u)) >> 3u);
}

// Entries of a voxel: one of three colours, or one for each channel.
fn rvq_per_voxel() -> u32 {
    if rvq_form == 2u {
        return 1u;
    }
    return rvq_channels;
}

// First entry of the codeword of a block at a stage.
fn rvq_codeword(codes: rvq_Codes, stage: u32) -> u32 {
    let edge = rvq_edge();
    let size = edge * edge * edge * rvq_per_voxel();
    return rvq_firsts[rvq_resolution()] + (stage * rvq_codewords + rvq_code(codes, stage)) * size;
}

// First entry of a voxel of a codeword.
fn rvq_place(inside: vec3<u32>) -> u32 {
    let edge = rvq_edge();
    return ((inside.z * edge + inside.y) * edge + inside.x) * rvq_per_voxel();
}

fn rvq_word(entry: u32) -> u32 {
    if rvq_form == 0u {
        return rvq_codebook(entry >> 2u);
    }
    if rvq_form == 1u {
        return rvq_codebook(entry >> 1u);
    }
    return rvq_codebook(entry);
}

// Whether two entries lie in one word.
fn rvq_together(a: u32, b: u32) -> bool {
    if rvq_form == 0u {
        return (a >> 2u) == (b >> 2u);
    }
    if rvq_form == 1u {
        return (a >> 1u) == (b >> 1u);
    }
    return a == b;
}

fn rvq_lane(word: u32, entry: u32) -> i32 {
    if rvq_form == 0u {
        return i32((word >> (8u * (entry & 3u))) & 0xffu) - 0x80;
    }
    return i32((word >> (16u * (entry & 1u))) & 0xffffu) - 0x8000;
}

// All channels of a voxel, whose first entry lies in a word that is there.
fn rvq_entry(word: u32, entry: u32) -> vec3<i32> {
    if rvq_form == 2u {
        let codes = vec3<u32>((word & 0x7ffu) << 5u, ((word >> 11u) & 0x7ffu) << 5u, (word >> 22u) << 6u);
        return vec3<i32>(codes) - 0x8000;
    }
    let first = rvq_lane(word, entry);
    if rvq_channels == 1u {
        return vec3<i32>(first, 0, 0);
    }
    return vec3<i32>(
        first,
        rvq_lane(rvq_word(entry + 1u), entry + 1u),
        rvq_lane(rvq_word(entry + 2u), entry + 2u),
    );
}

fn rvq_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    let block = v / rvq_edge();
    let codes = rvq_codes(block);
    let place = rvq_place(v - block * rvq_edge());
    var sum = rvq_base(codes) + rvq_rest(codes, v - block * rvq_edge());
    for (var s = 0u; s < rvq_count(codes); s++) {
        let entry = rvq_codeword(codes, s) + place;
        sum += rvq_entry(rvq_word(entry), entry) * rvq_units(s);
    }
    return rvq_values(sum);
}

fn rvq_row(low_x: u32, high_x: u32, y: u32, z: u32) -> rvq_Row {
    let low = rvq_codes(vec3<u32>(low_x, y, z));
    if low_x == high_x {
        return rvq_Row(low, low);
    }
    return rvq_Row(low, rvq_codes(vec3<u32>(high_x, y, z)));
}

// First entry of the codeword of a block at a stage, and the units that its entries count: 0 where the block has none.
fn rvq_term(codes: rvq_Codes, stage: u32, units: i32) -> rvq_Term {
    if stage >= rvq_count(codes) {
        return rvq_Term(0u, 0);
    }
    return rvq_Term(rvq_codeword(codes, stage), units);
}

// The same at both ends of a row.
fn rvq_ends(row: rvq_Row, stage: u32, units: i32, crossed: bool) -> rvq_Ends {
    let low = rvq_term(row.low, stage, units);
    if !crossed {
        return rvq_Ends(low, low);
    }
    return rvq_Ends(low, rvq_term(row.high, stage, units));
}

// What the codewords of a row add at its ends.
fn rvq_pair(ends: rvq_Ends, places: vec2<u32>) -> array<vec3<i32>, 2> {
    let low = ends.low.first + places.x;
    let high = ends.high.first + places.y;
    let low_word = rvq_word(low);
    var high_word = low_word;
    if !rvq_together(low, high) {
        high_word = rvq_word(high);
    }
    return array<vec3<i32>, 2>(rvq_entry(low_word, low) * ends.low.units, rvq_entry(high_word, high) * ends.high.units);
}

// What a row begins with at its ends: everything but codewords.
fn rvq_begun(row: rvq_Row, low: vec3<u32>, high: vec3<u32>) -> array<vec3<i32>, 2> {
    return array<vec3<i32>, 2>(
        rvq_base(row.low) + rvq_rest(row.low, low),
        rvq_base(row.high) + rvq_rest(row.high, high),
    );
}

// Stages that a row needs.
fn rvq_row_count(row: rvq_Row) -> u32 {
    return max(rvq_count(row.low), rvq_count(row.high));
}

fn rvq_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    let v = vec3<u32>(p);
    let w = vec3<u32>(q);
    let low = v / rvq_edge();
    let high = w / rvq_edge();
    let a = v - low * rvq_edge();
    let b = w - high * rvq_edge();
    let crossed = low != high;
    let row_00 = rvq_row(low.x, high.x, low.y, low.z);
    var row_10 = row_00;
    if crossed.y {
        row_10 = rvq_row(low.x, high.x, high.y, low.z);
    }
    var row_01 = row_00;
    var row_11 = row_10;
    if crossed.z {
        row_01 = rvq_row(low.x, high.x, low.y, high.z);
        row_11 = row_01;
        if crossed.y {
            row_11 = rvq_row(low.x, high.x, high.y, high.z);
        }
    }
    let place_00 = vec2<u32>(rvq_place(a), rvq_place(vec3<u32>(b.x, a.y, a.z)));
    let place_10 = vec2<u32>(rvq_place(vec3<u32>(a.x, b.y, a.z)), rvq_place(vec3<u32>(b.x, b.y, a.z)));
    let place_01 = vec2<u32>(rvq_place(vec3<u32>(a.x, a.y, b.z)), rvq_place(vec3<u32>(b.x, a.y, b.z)));
    let place_11 = vec2<u32>(rvq_place(vec3<u32>(a.x, b.y, b.z)), rvq_place(b));
    let begun_00 = rvq_begun(row_00, a, vec3<u32>(b.x, a.y, a.z));
    let begun_10 = rvq_begun(row_10, vec3<u32>(a.x, b.y, a.z), vec3<u32>(b.x, b.y, a.z));
    let begun_01 = rvq_begun(row_01, vec3<u32>(a.x, a.y, b.z), vec3<u32>(b.x, a.y, b.z));
    let begun_11 = rvq_begun(row_11, vec3<u32>(a.x, b.y, b.z), b);
    var sum_000 = begun_00[0];
    var sum_100 = begun_00[1];
    var sum_010 = begun_10[0];
    var sum_110 = begun_10[1];
    var sum_001 = begun_01[0];
    var sum_101 = begun_01[1];
    var sum_011 = begun_11[0];
    var sum_111 = begun_11[1];
    let count_0 = max(rvq_row_count(row_00), rvq_row_count(row_10));
    let count = max(count_0, max(rvq_row_count(row_01), rvq_row_count(row_11)));
    for (var s = 0u; s < count; s++) {
        let units = rvq_units(s);
        let ends_00 = rvq_ends(row_00, s, units, crossed.x);
        var ends_10 = ends_00;
        if crossed.y {
            ends_10 = rvq_ends(row_10, s, units, crossed.x);
        }
        var ends_01 = ends_00;
        var ends_11 = ends_10;
        if crossed.z {
            ends_01 = rvq_ends(row_01, s, units, crossed.x);
            ends_11 = ends_01;
            if crossed.y {
                ends_11 = rvq_ends(row_11, s, units, crossed.x);
            }
        }
        let pair_00 = rvq_pair(ends_00, place_00);
        let pair_10 = rvq_pair(ends_10, place_10);
        let pair_01 = rvq_pair(ends_01, place_01);
        let pair_11 = rvq_pair(ends_11, place_11);
        sum_000 += pair_00[0];
        sum_100 += pair_00[1];
        sum_010 += pair_10[0];
        sum_110 += pair_10[1];
        sum_001 += pair_01[0];
        sum_101 += pair_01[1];
        sum_011 += pair_11[0];
        sum_111 += pair_11[1];
    }
    return array<vec4<f32>, 8>(
        rvq_values(sum_000),
        rvq_values(sum_100),
        rvq_values(sum_010),
        rvq_values(sum_110),
        rvq_values(sum_001),
        rvq_values(sum_101),
        rvq_values(sum_011),
        rvq_values(sum_111),
    );
}
