// Decodes voxels and cells from the bits of their blocks. The twin of decode.rs, function for function.
//
// Constants: zfp_grid (vec3<u32>, blocks), zfp_channels, zfp_channel_words, zfp_block_bits. Resource: zfp_blocks.

struct zfp_Block {
    // Column 4 y + x, from z = 0 on.
    columns: array<vec4<i32>, 16>,
    // The stored exponent: 1 is 2^(157 - exponent) units. 0 if all values are 0.
    exponent: u32,
}

// A place is the start of a block: a word, and a bit in it.
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

// Bit planes, the lowest first in the result. They are read from the highest down until the block's bits end. Bit i of
// a plane's 64 bits belongs to coefficient i, counted from the lowest frequency. All invocations write the same plane
// at the same time.
fn zfp_planes(place: vec2<u32>) -> array<vec2<u32>, 32> {
    var out: array<vec2<u32>, 32>;
    var at = 9u;
    var reached = 0u;
    var plane = 32u;
    while plane > 0u && at < zfp_block_bits {
        plane--;
        let known = min(reached, zfp_block_bits - at);
        var low = zfp_take(place, at, min(known, 32u));
        var high = zfp_take(place, at + 32u, max(known, 32u) - 32u);
        at += known;
        var announced = false;
        var window = 0u;
        var left = 0u;
        while at < zfp_block_bits && reached < 64u {
            if left == 0u {
                left = min(zfp_block_bits - at, 32u);
                window = zfp_take(place, at, left);
            }
            if !announced {
                at++;
                left--;
                let any = window & 1u;
                window >>= 1u;
                if any == 0u {
                    break;
                }
            }
            // The last coefficient needs no bit: the group test implies it.
            let span = min(left, 63u - reached);
            let zeros = min(firstTrailingBit(window), span);
            let used = zeros + select(0u, 1u, zeros < span);
            reached += zeros;
            at += used;
            left -= used;
            window >>= used;
            announced = zeros == span && at < zfp_block_bits && reached < 63u;
            if !announced {
                let bit = 1u << reached;
                low |= select(0u, bit, reached < 32u);
                high |= select(bit, 0u, reached < 32u);
                reached++;
            }
        }
        out[plane] = vec2<u32>(low, high);
    }
    return out;
}

struct zfp_Pair {
    a: vec4<u32>,
    b: vec4<u32>,
}

// Exchanges the high bits of groups in `a` with the low bits of those in `b`, `shift` bits each.
fn zfp_exchange(a: vec4<u32>, b: vec4<u32>, shift: u32, low: u32) -> zfp_Pair {
    let other = ((a >> vec4<u32>(shift)) ^ b) & vec4<u32>(low);
    return zfp_Pair(a ^ (other << vec4<u32>(shift)), b ^ other);
}

// Transposes 32 words of 32 bits: bit j of word i becomes bit i of word j.
fn zfp_mirrored(words: array<vec4<u32>, 8>) -> array<vec4<u32>, 8> {
    var w = words;
    for (var i = 0u; i < 4u; i++) {
        let p = zfp_exchange(w[i], w[i + 4u], 16u, 0xffffu);
        w[i] = p.a;
        w[i + 4u] = p.b;
    }
    for (var i = 0u; i < 8u; i += 4u) {
        let p = zfp_exchange(w[i], w[i + 2u], 8u, 0xff00ffu);
        let q = zfp_exchange(w[i + 1u], w[i + 3u], 8u, 0xff00ffu);
        w[i] = p.a;
        w[i + 1u] = q.a;
        w[i + 2u] = p.b;
        w[i + 3u] = q.b;
    }
    for (var i = 0u; i < 8u; i += 2u) {
        let by_4 = zfp_exchange(w[i], w[i + 1u], 4u, 0xf0f0f0fu);
        let by_2 = zfp_exchange(
            vec4<u32>(by_4.a.xy, by_4.b.xy), vec4<u32>(by_4.a.zw, by_4.b.zw), 2u, 0x33333333u,
        );
        let by_1 = zfp_exchange(
            vec4<u32>(by_2.a.xz, by_2.b.xz), vec4<u32>(by_2.a.yw, by_2.b.yw), 1u, 0x55555555u,
        );
        w[i] = vec4<u32>(by_1.a.x, by_1.b.x, by_1.a.z, by_1.b.z);
        w[i + 1u] = vec4<u32>(by_1.a.y, by_1.b.y, by_1.a.w, by_1.b.w);
    }
    return w;
}

