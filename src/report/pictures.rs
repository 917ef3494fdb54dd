//! The pictures: per view the original, and for each cell what was drawn and where it is wrong.

use minijinja::{Value, context};

use super::cells::{View, compressed, ok, site_rank, views};
use super::embed::Pictures;
use super::number::{decibels, fixed, short};
use crate::experiment::records::labels::{Labels, full_cell};
use crate::experiment::records::provenance::Provenance;
use crate::experiment::records::record::Record;

/// Cells of a view that are shown at once; the others open on demand.
const AT_ONCE: usize = 8;

/// One group per view that has any picture.
pub(super) fn groups(
    provenance: &Provenance,
    records: &[Record],
    labels: &Labels,
    pictures: &mut Pictures,
) -> Vec<Value> {
    views(records).iter().filter_map(|view| group(provenance, (records, labels), view, pictures)).collect()
}

fn group(
    provenance: &Provenance,
    (records, labels): (&[Record], &Labels),
    view: &View,
    pictures: &mut Pictures,
) -> Option<Value> {
    let mut cells: Vec<&Record> = records
        .iter()
        .filter(|r| View::of(r) == *view && (r.image.is_some() || r.error_image.is_some()))
        .collect();
    let reference = provenance
        .references
        .iter()
        .find(|p| p.volume == view.volume && p.scene == view.scene && p.renderer == view.renderer)
        .map(|p| p.image.as_str())
        // An uncompressed picture without any error is the reference, pixel by pixel.
        .or_else(|| {
            let same = |r: &&&Record| !compressed(r) && r.image_psnr_db == Some(f64::INFINITY);
            cells.iter().find(same).and_then(|r| r.image.as_deref())
        });
    if cells.is_empty() && reference.is_none() {
        return None;
    }
    // Cells of one codec side by side, from the smallest file to the largest.
    cells.sort_by(|a, b| {
        let rate = |r: &Record| r.bits_per_voxel.unwrap_or(f64::INFINITY);
        a.codec
            .cmp(&b.codec)
            .then(rate(a).total_cmp(&rate(b)))
            .then(site_rank(&a.site).cmp(&site_rank(&b.site)))
    });
    // One site represents all: they draw the same values. If the preferred one is missing, the next is used.
    let preferred = cells.iter().filter(|r| compressed(r) && r.filter == "linear").map(|r| r.site.as_str());
    let preferred = preferred.min_by_key(|site| site_rank(site)).unwrap_or("inline").to_owned();
    let first = |r: &&Record| compressed(r) && r.filter == "linear" && r.site == preferred;
    let (mut shown, mut rest): (Vec<&Record>, Vec<&Record>) = cells.into_iter().partition(first);
    if shown.is_empty() {
        shown = std::mem::take(&mut rest);
    }
    if shown.len() > AT_ONCE {
        let later = thin_out(&mut shown);
        rest.splice(0..0, later);
    }
    let shown: Vec<Value> = shown.into_iter().map(|r| cell((records, labels), r, pictures)).collect();
    let rest: Vec<Value> = rest.into_iter().map(|r| cell((records, labels), r, pictures)).collect();
    Some(context! {
        volume => view.volume.clone(),
        name => view.name(),
        reference => reference.and_then(|path| pictures.source(path)),
        cells => shown,
        rest => rest,
    })
}

/// Leaves [`AT_ONCE`] cells spread evenly over the list, and returns the others.
fn thin_out<'a>(cells: &mut Vec<&'a Record>) -> Vec<&'a Record> {
    let last = cells.len() - 1;
    let kept: Vec<usize> = (0..AT_ONCE).map(|i| i * last / (AT_ONCE - 1)).collect();
    let (shown, later): (Vec<_>, Vec<_>) = cells.drain(..).enumerate().partition(|(i, _)| kept.contains(i));
    *cells = shown.into_iter().map(|(_, r)| r).collect();
    later.into_iter().map(|(_, r)| r).collect()
}

fn cell((records, labels): (&[Record], &Labels), record: &Record, pictures: &mut Pictures) -> Value {
    let mut source = |path: &Option<String>| path.as_deref().and_then(|p| pictures.source(p));
    let filter = match record.filtering.as_deref() {
        Some(by) if record.filter != "nearest" => format!("{} ({by})", record.filter),
        _ => record.filter.clone(),
    };
    context! {
        number => records.iter().position(|r| std::ptr::eq(r, record)),
        codec => record.codec.clone(),
        settings => labels.settings(record),
        place => [record.site.clone(), filter].join(", "),
        name => labels.cell(record),
        full => full_cell(record),
        failed => !ok(record),
        error => record.error.clone(),
        image => source(&record.image),
        error_image => source(&record.error_image),
        rate => short(record.bits_per_voxel),
        blank => record.shows_nothing(),
        identical => record.image_psnr_db == Some(f64::INFINITY),
        psnr => decibels(record.image_psnr_db),
        ssim => fixed(record.image_ssim, 4),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::record::tests::record;

    #[test]
    fn thinning_keeps_both_ends_and_loses_nothing() {
        let records: Vec<Record> =
            (0..30).map(|i| Record { settings: i.to_string(), ..record("v", "s3dc") }).collect();
        let mut shown: Vec<&Record> = records.iter().collect();
        let later = thin_out(&mut shown);
        assert_eq!(shown.len(), AT_ONCE);
        assert_eq!((shown[0], shown[AT_ONCE - 1]), (&records[0], &records[29]));
        assert_eq!(shown.len() + later.len(), 30);
    }
}
