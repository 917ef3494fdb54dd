use std::sync::atomic::{AtomicU32, Ordering};

use super::*;
use crate::codec::check_key;
use crate::volume::{Extent, SampleType};

/// Every frame is one more than the sum of its references. Counts decoded frames and remembers their order.
#[derive(Debug)]
struct Sums {
    layout: VolumeLayout,
    dependencies: Vec<Dependencies>,
    order: Mutex<Vec<u32>>,
    largest_stages: AtomicU32,
}

impl Decoder for Sums {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn dependencies(&self, frame: FrameIndex) -> Dependencies {
        self.dependencies[frame.0 as usize]
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        check_key(&self.layout, key)?;
        self.order.lock().unwrap().push(key.frame.0);
        self.largest_stages.fetch_max(key.level.stages.into(), Ordering::Relaxed);
        out.fill(1.0);
        for needed in self.dependencies(key.frame).frames().into_iter().flatten() {
            let missing = DecodeError::MissingReference { frame: key.frame.0, missing: needed.0 };
            let reference = references.frame(needed).ok_or(missing)?;
            out.iter_mut().zip(reference).for_each(|(out, r)| *out += r);
        }
        Ok(())
    }
}

const FRAME_BYTES: u64 = 8 * 4;

fn sums(dependencies: &[Dependencies]) -> Arc<Sums> {
    let layout = VolumeLayout {
        frames: dependencies.len() as u32,
        ..VolumeLayout::scalar(Extent::cube(2).unwrap(), SampleType::F32)
    };
    let (order, largest_stages) = (Mutex::default(), AtomicU32::new(0));
    Arc::new(Sums { layout, dependencies: dependencies.to_vec(), order, largest_stages })
}

fn order(sums: &Sums) -> Vec<u32> {
    std::mem::take(&mut sums.order.lock().unwrap())
}

fn value(decoder: &dyn Decoder, frame: u32) -> f32 {
    DecodedFrame::at(decoder, FrameIndex(frame), Level::FULL).unwrap().values()[7]
}

fn predicted(frame: u32) -> Dependencies {
    Dependencies::Predicted(FrameIndex(frame))
}

fn between(first: u32, second: u32) -> Dependencies {
    Dependencies::Bidirectional(FrameIndex(first), FrameIndex(second))
}

/// I B B P, in the order of display.
fn group() -> Arc<Sums> {
    sums(&[Dependencies::Intra, between(0, 3), between(0, 3), predicted(0)])
}

#[test]
fn a_stream_of_frames_that_decode_on_their_own_needs_no_store() {
    let alone: Arc<dyn Decoder> = sums(&[Dependencies::Intra; 3]);
    assert!(Arc::ptr_eq(&FrameStore::open(alone.clone(), 1), &alone));
    assert!(alone.kept_frame(FrameIndex(0), Level::FULL).unwrap().is_none());
}

#[test]
fn frames_are_decoded_in_order_of_what_they_need_and_once() {
    let sums = group();
    let store = FrameStore::open(sums.clone(), u64::MAX);
    assert_eq!(value(store.as_ref(), 1), 1.0 + 1.0 + 2.0);
    assert_eq!(order(&sums), [0, 3, 1]);
    assert_eq!([value(store.as_ref(), 2), value(store.as_ref(), 3)], [4.0, 2.0]);
    assert_eq!(order(&sums), [2], "what is kept is not decoded again");
}

#[test]
fn the_bound_changes_how_often_and_not_what_is_decoded() {
    let expected: Vec<f32> = (0..4).map(|f| value(FrameStore::open(group(), u64::MAX).as_ref(), f)).collect();
    let mut decoded = Vec::new();
    for frames in [0, 1, 2, 4] {
        let sums = group();
        let store = FrameStore::open(sums.clone(), frames * FRAME_BYTES);
        for frame in [0, 1, 2, 3, 1] {
            assert_eq!(value(store.as_ref(), frame), expected[frame as usize]);
        }
        decoded.push(order(&sums).len());
    }
    assert!(decoded.is_sorted_by(|a, b| a >= b) && decoded[0] > decoded[3], "{decoded:?}");
    assert_eq!(decoded[3], 4);
}

