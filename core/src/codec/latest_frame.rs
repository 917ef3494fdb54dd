//! The frame that a decoder of whole frames decoded last.

use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use rayon::ThreadPoolBuilder;

use super::{DecodeError, DecodedFrame};
use crate::volume::{FrameIndex, Level};

/// Keeps one decoded frame for a decoder that rebuilds whole frames, so that all boxes of a frame share one decode. Who
/// asks for a frame that is being decoded waits for it.
#[derive(Debug, Default)]
pub struct LatestFrame(Mutex<Option<Kept>>);

/// A decoded frame, with its number and level.
#[derive(Debug)]
struct Kept {
    key: (FrameIndex, Level),
    frame: Arc<DecodedFrame>,
}

impl LatestFrame {
    /// The frame of this number and level. Decodes it if another one is kept, which is dropped first.
    ///
    /// # Errors
    /// Those of `decode`; if the system starts no threads.
    pub fn get(
        &self,
        key: (FrameIndex, Level),
        decode: impl FnOnce() -> Result<DecodedFrame, DecodeError> + Send,
    ) -> Result<Arc<DecodedFrame>, DecodeError> {
        let mut latest = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kept) = latest.as_ref().filter(|kept| kept.key == key) {
            return Ok(kept.frame.clone());
        }
        // Two frames at a time are one too many.
        *latest = None;
        let frame = Arc::new(apart(decode)??);
        *latest = Some(Kept { key, frame: frame.clone() });
        Ok(frame)
    }
}

/// Runs work on threads of its own, as many as there are here. A worker that waited for parts of the work would take
/// other tasks meanwhile. One of them may ask for the same frame, and wait for a lock that its own thread holds.
fn apart<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, DecodeError> {
    let pool = ThreadPoolBuilder::new().num_threads(rayon::current_num_threads()).build();
    let pool = pool.map_err(|e| DecodeError::Failed(format!("no threads to decode a frame with: {e}")))?;
    // Waiting for a plain thread, a worker takes no other task.
    let done = thread::scope(|scope| scope.spawn(|| pool.install(work)).join());
    Ok(done.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::time::Duration;

    use super::*;
    use crate::volume::{Extent, SampleType, VolumeLayout};

    fn frame(value: f32) -> Result<DecodedFrame, DecodeError> {
        let layout = VolumeLayout::scalar(Extent::ONE, SampleType::F32);
        DecodedFrame::new(layout, vec![value]).ok_or_else(|| DecodeError::Corrupt("one voxel".to_owned()))
    }

    #[test]
    fn a_frame_is_decoded_once_until_another_is_asked_for() {
        let latest = LatestFrame::default();
        let get =
            |n: u32, value| latest.get((FrameIndex(n), Level::FULL), || frame(value)).unwrap().values()[0];
        assert_eq!([get(0, 1.0), get(0, 2.0), get(1, 3.0), get(0, 4.0)], [1.0, 1.0, 3.0, 4.0]);
        let coarse = Level { resolution: 1, ..Level::FULL };
        assert_eq!(latest.get((FrameIndex(0), coarse), || frame(5.0)).unwrap().values(), [5.0]);
    }

    /// A decode that lets its thread take other work does not get to wait for itself.
    #[test]
    fn a_thread_does_not_wait_for_its_own_decode() {
        let (done, waiting) = channel();
        // A thread that waits for itself never ends: it is left behind.
        thread::spawn(move || {
            let (latest, key) = (LatestFrame::default(), (FrameIndex::FIRST, Level::FULL));
            let decode = || {
                // The only worker has the other half of `join` to do.
                rayon::yield_now();
                frame(7.0)
            };
            let get = || latest.get(key, decode).unwrap().values()[0];
            let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            done.send(pool.install(|| rayon::join(get, get))).unwrap();
        });
        assert_eq!(waiting.recv_timeout(Duration::from_secs(60)), Ok((7.0, 7.0)));
    }
}
