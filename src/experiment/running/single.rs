//! One picture of `cvr render`, drawn as a cell of a run. Its voxels are compared with the CPU decoder.

use cvr_core::codec::Site;
use cvr_core::render::{Filter, Image, Renderer, View};

use crate::experiment::records::record::Record;
use crate::site;
use crate::site::expected::{Checked, Expected};
use crate::site::picture::VoxelSource;
use crate::site::target::{DrawError, Target};

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum SingleError {
    /// The device decodes other values than the CPU, in words.
    #[error("{0}")]
    Disagrees(String),
    /// The device's values cannot be compared.
    #[error("{0}")]
    Uncompared(String),
    /// The target refuses.
    #[error(transparent)]
    Draw(#[from] DrawError),
}

/// One picture of one frame at a site.
pub struct Single<'a> {
    /// What draws.
    pub target: &'a Target,
    /// The renderer.
    pub renderer: &'a dyn Renderer,
    /// The scene, over the range of the volume.
    pub view: &'a View,
    /// Where voxels are decoded.
    pub site: Site,
    /// The frame as the CPU decodes it.
    pub expected: &'a Expected<'a>,
    /// Whether the device's values are compared with the CPU decoder's.
    pub check: bool,
}

impl Single<'_> {
    /// Draws. Enters a run's remarks into the record.
    ///
    /// # Errors
    /// When the device decodes other values than the CPU, or the target refuses.
    pub fn draw(&self, record: &mut Record) -> Result<Image, SingleError> {
        let Self { target, renderer, view, site, expected, .. } = *self;
        let coded = expected.coded();
        record.flag_mirror(target, site::of(site), coded);
        let voxels = VoxelSource::prepare(target, site, coded, &|| Ok(expected.frame.clone()))?;
        record.enter_preparation(&voxels.held.preparation());
        let as_cells = view.filter == Filter::OptimisedLinear;
        self.compare(record, || voxels.held.check(target, expected, as_cells))?;
        let picture = target.picture(renderer, view, &voxels)?;
        record.flag_fallbacks(picture.fallback(), None);
        record.flag_blending(picture.blends_in_half(), false);
        self.compare(record, || picture.check(expected))?;
        let image = picture.image()?;
        record.flag_ray_pieces(picture.ray_pieces(), None);
        Ok(image)
    }

    fn compare(
        &self,
        record: &mut Record,
        check: impl FnOnce() -> Result<Option<Checked>, String>,
    ) -> Result<(), SingleError> {
        if !self.check {
            return Ok(());
        }
        let checked = check().map_err(SingleError::Uncompared)?;
        checked.map_or(Ok(()), |checked| record.enter_checked(&checked)).map_err(SingleError::Disagrees)
    }
}
