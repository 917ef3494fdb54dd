//! From stored bytes to the samples that are kept: byte order, wider number types, scaling.

use std::io::{ErrorKind, Read};

use cvr_core::memory;
use cvr_core::volume::{SampleType, Samples, StoredType};

use super::ByteOrder;

/// `stored × slope + intercept`, which makes single precision of any type.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Scale {
    pub slope: f64,
    pub intercept: f64,
}

/// Samples that arrive as stored bytes.
#[derive(Debug)]
pub(super) struct SampleSink {
    samples: Samples,
    stored: StoredType,
    scale: Option<Scale>,
    /// Samples whose value single precision cannot hold, though it holds one near it.
    rounded: u64,
}

/// The memory for more samples is not there.
#[derive(Copy, Clone, Debug)]
pub(super) struct NoMemory;

/// Bytes in memory in addition to the samples.
const CHUNK_BYTES: usize = 1 << 18;

/// A number as it lies in a file.
trait Stored: Copy {
    fn read(bytes: &[u8], order: ByteOrder) -> Self;
    /// The nearest double, and whether it is equal.
    fn to_double(self) -> (f64, bool);
    /// The nearest single-precision number, and whether it is equal.
    fn to_single(self) -> (f32, bool);
}

macro_rules! stored {
    ($($t:ty, $single:expr;)*) => {$(
        impl Stored for $t {
            fn read(bytes: &[u8], order: ByteOrder) -> Self {
                let bytes = bytes.try_into().unwrap_or_default();
                match order {
                    ByteOrder::Little => Self::from_le_bytes(bytes),
                    ByteOrder::Big => Self::from_be_bytes(bytes),
                }
            }

            #[allow(clippy::unnecessary_cast, clippy::cast_lossless, reason = "one expression serves all number types")]
            fn to_double(self) -> (f64, bool) {
                let double = self as f64;
                // 128 bits hold every integer here, and of a float only its equality with itself matters.
                (double, double as i128 == self as i128)
            }

            fn to_single(self) -> (f32, bool) {
                let single: fn(Self) -> (f32, bool) = $single;
                single(self)
            }
        }
    )*};
}

stored! {
    u8, |v| (f32::from(v), true);
    i8, |v| (f32::from(v), true);
    u16, |v| (f32::from(v), true);
    i16, |v| (f32::from(v), true);
    u32, |v| (v as f32, (v as f32) as i128 == i128::from(v));
    i32, |v| (v as f32, (v as f32) as i128 == i128::from(v));
    u64, |v| (v as f32, (v as f32) as i128 == i128::from(v));
    i64, |v| (v as f32, (v as f32) as i128 == i128::from(v));
    f32, |v| (v, true);
    f64, narrowed;
}

/// NaN, infinities and subnormals are counted when the volume is made finite, not here.
fn narrowed(v: f64) -> (f32, bool) {
    let single = v as f32;
    (single, f64::from(single) == v || !single.is_finite() || single.is_subnormal())
}

impl SampleSink {
    pub fn new(stored: StoredType, scale: Option<Scale>) -> Self {
        let kept = if scale.is_some() { SampleType::F32 } else { stored.kept() };
        let samples = match kept {
            SampleType::U8 => Samples::U8(Vec::new()),
            SampleType::I8 => Samples::I8(Vec::new()),
            SampleType::U16 => Samples::U16(Vec::new()),
            SampleType::I16 => Samples::I16(Vec::new()),
            _ => Samples::F32(Vec::new()),
        };
        Self { samples, stored, scale, rounded: 0 }
    }

    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Samples that have memory already.
    pub fn room(&self) -> usize {
        let capacity = match &self.samples {
            Samples::U8(v) => v.capacity(),
            Samples::I8(v) => v.capacity(),
            Samples::U16(v) => v.capacity(),
            Samples::I16(v) => v.capacity(),
            Samples::F32(v) => v.capacity(),
            _ => 0,
        };
        capacity.saturating_sub(self.len())
    }

    /// Checks that this many more samples fit into memory.
    pub fn check(&self, more: usize) -> Result<(), NoMemory> {
        let samples = (self.len() as u64).saturating_add(more as u64);
        let bytes = samples.saturating_mul(self.samples.sample_type().bytes() as u64);
        memory::check(bytes, String::new).map_err(|_| NoMemory)
    }

