//! Every tuned number of the encoder: its effect, and the reason for its value.
//!
//! A decoder uses none of them. Titles in italics are sections of `docs/benchmarks/tvq.md`, whose figures concern a
//! number. Volumes and commands are given there. *Limit* means a bound on time or memory. *Alone, not measured* means
//! that no stored figure varies only this number: it was set together with others, and the sections show their joint
//! result.

/// Training, and bits of streams besides codes.
pub mod codebooks {
    /// Training stops after a round that reduces the distortion by less than this fraction. It is twice that of `vq`
    /// and `hvq`, because many codebooks are trained for one that is kept. Alone, not measured.
    pub const GAIN: f64 = 2e-3;
    /// Rounds of training of a codebook that only gives an estimate. Limit.
    pub const QUICK_ROUNDS: u32 = 2;
    /// The container's header is a multiple of this many bytes. Given by the container format.
    pub const HEADER_BYTES: f64 = 2048.0;
    /// Used bytes of the header: at least, per frame, and per set of tables, as in typical headers. Alone, not
    /// measured.
    pub const HEADER_USED: [f64; 3] = [1800.0, 10.0, 10.0];
    /// The step of means is at most this fraction of the expected error (root mean square). It then adds a hundredth of
    /// its square, 0.4² / 12. *Where the loss lies*: means take a fifth to a third of the bits and leave less than 1 %
    /// of the error. So a coarser step would cost less than it saves at low rates.
    pub const MEAN_STEP: f64 = 0.4;
    /// Number of blocks that pays for full codebooks without a target: sixteen for each of 256 codewords. Alone, not
    /// measured.
    pub const FULL_BLOCKS: f64 = 4096.0;
    /// Error over max − min from which a search without a PSNR begins. It corresponds to 38 dB, which lies within *Over
    /// rates*. It affects the start of a search, not its end.
    pub const FIRST_ERROR: f64 = 0.0126;
    /// Number of blocks whose remainders the trainer copies at a time. Limit of memory.
    pub const AT_ONCE: usize = 8192;
    /// Number of blocks that decide which partition holds most of the remaining error. Limit.
    pub const LEADING_BLOCKS: usize = 2048;
    /// Number of blocks from which a basis is computed. Limit.
    pub const BASIS_BLOCKS: usize = 16384;
}

/// The payload `fixed`: sizes of three codebooks from training curves.
pub mod fixed {
    /// Widths at which training curves are measured. Each has a quarter of the codewords of the next, so that
    /// interpolation is accurate. Alone, not measured.
    pub const CURVE_WIDTHS: [u32; 4] = [3, 5, 7, 9];
    /// Number of blocks for these measurements: eight for each codeword of the largest codebook, and eight more that do
    /// not train. Limit.
    pub const CURVE_BLOCKS: u64 = 12288;
    /// Number of codewords for which the settings' training blocks are enough. With fewer blocks per codeword, training
    /// blocks have much less error than others. *Where the loss lies*: training on all blocks gains 0.32 dB on bonsai
    /// and almost nothing elsewhere.
    pub const ENOUGH_FOR: f64 = 1024.0;
    /// Largest factor on the settings' number of training blocks. Limit.
    pub const MOST_TRAINING: f64 = 2.5;
    /// One, two or three codebooks are tried if their expected error is at most this multiple of the least. *Where the
    /// loss lies*: curves predict 20 to 45 % less error than results, and at these rates one codebook was best.
    pub const TRIED: [f64; 3] = [1.6, 1.1, 1.0];
    /// The same if codevectors are confined to the zones of their partition. There, leaving out one of three codebooks
    /// has a cost.
    pub const TRIED_CONFINED: [f64; 3] = [1.0, 1.1, 1.35];
    /// With at most this many blocks, every number of codebooks is tried, with or without a target. Limit: it takes
    /// seconds.
    pub const FEW_BLOCKS: f64 = 32768.0;
    /// With a rate as target, two codebooks are tried with these fractions of the codewords in the first. Large
    /// codebooks fit most training blocks exactly, so curves do not show the best fraction. *Where the loss lies*,
    /// pcasl: four fifths. Alone, not measured.
    pub const SHARES: [f64; 6] = [0.0625, 0.125, 0.25, 0.5, 0.65, 0.8];
    /// Most blocks times codewords of a codebook, if there are fewer than three. Limit: more would train for minutes.
    pub const MOST_PAIRS: f64 = (1_u64 << 31) as f64;
    /// Budgets that are tried for a PSNR. Limit.
    pub const BUDGETS: usize = 12;
    /// The first budget for a PSNR grows by this factor until the curves predict the PSNR. Limit.
    pub const FIRST_STEP: f64 = 1.05;
    /// Factor from a budget that reached a PSNR down to the next, and from one that missed it up, until both are known.
    /// Limit.
    pub const DOWN: f64 = 1.5;
    /// See [`DOWN`].
    pub const UP: f64 = 1.2;
    /// Budgets within this factor count as equal: a fiftieth.
    pub const NEAR: f64 = 1.02;
    /// How often sizes are chosen again for a rate. Limit.
    pub const TRIES: usize = 8;
    /// A budget is then lowered by its excess times this factor.
    pub const BEYOND: f64 = 1.01;
}

