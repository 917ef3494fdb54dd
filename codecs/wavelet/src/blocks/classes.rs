//! Classes of the places of a group. All places of a class have records of one format, so a shader counts bits of planes
//! to find any record.

use super::bits::width_of;
use super::shape::KIND;

/// Bits of a format in a stream.
pub const FORMAT_BITS: u32 = 16;

/// Form of the seven coefficients of a place.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// No coefficient: all are 0.
    #[default]
    Empty,
    /// All coefficients in two's complement. Widths of those that are high-pass along one, two and three axes.
    Dense([u32; 3]),
    /// A mask of seven bits, and room for so many coefficients: a sign and the magnitude less one, of so many bits
    /// together.
    Sparse(u32, u32),
}

impl Format {
    /// Bits of a record.
    pub const fn record_bits(self) -> u32 {
        match self {
            Self::Empty => 0,
            Self::Dense([a, b, c]) => 3 * a + 3 * b + c,
            Self::Sparse(count, width) => 7 + count * width,
        }
    }

    /// The format as a stream holds it.
    pub const fn code(self) -> u32 {
        match self {
            Self::Empty => 0,
            Self::Dense([a, b, c]) => a | b << 5 | c << 10,
            Self::Sparse(count, width) => 1 << 15 | count | width << 5,
        }
    }
}

/// What a place needs, and what several places need together.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
struct Need {
    dense: [u32; 3],
    count: u32,
    width: u32,
}

impl Need {
    fn of(place: &[i32; 7]) -> Self {
        let mut need = Self::default();
        for (q, kind) in place.iter().zip(KIND).filter(|(q, _)| **q != 0) {
            let signed = width_of((if *q < 0 { !*q } else { *q }) as u32) + 1;
            need.dense[kind] = need.dense[kind].max(signed);
            need.count += 1;
            need.width = need.width.max(width_of(q.unsigned_abs() - 1) + 1);
        }
        need
    }

    fn and(self, other: Self) -> Self {
        Self {
            dense: [0, 1, 2].map(|k| self.dense[k].max(other.dense[k])),
            count: self.count.max(other.count),
            width: self.width.max(other.width),
        }
    }

    /// The shorter format that holds it.
    fn format(self) -> Format {
        if self.count == 0 {
            return Format::Empty;
        }
        let (dense, sparse) = (Format::Dense(self.dense), Format::Sparse(self.count, self.width));
        if dense.record_bits() <= sparse.record_bits() { dense } else { sparse }
    }
}

/// How a group is coded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Classes {
    /// Planes that hold the class of each place: 0, 1 or 2.
    pub planes: u32,
    /// Whether class 0 is empty and its format not written.
    pub bare: bool,
    /// Format of each class.
    pub formats: [Format; 4],
    /// Class of each place.
    pub classes: Vec<u8>,
    /// Bits of all that follows the code of planes: formats, planes and records.
    pub bits: u32,
}

impl Classes {
    /// The classes of a group that take the fewest bits. Places are ordered by the bits that each takes alone, and each
    /// class is a run of them.
    pub fn of(places: &[[i32; 7]]) -> Self {
        let needs: Vec<Need> = places.iter().map(Need::of).collect();
        let runs = Runs::of(&needs);
        let count = places.len() as u32;
        let mut best: Option<(u32, u32, bool, Vec<usize>)> = None;
        let mut offer = |planes: u32, bare: bool, (records, ends): (u32, Vec<usize>)| {
            let formats = (1 << planes) - u32::from(bare);
            let bits = FORMAT_BITS * formats + planes * count + records;
            if best.as_ref().is_none_or(|best| bits < best.0) {
                best = Some((bits, planes, bare, ends));
            }
        };
        let empty = usize::from(runs.costs.first() == Some(&0));
        if runs.needs.len() == empty {
            offer(0, true, (0, vec![runs.needs.len()]));
        } else {
            for planes in 0..3 {
                offer(planes, false, runs.cut(0, 1 << planes));
                if planes > 0 {
                    // Class 0 is what needs nothing, if there is any.
                    let (records, mut ends) = runs.cut(empty, (1 << planes) - 1);
                    ends.insert(0, empty);
                    offer(planes, true, (records, ends));
                }
            }
        }
        let (bits, planes, bare, ends) = best.unwrap_or_default();
        let mut formats = [Format::Empty; 4];
        let (mut from, mut class_of) = (0, vec![0_u8; runs.needs.len()]);
        for (class, end) in ends.iter().enumerate() {
            let all = runs.needs[from..*end].iter().copied().fold(Need::default(), Need::and);
            formats[class] = all.format();
            class_of[from..*end].fill(class as u8);
            from = *end;
        }
        let classes = runs.run_of.iter().map(|run| class_of[*run]).collect();
        Self { planes, bare, formats, classes, bits }
    }
}