    /// Makes room for exactly this many more samples.
    pub fn reserve(&mut self, more: usize) -> Result<(), NoMemory> {
        self.check(more)?;
        match &mut self.samples {
            Samples::U8(v) => v.try_reserve_exact(more),
            Samples::I8(v) => v.try_reserve_exact(more),
            Samples::U16(v) => v.try_reserve_exact(more),
            Samples::I16(v) => v.try_reserve_exact(more),
            Samples::F32(v) => v.try_reserve_exact(more),
            _ => return Err(NoMemory),
        }
        .map_err(|_| NoMemory)
    }

    /// Appends whole samples; bytes of an incomplete one at the end are left out. The caller has reserved.
    pub fn push(&mut self, bytes: &[u8], order: ByteOrder) {
        match self.stored {
            StoredType::U8 => self.push_as::<u8>(bytes, order),
            StoredType::I8 => self.push_as::<i8>(bytes, order),
            StoredType::U16 => self.push_as::<u16>(bytes, order),
            StoredType::I16 => self.push_as::<i16>(bytes, order),
            StoredType::U32 => self.push_as::<u32>(bytes, order),
            StoredType::I32 => self.push_as::<i32>(bytes, order),
            StoredType::U64 => self.push_as::<u64>(bytes, order),
            StoredType::I64 => self.push_as::<i64>(bytes, order),
            StoredType::F32 => self.push_as::<f32>(bytes, order),
            StoredType::F64 => self.push_as::<f64>(bytes, order),
        }
    }

    fn push_as<S: Stored>(&mut self, bytes: &[u8], order: ByteOrder) {
        let numbers = bytes.chunks_exact(size_of::<S>());
        let rounded = &mut self.rounded;
        match (&mut self.samples, self.scale) {
            (Samples::U8(v), None) => v.extend_from_slice(bytes),
            (Samples::I8(v), None) => v.extend(bytes.iter().map(|&b| b as i8)),
            (Samples::U16(v), None) => v.extend(numbers.map(|b| u16::read(b, order))),
            (Samples::I16(v), None) => v.extend(numbers.map(|b| i16::read(b, order))),
            (Samples::F32(v), None) => v.extend(numbers.map(|b| {
                let (single, exact) = S::read(b, order).to_single();
                *rounded += u64::from(!exact);
                single
            })),
            (Samples::F32(v), Some(scale)) => v.extend(numbers.map(|b| {
                let (double, exact) = S::read(b, order).to_double();
                let (single, still) = narrowed(double * scale.slope + scale.intercept);
                *rounded += u64::from(!exact || !still);
                single
            })),
            // `new` makes scaled samples single precision.
            _ => {}
        }
    }

    /// The samples, and how many of them were rounded.
    pub fn finish(self) -> (Samples, u64) {
        (self.samples, self.rounded)
    }
}

/// Why a stream gave fewer samples than were asked for. Counts are bytes that it did give.
#[derive(Debug)]
pub(super) enum ReadFault {
    /// It ended.
    Short(u64),
    /// It failed.
    Failed(u64, std::io::Error),
    /// There is no memory for the samples.
    Memory,
}

/// Reads `count` samples. Memory is reserved at once where the caller knows that the stream holds them, and else
/// follows what has come.
pub(super) fn read_samples(
    sink: &mut SampleSink,
    stream: &mut dyn Read,
    order: ByteOrder,
    count: usize,
    at_once: bool,
) -> Result<(), ReadFault> {
    let size = sink.stored.bytes();
    // All of them, even where room is made as they come: what a header promises is compared first.
    sink.check(count).map_err(|NoMemory| ReadFault::Memory)?;
    if at_once {
        sink.reserve(count).map_err(|NoMemory| ReadFault::Memory)?;
    }
    let mut buffer = vec![0; CHUNK_BYTES.min(count.saturating_mul(size))];
    let mut reserved = if at_once { count } else { 0 };
    let mut read = 0;
    while read < count {
        let n = (count - read).min(CHUNK_BYTES / size);
        let bytes = &mut buffer[..n * size];
        let before = (read * size) as u64;
        match fill(stream, bytes) {
            (filled, None) if filled == bytes.len() => {}
            (filled, None) => return Err(ReadFault::Short(before + filled as u64)),
            (filled, Some(e)) => return Err(ReadFault::Failed(before + filled as u64, e)),
        }
        if read + n > reserved {
            let more = read.max(4 * n).min(count - read);
            sink.reserve(more).map_err(|NoMemory| ReadFault::Memory)?;
            reserved = read + more;
        }
        sink.push(bytes, order);
        read += n;
    }
    Ok(())
}

