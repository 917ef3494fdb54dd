// Decodes one sample of a word. The twin of decode.rs, function for function.
//
// Constants: raw_bits (8, 16 or 32), raw_lanes_log2, raw_kind (form.rs), raw_offset, raw_step, raw_high,
// raw_extent, raw_channels. Resource: raw_samples.

fn raw_code(i: u32) -> u32 {
    let word = raw_samples(i >> raw_lanes_log2);
    let lane = i & ((1u << raw_lanes_log2) - 1u);
    return (word >> (lane * raw_bits)) & (0xffffffffu >> (32u - raw_bits));
}

fn raw_half(code: u32) -> f32 {
    let sign = (code & 0x8000u) << 16u;
    let exponent = (code >> 10u) & 0x1fu;
    let mantissa = code & 0x3ffu;
    if exponent != 0u {
        return bitcast<f32>(sign | ((exponent + 112u) << 23u) | (mantissa << 13u));
    }
    if mantissa == 0u {
        return bitcast<f32>(sign);
    }
    let first = firstLeadingBit(mantissa);
    return bitcast<f32>(sign | ((first + 103u) << 23u) | ((mantissa << (23u - first)) & 0x7fffffu));
}

fn raw_value(code: u32) -> f32 {
    if raw_kind == 0u {
        return f32(code);
    }
    if raw_kind == 1u {
        return f32(bitcast<i32>(code << (32u - raw_bits)) >> (32u - raw_bits));
    }
    if raw_kind == 2u {
        return bitcast<f32>(code);
    }
    if raw_kind == 3u {
        return raw_half(code);
    }
    return min(raw_offset + raw_step * f32(code), raw_high);
}

fn raw_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    let first = ((v.z * raw_extent.y + v.y) * raw_extent.x + v.x) * raw_channels;
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < raw_channels; c++) {
        out[c] = raw_value(raw_code(first + c));
    }
    return out;
}
