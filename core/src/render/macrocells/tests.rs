//! Ranges of a fake decoder, level by level.

use std::borrow::Cow;
use std::sync::atomic::AtomicBool;

use super::*;
use crate::codec::{BlockFormat, Resource, WgslModule};
use crate::render::ControlPoint;
use crate::volume::{ReferenceFrames, SampleType, VolumeLayout};

/// Decodes a function of level and voxel.
struct Fake {
    layout: VolumeLayout,
    value: fn(Level, [u32; 3]) -> f32,
    known: Option<ValueRange>,
    form: DecodedForm,
    agreement: Option<Agreement>,
    /// Scale and offset of blocks that a texture unit decodes.
    blocks: Option<(f32, f32)>,
}

impl Fake {
    fn new(size: [u32; 3], value: fn(Level, [u32; 3]) -> f32) -> Self {
        let layout = VolumeLayout::scalar(Extent::try_from(size).unwrap(), SampleType::F32);
        Self { layout, value, known: None, form: DecodedForm::FLOAT32, agreement: None, blocks: None }
    }

    fn ranges(&self, level: Level) -> MacrocellRanges {
        MacrocellRanges::decode(self, FrameIndex::FIRST, level, &AtomicBool::new(false)).unwrap().unwrap()
    }
}

impl std::fmt::Debug for Fake {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Fake")
    }
}

impl Decoder for Fake {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        _: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        if !key.region.fits(self.layout.extent.at_resolution(key.level.resolution)) {
            return Err(DecodeError::NoSuchBrick(format!("{key:?}")));
        }
        let width = key.region.extent.x() as usize;
        for (row, [x, y, z]) in out.chunks_mut(width).zip(key.region.rows()) {
            for (value, x) in row.iter_mut().zip(x..) {
                *value = (self.value)(key.level, [x, y, z]);
            }
        }
        Ok(())
    }

    fn value_range(&self, _: BrickKey) -> Option<ValueRange> {
        self.known
    }

    fn decoded_form(&self) -> DecodedForm {
        self.form
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        self.agreement.is_some().then_some(self)
    }

    fn block_texture(&self, _: FrameIndex, _: Level) -> Option<BlockTexture<'_>> {
        let (scale, offset) = self.blocks?;
        Some(BlockTexture { format: BlockFormat::Bc4, words: Cow::Borrowed(&[]), scale, offset })
    }
}

impl ShaderDecode for Fake {
    fn module(&self) -> WgslModule<'_> {
        WgslModule { file: "", source: "", constants: Vec::new() }
    }

    fn agreement(&self) -> Agreement {
        self.agreement.unwrap_or(Agreement::Exact)
    }

    fn resources(&self, _: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        Ok(Vec::new())
    }
}

/// Shows values above 1.
fn above_one() -> TransferFunction {
    let point = |value, alpha| ControlPoint { value, rgba: [1.0, 1.0, 1.0, alpha] };
    TransferFunction::new(vec![point(0.0, 0.0), point(1.0, 0.0), point(1.0, 1.0), point(2.0, 1.0)]).unwrap()
}

fn shown(macrocells: &Macrocells) -> Vec<[u32; 3]> {
    let grid = macrocells.grid();
    (0..grid.voxels() as usize).map(|i| grid.position(i)).filter(|&cell| macrocells.shows(cell)).collect()
}

#[test]
fn a_voxel_shows_in_the_macrocells_within_reach() {
    let whole = |_: Level, p| if p == [8, 3, 4] { 2.0 } else { 0.0 };
    let macrocells = Fake::new([33, 9, 8], whole).ranges(Level::FULL).classify(&above_one());
    assert_eq!(macrocells.grid().to_array(), [5, 2, 1]);
    assert_eq!(shown(&macrocells), [[0, 0, 0], [1, 0, 0]]);
    assert_eq!((macrocells.words(), macrocells.empty_share()), (&[3_u32][..], 0.8));
    let inside = |_: Level, p| if p == [17, 6, 3] { 2.0 } else { 0.0 };
    assert_eq!(shown(&Fake::new([33, 9, 8], inside).ranges(Level::FULL).classify(&above_one())), [[2, 0, 0]]);
    let corner = |_: Level, p| if p == [15, 7, 8] { 2.0 } else { 0.0 };
    let macrocells = Fake::new([24, 24, 24], corner).ranges(Level::FULL).classify(&above_one());
    assert_eq!(shown(&macrocells).len(), 8, "all that meet in the corner");
}

#[test]
fn what_is_no_number_is_never_skipped() {
    let nothing = TransferFunction::new(
        [0.0, 1.0].map(|value| ControlPoint { value, rgba: [1.0, 1.0, 1.0, 0.0] }).to_vec(),
    )
    .unwrap();
    let values: [fn(Level, [u32; 3]) -> f32; 3] = [
        |_, p| if p == [20, 4, 4] { f32::NAN } else { 0.0 },
        |_, p| if p == [20, 4, 4] { f32::INFINITY } else { 0.0 },
        |_, p| if p == [20, 4, 4] { f32::NEG_INFINITY } else { 0.0 },
    ];
    for value in values {
        let ranges = Fake::new([40, 8, 8], value).ranges(Level::FULL);
        assert_eq!(ranges.range([2, 0, 0]), None);
        assert!(ranges.range([1, 0, 0]).is_some());
        assert_eq!(shown(&ranges.classify(&nothing)), [[2, 0, 0]]);
    }
}

