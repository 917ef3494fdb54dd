//! Bjøntegaard's differences of every pair of curves, per volume and over all: as the page's tables, and as a file.

use minijinja::{Value, context};

use super::bjontegaard::{Curve, LEAST_POINTS, Refused, decibels, log_rate, percent};
use super::cells::{View, distinct, views, volumes};
use super::curves::{Measure, Named, of_view, of_volume};
use super::figure::Sheet;
use super::number::fixed;
use crate::experiment::records::labels::Labels;
use crate::experiment::records::record::Record;

/// What curves may be compared within.
#[derive(Clone, Debug, PartialEq)]
struct Scope {
    volume: String,
    /// Scene and renderer, of pictures.
    view: String,
    /// The measured quantity, in words.
    measure: &'static str,
    curves: Vec<Named>,
}

/// One series against another within a scope.
#[derive(Clone, Debug, PartialEq)]
struct Difference {
    anchor: String,
    series: String,
    /// Points of both curves, that of the anchor first.
    points: [usize; 2],
    /// Mean of log10 of the ratio of rates.
    log_rate: Result<f64, Refused>,
    decibels: Result<f64, Refused>,
}

const PICTURE: &str = "picture";

fn scopes(records: &[Record], labels: &Labels) -> Vec<Scope> {
    let mut scopes = Vec::new();
    for volume in volumes(records) {
        for measure in Measure::ALL {
            let curves = of_volume(records, labels, &volume, measure);
            scopes.push(Scope {
                volume: volume.clone(),
                view: String::new(),
                measure: measure.name(),
                curves,
            });
        }
        for view in views(records).into_iter().filter(|v| v.volume == volume) {
            let curves = of_view(records, labels, &view);
            scopes.push(Scope { volume: volume.clone(), view: View::name(&view), measure: PICTURE, curves });
        }
    }
    scopes.retain(|scope| scope.curves.len() > 1);
    scopes
}

/// Series that have a full curve somewhere; the first is the one that others are compared with unless the reader chooses.
fn anchors(scopes: &[Scope]) -> Vec<String> {
    let full = |named: &&Named| named.1.points() >= LEAST_POINTS;
    distinct(scopes.iter().flat_map(|s| s.curves.iter().filter(full).map(|named| named.0.clone())))
}

/// All series against one, where that one has a full curve.
fn against(scope: &Scope, anchor: &str) -> Vec<Difference> {
    let own = scope.curves.iter().find(|named| named.0 == anchor);
    let Some((_, own)) = own.filter(|named| named.1.points() >= LEAST_POINTS) else { return Vec::new() };
    let difference = |(series, curve): &(String, Curve)| Difference {
        anchor: anchor.to_owned(),
        series: series.clone(),
        points: [own.points(), curve.points()],
        log_rate: log_rate(own, curve),
        decibels: decibels(own, curve),
    };
    scope.curves.iter().filter(|named| named.0 != anchor).map(difference).collect()
}

fn signed(value: f64, decimals: usize) -> String {
    // What rounds to nothing has no sign.
    let text = fixed(Some(value), decimals);
    let nothing = text.chars().all(|c| !c.is_ascii_digit() || c == '0');
    if nothing {
        text.trim_start_matches('−').to_owned()
    } else if value > 0.0 {
        format!("+{text}")
    } else {
        text
    }
}

/// One cell of a table: a value, or why there is none.
fn shown(
    d: Option<&Difference>,
    of: fn(&Difference) -> Result<f64, Refused>,
    text: fn(f64) -> String,
) -> Value {
    let Some(d) = d else { return context! {} };
    let why = format!("{} and {} points", d.points[1], d.points[0]);
    match of(d) {
        Ok(value) => context! { text => text(value), why => why },
        Err(Refused::Few(points)) => context! { refused => format!("{points} points"), why => why },
        Err(refused @ Refused::Apart(share)) => {
            context! { refused => format!("{:.0} % overlap", 100.0 * share), why => refused.to_string() }
        }
    }
}

fn rate_text(log_rate: f64) -> String {
    signed(percent(log_rate), 1)
}

fn decibel_text(decibels: f64) -> String {
    signed(decibels, 2)
}

/// The tables, one for each anchor. The page shows the first and folds the others.
pub(super) fn tables(records: &[Record], labels: &Labels) -> Vec<Value> {
    let scopes = scopes(records, labels);
    let table = |anchor: String| {
        let all: Vec<(&Scope, Difference)> =
            scopes.iter().flat_map(|s| against(s, &anchor).into_iter().map(move |d| (s, d))).collect();
        let rows: Vec<Value> = distinct(all.iter().map(|(s, _)| s.volume.clone()))
            .iter()
            .flat_map(|v| of_volume_rows(v, &all))
            .collect();
        let series = distinct(all.iter().map(|(_, d)| d.series.clone()));
        // A mean of one is none.
        let several = of_several(all.iter().map(|(scope, _)| *scope));
        let means: Vec<Value> = series.iter().filter(|_| several).map(|series| means(series, &all)).collect();
        (!all.is_empty()).then(|| context! { anchor => anchor, rows => rows, means => means })
    };
    anchors(&scopes).into_iter().filter_map(table).collect()
}

