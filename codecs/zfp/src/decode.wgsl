// One voxel out of the bits of its block: the twin of decode.rs, function for function.
//
// Constants: zfp_grid (vec3<u32>, blocks), zfp_channels, zfp_channel_words, zfp_block_bits. Resource: zfp_blocks.

struct zfp_Block {
    // Column 4 y + x, from z = 0 on.
    columns: array<vec4<i32>, 16>,
    // As it is stored: 1 is 2^(157 - exponent) units. 0 where all is 0.
    exponent: u32,
}

// A place is a word, and a bit of it, where a block begins.
fn zfp_take(place: vec2<u32>, at: u32, count: u32) -> u32 {
    if count == 0u {
        return 0u;
    }
    let bit = place.y + at;
    let word = place.x + (bit >> 5u);
    let shift = bit & 31u;
    var bits = zfp_blocks(word) >> shift;
    if shift + count > 32u {
        bits |= zfp_blocks(word + 1u) << (32u - shift);
    }
    return bits & (0xffffffffu >> (32u - count));
}

// Coefficients from the lowest frequency on, in negabinary: planes from the highest down, until a block's bits end.
fn zfp_coefficients(place: vec2<u32>) -> array<u32, 64> {
    var out: array<u32, 64>;
    var at = 9u;
    var reached = 0u;
    var plane = 32u;
    while plane > 0u && at < zfp_block_bits {
        plane--;
        let known = min(reached, zfp_block_bits - at);
        for (var first = 0u; first < known; first += 32u) {
            var bits = zfp_take(place, at + first, min(known - first, 32u));
            while bits != 0u {
                out[first + firstTrailingBit(bits)] |= 1u << plane;
                bits &= bits - 1u;
            }
        }
        at += known;
        var announced = false;
        while at < zfp_block_bits && reached < 64u {
            let width = min(zfp_block_bits - at, 32u);
            var window = zfp_take(place, at, width);
            var span = width;
            if !announced {
                at++;
                if (window & 1u) == 0u {
                    break;
                }
                window >>= 1u;
                span--;
            }
            // The last coefficient needs no bit: the test has told it.
            span = min(span, 63u - reached);
            let zeros = min(firstTrailingBit(window), span);
            reached += zeros;
            at += zeros + select(0u, 1u, zeros < span);
            announced = zeros == span && at < zfp_block_bits && reached < 63u;
            if !announced {
                out[reached] |= 1u << plane;
                reached++;
            }
        }
    }
    return out;
}

// The mean of two numbers and by how much the second is larger, to both.
fn zfp_join(mean: i32, larger: i32) -> vec2<i32> {
    let q = mean + larger;
    return vec2<i32>(mean + mean - q, q);
}

fn zfp_inverse(c: vec4<i32>) -> vec4<i32> {
    let second = c.y + (c.w >> 1u);
    let last = c.w - (second >> 1u);
    let slopes = zfp_join(last, second);
    let means = zfp_join(c.x, c.z);
    let inner = zfp_join(means.y, slopes.y);
    let outer = zfp_join(means.x, slopes.x);
    return vec4<i32>(outer.x, inner.y, inner.x, outer.y);
}

fn zfp_column(a: u32, b: u32, c: u32, d: u32) -> vec4<i32> {
    let negabinary = vec4<u32>(0xaaaaaaaau);
    return zfp_inverse(bitcast<vec4<i32>>((vec4<u32>(a, b, c, d) ^ negabinary) - negabinary));
}

fn zfp_place(block: vec3<u32>, channel: u32) -> vec2<u32> {
    let b = (block.z * zfp_grid.y + block.y) * zfp_grid.x + block.x;
    let bit = (b & 31u) * zfp_block_bits;
    let word = channel * zfp_channel_words + (b >> 5u) * zfp_block_bits + (bit >> 5u);
    return vec2<u32>(word, bit & 31u);
}

