//! What `configs/stability.toml` says.

use std::ops::RangeInclusive;
use std::path::Path;

use cvr_core::codec::Settings;
use cvr_core::pipeline::Experiment;
use cvr_core::stability::Subject;
use serde::Deserialize;

use super::scenes::Provocation;

/// The configuration that comes with the program.
const OWN: &str = include_str!("../../configs/stability.toml");

/// Edges of pictures, in pixels.
const PICTURES: RangeInclusive<u32> = 16..=96;

/// Size of the atlas, and settings that differ from the defaults.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Longest axis of the volumes in voxels.
    pub edge: u32,
    /// Width and height of the pictures in pixels.
    pub picture: u32,
    /// Subjects by name; `None` = all.
    pub subjects: Option<Vec<String>>,
    /// Scenes by name; `None` = all.
    pub scenes: Option<Vec<String>>,
    /// Steps of each dial; `None` = all.
    pub steps: Option<usize>,
    /// Seeds over which the spread is taken.
    pub seeds: u32,
    /// Numbers of threads.
    pub threads: Vec<usize>,
    /// Encodings one after another.
    pub generations: u32,
    /// Subjects of the encoder's stability, by name.
    pub encoder_subjects: Vec<String>,
    /// What `--quick` changes.
    #[serde(default)]
    quick: Quick,
    /// Most cells and measurements of encoders together.
    #[serde(default = "max_cells")]
    pub max_cells: u64,
    /// What reading did that the author of the file should know of, one sentence each.
    #[serde(skip)]
    pub notes: Vec<String>,
    /// Further settings.
    #[serde(default, rename = "codec")]
    pub codecs: Vec<CodecEntry>,
    /// Settings for the measurements of encoders only.
    #[serde(default, rename = "encoder")]
    pub encoders: Vec<CodecEntry>,
}

const fn max_cells() -> u64 {
    Experiment::MAX_CELLS
}

/// Leaves each value once, in its first place; says whether one came again.
fn once<T: PartialEq>(values: &mut Vec<T>) -> bool {
    let written = values.len();
    let mut kept: Vec<T> = Vec::new();
    for value in values.drain(..) {
        if !kept.contains(&value) {
            kept.push(value);
        }
    }
    *values = kept;
    values.len() < written
}

/// Settings of a codec that differ from its defaults.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct CodecEntry {
    /// Codec id.
    pub id: String,
    /// Settings, partial.
    #[serde(flatten)]
    pub settings: Settings,
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Quick {
    edge: Option<u32>,
    picture: Option<u32>,
    subjects: Option<Vec<String>>,
    scenes: Option<Vec<String>>,
    steps: Option<usize>,
    seeds: Option<u32>,
    threads: Option<Vec<usize>>,
    generations: Option<u32>,
    encoder_subjects: Option<Vec<String>>,
}

