//! A checked stream: bricks on the CPU, and the data of the shader.

use std::borrow::Cow;

use cvr_core::codec::{Agreement, DecodeError, DecodedForm, Resource, WgslModule};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::kit::{PartedTensor, StreamReader};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ValueRange, VolumeLayout};
use rayon::prelude::*;

use super::decode::group::Group;
use super::decode::{CONSTANT, Frame, Head};
use super::shape::{CHILD_PLACES, Parameters, ROOT_PLACES, Shape};
use super::{BITS, Filter, TABLE};

/// A stream that is read. Each entry of its table was checked, so no fetch reads outside.
#[derive(Debug)]
pub struct Reader {
    layout: VolumeLayout,
    shape: Shape,
    table: PartedTensor,
    /// `None` if all blocks are constant.
    bits: Option<Tensor>,
    /// First word of each frame, and the end of the last.
    starts: Vec<usize>,
}

impl Reader {
    /// Opens a stream of blocks.
    ///
    /// # Errors
    /// If tensors or parameters are missing, out of range or contradict each other.
    pub fn open(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        let layout = volume.spec().layout.clone();
        let parameters: Parameters = volume.parameters()?;
        let shape = Shape::new(&layout, &parameters).ok_or_else(|| {
            let problem =
                format!("for {} frame(s) of {} voxels: {parameters:?}", layout.frames, layout.extent);
            DecodeError::Corrupt(problem)
        })?;
        let table = [u64::from(layout.frames), u64::from(layout.channels), shape.grid.blocks().voxels()];
        let table = PartedTensor::open(volume, TABLE, &table)?;
        let ends = parameters.frame_words.iter().try_fold(vec![0_u64], |mut ends, words| {
            ends.push(ends.last()?.checked_add(*words)?);
            Some(ends)
        });
        let ends = ends.ok_or_else(|| DecodeError::Corrupt("frames of more than 2^64 words".to_owned()))?;
        let all = ends.last().copied().unwrap_or_default();
        let bits = match all {
            0 => None,
            _ => Some(volume.tensor_of_shape(BITS, Element::U32, &[all])?.clone()),
        };
        // The tensor has so many words, so they fit.
        let starts = ends.into_iter().map(|end| end as usize).collect();
        let reader = Self { layout, shape, table, bits, starts };
        (0..reader.layout.frames).try_for_each(|frame| reader.check(frame))?;
        Ok(reader)
    }

    fn of_frame(&self, frame: u32) -> Frame<'_> {
        let i = frame as usize;
        let words = self.bits.as_ref().map_or(&[][..], Tensor::words);
        let words = &words[self.starts[i]..self.starts[i + 1]];
        Frame { table: self.table.part(i), words, shape: &self.shape }
    }

    /// Checks all entries of a frame.
    fn check(&self, frame: u32) -> Result<(), DecodeError> {
        let of = self.of_frame(frame);
        let outside = of.table.par_iter().position_first(|entry| !is_inside(of, *entry));
        outside.map_or(Ok(()), |entry| {
            let problem = format!("the bits of entry {entry} of frame {frame} are unsound or lie outside");
            Err(DecodeError::Corrupt(problem))
        })
    }
}

/// Whether all bits of a block lie inside its frame, and its groups are sound.
fn is_inside(frame: Frame<'_>, entry: u32) -> bool {
    if entry & CONSTANT != 0 {
        return true;
    }
    let Some(head) = Head::checked(frame, entry) else { return false };
    let Some((first, root)) = head.root_at() else { return true };
    let end = 32 * frame.words.len().saturating_sub(first) as u64;
    let group = |first, bit, places: usize| Group::is_inside(frame.words, first, bit, places as u32, end);
    // The places of the children lie before the root.
    if !group(first, root, ROOT_PLACES) {
        return false;
    }
    frame.shape.edge() == 8
        || (0..8).all(|child| head.child_at(child).is_none_or(|(first, bit)| group(first, bit, CHILD_PLACES)))
}

impl StreamReader for Reader {
    type Frame<'a> = Frame<'a>;

    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn frame(&self, frame: FrameIndex, _level: Level) -> Frame<'_> {
        self.of_frame(frame.0)
    }

    /// The range of all values. A range of each block would cost bits.
    fn range(&self, _key: BrickKey) -> Option<ValueRange> {
        Some(self.shape.scale.range())
    }

    fn decoded_form(&self) -> DecodedForm {
        DecodedForm::of(self.layout.sample)
    }

    /// Places of a block's bits count bytes in 31 bits, so words always fit.
    fn fits_a_shader(&self) -> bool {
        self.shape.entries() <= u64::from(u32::MAX)
    }

    fn module(&self) -> WgslModule<'_> {
        let s = &self.shape;
        let source = match s.filter {
            Filter::Haar => concat!(include_str!("decode.wgsl"), "\n", include_str!("haar.wgsl")),
            Filter::FiveThree => concat!(include_str!("decode.wgsl"), "\n", include_str!("five_three.wgsl")),
        };
        let steps = s.steps.map(|kinds| kinds.map(|step| step as u32));
        WgslModule::new("codecs/wavelet/src/blocks/decode.wgsl", source)
            .with("grid", s.grid.blocks())
            .with("edge", s.edge() as u32)
            .with("levels", s.edge().ilog2())
            .with("channels", s.channels)
            .with("low_bits", s.low_bits)
            .with("low_base", s.low_base as u32)
            .with("low_step", s.low_step as u32)
            .with("steps_0", steps[0])
            .with("steps_1", steps[1])
            .with("steps_2", steps[2])
            .with("steps_3", steps[3])
            .with("fraction", s.scale.fraction)
            .with("lowest", s.scale.low as u32)
            .with("highest", s.scale.high as u32)
            .with("offset", s.scale.offset)
            .with("unit", s.scale.unit)
    }

    /// Integers up to the last step, whose product and integer are exact: one rounding, fused or not.
    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }

    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>> {
        let words = Cow::Borrowed(self.of_frame(frame.0).words);
        vec![self.table.resource(frame.0 as usize), Resource { name: BITS, words }]
    }
}
