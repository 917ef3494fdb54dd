//! Prepares scenes: reads opacity tables, and checks frames against the volumes.

use std::sync::Arc;

use cvr_core::pipeline::{Experiment, FilePath, Scene, SceneOpacity, UnsetVariable};
use cvr_core::render::{ColourOpacity, OpacityTable, OpacityTableError};
use cvr_core::volume::{BrickSource, FrameIndex};

use crate::input::{self, InputError};

/// Why a scene cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum SceneProblem {
    /// The path of its opacity table needs an environment variable.
    #[error("scene `{scene}`: opacity table {source}")]
    Unset {
        /// Scene name.
        scene: String,
        /// The variable.
        source: UnsetVariable,
    },
    /// Its opacity table cannot be read.
    #[error("scene `{scene}`: opacity table: {source}")]
    Input {
        /// Scene name.
        scene: String,
        /// Why.
        source: Box<InputError>,
    },
    /// Its opacity table is not valid.
    #[error("scene `{scene}`: {path}: {problem}; red runs along x, green along y, blue along z")]
    Table {
        /// Scene name.
        scene: String,
        /// The file.
        path: String,
        /// Why.
        problem: OpacityTableError,
    },
    /// It draws a frame that a volume does not have.
    #[error(
        "scene `{scene}` draws {wanted}, and volume `{volume}` has {frames}, counted from 0; name the scene's \
         `volumes`, or change its `frame`"
    )]
    Frames {
        /// Scene name.
        scene: String,
        /// Frames that it draws.
        wanted: String,
        /// Volume name.
        volume: String,
        /// Frames that the volume has, in words.
        frames: String,
    },
}

/// Reads the opacity tables that scenes name.
///
/// # Errors
/// When a file is missing, unreadable, or holds no table.
pub fn read_tables(experiment: &mut Experiment) -> Result<(), SceneProblem> {
    for scene in &mut experiment.scenes {
        read_table(scene)?;
    }
    Ok(())
}

/// Reads the opacity table of a scene, if it names one.
///
/// # Errors
/// As [`read_tables`].
pub fn read_table(scene: &mut Scene) -> Result<(), SceneProblem> {
    let SceneOpacity::File(path) = &scene.opacity else { return Ok(()) };
    let table = table(&scene.name, path)?;
    scene.opacity = SceneOpacity::Known(ColourOpacity::Table(Arc::new(table)));
    Ok(())
}

fn table(scene: &str, path: &FilePath) -> Result<OpacityTable, SceneProblem> {
    let scene = scene.to_owned();
    let lookup = |name: &str| std::env::var_os(name);
    let file = match path.expand(&lookup) {
        Ok(file) => file,
        Err(source) => return Err(SceneProblem::Unset { scene, source }),
    };
    let volume = match input::read(&[file], None, None) {
        Ok(read) => read.volume,
        Err(source) => return Err(SceneProblem::Input { scene, source: Box::new(source) }),
    };
    let layout = volume.layout();
    let mut found: Vec<usize> = layout.extent.to_array().map(|n| n as usize).to_vec();
    found.extend([layout.channels, layout.frames].into_iter().filter(|n| *n > 1).map(|n| n as usize));
    let cube = found.len() == 3 && found.iter().all(|n| *n == found[0]);
    let made = if cube {
        OpacityTable::new(layout.extent.x(), &volume.frame_values(FrameIndex::FIRST))
    } else {
        Err(OpacityTableError::Shape { found })
    };
    made.map_err(|problem| SceneProblem::Table { scene, path: path.written().to_owned(), problem })
}

/// Checks the frames that scenes draw against those of a volume.
///
/// # Errors
/// When a scene that applies to the volume draws a frame beyond its last.
pub fn check_frames(experiment: &Experiment, volume: &str, frames: u32) -> Result<(), SceneProblem> {
    for scene in experiment.scenes_of(volume) {
        if scene.frames.last >= frames {
            return Err(SceneProblem::Frames {
                scene: scene.name.clone(),
                wanted: scene.frames.to_string(),
                volume: volume.to_owned(),
                frames: if frames == 1 { "one frame".to_owned() } else { format!("{frames} frames") },
            });
        }
    }
    Ok(())
}
