//! A chart as a file of its own, for papers and slides: colours written out, the legend below.

use std::fmt::Write;

use super::Chart;
use super::draw::{HEADROOM, SIZE};

/// Height of a line of the legend.
const LINE: f64 = 20.0;
/// Space around the drawing.
const MARGIN: f64 = 12.0;

impl Chart {
    /// The drawing as an SVG file. `style` is the page's, whose first rule defines the colours; programs other than
    /// browsers know no variables.
    #[must_use]
    pub fn svg_file(&self, title: &str, style: &str) -> String {
        let drawing = self.drawing();
        let body = drawing.split_once('>').map_or("", |(_, body)| body);
        let body = body.strip_suffix("</svg>").unwrap_or(body);
        let [width, height] = SIZE;
        let below = height + LINE * self.legend.len() as f64 + MARGIN;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"-{MARGIN} -{2} {0} {1}\" \
             font-family=\"Liberation Sans, DejaVu Sans, Helvetica, Arial, sans-serif\" fill=\"var(--ink)\">\
             <title>{3}</title><desc>{4}</desc><rect x=\"-{MARGIN}\" y=\"-{2}\" width=\"{0}\" height=\"{1}\" \
             fill=\"var(--paper)\"/>{body}",
            width + 2.0 * MARGIN,
            below + HEADROOM + MARGIN,
            HEADROOM + MARGIN,
            escaped(title),
            escaped(&self.description)
        );
        for (i, entry) in self.legend.iter().enumerate() {
            let (x, y) = (70.0, height + LINE * (i as f64 + 0.5));
            let (fill, stroke) = entry.mark.paint();
            let _ = write!(
                svg,
                "<g transform=\"translate({x},{y})\"><path d=\"{}\" fill=\"{fill}\" stroke=\"{stroke}\" \
                 stroke-width=\"{}\"/>",
                entry.mark.path_at_origin(),
                entry.mark.stroke_width()
            );
            if let super::Shape::Letter(letter @ 'A'..='Z') = entry.mark.shape {
                let _ = write!(
                    svg,
                    "<text y=\"4.2\" font-size=\"12\" font-weight=\"bold\" text-anchor=\"middle\">{letter}</text>"
                );
            }
            let label = escaped(&entry.label);
            let _ = write!(svg, "<text x=\"16\" y=\"4.5\" font-size=\"13\">{label}</text></g>");
        }
        let svg = svg.replace("class=\"pt faint\"", "").replace("class=\"pt\"", "");
        with_colours(svg + "</svg>\n", style)
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Writes out the variables of a style sheet's first rule.
fn with_colours(mut svg: String, style: &str) -> String {
    let rule = style.split_once(":root {").and_then(|(_, rest)| rest.split_once('}')).map_or("", |(r, _)| r);
    for declaration in rule.split(';') {
        if let Some((name, value)) = declaration.split_once(':')
            && value.trim().starts_with('#')
        {
            svg = svg.replace(&format!("var({})", name.trim()), value.trim());
        }
    }
    svg
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Colour, LegendEntry, Line, Mark, Point, Scale, Shape};
    use super::*;

    #[test]
    fn a_file_has_colours_a_legend_and_no_variable() {
        let mark = Mark { faint: true, ..Mark::filled(Shape::Letter('A'), Colour::Series(7)) };
        let evil = "</text><script>alert(1)</script>";
        let chart = Chart {
            description: evil.into(),
            x: Axis::new("bits_per_voxel", "bits per voxel", Scale::Log),
            y: Axis::new("psnr_db", "PSNR", Scale::Linear),
            lines: vec![Line {
                points: vec![(1.0, 30.0), (2.0, 40.0)],
                colour: Colour::Failure,
                dashed: true,
            }],
            points: vec![Point { x: 1.0, y: 30.0, mark, title: evil.into(), cell: Some(0), unbeaten: true }],
            legend: vec![LegendEntry { mark, label: evil.into() }],
        };
        let svg = chart.svg_file(evil, include_str!("../style.css"));
        assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" ") && svg.ends_with("</svg>\n"));
        for wrong in ["var(", "<script", "class=", "NaN"] {
            assert!(!svg.contains(wrong), "{wrong}: {svg}");
        }
        assert!(svg.contains("#a8a8a4") && svg.contains("#c1121f"));
        let mut reader = quick_xml::Reader::from_str(&svg);
        loop {
            if matches!(reader.read_event().unwrap(), quick_xml::events::Event::Eof) {
                break;
            }
        }
    }
}
