//! Properties of a stream that was moved or damaged.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use super::decoded::{Decoded, difference};
use super::{Case, Property, Report};
use crate::codec::{CodecInfo, DecodeError, FrameStore, Settings};
use crate::container::{ContainerError, ContainerWriter, Element, EncodedVolume, StreamWriter as _};
use crate::volume::{Extent, FrameIndex, Level, VolumeLayout};

/// A container's content, to be changed and written again with right checksums.
#[derive(Clone)]
struct Content {
    info: CodecInfo,
    layout: VolumeLayout,
    settings: Settings,
    parameters: Value,
    tensors: Vec<(String, Element, Vec<u64>, Vec<u8>)>,
}

impl Content {
    fn of(case: &Case<'_>) -> Result<Self, ContainerError> {
        let spec = case.stream.spec();
        let mut tensors = Vec::new();
        for (name, tensor) in &spec.tensors {
            let bytes = case.stream.tensor(name, tensor.element)?.bytes().to_vec();
            tensors.push((name.clone(), tensor.element, tensor.shape.clone(), bytes));
        }
        Ok(Self {
            info: case.codec.info().clone(),
            layout: spec.layout.clone(),
            settings: case.settings.clone(),
            parameters: spec.parameters.clone(),
            tensors,
        })
    }

    fn write(&self, path: &Path) -> Result<EncodedVolume, ContainerError> {
        let mut writer = ContainerWriter::create(path)?;
        for (name, element, shape, bytes) in &self.tensors {
            writer.append(name, *element, bytes)?;
            writer.shape(name, shape)?;
        }
        writer.parameters(self.parameters.clone());
        let (report, replaced) = Default::default();
        writer.finish(&self.info, &self.layout, &self.settings, &report, replaced)?;
        EncodedVolume::open(path)
    }
}

/// The result of decoding a damaged stream.
enum Outcome {
    Refused(DecodeError),
    Accepted,
    Panicked,
}

/// Checks that the stream needs nothing else, and that damage is noticed.
pub fn check(case: &Case<'_>, report: &mut Report) {
    let content = match Content::of(case) {
        Ok(content) => content,
        Err(e) => return report.fail(Property::Stream, e.to_string()),
    };
    alone(case, &content, report);
    version(case, &content, report);
    for (what, damaged) in damages(&content) {
        let outcome = decode(case, &damaged);
        report.check(Property::Damage, matches!(outcome, Ok(Outcome::Refused(_))), || match outcome {
            Ok(Outcome::Panicked) => format!("{what}: panics"),
            Ok(_) => format!("{what}: decodes as if nothing had happened"),
            Err(e) => format!("{what}: {e}"),
        });
    }
    // A changed parameter may still be valid. The decoder must not panic.
    for (what, changed) in changed_parameters(&content) {
        let outcome = decode(case, &changed);
        report
            .check(Property::Damage, !matches!(outcome, Ok(Outcome::Panicked)), || format!("{what}: panics"));
    }
}

/// The settings in a container are only for the record. The stream decodes without them, in any folder.
fn alone(case: &Case<'_>, content: &Content, report: &mut Report) {
    let bare = Content { settings: Settings::default(), ..content.clone() };
    let all = |volume| {
        let decoder = case.codec.decoder(volume).map_err(|e| e.to_string())?;
        Decoded::at(FrameStore::open(decoder.into(), u64::MAX).as_ref(), Level::FULL)
    };
    let problem = rewritten(&bare).and_then(|volume| {
        let (here, there) = (all(Arc::clone(&case.stream))?, all(volume)?);
        let differs = |f| difference(here.values(FrameIndex(f)), there.values(FrameIndex(f)));
        (0..content.layout.frames).find_map(differs).map_or(Ok(()), Err)
    });
    report.check(Property::Stream, problem.is_ok(), || {
        format!("without its settings the stream does not decode to the same: {problem:?}")
    });
}

fn version(case: &Case<'_>, content: &Content, report: &mut Report) {
    let mut later = content.clone();
    later.info.stream_version += 1;
    let outcome = decode(case, &later);
    let noticed = matches!(outcome, Ok(Outcome::Refused(DecodeError::Version { .. })));
    report
        .check(Property::Version, noticed, || "a later stream version is not named as the reason".to_owned());
    let mut other = content.clone();
    other.info.id = "someoneelse";
    let noticed = matches!(decode(case, &other), Ok(Outcome::Refused(_)));
    report.check(Property::Version, noticed, || "another codec's stream is accepted".to_owned());
}

