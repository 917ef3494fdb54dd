//! The trait of renderers, and labels of their settings.

use std::fmt::Debug;
use std::sync::Arc;

use super::{Image, Plan, RenderError, View, Voxels};
use crate::codec::{ConfigError, Setting, SettingValue, Settings};
use crate::volume::VolumeLayout;

/// Metadata of a renderer.
#[derive(Copy, Clone, Debug)]
pub struct RendererInfo {
    /// Name in TOML and records.
    pub id: &'static str,
    /// One line for lists.
    pub summary: &'static str,
    /// Its settings: additional keys of `[pipeline]`.
    pub settings: &'static [Setting],
    /// The settings with which it draws from a ring of layers ([`Renderer::plan_layers`], site *ring*). `None` if it
    /// never does.
    pub layers: Option<&'static [(&'static str, &'static str)]>,
}

impl RendererInfo {
    /// The label of this renderer with these settings, in records and on command lines: the id, and the settings that
    /// differ from the defaults (`slicing,geometry=axis`). Equal settings have equal labels.
    ///
    /// # Errors
    /// When it has no such setting, or not this value.
    pub fn label(&self, settings: &Settings) -> Result<String, ConfigError> {
        let complete = self.complete(settings)?;
        let defaults = self.complete(&Settings::default())?;
        let changed = complete.iter().filter(|(name, value)| defaults.get(name) != Some(value));
        Ok(changed.fold(self.id.to_owned(), |label, (name, value)| format!("{label},{name}={value}")))
    }

    /// The complete settings of a label. `None` if the label is another renderer's.
    ///
    /// # Errors
    /// As [`RendererInfo::label`].
    pub fn parse(&self, label: &str) -> Option<Result<Settings, ConfigError>> {
        let mut parts = label.split(',');
        if parts.next() != Some(self.id) {
            return None;
        }
        // A word without a value becomes an unknown setting, and the schema reports it.
        let pairs = parts.map(|part| part.split_once('=').unwrap_or((part, "")));
        let written: Settings =
            pairs.map(|(name, value)| (name.to_owned(), SettingValue::from(value))).collect();
        Some(self.complete(&written))
    }

    /// Whether a renderer with this label draws from a ring of layers. Labels contain only settings that differ from
    /// the defaults.
    #[must_use]
    pub fn draws_layers(&self, label: &str) -> bool {
        let settings = self.parse(label).and_then(Result::ok);
        settings.zip(self.layers).is_some_and(|(settings, needed)| {
            needed.iter().all(|(name, value)| settings.text(name).is_ok_and(|text| text == *value))
        })
    }

    /// The label with which it draws from a ring of layers, if there is one.
    #[must_use]
    pub fn layers_label(&self) -> Option<String> {
        let needed = self.layers?.iter();
        Some(needed.fold(self.id.to_owned(), |label, (name, value)| format!("{label},{name}={value}")))
    }

    fn complete(&self, settings: &Settings) -> Result<Settings, ConfigError> {
        settings.complete_by(&format!("renderer `{}`", self.id), self.settings)
    }
}

/// Walks a volume and draws a picture. It only describes passes and needs no device.
pub trait Renderer: Send + Sync + Debug {
    /// Its name and settings.
    fn info(&self) -> &'static RendererInfo;

    /// The same renderer with other settings, which are complete.
    ///
    /// # Errors
    /// When settings exclude each other.
    fn with(&self, settings: &Settings) -> Result<Arc<dyn Renderer>, ConfigError>;

    /// The passes that draw `view` of a volume of this shape.
    ///
    /// # Errors
    /// When the renderer does not offer what the view asks for.
    fn plan(&self, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError>;

    /// The pass of kind [`super::Stage::Layers`] that draws the same picture from a ring of layers, for the site
    /// *ring*.
    ///
    /// # Errors
    /// As [`Renderer::plan`], and when the renderer, with its settings, does not draw layer by layer.
    fn plan_layers(&self, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
        let _ = (view, layout);
        Err(RenderError::Unsupported(format!("renderer {} does not draw layer by layer", self.info().id)))
    }

    /// The CPU mirror: the same picture with the same arithmetic in Rust. It defines the golden image. For a
    /// [`super::Filter`] it computes what the manual filters of the shaders compute.
    ///
    /// # Errors
    /// As [`Renderer::plan`], and when `voxels` fails.
    ///
    /// # Panics
    /// When `image` has another size than the view.
    fn reference(&self, view: &View, voxels: &dyn Voxels, image: &mut Image) -> Result<(), RenderError>;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::SettingKind;

    const INFO: RendererInfo = RendererInfo {
        id: "slicing",
        summary: "",
        settings: &[
            Setting {
                name: "geometry",
                doc: "",
                kind: SettingKind::Choice(&["planes", "axis"]),
                default: "planes",
            },
            Setting { name: "layers", doc: "", kind: SettingKind::Integer { min: 1, max: 9 }, default: "1" },
        ],
        layers: Some(&[("geometry", "axis")]),
    };

    #[test]
    fn a_label_names_what_differs_and_reads_back() {
        let label = |text| {
            let settings = INFO.parse(text).unwrap().unwrap();
            INFO.label(&settings).unwrap()
        };
        assert_eq!(label("slicing"), "slicing");
        assert_eq!(label("slicing,layers=1,geometry=planes"), "slicing");
        assert_eq!(label("slicing,layers=3,geometry=axis"), "slicing,geometry=axis,layers=3");
        assert!(INFO.parse("raycasting").is_none());
        for (label, draws) in [
            ("slicing", false),
            ("slicing,geometry=axis,layers=3", true),
            ("slicing,geometry=cones", false),
            ("raycasting,geometry=axis", false),
        ] {
            assert_eq!(INFO.draws_layers(label), draws, "{label}");
        }
        assert_eq!(INFO.layers_label().as_deref(), Some("slicing,geometry=axis"));
        assert!(!RendererInfo { layers: None, ..INFO }.draws_layers("slicing,geometry=axis"));
        let problem = |text| INFO.parse(text).unwrap().unwrap_err().to_string();
        assert_eq!(
            problem("slicing,step=3"),
            "renderer `slicing` has no setting `step`; it has: geometry, layers"
        );
        assert_eq!(
            problem("slicing,layers=12"),
            "`layers = 12` of renderer `slicing`: expected an integer from 1 to 9"
        );
    }
}
