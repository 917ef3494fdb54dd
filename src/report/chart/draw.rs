//! From a chart to SVG: kuva's axes, our marks, the page's colours.

use kuva::Theme;
use kuva::backend::svg::SvgBackend;
use kuva::render::axis::{add_axes_and_grid, add_labels_and_title};
use kuva::render::color::Color;
use kuva::render::layout::{AxisLabelOverlap, ComputedLayout, Layout};
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use super::axis::Range;
use super::mark::RADIUS;
use super::{Axis, Chart, Point, Scale, Shape};

/// Width and height of a drawing in its own units, which are pixels at full size.
pub const SIZE: [f64; 2] = [560.0, 400.0];
/// The label of the topmost tick sticks out by half its height.
pub(super) const HEADROOM: f64 = 8.0;

impl Chart {
    /// The drawing, to be set into HTML: no namespace, no size, colours from the page.
    #[must_use]
    pub fn svg(&self) -> String {
        in_page(&self.drawing())
    }

    /// The drawing as kuva writes it, with colours from the page.
    pub(super) fn drawing(&self) -> String {
        let xs = self
            .points
            .iter()
            .map(|p| p.x)
            .chain(self.lines.iter().flat_map(|l| l.points.iter().map(|p| p.0)));
        let ys = self
            .points
            .iter()
            .map(|p| p.y)
            .chain(self.lines.iter().flat_map(|l| l.points.iter().map(|p| p.1)));
        let (x, y) = (Range::of(&self.x, xs), Range::of(&self.y, ys));
        let layout = layout(self, &x, &y);
        let computed = ComputedLayout::from_layout(&layout);
        let mut scene = Scene::new(computed.width, computed.height);
        scene.background_color = None;
        add_axes_and_grid(&mut scene, &computed, &layout);
        add_labels_and_title(&mut scene, &computed, &layout);
        let place = |px: f64, py: f64| (computed.map_x(x.place(px)), computed.map_y(y.place(py)));
        let shown = |px: f64, py: f64| self.x.shows(px) && self.y.shows(py);
        for line in &self.lines {
            let points = line.points.iter().filter(|p| shown(p.0, p.1)).map(|p| place(p.0, p.1));
            scene.add(Primitive::PolyLine {
                points: points.collect(),
                stroke: Color::from(line.colour.css()),
                stroke_width: 1.6,
                stroke_dasharray: line.dashed.then(|| "6 4".to_owned()),
            });
        }
        for point in self.points.iter().filter(|p| shown(p.x, p.y)) {
            let (px, py) = place(point.x, point.y);
            add_mark(&mut scene, point, px, py);
        }
        SvgBackend::new().render_scene(&scene)
    }
}

fn layout(chart: &Chart, x: &Range, y: &Range) -> Layout {
    let theme = Theme {
        background: "none".into(),
        axis_color: "var(--axis)".into(),
        grid_color: "var(--grid)".into(),
        tick_color: "var(--axis)".into(),
        text_color: "var(--ink)".into(),
        ..Theme::light()
    };
    let mut layout = Layout::new((x.low, x.high), (y.low, y.high))
        .with_width(SIZE[0])
        .with_height(SIZE[1])
        .with_x_axis_min(x.low)
        .with_x_axis_max(x.high)
        .with_y_axis_min(y.low)
        .with_y_axis_max(y.high)
        .with_x_label(chart.x.label.as_str())
        .with_y_label(chart.y.label.as_str())
        .with_x_tick_format(x.format())
        .with_y_tick_format(y.format())
        .with_x_label_overlap(AxisLabelOverlap::Thin)
        .with_label_size(14)
        .with_tick_size(13)
        .with_grid_line_width(1.0)
        .with_axis_line_width(1.0)
        .with_theme(theme);
    let log = |axis: &Axis| axis.scale == Scale::Log;
    if log(&chart.x) {
        layout = layout.with_log_x();
    }
    if log(&chart.y) {
        layout = layout.with_log_y();
    }
    if let Some(step) = x.step {
        layout = layout.with_x_tick_step(step);
    }
    if let Some(step) = y.step {
        layout = layout.with_y_tick_step(step);
    }
    layout
}

