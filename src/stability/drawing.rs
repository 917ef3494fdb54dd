//! Pictures of a subject: of the original, of what a codec and what the trivial codec make of it, by the CPU mirror of
//! raycasting, which draws alike on every machine.

use std::sync::Arc;

use cvr_core::metrics::ImageError;
use cvr_core::render::{DecodedFrame, Filter, Image, Renderer, View};
use cvr_core::stability::Subject;
use cvr_core::volume::{BrickSource as _, FiniteVolume};

use super::scenes::Provocation;
use crate::registry::renderer;

/// Background of all pictures.
pub const BACKGROUND: [f32; 3] = [0.0; 3];

/// A subject at one step, and how it is drawn.
pub struct Stage {
    renderer: Arc<dyn Renderer>,
    volume: FiniteVolume,
    frame: usize,
    scenes: Vec<Scene>,
}

/// A scene with the picture of the original.
pub struct Scene {
    /// The scene.
    pub provocation: &'static Provocation,
    view: View,
    /// The picture of the original.
    pub reference: Image,
}

impl Stage {
    /// Makes the volume and draws it in every scene.
    ///
    /// # Errors
    /// A sentence, when a scene cannot be drawn.
    pub fn new(
        subject: &'static Subject,
        step: usize,
        scenes: &[&'static Provocation],
        [edge, picture]: [u32; 2],
    ) -> Result<Self, String> {
        let volume = subject.volume(step, edge);
        let renderer = renderer("raycasting")?;
        let filter = if subject.labels { Filter::Nearest } else { Filter::Linear };
        let original = frame_of(&volume, volume.dense().frame_values(subject.frame))?;
        let scene = |provocation: &&'static Provocation| {
            let view = provocation.view(&original, volume.range(), filter, picture);
            let view = view.map_err(|e| format!("{} {}: {e}", subject.name, provocation.name))?;
            let reference = draw(renderer.as_ref(), &view, &original)?;
            Ok(Scene { provocation, view, reference })
        };
        let scenes = scenes.iter().map(scene).collect::<Result<_, String>>()?;
        Ok(Self { renderer, volume, frame: subject.frame.0 as usize, scenes })
    }

    /// The volume.
    #[must_use]
    pub const fn volume(&self) -> &FiniteVolume {
        &self.volume
    }

    /// The scenes.
    #[must_use]
    pub fn scenes(&self) -> &[Scene] {
        &self.scenes
    }

    /// The frame that is drawn, of decoded frames.
    ///
    /// # Errors
    /// When it is missing or no whole frame.
    pub fn shown(&self, frames: &[Vec<f32>]) -> Result<DecodedFrame, String> {
        let values = frames.get(self.frame).ok_or("a frame is missing")?;
        frame_of(&self.volume, values.clone())
    }

    /// The picture of a frame.
    ///
    /// # Errors
    /// When the mirror refuses.
    pub fn draw(&self, scene: &Scene, frame: &DecodedFrame) -> Result<Image, String> {
        draw(self.renderer.as_ref(), &scene.view, frame)
    }

    /// Draws a frame and compares it with the original's picture.
    ///
    /// # Errors
    /// As [`Stage::draw`].
    pub fn error(&self, scene: &Scene, frame: &DecodedFrame) -> Result<ImageError, String> {
        let image = self.draw(scene, frame)?;
        ImageError::compare(&scene.reference, &image, BACKGROUND).map_err(|e| e.to_string())
    }
}

fn frame_of(volume: &FiniteVolume, values: Vec<f32>) -> Result<DecodedFrame, String> {
    DecodedFrame::new(volume.layout().clone(), values).ok_or_else(|| "no whole frame".to_owned())
}

fn draw(renderer: &dyn Renderer, view: &View, frame: &DecodedFrame) -> Result<Image, String> {
    let mut image = Image::new(view.size);
    renderer.reference(view, frame, &mut image).map_err(|e| e.to_string())?;
    Ok(image)
}
