//! What all coders have in common.

use proptest::prelude::*;

use super::{
    Coder, arithmetic::Arithmetic, contexts::Contexts, deflate::Deflate, order::Order, runs::Runs,
    zerotree::Zerotree,
};
use crate::stream::pyramid::Pyramid;

const CODERS: [(&str, &dyn Coder); 7] = [
    ("contexts", &Contexts),
    ("runs, lines", &Runs { order: Order::Lines }),
    ("runs, octree", &Runs { order: Order::Octree }),
    ("deflate, lines", &Deflate { order: Order::Lines }),
    ("deflate, octree", &Deflate { order: Order::Octree }),
    ("arithmetic", &Arithmetic),
    ("zerotree", &Zerotree),
];

/// Numbers that look random (SplitMix64).
fn random(seed: u64) -> impl FnMut() -> u64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = state;
        bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ bits >> 31
    }
}

/// Kinds of coefficients: zeros; few and small; dense and small; more than a byte; of any size; one outlier.
const KINDS: usize = 6;

fn coefficients(pyramid: &Pyramid, kind: usize, seed: u64) -> Vec<i32> {
    let mut next = random(seed);
    let mut value = |i: usize| match kind {
        0 => 0,
        1 if !next().is_multiple_of(20) => 0,
        1 => (next() % 7) as i32 - 3,
        2 => (next() % 21) as i32 - 10,
        3 => (next() % 2000) as i32 - 1000,
        4 => (next() as i32).max(-i32::MAX) >> (next() % 32),
        _ => i32::from(i == 5) * -i32::MAX,
    };
    (0..pyramid.coefficients(pyramid.levels())).map(&mut value).collect()
}

fn decoded(
    coder: &dyn Coder,
    pyramid: &Pyramid,
    levels: usize,
    chunks: &[Vec<u8>],
) -> Result<Vec<i32>, String> {
    let mut out = vec![0; pyramid.coefficients(levels)];
    let chunks = chunks.iter().map(|chunk| &chunk[..]).collect::<Vec<_>>();
    match coder.decode(pyramid, levels, &chunks, &mut out) {
        Ok(()) => Ok(out),
        Err(cvr_core::codec::DecodeError::Corrupt(sentence)) => Err(sentence),
        Err(other) => panic!("{other}"),
    }
}

fn check(pyramid: &Pyramid, coefficients: &[i32]) {
    for (name, coder) in CODERS {
        let chunks = coder.encode(pyramid, coefficients);
        assert_eq!(chunks.len(), coder.chunks(pyramid), "{name}");
        for levels in 0..=pyramid.levels() {
            let out = decoded(coder, pyramid, levels, &chunks);
            assert!(
                out.as_deref() == Ok(&coefficients[..pyramid.coefficients(levels)]),
                "{name}, {levels} levels"
            );
        }
    }
}

#[test]
fn coefficients_come_back_at_all_levels() {
    let extents =
        [[1, 1, 1], [2, 1, 1], [1, 3, 2], [5, 4, 3], [13, 8, 1], [17, 9, 11], [16, 16, 16], [33, 1, 21]];
    for extent in extents {
        for (levels, padded) in (0..=4).flat_map(|levels| [(levels, false), (levels, true)]) {
            let pyramid = Pyramid::new(extent, levels, padded);
            for kind in 0..KINDS {
                check(&pyramid, &coefficients(&pyramid, kind, 1));
            }
        }
    }
}

#[test]
fn an_empty_volume_has_chunks() {
    check(&Pyramid::new([0, 4, 4], 2, false), &[]);
}

#[test]
fn zeros_cost_nothing() {
    let pyramid = Pyramid::new([40, 40, 40], 3, false);
    let mut coefficients = coefficients(&pyramid, 0, 0);
    for (name, coder) in CODERS {
        assert!(coder.encode(&pyramid, &coefficients).concat().is_empty(), "{name}");
    }
    // One coefficient costs its own chunk.
    coefficients[pyramid.level(2)[3].start] = 1;
    for (name, coder) in CODERS {
        let used = coder.encode(&pyramid, &coefficients).iter().filter(|chunk| !chunk.is_empty()).count();
        assert_eq!(used, 1, "{name}");
    }
}

#[test]
fn a_tree_of_zeros_is_one_symbol() {
    // Values at the coarsest level, and one coefficient of the finest, far from them.
    let pyramid = Pyramid::new([64, 64, 64], 4, false);
    let mut coefficients = vec![0; pyramid.coefficients(4)];
    for (i, band) in pyramid.level(0).iter().enumerate() {
        coefficients[band.range()].fill(1);
        coefficients[band.start] = 0;
        let finest = &pyramid.level(3)[i];
        coefficients[finest.start + finest.len() - 1] = 1;
    }
    check(&pyramid, &coefficients);
    let trees = Zerotree.encode(&pyramid, &coefficients).concat().len();
    let runs = Arithmetic.encode(&pyramid, &coefficients).concat().len();
    assert!(trees * 2 < runs, "{trees} and {runs} bytes");
}

