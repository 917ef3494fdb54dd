//! The WGSL of a run of samples along a line, written from the filter's own steps.
//!
//! An invocation makes [`PAIRS`] pairs of neighbouring samples from the low and high coefficients around them. All
//! numbers of a run have names of their own, because arrays that are indexed in loops leave the registers.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;

use crate::transform::{Extension, Filter, Half, Kernel, Step};

/// Pairs of samples of one invocation.
pub const PAIRS: i32 = 8;

/// What a pass reads and writes.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Along z, from the bands of a level and the low band of the level before.
    Bands,
    /// Along y or x, from scratch to scratch.
    Axis,
    /// Along x, from scratch to the frame.
    Last,
}

const BANDS: &str = include_str!("bands.wgsl");
const AXIS: &str = include_str!("axis.wgsl");
const TO_SCRATCH: &str = include_str!("to_scratch.wgsl");
const TO_FRAME: &str = include_str!("to_frame.wgsl");

/// What makes a value of a quantised coefficient.
#[must_use]
pub const fn dequantisation(filter: Filter) -> &'static str {
    if filter.is_integer() { include_str!("integer_value.wgsl") } else { include_str!("float_value.wgsl") }
}

/// The whole module of a pass.
#[must_use]
pub fn module(filter: Filter, pass: Pass) -> String {
    let value = if filter.is_integer() { "i32" } else { "f32" };
    let parts: &[&str] = match pass {
        Pass::Bands => &[BANDS, dequantisation(filter)],
        Pass::Axis => &[AXIS, TO_SCRATCH],
        Pass::Last => &[AXIS, TO_FRAME],
    };
    let mut out =
        format!("alias wavelet_Value = {value};\n\n{}\n{}", extension(filter.extension()), parts.concat());
    out += "\n// Pairs of samples from pair `first` on.\nfn wavelet_run(line: wavelet_Line, first: i32) {\n";
    out += &match filter.kernel() {
        Kernel::Lifting(steps) => lifting(steps, PAIRS, filter.extension()),
        Kernel::Integer => integers(PAIRS),
        Kernel::Orthonormal(taps) => orthonormal(taps, PAIRS),
    };
    for i in 0..PAIRS {
        _ = writeln!(out, "    wavelet_store(line, 2 * (first + {i}), e{i});");
        _ = writeln!(out, "    wavelet_store(line, 2 * (first + {i}) + 1, o{i});");
    }
    out += "}\n";
    out
}

/// The texts of a filter's passes.
#[derive(Clone, Debug)]
pub struct Texts {
    /// From the bands of a level.
    pub bands: String,
    /// From scratch to scratch.
    pub axis: String,
    /// From scratch to the frame.
    pub last: String,
    /// Of a frame without decompositions.
    pub lll: String,
}

impl Texts {
    /// The texts of a filter.
    #[must_use]
    pub fn new(filter: Filter) -> Self {
        let [bands, axis, last] = [Pass::Bands, Pass::Axis, Pass::Last].map(|pass| module(filter, pass));
        let lll = [include_str!("lll.wgsl"), dequantisation(filter)].concat();
        Self { bands, axis, last, lll }
    }
}

/// Where a coefficient beyond the ends of a line is read, and whether it counts.
fn extension(extension: Extension) -> &'static str {
    match extension {
        Extension::Periodic => include_str!("periodic.wgsl"),
        Extension::Symmetric => include_str!("symmetric.wgsl"),
        Extension::HalfSample => include_str!("half_sample.wgsl"),
    }
}

/// A name of coefficient or sample `i` of a half: `e0`, `om1`.
fn name(half: Half, i: i32) -> String {
    let letter = if half == Half::Even { 'e' } else { 'o' };
    if i < 0 { format!("{letter}m{}", -i) } else { format!("{letter}{i}") }
}

/// Reads the coefficients of these ranges.
fn loads(out: &mut String, even: Range<i32>, odd: Range<i32>) {
    for (half, range) in [(Half::Even, even), (Half::Odd, odd)] {
        let read = if half == Half::Even { "wavelet_low" } else { "wavelet_high" };
        for i in range {
            _ = writeln!(out, "    var {} = {read}(line, first + {i});", name(half, i));
        }
    }
}

