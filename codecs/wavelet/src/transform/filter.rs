//! The filters: their names, and the lifting steps or taps that define them.

/// A wavelet filter.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// Haar, orthonormal.
    Haar,
    /// Four taps and two vanishing moments, orthonormal (I. Daubechies, Ten Lectures on Wavelets, 1992, table 6.1).
    #[serde(rename = "daubechies-4")]
    Daubechies4,
    /// Six taps, orthonormal (I. Daubechies, SIAM Journal on Mathematical Analysis 24, 1993, section 3.B).
    #[serde(rename = "coiflet-6")]
    Coiflet6,
    /// Two taps for the low band, six for the high band (Cohen, Daubechies, Feauveau, 1992, the spline family N = 1,
    /// Ñ = 3, duals exchanged).
    #[serde(rename = "cdf-2-6")]
    Cdf26,
    /// The spline wavelet CDF(2, 6): linear splines whose wavelet's dual has six vanishing moments.
    #[serde(rename = "cdf-spline-2-6")]
    CdfSpline26,
    /// Nine and seven taps (Antonini et al., 1992; JPEG 2000 part 1, annex F).
    #[serde(rename = "cdf-9-7")]
    Cdf97,
    /// Five and three taps on integers (Le Gall, Tabatabai, 1988; JPEG 2000 part 1, annex F). Exactly reversible.
    #[serde(rename = "5-3")]
    FiveThree,
}

/// What a filter reads beyond the ends of a line.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Extension {
    /// The other end. A line of odd length is extended by its last sample first.
    Periodic,
    /// The line mirrored at its first and at its last sample, which are not repeated.
    Symmetric,
    /// The line mirrored beyond its ends: the first and the last coefficient are repeated.
    HalfSample,
}

/// Half of the samples of a line.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Half {
    /// Samples at even places, which become the low band.
    Even,
    /// Samples at odd places, which become the high band.
    Odd,
}

/// A lifting step (Daubechies and Sweldens, 1998): sample `i` of one half gains `Σ taps[k] · other[i + first + k]`.
#[derive(Copy, Clone, Debug)]
pub struct Step {
    /// The half that changes.
    pub to: Half,
    /// Place of the first tap, relative to `i`.
    pub first: isize,
    /// Weights of consecutive samples of the other half.
    pub taps: &'static [f64],
}