/// Reads until `out` is full, the stream ends, or it fails; says how many bytes came.
pub(super) fn fill(stream: &mut dyn Read, out: &mut [u8]) -> (usize, Option<std::io::Error>) {
    let mut filled = 0;
    while filled < out.len() {
        match stream.read(&mut out[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return (filled, Some(e)),
        }
    }
    (filled, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(stored: StoredType, scale: Option<Scale>, bytes: &[u8], order: ByteOrder) -> (Samples, u64) {
        let mut sink = SampleSink::new(stored, scale);
        read_samples(&mut sink, &mut &bytes[..], order, bytes.len() / stored.bytes(), false).unwrap();
        sink.finish()
    }

    #[test]
    fn what_single_precision_cannot_hold_is_counted() {
        let u64s = [0_u64, 1 << 24, (1 << 24) + 1, u64::MAX].map(u64::to_be_bytes).concat();
        let (samples, rounded) = kept(StoredType::U64, None, &u64s, ByteOrder::Big);
        assert_eq!(
            (samples, rounded),
            (Samples::F32(vec![0.0, 16_777_216.0, 16_777_216.0, 2_f32.powi(64)]), 2)
        );
        let i32s = [i32::MIN, -16_777_217, 5].map(i32::to_le_bytes).concat();
        assert_eq!(kept(StoredType::I32, None, &i32s, ByteOrder::Little).1, 1);
        let i64s = [i64::MIN, i64::MAX, -3].map(i64::to_le_bytes).concat();
        assert_eq!(kept(StoredType::I64, None, &i64s, ByteOrder::Little).1, 1);
        // NaN, infinities and subnormals are not rounded here: they are replaced, and counted, later on.
        let f64s = [0.5, 0.1, f64::NAN, f64::INFINITY, 1e300, 1e-40, 1e-300, f64::from(f32::MAX)];
        let (samples, rounded) =
            kept(StoredType::F64, None, &f64s.map(f64::to_le_bytes).concat(), ByteOrder::Little);
        let Samples::F32(v) = samples else { panic!("single precision") };
        assert_eq!((v[0], v[1], v[4], v[6], v[7]), (0.5, 0.1, f32::INFINITY, 0.0, f32::MAX));
        assert!(v[2].is_nan() && v[5].is_subnormal());
        assert_eq!(rounded, 2, "0.1 and 1e-300");
    }

    #[test]
    fn scaling_makes_single_precision() {
        let scale = Some(Scale { slope: 0.5, intercept: -1.0 });
        let (samples, rounded) = kept(StoredType::U8, scale, &[0, 1, 255], ByteOrder::Little);
        assert_eq!((samples, rounded), (Samples::F32(vec![-1.0, -0.5, 126.5]), 0));
        let scale = Some(Scale { slope: 0.1, intercept: 0.0 });
        assert_eq!(kept(StoredType::U8, scale, &[0, 1, 2], ByteOrder::Little).1, 2);
        let large = [u64::MAX, 2].map(u64::to_le_bytes).concat();
        let scale = Some(Scale { slope: 2.0, intercept: 0.0 });
        assert_eq!(kept(StoredType::U64, scale, &large, ByteOrder::Little).1, 1, "2^64 - 1 is no double");
        let floats = [f32::NAN, 1.0].map(f32::to_le_bytes).concat();
        assert_eq!(kept(StoredType::F32, scale, &floats, ByteOrder::Little).1, 0);
    }

    #[test]
    fn a_stream_that_ends_says_where() {
        let mut sink = SampleSink::new(StoredType::U16, None);
        let fault = read_samples(&mut sink, &mut &[0; 5][..], ByteOrder::Little, 3, false);
        assert!(matches!(fault, Err(ReadFault::Short(5))), "{fault:?}");
    }
}