fn add_mark(scene: &mut Scene, point: &Point, x: f64, y: f64) {
    let mark = point.mark;
    let (fill, stroke) = mark.paint();
    // Pushed past `Scene::add`, which would bring a style sheet for titles into every drawing.
    let faint = if mark.faint { " faint" } else { "" };
    let cell = point.cell.map(|cell| format!(" data-cell=\"{cell}\"")).unwrap_or_default();
    let attributes = format!("class=\"pt{faint}\"{cell}");
    scene.elements.push(Primitive::GroupStart {
        transform: None,
        title: Some(point.title.clone()),
        extra_attrs: Some(attributes),
    });
    scene.elements.push(Primitive::Path(Box::new(PathData {
        d: mark.path(x, y, RADIUS),
        fill: Some(Color::from(fill)),
        stroke: Color::from(stroke),
        stroke_width: mark.stroke_width(),
        opacity: None,
        stroke_dasharray: None,
    })));
    if let Shape::Letter(letter) = mark.shape {
        scene.elements.push(Primitive::Text {
            x,
            y: y + 4.2,
            content: letter.to_string(),
            size: 12,
            anchor: TextAnchor::Middle,
            rotate: None,
            bold: true,
            color: Some(Color::from(mark.paint().1)),
        });
    }
    scene.elements.push(Primitive::GroupEnd);
}

/// Replaces the opening tag of a stand-alone drawing: within a page it scales and needs no namespace.
fn in_page(svg: &str) -> String {
    let body = svg.split_once('>').map_or("", |(_, body)| body);
    let [width, height] = SIZE;
    format!("<svg class=\"chart\" viewBox=\"0 -{HEADROOM} {width} {}\">{body}", height + HEADROOM)
}

#[cfg(test)]
mod tests {
    use super::super::{Colour, Line, Mark};
    use super::*;

    fn chart(points: Vec<Point>) -> Chart {
        Chart {
            description: "a \"chart\" of <things>".into(),
            x: Axis::new("field", "bits per voxel", Scale::Log),
            y: Axis { infinity: Some("lossless"), ..Axis::new("field", "PSNR", Scale::Linear) },
            lines: vec![Line { points: vec![(1.0, 30.0), (2.0, 40.0)], colour: Colour::Ink, dashed: true }],
            points,
            legend: Vec::new(),
        }
    }

    fn point(x: f64, y: f64, title: &str) -> Point {
        Point {
            x,
            y,
            mark: Mark::filled(Shape::Circle, Colour::Series(1)),
            title: title.into(),
            cell: Some(7),
            unbeaten: false,
        }
    }

    #[test]
    fn marks_infinity_and_leaves_out_what_has_no_place() {
        let svg = chart(vec![
            point(2.0, f64::INFINITY, "lossless one"),
            point(0.0, 30.0, "no place on a log axis"),
            point(1.0, f64::NAN, "no number"),
        ])
        .svg();
        assert!(svg.contains("lossless one") && svg.contains(">lossless</text>"));
        assert!(!svg.contains("no place") && !svg.contains("no number") && !svg.contains("NaN"));
    }

    #[test]
    fn escapes_and_takes_colours_from_the_page() {
        let svg = chart(vec![point(1.0, 30.0, "<script>alert(1)</script>")]).svg();
        assert!(!svg.contains("<script>") && svg.contains("&lt;script&gt;"));
        assert!(svg.contains("var(--c1)") && svg.contains("var(--grid)") && !svg.contains("http"));
        assert!(!svg.contains("black") && !svg.contains("#000") && !svg.contains("white"));
    }

    #[test]
    fn an_empty_chart_is_a_chart() {
        let mut empty = chart(Vec::new());
        empty.lines.clear();
        assert!(empty.svg().starts_with("<svg class=\"chart\"") && empty.svg().ends_with("</svg>"));
    }
}
