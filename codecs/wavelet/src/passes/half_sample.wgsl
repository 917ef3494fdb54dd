// A line mirrored beyond its ends: the first and last coefficients are repeated.
fn wavelet_even(i: i32) -> i32 {
    return clamp(i, 0, (i32(wavelet_samples) - 1) >> 1u);
}

fn wavelet_odd(i: i32) -> i32 {
    return clamp(i, 0, (i32(wavelet_samples) - 2) >> 1u);
}

// The last sample of a line of odd length has no difference from itself.
fn wavelet_counts(i: i32) -> bool {
    return 2 * i + 1 < i32(wavelet_samples);
}
