//! How time and memory grow with the number of voxels: one volume in several sizes, and the power that fits.

use super::super::cells::{distinct, ok, site_rank};
use super::super::chart::{Axis, Chart, LegendEntry, Line, Mark, Point, Scale, Shape};
use super::super::number::short;
use super::Drawing;
use super::marks::{Palette, number, title};
use crate::experiment::records::labels::full_coding;
use crate::experiment::records::provenance::Provenance;
use crate::experiment::records::record::Record;
use crate::report::figure::Sheet;

/// Sizes that a fit needs: two points fit any power, and do not show whether growth is a power.
const LEAST_SIZES: usize = 3;

/// What grows.
#[derive(Copy, Clone, Debug)]
pub(super) struct Cost {
    pub(super) field: &'static str,
    pub(super) name: &'static str,
    label: &'static str,
    /// To the axis' unit.
    scale: f64,
    of: fn(&Record) -> Option<f64>,
}

pub(super) const COSTS: [Cost; 3] = [
    Cost {
        field: "encode_seconds",
        name: "Encoding time",
        label: "encoding, seconds  (← better)",
        scale: 1.0,
        of: |r| r.encode_seconds,
    },
    Cost {
        field: "decode_seconds",
        name: "Decoding time on the CPU",
        label: "decoding on the CPU, seconds  (← better)",
        scale: 1.0,
        of: |r| r.decode_seconds,
    },
    Cost {
        field: "resident_bytes",
        name: "Device memory",
        label: "in device memory, MiB  (← better)",
        scale: 1.0 / 1_048_576.0,
        of: |r| Some(r.resident_bytes? as f64),
    },
];

/// Volumes of one source and several sizes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Family {
    /// Generator and seed, and the type of the samples.
    pub(super) name: String,
    volumes: Vec<String>,
}

/// Volumes that count as one growing volume: the same source and type, in two sizes or more.
pub(super) fn families(provenance: &Provenance) -> Vec<Family> {
    let key =
        |v: &crate::experiment::records::provenance::VolumeProvenance| (v.source.clone(), v.dtype.clone());
    let family = |of: (String, String)| {
        let own = || provenance.volumes.iter().filter(|v| key(v) == of);
        let sizes = distinct(own().map(|v| v.dims)).len();
        let volumes = own().map(|v| v.name.clone()).collect();
        (sizes > 1).then(|| Family { name: format!("{}, {}", of.0, of.1), volumes })
    };
    distinct(provenance.volumes.iter().map(key)).into_iter().filter_map(family).collect()
}

/// A power of the number of voxels.
#[derive(Copy, Clone, Debug, PartialEq)]
struct Fit {
    exponent: f64,
    /// Standard error of the exponent.
    error: f64,
    /// Log10 of the cost of one voxel.
    offset: f64,
}

/// Least squares of log cost over log voxels.
///
/// # Errors
/// The number of sizes, where there are too few.
fn fit(points: &[(f64, f64)]) -> Result<Fit, usize> {
    let mut sizes: Vec<f64> = points.iter().map(|p| p.0).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    if sizes.len() < LEAST_SIZES {
        return Err(sizes.len());
    }
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.log10(), y.log10())).collect();
    let (mx, my) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let sxx: f64 = logs.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let exponent = logs.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / sxx;
    let offset = my - exponent * mx;
    let rest: f64 = logs.iter().map(|p| (p.1 - offset - exponent * p.0).powi(2)).sum();
    Ok(Fit { exponent, error: (rest / (n - 2.0) / sxx).sqrt(), offset })
}

impl Fit {
    fn at(&self, voxels: f64) -> f64 {
        10f64.powf(self.offset + self.exponent * voxels.log10())
    }
}

