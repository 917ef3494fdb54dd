//! The failing twins of the picture tests: an error of one voxel, or of the colours, breaks the same rules.

use std::sync::Arc;

use cvr_codec_tests::mutated::Mutated;
use cvr_core::codec::{Decoder, Site};
use cvr_core::metrics::AgreementRule;
use cvr_core::render::{ClipBox, ControlPoint, Filter, Light, Shading, TransferFunction, View};
use cvr_core::volume::{BrickSource as _, FrameIndex};
use cvr_core::volume::{DenseVolume, FiniteVolume, SampleType, Samples};
use cvr_engine::testing::test_device;

use super::scenes::{clipped, draw, inline, lit, mirror, source, textured, view};
use super::subjects::{ODD, codec, encoded, settings};

const SAMPLE: SampleType = SampleType::U8;

fn original() -> FiniteVolume {
    textured(ODD, [1.0; 3], SAMPLE)
}

fn raw(volume: &FiniteVolume) -> Box<dyn Decoder> {
    encoded(codec("raw").as_ref(), &settings(&[]), volume)
}

/// The volume shifted cyclically by one voxel along an axis.
fn shifted(axis: usize) -> FiniteVolume {
    let volume = original();
    let layout = volume.layout().clone();
    let values = volume.dense().frame_values(FrameIndex::FIRST);
    let moved = (0..values.len()).map(|i| {
        let [x, y, _] = ODD.map(|e| e as usize);
        let mut p = [i % x, i / x % y, i / x / y].map(|c| c as u32);
        p[axis] = (p[axis] + 1) % ODD[axis];
        values[layout.extent.index(p)] as u8
    });
    let samples = Samples::U8(moved.collect());
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// Site, filter, and the rule for its picture.
const CASES: [(Site, Filter, AgreementRule); 3] = [
    (Site::Inline, Filter::Nearest, AgreementRule::MANUAL),
    (Site::Inline, Filter::Linear, AgreementRule::MANUAL),
    (Site::Host, Filter::Linear, AgreementRule::HARDWARE),
];

fn seen(filter: Filter) -> View {
    view(SAMPLE, [65, 49], filter)
}

#[test]
fn a_volume_shifted_by_one_voxel_breaks_every_rule() {
    let Some(device) = test_device("picture_twins::shifted") else { return };
    let whole = raw(&original());
    for (site, filter, rule) in CASES {
        let expected = mirror(&seen(filter), whole.as_ref());
        let picture =
            |decoder: &dyn Decoder| draw(device, &seen(filter), &source(device, site, "raw", decoder)).0;
        rule.check(&expected, &picture(whole.as_ref())).unwrap();
        for axis in 0..3 {
            let twin = raw(&shifted(axis));
            let found = rule.check(&expected, &picture(twin.as_ref()));
            assert!(found.is_err(), "{site} {filter}: a shift along axis {axis} passes: {found:?}");
        }
    }
}

#[test]
fn another_transfer_function_breaks_every_rule() {
    let Some(device) = test_device("picture_twins::transfer_function") else { return };
    let whole = raw(&original());
    for (site, filter, rule) in CASES {
        let right = seen(filter);
        let points = right.transfer_function.points();
        let change = |change: &dyn Fn(&mut ControlPoint)| {
            let mut points = points.to_vec();
            points.iter_mut().for_each(change);
            View { transfer_function: Arc::new(TransferFunction::new(points).unwrap()), ..right.clone() }
        };
        // A twentieth of the range off, a tenth less dense, red and blue exchanged.
        let aside = change(&|p| p.value += 255.0 / 20.0);
        let thinner = change(&|p| p.rgba[3] *= 0.8);
        let swapped = change(&|p| p.rgba.swap(0, 2));
        let source = source(device, site, "raw", whole.as_ref());
        let expected = mirror(&right, whole.as_ref());
        rule.check(&expected, &draw(device, &right, &source).0).unwrap();
        for (what, wrong) in [("aside", aside), ("thinner", thinner), ("swapped", swapped)] {
            let found = rule.check(&expected, &draw(device, &wrong, &source).0);
            assert!(found.is_err(), "{site} {filter}: {what} passes: {found:?}");
        }
    }
}

#[test]
fn another_light_breaks_every_rule() {
    let Some(device) = test_device("picture_twins::light") else { return };
    let whole = raw(&original());
    for (site, filter, rule) in CASES {
        let source = source(device, site, "raw", whole.as_ref());
        for light in [Light::Camera, Light::Fixed] {
            let right = lit(seen(filter), light);
            let expected = mirror(&right, whole.as_ref());
            rule.check(&expected, &draw(device, &right, &source).0).unwrap();
            let change = |change: &dyn Fn(&mut Shading)| {
                let mut shading = right.shading.unwrap();
                change(&mut shading);
                View { shading: Some(shading), ..right.clone() }
            };
            let other = if light == Light::Camera { Light::Fixed } else { Light::Camera };
            for (what, wrong) in [
                ("unlit", seen(filter)),
                ("mirrored in x", change(&|s| s.direction[0] = -s.direction[0])),
                ("mirrored in y", change(&|s| s.direction[1] = -s.direction[1])),
                ("mirrored in z", change(&|s| s.direction[2] = -s.direction[2])),
                ("following the other", change(&|s| s.light = other)),
                ("a larger highlight", change(&|s| s.shininess = 8.0)),
                ("less of it", change(&|s| s.diffuse *= 0.8)),
            ] {
                let found = rule.check(&expected, &draw(device, &wrong, &source).0);
                assert!(found.is_err(), "{site} {filter}: {light:?}, {what}: passes: {found:?}");
            }
        }
    }
}

#[test]
fn a_clip_box_off_by_one_voxel_breaks_every_rule() {
    let Some(device) = test_device("picture_twins::clip_box") else { return };
    let whole = raw(&original());
    for (site, filter, rule) in CASES {
        let source = source(device, site, "raw", whole.as_ref());
        let right = clipped(seen(filter));
        let expected = mirror(&right, whole.as_ref());
        rule.check(&expected, &draw(device, &right, &source).0).unwrap();
        let change = |change: &dyn Fn(&mut ClipBox)| {
            let mut clip = right.clip.unwrap();
            change(&mut clip);
            View { clip: Some(clip), ..right.clone() }
        };
        let mut wrong = vec![("whole".to_owned(), seen(filter))];
        for (axis, extent) in ODD.into_iter().enumerate() {
            let voxel = 1.0 / extent as f32;
            let low = change(&|clip| clip.low[axis] += voxel);
            let high = change(&|clip| clip.high[axis] -= voxel);
            wrong.extend([(format!("low {axis}"), low), (format!("high {axis}"), high)]);
        }
        for (what, wrong) in wrong {
            let found = rule.check(&expected, &draw(device, &wrong, &source).0);
            assert!(found.is_err(), "{site} {filter}: {what} passes: {found:?}");
        }
    }
}

#[test]
fn a_snippet_off_by_one_voxel_breaks_the_rule() {
    let Some(device) = test_device("picture_twins::snippet") else { return };
    let view = seen(Filter::Linear);
    let mutated =
        Mutated::snippet(raw(&original()), "vec3<u32>(p)", "min(vec3<u32>(p) + 1u, raw_extent - 1u)");
    let expected = mirror(&view, &mutated);
    let found = AgreementRule::MANUAL.check(&expected, &draw(device, &view, &inline("raw", &mutated)).0);
    assert!(found.is_err(), "{found:?}");
}