/// Places of equal bits, by these bits.
struct Runs {
    costs: Vec<u32>,
    needs: Vec<Need>,
    counts: Vec<u32>,
    /// The run of each place.
    run_of: Vec<usize>,
}

impl Runs {
    fn of(needs: &[Need]) -> Self {
        let own: Vec<u32> = needs.iter().map(|need| need.format().record_bits()).collect();
        let mut costs = own.clone();
        costs.sort_unstable();
        costs.dedup();
        let run_of: Vec<usize> = own.iter().map(|cost| costs.partition_point(|c| c < cost)).collect();
        let (mut joined, mut counts) = (vec![Need::default(); costs.len()], vec![0; costs.len()]);
        for (need, run) in needs.iter().zip(&run_of) {
            joined[*run] = joined[*run].and(*need);
            counts[*run] += 1;
        }
        Self { costs, needs: joined, counts, run_of }
    }

    /// Cuts the runs from `first` on into at most `parts` classes with the fewest bits of records. Returns these bits and
    /// the end of each class.
    fn cut(&self, first: usize, parts: usize) -> (u32, Vec<usize>) {
        let n = self.needs.len();
        // `best[k][j]`: bits of the runs before `j` in `k + 1` classes, and where the last of these begins.
        let mut best = vec![vec![(u32::MAX, first); n + 1]; parts];
        for from in first..n {
            let (mut need, mut count) = (Need::default(), 0);
            for to in from..n {
                need = need.and(self.needs[to]);
                count += self.counts[to];
                let bits = count * need.format().record_bits();
                for k in 0..parts {
                    let before = match k {
                        0 if from == first => 0,
                        0 => continue,
                        // All classes that end at `from` are known: they begin before it.
                        _ => best[k - 1][from].0,
                    };
                    let all = before.saturating_add(bits);
                    if all < best[k][to + 1].0 {
                        best[k][to + 1] = (all, from);
                    }
                }
            }
        }
        let k = (0..parts).min_by_key(|k| best[*k][n].0).unwrap_or_default();
        let (mut ends, mut end) = (Vec::new(), n);
        for k in (0..=k).rev() {
            ends.push(end);
            end = best[k][end].1;
        }
        ends.reverse();
        (best[k][n].0, ends)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_takes_the_shorter_format() {
        assert_eq!(Need::of(&[0; 7]).format(), Format::Empty);
        assert_eq!(Need::of(&[0, 0, 0, 0, 0, 0, 1]).format(), Format::Dense([0, 0, 2]));
        assert_eq!(Need::of(&[0, 1, 0, 0, 0, 1, 0]).format(), Format::Sparse(2, 1));
        assert_eq!(Need::of(&[-2, 1, 0, 0, 0, 0, 0]).format(), Format::Dense([2, 0, 0]));
        assert_eq!(Need::of(&[9, 1, 0, 0, 0, 0, 0]).format(), Format::Dense([5, 0, 0]));
        assert_eq!(Need::of(&[9, 0, 0, 3, 0, 0, 0]).format(), Format::Sparse(2, 5));
    }

    #[test]
    fn places_alike_share_a_class() {
        let nothing = Classes::of(&[[0; 7]; 64]);
        assert_eq!((nothing.planes, nothing.bare, nothing.bits), (0, true, 0));
        let alike = Classes::of(&[[1, -1, 1, -1, 1, -1, 1]; 64]);
        assert_eq!((alike.planes, alike.bare, alike.bits), (0, false, 16 + 64 * 14));
        let mut places = [[0; 7]; 64];
        places[5] = [1, 0, 0, 0, 0, 0, 0];
        let one = Classes::of(&places);
        assert_eq!((one.planes, one.bare, one.bits), (1, true, 16 + 64 + 6));
        assert_eq!(one.classes.iter().filter(|class| **class == 1).count(), 1);
        (10..30).for_each(|i| places[i] = [100, -100, 50, 20, 9, 3, 1]);
        (30..50).for_each(|i| places[i] = [3; 7]);
        let four = Classes::of(&places);
        assert_eq!((four.planes, four.bare), (2, true));
        assert!(four.bits < Runs::of(&[Need::of(&places[10])]).costs[0] * 40);
    }
}
