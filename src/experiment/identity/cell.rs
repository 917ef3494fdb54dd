//! What makes a cell this one and no other: two records of one identity are of one cell, whatever came out.

use cvr_core::pipeline::Cell;

use crate::experiment::records::record::Record;

/// Identity of a record: its columns `volume` to `scene`, and `skipping`, `stages` and `resolution`.
pub type CellIdentity = ([String; 7], bool, Option<u8>, u8);

/// Identity of a record.
#[must_use]
pub fn of_record(r: &Record) -> CellIdentity {
    let names = [&r.volume, &r.codec, &r.settings, &r.site, &r.filter, &r.renderer, &r.scene];
    (names.map(Clone::clone), r.skipping, r.stages, r.resolution)
}

/// Identity of a cell's future record.
#[must_use]
pub fn of_cell(c: &Cell) -> CellIdentity {
    let (codec, settings) = (c.codec_label(), c.settings.to_string());
    let names = [&c.volume, &codec, &settings, c.site.name(), c.filter.name(), &c.renderer, &c.scene];
    (names.map(str::to_owned), c.skipping, c.stages, c.resolution)
}

/// An identity in words.
#[must_use]
pub fn in_words((names, skipping, stages, resolution): &CellIdentity) -> String {
    let stages = stages.map(|stages| format!(" stages={stages}")).unwrap_or_default();
    let resolution = if *resolution > 0 { format!(" resolution={resolution}") } else { String::new() };
    format!("{}{}{stages}{resolution}", names.join(" "), if *skipping { " skipping" } else { "" })
}