#[test]
fn no_more_is_kept_than_the_bound_allows() {
    let store = FrameStore {
        decoder: sums(
            &(0..9).map(|f: u32| f.checked_sub(1).map_or(Dependencies::Intra, predicted)).collect::<Vec<_>>(),
        ),
        bound_bytes: 3 * FRAME_BYTES + 1,
        kept: Mutex::default(),
    };
    for frame in 0..9 {
        value(&store, frame);
        let kept: Vec<u32> = store.lock().iter().map(|kept| kept.key.0.0).collect();
        let expected: Vec<u32> = (frame.saturating_sub(2)..=frame).collect();
        assert_eq!(kept, expected);
    }
}

/// Chains are as long as sequences are.
#[test]
fn a_long_chain_decodes_from_its_first_frame_on() {
    let chain: Vec<_> =
        (0..2000).map(|f: u32| f.checked_sub(1).map_or(Dependencies::Intra, predicted)).collect();
    let store = FrameStore::open(sums(&chain), FRAME_BYTES);
    assert_eq!(value(store.as_ref(), 1999), 2000.0);
}

#[test]
fn references_are_of_the_level_that_is_decoded() {
    let sums = group();
    let store = FrameStore::open(sums.clone(), u64::MAX);
    let level = Level { stages: 2, ..Level::FULL };
    DecodedFrame::at(store.as_ref(), FrameIndex(1), level).unwrap();
    assert_eq!(sums.largest_stages.load(Ordering::Relaxed), 2);
    order(&sums);
    value(store.as_ref(), 1);
    assert_eq!(order(&sums), [0, 3, 1], "another level is another frame");
}

#[test]
fn circles_and_missing_frames_are_faults_of_the_stream() {
    let told = |dependencies: &[Dependencies], frame| {
        let store = FrameStore::open(sums(dependencies), u64::MAX);
        DecodedFrame::at(store.as_ref(), FrameIndex(frame), Level::FULL).unwrap_err().to_string()
    };
    let circle = [predicted(1), predicted(2), between(0, 0)];
    assert_eq!(told(&circle, 0), "corrupt stream: frames are predicted in a circle: 0 from 1 from 2 from 0");
    assert_eq!(told(&circle, 2), "corrupt stream: frames are predicted in a circle: 2 from 0 from 1 from 2");
    assert_eq!(
        told(&[Dependencies::Intra, predicted(1)], 1),
        "corrupt stream: frames are predicted in a circle: 1 from 1"
    );
    assert_eq!(
        told(&[Dependencies::Intra, between(0, 9)], 1),
        "corrupt stream: frame 1 is predicted from frame 9, of 2"
    );
    assert!(told(&[predicted(1), Dependencies::Intra], 7).starts_with("no such brick: frame 7"));
}

/// The failing twin: without the store, a predicted frame does not decode, and the error names the missing frame.
#[test]
fn without_a_store_a_predicted_frame_is_refused() {
    let sums = group();
    let error = DecodedFrame::at(sums.as_ref(), FrameIndex(3), Level::FULL).unwrap_err();
    assert_eq!(error.to_string(), "frame 3 needs the decoded frame 0");
}

#[test]
fn shaders_read_references_in_the_order_of_the_dependencies() {
    let store = FrameStore::open(group(), u64::MAX);
    let of = |frame| {
        let references = store.references(FrameIndex(frame), Level::FULL).unwrap();
        let resources = references.resources().unwrap();
        resources.into_iter().map(|r| (r.name, f32::from_bits(r.words[0]), r.words.len())).collect::<Vec<_>>()
    };
    assert_eq!(of(0), []);
    assert_eq!(of(3), [("reference", 1.0, 8)]);
    assert_eq!(of(1), [("reference", 1.0, 8), ("second_reference", 2.0, 8)]);
}
