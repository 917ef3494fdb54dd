//! What cells of one codec, its settings and a level share beside the stream: what is decoded and compared of the frame that is
//! drawn.

use std::cell::RefCell;
use std::collections::BTreeMap;

use cvr_core::codec::Site;
use cvr_core::memory;
use cvr_core::metrics::isosurface::SurfaceDistance;
use cvr_core::pipeline::{Cell, FrameRange};
use cvr_core::render::Filter;
use cvr_core::volume::FrameIndex;

use super::checked::{Checked, Expected};
use super::deferred::SharedDecode;
use super::encoded::Encoded;
use super::host::SharedUpload;
use super::latest::Latest;
use super::record::Record;
use super::ring;
use super::stage::Stage;
use super::surfaces;
use super::target::{Decoded, Target};

/// Shared by the cells of one codec, its settings and a level, as long as one of them runs.
pub struct Shared<'a> {
    codec: &'a str,
    encoded: &'a Encoded,
    target: &'a Target,
    /// Whether a cell reads voxels through `fetch_cell`.
    use_cell: bool,
    /// What came of comparing the shader's fetches; `None` where no device ran it.
    fetched: RefCell<BTreeMap<FrameIndex, Option<Checked>>>,
    host: Latest<SharedUpload>,
    deferred: Latest<SharedDecode>,
    /// By scene and frame.
    surfaces: RefCell<BTreeMap<(String, FrameIndex), Option<SurfaceDistance>>>,
}

impl<'a> Shared<'a> {
    /// Nothing yet; the cells are all of one codec, its settings and a level.
    pub fn new<'c>(
        target: &'a Target,
        codec: &'a str,
        encoded: &'a Encoded,
        mut cells: impl Iterator<Item = &'c Cell>,
    ) -> Self {
        let use_cell = cells.any(|cell| cell.filter == Filter::OptimisedLinear);
        let fetched = RefCell::default();
        let (host, deferred) = (Latest::default(), Latest::default());
        let surfaces = RefCell::default();
        Self { codec, encoded, target, use_cell, fetched, host, deferred, surfaces }
    }

    /// The stream.
    #[must_use]
    pub const fn encoded(&self) -> &'a Encoded {
        self.encoded
    }

    /// How far the isosurfaces of a frame are from the original's in the scene of a stage; measured once for all its
    /// cells.
    ///
    /// # Errors
    /// As [`surfaces::distance`].
    pub fn surface_distance(
        &self,
        stage: &Stage<'_>,
        frame: FrameIndex,
    ) -> Result<Option<SurfaceDistance>, String> {
        let key = (stage.scene().to_owned(), frame);
        let known = self.surfaces.borrow().get(&key).copied();
        if let Some(known) = known {
            return Ok(known);
        }
        let decoded = self.encoded.frame_of_full_size(frame)?;
        let distance = surfaces::distance(stage, frame, &decoded)?;
        self.surfaces.borrow_mut().insert(key, distance);
        Ok(distance)
    }

    /// A frame of the stream, which sites are held to.
    ///
    /// # Errors
    /// A sentence, when it cannot be decoded.
    pub fn expected(&self, frame: FrameIndex) -> Result<Expected<'a>, String> {
        self.encoded.expected(self.codec, frame)
    }

    /// A frame as a site wants it. The record learns what the device took to decode it, and on how many samples its
    /// shader and the CPU disagree, or that no shader ran.
    ///
    /// # Errors
    /// A sentence, when a frame cannot be decoded or held, or the device decodes other texels than the CPU.
    pub fn decoded(&self, site: Site, frame: FrameIndex, record: &mut Record) -> Result<Decoded, String> {
        let expected = self.expected(frame)?;
        expected.flag_not_run(self.target, site, record);
        if let (Target::Device(_), Site::Inline | Site::Deferred | Site::Ring) = (self.target, site) {
            // What the device decodes is read back, to be compared.
            let layout = expected.frame.layout();
            let bytes = layout.samples_per_frame() * size_of::<f32>() as u64;
            let what = || format!("a frame of {} voxels as the device decodes it", layout.extent);
            memory::check(bytes, what).map_err(|e| e.to_string())?;
        }
        Ok(match site {
            Site::Host => {
                let upload = self.host.get(frame, || SharedUpload::new(self.target, &expected))?;
                Decoded::Host(upload.enter(record)?)
            }
            Site::Ring => {
                ring::flag_mirror(self.target, record);
                Decoded::Ring(expected.frame)
            }
            Site::Deferred => {
                let decode = self.deferred.get(frame, || SharedDecode::new(self.target, &expected))?;
                Decoded::Deferred(decode.enter(record)?)
            }
            _ => {
                let known = self.fetched.borrow().get(&frame).cloned();
                let checked = match known {
                    Some(checked) => checked,
                    None => expected.inline(self.target, self.use_cell)?,
                };
                record.parity_mismatches = checked.as_ref().map(|checked| checked.mismatches);
                self.fetched.borrow_mut().insert(frame, checked);
                Decoded::Inline
            }
        })
    }

    /// What is wrong with what the shader fetches at the site *inline*, in the first of these frames in which it is. Such a
    /// cell is drawn and timed all the same, so that the fault can be looked at.
    #[must_use]
    pub fn inline_problem(&self, frames: FrameRange) -> Option<String> {
        let fetched = self.fetched.borrow();
        frames.iter().find_map(|frame| fetched.get(&frame)?.as_ref()?.problem.clone())
    }
}