// Coefficients from the lowest frequency on, in negabinary.
fn zfp_coefficients(place: vec2<u32>) -> array<vec4<u32>, 16> {
    var planes = zfp_planes(place);
    var low: array<vec4<u32>, 8>;
    var high: array<vec4<u32>, 8>;
    for (var i = 0u; i < 8u; i++) {
        let a = planes[4u * i];
        let b = planes[4u * i + 1u];
        let c = planes[4u * i + 2u];
        let d = planes[4u * i + 3u];
        low[i] = vec4<u32>(a.x, b.x, c.x, d.x);
        high[i] = vec4<u32>(a.y, b.y, c.y, d.y);
    }
    low = zfp_mirrored(low);
    high = zfp_mirrored(high);
    var out: array<vec4<u32>, 16>;
    for (var i = 0u; i < 8u; i++) {
        out[i] = low[i];
        out[8u + i] = high[i];
    }
    return out;
}

// Both numbers, from their mean and the second minus the first.
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

fn zfp_column(coefficients: vec4<u32>) -> vec4<i32> {
    let negabinary = vec4<u32>(0xaaaaaaaau);
    return zfp_inverse(bitcast<vec4<i32>>((coefficients ^ negabinary) - negabinary));
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
    out.columns[0] = zfp_column(vec4<u32>(c[0].x, c[0].w, c[2].y, c[4].w));
    out.columns[1] = zfp_column(vec4<u32>(c[0].y, c[1].y, c[3].w, c[7].z));
    out.columns[2] = zfp_column(vec4<u32>(c[1].w, c[3].x, c[6].x, c[10].z));
    out.columns[3] = zfp_column(vec4<u32>(c[4].y, c[6].w, c[9].w, c[13].x));
    out.columns[4] = zfp_column(vec4<u32>(c[0].z, c[1].x, c[4].x, c[7].w));
    out.columns[5] = zfp_column(vec4<u32>(c[1].z, c[2].z, c[5].z, c[9].y));
    out.columns[6] = zfp_column(vec4<u32>(c[2].w, c[5].x, c[8].y, c[12].y));
    out.columns[7] = zfp_column(vec4<u32>(c[6].z, c[8].w, c[11].z, c[14].z));
    out.columns[8] = zfp_column(vec4<u32>(c[2].x, c[3].y, c[5].w, c[10].w));
    out.columns[9] = zfp_column(vec4<u32>(c[3].z, c[5].y, c[8].x, c[12].z));
    out.columns[10] = zfp_column(vec4<u32>(c[6].y, c[8].z, c[11].x, c[14].x));
    out.columns[11] = zfp_column(vec4<u32>(c[9].z, c[11].y, c[13].z, c[15].y));
    out.columns[12] = zfp_column(vec4<u32>(c[4].z, c[7].x, c[10].x, c[12].w));
    out.columns[13] = zfp_column(vec4<u32>(c[7].y, c[9].x, c[11].w, c[14].y));
    out.columns[14] = zfp_column(vec4<u32>(c[10].y, c[12].x, c[13].w, c[15].x));
    out.columns[15] = zfp_column(vec4<u32>(c[13].y, c[14].w, c[15].z, c[15].w));
    return out;
}

fn zfp_lane(v: vec4<i32>, i: u32) -> i32 {
    let pair = select(v.xy, v.zw, i >= 2u);
    return select(pair.x, pair.y, (i & 1u) == 1u);
}

fn zfp_line(block: ptr<function, zfp_Block>, x: u32, z: u32) -> vec4<i32> {
    return zfp_inverse(vec4<i32>(
        zfp_lane((*block).columns[x], z), zfp_lane((*block).columns[4u + x], z),
        zfp_lane((*block).columns[8u + x], z), zfp_lane((*block).columns[12u + x], z),
    ));
}

