//! Frames that several pictures share.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use cvr_core::codec::Site;
use cvr_core::volume::FrameIndex;

use super::expected::Checked;
use super::holding::HeldFrame;

/// A frame held by a site, and the result of comparing it with the CPU decoder, if it was compared.
#[derive(Clone, Debug)]
pub struct KeptFrame {
    /// The frame.
    pub held: Arc<dyn HeldFrame>,
    /// The result of the comparison. `None` if nothing was compared.
    pub checked: Option<Checked>,
}

/// Frames of one stream, held by sites. Each site keeps the frame used last, if it uses memory. A scene of one frame
/// prepares it once, a scene of a range once per frame. Memory never holds two frames of a site.
#[derive(Debug, Default)]
pub struct KeptFrames(RefCell<BTreeMap<(Site, FrameIndex), KeptFrame>>);

impl KeptFrames {
    /// The frame at a site; `make` makes it unless it is there.
    ///
    /// # Errors
    /// That of `make`; what the site has kept of other frames is dropped before.
    pub fn get<E>(
        &self,
        site: Site,
        frame: FrameIndex,
        make: impl FnOnce() -> Result<KeptFrame, E>,
    ) -> Result<KeptFrame, E> {
        let key = (site, frame);
        if let Some(kept) = self.0.borrow().get(&key) {
            return Ok(kept.clone());
        }
        self.0.borrow_mut().retain(|(of, _), kept| *of != site || !kept.held.holds_memory());
        let kept = make()?;
        self.0.borrow_mut().insert(key, kept.clone());
        Ok(kept)
    }

    /// The result of comparing a kept frame.
    #[must_use]
    pub fn checked(&self, site: Site, frame: FrameIndex) -> Option<Checked> {
        self.0.borrow().get(&(site, frame))?.checked.clone()
    }
}

#[cfg(test)]
mod tests {
    use cvr_engine::{DrawSource, EngineError};

    use super::super::coded::CodedFrame;
    use super::*;

    #[derive(Debug)]
    struct Held {
        memory: bool,
    }

    impl HeldFrame for Held {
        fn source<'a>(&self, _: CodedFrame<'a>) -> Result<DrawSource<'a>, EngineError> {
            Err(EngineError::Unsupported(String::new()))
        }

        fn holds_memory(&self) -> bool {
            self.memory
        }
    }

    #[test]
    fn of_frames_that_hold_memory_only_the_last_is_kept() {
        let kept = KeptFrames::default();
        let made = RefCell::new(Vec::new());
        let get = |site: Site, frame, memory| {
            kept.get(site, FrameIndex(frame), || {
                made.borrow_mut().push((site, frame));
                let held: Arc<dyn HeldFrame> = Arc::new(Held { memory });
                if frame == 9 { Err("none") } else { Ok(KeptFrame { held, checked: None }) }
            })
            .map(|_| ())
        };
        for frame in [2, 2, 3, 2] {
            get(Site::Host, frame, true).unwrap();
            get(Site::Inline, frame, false).unwrap();
        }
        let expected =
            [(Site::Host, 2), (Site::Inline, 2), (Site::Host, 3), (Site::Inline, 3), (Site::Host, 2)];
        assert_eq!(*made.borrow(), expected);
        assert_eq!([get(Site::Host, 9, true), get(Site::Host, 9, true)], [Err("none"); 2]);
        assert_eq!(made.borrow().len(), 7, "a failure is not kept");
    }
}
