//! A decoder with a snippet, predicted frames and two resolutions, at the sites *inline* and *ring*.

use std::borrow::Cow;
use std::sync::Arc;

use cvr::site::coded::CodedFrame;
use cvr::site::picture::VoxelSource;
use cvr::site::target::Target;
use cvr_core::codec::*;
use cvr_core::metrics::AgreementRule;
use cvr_core::render::{
    Camera, ControlPoint, Filter, Image, MacrocellRanges, Projection, Renderer, TransferFunction, View,
};
use cvr_core::volume::*;
use cvr_engine::testing::test_device;
use cvr_raycasting::Raycasting;
use cvr_slicing::{Geometry, Slicing};

use super::scenes::{rule, sums_single, view};
use super::subjects::ODD;

const SNIPPET: &str = "\
fn drift_fetch(p: vec3<i32>) -> vec4<f32> {
    let step = drift_resolution();
    let extent = (drift_extent + (1u << step) - 1u) >> vec3<u32>(step);
    let v = vec3<u32>(p);
    let i = (v.z * extent.y + v.y) * extent.x + v.x;
    var value = bitcast<f32>(drift_own(i + select(0u, drift_first_low, step == 1u)));
    if drift_frame() > 0u {
        value += bitcast<f32>(drift_reference(i));
    }
    return vec4<f32>(value, 0.0, 0.0, 0.0);
}
";

/// Drifting waves. For each frame it holds the difference from the frame before, at both resolutions, one after the
/// other.
#[derive(Debug)]
struct Drift {
    layout: VolumeLayout,
    own: Vec<Vec<u32>>,
    snippet: Cow<'static, str>,
}

impl Drift {
    fn new(size: [u32; 3]) -> Self {
        let extent = Extent::try_from(size).unwrap();
        let layout = VolumeLayout {
            frames: 3,
            spacing: [1.0, 1.5, 0.7],
            ..VolumeLayout::scalar(extent, SampleType::U8)
        };
        let own = (0..3)
            .map(|frame| {
                let at = |resolution: u8| {
                    let (of, scale) = (extent.at_resolution(resolution), Level::scale(resolution));
                    (0..of.voxels() as usize).map(move |i| {
                        let [x, y, z] = of.position(i).map(|p| (f64::from(p) + 0.5) * scale);
                        let wave =
                            (0.5 * x + 0.2 * z).sin() * (0.4 * y - 0.1 * x).cos() * (0.3 * z + 0.4).sin();
                        // The upper part is dark, so that something may be skipped.
                        let wave = if z > 12.5 { -1.0 } else { wave };
                        let value = if frame == 0 { 128.0 + 100.0 * wave } else { 8.0 * (0.3 * x).sin() };
                        // Whole numbers: sums of them are exact.
                        (value.round() as f32).to_bits()
                    })
                };
                at(0).chain(at(1)).collect()
            })
            .collect();
        Self { layout, own, snippet: Cow::Borrowed(SNIPPET) }
    }

    fn first(&self, resolution: u8) -> usize {
        if resolution == 0 { 0 } else { self.layout.extent.voxels() as usize }
    }
}

impl Decoder for Drift {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn dependencies(&self, frame: FrameIndex) -> Dependencies {
        frame
            .0
            .checked_sub(1)
            .map_or(Dependencies::Intra, |before| Dependencies::Predicted(FrameIndex(before)))
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        check_key_at(&self.layout, 2, key)?;
        let BrickKey { frame, level, region } = key;
        let extent = self.layout.extent.at_resolution(level.resolution);
        let own = &self.own[frame.0 as usize][self.first(level.resolution)..];
        let reference = frame.0.checked_sub(1).map(|before| references.frame(FrameIndex(before)).unwrap());
        let row = region.extent.x() as usize;
        for (start, out) in region.rows().zip(out.chunks_exact_mut(row)) {
            for (i, out) in (extent.index(start)..).zip(out) {
                *out = f32::from_bits(own[i]) + reference.map_or(0.0, |reference| reference[i]);
            }
        }
        Ok(())
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        Some(self)
    }
}

impl ShaderDecode for Drift {
    fn module(&self) -> WgslModule<'_> {
        let constants = vec![
            Constant { name: "extent", value: ConstantValue::Vec3U32(self.layout.extent.to_array()) },
            Constant { name: "first_low", value: ConstantValue::U32(self.first(1) as u32) },
        ];
        WgslModule { file: "tests/device/drift.rs", source: &self.snippet, constants }
    }

    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        let own = self.own.get(frame.0 as usize);
        let own = own.ok_or_else(|| DecodeError::NoSuchBrick(format!("frame {}", frame.0)))?;
        Ok(vec![Resource { name: "own", words: Cow::Borrowed(own) }])
    }
}

fn store(drift: Drift) -> Arc<dyn Decoder> {
    FrameStore::open(Arc::new(drift), u64::MAX)
}

