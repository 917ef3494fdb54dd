//! The plan of the atlas: codecs with settings, subjects with their dial steps, scenes.

use std::sync::Arc;

use cvr_core::codec::{Codec, Registry, Settings};
use cvr_core::stability::Subject;

use super::config::{CodecEntry, Config};
use super::scenes::Provocation;

/// A codec with complete settings.
#[derive(Clone, Debug)]
pub struct Contestant {
    /// The codec.
    pub codec: Arc<dyn Codec>,
    /// Complete settings.
    pub settings: Settings,
    /// `s3dc`, or `s3dc block=4 index_bits=2` with what differs from the defaults.
    pub label: String,
}

/// A subject and which steps of its dial are measured, the easiest first.
#[derive(Clone, Debug)]
pub struct Dial {
    /// The subject.
    pub subject: &'static Subject,
    /// Indices of its steps; the first is 0.
    pub steps: Vec<usize>,
}

/// All of it.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Codecs with settings, `raw` among them where it is registered.
    pub contestants: Vec<Contestant>,
    /// Those, and others whose encoders alone are measured.
    pub encoders: Vec<Contestant>,
    /// Volumes.
    pub dials: Vec<Dial>,
    /// Scenes.
    pub scenes: Vec<&'static Provocation>,
    /// Sizes, seeds, threads, generations.
    pub config: Config,
}

impl Plan {
    /// Every registered codec, or those of `ids`, with its defaults and the configuration's settings.
    ///
    /// # Errors
    /// A sentence, when a codec is unknown or settings are wrong.
    pub fn new(config: Config, registry: &Registry, ids: &[String]) -> Result<Self, String> {
        let named = config.codecs.iter().chain(&config.encoders).map(|entry| &entry.id);
        for id in ids.iter().chain(named) {
            registry.get(id).map_err(|e| e.to_string())?;
        }
        let wanted = |id: &str| ids.is_empty() || ids.iter().any(|i| i == id);
        let mut contestants: Vec<Contestant> = Vec::new();
        for codec in registry.iter().filter(|codec| wanted(codec.info().id)) {
            let id = codec.info().id;
            let default = CodecEntry { id: id.to_owned(), settings: Settings::default() };
            let further = config.codecs.iter().filter(|entry| entry.id == id);
            for entry in std::iter::once(&default).chain(further) {
                let contestant = contestant(codec, entry)?;
                if contestants.iter().all(|c| c.label != contestant.label) {
                    contestants.push(contestant);
                }
            }
        }
        let mut encoders = contestants.clone();
        for entry in config.encoders.iter().filter(|entry| wanted(&entry.id)) {
            encoders.push(contestant(registry.get(&entry.id).map_err(|e| e.to_string())?, entry)?);
        }
        let named = |names: &Option<Vec<String>>, name: &str| {
            names.as_ref().is_none_or(|names| names.iter().any(|n| n == name))
        };
        let dials = Subject::all().filter(|s| named(&config.subjects, s.name)).map(|subject| Dial {
            subject,
            steps: spread(subject.steps.len(), config.steps.unwrap_or(usize::MAX)),
        });
        let dials = dials.collect();
        let scenes = Provocation::ALL.iter().filter(|s| named(&config.scenes, s.name)).collect();
        let plan = Self { contestants, encoders, dials, scenes, config };
        let (cells, allowed) = ((plan.cells() + plan.encoder_cells()) as u64, plan.config.max_cells);
        if cells > allowed {
            return Err(format!(
                "the atlas has {cells} cells and measurements of encoders, and {allowed} are allowed: leave out settings \
                 or subjects, or write a larger number as `max_cells`"
            ));
        }
        Ok(plan)
    }

    /// Cells of the atlas: contestants × steps.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.contestants.len() * self.dials.iter().map(|dial| dial.steps.len()).sum::<usize>()
    }

    /// Measurements of encoders: contestants × subjects.
    #[must_use]
    pub fn encoder_cells(&self) -> usize {
        self.encoders.len() * self.config.encoder_subjects.len()
    }
}

fn contestant(codec: &Arc<dyn Codec>, entry: &CodecEntry) -> Result<Contestant, String> {
    let info = codec.info();
    let settings = info.complete(&entry.settings).map_err(|e| format!("[[codec]] {}: {e}", entry.id))?;
    let defaults = info.complete(&info.default_settings()).map_err(|e| e.to_string())?;
    let others: Settings = settings
        .iter()
        .filter(|(name, value)| defaults.get(name) != Some(*value))
        .map(|(name, value)| (name.to_owned(), value.clone()))
        .collect();
    let label = format!("{} {others}", info.id).trim_end().to_owned();
    Ok(Contestant { codec: Arc::clone(codec), settings, label })
}

/// At most `wanted` of the steps, evenly spaced, with the first and the last.
fn spread(count: usize, wanted: usize) -> Vec<usize> {
    if wanted >= count || wanted < 2 {
        return (0..count).collect();
    }
    (0..wanted).map(|i| (i * (count - 1) + (wanted - 1) / 2) / (wanted - 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::codecs;
    use cvr_core::codec::SettingValue;

    #[test]
    fn every_registered_codec_is_in_it_with_defaults_and_more() {
        let registry = codecs().unwrap();
        let plan = Plan::new(Config::own().unwrap(), &registry, &[]).unwrap();
        for codec in registry.iter() {
            assert!(plan.contestants.iter().any(|c| c.label == codec.info().id), "{}", codec.info().id);
        }
        assert!(plan.contestants.iter().any(|c| c.label == "s3dc block=4 index_bits=2"));
        assert_eq!((plan.dials.len(), plan.scenes.len()), (Subject::all().count(), Provocation::ALL.len()));
    }

    #[test]
    fn named_codecs_alone_are_in_it_and_unknown_ones_are_refused() {
        let registry = codecs().unwrap();
        let plan = |ids: &[&str]| {
            let ids: Vec<String> = ids.iter().map(|id| (*id).to_owned()).collect();
            Plan::new(Config::own().unwrap(), &registry, &ids)
        };
        assert!(plan(&["raw"]).unwrap().contestants.iter().all(|c| c.label == "raw"));
        assert!(plan(&["s3bc"]).unwrap_err().contains("no codec `s3bc`"));
        let mut config = Config::own().unwrap();
        config.codecs[0].settings.set("blok", SettingValue::Integer(3));
        assert!(Plan::new(config, &registry, &[]).unwrap_err().contains("no setting `blok`"));
    }

    #[test]
    fn an_atlas_of_more_cells_than_are_allowed_is_refused() {
        let registry = codecs().unwrap();
        let plan = |max_cells| {
            let mut config = Config::own().unwrap();
            config.max_cells = max_cells;
            Plan::new(config, &registry, &[])
        };
        let cells = plan(u64::MAX).map(|plan| plan.cells() + plan.encoder_cells()).unwrap() as u64;
        assert!(plan(cells).is_ok());
        let refused = plan(cells - 1).unwrap_err();
        assert!(refused.contains(&format!("{cells} cells")) && refused.contains("`max_cells`"), "{refused}");
    }

    #[test]
    fn fewer_steps_keep_both_ends() {
        assert_eq!(spread(5, 3), [0, 2, 4]);
        assert_eq!(spread(16, 3), [0, 8, 15]);
        assert_eq!(spread(6, 4), [0, 2, 3, 5]);
        assert_eq!(spread(3, 9), [0, 1, 2]);
    }
}
