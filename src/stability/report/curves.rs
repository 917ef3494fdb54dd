//! A curve per dial: the worst picture of each codec over the steps; and PSNR over generations.

use cvr_core::stability::{Subject, Verdict};

use crate::report::chart::{Axis, Chart, Colour, LegendEntry, Line, Mark, Point, Scale, Shape};
use crate::stability::atlas::Atlas;
use crate::stability::encoder::EncoderMeasured;
use crate::stability::row::{Row, VOXELS};

/// A chart with its name as a file and its title.
pub struct Curve {
    /// Name without ending.
    pub name: String,
    /// Title.
    pub title: String,
    /// The chart.
    pub chart: Chart,
}

/// Colour and shape of each label: codecs have colours, their settings shapes.
struct Series(Vec<(String, String)>);

impl Series {
    /// Curves by pair of codec and label.
    fn of<'a>(pairs: impl Iterator<Item = (&'a str, &'a str)>) -> Self {
        let mut all: Vec<(String, String)> = pairs.map(|(c, l)| (c.to_owned(), l.to_owned())).collect();
        all.sort();
        all.dedup();
        Self(all)
    }

    fn mark(&self, label: &str) -> Mark {
        let mut codecs: Vec<&str> = self.0.iter().map(|(codec, _)| codec.as_str()).collect();
        codecs.dedup();
        let own = self.0.iter().find(|(_, l)| l == label).map_or("", |(codec, _)| codec);
        let colour = codecs.iter().position(|c| *c == own).unwrap_or(0) + 1;
        let among = self.0.iter().filter(|(codec, _)| codec == own).position(|(_, l)| l == label);
        Mark::filled(Shape::series(among.unwrap_or(0)), Colour::Series(colour))
    }

    fn legend(&self) -> Vec<LegendEntry> {
        self.0.iter().map(|(_, l)| LegendEntry { mark: self.mark(l), label: l.clone() }).collect()
    }
}

/// One curve per subject. `raw`, which is exact, has none.
pub fn dials(atlas: &Atlas) -> Vec<Curve> {
    let compressed = || atlas.rows.iter().filter(|r| r.codec != crate::experiment::measured::reference::RAW);
    Subject::all()
        .filter_map(|subject| {
            let rows: Vec<&Row> = compressed().filter(|r| r.subject == subject.name).collect();
            let series = Series::of(rows.iter().map(|r| (r.codec.as_str(), r.label.as_str())));
            let chart = dial(subject, &rows, &series);
            (!chart.points.is_empty()).then(|| Curve {
                name: format!("dial-{}", subject.name),
                title: subject.name.to_owned(),
                chart,
            })
        })
        .collect()
}

fn dial(subject: &Subject, rows: &[&Row], series: &Series) -> Chart {
    let (mut lines, mut points) = (Vec::new(), Vec::new());
    for (_, label) in &series.0 {
        let mark = series.mark(label);
        let mut line = Vec::new();
        for (index, value) in subject.steps.iter().enumerate() {
            let at = || rows.iter().filter(|r| r.label == *label && r.step == index + 1);
            let pictures = || at().filter(|r| r.scene != VOXELS && r.image_rmse.is_some());
            // PSNR is missing where a picture is identical.
            let psnr = |r: &Row| r.image_psnr_db.unwrap_or(f64::INFINITY);
            let Some(worst) = pictures().min_by(|a, b| psnr(a).total_cmp(&psnr(b))) else { continue };
            let verdict = at().map(|r| r.verdict).max().unwrap_or(Verdict::Holds);
            let (x, y) = ((index + 1) as f64, psnr(worst));
            line.push((x, y));
            let mark = match verdict {
                Verdict::Fails => Mark { shape: Shape::Cross, filled: false, ..mark },
                Verdict::Degrades => Mark { filled: false, ..mark },
                Verdict::Holds | Verdict::Refused => mark,
            };
            let title = format!(
                "{label}, {} at {value}: {verdict}\nworst picture: {}, {y:.1} dB",
                subject.name, worst.scene
            );
            points.push(Point { x, y, mark, title, cell: None, unbeaten: false });
        }
        lines.push(Line { points: line, colour: mark.colour, dashed: mark.shape != Shape::series(0) });
    }
    let values: Vec<String> = subject.steps.iter().map(|v| super::dial_value(*v)).collect();
    let x = Axis { include: vec![1.0], ..Axis::new("step", "step of the dial  (harder →)", Scale::Linear) };
    let y = Axis {
        infinity: Some("identical"),
        // If all pictures are identical, the axis still has its name.
        include: vec![20.0, 60.0],
        ..Axis::new("image_psnr_db", "PSNR of the worst picture in dB  (better →)", Scale::Linear)
    };
    let description = format!(
        "PSNR of the worst picture over the dial. {}: {}. Hollow: degrades. Cross: fails in a scene or in voxels.",
        subject.dial,
        values.join(", ")
    );
    Chart { description, x, y, lines, points, legend: series.legend() }
}

/// PSNR over generations, one chart per subject.
pub fn generations(encoders: &[EncoderMeasured]) -> Vec<Curve> {
    let mut subjects: Vec<&str> = encoders.iter().map(|e| e.subject.as_str()).collect();
    subjects.dedup();
    subjects
        .into_iter()
        .filter_map(|subject| {
            let own: Vec<&EncoderMeasured> = encoders
                .iter()
                .filter(|e| {
                    e.subject == subject
                        && !e.generations.is_empty()
                        && e.codec != crate::experiment::measured::reference::RAW
                })
                .collect();
            let series = Series::of(own.iter().map(|e| (e.codec.as_str(), e.label.as_str())));
            let (mut lines, mut points) = (Vec::new(), Vec::new());
            for encoder in &own {
                let mark = series.mark(&encoder.label);
                let place =
                    |(i, psnr): (usize, &Option<f64>)| ((i + 1) as f64, psnr.unwrap_or(f64::INFINITY));
                let line: Vec<(f64, f64)> = encoder.generations.iter().enumerate().map(place).collect();
                points.extend(line.iter().map(|&(x, y)| Point {
                    x,
                    y,
                    mark,
                    title: format!("{}, generation {x}: {y:.2} dB", encoder.label),
                    cell: None,
                    unbeaten: false,
                }));
                lines.push(Line {
                    points: line,
                    colour: mark.colour,
                    dashed: mark.shape != Shape::series(0),
                });
            }
            let x = Axis { include: vec![1.0], ..Axis::new("generation", "generation", Scale::Linear) };
            let y = Axis {
                infinity: Some("identical"),
                ..Axis::new("psnr_db", "PSNR against the original in dB  (better →)", Scale::Linear)
            };
            let chart = Chart {
                description: format!(
                    "PSNR of {subject} when what was decoded is encoded again, generation by generation"
                ),
                x,
                y,
                lines,
                points,
                legend: series.legend(),
            };
            (!chart.points.is_empty()).then(|| Curve {
                name: format!("generations-{subject}"),
                title: format!("Generations of {subject}"),
                chart,
            })
        })
        .collect()
}