/// How the two halves of a line are transformed.
#[derive(Copy, Clone, Debug)]
pub enum Kernel {
    /// Lifting steps of the analysis in order. The inverse undoes them in the opposite order. The halves are not scaled:
    /// the quantiser knows their gains, and every factor would round.
    Lifting(&'static [Step]),
    /// An orthonormal low-pass filter, divided by √2 so that a constant line keeps its value. Sample `i` of the low band
    /// is `Σ taps[k] · line[2 i + k]`. The high-pass filter has the taps `(−1)^k · taps[n − 1 − k]`. The inverse has
    /// twice the transposed taps.
    Orthonormal(&'static [f64]),
    /// The reversible 5/3 filter on integers.
    Integer,
}

const SQRT3: f64 = 1.732_050_807_568_877_2;

/// Haar: the difference, then the mean.
const HAAR: [Step; 2] =
    [Step { to: Half::Odd, first: 0, taps: &[-1.0] }, Step { to: Half::Even, first: 0, taps: &[0.5] }];

/// Daubechies and Sweldens, Factoring Wavelet Transforms into Lifting Steps, 1998, section 7.5.
const DAUBECHIES4: [f64; 4] =
    [(1.0 + SQRT3) / 8.0, (3.0 + SQRT3) / 8.0, (3.0 - SQRT3) / 8.0, (1.0 - SQRT3) / 8.0];

const SQRT7: f64 = 2.645_751_311_064_590_7;

/// The six taps in closed form: (1 − √7, 5 + √7, 14 + 2√7, 14 − 2√7, 1 − √7, −3 + √7) / 32.
const COIFLET6: [f64; 6] = [
    (1.0 - SQRT7) / 32.0,
    (5.0 + SQRT7) / 32.0,
    (14.0 + 2.0 * SQRT7) / 32.0,
    (14.0 - 2.0 * SQRT7) / 32.0,
    (1.0 - SQRT7) / 32.0,
    (-3.0 + SQRT7) / 32.0,
];

/// Haar, and a high band that loses the slope of its neighbours.
const CDF26: [Step; 3] = [HAAR[0], HAAR[1], Step { to: Half::Odd, first: -1, taps: &[0.25, 0.0, -0.25] }];

/// Linear prediction, and an update of six taps that keeps six moments.
const CDF_SPLINE26: [Step; 2] = [
    Step { to: Half::Odd, first: 0, taps: &[-0.5, -0.5] },
    Step {
        to: Half::Even,
        first: -3,
        taps: &[5.0 / 512.0, -39.0 / 512.0, 162.0 / 512.0, 162.0 / 512.0, -39.0 / 512.0, 5.0 / 512.0],
    },
];

/// JPEG 2000 part 1, annex F, table F.4, to the precision of a double.
const CDF97: [Step; 4] = [
    Step { to: Half::Odd, first: 0, taps: &[-1.586_134_342_059_924, -1.586_134_342_059_924] },
    Step { to: Half::Even, first: -1, taps: &[-0.052_980_118_572_961, -0.052_980_118_572_961] },
    Step { to: Half::Odd, first: 0, taps: &[0.882_911_075_530_934, 0.882_911_075_530_934] },
    Step { to: Half::Even, first: -1, taps: &[0.443_506_852_043_971, 0.443_506_852_043_971] },
];

/// The scaling factor of the same table: what the steps multiply a constant line by.
const CDF97_K: f64 = 1.230_174_104_914_001;

impl Filter {
    /// All filters, the paper's first.
    pub const ALL: [Self; 7] = [
        Self::Haar,
        Self::Daubechies4,
        Self::Coiflet6,
        Self::Cdf26,
        Self::CdfSpline26,
        Self::Cdf97,
        Self::FiveThree,
    ];

    /// Names, in the order of [`Filter::ALL`].
    pub const NAMES: &'static [&'static str] =
        &["haar", "daubechies-4", "coiflet-6", "cdf-2-6", "cdf-spline-2-6", "cdf-9-7", "5-3"];

    /// The filter of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let at = Self::NAMES.iter().position(|known| *known == name)?;
        Some(Self::ALL[at])
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().position(|filter| *filter == self).map_or("", |at| Self::NAMES[at])
    }

    /// What it reads beyond the ends of a line.
    #[must_use]
    pub const fn extension(self) -> Extension {
        match self {
            Self::Haar | Self::Daubechies4 | Self::Coiflet6 => Extension::Periodic,
            Self::Cdf26 => Extension::HalfSample,
            Self::CdfSpline26 | Self::Cdf97 | Self::FiveThree => Extension::Symmetric,
        }
    }

    /// Whether a line of an odd number of samples above 1 gains one before it is transformed.
    #[must_use]
    pub fn pads(self) -> bool {
        self.extension() == Extension::Periodic
    }

    /// Whether it maps integers to integers.
    #[must_use]
    pub const fn is_integer(self) -> bool {
        matches!(self, Self::FiveThree)
    }

    /// Its steps or taps.
    #[must_use]
    pub const fn kernel(self) -> Kernel {
        match self {
            Self::Haar => Kernel::Lifting(&HAAR),
            Self::Daubechies4 => Kernel::Orthonormal(&DAUBECHIES4),
            Self::Coiflet6 => Kernel::Orthonormal(&COIFLET6),
            Self::Cdf26 => Kernel::Lifting(&CDF26),
            Self::CdfSpline26 => Kernel::Lifting(&CDF_SPLINE26),
            Self::Cdf97 => Kernel::Lifting(&CDF97),
            Self::FiveThree => Kernel::Integer,
        }
    }

    /// Where low coefficient 0 lies among the samples of its line: the mean place of its weights.
    #[must_use]
    pub fn low_centre(self) -> f64 {
        match (self.extension(), self.kernel()) {
            (_, Kernel::Orthonormal(taps)) => taps.iter().enumerate().map(|(k, tap)| k as f64 * tap).sum(),
            // Low coefficients of filters of even length lie between two samples, all others on one.
            (Extension::Periodic | Extension::HalfSample, _) => 0.5,
            (Extension::Symmetric, _) => 0.0,
        }
    }

    /// The factor by which one transform multiplies a constant line of more than one sample.
    #[must_use]
    pub const fn low_gain(self) -> f64 {
        match self {
            Self::Cdf97 => CDF97_K,
            _ => 1.0,
        }
    }
}