/// Whether these are of several volumes, or of several views of one.
fn of_several<'a>(scopes: impl Iterator<Item = &'a Scope>) -> bool {
    let all: Vec<&Scope> = scopes.collect();
    let views = all.iter().filter(|s| s.measure == PICTURE).map(|s| s.view.clone());
    distinct(all.iter().map(|s| s.volume.clone())).len() > 1 || distinct(views).len() > 1
}

/// One row per series and view. Values without a view are in the first row.
fn of_volume_rows(volume: &str, all: &[(&Scope, Difference)]) -> Vec<Value> {
    let own = || all.iter().filter(|(s, _)| s.volume == volume);
    let mut views = distinct(own().filter(|(s, _)| s.measure == PICTURE).map(|(s, _)| s.view.clone()));
    if views.is_empty() {
        views.push(String::new());
    }
    let mut rows = Vec::new();
    for series in distinct(own().map(|(_, d)| d.series.clone())) {
        for (i, view) in views.iter().enumerate() {
            let find = |measure: &str, view: &str| {
                let found = own().find(|(s, d)| s.measure == measure && s.view == view && d.series == series);
                found.map(|(_, d)| d)
            };
            let [voxels, foreground] = Measure::ALL.map(|m| find(m.name(), "").filter(|_| i == 0));
            let cells = [voxels, foreground, find(PICTURE, view)]
                .map(|d| [shown(d, |d| d.log_rate, rate_text), shown(d, |d| d.decibels, decibel_text)]);
            let view = if views.len() > 1 { view.as_str() } else { "" };
            rows.push(
                context! { volume => volume, view => view, series => series.clone(), cells => cells.concat() },
            );
        }
    }
    rows
}

/// The means of a series over the volumes and views that have the difference, and the number of these.
fn means(series: &str, all: &[(&Scope, Difference)]) -> Value {
    let cell = |measure: &str, of: fn(&Difference) -> Result<f64, Refused>, text: fn(f64) -> String| {
        let own = || all.iter().filter(|(s, d)| s.measure == measure && d.series == series);
        let told: Vec<f64> = own().filter_map(|(_, d)| of(d).ok()).collect();
        let (n, every) = (told.len(), own().count());
        if n == 0 {
            return context! { refused => if every > 0 { "–" } else { "" } };
        }
        let mean = told.iter().sum::<f64>() / n as f64;
        context! { text => text(mean), of => (n < every).then(|| format!("{n} of {every}")), why => format!("over {n} of {every}") }
    };
    let [voxels, foreground] = Measure::ALL.map(Measure::name);
    let cells = [voxels, foreground, PICTURE]
        .map(|m| [cell(m, |d| d.log_rate, rate_text), cell(m, |d| d.decibels, decibel_text)]);
    context! { series => series, cells => cells.concat() }
}