impl Config {
    /// The configuration that comes with the program.
    ///
    /// # Errors
    /// When it is wrong, which a test rules out.
    pub fn own() -> Result<Self, String> {
        Self::parse("configs/stability.toml", OWN)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// When it cannot be read, or is wrong: file, place and the way out.
    pub fn read(path: &Path) -> Result<Self, String> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|e| format!("{name}: {e}"))?;
        Self::parse(&name, &text)
    }

    /// Reads a text; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`Config::read`].
    pub fn parse(name: &str, text: &str) -> Result<Self, String> {
        let mut config: Self = toml::from_str(text).map_err(|e| format!("{name}: {e}"))?;
        config.count_once(name);
        for config in [config.clone(), config.clone().quick()] {
            config.check().map_err(|e| format!("{name}: {e}"))?;
        }
        Ok(config)
    }

    /// Equal values of a list that multiplies count once, which a note says.
    fn count_once(&mut self, name: &str) {
        let quick = &mut self.quick;
        let repeated = [
            ("threads", once(&mut self.threads)),
            ("encoder_subjects", once(&mut self.encoder_subjects)),
            ("quick.threads", quick.threads.as_mut().is_some_and(once)),
            ("quick.encoder_subjects", quick.encoder_subjects.as_mut().is_some_and(once)),
        ];
        for (key, _) in repeated.into_iter().filter(|(_, repeated)| *repeated) {
            self.notes.push(format!("{name}: `{key}` lists a value again; equal values count once"));
        }
    }

    /// The same with what `--quick` changes.
    #[must_use]
    pub fn quick(self) -> Self {
        let Quick { edge, picture, subjects, scenes, steps, seeds, threads, generations, encoder_subjects } =
            self.quick.clone();
        Self {
            edge: edge.unwrap_or(self.edge),
            picture: picture.unwrap_or(self.picture),
            subjects: subjects.or(self.subjects),
            scenes: scenes.or(self.scenes),
            steps: steps.or(self.steps),
            seeds: seeds.unwrap_or(self.seeds),
            threads: threads.unwrap_or(self.threads),
            generations: generations.unwrap_or(self.generations),
            encoder_subjects: encoder_subjects.unwrap_or(self.encoder_subjects),
            max_cells: self.max_cells,
            notes: self.notes,
            quick: self.quick,
            codecs: self.codecs,
            encoders: self.encoders,
        }
    }

    /// Checks everything against its limits.
    ///
    /// # Errors
    /// A sentence with the key, its value and the expectation.
    pub fn check(&self) -> Result<(), String> {
        let within = |name: &str, value: u64, allowed: RangeInclusive<u64>| {
            let (low, high) = (allowed.start(), allowed.end());
            if allowed.contains(&value) {
                Ok(())
            } else {
                Err(format!("`{name} = {value}`: expected a number from {low} to {high}"))
            }
        };
        let u64s = |range: &RangeInclusive<u32>| u64::from(*range.start())..=u64::from(*range.end());
        within("edge", self.edge.into(), u64s(&Subject::EDGES))?;
        within("picture", self.picture.into(), u64s(&PICTURES))?;
        within("steps", self.steps.map_or(2, |n| n as u64), 2..=16)?;
        within("seeds", self.seeds.into(), 1..=64)?;
        within("generations", self.generations.into(), 1..=100)?;
        if self.threads.is_empty() {
            return Err("`threads` is empty: name at least one number of threads".to_owned());
        }
        for threads in &self.threads {
            within("threads", *threads as u64, 1..=256)?;
        }
        let subjects: Vec<&str> = Subject::all().map(|s| s.name).collect();
        let scenes: Vec<&str> = Provocation::ALL.iter().map(|s| s.name).collect();
        let lists = [
            ("subjects", self.subjects.as_ref(), &subjects),
            ("encoder_subjects", Some(&self.encoder_subjects), &subjects),
            ("scenes", self.scenes.as_ref(), &scenes),
        ];
        for (key, names, known) in lists {
            if names.is_some_and(Vec::is_empty) && key != "encoder_subjects" {
                return Err(format!("`{key}` is empty: leave the line away for all"));
            }
            for name in names.into_iter().flatten() {
                if !known.contains(&name.as_str()) {
                    return Err(format!("`{key}` names `{name}`; there are: {}", known.join(", ")));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_programs_own_is_right_and_quick_is_less() {
        let config = Config::own().unwrap();
        let quick = config.clone().quick();
        assert!(quick.edge < config.edge && quick.picture < config.picture && quick.steps == Some(3));
        assert!(config.codecs.len() >= 4);
    }

    #[test]
    fn equal_values_count_once_and_a_note_says_so() {
        let config =
            |list: &str| Config::parse("x.toml", &OWN.replacen("threads = [1, 2, 4]", list, 1)).unwrap();
        assert_eq!(config("threads = [1, 2, 4]").notes, [""; 0]);
        let again = config("threads = [2, 1, 2, 1]");
        assert_eq!(again.threads, [2, 1]);
        assert_eq!(again.notes, ["x.toml: `threads` lists a value again; equal values count once"]);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place_or_its_key() {
        let wrong = [
            ("edge = 48 ", "edge = 49 ", "`edge = 49`: expected a number from 12 to 48"),
            ("edge = 48 ", "egde = 48 ", "unknown field `egde`"),
            ("picture = 96 ", "picture = \"96\" ", "line 10"),
            ("[\"noise\"]", "[\"nosie\"]", "`encoder_subjects` names `nosie`; there are: constant"),
            ("\"slope-30\"", "\"slope-31\"", "`scenes` names `slope-31`"),
            ("threads = [1, 2, 4]", "threads = []", "`threads` is empty"),
            ("steps = 3 ", "steps = 1 ", "`steps = 1`"),
        ];
        for (right, other, expected) in wrong {
            assert!(OWN.contains(right), "{right}");
            let error = Config::parse("x.toml", &OWN.replacen(right, other, 1)).unwrap_err();
            assert!(error.starts_with("x.toml: ") && error.contains(expected), "{error}");
        }
    }
}
