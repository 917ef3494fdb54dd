//! The rate–distortion curves of codecs and their methods: which cells they run through.

use super::bjontegaard::Curve;
use super::cells::{View, blends, compressed, distinct, ok, site_rank};
use crate::experiment::records::labels::Labels;
use crate::experiment::records::record::Record;

/// What quality a curve shows.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Measure {
    /// PSNR of all voxels.
    Voxels,
    /// PSNR without blocks of nothing.
    Foreground,
}

impl Measure {
    pub(super) const ALL: [Self; 2] = [Self::Voxels, Self::Foreground];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Voxels => "all voxels",
            Self::Foreground => "without empty blocks",
        }
    }

    /// The record's field.
    pub(super) const fn field(self) -> &'static str {
        match self {
            Self::Voxels => "psnr_db",
            Self::Foreground => "foreground_psnr_db",
        }
    }

    const fn of(self, record: &Record) -> Option<f64> {
        match self {
            Self::Voxels => record.psnr_db,
            Self::Foreground => record.foreground_psnr_db,
        }
    }
}

/// The name of a series and its curve; the uncompressed has none.
pub(super) type Named = (String, Curve);

/// Curves of a volume, of the series in the order of their first records.
pub(super) fn of_volume(records: &[Record], labels: &Labels, volume: &str, measure: Measure) -> Vec<Named> {
    let cells: Vec<&Record> = records.iter().filter(|r| r.volume == volume).collect();
    of_cells(&cells, labels, |r| measure.of(r))
}

/// Curves of a view, by the PSNR of the picture: at one site, under one filter and on one device, since each of them
/// changes pictures. The site is the one at which most series have curves, the first of equals.
pub(super) fn of_view(records: &[Record], labels: &Labels, view: &View) -> Vec<Named> {
    let mut own: Vec<&Record> =
        records.iter().filter(|r| View::of(r) == *view && !r.shows_nothing()).collect();
    if let Some(first) = own.iter().find(|r| r.image_psnr_db.is_some()).map(|r| r.device.clone()) {
        own.retain(|r| r.device == first);
    }
    if own.iter().any(|r| blends(r)) {
        own.retain(|r| blends(r));
    }
    let mut sites = distinct(own.iter().map(|r| r.site.clone()));
    sites.sort_by_key(|site| site_rank(site));
    let at = |site: &String| {
        let cells: Vec<&Record> = own.iter().copied().filter(|r| r.site == *site).collect();
        of_cells(&cells, labels, |r| r.image_psnr_db)
    };
    let full = |curves: &Vec<Named>| {
        curves.iter().filter(|c| c.1.points() >= super::bjontegaard::LEAST_POINTS).count()
    };
    let mut best = Vec::new();
    for curves in sites.iter().map(at) {
        if best.is_empty() || full(&curves) > full(&best) {
            best = curves;
        }
    }
    best
}

fn of_cells(cells: &[&Record], labels: &Labels, value: impl Fn(&Record) -> Option<f64>) -> Vec<Named> {
    let own = cells.iter().copied().filter(|r| ok(r) && compressed(r));
    let own: Vec<(String, &Record)> = own.map(|r| (labels.series(r), r)).collect();
    let curve = |series: String| {
        let of_series = own.iter().filter(|(name, _)| *name == series);
        let points = of_series.filter_map(|(_, r)| Some((r.bits_per_voxel?, value(r)?)));
        let curve = Curve::of(points);
        (series, curve)
    };
    let all = distinct(own.iter().map(|(name, _)| name.clone())).into_iter().map(curve);
    all.filter(|(_, curve)| curve.points() > 0).collect()
}