// Four lines along y: a slice, transformed back along z and y.
struct zfp_Slice {
    a: vec4<i32>,
    b: vec4<i32>,
    c: vec4<i32>,
    d: vec4<i32>,
}

fn zfp_slice(block: ptr<function, zfp_Block>, z: u32) -> zfp_Slice {
    return zfp_Slice(zfp_line(block, 0u, z), zfp_line(block, 1u, z), zfp_line(block, 2u, z), zfp_line(block, 3u, z));
}

// A row along x, transformed back.
fn zfp_row(slice: zfp_Slice, y: u32) -> vec4<i32> {
    return zfp_inverse(vec4<i32>(
        zfp_lane(slice.a, y), zfp_lane(slice.b, y), zfp_lane(slice.c, y), zfp_lane(slice.d, y),
    ));
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
    let row = zfp_row(zfp_slice(block, inside.z), inside.y);
    return zfp_value(zfp_lane(row, inside.x), (*block).exponent);
}

fn zfp_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    var out = vec4<f32>(0.0);
    var c = 0u;
    // The loop ends after its last channel. On devices without jumps, a `for` would run its body once more with all
    // lanes masked.
    loop {
        var block = zfp_block(v / 4u, c);
        out[c] = zfp_voxel(&block, v % 4u);
        c++;
        if c >= zfp_channels {
            break;
        }
    }
    return out;
}

// Values at the ends of a cell's four rows along x, all in one block. In a row's number, bit 0 is y and bit 1 is z.
struct zfp_Ends {
    low: vec4<f32>,
    high: vec4<f32>,
}

fn zfp_values(rows: array<vec4<i32>, 4>, x: u32, exponent: u32) -> vec4<f32> {
    return vec4<f32>(
        zfp_value(zfp_lane(rows[0], x), exponent), zfp_value(zfp_lane(rows[1], x), exponent),
        zfp_value(zfp_lane(rows[2], x), exponent), zfp_value(zfp_lane(rows[3], x), exponent),
    );
}

fn zfp_ends(block: ptr<function, zfp_Block>, low: vec3<u32>, high: vec3<u32>) -> zfp_Ends {
    let near = zfp_slice(block, low.z);
    let far = zfp_slice(block, high.z);
    let rows = array<vec4<i32>, 4>(
        zfp_row(near, low.y), zfp_row(near, high.y), zfp_row(far, low.y), zfp_row(far, high.y),
    );
    let exponent = (*block).exponent;
    return zfp_Ends(zfp_values(rows, low.x, exponent), zfp_values(rows, high.x, exponent));
}

fn zfp_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    let v = vec3<u32>(p);
    let w = vec3<u32>(q);
    // Axes along which the cell reaches into another block.
    let crossed = select(vec3<u32>(0u), vec3<u32>(1u), v / 4u != w / 4u);
    let shifts = vec3<u32>(0u, crossed.x, crossed.x + crossed.y);
    let blocks = 1u << (shifts.z + crossed.z);
    var out: array<vec4<f32>, 8>;
    for (var c = 0u; c < zfp_channels; c++) {
        var low = vec4<f32>(0.0);
        var high = vec4<f32>(0.0);
        // The loop goes over blocks, not corners. Neighbouring invocations then decode their first block together, then
        // their second, and so on, regardless of the axes that they cross.
        for (var k = 0u; k < blocks; k++) {
            let side = (vec3<u32>(k) >> shifts) & crossed;
            let near = side == vec3<u32>(0u);
            let far = side == crossed;
            let start = select(w, v, near);
            let end = select(v, w, far);
            var block = zfp_block(start / 4u, c);
            let ends = zfp_ends(&block, start % 4u, end % 4u);
            let rows = vec4<bool>(near.y, far.y, near.y, far.y) & vec4<bool>(near.zz, far.zz);
            low = select(low, ends.low, rows & vec4<bool>(near.x));
            high = select(high, ends.high, rows & vec4<bool>(far.x));
        }
        out[0][c] = low.x;
        out[1][c] = high.x;
        out[2][c] = low.y;
        out[3][c] = high.y;
        out[4][c] = low.z;
        out[5][c] = high.z;
        out[6][c] = low.w;
        out[7][c] = high.w;
    }
    return out;
}
