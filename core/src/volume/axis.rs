//! The axes of a volume, and layers of voxels across them.

/// An axis of a volume.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Axis {
    /// Along x; layers across it are planes of y and z.
    X,
    /// Along y; layers across it are planes of x and z.
    Y,
    /// Along z; layers across it are planes of x and y.
    Z,
}

impl Axis {
    /// All three, x first.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// 0, 1 or 2.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The components of x, y, z in the order of layers across this axis: along the rows of a layer, across its rows,
    /// and from layer to layer.
    #[must_use]
    pub fn layered<T>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Self::X => [y, z, x],
            Self::Y => [x, z, y],
            Self::Z => [x, y, z],
        }
    }

    /// The inverse of [`Axis::layered`]: from the order of layers back to x, y, z.
    #[must_use]
    pub fn unlayered<T>(self, [along, across, layer]: [T; 3]) -> [T; 3] {
        match self {
            Self::X => [layer, along, across],
            Self::Y => [along, layer, across],
            Self::Z => [along, across, layer],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_lie_across_their_axis_and_back() {
        for axis in Axis::ALL {
            let layered = axis.layered(["x", "y", "z"]);
            assert_eq!(layered[2], ["x", "y", "z"][axis.index()]);
            assert_eq!(axis.unlayered(layered), ["x", "y", "z"]);
        }
    }
}
