//! Every number of the encoder that was chosen and does not follow from anything: what it does, and what chose it.
//!
//! A decoder knows none of them. Titles in italics are sections of `docs/benchmarks/tvq.md`, whose figures bear on a number;
//! volumes and commands are given there. *Limit* is a bound on time or memory. *Alone, not measured* is said where no figure is
//! kept that varies this number and nothing else: it was set beside others, and the sections show what all of them reach.

/// Training, and what streams take beside codes.
pub mod codebooks {
    /// A round of training that gains less than this part of the distortion is the last. Twice that of `vq` and `hvq`: many
    /// codebooks are trained for one that is kept. Alone, not measured.
    pub const GAIN: f64 = 2e-3;
    /// Rounds of training of a codebook that only shows what to expect. Limit.
    pub const QUICK_ROUNDS: u32 = 2;
    /// The container's header is a multiple of so many bytes. Of the container format.
    pub const HEADER_BYTES: f64 = 2048.0;
    /// What is in it at least, as a rule, and for each frame and set of tables: what headers of streams hold.
    /// Alone, not measured.
    pub const HEADER_USED: [f64; 3] = [1800.0, 10.0, 10.0];
    /// The step of means is at most this part of the expected error (root mean square): it then adds a hundredth of its square,
    /// 0.4² / 12. *Where the loss lies*: means take a fifth to a third of the bits and leave less than 1 % of the error, so that a
    /// coarser step would cost less than it saves at low rates.
    pub const MEAN_STEP: f64 = 0.4;
    /// Blocks that pay for full codebooks, without a target; sixteen for each of 256 codewords. Alone, not
    /// measured.
    pub const FULL_BLOCKS: f64 = 4096.0;
    /// Error, over max − min, from which a search begins without a PSNR: what 38 dB leave, which lie within *Over
    /// rates*. It is where a search begins, and not where it ends.
    pub const FIRST_ERROR: f64 = 0.0126;
    /// The trainer copies the residuals of so many blocks at a time. Limit of memory.
    pub const AT_ONCE: usize = 8192;
    /// Blocks that show which partition holds most of the remaining error. Limit.
    pub const LEADING_BLOCKS: usize = 2048;
    /// Blocks that a basis is made of. Limit.
    pub const BASIS_BLOCKS: usize = 16384;
}

/// The payload `fixed`: sizes of three codebooks from training curves.
pub mod fixed {
    /// Widths at which training curves are measured: each a quarter of the codewords of the next, so that lines between them
    /// are near what lies there. Alone, not measured.
    pub const CURVE_WIDTHS: [u32; 4] = [3, 5, 7, 9];
    /// Blocks on which they are measured: eight for each codeword of the largest codebook and eight more that train nothing.
    /// Limit.
    pub const CURVE_BLOCKS: u64 = 12288;
    /// Codewords for which the settings' blocks are enough to train on. Where there are fewer for each codeword, blocks that
    /// trained do far better than others. *Where the loss lies*: training on all blocks gains 0.32 dB on bonsai and next to nothing elsewhere.
    pub const ENOUGH_FOR: f64 = 1024.0;
    /// How many times the settings' blocks train at most. Limit.
    pub const MOST_TRAINING: f64 = 2.5;
    /// One, two or three codebooks are tried where their expected error is at most this multiple of the least. *Where the
    /// loss lies*: what curves expect is 20 to 45 % below the error that comes out, and at these rates one codebook was best.
    pub const TRIED: [f64; 3] = [1.6, 1.1, 1.0];
    /// The same where codevectors keep to the zones of their partition, so that none does without three codebooks for nothing.
    pub const TRIED_CONFINED: [f64; 3] = [1.0, 1.1, 1.35];
    /// With no more blocks than this every number is tried, with a target or without. Limit: it takes seconds.
    pub const FEW_BLOCKS: f64 = 32768.0;
    /// Under a rate, two codebooks are tried with these shares of the codewords in the first. Large codebooks know most blocks
    /// by heart, and curves do not show then which share is best. *Where the loss lies*, pcasl: four fifths. Alone, not measured.
    pub const SHARES: [f64; 6] = [0.0625, 0.125, 0.25, 0.5, 0.65, 0.8];
    /// Most blocks times codewords of one of fewer than three codebooks. Limit: more would train for minutes.
    pub const MOST_PAIRS: f64 = (1_u64 << 31) as f64;
    /// Budgets that are tried for a PSNR. Limit.
    pub const BUDGETS: usize = 12;
    /// The first budget of a PSNR grows by this factor until the curves promise it. Limit.
    pub const FIRST_STEP: f64 = 1.05;
    /// From a budget that reached a PSNR down to the next, and up from one that missed it, until both are known. Limit.
    pub const DOWN: f64 = 1.5;
    /// See [`DOWN`].
    pub const UP: f64 = 1.2;
    /// Budgets that differ by no more than this factor are the same: a fiftieth.
    pub const NEAR: f64 = 1.02;
    /// How often sizes are chosen anew for a rate. Limit.
    pub const TRIES: usize = 8;
    /// And by how many times its excess a budget is then lowered.
    pub const BEYOND: f64 = 1.01;
}

