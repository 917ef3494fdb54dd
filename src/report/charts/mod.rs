//! The charts of the report, one file each, and the list of them.

mod cost_growth;
mod encode_time;
mod error_histogram;
mod marks;
mod memory_budget;
mod pooled;
mod rate_distortion;
mod speed_accuracy;

pub(super) use marks::{Palette, baseline_mark, failure_entry, filter_entries};

use std::path::Path;

use super::cells::{View, devices, views, volumes};
use super::chart::Chart;
use super::curves::Measure;
use super::figure::{Figure, Sheet, file_name};
use crate::experiment::records::provenance::Provenance;
use crate::experiment::records::record::Record;

/// A chart, and what its CSV file holds where its marks are not plain cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drawing {
    pub(super) chart: Chart,
    pub(super) sheet: Option<Sheet>,
}

impl From<Chart> for Drawing {
    fn from(chart: Chart) -> Self {
        Self { chart, sheet: None }
    }
}

impl Drawing {
    fn row(&mut self, values: impl Iterator<Item = String>) {
        if let Some(sheet) = &mut self.sheet {
            sheet.row(values);
        }
    }
}

/// The list as it grows.
struct List {
    figures: Vec<Figure>,
    /// Where several devices ran, captions and files name theirs.
    several: bool,
}

impl List {
    /// Adds a chart, if there is one. `of` is what the chart is about, in the order of a file's name.
    fn add(
        &mut self,
        drawing: Option<impl Into<Drawing>>,
        kind: &str,
        title: &str,
        of: &Subject<'_>,
        wide: bool,
    ) {
        let Some(drawing) = drawing else { return };
        let Drawing { chart, sheet } = drawing.into();
        let device = of.device.filter(|_| self.several).unwrap_or_default();
        let view = of.view.map(View::name).unwrap_or_default();
        let names: Vec<&str> =
            [of.family.unwrap_or_default(), &view, device].into_iter().filter(|n| !n.is_empty()).collect();
        let caption =
            if names.is_empty() { title.to_owned() } else { format!("{title} — {}", names.join(", ")) };
        let [scene, renderer] = of.view.map_or(["", ""], |v| [&v.scene, &v.renderer]);
        let first = of.volume.or(of.family).unwrap_or_default();
        let name = file_name(&[first, scene, renderer, device, kind]);
        let volume = of.volume.map(str::to_owned);
        self.figures.push(Figure {
            name,
            kind: kind.to_owned(),
            volume,
            caption,
            wide,
            chart,
            sheet,
            note: of.note.map(str::to_owned),
        });
    }
}

/// Subject of a chart.
#[derive(Copy, Clone, Default)]
struct Subject<'a> {
    volume: Option<&'a str>,
    family: Option<&'a str>,
    view: Option<&'a View>,
    device: Option<&'a str>,
    /// Definition of its numbers, if the axes do not show it.
    note: Option<&'a str>,
}

const BUDGET: &str = "Memory is what the device needs while it draws or while it decodes, whichever is more. The \
    line goes from one best cell to the next.";
const GROWTH: &str = "One volume in several sizes. Dashed: cost = a · voxels^b by least squares of the logarithms, b with \
    its standard error.";

/// All charts: those of all volumes together first, then volume by volume. Histograms of errors are read from `dir`.
pub(super) fn figures(
    dir: &Path,
    records: &[Record],
    provenance: &Provenance,
    palette: &Palette,
) -> Vec<Figure> {
    let mut list = List { figures: Vec::new(), several: devices(records.iter()).len() > 1 };
    all_volumes(&mut list, records, provenance, palette);
    for volume in volumes(records) {
        one_volume(&mut list, records, palette, &volume);
        if let Some((drawing, note)) =
            error_histogram::error_histogram(dir, records, palette, provenance, &volume)
        {
            let of = Subject { volume: Some(&volume), note: Some(&note), ..Subject::default() };
            list.add(
                Some(drawing),
                "error-histogram",
                "Errors of the voxels at about the same rate",
                &of,
                true,
            );
        }
    }
    list.figures
}

fn all_volumes(list: &mut List, records: &[Record], provenance: &Provenance, palette: &Palette) {
    for measure in Measure::ALL {
        let title = format!("Mean PSNR of the voxels over bits per voxel, {}", measure.name());
        let kind = format!("pooled-{}", measure.field().trim_end_matches("_db").replace('_', "-"));
        let Some((drawing, note)) = pooled::pooled(records, palette, measure) else { continue };
        let of = Subject { note: Some(&note), ..Subject::default() };
        list.add(Some(drawing), &kind, &title, &of, false);
    }
    for family in cost_growth::families(provenance) {
        for device in devices(records.iter()) {
            for cost in cost_growth::COSTS {
                let drawing = cost_growth::cost_growth(records, palette, &family, &device, cost);
                let title = format!("{} over voxels", cost.name);
                let kind = format!("growth-{}", cost.field.replace('_', "-"));
                let (family, device) = (Some(family.name.as_str()), Some(device.as_str()));
                let of = Subject { family, device, note: Some(GROWTH), ..Subject::default() };
                list.add(drawing, &kind, &title, &of, false);
            }
        }
    }
}

fn one_volume(list: &mut List, records: &[Record], palette: &Palette, volume: &str) {
    let of_volume: Vec<View> = views(records).into_iter().filter(|v| v.volume == volume).collect();
    let devices = devices(records.iter().filter(|r| r.volume == volume));
    let own = Subject { volume: Some(volume), ..Subject::default() };
    let voxels = rate_distortion::voxel_psnr(records, palette, volume);
    list.add(voxels, "voxel-psnr", "Voxels: PSNR over bits per voxel", &own, false);
    for view in &of_volume {
        let ssim = rate_distortion::picture_ssim(records, palette, view);
        let of = Subject { view: Some(view), ..own };
        list.add(ssim, "picture-ssim", "Picture: SSIM over bits per voxel", &of, false);
    }
    for device in &devices {
        let of = Subject { device: Some(device), ..own };
        let encode = encode_time::encode_time(records, palette, volume, device);
        list.add(encode, "encode-time", "Encoding time over PSNR of the voxels", &of, false);
        let decode = speed_accuracy::decode_rate(records, palette, volume, device);
        list.add(decode, "decode-rate", "Decoding speed over PSNR of the voxels", &of, false);
    }
    for (view, device) in of_volume.iter().flat_map(|v| devices.iter().map(move |d| (v, d))) {
        let of = Subject { view: Some(view), device: Some(device), ..own };
        let time = speed_accuracy::frame_time(records, palette, view, device);
        list.add(time, "frame-time", "Frame time over PSNR of the picture", &of, true);
        let of = Subject { note: Some(BUDGET), ..of };
        let picture = memory_budget::best_picture(records, palette, view, device);
        list.add(picture, "memory-budget", "Best picture within a budget of device memory", &of, false);
        let time = memory_budget::its_frame_time(records, palette, view, device);
        let of = Subject { note: None, ..of };
        list.add(time, "memory-budget-time", "Frame time of that picture", &of, false);
    }
}

#[cfg(test)]
mod tests;
