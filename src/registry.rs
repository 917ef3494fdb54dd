//! The codecs and renderers of this application. Each is named once.

use std::sync::Arc;

use cvr_core::codec::{Codec, Registry, RegistryError};
use cvr_core::pipeline::Known;
use cvr_core::render::{Renderer, RendererInfo};

use crate::input::Generator;

/// All codecs.
///
/// # Errors
/// When two share an id: a mistake in this list.
pub fn codecs() -> Result<Registry, RegistryError> {
    let mut registry = Registry::default();
    let all = [
        cvr_bc4::codec(),
        cvr_external::codec(),
        cvr_hvq::codec(),
        cvr_raw::codec(),
        cvr_rvq::codec(),
        cvr_s3dc::codec(),
        cvr_tvq::codec(),
        cvr_vq::codec(),
        cvr_wavelet::codec(),
        cvr_zfp::codec(),
    ];
    for codec in all {
        registry.register(codec)?;
    }
    Ok(registry)
}

/// All renderers, with their default settings.
#[must_use]
pub fn renderers() -> Vec<Arc<dyn Renderer>> {
    vec![Arc::new(cvr_raycasting::Raycasting), Arc::new(cvr_slicing::Slicing::default())]
}

/// The renderer with this label: an id, and settings that differ from its defaults (`slicing,geometry=axis`).
///
/// # Errors
/// A sentence, when there is no such renderer or setting.
pub fn renderer(label: &str) -> Result<Arc<dyn Renderer>, String> {
    let renderers = renderers();
    for renderer in &renderers {
        if let Some(settings) = renderer.info().parse(label) {
            return settings.and_then(|settings| renderer.with(&settings)).map_err(|e| e.to_string());
        }
    }
    let known: Vec<_> = renderers.iter().map(|renderer| renderer.info().id).collect();
    Err(format!("no renderer `{label}`; there are: {}", known.join(", ")))
}

/// The names that a configuration may use.
#[derive(Debug)]
pub struct Names {
    codecs: Registry,
    renderers: Vec<&'static RendererInfo>,
    generators: Vec<&'static str>,
}

impl Names {
    /// All codecs and renderers of this application.
    ///
    /// # Errors
    /// As [`codecs`].
    pub fn new() -> Result<Self, RegistryError> {
        let renderers = renderers().iter().map(|r| r.info()).collect();
        let generators = Generator::ALL.iter().map(|g| g.name()).collect();
        Ok(Self { codecs: codecs()?, renderers, generators })
    }

    /// With a codec more than this application brings.
    ///
    /// # Errors
    /// When its id is taken or malformed.
    pub fn with_codec(mut self, codec: Arc<dyn Codec>) -> Result<Self, RegistryError> {
        self.codecs.register(codec)?;
        Ok(self)
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
