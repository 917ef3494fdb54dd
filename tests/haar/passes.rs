//! What the device runs: one pass that loads, three for each level, one that finishes.

use std::borrow::Cow;

use cvr_core::codec::*;
use cvr_core::volume::*;

use super::HaarDecoder;
use super::transform::boxes;

/// One of the four texts.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Pass {
    Load,
    Lift,
    Row,
    Finish,
}

/// The texts, which tests may change.
#[derive(Clone, Debug)]
pub struct Passes {
    texts: [Cow<'static, str>; 4],
    /// Workgroups along x that the last pass has too many.
    pub idle_workgroups: u32,
}

const FILES: [&str; 4] =
    ["tests/haar/load.wgsl", "tests/haar/lift.wgsl", "tests/haar/row.wgsl", "tests/haar/finish.wgsl"];

impl Default for Passes {
    fn default() -> Self {
        let texts = [
            include_str!("load.wgsl"),
            include_str!("lift.wgsl"),
            include_str!("row.wgsl"),
            include_str!("finish.wgsl"),
        ];
        Self { texts: texts.map(Cow::Borrowed), idle_workgroups: 0 }
    }
}

impl Passes {
    /// `from`, which must occur, reads `to`.
    pub fn change(&mut self, pass: Pass, from: &str, to: &str) {
        let text = &mut self.texts[pass as usize];
        assert!(text.contains(from), "the pass has changed: it holds no `{from}`");
        *text = Cow::Owned(text.replace(from, to));
    }
}

impl HaarDecoder {
    /// A pass with these constants beside those that all have.
    fn pass(
        &self,
        pass: Pass,
        more: &[(&'static str, ConstantValue)],
        workgroups: [u32; 3],
        scratch: &[(&'static str, &'static str)],
    ) -> FramePass<'_> {
        let common = [
            ("extent", ConstantValue::Vec3U32(self.layout.extent.to_array())),
            ("channels", ConstantValue::U32(self.layout.channels)),
            ("samples", ConstantValue::U32(self.layout.samples_per_frame() as u32)),
        ];
        let constants = common.iter().chain(more).map(|&(name, value)| Constant { name, value }).collect();
        FramePass {
            module: WgslModule {
                file: FILES[pass as usize],
                source: &self.passes.texts[pass as usize],
                constants,
            },
            entry: ["load", "lift", "row", "finish"][pass as usize],
            workgroups,
            scratch: scratch.iter().map(|&(name, buffer)| ScratchUse { name, buffer }).collect(),
        }
    }
}

impl FrameDecode for HaarDecoder {
    fn passes(&self, frame: FrameIndex, level: Level) -> Result<FramePasses<'_>, DecodeError> {
        check_key(&self.layout, BrickKey { frame, level, region: Region::whole(self.layout.extent) })?;
        let samples = self.layout.samples_per_frame();
        let words = &self.coefficients[frame.0 as usize * samples as usize..][..samples as usize];
        let groups = samples.div_ceil(64);
        let all = [groups.min(1000) as u32, groups.div_ceil(1000) as u32, 1];
        let channels = self.layout.channels;

        let mut passes = vec![self.pass(Pass::Load, &[], all, &[("to", "a")])];
        for of_level in boxes(self.layout.extent.to_array(), self.levels).into_iter().rev() {
            let [x, y, z] = of_level;
            for (axis, from, to) in [(2, "a", "b"), (1, "b", "a")] {
                let constants =
                    [("box", ConstantValue::Vec3U32(of_level)), ("axis", ConstantValue::U32(axis))];
                let workgroups = [(x * channels).div_ceil(64), y, z];
                passes.push(self.pass(Pass::Lift, &constants, workgroups, &[("from", from), ("to", to)]));
            }
            let length = [("length", ConstantValue::U32(x))];
            passes.push(self.pass(Pass::Row, &length, [channels, y, z], &[("sample", "a")]));
        }
        let all = [all[0] + self.passes.idle_workgroups, all[1], 1];
        passes.push(self.pass(Pass::Finish, &[], all, &[("sample", "a")]));
        let scratch = vec![Scratch { name: "a", words: samples }, Scratch { name: "b", words: samples }];
        let resources = vec![Resource { name: "coefficients", words: Cow::Borrowed(words) }];
        Ok(FramePasses { resources, scratch, passes, result: "a" })
    }

    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }
}
