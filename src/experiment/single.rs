//! One picture as a cell of a run would draw it, of voxels that are held to the CPU decoder: what `cvr render` draws.

use cvr_core::codec::Site;
use cvr_core::render::{Filter, Image, Renderer, View};

use super::checked::{Checked, Expected};
use super::host::SharedUpload;
use super::record::Record;
use super::ring;
use super::target::{Decoded, DrawError, Target, VoxelSource};

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum SingleError {
    /// The device decodes other values than the CPU, in words.
    #[error("{0}")]
    Disagrees(String),
    /// What the device decodes cannot be compared.
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
    /// Whether what the device decodes is held to the CPU decoder.
    pub check: bool,
}

impl Single<'_> {
    /// Draws; the record learns what a run would note.
    ///
    /// # Errors
    /// When the device decodes other values than the CPU, or the target refuses.
    pub fn draw(&self, record: &mut Record) -> Result<Image, SingleError> {
        let Self { target, renderer, view, site, expected, check } = *self;
        let Expected { codec, decoder, key: (frame, level), .. } = *expected;
        expected.flag_not_run(target, site, record);
        let decoded = match site {
            Site::Host => {
                let volume = target.upload(decoder, expected.key, expected.frame.clone())?;
                let upload =
                    SharedUpload::of(target, expected, volume, check).map_err(SingleError::Uncompared)?;
                Decoded::Host(upload.enter(record).map_err(SingleError::Disagrees)?)
            }
            Site::Ring => {
                ring::flag_mirror(target, record);
                Decoded::Ring(expected.frame.clone())
            }
            Site::Deferred => {
                let volume = target.decode(codec, decoder, expected.key, &expected.frame)?;
                self.compare(record, || expected.deferred(target, &volume))?;
                Decoded::Deferred(volume)
            }
            _ => {
                let as_cells = view.filter == Filter::OptimisedLinear;
                self.compare(record, || expected.inline(target, as_cells))?;
                Decoded::Inline
            }
        };
        let source = VoxelSource { codec, decoder, frame, level, decoded };
        let picture = target.picture(renderer, view, &source)?;
        record.flag_fallbacks(picture.fallback(), None);
        record.flag_blending(picture.blends_in_half(), false);
        if site == Site::Ring {
            self.compare(record, || expected.ring(&picture))?;
        }
        let image = picture.image()?;
        record.flag_ray_pieces(picture.ray_pieces(), None);
        Ok(image)
    }

    fn compare(
        &self,
        record: &mut Record,
        checked: impl FnOnce() -> Result<Option<Checked>, String>,
    ) -> Result<(), SingleError> {
        if !self.check {
            return Ok(());
        }
        let checked = checked().map_err(SingleError::Uncompared)?;
        checked.map_or(Ok(()), |checked| checked.enter(record)).map_err(SingleError::Disagrees)
    }
}
