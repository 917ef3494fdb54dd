//! The comparison as a file: one line per cell, quantity and other run.

use super::cells::pair;
use super::quantity::QUANTITIES;
use super::side::Side;

const HEADER: [&str; 19] = [
    "first",
    "other",
    "volume",
    "codec",
    "settings",
    "site",
    "filter",
    "renderer",
    "scene",
    "skipping",
    "stages",
    "quantity",
    "first_value",
    "other_value",
    "change",
    "noise",
    "verdict",
    "kind",
    "resolution",
];

/// All runs against the first. `change` is other ÷ first, and for decibels (`kind` = `difference`) other − first. `once` as
/// [`super::Quantity::compare`] has it.
///
/// # Errors
/// When a line cannot be written, for want of memory.
pub fn csv(sides: &[Side], once: f64) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEADER)?;
    let Some((first, others)) = sides.split_first() else { return Ok(Vec::new()) };
    let name = |side: &Side| format!("{}: {}, {}", side.file.display(), side.software, side.machine);
    for other in others {
        for matched in pair(first, other).both {
            let r = matched.first;
            for quantity in &QUANTITIES {
                let Some(c) = quantity.compare(matched.first, matched.other, once) else { continue };
                let stages = r.stages.map(|s| s.to_string()).unwrap_or_default();
                let kind = if quantity.kind == super::Kind::Decibels { "difference" } else { "ratio" };
                let numbers = [c.first, c.other, c.change, c.noise].map(|v| v.to_string());
                let names = [&r.volume, &r.codec, &r.settings, &r.site, &r.filter, &r.renderer, &r.scene];
                let line = [name(first), name(other)].into_iter().chain(names.map(Clone::clone));
                let line =
                    line.chain([r.skipping.to_string(), stages, quantity.field.to_owned()]).chain(numbers);
                let line = line.chain([c.verdict.name(), kind].map(str::to_owned));
                writer.write_record(line.chain([r.resolution.to_string()]))?;
            }
        }
    }
    writer.into_inner().map_err(|e| e.into_error().into())
}