/// The payload `variable`: growth of codebooks.
pub mod growth {
    /// Typical fraction of a block's error that a code removes. A block is not used for training if even that would not
    /// pay. Alone, not measured.
    pub const PART_GAINED: f64 = 0.35;
    /// A codebook has at most one codeword per this many blocks. Alone, not measured.
    pub const FEWEST_BLOCKS: f64 = 4.0;
    /// How often a codebook that does not pay is halved before the list ends. Limit.
    pub const HALVINGS: u32 = 3;
    /// Least number of codewords of a halved codebook. Limit.
    pub const LEAST_HALF: usize = 4;
    /// Eighths of the largest size to try for a codebook that is chosen alone. Limit.
    pub const EIGHTHS: [usize; 6] = [8, 6, 4, 3, 2, 1];
    /// From this number of codewords on, a smaller codebook is tried even if a full one helps. Limit.
    pub const LARGE: usize = 64;
}

/// The payload `variable`: trials before all blocks are coded.
pub mod trials {
    /// Blocks on which trials train. Limit: *Time and memory*.
    pub const BLOCKS: u64 = 32768;
    /// Least error, in units of sums, at which a bit may pay. Rounding loses half a unit.
    pub const LEAST_ERROR: f64 = 0.5;
    /// Numbers of blocks of a table. Above the first, wide codes take too long. Up to the second, codebooks are chosen
    /// one by one. Up to the last, each width gets its own price. Limits: *Time and memory*.
    pub const MANY: f64 = 65536.0;
    /// See [`MANY`].
    pub const SOME: f64 = 16384.0;
    /// See [`MANY`].
    pub const FEW: f64 = 4096.0;
    /// Widths begin at one codeword per this many blocks, within bounds. Limit: the best width is searched from there.
    pub const FIRST_BLOCKS: f64 = 2000.0;
    /// See [`FIRST_BLOCKS`].
    pub const FIRST_WIDTHS: [u32; 2] = [3, 6];
    /// Widest codes of tables with many blocks, and of others. Limit: wider codes take too long and do not pay there.
    pub const WIDEST: [u32; 2] = [8, 12];
    /// Trials of one width. Limit.
    pub const OF_WIDTH: usize = 6;
    /// Trials of a width next to another with a known price. Limit.
    pub const ANEW: usize = 3;
    /// Largest step of one trial, as the logarithm of the error at which a bit pays. With few codebooks, a price may
    /// vary over a wide range. Limit.
    pub const FARTHEST: f64 = 1.5;
    /// Squared error of a block that one bit is worth, divided by the mean square of its voxels: one bit less in 64
    /// dimensions raises it by 2 ln 2. Derived.
    pub const PRICE: f64 = 2.0 * std::f64::consts::LN_2;
    /// The error that fits the step of means, divided by the error at which a bit pays. A step `s` adds `64 s² / 12` to
    /// the error of a block, and doubling it saves a bit. This pays up to 0.59 of that error. Derived.
    pub const OF_MEANS: f64 = 1.45;
    /// Finer entries are used for all trials if they leave less than this fraction of the error, or of the bits. *Where
    /// the loss lies*: entries of 16 bits gain 0.03 and 0.04 dB on two volumes, and 0.68 dB for twice the bits of
    /// codebooks on pcasl.
    pub const FINER_GAINS: f64 = 0.97;
    /// Budgets that are tried for an error. Limit.
    pub const BUDGETS: usize = 5;
    /// Tolerance of the logarithm of an error against the target. Tested: a PSNR is exceeded by at most half a decibel.
    pub const CLOSE: f64 = 0.1;
    /// Least difference between the logarithms of two budgets. Limit.
    pub const CLOSER: f64 = 0.02;
    /// Slope of the first step of a search: logarithm of bits per logarithm of squared error. Later steps use the
    /// measured slope. *Over rates* has 0.56 and 0.64 on large volumes; a search uses few blocks. Alone, not measured.
    pub const SLOPE: f64 = 0.3;
    /// Bounds of a measured slope. Limit.
    pub const SLOPES: [f64; 2] = [0.1, 1.0];
    /// Bounds of a step between a budget that missed and one that reached, as a fraction of the interval. Limit.
    pub const PARTS: [f64; 2] = [0.2, 0.8];
    /// Bounds of a step if only one of them is known, as the logarithm of bits. Limit.
    pub const STEPS: [f64; 2] = [0.05, 0.7];
    /// Errors, or bits, within this factor count as about equal. Then the widest codes are taken, because fewer codes
    /// are fewer fetches. It is 0.13 dB. Alone, not measured.
    pub const ABOUT_AS_GOOD: f64 = 1.03;
    /// The same if codebooks are chosen one by one. Then the quantity that the target leaves free is compared. It is
    /// 0.04 dB. Alone, not measured.
    pub const AS_GOOD: f64 = 1.01;
    /// Errors at which a bit pays count as equal if their logarithms differ by less. Limit.
    pub const NEAR: f64 = 0.05;
    /// Interpolation assumes that an error at which a bit pays is off by at most this. Limit.
    pub const STEEP: f64 = 0.5;
}