/// The payload `variable`: growth of codebooks.
pub mod growth {
    /// Part of a block's error that a code takes away, as a rule. A block is not trained on if even that would not pay.
    /// Alone, not measured.
    pub const PART_GAINED: f64 = 0.35;
    /// A codebook has no more codewords than one for so many blocks. Alone, not measured.
    pub const FEWEST_BLOCKS: f64 = 4.0;
    /// How often a codebook that is not worth its bits is halved before the list ends. Limit.
    pub const HALVINGS: u32 = 3;
    /// Codewords at least of a codebook that was halved. Limit.
    pub const LEAST_HALF: usize = 4;
    /// Eighths of the largest size that are tried for a codebook that is chosen by itself. Limit.
    pub const EIGHTHS: [usize; 6] = [8, 6, 4, 3, 2, 1];
    /// Codewords from which on a smaller codebook is tried even where a full one helps. Limit.
    pub const LARGE: usize = 64;
}

/// The payload `variable`: trials before all blocks are coded.
pub mod trials {
    /// Blocks on which trials train. Limit: *Time and memory*.
    pub const BLOCKS: u64 = 32768;
    /// Least error, in units of sums, at which a bit may pay: half a unit is lost by rounding.
    pub const LEAST_ERROR: f64 = 0.5;
    /// Blocks of a table that are many, not many, and few: beyond the first, wide codes take too long; up to the second,
    /// codebooks are chosen one by one; up to the last, each width gets a price of its own. Limits: *Time and memory*.
    pub const MANY: f64 = 65536.0;
    /// See [`MANY`].
    pub const SOME: f64 = 16384.0;
    /// See [`MANY`].
    pub const FEW: f64 = 4096.0;
    /// Widths begin where a codebook has one codeword for so many blocks, within bounds. Limit: the best is then sought.
    pub const FIRST_BLOCKS: f64 = 2000.0;
    /// See [`FIRST_BLOCKS`].
    pub const FIRST_WIDTHS: [u32; 2] = [3, 6];
    /// Widest codes of tables of many blocks, and of others. Limit: wider ones take too long, and do not pay there.
    pub const WIDEST: [u32; 2] = [8, 12];
    /// Trials of one width. Limit.
    pub const OF_WIDTH: usize = 6;
    /// Trials of a width beside another whose price is known. Limit.
    pub const ANEW: usize = 3;
    /// The farthest that one trial leads, as the logarithm of the error at which a bit pays: where codebooks are few, a price
    /// may be any in a wide range. Limit.
    pub const FARTHEST: f64 = 1.5;
    /// Squared error of a block that one bit is worth, over the mean square of its voxels: a bit less in each of 64 dimensions
    /// would raise it by 2 ln 2. Derived.
    pub const PRICE: f64 = 2.0 * std::f64::consts::LN_2;
    /// The error that suits the step of means, over the error at which a bit pays. A step `s` adds `64 s² / 12` to the error of
    /// a block, and one twice as long takes a bit less: that pays up to 0.59 of that error. Derived.
    pub const OF_MEANS: f64 = 1.45;
    /// What finer entries must leave of the error, or of the bits, before all trials are made with them. *Where the
    /// loss lies*: entries of 16 bits gain 0.03 and 0.04 dB on two volumes, and 0.68 dB for twice the bits of codebooks on pcasl.
    pub const FINER_GAINS: f64 = 0.97;
    /// Budgets that are tried for an error. Limit.
    pub const BUDGETS: usize = 5;
    /// How near the logarithm of an error is to come to what is allowed. Tested: a PSNR is exceeded by half a decibel at most.
    pub const CLOSE: f64 = 0.1;
    /// And the logarithms of two budgets to each other. Limit.
    pub const CLOSER: f64 = 0.02;
    /// Logarithm of bits per logarithm of squared error, of the first step of a search; later ones take what was found. *Over
    /// rates* has 0.56 and 0.64 on large volumes; a search is of few blocks. Alone, not measured.
    pub const SLOPE: f64 = 0.3;
    /// Bounds of a slope that was found. Limit.
    pub const SLOPES: [f64; 2] = [0.1, 1.0];
    /// Bounds of a step between a budget that missed and one that reached, as a part of the way. Limit.
    pub const PARTS: [f64; 2] = [0.2, 0.8];
    /// Bounds of a step where only one of them is known, as the logarithm of bits. Limit.
    pub const STEPS: [f64; 2] = [0.05, 0.7];
    /// Errors, or bits, that differ by no more than this factor are about the same; the widest codes are then taken, since
    /// fewer codes are fewer fetches. It is 0.13 dB. Alone, not measured.
    pub const ABOUT_AS_GOOD: f64 = 1.03;
    /// The same where codebooks are chosen one by one: what is compared is then what the target leaves.
    /// It is 0.04 dB. Alone, not measured.
    pub const AS_GOOD: f64 = 1.01;
    /// Errors at which a bit pays are the same where their logarithms differ by less. Limit.
    pub const NEAR: f64 = 0.05;
    /// Interpolation takes errors at which a bit pays for no farther off than this. Limit.
    pub const STEEP: f64 = 0.5;
}