const LEVELS: [Level; 2] = [Level::FULL, Level { resolution: 1, ..Level::FULL }];

#[test]
fn a_snippet_reads_what_its_frame_is_predicted_from() {
    let Some(device) = test_device("drift::parity") else { return };
    let parities = |drift: Drift| {
        let decoder = store(drift);
        let mut all = Vec::new();
        for level in LEVELS {
            for frame in (0..3).map(FrameIndex) {
                let cpu = DecodedFrame::at(decoder.as_ref(), frame, level).unwrap();
                let key = (frame, level);
                let dumped = device.dump_at("drift", decoder.as_ref(), key, false).unwrap();
                let decoded = device.dump_frame("drift", decoder.as_ref(), key).unwrap();
                let compare = |found: &[f32]| {
                    Parity::compare_at(decoder.as_ref(), Agreement::Exact, key, cpu.values(), found).holds()
                };
                all.push((frame.0, compare(&dumped), compare(&decoded)));
            }
        }
        all
    };
    for found in parities(Drift::new(ODD)) {
        assert!(found.1 && found.2, "{found:?}");
    }
    // The failing twin: another voxel of the reference.
    let wrong = SNIPPET.replace("drift_reference(i)", "drift_reference(i ^ 1u)");
    for (frame, inline, deferred) in parities(Drift { snippet: wrong.into(), ..Drift::new(ODD) }) {
        assert_eq!([inline, deferred], [frame == 0; 2], "frame {frame}");
    }
}

/// Shows only bright values.
fn band() -> Arc<TransferFunction> {
    let point = |value, alpha| ControlPoint { value, rgba: [0.9, 0.6, 0.3, alpha] };
    Arc::new(TransferFunction::new(vec![point(0.0, 0.0), point(150.0, 0.0), point(255.0, 0.6)]).unwrap())
}

const SLICING: Slicing = Slicing {
    geometry: Geometry::Axis,
    opacity_correction: cvr_slicing::OpacityCorrection::Exact,
    blending: cvr_core::render::Blending::Float32,
};

/// Pictures of the last frame at the sites *inline* and *ring*, with and without skipping, compared with the mirror's,
/// which decodes at every fetch.
#[test]
fn inline_and_ring_draw_a_resolution_at_the_volumes_size() {
    let Some(device) = test_device("drift::pictures") else { return };
    let single = sums_single(device, "drift::pictures");
    let (target, mirror) = (Target::Device(device.clone()), Target::Cpu { reason: None });
    let decoder = store(Drift::new(ODD));
    let decoder = decoder.as_ref();
    let frame = FrameIndex(2);
    let draw = |target: &Target,
                renderer: &dyn Renderer,
                view: &View,
                level: Level,
                ring: bool|
     -> (Image, AgreementRule) {
        let coded = CodedFrame { codec: "drift", decoder, key: (frame, level) };
        let decoded = || DecodedFrame::at(decoder, frame, level).map_err(|e| e.to_string());
        let site = if ring { Site::Ring } else { Site::Inline };
        let source = VoxelSource::prepare(target, site, coded, &decoded).unwrap();
        let picture = target.picture(renderer, view, &source).unwrap();
        let manual = if picture.filtering() == "hardware" {
            AgreementRule::HARDWARE
        } else {
            rule(cvr_core::shader::TextureSampling::Manual)
        };
        (picture.image().unwrap(), manual)
    };
    for level in LEVELS {
        let stop = std::sync::atomic::AtomicBool::new(false);
        let ranges = MacrocellRanges::decode(decoder, frame, level, &stop).unwrap().unwrap();
        for (azimuth, filter) in [(0.0, Filter::Nearest), (30.0, Filter::Linear), (100.0, Filter::Linear)] {
            let camera =
                Camera { azimuth, elevation: 15.0, projection: Projection::Perspective, ..Camera::default() };
            let plain = View { camera, transfer_function: band(), ..view(SampleType::U8, [40, 40], filter) };
            let macrocells = Arc::new(ranges.classify(&plain.transfer_function));
            assert!(macrocells.empty_share() > 0.0, "{level:?}");
            let skipping = View { macrocells: Some(macrocells), ..plain.clone() };
            for (renderer, rings) in [(&Raycasting as &dyn Renderer, false), (&SLICING, true)] {
                if rings && !single {
                    continue;
                }
                let (expected, _) = draw(&mirror, renderer, &plain, level, false);
                for ring in if rings { &[false, true][..] } else { &[false] } {
                    let name = format!("{level:?} {azimuth} {filter}, ring {ring}");
                    let (found, rule) = draw(&target, renderer, &plain, level, *ring);
                    let agreed = rule.check(&expected, &found).unwrap_or_else(|e| panic!("{name}: {e}"));
                    assert!(agreed.visible_pixels > 100, "{name}");
                    assert!(
                        draw(&target, renderer, &skipping, level, *ring).0 == found,
                        "{name}: skipping changes it"
                    );
                }
            }
        }
    }
}
