// The payload variable: a mean, as many codes as a block needs, and what is coded directly. The group of a block says which.
//
// Constants of this payload: rvq_groups (vec3<u32>), rvq_parts, rvq_mean_shift (of the only table). Functions of groups.wgsl
// stand behind this file.

// What a block is the sum of.
struct rvq_Codes {
    mean: vec3<i32>,
    // How many codes there are, and where they begin: so many bits from a word on.
    count: u32,
    start: u32,
    bit: u32,
    // First word of what is coded directly, and bits of a voxel there: 0 where nothing is.
    rest: u32,
    rest_bits: u32,
}

fn rvq_mean(code: u32) -> vec3<i32> {
    if rvq_channels == 3u {
        return vec3<i32>(vec3<u32>(code & 31u, (code >> 5u) & 31u, code >> 10u) * 2114u);
    }
    var shift = rvq_mean_shift;
    if rvq_one_table == 0u {
        shift = rvq_scales(4u);
    }
    return vec3<i32>(i32(code << shift), 0, 0);
}

fn rvq_codes(block: vec3<u32>) -> rvq_Codes {
    let group = block / 4u;
    let first = group * 4u;
    let size = min(vec3<u32>(4u), rvq_grid - first);
    let p = block - first;
    let n = (p.z * size.y + p.y) * size.x + p.x;
    let head = ((group.z * rvq_groups.y + group.y) * rvq_groups.x + group.x) * 2u;
    let kept = rvq_block(head, n, size.x * size.y * size.z, rvq_index_bits);
    return rvq_Codes(rvq_mean(kept.mean), kept.count, kept.start, kept.bit, kept.rest, kept.rest_bits);
}

fn rvq_code(codes: rvq_Codes, stage: u32) -> u32 {
    return rvq_number(codes.start, codes.bit + stage * rvq_index_bits, rvq_index_bits);
}

fn rvq_base(codes: rvq_Codes) -> vec3<i32> {
    return codes.mean;
}

fn rvq_count(codes: rvq_Codes) -> u32 {
    return min(codes.count, rvq_shown());
}

// What a part of an escape adds at a voxel: at coarser resolutions the mean over its voxels, half a unit rounded up.
fn rvq_part(first: u32, bits: u32, inside: vec3<u32>) -> i32 {
    if rvq_resolution() == 0u {
        return rvq_part_value(first, bits, (inside.z * 4u + inside.y) * 4u + inside.x);
    }
    let form = rvq_index(first);
    let step = ((8u + ((form >> 5u) & 7u)) << (form & 31u)) >> 3u;
    let log2 = rvq_resolution();
    let edge = 1u << log2;
    var all = 0u;
    for (var i = 0u; i < (1u << (3u * log2)); i++) {
        let q = inside * edge + vec3<u32>(i & (edge - 1u), (i >> log2) & (edge - 1u), i >> (2u * log2));
        all += rvq_number(first + 1u, ((q.z * 4u + q.y) * 4u + q.x) * bits, bits);
    }
    let half = 1u << (3u * log2 - 1u);
    return (bitcast<i32>(form) >> 8u) + i32((step * all + half) >> (3u * log2));
}

// What is coded directly belongs to the last stage.
fn rvq_rest(codes: rvq_Codes, inside: vec3<u32>) -> vec3<i32> {
    if codes.rest_bits == 0u || rvq_shown() < rvq_all_stages {
        return vec3<i32>(0);
    }
    let size = 1u + 2u * codes.rest_bits;
    let first = rvq_part(codes.rest, codes.rest_bits, inside);
    if rvq_parts == 1u {
        return vec3<i32>(first, 0, 0);
    }
    let second = rvq_part(codes.rest + size, codes.rest_bits, inside);
    return vec3<i32>(first, second, rvq_part(codes.rest + 2u * size, codes.rest_bits, inside));
}
