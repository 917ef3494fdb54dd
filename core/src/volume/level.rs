//! How much of an encoded volume is decoded.

/// How much of an encoded volume to decode: two independent numbers.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Level {
    /// 0 = full resolution; every further step halves each axis.
    pub resolution: u8,
    /// Refinement terms to sum; [`Level::ALL_STAGES`] = all that exist.
    pub stages: u8,
}

impl Level {
    /// Every refinement term that the stream holds.
    pub const ALL_STAGES: u8 = u8::MAX;
    /// Number of voxels of the volume along each axis that one voxel of this resolution covers: 2^r.
    #[must_use]
    pub fn scale(resolution: u8) -> f64 {
        // No axis has more than 2^32 voxels.
        2.0_f64.powi(i32::from(resolution.min(32)))
    }

    /// Full resolution, all stages.
    pub const FULL: Self = Self { resolution: 0, stages: Self::ALL_STAGES };
}