/// The payload `variable`: training on all blocks until codebooks fit the price that they lead to.
pub mod variable {
    /// Codebooks are retrained if the logarithm of the error at which a bit pays is off by this. Limit.
    pub const OFF: f64 = 0.5;
    /// The same for fewer blocks, where retraining takes little time.
    pub const OFF_OF_SOME: f64 = 0.1;
    /// There, the error for which codebooks are trained grows by this factor while that helps. Alone, not measured.
    pub const COARSER: f64 = 1.15;
    /// The factor of that error where a PSNR was missed. Alone, not measured.
    pub const FINER: f64 = 0.7;
    /// Fraction of an error's deviation by which it is moved, to avoid oscillation. Alone, not measured.
    pub const DAMPED: f64 = 0.7;
    /// Errors whose logarithms differ by less are the same. Limit.
    pub const SAME: f64 = 0.05;
    /// Blocks are searched until less than this fraction of a code's cost is left of their error: while codebooks are
    /// added, and for given sizes. Limit: more time finds codes that a lower price would keep.
    pub const ENOUGH: [f64; 2] = [0.5, 0.05];
    /// Most rounds of training of codebooks. Limit.
    pub const TRIES: usize = 4;
}

/// The payload `variable`: blocks that are coded directly behind their codes.
pub mod escapes {
    /// Part of a step of integers that escapes behind codes have at most where they are to lose nothing: codes leave values
    /// between integers, which a whole step would round either way. Derived.
    pub const COVERED: f64 = 0.95;
    /// Escapes are tried that may pay at this part of the price that is expected, and at less of it where that turns out to be
    /// too dear. Limit.
    pub const FLOOR: f64 = 0.2;
    /// How often a lower price is tried before every block is.
    pub const FLOORS: usize = 3;
}
