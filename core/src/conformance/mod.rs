//! The conformance tests that every codec must pass: adversarial volumes, and properties that hold for all codecs.
//!
//! ```no_run
//! # fn battery(codec: &dyn cvr_core::codec::Codec) {
//! cvr_core::conformance::run(codec, None).assert_ok();
//! # }
//! ```
//! A codec may *refuse* a volume ([`crate::codec::EncodeError::Unsupported`]). The report counts refusals. Every other
//! problem is a failure. The tests go on after a failure, so one run shows all failures.
//!
//! Without a dump no shader is compared, so a wrong shader passes. The report then says "shader not run"
//! ([`Report::shader_not_run`]).

mod atlas;
mod cells;
mod decoded;
mod module;
mod parity;
mod properties;
mod report;
mod stream;
#[cfg(test)]
mod tests;
mod volumes;

pub use cells::{cells_are_eight_fetches, noise};
pub use report::{Failure, Property, Report};
pub use volumes::{Subject, subjects};

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::codec::{Codec, ConfigError, EncodeError, Settings, VoxelDump, encode_temporary};
use crate::container::EncodedVolume;
use crate::volume::FiniteVolume;

/// Runs the tests with the codec's default settings. With `dump`, every voxel also goes through the real shader.
/// Without it, the report says that no shader was compared.
#[must_use]
pub fn run(codec: &dyn Codec, dump: Option<&dyn VoxelDump>) -> Report {
    run_with(codec, &[Settings::default()], dump)
}

/// Runs the tests with each of these settings, which may be partial. With settings other than the defaults, only some
/// volumes go through the shader: every sample type, one channel and three, one frame and two.
#[must_use]
pub fn run_with(codec: &dyn Codec, settings: &[Settings], dump: Option<&dyn VoxelDump>) -> Report {
    let mut report = Report::new(codec.info().id);
    report.has_shader = has_shader(codec, settings);
    for settings in settings {
        match codec.info().complete(settings) {
            Ok(settings) => run_one(codec, &settings, dump, &mut report),
            Err(e) => {
                report.begin(settings, "none");
                report.fail(Property::Encode, e.to_string());
            }
        }
    }
    report
}

/// Runs only the shader tests, on the volumes that [`run_with`] uses for settings other than the defaults.
#[must_use]
pub fn run_shaders(codec: &dyn Codec, settings: &[Settings], dump: &dyn VoxelDump) -> Report {
    let mut report = Report::new(codec.info().id);
    report.has_shader = has_shader(codec, settings);
    for settings in settings {
        let settings = match codec.info().complete(settings) {
            Ok(settings) => settings,
            Err(e) => {
                report.fail(Property::Encode, e.to_string());
                continue;
            }
        };
        for subject in chosen(codec, &settings) {
            report.begin(&settings, &subject.name);
            let volume = FiniteVolume::new(subject.volume);
            match encode_temporary(codec, &settings, &volume) {
                Ok(stream) => {
                    let case = Case { codec, settings: &settings, volume: &volume, stream: Arc::new(stream) };
                    parity::check(&case, dump, &mut report);
                }
                Err(EncodeError::Unsupported(_)) => report.refused += 1,
                Err(e) => report.fail(Property::Encode, e.to_string()),
            }
        }
    }
    report
}

/// Volumes for settings that cannot be tested on all: every third of the volumes with different layouts.
fn chosen(codec: &dyn Codec, settings: &Settings) -> impl Iterator<Item = Subject> {
    subjects(volumes::block_of(codec, settings)).into_iter().filter(|subject| subject.tamper).step_by(3)
}

/// Whether a shader of the codec decodes volumes of any of these settings, which may be partial.
fn has_shader(codec: &dyn Codec, settings: &[Settings]) -> bool {
    let mut complete = settings.iter().filter_map(|settings| codec.info().complete(settings).ok());
    complete.any(|settings| codec.decoded_by(&settings).iter().any(|by| by.on_device()))
}

/// An encoded subject, and the data that the properties compare it with.
struct Case<'a> {
    codec: &'a dyn Codec,
    settings: &'a Settings,
    volume: &'a FiniteVolume,
    stream: Arc<EncodedVolume>,
}