/// The payload `variable`: training on all blocks until codebooks suit the price that they lead to.
pub mod variable {
    /// Codebooks are trained anew where the logarithm of the error at which a bit pays turns out to be off by this. Limit.
    pub const OFF: f64 = 0.5;
    /// The same where blocks are not many, so that this takes little time.
    pub const OFF_OF_SOME: f64 = 0.1;
    /// The error for which codebooks are trained grows by this factor there, as long as that helps. Alone, not
    /// measured.
    pub const COARSER: f64 = 1.15;
    /// The factor of that error where a PSNR was missed. Alone, not measured.
    pub const FINER: f64 = 0.7;
    /// The part of what an error is off by which it is moved, so that it does not swing. Alone, not measured.
    pub const DAMPED: f64 = 0.7;
    /// Errors whose logarithms differ by less are the same. Limit.
    pub const SAME: f64 = 0.05;
    /// Blocks are searched until less than this part of what a code costs is left of their error, as long as codebooks are added
    /// and where sizes are given. Limit: more time finds codes that a lower price would keep.
    pub const ENOUGH: [f64; 2] = [0.5, 0.05];
    /// How often codebooks are trained at most. Limit.
    pub const TRIES: usize = 4;
}

/// The payload `variable`: blocks that are coded directly behind their codes.
pub mod escapes {
    /// Part of a step of integers that escapes behind codes have at most where they are to lose nothing: codes leave values
    /// between integers, which a whole step would round either way. Derived.
    pub const COVERED: f64 = 0.95;
    /// One more bit for each voxel is not tried where what is left is worth less than this part of it. Limit.
    pub const WORTH: f64 = 1.0;
    /// Part of a block's error that is expected to be left by a quantiser of 0, 1, … bits: between normal and Laplacian
    /// distributions (Max 1960). Trials alone use it.
    pub const LEFT: [f64; 5] = [1.0, 0.42, 0.15, 0.05, 0.016];
    /// And by each further bit.
    pub const LEFT_BEYOND: f64 = 0.3;
    /// Escapes are tried that may pay at this part of the price that is expected, and at less of it where that turns out to be
    /// too dear. Limit.
    pub const FLOOR: f64 = 0.2;
    /// How often a lower price is tried before every block is.
    pub const FLOORS: usize = 3;
}

/// The payload `variable`: rate control.
pub mod rate_control {
    /// Halvings of a range of prices, whose logarithms are then known within 2 · ln 10⁷ / 2²⁸. Derived.
    pub const HALVINGS: usize = 28;
    /// Prices are sought within this factor of the one that is expected, up and down. Tested: any first guess within 10³.
    pub const REACH: f64 = 1e7;
    /// Bits or errors that fall short of what is allowed by no more than this part are taken. Limit.
    pub const NEAR: f64 = 1e-5;
    /// Numbers of codebooks that are tried one by one. Limit.
    pub const COUNTS: usize = 8;
}
