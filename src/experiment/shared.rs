//! What cells of one codec, its settings and a level share beside the stream: what is decoded and compared of the frame that is
//! drawn.

use std::cell::RefCell;
use std::collections::BTreeMap;

use cvr_core::codec::Site;
use cvr_core::memory;
use cvr_core::metrics::isosurface::SurfaceDistance;
use cvr_core::pipeline::Cell;
use cvr_core::render::Filter;
use cvr_core::volume::FrameIndex;

use super::deferred::SharedDecode;
use super::encoded::Encoded;
use super::host::SharedUpload;
use super::latest::Latest;
use super::record::Record;
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
    parity: RefCell<BTreeMap<FrameIndex, Option<u64>>>,
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
        let parity = RefCell::default();
        let (host, deferred) = (Latest::default(), Latest::default());
        let surfaces = RefCell::default();
        Self { codec, encoded, target, use_cell, parity, host, deferred, surfaces }
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
        let decoded = self.encoded.frame(frame)?;
        let distance = surfaces::distance(stage, frame, &decoded)?;
        self.surfaces.borrow_mut().insert(key, distance);
        Ok(distance)
    }

    /// A frame as a site wants it. The record learns what the device took to decode it, and on how many samples its
    /// shader and the CPU disagree.
    ///
    /// # Errors
    /// A sentence, when a frame cannot be decoded or held, or the device decodes other texels than the CPU.
    pub fn decoded(&self, site: Site, frame: FrameIndex, record: &mut Record) -> Result<Decoded, String> {
        let decoder = self.encoded.decoder.as_ref();
        if let (Target::Device(_), Site::Inline | Site::Deferred | Site::Ring) = (self.target, site) {
            // What the device decodes is read back, to be compared.
            let layout = decoder.layout();
            let bytes = layout.samples_per_frame() * size_of::<f32>() as u64;
            let what = || format!("a frame of {} voxels as the device decodes it", layout.extent);
            memory::check(bytes, what).map_err(|e| e.to_string())?;
        }
        Ok(match site {
            Site::Host => {
                let upload = self.host.get(frame, || {
                    let key = (frame, self.encoded.level);
                    SharedUpload::new(self.target, decoder, key, self.encoded.frame(frame)?)
                        .map_err(|e| e.to_string())
                })?;
                Decoded::Host(upload.enter(record)?)
            }
            Site::Ring => Decoded::Ring(self.encoded.frame(frame)?),
            Site::Deferred => {
                let decode = self.deferred.get(frame, || {
                    let decoded = self.encoded.frame(frame)?;
                    SharedDecode::new(self.target, self.codec, decoder, (frame, self.encoded.level), &decoded)
                        .map_err(|e| e.to_string())
                })?;
                Decoded::Deferred(decode.enter(record)?)
            }
            _ => {
                let known = self.parity.borrow().get(&frame).copied();
                record.parity_mismatches = match known {
                    Some(mismatches) => mismatches,
                    None => self.encoded.parity(self.codec, self.target, frame, self.use_cell)?,
                };
                self.parity.borrow_mut().insert(frame, record.parity_mismatches);
                Decoded::Inline
            }
        })
    }
}