/// Every pair, in full precision. A refused value is empty, and the reason is next to it.
pub(super) fn sheet(records: &[Record], labels: &Labels) -> Option<Sheet> {
    let scopes = scopes(records, labels);
    let mut sheet = Sheet::new(&[
        "volume",
        "view",
        "measure",
        "anchor",
        "series",
        "anchor_points",
        "points",
        "bd_rate_percent",
        "bd_psnr_db",
        "bd_rate_refused",
        "bd_psnr_refused",
    ]);
    for anchor in anchors(&scopes) {
        for (scope, d) in scopes.iter().flat_map(|s| against(s, &anchor).into_iter().map(move |d| (s, d))) {
            let value = |v: Result<f64, Refused>| v.map(|v| v.to_string()).unwrap_or_default();
            let why = |v: Result<f64, Refused>| v.err().map(|e| e.to_string()).unwrap_or_default();
            let words = [&scope.volume, &scope.view, scope.measure, &d.anchor, &d.series].map(str::to_owned);
            let counts = d.points.map(|n| n.to_string());
            let rest = [value(d.log_rate.map(percent)), value(d.decibels), why(d.log_rate), why(d.decibels)];
            sheet.row(words.into_iter().chain(counts).chain(rest));
        }
    }
    (!sheet.rows.is_empty()).then_some(sheet)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::record::tests::record;

    /// Two volumes; `vq` is 2 dB better in all voxels and 1 dB in the foreground, and `hvq` has two points.
    fn records() -> Vec<Record> {
        let mut records = Vec::new();
        for volume in ["a", "b"] {
            for (codec, better, settings) in
                [("s3dc", 0.0, 5), ("vq", 2.0, 5), ("hvq", 9.0, 2), ("raw", 50.0, 5)]
            {
                for i in 0..settings {
                    let (rate, psnr) = (2f64.powi(i), 30.0 + 5.0 * f64::from(i) + better);
                    records.push(Record {
                        settings: i.to_string(),
                        bits_per_voxel: Some(rate),
                        psnr_db: Some(psnr),
                        foreground_psnr_db: Some(psnr - 3.0 - better / 2.0),
                        ..record(volume, codec)
                    });
                }
            }
        }
        records
    }

    fn sheet_of(records: &[Record]) -> Option<Sheet> {
        sheet(records, &Labels::of(records))
    }

    fn tables_of(records: &[Record]) -> Vec<Value> {
        tables(records, &Labels::of(records))
    }

    #[test]
    fn methods_of_one_codec_are_compared_as_two_codecs_are() {
        let cells = |payload: &str, better: f64| {
            let one = |i: i32| Record {
                settings: format!("payload={payload} rate={i}"),
                series: format!("payload={payload}"),
                bits_per_voxel: Some(2f64.powi(i)),
                psnr_db: Some(30.0 + 5.0 * f64::from(i) + better),
                ..record("a", "tvq")
            };
            (0..5).map(one).collect::<Vec<_>>()
        };
        let records = [cells("fixed", 0.0), cells("variable", 3.0)].concat();
        let rows = sheet_of(&records).unwrap().rows;
        let told: Vec<_> =
            rows.iter().map(|r| (r[3].as_str(), r[4].as_str(), r[8].parse::<f64>().unwrap())).collect();
        assert_eq!(told.len(), 2);
        assert_eq!((told[0].0, told[0].1), ("tvq payload=fixed", "tvq payload=variable"));
        assert!((told[0].2 - 3.0).abs() < 1e-9 && (told[1].2 + 3.0).abs() < 1e-9, "{told:?}");
        let unmarked: Vec<Record> =
            records.iter().map(|r| Record { series: String::new(), ..r.clone() }).collect();
        assert!(sheet_of(&unmarked).is_none(), "one codec that lists no method is one curve");
    }

    #[test]
    fn every_pair_with_a_full_anchor_is_told_per_volume_and_as_a_mean() {
        let sheet = sheet_of(&records()).unwrap();
        let find = |volume: &str, measure: &str, anchor: &str, codec: &str| {
            let row = sheet
                .rows
                .iter()
                .find(|r| r[0] == volume && r[2] == measure && r[3] == anchor && r[4] == codec);
            row.map(|r| (r[7].parse::<f64>().ok(), r[8].parse::<f64>().ok(), r[9].clone()))
        };
        let (rate, decibels, refused) = find("b", "all voxels", "s3dc", "vq").unwrap();
        assert!((decibels.unwrap() - 2.0).abs() < 1e-9 && refused.is_empty());
        assert!((rate.unwrap() - percent(-0.4 * 2f64.log10())).abs() < 1e-9);
        let (_, decibels, _) = find("b", "without empty blocks", "vq", "s3dc").unwrap();
        assert!((decibels.unwrap() + 1.0).abs() < 1e-9, "the other way round");
        let (rate, decibels, refused) = find("a", "all voxels", "s3dc", "hvq").unwrap();
        assert_eq!((rate, decibels, refused.as_str()), (None, None, "a curve of 2 points, 4 are needed"));
        assert_eq!(find("a", "all voxels", "hvq", "vq"), None, "no full curve, no anchor");
        assert!(!sheet.rows.iter().any(|r| r[3] == "raw" || r[4] == "raw"));

        let tables = tables_of(&records());
        assert_eq!(tables.len(), 2);
        let first = &tables[0];
        assert_eq!(first.get_attr("anchor").unwrap().as_str(), Some("s3dc"));
        // Over both volumes: BD-rate and BD-PSNR of all voxels and of the foreground, and pictures that there are none of.
        let mean = first.get_attr("means").unwrap().get_item_by_index(0).unwrap();
        assert_eq!(mean.get_attr("series").unwrap().as_str(), Some("vq"));
        let cells = mean.get_attr("cells").unwrap();
        let text = |i: usize| cells.get_item_by_index(i).unwrap().get_attr("text").unwrap().to_string();
        assert_eq!([text(0), text(1), text(2), text(3)], ["−24.2", "+2.00", "−12.9", "+1.00"]);
        assert_eq!(cells.get_item_by_index(1).unwrap().get_attr("why").unwrap().to_string(), "over 2 of 2");
        let row = first.get_attr("rows").unwrap().get_item_by_index(1).unwrap();
        let cell = row.get_attr("cells").unwrap().get_item_by_index(0).unwrap();
        assert_eq!(cell.get_attr("refused").unwrap().as_str(), Some("2 points"));
    }

    #[test]
    fn without_two_curves_there_is_no_table() {
        assert!(tables_of(&[]).is_empty() && sheet_of(&[]).is_none());
        let alone: Vec<Record> = records().into_iter().filter(|r| r.codec == "vq").collect();
        assert!(tables_of(&alone).is_empty() && sheet_of(&alone).is_none());
    }

    #[test]
    fn signs_are_told_but_for_nothing() {
        assert_eq!(signed(1.234, 1), "+1.2");
        assert_eq!(signed(-1.26, 1), "−1.3");
        assert_eq!(signed(-0.001, 1), "0.0");
    }
}
