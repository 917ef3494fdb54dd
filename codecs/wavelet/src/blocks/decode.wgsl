// Decodes voxels and cells from the bits of their blocks: what both filters share. The twin of decode.rs. The file of the
// filter, haar.wgsl or five_three.wgsl, follows.
//
// Constants: wavelet_edge, wavelet_levels, wavelet_channels, wavelet_low_bits, wavelet_low_base, wavelet_low_step,
// wavelet_fraction, wavelet_lowest, wavelet_highest (u32), wavelet_offset, wavelet_unit (f32), wavelet_grid (vec3<u32>, blocks),
// wavelet_steps_0 to wavelet_steps_3 (vec3<u32>). Resources: wavelet_table, wavelet_bits.

// A block: its low-pass coefficient, and where its other bits are.
struct wavelet_Head {
    low: i32,
    // Whether there are other bits. Without, the block is constant.
    coded: bool,
    // The block begins at a bit of a word.
    first: u32,
    start: u32,
    // Bit of the places of the children. 0 if all are empty.
    children: u32,
    // Bit of the root.
    root: u32,
}

// The classes of a group of places.
struct wavelet_Group {
    // Bit of the first record.
    records: u32,
    // Format of each class, and bits of its records.
    formats: vec4<u32>,
    lengths: vec4<u32>,
    // Bits 0 and 1 of the class of each place.
    even: vec3<u32>,
    odd: vec3<u32>,
}

// Bits and format of the coefficients of a place.
struct wavelet_Record {
    bit: u32,
    form: u32,
}

// The number of so many bits, 32 at most, from a bit on. Bits count from a word.
fn wavelet_take(first: u32, bit: u32, width: u32) -> u32 {
    if width == 0u {
        return 0u;
    }
    let word = first + (bit >> 5u);
    let shift = bit & 31u;
    var number = wavelet_bits(word) >> shift;
    if shift + width > 32u {
        number |= wavelet_bits(word + 1u) << (32u - shift);
    }
    return number & (0xffffffffu >> (32u - width));
}

// The head of a block of a channel.
fn wavelet_head(block: vec3<u32>, channel: u32) -> wavelet_Head {
    let number = (channel * wavelet_grid.z + block.z) * wavelet_grid.y + block.y;
    let entry = wavelet_table(number * wavelet_grid.x + block.x);
    if (entry & 0x80000000u) != 0u {
        let low = bitcast<i32>(entry << 1u) >> 1u;
        return wavelet_Head(low * i32(wavelet_low_step), false, 0u, 0u, 0u, 0u);
    }
    let first = entry >> 2u;
    let start = (entry & 3u) * 8u;
    let low = bitcast<i32>(wavelet_low_base) + bitcast<i32>(wavelet_take(first, start, wavelet_low_bits));
    var root = start + wavelet_low_bits;
    var children = 0u;
    if wavelet_levels > 3u {
        let flag = wavelet_take(first, root, 1u);
        root++;
        if flag == 1u {
            children = root;
            root += 128u;
        }
    }
    return wavelet_Head(low * i32(wavelet_low_step), true, first, start, children, root);
}

// Bits of a record.
fn wavelet_length(form: u32) -> u32 {
    if (form & 0x8000u) != 0u {
        return 7u + (form & 7u) * ((form >> 5u) & 31u);
    }
    return 3u * ((form & 31u) + ((form >> 5u) & 31u)) + (form >> 10u);
}

// One plane of a group.
fn wavelet_plane(first: u32, bit: u32, places: u32) -> vec3<u32> {
    return vec3<u32>(
        wavelet_take(first, bit, 32u),
        wavelet_take(first, bit + 32u, 32u),
        wavelet_take(first, bit + 64u, places - 64u),
    );
}

// The group of so many places that begins at a bit.
fn wavelet_group(first: u32, start: u32, places: u32) -> wavelet_Group {
    let code = wavelet_take(first, start, 3u);
    let planes = code & 3u;
    let bare = code >> 2u;
    var bit = start + 3u;
    var group = wavelet_Group(0u, vec4<u32>(0u), vec4<u32>(0u), vec3<u32>(0u), vec3<u32>(0u));
    for (var class_ = bare; class_ < 1u << planes; class_++) {
        let form = wavelet_take(first, bit, 16u);
        group.formats[class_] = form;
        group.lengths[class_] = wavelet_length(form);
        bit += 16u;
    }
    if planes > 0u {
        group.even = wavelet_plane(first, bit, places);
        bit += places;
    }
    if planes > 1u {
        group.odd = wavelet_plane(first, bit, places);
        bit += places;
    }
    group.records = bit;
    return group;
}

// The root of a block.
fn wavelet_root(head: wavelet_Head) -> wavelet_Group {
    return wavelet_group(head.first, head.root, 73u);
}

// A child of a block.
fn wavelet_child(head: wavelet_Head, child: u32) -> wavelet_Group {
    if head.children != 0u {
        let place = wavelet_take(head.first, head.children + 16u * child, 16u);
        if place != 0u {
            return wavelet_group(head.first, head.start + 8u * place, 64u);
        }
    }
    return wavelet_Group(0u, vec4<u32>(0u), vec4<u32>(0u), vec3<u32>(0u), vec3<u32>(0u));
}

fn wavelet_ones(plane: vec3<u32>) -> u32 {
    let ones = countOneBits(plane);
    return ones.x + ones.y + ones.z;
}