#[test]
fn threads_change_no_byte() {
    let pyramid = Pyramid::new([33, 30, 31], 3, true);
    let coefficients = coefficients(&pyramid, 1, 3);
    for (name, coder) in CODERS {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let chunks = coder.encode(&pyramid, &coefficients);
                (decoded(coder, &pyramid, 3, &chunks), chunks)
            })
        };
        assert_eq!(with(1), with(4), "{name}");
    }
}

#[test]
fn arguments_are_checked() {
    let pyramid = Pyramid::new([8, 8, 8], 2, false);
    for (name, coder) in CODERS {
        let chunks = vec![&[][..]; coder.chunks(&pyramid)];
        let mut out = vec![0; 512];
        coder.decode(&pyramid, 2, &chunks, &mut out).unwrap();
        coder.decode(&pyramid, 3, &chunks, &mut out).expect_err(name);
        coder.decode(&pyramid, 2, &chunks[1..], &mut out).expect_err(name);
        coder.decode(&pyramid, 2, &chunks, &mut out[1..]).expect_err(name);
    }
}

#[test]
fn finer_chunks_are_not_read() {
    let pyramid = Pyramid::new([16, 16, 16], 2, false);
    let coefficients = coefficients(&pyramid, 2, 3);
    // Contexts write so small a volume as one chunk.
    for (name, coder) in &CODERS[1..] {
        let mut chunks = coder.encode(&pyramid, &coefficients);
        let finest = chunks.len() - 7;
        chunks[finest..].iter_mut().for_each(|chunk| *chunk = vec![0x80; 9]);
        assert!(decoded(*coder, &pyramid, 2, &chunks).is_err(), "{name}");
        let levels = usize::from(chunks.len() > 8);
        let out = decoded(*coder, &pyramid, levels, &chunks).expect(name);
        assert!(out == coefficients[..pyramid.coefficients(levels)], "{name}");
    }
}

/// Streams that a test can tamper with.
fn small(kind: usize) -> (Pyramid, Vec<i32>) {
    let pyramid = Pyramid::new([5, 6, 4], 2, true);
    let coefficients = coefficients(&pyramid, kind, 5);
    (pyramid, coefficients)
}

#[test]
fn chunks_that_are_cut_off_are_refused() {
    for kind in 1..KINDS {
        let (pyramid, coefficients) = small(kind);
        for (name, coder) in CODERS {
            let whole = coder.encode(&pyramid, &coefficients);
            for (i, len) in
                whole.iter().enumerate().flat_map(|(i, chunk)| (1..chunk.len()).map(move |len| (i, len)))
            {
                let mut chunks = whole.clone();
                chunks[i].truncate(len);
                let out = decoded(coder, &pyramid, 2, &chunks);
                // A range coder may also decode to other coefficients.
                assert!(out.as_ref() != Ok(&coefficients), "{name}: {len} bytes of chunk {i}");
                if name.starts_with("runs") || name.starts_with("deflate") {
                    assert!(out.is_err(), "{name}: {len} bytes of chunk {i}");
                }
            }
        }
    }
}

#[test]
fn flipped_bits_do_no_harm() {
    for kind in 1..KINDS {
        let (pyramid, coefficients) = small(kind);
        for (name, coder) in CODERS {
            let mut chunks = coder.encode(&pyramid, &coefficients);
            let mut refused = 0;
            for chunk in 0..chunks.len() {
                for bit in 0..8 * chunks[chunk].len() {
                    chunks[chunk][bit / 8] ^= 1 << (bit % 8);
                    match decoded(coder, &pyramid, 2, &chunks) {
                        // All bits of runs matter, except those of the header.
                        Ok(out) => {
                            assert!(out != coefficients || bit < 40 || !name.starts_with("runs"), "{bit}");
                        }
                        Err(sentence) => {
                            assert!(sentence.len() > 20, "{sentence}");
                            refused += 1;
                        }
                    }
                    chunks[chunk][bit / 8] ^= 1 << (bit % 8);
                }
            }
            assert!(refused > 0, "{name}");
        }
    }
}

proptest! {
    #[test]
    fn random_coefficients_come_back(
        extent in [1_usize..20, 1..20, 1..20], levels in 0_usize..5, padded: bool, kind in 1..KINDS, seed: u64,
    ) {
        let pyramid = Pyramid::new(extent, levels, padded);
        check(&pyramid, &coefficients(&pyramid, kind, seed));
    }

    #[test]
    fn random_bytes_do_no_harm(
        extent in [0_usize..9, 1..9, 1..9], levels in 0_usize..4, padded: bool, seed: u64,
        header in prop::collection::vec(prop_oneof![0_u8..4, any::<u8>()], 0..6), len in 0_usize..60,
    ) {
        let pyramid = Pyramid::new(extent, levels, padded);
        let mut next = random(seed);
        for (_, coder) in CODERS {
            let bytes = || header.iter().copied().chain((0..len).map(|_| next() as u8)).collect();
            let chunks = std::iter::repeat_with(bytes).take(coder.chunks(&pyramid)).collect::<Vec<Vec<u8>>>();
            for levels in 0..=levels {
                // Neither panics, nor returns another error than that of corrupt bytes.
                let _ = decoded(coder, &pyramid, levels, &chunks);
            }
        }
    }
}
