// Lines along z of a level, from its bands and the low band of the level before.
//
// Constants: wavelet_grid (coefficients along x, y, z), wavelet_low_extent, wavelet_samples (samples along z),
// wavelet_table (its first entry), wavelet_first (1 if LLL is a band of the stream).
// Resources: wavelet_coefficients; wavelet_bands, three words per band: first coefficient, step, offset.
// Scratch: wavelet_from (the low band of the level before), wavelet_to.

struct wavelet_Line {
    // First sample of the line in `to`, and the distance between its samples.
    start: u32,
    // First coefficient of both halves, and the distance between their coefficients.
    low: u32,
    high: u32,
    area: u32,
    // Steps and offset as words.
    low_step: u32,
    low_offset: u32,
    high_step: u32,
    // Whether the low half is the low band of the level before.
    is_scratch: bool,
}

fn wavelet_line_at(x: u32, y: u32) -> wavelet_Line {
    let at = vec2<u32>(x, y);
    let low = wavelet_low_extent.xy;
    let high = at >= low;
    let extent = select(low, wavelet_grid.xy - low, high);
    let inside = at - select(vec2<u32>(0u), low, high);
    let number = select(0u, 1u, high.x) + select(0u, 2u, high.y);
    let low_entry = 3u * (wavelet_table + number);
    let high_entry = low_entry + 12u;
    let place = inside.y * extent.x + inside.x;
    var line: wavelet_Line;
    line.start = y * wavelet_grid.x + x;
    line.area = extent.x * extent.y;
    line.low = wavelet_bands(low_entry) + place;
    line.low_step = wavelet_bands(low_entry + 1u);
    line.low_offset = wavelet_bands(low_entry + 2u);
    line.high = wavelet_bands(high_entry) + place;
    line.high_step = wavelet_bands(high_entry + 1u);
    line.is_scratch = number == 0u && wavelet_first == 0u;
    if line.is_scratch {
        line.low = place;
    }
    return line;
}

fn wavelet_low(line: wavelet_Line, i: i32) -> wavelet_Value {
    let at = line.low + u32(wavelet_even(i)) * line.area;
    if line.is_scratch {
        return bitcast<wavelet_Value>(wavelet_from(at));
    }
    return wavelet_value(wavelet_coefficients(at), line.low_step, line.low_offset);
}

fn wavelet_high(line: wavelet_Line, i: i32) -> wavelet_Value {
    if !wavelet_counts(i) {
        return wavelet_Value(0);
    }
    return wavelet_value(wavelet_coefficients(line.high + u32(wavelet_odd(i)) * line.area), line.high_step, 0u);
}

fn wavelet_store(line: wavelet_Line, i: i32, value: wavelet_Value) {
    if u32(i) < wavelet_samples {
        wavelet_set_to(line.start + u32(i) * wavelet_grid.x * wavelet_grid.y, bitcast<u32>(value));
    }
}

@compute @workgroup_size(64)
fn wavelet_bands_pass(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= wavelet_grid.x {
        return;
    }
    let line = wavelet_line_at(id.x, id.y);
    if wavelet_samples == 1u {
        wavelet_store(line, 0, wavelet_low(line, 0));
        return;
    }
    wavelet_run(line, i32(id.z * wavelet_pairs));
}
