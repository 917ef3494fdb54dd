//! A value that is made for one frame at a time.

use std::cell::RefCell;

use cvr_core::volume::FrameIndex;

/// The value of the frame used last. The value of the frame before is dropped. A scene of one frame makes it once, a
/// scene of a range once per frame, and memory never holds two.
#[derive(Debug)]
pub struct Latest<T>(RefCell<Option<(FrameIndex, T)>>);

impl<T> Default for Latest<T> {
    fn default() -> Self {
        Self(RefCell::new(None))
    }
}

impl<T: Clone> Latest<T> {
    /// Starts with the value of `frame`.
    pub fn new(frame: FrameIndex, thing: T) -> Self {
        Self(RefCell::new(Some((frame, thing))))
    }

    /// The value of `frame`. `make` makes it if it is missing.
    ///
    /// # Errors
    /// That of `make`; what was kept is dropped before.
    pub fn get<E>(&self, frame: FrameIndex, make: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let kept = self.0.borrow().as_ref().filter(|(of, _)| *of == frame).map(|(_, thing)| thing.clone());
        if let Some(thing) = kept {
            return Ok(thing);
        }
        self.0.replace(None);
        let thing = make()?;
        self.0.replace(Some((frame, thing.clone())));
        Ok(thing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_another_frame_is_made_anew() {
        let latest = Latest::default();
        let made = RefCell::new(Vec::new());
        let get = |frame| {
            latest.get(FrameIndex(frame), || {
                made.borrow_mut().push(frame);
                if frame == 9 { Err("none") } else { Ok(10 * frame) }
            })
        };
        assert_eq!([get(2), get(2), get(3), get(2)], [Ok(20), Ok(20), Ok(30), Ok(20)]);
        assert_eq!((get(9), get(9)), (Err("none"), Err("none")), "a failure is not kept");
        assert_eq!(*made.borrow(), [2, 3, 2, 9, 9]);
    }
}