fn zfp_block(block: vec3<u32>, channel: u32) -> zfp_Block {
    let place = zfp_place(block, channel);
    var out: zfp_Block;
    let header = zfp_take(place, 0u, 9u);
    if (header & 1u) == 0u {
        return out;
    }
    out.exponent = header >> 1u;
    let c = zfp_coefficients(place);
    out.columns[0] = zfp_column(c[0], c[3], c[9], c[19]);
    out.columns[1] = zfp_column(c[1], c[5], c[15], c[30]);
    out.columns[2] = zfp_column(c[7], c[12], c[24], c[42]);
    out.columns[3] = zfp_column(c[17], c[27], c[39], c[52]);
    out.columns[4] = zfp_column(c[2], c[4], c[16], c[31]);
    out.columns[5] = zfp_column(c[6], c[10], c[22], c[37]);
    out.columns[6] = zfp_column(c[11], c[20], c[33], c[49]);
    out.columns[7] = zfp_column(c[26], c[35], c[46], c[58]);
    out.columns[8] = zfp_column(c[8], c[13], c[23], c[43]);
    out.columns[9] = zfp_column(c[14], c[21], c[32], c[50]);
    out.columns[10] = zfp_column(c[25], c[34], c[44], c[56]);
    out.columns[11] = zfp_column(c[38], c[45], c[54], c[61]);
    out.columns[12] = zfp_column(c[18], c[28], c[40], c[51]);
    out.columns[13] = zfp_column(c[29], c[36], c[47], c[57]);
    out.columns[14] = zfp_column(c[41], c[48], c[55], c[60]);
    out.columns[15] = zfp_column(c[53], c[59], c[62], c[63]);
    return out;
}

// A row along x, transformed back along y.
fn zfp_row(block: ptr<function, zfp_Block>, y: u32, z: u32) -> vec4<i32> {
    var row: vec4<i32>;
    for (var x = 0u; x < 4u; x++) {
        row[x] = zfp_inverse(vec4<i32>(
            (*block).columns[x][z], (*block).columns[4u + x][z],
            (*block).columns[8u + x][z], (*block).columns[12u + x][z],
        ))[y];
    }
    return row;
}

// An integer as a single, rounded to nearest, ties to even, times 2^(exponent - 157).
fn zfp_value(integer: i32, exponent: u32) -> f32 {
    let bits_of = bitcast<u32>(integer);
    let sign = bits_of & 0x80000000u;
    let magnitude = select(bits_of, 0u - bits_of, sign != 0u);
    if magnitude == 0u {
        return 0.0;
    }
    let top = firstLeadingBit(magnitude);
    var mantissa = magnitude << (23u - min(top, 23u));
    if top > 23u {
        let shift = top - 23u;
        mantissa = (magnitude + ((1u << (shift - 1u)) - 1u) + ((magnitude >> shift) & 1u)) >> shift;
    }
    let raised = top + exponent;
    if raised < 30u {
        return 0.0;
    }
    if raised >= 285u {
        return bitcast<f32>(sign | 0x7f7fffffu);
    }
    let bits = ((raised - 30u) << 23u) + mantissa - 0x800000u;
    if bits < 0x800000u {
        return 0.0;
    }
    return bitcast<f32>(sign | min(bits, 0x7f7fffffu));
}

fn zfp_voxel(block: ptr<function, zfp_Block>, inside: vec3<u32>) -> f32 {
    return zfp_value(zfp_inverse(zfp_row(block, inside.y, inside.z))[inside.x], (*block).exponent);
}

fn zfp_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < zfp_channels; c++) {
        var block = zfp_block(v / 4u, c);
        out[c] = zfp_voxel(&block, v % 4u);
    }
    return out;
}

fn zfp_end(p: vec3<u32>, q: vec3<u32>, i: u32) -> vec3<u32> {
    return select(p, q, (vec3<u32>(i, i >> 1u, i >> 2u) & vec3<u32>(1u)) == vec3<u32>(1u));
}

fn zfp_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    let v = vec3<u32>(p);
    let w = vec3<u32>(q);
    // Axes along which the cell reaches into another block.
    let other = select(vec3<u32>(0u), vec3<u32>(1u, 2u, 4u), v / 4u != w / 4u);
    let crossed = other.x | other.y | other.z;
    var out: array<vec4<f32>, 8>;
    for (var c = 0u; c < zfp_channels; c++) {
        for (var b = 0u; b < 8u; b++) {
            if (b & ~crossed) != 0u {
                continue;
            }
            var block = zfp_block(zfp_end(v / 4u, w / 4u, b), c);
            for (var i = 0u; i < 8u; i++) {
                if (i & crossed) == b {
                    out[i][c] = zfp_voxel(&block, zfp_end(v % 4u, w % 4u, i));
                }
            }
        }
    }
    return out;
}
