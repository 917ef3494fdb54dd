//! How a shader finds the segment of a value without a loop.

/// How a shader finds the segment of a value. This is structure and part of the shader's text. The values are in
/// buffers.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum SegmentSearch {
    /// It compares with every point; they lie in the view.
    Every {
        /// How many there are.
        points: u32,
    },
    /// A guide of equal cells over the domain. Each cell names the points that it may contain.
    Guide {
        /// Whether they are up to three, and not one.
        wide: bool,
    },
    /// A tree of four values in each node.
    Tree {
        /// Nodes from the root to a leaf.
        levels: u32,
    },
}

impl SegmentSearch {
    /// Most points that are all compared with.
    const EVERY: usize = 8;
    /// Cells that a guide may have.
    const CELLS: [usize; 3] = [1024, 4096, 8192];
    /// A shader's rounding moves a position by less than this, in cells.
    const APRON: f64 = 0.01;
    /// Limits on magnitude and width of a guide's domain. Within them, a shader's position in cells cannot overflow or
    /// underflow.
    const MAGNITUDE: f32 = 1e37;
    const WIDTH: f64 = 1e-30;
    /// The last segment that a tree may name: the one beyond all points.
    pub const TREE_END: usize = super::TransferFunction::MAX_POINTS + 1;

    /// The cheapest for these values, which do not decrease.
    pub(super) fn of(values: &[f32]) -> Self {
        if values.len() <= Self::EVERY {
            return Self::Every { points: values.len() as u32 };
        }
        for wide in [false, true] {
            if guide(values, wide).is_some() {
                return Self::Guide { wide };
            }
        }
        let mut levels = 1;
        while keys_of(levels) < values.len() {
            levels += 1;
        }
        Self::Tree { levels }
    }

    /// The last segment that the search may name. All segments beyond the last point are alike.
    pub(super) fn last_segment(self, points: usize) -> usize {
        match self {
            Self::Every { .. } => points,
            Self::Guide { wide } => points + named(wide),
            Self::Tree { levels } => keys_of(levels).min(Self::TREE_END),
        }
    }

    /// Keys of the view.
    pub(super) fn keys(self, values: &[f32]) -> [[f32; 4]; 2] {
        match self {
            Self::Every { .. } => [0, 1].map(|four| std::array::from_fn(|k| key(values, 4 * four + k))),
            Self::Guide { wide } => {
                let (first, last) = (values[0], key(values, values.len()));
                let cells = guide(values, wide).map_or(0, |cells| cells.len());
                let per_unit = cells as f64 / (f64::from(last) - f64::from(first));
                [[first, last, per_unit as f32, cells as f32 - 1.0], [0.0; 4]]
            }
            Self::Tree { .. } => [[0.0; 4]; 2],
        }
    }

    /// Texels of the table's first row.
    pub(super) fn texels(self, values: &[f32]) -> Vec<[f32; 4]> {
        match self {
            Self::Every { .. } => Vec::new(),
            Self::Guide { wide } => {
                let cell = |below: usize| {
                    let from = if wide { below } else { below.saturating_sub(1) };
                    let keys = [from, below + usize::from(wide), below + 1 + usize::from(wide)];
                    let [a, b, c] = keys.map(|i| key(values, i));
                    [below as f32, a, b, c]
                };
                guide(values, wide).into_iter().flatten().map(cell).collect()
            }
            Self::Tree { levels } => {
                let level = |depth: u32| {
                    let apart = 5_usize.pow(levels - 1 - depth);
                    let node =
                        move |i: usize| std::array::from_fn(|k| key(values, (5 * i + k + 1) * apart - 1));
                    (0..5_usize.pow(depth)).map(node)
                };
                (0..levels).flat_map(level).collect()
            }
        }
    }
}

/// Number of values in a tree with this many levels.
const fn keys_of(levels: u32) -> usize {
    5_usize.pow(levels) - 1
}

/// Most points in a cell of a guide.
const fn named(wide: bool) -> usize {
    if wide { 3 } else { 1 }
}

/// Value `i`, or the last one.
fn key(values: &[f32], i: usize) -> f32 {
    values[i.min(values.len() - 1)]
}

/// For each cell, the number of values that certainly lie below it, under any rounding of the position. `None` if even
/// the smallest cells would hold more values than a cell can name.
fn guide(values: &[f32], wide: bool) -> Option<Vec<usize>> {
    let ends = [values[0], values[values.len() - 1]];
    let [first, last] = ends.map(f64::from);
    if ends.iter().any(|end| end.abs() > SegmentSearch::MAGNITUDE) || last - first < SegmentSearch::WIDTH {
        return None;
    }
    SegmentSearch::CELLS.into_iter().find_map(|cells| {
        let position = |value: f32| (f64::from(value) - first) / (last - first) * cells as f64;
        let (mut below, mut reached) = (0, 0);
        let cell = |cell: usize| {
            let (begin, end) = (cell as f64 - SegmentSearch::APRON, (cell + 1) as f64 + SegmentSearch::APRON);
            while below < values.len() && position(values[below]) < begin {
                below += 1;
            }
            while reached < values.len() && position(values[reached]) <= end {
                reached += 1;
            }
            (reached - below <= named(wide)).then_some(below)
        };
        (0..cells).map(cell).collect()
    })
}
