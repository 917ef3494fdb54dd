//! Rate–distortion over several volumes: what a codec, or a method of it, reaches on average.

use super::super::bjontegaard::Pchip;
use super::super::cells::volumes;
use super::super::chart::{Axis, Chart, LegendEntry, Line, Point, Scale};
use super::super::curves::{Measure, of_volume};
use super::super::number::{decibels, short};
use super::Drawing;
use super::marks::Palette;
use super::rate_distortion::rate_axis;
use crate::experiment::records::record::Record;
use crate::report::figure::Sheet;

/// Marks along a line.
const MARKS: u32 = 9;
/// Pieces of line between two marks.
const PIECES: u32 = 8;

const DEFINITION: &str = "Mean over the volumes of the PSNR at the same rate. Each curve is interpolated by monotone \
    cubics over the logarithm of the rate. The mean is drawn for rates that the curves of a series reach on all volumes.";

/// The quality of a series on each volume, over log10 of the rate.
struct Pool {
    series: String,
    curves: Vec<(String, Pchip)>,
}

impl Pool {
    /// The rates that all of its curves cover, as log10.
    fn common(&self) -> Option<[f64; 2]> {
        let domains = || self.curves.iter().map(|(_, curve)| curve.domain());
        let low = domains().map(|d| d[0]).reduce(f64::max)?;
        let high = domains().map(|d| d[1]).reduce(f64::min)?;
        (low < high).then_some([low, high])
    }

    fn mean(&self, log_rate: f64) -> f64 {
        let sum: f64 = self.curves.iter().map(|(_, curve)| curve.at(log_rate)).sum();
        sum / self.curves.len() as f64
    }
}

/// Mean over the volumes of a series' PSNR at the same rate, between the rates that all of its curves cover. A series is
/// drawn if it has a curve of two points or more on each of the volumes on which any series has one. All lines are then
/// means over the same volumes. The chart comes with its definition in words.
pub(super) fn pooled(records: &[Record], palette: &Palette, measure: Measure) -> Option<(Drawing, String)> {
    let mut pools: Vec<Pool> = Vec::new();
    let mut pooled = Vec::new();
    for volume in volumes(records) {
        let curves = of_volume(records, &palette.labels, &volume, measure).into_iter();
        let mut curves = curves.filter_map(|(series, curve)| Some((series, curve.quality()?))).peekable();
        if curves.peek().is_some() {
            pooled.push(volume.clone());
        }
        for (series, curve) in curves {
            match pools.iter_mut().find(|p| p.series == series) {
                Some(pool) => pool.curves.push((volume.clone(), curve)),
                None => pools.push(Pool { series, curves: vec![(volume.clone(), curve)] }),
            }
        }
    }
    if pooled.len() < 2 {
        return None;
    }
    let (drawn, left_out): (Vec<Pool>, Vec<Pool>) =
        pools.into_iter().partition(|p| p.curves.len() == pooled.len() && p.common().is_some());
    let mut sheet = Sheet::new(&[
        "series",
        "bits_per_voxel",
        "mean_psnr_db",
        "lowest_psnr_db",
        "highest_psnr_db",
        "volumes",
    ]);
    let (mut points, mut lines, mut legend) = (Vec::new(), Vec::new(), Vec::new());
    for pool in &drawn {
        let Some([low, high]) = pool.common() else { continue };
        let at = |i: u32, of: u32| low + (high - low) * f64::from(i) / f64::from(of);
        let all = PIECES * (MARKS - 1);
        let line = (0..=all).map(|i| at(i, all)).map(|rate| (10f64.powf(rate), pool.mean(rate))).collect();
        lines.push(Line { points: line, colour: palette.colour(&pool.series), dashed: false });
        for rate in (0..MARKS).map(|i| at(i, MARKS - 1)) {
            let (x, y) = (10f64.powf(rate), pool.mean(rate));
            let each: Vec<f64> = pool.curves.iter().map(|(_, curve)| curve.at(rate)).collect();
            let (least, most) =
                (each.iter().copied().fold(y, f64::min), each.iter().copied().fold(y, f64::max));
            let mut title =
                format!("{}: {} at {} bits per voxel", pool.series, decibels(Some(y)), short(Some(x)));
            for ((volume, _), psnr) in pool.curves.iter().zip(&each) {
                title += &format!("\n{volume}: {}", decibels(Some(*psnr)));
            }
            let mark = palette.mark(&pool.series);
            points.push(Point { x, y, mark, title, cell: None, unbeaten: false });
            let values = [x, y, least, most].map(|v| v.to_string());
            let row = std::iter::once(pool.series.clone()).chain(values);
            sheet.row(row.chain(std::iter::once(pooled.len().to_string())));
        }
        legend.push(LegendEntry { mark: palette.mark(&pool.series), label: pool.series.clone() });
    }
    let x = rate_axis(points.iter().map(|p| p.x));
    let y = Axis::new(
        measure.field(),
        format!("mean PSNR, {}, in dB  (better →)", measure.name()),
        Scale::Linear,
    );
    let description =
        format!("Mean PSNR over {} volumes at equal bits per voxel, {}", pooled.len(), measure.name());
    let mut note = format!("{DEFINITION} Volumes: {}.", pooled.join(", "));
    if !left_out.is_empty() {
        let names: Vec<&str> = left_out.iter().map(|p| p.series.as_str()).collect();
        note += &format!(
            " Left out, because missing on a volume or without a common rate: {}.",
            names.join(", ")
        );
    }
    let chart = Chart { description, x, y, lines, points, legend };
    (!chart.points.is_empty()).then_some((Drawing { chart, sheet: Some(sheet) }, note))
}