const fn union(a: Range<i32>, b: Range<i32>) -> Range<i32> {
    let start = if a.start < b.start { a.start } else { b.start };
    start..if a.end > b.end { a.end } else { b.end }
}

/// The ranges that each step of the analysis has to be undone on, and those of the coefficients.
fn ranges(steps: &[(Half, Range<i32>)], pairs: i32) -> (Vec<Range<i32>>, BTreeMap<bool, Range<i32>>) {
    let mut needed = BTreeMap::from([(true, 0..pairs), (false, 0..pairs)]);
    let undone = steps.iter().map(|(to, reach)| {
        let even = *to == Half::Even;
        let own = needed[&even].clone();
        let reached = own.start + reach.start..own.end + reach.end - 1;
        let other = union(needed[&!even].clone(), reached);
        needed.insert(!even, other);
        own
    });
    (undone.collect(), needed)
}

fn lifting(steps: &[Step], pairs: i32, extension: Extension) -> String {
    let reach = |step: &Step| step.first as i32..step.first as i32 + step.taps.len() as i32;
    let list: Vec<_> = steps.iter().map(|step| (step.to, reach(step))).collect();
    let (undone, needed) = ranges(&list, pairs);
    let mut out = String::new();
    loads(&mut out, needed[&true].clone(), needed[&false].clone());
    for (step, range) in steps.iter().zip(undone).rev() {
        let other = if step.to == Half::Even { Half::Odd } else { Half::Even };
        for i in range {
            let term = |(k, tap): (usize, &f64)| {
                let from = name(other, i + step.first as i32 + k as i32);
                (*tap != 0.0).then(|| format!("({:?} * {from})", *tap as f32))
            };
            let sum: Vec<String> = step.taps.iter().enumerate().filter_map(term).collect();
            let to = name(step.to, i);
            _ = writeln!(out, "    {to} = {to} - ({});", sum.join(" + "));
            if extension == Extension::HalfSample && step.to == Half::Odd {
                _ = writeln!(out, "    {to} = select(0.0, {to}, wavelet_counts(first + {i}));");
            }
        }
    }
    out
}

/// JPEG 2000 part 1, equations F-5 and F-6.
fn integers(pairs: i32) -> String {
    let (undone, needed) = ranges(&[(Half::Odd, 0..2), (Half::Even, -1..1)], pairs);
    let mut out = String::new();
    loads(&mut out, needed[&true].clone(), needed[&false].clone());
    for i in undone[1].clone() {
        let [e, before, o] = [name(Half::Even, i), name(Half::Odd, i - 1), name(Half::Odd, i)];
        _ = writeln!(out, "    {e} = {e} - (({before} + {o} + 2) >> 2u);");
    }
    for i in undone[0].clone() {
        let [o, e, after] = [name(Half::Odd, i), name(Half::Even, i), name(Half::Even, i + 1)];
        _ = writeln!(out, "    {o} = {o} + (({e} + {after}) >> 1u);");
    }
    out
}

/// Twice the transposed taps.
fn orthonormal(taps: &[f64], pairs: i32) -> String {
    let n = taps.len();
    let back = n as i32 / 2 - 1;
    let mut out = String::new();
    for (letter, read) in [("l", "wavelet_low"), ("h", "wavelet_high")] {
        for i in -back..pairs {
            _ = writeln!(out, "    let {letter}{} = {read}(line, first + {i});", i + back);
        }
    }
    for i in 0..pairs {
        for (parity, to) in [(0, "e"), (1, "o")] {
            let term = |k: usize| {
                let at = i + back - k as i32;
                let tap = 2 * k + parity;
                let sign = if tap.is_multiple_of(2) { 1.0 } else { -1.0 };
                let [low, high] = [2.0 * taps[tap], 2.0 * sign * taps[n - 1 - tap]].map(|tap| tap as f32);
                format!("({low:?} * l{at}) + ({high:?} * h{at})")
            };
            let sum: Vec<String> = (0..n / 2).map(term).collect();
            _ = writeln!(out, "    let {to}{i} = {};", sum.join(" + "));
        }
    }
    out
}
