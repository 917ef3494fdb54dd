//! What cells of one volume, scene and renderer share: the reference picture, the baseline of all timing, and
//! raw's pictures under each site and filter.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use cvr_core::codec::Site;
use cvr_core::pipeline::Scene;
use cvr_core::render::{Filter, Image, Renderer, View};
use cvr_core::volume::{FiniteVolume, ValueRange};

use super::deferred::DeferredVolume;
use super::encoded::Encoded;
use super::target::{Decoded, DrawError, HostVolume, Picture, Target, VoxelSource};

/// Id of the codec that holds the uncompressed volume.
pub const RAW: &str = "raw";

/// Renderers subtract values of a volume from each other, in single precision.
///
/// # Errors
/// A sentence, when such a difference overflows: a picture would silently lack what lies there.
pub fn check_range(range: ValueRange) -> Result<(), String> {
    if range.span() <= f64::from(f32::MAX) {
        return Ok(());
    }
    let ValueRange { min, max } = range;
    Err(format!(
        "values from {min:e} to {max:e} cannot be filtered: their differences exceed single precision; scale the volume"
    ))
}

/// The uncompressed volume on the target.
#[derive(Debug)]
pub struct RawVolume {
    encoded: Encoded,
    host: HostVolume,
    deferred: OnceLock<DeferredVolume>,
}

impl RawVolume {
    /// Uploads what the codec `raw` gave back.
    ///
    /// # Errors
    /// When the target cannot hold it.
    pub fn new(target: &Target, encoded: Encoded) -> Result<Self, DrawError> {
        let host = target.upload(encoded.decoder.as_ref(), encoded.frame.clone())?;
        Ok(Self { encoded, host, deferred: OnceLock::new() })
    }

    /// Its voxels at a site. The device decodes them when they are first asked for at the site *deferred*.
    ///
    /// # Errors
    /// When the device cannot decode them.
    pub fn at(&self, target: &Target, site: Site) -> Result<VoxelSource<'_>, DrawError> {
        let decoder = self.encoded.decoder.as_ref();
        let decoded = match site {
            Site::Host => Decoded::Host(self.host.clone()),
            Site::Deferred => Decoded::Deferred(match self.deferred.get() {
                Some(volume) => volume.clone(),
                None => {
                    let volume = target.decode(RAW, decoder, self.encoded.level, &self.encoded.frame)?;
                    self.deferred.get_or_init(|| volume).clone()
                }
            }),
            _ => Decoded::Inline,
        };
        Ok(VoxelSource { codec: RAW, decoder, level: self.encoded.level, decoded })
    }
}

/// One volume in one scene under one renderer.
pub struct Stage<'a> {
    target: &'a Target,
    renderer: &'a dyn Renderer,
    scene: &'a Scene,
    range: ValueRange,
    raw: &'a RawVolume,
    /// Uncompressed, manual trilinear filter, same step: what every picture is compared with.
    pub reference: Image,
    /// Raw texture with hardware linear filtering: what every frame time is divided by.
    pub baseline: Picture<'a>,
    raw_images: BTreeMap<(Site, Filter), Image>,
}

impl<'a> Stage<'a> {
    /// Draws the reference and prepares the baseline.
    ///
    /// # Errors
    /// When the target refuses.
    pub fn new(
        target: &'a Target,
        renderer: &'a dyn Renderer,
        scene: &'a Scene,
        volume: &FiniteVolume,
        raw: &'a RawVolume,
    ) -> Result<Self, String> {
        let range = volume.range();
        check_range(range)?;
        let linear = scene.view(range, Filter::Linear).map_err(|e| e.to_string())?;
        let picture = |site| {
            let voxels = raw.at(target, site).map_err(|e| e.to_string())?;
            target.picture(renderer, &linear, &voxels).map_err(|e| e.to_string())
        };
        let reference = picture(Site::Inline)?.image().map_err(|e| e.to_string())?;
        let baseline = picture(Site::Host)?;
        let raw_images = BTreeMap::from([((Site::Inline, Filter::Linear), reference.clone())]);
        Ok(Self { target, renderer, scene, range, raw, reference, baseline, raw_images })
    }

    /// What draws.
    #[must_use]
    pub const fn target(&self) -> &'a Target {
        self.target
    }

    /// The view under a filter; nothing is skipped in it.
    ///
    /// # Errors
    /// When the scene's transfer function has no meaning over the volume's range.
    pub fn view(&self, filter: Filter) -> Result<View, String> {
        self.scene.view(self.range, filter).map_err(|e| e.to_string())
    }

    /// Prepares a picture of a view of the stage.
    ///
    /// # Errors
    /// When the target refuses.
    pub fn picture<'b>(&self, view: &View, voxels: &VoxelSource<'b>) -> Result<Picture<'b>, String>
    where
        'a: 'b,
    {
        self.target.picture(self.renderer, view, voxels).map_err(|e| e.to_string())
    }

    /// Raw's picture under a site and filter, drawn once. Optimised linear is linear in another way, which raw
    /// does not offer.
    ///
    /// # Errors
    /// When the target refuses.
    pub fn raw_image(&mut self, site: Site, filter: Filter) -> Result<&Image, String> {
        let filter = if filter == Filter::OptimisedLinear { Filter::Linear } else { filter };
        if !self.raw_images.contains_key(&(site, filter)) {
            let voxels = self.raw.at(self.target, site).map_err(|e| e.to_string())?;
            let picture = self.picture(&self.view(filter)?, &voxels)?;
            let image = picture.image().map_err(|e| e.to_string())?;
            self.raw_images.insert((site, filter), image);
        }
        self.raw_images.get(&(site, filter)).ok_or_else(|| "raw's picture is missing".to_owned())
    }

    /// Colour behind the volume.
    #[must_use]
    pub const fn background(&self) -> [f32; 3] {
        self.scene.background
    }
}
