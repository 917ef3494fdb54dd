// What a group of blocks says of one of them: the twin of read.rs. A codec includes these functions under its own prefix.
//
// Constants: groups_parts. Resources: groups_index, groups_heads.

// What a group says of one block.
struct groups_Block {
    // Code of the mean.
    mean: u32,
    // How many codes there are, and where they begin: so many bits from a word on.
    count: u32,
    start: u32,
    bit: u32,
    // First word of what is coded directly, and bits of a voxel there: 0 where nothing is.
    rest: u32,
    rest_bits: u32,
}

// The number of so many bits, 16 at most, that begins at a bit from a word on.
fn groups_number(first: u32, bit: u32, width: u32) -> u32 {
    if width == 0u {
        return 0u;
    }
    let word = first + (bit >> 5u);
    let shift = bit & 31u;
    var number = groups_index(word) >> shift;
    if shift + width > 32u {
        number |= groups_index(word + 1u) << (32u - shift);
    }
    return number & ((1u << width) - 1u);
}

// A plane's words: one or two.
fn groups_plane(first: u32, words: u32) -> vec2<u32> {
    if words == 1u {
        return vec2<u32>(groups_index(first), 0u);
    }
    return vec2<u32>(groups_index(first), groups_index(first + 1u));
}

fn groups_below(plane: vec2<u32>, n: u32) -> u32 {
    if n < 32u {
        return countOneBits(plane.x & ((1u << n) - 1u));
    }
    return countOneBits(plane.x) + countOneBits(plane.y & ((1u << (n - 32u)) - 1u));
}

fn groups_bit(plane: vec2<u32>, n: u32) -> u32 {
    if n < 32u {
        return (plane.x >> n) & 1u;
    }
    return (plane.y >> (n - 32u)) & 1u;
}

fn groups_ones(plane: vec2<u32>) -> u32 {
    return countOneBits(plane.x) + countOneBits(plane.y);
}

// What plane j of some numbers adds at a place: to the numbers before it, and to its own. Planes have one or two words each.
fn groups_digit(first: u32, words: u32, place: u32, j: u32) -> vec2<u32> {
    let plane = groups_plane(first + j * words, words);
    return vec2<u32>(groups_below(plane, place), groups_bit(plane, place)) << vec2<u32>(j);
}

// Numbers that lie in planes, at most 6: the sum of those before a place, and its own. Without a loop: software rasterisers end
// the loops of a shader after a number of rounds.
fn groups_digits(first: u32, words: u32, place: u32, planes: u32) -> vec2<u32> {
    var all = vec2<u32>(0u);
    if planes > 0u {
        all = groups_digit(first, words, place, 0u);
    }
    if planes > 1u {
        all += groups_digit(first, words, place, 1u);
    }
    if planes > 2u {
        all += groups_digit(first, words, place, 2u);
    }
    if planes > 3u {
        all += groups_digit(first, words, place, 3u);
    }
    if planes > 4u {
        all += groups_digit(first, words, place, 4u);
    }
    if planes > 5u {
        all += groups_digit(first, words, place, 5u);
    }
    return all;
}

// Words of the planes of escapes, the first word of a record's escape, and bits of a voxel there. The planes begin at a word
// and have one or two each; escapes end at another word.
fn groups_escape(form: u32, first: u32, words: u32, place: u32, end: u32) -> vec3<u32> {
    let least = ((form >> 25u) & 15u) + 1u;
    let planes = (form >> 29u) - 1u;
    let escaped = groups_plane(first, words);
    let narrow = select(1u, 2u, groups_ones(escaped) > 32u);
    let all_words = words + planes * narrow;
    if groups_bit(escaped, place) == 0u {
        return vec3<u32>(all_words, 0u, 0u);
    }
    let nth = groups_below(escaped, place);
    let beyond = groups_digits(first + words, narrow, nth, planes);
    let bits = least + beyond.y;
    let all = nth * least + beyond.x + bits;
    return vec3<u32>(all_words, end - groups_parts * (nth + 1u + 2u * all), bits);
}

// Block n of the group whose head begins at a word: there are so many blocks, and codes have so many bits.
fn groups_block(head: u32, n: u32, blocks: u32, code_bits: u32) -> groups_Block {
    let end = groups_heads(head);
    let form = groups_heads(head + 1u);
    let base = form & 0xffffu;
    let mean_bits = (form >> 16u) & 31u;
    let planes = (form >> 21u) & 7u;
    let bare = groups_Block(base, 0u, 0u, 0u, 0u, 0u);
    if planes == 7u {
        return bare;
    }
    var start = end;
    var place = n;
    var records = blocks;
    if (form & 0x1000000u) == 0u {
        let mask = groups_plane(start, 2u);
        if groups_bit(mask, n) == 0u {
            return bare;
        }
        place = groups_below(mask, n);
        records = groups_ones(mask);
        start += 2u;
    }
    let words = select(1u, 2u, records > 32u);
    let codes = groups_digits(start, words, place, planes);
    start += planes * words;
    var rest = vec3<u32>(0u);
    if form >= 0x20000000u {
        rest = groups_escape(form, start, words, place, end);
        start += rest.x;
    }
    let mean = base + groups_number(start, place * mean_bits, mean_bits);
    return groups_Block(mean, codes.y, start, records * mean_bits + codes.x * code_bits, rest.y, rest.z);
}

// What a part of an escape adds at a place, in units of sums: the part begins at a word, and has so many bits of a voxel.
fn groups_part_value(first: u32, bits: u32, place: u32) -> i32 {
    let form = groups_index(first);
    let step = ((8u + ((form >> 5u) & 7u)) << (form & 31u)) >> 3u;
    return (bitcast<i32>(form) >> 8u) + i32(step * groups_number(first + 1u, place * bits, bits));
}
