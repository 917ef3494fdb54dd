//! What this application holds: the codecs and renderers, each named once.

use std::sync::Arc;

use cvr_core::codec::{Registry, RegistryError};
use cvr_core::pipeline::Known;
use cvr_core::render::Renderer;

use crate::input::Generator;

/// All codecs.
///
/// # Errors
/// When two share an id: a mistake in this list.
pub fn codecs() -> Result<Registry, RegistryError> {
    let mut registry = Registry::default();
    for codec in [cvr_raw::codec(), cvr_s3dc::codec(), cvr_vq::codec()] {
        registry.register(codec)?;
    }
    Ok(registry)
}

/// All renderers.
#[must_use]
pub fn renderers() -> Vec<Arc<dyn Renderer>> {
    vec![Arc::new(cvr_raycasting::Raycasting)]
}

/// The renderer of this id.
#[must_use]
pub fn renderer(id: &str) -> Option<Arc<dyn Renderer>> {
    renderers().into_iter().find(|r| r.id() == id)
}

/// The names that a configuration may use.
#[derive(Debug)]
pub struct Names {
    codecs: Registry,
    renderers: Vec<&'static str>,
    generators: Vec<&'static str>,
}

impl Names {
    /// Names of everything in this application.
    ///
    /// # Errors
    /// As [`codecs`].
    pub fn new() -> Result<Self, RegistryError> {
        let renderers = renderers().iter().map(|r| r.id()).collect();
        let generators = Generator::ALL.iter().map(|g| g.name()).collect();
        Ok(Self { codecs: codecs()?, renderers, generators })
    }

    /// The codecs.
    #[must_use]
    pub const fn codecs(&self) -> &Registry {
        &self.codecs
    }

    /// As the configuration's reader wants them.
    #[must_use]
    pub fn known(&self) -> Known<'_> {
        Known { codecs: &self.codecs, renderers: &self.renderers, generators: &self.generators }
    }
}
