//! Marks: shapes that stay apart without colour.

use std::fmt::Write;

use super::Colour;

/// Radius of a mark.
pub(super) const RADIUS: f64 = 5.2;

/// Outline of a mark.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Shape {
    /// ●
    Circle,
    /// ■
    Square,
    /// ▲
    TriangleUp,
    /// ◆
    Diamond,
    /// ▼
    TriangleDown,
    /// ⬟
    Pentagon,
    /// ★
    Star,
    /// ⬢
    Hexagon,
    /// ✕, for failures alone.
    Cross,
    /// A letter in a ring, for baselines.
    Letter(char),
}

/// How one mark looks.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Mark {
    /// Outline.
    pub shape: Shape,
    /// Colour.
    pub colour: Colour,
    /// Filled, or an outline alone.
    pub filled: bool,
    /// Drawn in grey because another mark beats it. Its shape still shows the series.
    pub faint: bool,
}

impl Shape {
    /// The shape of the `i`-th series; after eight they repeat.
    #[must_use]
    pub const fn series(i: usize) -> Self {
        [
            Self::Circle,
            Self::Square,
            Self::TriangleUp,
            Self::Diamond,
            Self::TriangleDown,
            Self::Pentagon,
            Self::Star,
            Self::Hexagon,
        ][i % 8]
    }

    /// Corners on a circle around the origin, as (turn, radius); shapes are of about equal area.
    fn corners(self) -> Vec<(f64, f64)> {
        let regular = |n: usize, start: f64, radius: f64| {
            (0..n).map(|i| (start + i as f64 / n as f64, radius)).collect::<Vec<_>>()
        };
        match self {
            Self::Square => regular(4, 0.125, 1.22),
            Self::TriangleUp => regular(3, 0.0, 1.4),
            Self::TriangleDown => regular(3, 0.5, 1.4),
            Self::Diamond => regular(4, 0.0, 1.3),
            Self::Pentagon => regular(5, 0.0, 1.15),
            Self::Hexagon => regular(6, 0.0, 1.1),
            Self::Star => (0..10).map(|i| (i as f64 / 10.0, if i % 2 == 0 { 1.5 } else { 0.65 })).collect(),
            Self::Circle | Self::Cross | Self::Letter(_) => Vec::new(),
        }
    }
}

impl Mark {
    /// A filled mark.
    #[must_use]
    pub const fn filled(shape: Shape, colour: Colour) -> Self {
        Self { shape, colour, filled: true, faint: false }
    }

    /// A failure.
    #[must_use]
    pub const fn failure() -> Self {
        Self { shape: Shape::Cross, colour: Colour::Failure, filled: false, faint: false }
    }

    /// SVG path of radius `r` around a point.
    #[must_use]
    pub(super) fn path(&self, x: f64, y: f64, r: f64) -> String {
        let mut d = String::new();
        match self.shape {
            Shape::Circle | Shape::Letter(_) => {
                let r = if self.shape == Shape::Circle { r } else { r * 1.75 };
                let _ = write!(
                    d,
                    "M{:.2},{y:.2}a{r:.2},{r:.2} 0 1,0 {:.2},0a{r:.2},{r:.2} 0 1,0 -{:.2},0Z",
                    x - r,
                    2.0 * r,
                    2.0 * r
                );
            }
            Shape::Cross => {
                let s = r * 1.05;
                let (l, t, e, b) = (x - s, y - s, x + s, y + s);
                let _ = write!(d, "M{l:.2},{t:.2}L{e:.2},{b:.2}M{l:.2},{b:.2}L{e:.2},{t:.2}");
            }
            shape => {
                for (i, (turn, radius)) in shape.corners().into_iter().enumerate() {
                    let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
                    let command = if i == 0 { 'M' } else { 'L' };
                    let _ = write!(d, "{command}{:.2},{:.2}", x + r * radius * sin, y - r * radius * cos);
                }
                d.push('Z');
            }
        }
        d
    }

    /// SVG path around the origin, of the size that charts have.
    #[must_use]
    pub fn path_at_origin(&self) -> String {
        self.path(0.0, 0.0, RADIUS)
    }

    /// Fill and stroke as CSS values.
    #[must_use]
    pub fn paint(&self) -> (String, String) {
        let colour = if self.faint { "var(--beaten)".to_owned() } else { self.colour.css() };
        match self.shape {
            Shape::Cross => ("none".to_owned(), colour),
            _ if self.filled => (colour, "var(--paper)".to_owned()),
            _ => ("var(--paper)".to_owned(), colour),
        }
    }

    /// Width of the stroke: that of a filled mark only sets it off from its neighbours.
    #[must_use]
    pub const fn stroke_width(&self) -> f64 {
        match self.shape {
            Shape::Cross => 2.4,
            _ if self.filled => 0.8,
            _ => 1.7,
        }
    }

    /// The mark as a drawing of its own, for legends. It holds no text from outside.
    #[must_use]
    pub fn svg(&self) -> String {
        let (fill, stroke) = self.paint();
        let mut svg = format!(
            "<svg class=\"mark{}\" viewBox=\"-9 -9 18 18\" aria-hidden=\"true\">\
             <path d=\"{}\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"{}\"/>",
            if self.faint { " faint" } else { "" },
            self.path(0.0, 0.0, 4.6),
            self.stroke_width()
        );
        if let Shape::Letter(letter @ 'A'..='Z') = self.shape {
            let _ = write!(
                svg,
                "<text y=\"3.6\" font-size=\"10\" font-weight=\"bold\" text-anchor=\"middle\" \
                 fill=\"{}\">{letter}</text>",
                self.colour.css()
            );
        }
        svg.push_str("</svg>");
        svg
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_series_have_eight_outlines() {
        let paths: std::collections::BTreeSet<_> =
            (0..8).map(|i| Mark::filled(Shape::series(i), Colour::Ink).path(0.0, 0.0, 5.0)).collect();
        assert_eq!(paths.len(), 8);
        assert!(!paths.contains(&Mark::failure().path(0.0, 0.0, 5.0)));
    }
}
