//! `[[volume]]`

use super::super::config::{ByteOrder, RawLayout, Volume, VolumeSource};
use super::super::document::Node;
use super::super::file_path::FilePath;
use super::super::read::{Fields, unknown};
use super::{Known, name_of};
use crate::diagnostic::Diagnostic;
use crate::volume::{Extent, SampleType};

/// Keys of a volume.
pub(in super::super) const VOLUME_KEYS: &[&str] =
    &["name", "file", "generate", "dims", "dtype", "byte_order", "spacing", "skip_bytes"];

/// Keys that describe a headerless file only.
const RAW_KEYS: [&str; 3] = ["byte_order", "spacing", "skip_bytes"];

/// Voxels along each axis of a generated volume, unless the configuration says otherwise.
const DEFAULT_EDGE: u32 = 64;

pub(super) fn read(node: &Node, known: &Known<'_>) -> Result<Volume, Diagnostic> {
    let fields = Fields::of("the volume", node, VOLUME_KEYS)?;
    let name = name_of(&fields, "name = \"bonsai\"")?;
    let what = format!("volume `{name}`");
    let fields = Fields::open(&what, node)?;
    let source = match (fields.entry("file"), fields.entry("generate")) {
        (Some(file), Some(generate)) => {
            let message = format!("{what} has both `file` and `generate`");
            return Err(Diagnostic::new(message, generate.place.clone(), "here a generator")
                .with_secondary(file.place.clone(), "here a file")
                .with_note("keep one of the two"));
        }
        (Some(file), None) => file_source(&fields, &file.node)?,
        (None, Some(generate)) => generated_source(&fields, &generate.node, known)?,
        (None, None) => {
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
    if let Some(entry) = RAW_KEYS.iter().find_map(|key| fields.entry(key)) {
        let message = format!("`{}` describes a headerless file; this volume is generated", entry.key);
        return Err(Diagnostic::new(message, entry.place.clone(), "has no meaning here")
            .with_note("remove this line, or read the volume with `file`"));
    }
    let edge = Extent::cube(DEFAULT_EDGE).unwrap_or(Extent::ONE);
    Ok(VolumeSource::Generated {
        generator: generator.to_owned(),
        extent: fields.optional("dims", dims)?.unwrap_or(edge),
        sample: fields.optional("dtype", sample)?.unwrap_or(SampleType::U8),
    })
}

fn file_source(fields: &Fields<'_>, file: &Node) -> Result<VolumeSource, Diagnostic> {
    let path = FilePath::new(file.text()?).map_err(|e| {
        file.error(e.to_string(), "not a path")
            .with_note("`$NAME` and `${NAME}` stand for environment variables, `$$` for `$`")
    })?;
    let described = ["dims", "dtype"].iter().chain(&RAW_KEYS).any(|key| fields.get(key).is_some());
    if !described {
        return Ok(VolumeSource::File { path, raw: None });
    }
    let byte_orders = [ByteOrder::Little, ByteOrder::Big].map(|order| (order.name(), order));
    let raw = RawLayout {
        extent: dims(fields.require("dims", "dims = [256, 256, 128]")?)?,
        sample: sample(fields.require("dtype", "dtype = \"u8\"")?)?,
        byte_order: fields
            .optional("byte_order", |n| n.one_of("byte order", &byte_orders))?
            .unwrap_or_default(),
        spacing: fields.optional("spacing", spacing)?.unwrap_or([1.0; 3]),
        skip_bytes: fields
            .optional("skip_bytes", |n| n.integer(0, i64::MAX, "a number of bytes, from 0"))?
            .unwrap_or(0)
            .unsigned_abs(),
    };
    Ok(VolumeSource::File { path, raw: Some(raw) })
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

fn spacing(node: &Node) -> Result<[f64; 3], Diagnostic> {
    let axes = node.array::<3>("three lengths, [x, y, z]")?;
    let mut spacing = [0.0; 3];
    for (axis, item) in spacing.iter_mut().zip(axes) {
        *axis = item.number("a length above 0", |x| x > 0.0)?;
    }
    Ok(spacing)
}
