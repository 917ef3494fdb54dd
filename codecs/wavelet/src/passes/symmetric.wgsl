// A line mirrored at its first and last sample: the place of sample j of the extended line.
fn wavelet_mirrored(j: i32) -> i32 {
    let last = i32(wavelet_samples) - 1;
    let inside = abs(j);
    if inside <= last {
        return inside;
    }
    let place = inside % (2 * last);
    return min(place, 2 * last - place);
}

fn wavelet_even(i: i32) -> i32 {
    return wavelet_mirrored(2 * i) >> 1u;
}

fn wavelet_odd(i: i32) -> i32 {
    return wavelet_mirrored(2 * i + 1) >> 1u;
}

fn wavelet_counts(i: i32) -> bool {
    return true;
}