/// Later stages and finer voxels may show more or less than earlier and coarser ones.
#[test]
fn ranges_are_those_of_the_level() {
    let fake = Fake::new([40, 17, 9], |level, [x, _, _]| match (level.resolution, level.stages) {
        (0, 1) => 0.0,
        (0, _) if x == 35 => 2.0,
        (1, _) if x == 3 => 3.0,
        _ => 0.0,
    });
    let shown = |resolution, stages| {
        let macrocells = fake.ranges(Level { resolution, stages }).classify(&above_one());
        (macrocells.grid().to_array(), shown(&macrocells).iter().map(|p| p[0]).max())
    };
    assert_eq!(shown(0, 1), ([5, 3, 2], None));
    assert_eq!(shown(0, Level::ALL_STAGES), ([5, 3, 2], Some(4)));
    assert_eq!(shown(1, Level::ALL_STAGES), ([3, 2, 1], Some(0)));
    assert_eq!(shown(2, 1), ([2, 1, 1], None));
}

#[test]
fn ranges_hold_what_a_shader_may_make_of_them() {
    let slack = |fake: &Fake| {
        let range = fake.ranges(Level::FULL).range([0; 3]).unwrap();
        assert!(range.min < 1.0 && range.max > 1.0);
        f64::from(range.max) - 1.0
    };
    let ulp = f64::from(f32::EPSILON);
    let plain = Fake::new([8, 8, 8], |_, _| 1.0);
    assert!((slack(&plain) - 16.0 * ulp).abs() < ulp);
    // The shader's tolerance depends on the codec's range, which may be far wider than the macrocell's own.
    let known = Some(ValueRange { min: 0.0, max: 1024.0 });
    let loose = Fake { known, agreement: Some(Agreement::Ulp(4)), ..Fake::new([8, 8, 8], |_, _| 1.0) };
    assert!(slack(&loose) >= 4.0 * 1024.0 * ulp);
    let exact = Fake { known, agreement: Some(Agreement::Exact), ..Fake::new([8, 8, 8], |_, _| 1.0) };
    assert!((slack(&exact) - 16.0 * ulp).abs() < ulp);
    // Values stored as fractions of −32768..32767 cancel when the offset is added.
    let form = DecodedForm { format: TexelFormat::Unorm16, scale: 65535.0, offset: -32768.0 };
    assert!(slack(&Fake { form, ..Fake::new([8, 8, 8], |_, _| 1.0) }) >= 32768.0 * ulp);
    // A zero is not rounded: air stays air.
    let form = DecodedForm { format: TexelFormat::Unorm8, scale: 255.0, offset: 0.0 };
    let air = Fake { form, agreement: Some(Agreement::Ulp(4)), ..Fake::new([8, 8, 8], |_, _| 0.0) };
    assert_eq!(air.ranges(Level::FULL).range([0; 3]), Some(ValueRange { min: 0.0, max: 0.0 }));
}

#[test]
fn ranges_hold_what_a_texture_unit_may_make_of_blocks() {
    let range = |value, blocks| {
        let fake = Fake { blocks, ..Fake::new([8, 8, 8], value) };
        fake.ranges(Level::FULL).range([0; 3]).unwrap()
    };
    // Two of 255 codes, and 0.0265 of a block's span: of the whole range, or of the range that the codec knows.
    let inside = range(|_, _| 100.0, Some((510.0, -10.0)));
    assert!((82.485 - inside.min).abs() < 0.01 && (inside.max - 117.515).abs() < 0.01, "{inside:?}");
    let known = Some(ValueRange { min: 50.0, max: 150.0 });
    let fake = Fake { blocks: Some((510.0, -10.0)), known, ..Fake::new([8, 8, 8], |_, _| 100.0) };
    let inside = fake.ranges(Level::FULL).range([0; 3]).unwrap();
    assert!((93.35 - inside.min).abs() < 0.01 && (inside.max - 106.65).abs() < 0.01, "{inside:?}");
    // Texels never leave 0..1, and a block of zeros contains only zeros.
    let border = range(|_, p| if p[0] == 0 { -9.0 } else { 499.0 }, Some((510.0, -10.0)));
    assert!((border.min + 10.0).abs() < 0.01 && (border.max - 500.0).abs() < 0.01, "{border:?}");
    let air = range(|_, _| 0.0, Some((510.0, 0.0)));
    assert_eq!((air.min, air.max), (0.0, 0.0));
}

#[test]
fn decoding_stops_and_fails_when_it_should() {
    let fake = Fake::new([64, 64, 8], |_, _| 0.0);
    let stop = AtomicBool::new(true);
    let stopped = MacrocellRanges::decode(&fake, FrameIndex::FIRST, Level::FULL, &stop).unwrap();
    assert_eq!(stopped, None);

    #[derive(Debug)]
    struct Broken(VolumeLayout);
    impl Decoder for Broken {
        fn layout(&self) -> &VolumeLayout {
            &self.0
        }
        fn decode_brick(
            &self,
            _: BrickKey,
            _: &dyn ReferenceFrames,
            _: &mut [f32],
        ) -> Result<(), DecodeError> {
            Err(DecodeError::Corrupt("broken".to_owned()))
        }
    }
    let broken = Broken(fake.layout.clone());
    let problem = MacrocellRanges::decode(&broken, FrameIndex::FIRST, Level::FULL, &AtomicBool::new(false))
        .unwrap_err();
    assert!(problem.to_string().contains("broken"));
}