/// Damages that every decoder must notice, with right checksums.
fn damages(content: &Content) -> Vec<(String, Content)> {
    let mut all = Vec::new();
    let mut add = |what: String, change: &dyn Fn(&mut Content)| {
        let mut damaged = content.clone();
        change(&mut damaged);
        all.push((what, damaged));
    };
    for (i, (name, element, ..)) in content.tensors.iter().enumerate() {
        add(format!("tensor `{name}` is missing"), &|c| {
            c.tensors.remove(i);
        });
        add(format!("tensor `{name}` lacks its last element"), &|c| {
            let (_, element, shape, bytes) = &mut c.tensors[i];
            bytes.truncate(bytes.len().saturating_sub(element.bytes()));
            *shape = vec![(bytes.len() / element.bytes()) as u64];
        });
        add(format!("tensor `{name}` is empty"), &|c| {
            let (_, _, shape, bytes) = &mut c.tensors[i];
            bytes.clear();
            *shape = vec![0];
        });
        let other = if *element == Element::U8 { Element::U32 } else { Element::U8 };
        add(format!("tensor `{name}` is of type {}", other.name()), &|c| {
            let (_, element, shape, bytes) = &mut c.tensors[i];
            *element = other;
            bytes.resize(bytes.len().next_multiple_of(other.bytes()), 0);
            *shape = vec![(bytes.len() / other.bytes()) as u64];
        });
    }
    if content.parameters != Value::Null {
        add("the parameters are null".to_owned(), &|c| c.parameters = Value::Null);
        add("the parameters are a text".to_owned(), &|c| c.parameters = "nonsense".into());
    }
    // Wide enough that no padding can hide it.
    let [x, y, z] = content.layout.extent.to_array();
    for (axis, size) in [[x + 64, y, z], [x, y + 64, z], [x, y, z + 64], [8192; 3]].into_iter().enumerate() {
        if let Ok(extent) = Extent::try_from(size) {
            add(format!("the layout claims {extent} voxels ({axis})"), &|c| c.layout.extent = extent);
        }
    }
    add("the layout claims another frame".to_owned(), &|c| c.layout.frames += 1);
    all
}

/// Each parameter in turn removed, or set to a strange value.
fn changed_parameters(content: &Content) -> Vec<(String, Content)> {
    let Value::Object(parameters) = &content.parameters else { return Vec::new() };
    let mut all = Vec::new();
    for key in parameters.keys() {
        let strange =
            [Value::Null, 0.into(), (-1).into(), u32::MAX.into(), 1e300.into(), "x".into(), "4096".into()];
        for value in strange {
            let mut changed = parameters.clone();
            changed.insert(key.clone(), value.clone());
            let content = Content { parameters: Value::Object(changed), ..content.clone() };
            all.push((format!("parameter `{key}` = {value}"), content));
        }
        let mut fewer = parameters.clone();
        fewer.remove(key);
        let content = Content { parameters: Value::Object(fewer), ..content.clone() };
        all.push((format!("parameter `{key}` is gone"), content));
    }
    all
}

fn rewritten(content: &Content) -> Result<Arc<EncodedVolume>, String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    content.write(&folder.path().join("elsewhere.cvr")).map(Arc::new).map_err(|e| e.to_string())
}

/// Opens and decodes; `Err` when the damaged container itself cannot be made.
fn decode(case: &Case<'_>, content: &Content) -> Result<Outcome, String> {
    let volume = rewritten(content)?;
    let attempt = || {
        let decoder = match case.codec.decoder(volume) {
            Ok(decoder) => FrameStore::open(decoder.into(), u64::MAX),
            Err(e) => return Outcome::Refused(e),
        };
        // A decoder that trusted a huge size would cost memory here, so only small volumes are decoded.
        if decoder.layout().extent.voxels() <= 1 << 20 {
            let _ = Decoded::at(decoder.as_ref(), Level::FULL);
        }
        if let Some(shader) = decoder.shader() {
            let _ = shader.resources(FrameIndex::FIRST);
        }
        if let Some(shader) = decoder.frame_decode() {
            let _ = shader.passes(FrameIndex::FIRST, Level::FULL);
        }
        Outcome::Accepted
    };
    Ok(catch_unwind(AssertUnwindSafe(attempt)).unwrap_or(Outcome::Panicked))
}
