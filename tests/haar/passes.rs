//! The passes on the device: one loads, three run per level, one finishes, and for a predicted frame one adds its
//! reference.

use std::borrow::Cow;

use cvr_core::codec::*;
use cvr_core::volume::*;

use super::HaarDecoder;
use super::transform::boxes;

/// One of the texts.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Pass {
    Load,
    Lift,
    Row,
    Finish,
    Low,
    Add,
}

/// The texts, which tests may change.
#[derive(Clone, Debug)]
pub struct Passes {
    texts: [Cow<'static, str>; 6],
    /// Workgroups along x that the last pass has too many.
    pub idle_workgroups: u32,
}

const FILES: [&str; 6] = [
    "tests/haar/load.wgsl",
    "tests/haar/lift.wgsl",
    "tests/haar/row.wgsl",
    "tests/haar/finish.wgsl",
    "tests/haar/low.wgsl",
    "tests/haar/add.wgsl",
];

impl Default for Passes {
    fn default() -> Self {
        let texts = [
            include_str!("load.wgsl"),
            include_str!("lift.wgsl"),
            include_str!("row.wgsl"),
            include_str!("finish.wgsl"),
            include_str!("low.wgsl"),
            include_str!("add.wgsl"),
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
    /// A pass over a frame of this layout, with these constants and those that all passes have.
    fn pass(
        &self,
        (pass, layout): (Pass, &VolumeLayout),
        more: &[(&'static str, ConstantValue)],
        workgroups: [u32; 3],
        scratch: &[(&'static str, &'static str)],
    ) -> FramePass<'_> {
        let common = [
            ("extent", ConstantValue::Vec3U32(layout.extent.to_array())),
            ("channels", ConstantValue::U32(layout.channels)),
            ("samples", ConstantValue::U32(layout.samples_per_frame() as u32)),
        ];
        let constants = common.iter().chain(more).map(|&(name, value)| Constant { name, value }).collect();
        FramePass {
            module: WgslModule {
                file: FILES[pass as usize],
                source: &self.passes.texts[pass as usize],
                constants,
            },
            entry: ["load", "lift", "row", "finish", "low", "add"][pass as usize],
            workgroups,
            scratch: scratch.iter().map(|&(name, buffer)| ScratchUse { name, buffer }).collect(),
        }
    }
}

impl FrameDecode for HaarDecoder {
    fn passes(&self, frame: FrameIndex, level: Level) -> Result<FramePasses<'_>, DecodeError> {
        let layout = &self.layout.at_resolution(level.resolution);
        let key = BrickKey { frame, level, region: Region::whole(layout.extent) };
        check_key_at(&self.layout, self.resolutions(), key)?;
        let stored = self.layout.samples_per_frame() as usize;
        let words = &self.coefficients[frame.0 as usize * stored..][..stored];
        let samples = layout.samples_per_frame();
        let groups = samples.div_ceil(64);
        let all = [groups.min(1000) as u32, groups.div_ceil(1000) as u32, 1];
        let channels = layout.channels;

        let mut passes = vec![match level.resolution {
            0 => self.pass((Pass::Load, layout), &[], all, &[("to", "a")]),
            _ => {
                let stored = [("stored", ConstantValue::Vec3U32(self.layout.extent.to_array()))];
                self.pass((Pass::Low, layout), &stored, all, &[("to", "a")])
            }
        }];
        let levels = self.levels - u32::from(level.resolution);
        for of_level in boxes(layout.extent.to_array(), levels).into_iter().rev() {
            let [x, y, z] = of_level;
            for (axis, from, to) in [(2, "a", "b"), (1, "b", "a")] {
                let constants =
                    [("box", ConstantValue::Vec3U32(of_level)), ("axis", ConstantValue::U32(axis))];
                let workgroups = [(x * channels).div_ceil(64), y, z];
                let scratch = [("from", from), ("to", to)];
                passes.push(self.pass((Pass::Lift, layout), &constants, workgroups, &scratch));
            }
            let length = [("length", ConstantValue::U32(x))];
            passes.push(self.pass((Pass::Row, layout), &length, [channels, y, z], &[("sample", "a")]));
        }
        let idle = [all[0] + self.passes.idle_workgroups, all[1], 1];
        passes.push(self.pass((Pass::Finish, layout), &[], idle, &[("sample", "a")]));
        if self.dependencies(frame) != Dependencies::Intra {
            passes.push(self.pass((Pass::Add, layout), &[], all, &[("sample", "a")]));
        }
        let scratch = vec![Scratch { name: "a", words: samples }, Scratch { name: "b", words: samples }];
        let resources = vec![Resource { name: "coefficients", words: Cow::Borrowed(words) }];
        Ok(FramePasses { resources, scratch, passes, result: "a" })
    }

    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }
}