fn run_one(codec: &dyn Codec, settings: &Settings, dump: Option<&dyn VoxelDump>, report: &mut Report) {
    let unlisted = codec.decoded_by(settings).iter().find(|by| !codec.info().decoded_by.contains(by));
    report.check(Property::Module, unlisted.is_none(), || {
        format!("with these settings it is decoded by {unlisted:?}, which info does not list")
    });
    let refused_before = report.refused;
    let mut encoded = 0;
    let pools = match (pool(1), pool(4)) {
        (Ok(one), Ok(four)) => [one, four],
        (Err(e), _) | (_, Err(e)) => return report.fail(Property::Threads, e.to_string()),
    };
    let defaults = codec.info().complete(&codec.info().default_settings());
    let is_default = defaults.is_ok_and(|defaults| defaults == *settings);
    let chosen: BTreeSet<String> = chosen(codec, settings).map(|subject| subject.name).collect();
    for subject in subjects(volumes::block_of(codec, settings)) {
        report.begin(settings, &subject.name);
        let volume = FiniteVolume::new(subject.volume);
        let Some(case) = encoded_case(codec, settings, &volume, &pools, report) else { continue };
        encoded += 1;
        properties::check(&case, report);
        if subject.tamper {
            stream::check(&case, report);
        }
        if let Some(dump) = dump.filter(|_| is_default || chosen.contains(&subject.name)) {
            parity::check(&case, dump, report);
        }
    }
    for step in atlas::steps() {
        report.begin(settings, &step.name);
        let Some(case) = encoded_case(codec, settings, &step.volume, &pools, report) else { continue };
        properties::check(&case, report);
        atlas::check(&case, &step, report);
        if let Some(dump) = dump.filter(|_| is_default) {
            parity::check(&case, dump, report);
        }
    }
    let on_device = codec.decoded_by(settings).iter().any(|by| by.on_device());
    if dump.is_some() && on_device && encoded > 0 && report.shader_not_run() {
        report
            .fail(Property::Parity, "there is a device, and not one sample went through a shader".to_owned());
    }
    if encoded == 0 {
        let refused = report.refused - refused_before;
        report.fail(Property::Encode, format!("not one volume was encoded; {refused} were refused"));
    }
}

fn encoded_case<'a>(
    codec: &'a dyn Codec,
    settings: &'a Settings,
    volume: &'a FiniteVolume,
    pools: &[ThreadPool; 2],
    report: &mut Report,
) -> Option<Case<'a>> {
    let stream = Arc::new(encode(codec, settings, volume, pools, report)?);
    Some(Case { codec, settings, volume, stream })
}

fn pool(threads: usize) -> Result<ThreadPool, rayon::ThreadPoolBuildError> {
    ThreadPoolBuilder::new().num_threads(threads).build()
}

/// Encodes with one thread, with four, and with four again. The files must be equal. Returns the first.
fn encode(
    codec: &dyn Codec,
    settings: &Settings,
    volume: &FiniteVolume,
    pools: &[ThreadPool; 2],
    report: &mut Report,
) -> Option<EncodedVolume> {
    let folder = match tempfile::tempdir() {
        Ok(folder) => folder,
        Err(e) => return report.give_up(Property::Encode, format!("no temporary folder: {e}")),
    };
    let write = |name: &str, pool: &ThreadPool| -> Result<(std::path::PathBuf, Vec<u8>), EncodeError> {
        let path = folder.path().join(name);
        let run = crate::codec::Progress::silent();
        let replaced = volume.replaced();
        pool.install(|| crate::codec::encode_file(codec, settings, volume, replaced, &path, &run))?;
        let bytes = std::fs::read(&path).map_err(crate::volume::SourceError::Io)?;
        Ok((path, bytes))
    };
    let (path, one) = match write("one", &pools[0]) {
        Ok(written) => written,
        Err(EncodeError::Unsupported(_) | EncodeError::Config(ConfigError::Contradiction(_))) => {
            report.refused += 1;
            return None;
        }
        Err(e) => return report.give_up(Property::Encode, e.to_string()),
    };
    match (write("four", &pools[1]), write("again", &pools[1])) {
        (Ok((_, four)), Ok((_, again))) => {
            report.check(Property::Repeat, four == again, || "two encodings differ".to_owned());
            report.check(Property::Threads, one == four, || {
                format!("{} bytes with one thread, {} other bytes with four", one.len(), four.len())
            });
        }
        (Err(e), _) | (_, Err(e)) => {
            report.fail(Property::Repeat, format!("one encoding succeeds, another does not: {e}"));
        }
    }
    match EncodedVolume::open(&path) {
        Ok(stream) => Some(stream),
        Err(e) => report.give_up(Property::Stream, e.to_string()),
    }
}
