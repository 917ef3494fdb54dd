//! Data that cells of one volume, scene and renderer share: the reference picture, the baseline of all timing, and
//! raw's pictures for each site and filter.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use cvr_core::codec::Site;
use cvr_core::pipeline::{FrameRange, Scene};
use cvr_core::render::{DecodedFrame, Filter, Image, Renderer, View};
use cvr_core::volume::{BrickSource, FiniteVolume, FrameIndex, ValueRange};

use super::encoded::Encoded;
use super::latest::Latest;
use crate::experiment::inputs::blank;
use crate::experiment::measured::reference::{BASELINE, RAW, REFERENCE, check_range, filter_of_raw};
use crate::site::kept::{KeptFrame, KeptFrames};
use crate::site::picture::{Picture, VoxelSource};
use crate::site::target::Target;

/// The uncompressed volume on the target.
#[derive(Debug)]
pub struct RawVolume {
    encoded: Encoded,
    kept: KeptFrames,
}

impl RawVolume {
    /// The decoded volume of the codec `raw`.
    #[must_use]
    pub fn new(encoded: Encoded) -> Self {
        Self { encoded, kept: KeptFrames::default() }
    }

    /// The voxels of a frame at a site, prepared at first use.
    ///
    /// # Errors
    /// A sentence, when the target cannot hold or decode them.
    pub fn at(&self, target: &Target, site: Site, frame: FrameIndex) -> Result<VoxelSource<'_>, String> {
        let coded = self.encoded.coded(RAW, frame);
        let KeptFrame { held, .. } = self.kept.get(site, frame, || {
            let source = VoxelSource::prepare(target, site, coded, &|| self.encoded.frame(frame));
            source.map(|source| KeptFrame { held: source.held, checked: None }).map_err(|e| e.to_string())
        })?;
        Ok(VoxelSource { site, coded, held })
    }
}

/// One volume in one scene under one renderer.
pub struct Stage<'a> {
    target: &'a Target,
    renderer: &'a dyn Renderer,
    scene: &'a Scene,
    range: ValueRange,
    raw: &'a RawVolume,
    references: BTreeMap<FrameIndex, Image>,
    shows_nothing: Option<String>,
    baseline: Latest<Rc<Picture<'a>>>,
    /// The picture of the frame used last, by site and filter.
    raw_images: BTreeMap<(Site, Filter), (FrameIndex, Image)>,
}

impl<'a> Stage<'a> {
    /// Draws the reference of every frame of the scene and prepares the baseline of the first.
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
        let (references, raw_images) = (BTreeMap::new(), BTreeMap::new());
        let baseline = Latest::default();
        let mut stage = Self {
            target,
            renderer,
            scene,
            range,
            raw,
            references,
            shows_nothing: None,
            baseline,
            raw_images,
        };
        let mut blank = Vec::new();
        for frame in scene.frames.iter() {
            let reference = stage.draw_raw(frame, REFERENCE)?;
            if blank::is_blank(&reference) {
                blank.push(frame);
            }
            stage.references.insert(frame, reference);
        }
        let view = stage.view(Filter::Linear)?;
        stage.shows_nothing = blank::remark(&view, volume.layout().channels, &blank, scene.frames);
        stage.baseline(FrameIndex(scene.frames.first))?;
        Ok(stage)
    }

    /// The frames that are drawn.
    #[must_use]
    pub const fn frames(&self) -> FrameRange {
        self.scene.frames
    }

    /// The reference of every picture of a frame: uncompressed, manual trilinear filter, same step.
    ///
    /// # Errors
    /// When the scene does not draw the frame.
    pub fn reference(&self, frame: FrameIndex) -> Result<&Image, String> {
        self.references.get(&frame).ok_or_else(|| format!("frame {} has no reference", frame.0))
    }

    /// The remark on blank references, with the reason. `None` if all show something.
    #[must_use]
    pub fn shows_nothing(&self) -> Option<&str> {
        self.shows_nothing.as_deref()
    }

    /// The baseline of every frame time of a frame: raw texture with hardware linear filtering.
    ///
    /// # Errors
    /// When the target refuses.
    pub fn baseline(&self, frame: FrameIndex) -> Result<Rc<Picture<'a>>, String> {
        self.baseline.get(frame, || {
            let (site, filter) = BASELINE;
            let voxels = self.raw.at(self.target, site, frame)?;
            self.picture(&self.view(filter)?, &voxels).map(Rc::new)
        })
    }

    /// A frame of the original, decoded from raw.
    ///
    /// # Errors
    /// A sentence, when it cannot be decoded.
    pub fn original(&self, frame: FrameIndex) -> Result<Arc<DecodedFrame>, String> {
        self.raw.encoded.frame(frame)
    }

    /// Name of the scene.
    #[must_use]
    pub fn scene(&self) -> &'a str {
        &self.scene.name
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

    /// Raw's picture of a frame for a site and filter, drawn once.
    ///
    /// # Errors
    /// When the target refuses.
    pub fn raw_image(&mut self, frame: FrameIndex, site: Site, filter: Filter) -> Result<&Image, String> {
        let key = (site, filter_of_raw(filter));
        if key == REFERENCE {
            return self.reference(frame);
        }
        if self.raw_images.get(&key).is_none_or(|(of, _)| *of != frame) {
            let image = self.draw_raw(frame, key)?;
            self.raw_images.insert(key, (frame, image));
        }
        let image = self.raw_images.get(&key).map(|(_, image)| image);
        image.ok_or_else(|| "raw's picture is missing".to_owned())
    }

    fn draw_raw(&self, frame: FrameIndex, (site, filter): (Site, Filter)) -> Result<Image, String> {
        let voxels = self.raw.at(self.target, site, frame)?;
        self.picture(&self.view(filter)?, &voxels)?.image().map_err(|e| e.to_string())
    }

    /// Colour behind the volume.
    #[must_use]
    pub const fn background(&self) -> [f32; 3] {
        self.scene.background
    }
}
