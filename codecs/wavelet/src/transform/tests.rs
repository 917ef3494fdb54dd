use proptest::prelude::*;

use super::*;

fn noise(n: usize, seed: u64) -> impl Iterator<Item = u64> {
    (0..n as u64).map(move |i| {
        let mut v = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ seed.wrapping_mul(0xd134_2543_de82_ef95);
        v ^= v >> 32;
        v = v.wrapping_mul(0xd6e8_feb8_6659_fd93);
        v ^ v >> 29
    })
}

fn floats(n: usize, seed: u64) -> Vec<f32> {
    noise(n, seed).map(|v| (v >> 40) as f32 / (1 << 24) as f32 - 0.25).collect()
}

/// Largest error of a round trip, in units in the last place of the largest magnitude.
fn error(filter: Filter, extent: [usize; 3], decompositions: usize) -> f64 {
    let pyramid = Pyramid::new(extent, decompositions, filter.pads());
    let values = floats(extent.iter().product(), extent[0] as u64);
    let coefficients = forward(filter, &pyramid, values.clone());
    let back: Vec<f32> = inverse(filter, &pyramid, decompositions, &coefficients, |_, c: f32| f64::from(c));
    let largest = values.iter().fold(0.0_f32, |a, v| a.max(v.abs()));
    let ulp = f64::from(largest.next_up() - largest);
    let distance = |(a, b): (&f32, &f32)| (f64::from(*a) - f64::from(*b)).abs() / ulp;
    values.iter().zip(&back).map(distance).fold(0.0, f64::max)
}

#[test]
fn every_filter_reconstructs_every_size() {
    let mut failed = false;
    for filter in Filter::ALL.into_iter().filter(|filter| !filter.is_integer()) {
        let mut worst = (0.0, [0; 3]);
        for n in 1..=65 {
            for extent in [[n, 1, 1], [1, n, 1], [1, 1, n], [n, 66 - n, 5], [7, n, 66 - n], [66 - n, 9, n]] {
                let e = error(filter, extent, 5);
                if e > worst.0 {
                    worst = (e, extent);
                }
            }
        }
        println!("{}: {:.2} ulp at {:?}", filter.name(), worst.0, worst.1);
        failed |= worst.0 > 4.0;
    }
    assert!(!failed, "see above");
}

#[test]
fn gains_are_those_of_the_transform() {
    for filter in Filter::ALL.into_iter().filter(|filter| !filter.is_integer()) {
        let pyramid = Pyramid::new([256, 1, 1], 3, filter.pads());
        let constant = forward(filter, &pyramid, vec![1.0_f32; 256]);
        let expected = gain::low(filter, 256, 3);
        assert!((f64::from(constant[5]) - expected).abs() < 1e-4, "{}: {}", filter.name(), constant[5]);
        for (band, depth) in [(0, 3), (1, 3), (8, 2), (15, 1)] {
            let band = &pyramid.bands()[band];
            let own = gain::of_band(filter, 256, depth, band.high[0]);
            let mut coefficients = vec![0.0_f32; 256];
            coefficients[band.start + band.len() / 2] = 1.0;
            let samples: Vec<f64> = inverse(filter, &pyramid, 3, &coefficients, |_, c: f32| f64::from(c));
            let norm = samples.iter().map(|v| v.powi(2)).sum::<f64>().sqrt();
            assert!((norm - own.synthesis).abs() < 1e-4, "{} {band:?}: {norm} {own:?}", filter.name());
            // The largest coefficient of samples within ±1 is the sum of the weights' magnitudes.
            let weight = |i: usize| {
                let mut samples = vec![0.0_f32; 256];
                samples[i] = 1.0;
                f64::from(forward(filter, &pyramid, samples)[band.start + band.len() / 2]).abs()
            };
            let sum: f64 = (0..256).map(weight).sum();
            assert!((sum - own.analysis).abs() < 1e-4, "{} {band:?}: {sum} {own:?}", filter.name());
        }
    }
}

proptest! {
    #[test]
    fn integers_are_exact(x in 1_usize..66, y in 1_usize..66, z in 1_usize..20, levels in 0_usize..7, seed: u64) {
        let pyramid = Pyramid::new([x, y, z], levels, false);
        let values: Vec<i32> = noise(x * y * z, seed).map(|v| (v >> 48) as i32 - 32768).collect();
        let coefficients = forward(Filter::FiveThree, &pyramid, values.clone());
        let back: Vec<i32> = inverse(Filter::FiveThree, &pyramid, levels, &coefficients, |_, c: i32| c);
        prop_assert_eq!(back, values);
    }
}
