// The payload fixed: every block has one code of each stage.
//
// Constant of this payload: rvq_block_bits (those of all codes of a block).

// Codes of a block: the first lies in bits `shift` and above of word `word`. All of them, if they take 64 bits at most.
struct rvq_Codes {
    word: u32,
    shift: u32,
    record: vec2<u32>,
}

fn rvq_codes(block: vec3<u32>) -> rvq_Codes {
    // 32 codes fill rvq_index_bits words: bits never overflow.
    let i = ((block.z * rvq_grid.y + block.y) * rvq_grid.x + block.x) * rvq_all_stages;
    let bit = (i & 31u) * rvq_index_bits;
    let word = (i >> 5u) * rvq_index_bits + (bit >> 5u);
    let shift = bit & 31u;
    var record = vec2<u32>(0u);
    if rvq_block_bits <= 64u {
        record.x = rvq_index(word) >> shift;
        if rvq_block_bits != 32u && shift + rvq_block_bits > 32u {
            let next = rvq_index(word + 1u);
            if shift == 0u {
                record.y = next;
            } else {
                record.x |= next << (32u - shift);
                record.y = next >> shift;
            }
        }
        if rvq_block_bits > 32u && shift + rvq_block_bits > 64u {
            record.y |= rvq_index(word + 2u) << (32u - shift);
        }
    }
    return rvq_Codes(word, shift, record);
}

fn rvq_code(codes: rvq_Codes, stage: u32) -> u32 {
    var bit = stage * rvq_index_bits;
    var code = 0u;
    if rvq_block_bits <= 32u {
        code = codes.record.x >> bit;
    } else if rvq_block_bits <= 64u {
        if bit >= 32u {
            code = codes.record.y >> (bit - 32u);
        } else {
            code = codes.record.x >> bit;
            if bit + rvq_index_bits > 32u {
                code |= codes.record.y << (32u - bit);
            }
        }
    } else {
        bit += codes.shift;
        let word = codes.word + (bit >> 5u);
        let shift = bit & 31u;
        code = rvq_index(word) >> shift;
        if shift + rvq_index_bits > 32u {
            code |= rvq_index(word + 1u) << (32u - shift);
        }
    }
    return code & ((1u << rvq_index_bits) - 1u);
}

fn rvq_base(codes: rvq_Codes) -> vec3<i32> {
    return vec3<i32>(0x8000);
}

fn rvq_count(codes: rvq_Codes) -> u32 {
    return rvq_shown();
}

fn rvq_rest(codes: rvq_Codes, inside: vec3<u32>) -> vec3<i32> {
    return vec3<i32>(0);
}