// The record of a place.
fn wavelet_record(group: wavelet_Group, place: u32) -> wavelet_Record {
    let bit = 1u << (place & 31u);
    let word = place >> 5u;
    // The places before this one.
    let below = select(select(vec3<u32>(0u), vec3<u32>(bit - 1u), vec3<u32>(0u, 1u, 2u) == vec3<u32>(word)),
        vec3<u32>(0xffffffffu), vec3<u32>(0u, 1u, 2u) < vec3<u32>(word));
    let even = group.even & below;
    let odd = group.odd & below;
    let both = wavelet_ones(even & odd);
    let counts = vec3<u32>(wavelet_ones(even) - both, wavelet_ones(odd) - both, both);
    let others = place - counts.x - counts.y - counts.z;
    var at = group.records + others * group.lengths.x;
    at += counts.x * group.lengths.y + counts.y * group.lengths.z + counts.z * group.lengths.w;
    var form = group.formats.x;
    let is_even = (group.even[word] & bit) != 0u;
    let is_odd = (group.odd[word] & bit) != 0u;
    form = select(form, group.formats.y, is_even && !is_odd);
    form = select(form, group.formats.z, is_odd && !is_even);
    form = select(form, group.formats.w, is_odd && is_even);
    return wavelet_Record(at, form);
}

// The coefficients of a record by slot, times their steps. Only those of the slots in `wanted` are read, the others are 0.
fn wavelet_coefficients(first: u32, record: wavelet_Record, level: u32, wanted: u32) -> array<i32, 7> {
    let form = record.form;
    let is_sparse = (form & 0x8000u) != 0u;
    let widths = vec3<u32>(form & 31u, (form >> 5u) & 31u, form >> 10u);
    var at = record.bit;
    var mask = 0x7fu;
    if is_sparse {
        mask = wavelet_take(first, at, 7u);
        at += 7u;
    }
    // A stream may set more bits than it has room for.
    var left = select(7u, form & 7u, is_sparse);
    var out: array<i32, 7>;
    for (var slot = 0u; slot < 7u; slot++) {
        if ((mask >> slot) & 1u) == 0u || left == 0u {
            continue;
        }
        left--;
        let width = select(widths[wavelet_kind(slot)], widths.y, is_sparse);
        if ((wanted >> slot) & 1u) == 1u && (width > 0u || is_sparse) {
            let number = wavelet_take(first, at, width);
            var q = i32(number >> 1u) + 1;
            if !is_sparse {
                q = bitcast<i32>(number << (32u - width)) >> (32u - width);
            } else if (number & 1u) == 1u {
                q = -q;
            }
            out[slot] = q * wavelet_step(level, slot);
        }
        at += width;
    }
    return out;
}

// How many axes of a slot are high-pass, less one.
fn wavelet_kind(slot: u32) -> u32 {
    return select(0u, 1u, slot > 2u) + select(0u, 1u, slot > 5u);
}

// Step of a slot of a level.
fn wavelet_step(level: u32, slot: u32) -> i32 {
    var steps = wavelet_steps_0;
    if level == 1u {
        steps = wavelet_steps_1;
    } else if level == 2u {
        steps = wavelet_steps_2;
    } else if level == 3u {
        steps = wavelet_steps_3;
    }
    return i32(steps[wavelet_kind(slot)]);
}

// Slot of the coefficient that is high-pass along the axes of these bits.
fn wavelet_slot(axes: u32) -> u32 {
    return (0x65423100u >> (4u * axes)) & 7u;
}

// Place of a position of a level within its group.
fn wavelet_place(level: u32, p: vec3<u32>) -> u32 {
    if level == 0u {
        return 0u;
    }
    if level == 1u {
        return 1u + p.x + 2u * p.y + 4u * p.z;
    }
    let place = (p.x & 3u) + 4u * (p.y & 3u) + 16u * (p.z & 3u);
    return select(place, place + 9u, level == 2u);
}

// Child of a position of level 3.
fn wavelet_child_of(p: vec3<u32>) -> u32 {
    return (p.x >> 2u) + 2u * (p.y >> 2u) + 4u * (p.z >> 2u);
}

// The value of an integer of the transform.
fn wavelet_value(x: i32) -> f32 {
    let rounded = (x + i32((1u << wavelet_fraction) >> 1u)) >> wavelet_fraction;
    let integer = clamp(rounded, bitcast<i32>(wavelet_lowest), bitcast<i32>(wavelet_highest));
    return wavelet_offset + wavelet_unit * f32(integer);
}

fn wavelet_fetch(p: vec3<i32>) -> vec4<f32> {
    let block = vec3<u32>(p) / wavelet_edge;
    let inside = vec3<u32>(p) % wavelet_edge;
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < wavelet_channels; c++) {
        out[c] = wavelet_value(wavelet_one(wavelet_head(block, c), inside));
    }
    return out;
}

// The corners of a grid cell. A cell inside a block finds what its corners share once.
fn wavelet_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    let block = vec3<u32>(p) / wavelet_edge;
    let inside = vec3<u32>(p) % wavelet_edge;
    var out: array<vec4<f32>, 8>;
    if all(block == vec3<u32>(q) / wavelet_edge) {
        for (var c = 0u; c < wavelet_channels; c++) {
            var corners = wavelet_corners(wavelet_head(block, c), inside, vec3<u32>(q - p));
            for (var i = 0u; i < 8u; i++) {
                out[i][c] = wavelet_value(corners[i]);
            }
        }
        return out;
    }
    for (var i = 0u; i < 8u; i++) {
        let far = (vec3<u32>(i) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u);
        out[i] = wavelet_fetch(select(p, q, far == vec3<u32>(1u)));
    }
    return out;
}
