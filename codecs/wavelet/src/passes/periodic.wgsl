// A line of an even number of samples that begins anew at its end.
fn wavelet_even(i: i32) -> i32 {
    let half = i32(wavelet_samples + 1u) / 2;
    // Runs begin at most two places before a line, so one length makes the number positive but for the shortest lines.
    return (i + 2 * half) % half;
}

fn wavelet_odd(i: i32) -> i32 {
    return wavelet_even(i);
}

fn wavelet_counts(i: i32) -> bool {
    return true;
}
