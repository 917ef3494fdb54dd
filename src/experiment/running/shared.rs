//! Data that cells of one codec, its settings and a level share besides the stream: decoded and compared frames.

use cvr_core::codec::Site;
use cvr_core::memory;
use cvr_core::pipeline::{Cell, FrameRange};
use cvr_core::render::Filter;
use cvr_core::volume::FrameIndex;

use super::encoded::Encoded;
use crate::experiment::measured::surfaces::SurfaceDistances;
use crate::experiment::records::record::Record;
use crate::site;
use crate::site::expected::Expected;
use crate::site::kept::{KeptFrame, KeptFrames};
use crate::site::picture::VoxelSource;
use crate::site::target::Target;

/// Data for the cells of one codec, its settings and a level, while one of them runs.
pub struct Shared<'a> {
    codec: &'a str,
    encoded: &'a Encoded,
    target: &'a Target,
    /// Whether a cell reads voxels through `fetch_cell`.
    as_cells: bool,
    kept: KeptFrames,
    surfaces: SurfaceDistances,
}

impl<'a> Shared<'a> {
    /// Empty. All cells have one codec, its settings and a level.
    pub fn new<'c>(
        target: &'a Target,
        codec: &'a str,
        encoded: &'a Encoded,
        mut cells: impl Iterator<Item = &'c Cell>,
    ) -> Self {
        let as_cells = cells.any(|cell| cell.filter == Filter::OptimisedLinear);
        let (kept, surfaces) = (KeptFrames::default(), SurfaceDistances::default());
        Self { codec, encoded, target, as_cells, kept, surfaces }
    }

    /// The stream.
    #[must_use]
    pub const fn encoded(&self) -> &'a Encoded {
        self.encoded
    }

    /// Distances of the isosurfaces from the original's.
    #[must_use]
    pub const fn surfaces(&self) -> &SurfaceDistances {
        &self.surfaces
    }

    /// The CPU's frame, with which sites are compared.
    ///
    /// # Errors
    /// A sentence, when it cannot be decoded.
    pub fn expected(&self, frame: FrameIndex) -> Result<Expected<'a>, String> {
        self.encoded.expected(self.codec, frame)
    }

    /// A frame held by a site. Enters into the record the device's decoding time, and the number of samples on which
    /// shader and CPU disagree, or that no shader ran.
    ///
    /// # Errors
    /// A sentence, when a frame cannot be decoded or held, or the device decodes other texels than the CPU.
    pub fn prepared(
        &self,
        site: Site,
        frame: FrameIndex,
        record: &mut Record,
    ) -> Result<VoxelSource<'a>, String> {
        let (holding, target) = (site::of(site), self.target);
        let coded = self.encoded.coded(self.codec, frame);
        record.flag_mirror(target, holding, coded);
        let KeptFrame { held, checked } = self.kept.get(site, frame, || {
            let expected = self.expected(frame)?;
            if let (Target::Device(_), true) = (target, site.decoded_by().on_device()) {
                // The device's values are read back for the comparison.
                let layout = coded.layout();
                let bytes = layout.samples_per_frame() * size_of::<f32>() as u64;
                let what = || format!("a frame of {} voxels as the device decodes it", layout.extent);
                memory::check(bytes, what).map_err(|e| e.to_string())?;
            }
            let held = holding.prepare(target, coded, &|| Ok(expected.frame.clone()), true);
            let held = held.map_err(|e| e.to_string())?;
            let checked = held.check(target, &expected, self.as_cells)?;
            Ok::<_, String>(KeptFrame { held, checked })
        })?;
        record.enter_preparation(&held.preparation());
        if let Some(checked) = &checked {
            let agrees = record.enter_checked(checked);
            if !holding.draws_mismatches() {
                agrees?;
            }
        }
        Ok(VoxelSource { site, coded, held })
    }

    /// The problem with the device's values at a site, in the first of these frames that has one, for sites that draw
    /// nevertheless.
    #[must_use]
    pub fn problem(&self, site: Site, frames: FrameRange) -> Option<String> {
        frames.iter().find_map(|frame| self.kept.checked(site, frame)?.problem)
    }
}