/// A cost over voxels, with a fitted power for each codec and settings. One site represents all.
pub(super) fn cost_growth(
    records: &[Record],
    palette: &Palette,
    family: &Family,
    device: &str,
    cost: Cost,
) -> Option<Drawing> {
    let own = |r: &&Record| ok(r) && family.volumes.contains(&r.volume) && r.device == device;
    let value = |r: &Record| (cost.of)(r).filter(|v| *v > 0.0 && v.is_finite());
    let cells: Vec<&Record> =
        records.iter().filter(own).filter(|r| value(r).is_some() && r.voxels > 0).collect();
    let mut sheet = Sheet::new(&[
        "volume",
        "codec",
        "settings",
        "stages",
        "site",
        "device",
        "voxels",
        cost.field,
        "exponent",
        "exponent_error",
        "sizes",
        "resolution",
    ]);
    let (mut points, mut lines, mut legend) = (Vec::new(), Vec::new(), Vec::new());
    let names = distinct(cells.iter().map(|r| full_coding(r)));
    for (i, name) in names.iter().enumerate() {
        let of_name: Vec<&Record> = cells.iter().copied().filter(|r| full_coding(r) == *name).collect();
        // Memory differs between sites, so that all sizes are of one.
        let site =
            of_name.iter().map(|r| r.site.as_str()).min_by_key(|site| site_rank(site)).unwrap_or_default();
        let mut series: Vec<&Record> = Vec::new();
        for volume in distinct(of_name.iter().map(|r| r.volume.clone())) {
            series.extend(of_name.iter().copied().find(|r| r.volume == volume && r.site == site));
        }
        let measured: Vec<(f64, f64)> =
            series.iter().filter_map(|r| Some((r.voxels as f64, value(r)?))).collect();
        let fit = fit(&measured);
        let Some(first) = series.first() else { continue };
        let brief = palette.labels.coding(first);
        let mark = Mark::filled(Shape::series(i), palette.colour(&palette.labels.series(first)));
        if let Ok(fit) = fit {
            let ends =
                [f64::min, f64::max].map(|end| measured.iter().map(|p| p.0).reduce(end).unwrap_or(1.0));
            let points = ends.map(|voxels| (voxels / 1e6, fit.at(voxels) * cost.scale)).to_vec();
            lines.push(Line { points, colour: mark.colour, dashed: true });
        }
        let label = match fit {
            Ok(Fit { exponent, error, .. }) => {
                format!("{brief}: voxels^{exponent:.2} (± {error:.2}, {} sizes)", measured.len())
            }
            Err(sizes) => format!("{brief}: no fit, {sizes} of {LEAST_SIZES} sizes"),
        };
        for (r, (voxels, value)) in series.iter().zip(&measured) {
            let (x, y) = (voxels / 1e6, value * cost.scale);
            let title = format!("{}\n{label}\n{} million voxels", title(r, palette), short(Some(x)));
            points.push(Point { x, y, mark, title, cell: Some(number(records, r)), unbeaten: false });
            let fitted = fit.map_or_else(
                |_| [String::new(), String::new()],
                |f| [f.exponent.to_string(), f.error.to_string()],
            );
            let stages = r.stages.map(|s| s.to_string()).unwrap_or_default();
            let words =
                [&r.volume, &r.codec, &r.settings, &stages, &r.site, &r.device].map(ToString::to_string);
            let numbers = [voxels.to_string(), value.to_string()];
            let count = [measured.len().to_string(), r.resolution.to_string()];
            sheet.row(words.into_iter().chain(numbers).chain(fitted).chain(count));
        }
        legend.push(LegendEntry { mark, label });
    }
    let sizes = distinct(cells.iter().map(|r| r.voxels)).len();
    let description = format!("{} over voxels, {}, on {device}", cost.name, family.name);
    let x = Axis::new("voxels", "voxels, millions", Scale::Log);
    let y = Axis::new(cost.field, cost.label, Scale::Log);
    let chart = Chart { description, x, y, lines, points, legend };
    (sizes > 1).then_some(Drawing { chart, sheet: Some(sheet) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::provenance::VolumeProvenance;
    use crate::experiment::records::record::tests::record;

    #[test]
    fn the_power_is_found_and_two_sizes_are_none() {
        let cube: Vec<(f64, f64)> = [32.0f64, 64.0, 128.0].map(|e| (e.powi(3), 7.0 * e.powf(4.5))).to_vec();
        let found = fit(&cube).unwrap();
        assert!((found.exponent - 1.5).abs() < 1e-12 && found.error < 1e-9, "{found:?}");
        assert!((found.at(1e6) / 7e9 - 1.0).abs() < 1e-9);
        assert_eq!(fit(&cube[..2]), Err(2));
        assert_eq!(fit(&[cube[0], cube[1], cube[1]]), Err(2), "sizes, not points");
        // As `scipy.stats.linregress` has it.
        let noisy = fit(&[(1e3, 2.0), (1e4, 30.0), (1e5, 180.0), (1e6, 2500.0)]).unwrap();
        assert!((noisy.exponent - 1.006_888_128_94).abs() < 1e-9, "{noisy:?}");
        assert!((noisy.error - 0.054_172_192_5).abs() < 1e-9, "{noisy:?}");
    }

    #[test]
    fn only_volumes_of_one_source_grow() {
        let volume = |name: &str, source: &str, edge: u32| VolumeProvenance {
            name: name.into(),
            source: source.into(),
            dims: [edge; 3],
            dtype: "u8".into(),
            ..VolumeProvenance::default()
        };
        let volumes = vec![
            volume("a", "turbulence, seed 1", 32),
            volume("b", "turbulence, seed 1", 64),
            volume("c", "turbulence, seed 1", 128),
            volume("scan", "bonsai.nrrd", 256),
            volume("d", "turbulence, seed 2", 32),
        ];
        let provenance = Provenance { volumes, ..Provenance::default() };
        let families = families(&provenance);
        let names: Vec<&[String]> = families.iter().map(|f| f.volumes.as_slice()).collect();
        assert_eq!(names, [["a", "b", "c"]]);

        let cell = |volume: &str, voxels: u64, seconds: f64| Record {
            voxels,
            encode_seconds: Some(seconds),
            site: "inline".into(),
            ..record(volume, "vq")
        };
        let records =
            [cell("a", 1000, 1.0), cell("b", 8000, 8.0), cell("c", 64000, 64.0), cell("scan", 10, 9.0)];
        let palette = Palette::new(&records);
        let drawn = cost_growth(&records, &palette, &families[0], "", COSTS[0]).unwrap();
        assert_eq!(drawn.chart.legend[0].label, "vq: voxels^1.00 (± 0.00, 3 sizes)");
        assert_eq!((drawn.chart.points.len(), drawn.chart.lines.len()), (3, 1));
        let two = cost_growth(&records[..2], &palette, &families[0], "", COSTS[0]).unwrap();
        assert_eq!(two.chart.legend[0].label, "vq: no fit, 2 of 3 sizes");
        assert!(two.chart.lines.is_empty());
        assert!(cost_growth(&records[..1], &palette, &families[0], "", COSTS[0]).is_none());
    }
}
