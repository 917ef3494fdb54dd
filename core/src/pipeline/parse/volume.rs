//! `[[volume]]`

use super::super::config::{ByteOrder, RawLayout, Volume, VolumeSource};
use super::super::document::Node;
use super::super::file_path::FilePath;
use super::super::keys::volume::{self, DEFAULT_EDGE, RAW_NEEDS};
use super::super::read::{Fields, unknown};
use super::{Known, name_of, path};
use crate::diagnostic::Diagnostic;
use crate::volume::{Extent, SampleType, StoredType};

pub(super) fn read(node: &Node, known: &Known<'_>) -> Result<Volume, Diagnostic> {
    let keys = volume::names();
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    let fields = Fields::of("the volume", node, &keys)?;
    let name = name_of(&fields, "name = \"bonsai\"")?;
    let what = format!("volume `{name}`");
    let fields = Fields::open(&what, node)?;
    let origins = [("file", "a file"), ("files", "a sequence of files"), ("generate", "a generator")];
    let mut given = origins.into_iter().filter_map(|(key, thing)| Some((fields.entry(key)?, thing)));
    let source = match (given.next(), given.next()) {
        (Some((first, thing)), Some((second, other))) => {
            let message = format!("{what} has both `{}` and `{}`", first.key, second.key);
            return Err(Diagnostic::new(message, second.place.clone(), format!("here {other}"))
                .with_secondary(first.place.clone(), format!("here {thing}"))
                .with_note("keep one of the two"));
        }
        (Some((entry, _)), None) => match entry.key.as_str() {
            "generate" => generated_source(&fields, &entry.node, known)?,
            "files" => file_source(&fields, sequence(&entry.node)?)?,
            _ => file_source(&fields, vec![path(&entry.node)?])?,
        },
        (None, _) => {
            let error =
                node.error(format!("{what} has neither `file` nor `generate`"), "one is missing here");
            return Err(error.with_note("write, for instance, `file = \"$CVR_DATA/bonsai.nrrd\"`"));
        }
    };
    Ok(Volume { name, source })
}

fn generated_source(
    fields: &Fields<'_>,
    generate: &Node,
    known: &Known<'_>,
) -> Result<VolumeSource, Diagnostic> {
    let generator = generate.text()?;
    if !known.generators.contains(&generator) {
        return Err(unknown(&generate.place, "generator", generator, known.generators));
    }
    if let Some(entry) = volume::of_files_alone().iter().find_map(|key| fields.entry(key)) {
        let message = format!("`{}` describes a file; this volume is generated", entry.key);
        return Err(Diagnostic::new(message, entry.place.clone(), "has no meaning here")
            .with_note("remove this line, or read the volume with `file`"));
    }
    let edge = Extent::cube(DEFAULT_EDGE).unwrap_or(Extent::ONE);
    Ok(VolumeSource::Generated {
        generator: generator.to_owned(),
        extent: fields.optional("dims", dims)?.unwrap_or(edge),
        frames: fields.optional("frames", frames)?.unwrap_or(1),
        sample: fields.optional("dtype", sample)?.unwrap_or(SampleType::U8),
    })
}

/// The files of `files`, at least one. A file may be listed twice; its frames then appear twice.
fn sequence(list: &Node) -> Result<Vec<FilePath>, Diagnostic> {
    let items = list.list("a list of paths")?;
    if items.is_empty() {
        return Err(list
            .error("the list names no file", "empty list")
            .with_note("name at least one, or write `file = \"step*.raw\"` for all that a pattern matches"));
    }
    items.iter().map(path).collect()
}

fn file_source(fields: &Fields<'_>, files: Vec<FilePath>) -> Result<VolumeSource, Diagnostic> {
    let spacing = fields.optional("spacing", spacing)?;
    if !RAW_NEEDS.iter().any(|(key, _)| fields.get(key).is_some()) {
        return Ok(VolumeSource::File { files, raw: None, spacing });
    }
    let byte_orders = [ByteOrder::Little, ByteOrder::Big].map(|order| (order.name(), order));
    let raw = RawLayout {
        extent: dims(fields.require("dims", "dims = [256, 256, 128]")?)?,
        channels: fields.optional("channels", channels)?.unwrap_or(1),
        frames: fields.optional("frames", frames)?.unwrap_or(1),
        stored: stored(fields.require("dtype", "dtype = \"u8\"")?)?,
        byte_order: fields
            .optional("byte_order", |n| n.one_of("byte order", &byte_orders))?
            .unwrap_or_default(),
        spacing: spacing.unwrap_or([1.0; 3]),
        skip_bytes: fields
            .optional("skip_bytes", |n| n.integer(0, i64::MAX, "a number of bytes, from 0"))?
            .unwrap_or(0)
            .unsigned_abs(),
    };
    Ok(VolumeSource::File { files, raw: Some(raw), spacing: None })
}

fn frames(node: &Node) -> Result<u32, Diagnostic> {
    let frames = node.integer(1, i64::from(u32::MAX), "a number of time steps, from 1")?;
    Ok(u32::try_from(frames).unwrap_or(u32::MAX))
}

fn channels(node: &Node) -> Result<u32, Diagnostic> {
    match node.integer(1, 3, "1 (scalar) or 3 (RGB)")? {
        1 => Ok(1),
        3 => Ok(3),
        _ => Err(node.not_allowed("1 (scalar) or 3 (RGB)")),
    }
}

fn dims(node: &Node) -> Result<Extent, Diagnostic> {
    let axes = node.array::<3>("three sizes in voxels, [x, y, z]")?;
    let mut size = [0; 3];
    for (axis, item) in size.iter_mut().zip(axes) {
        let voxels = item.integer(1, i64::from(u32::MAX), "a number of voxels, from 1")?;
        *axis = u32::try_from(voxels).unwrap_or(u32::MAX);
    }
    Extent::try_from(size).map_err(|e| node.error(e.to_string(), "too large").with_note("take smaller sizes"))
}

fn sample(node: &Node) -> Result<SampleType, Diagnostic> {
    node.one_of("sample type", &SampleType::ALL.map(|t| (t.name(), t)))
}

fn stored(node: &Node) -> Result<StoredType, Diagnostic> {
    node.one_of("sample type", &StoredType::ALL.map(|t| (t.name(), t)))
}

fn spacing(node: &Node) -> Result<[f64; 3], Diagnostic> {
    let axes = node.array::<3>("three lengths, [x, y, z]")?;
    let mut spacing = [0.0; 3];
    for (axis, item) in spacing.iter_mut().zip(axes) {
        *axis = item.number("a length above 0", |x| x > 0.0)?;
    }
    Ok(spacing)
}
