//! A source text as an error quotes it. Of a long line, only the surroundings of the marked places are shown: a text
//! from outside may be one line of megabytes.

use std::ops::Range;

use codespan_reporting::files::{Error, Files};

/// Longest line that is quoted whole, in bytes.
const LONGEST_LINE: usize = 240;
/// Bytes quoted before and behind a place in a long line.
const AROUND: usize = 40;
const LEFT_OUT: &str = "…";

/// One text, cut.
pub(super) struct Quoted {
    name: String,
    original: String,
    cut: String,
    /// Start of each line in the shortened text.
    lines: Vec<usize>,
    pieces: Vec<Piece>,
}

/// Bytes that both texts have.
struct Piece {
    /// In the original.
    from: Range<usize>,
    /// Their start in the shortened text.
    to: usize,
}

impl Quoted {
    /// `places` are byte positions in the text that errors point at.
    pub fn new(name: String, original: String, places: &[usize]) -> Self {
        let mut quoted =
            Self { name, original: String::new(), cut: String::new(), lines: vec![0], pieces: Vec::new() };
        let mut at = 0;
        for line in original.split_inclusive('\n') {
            let text = line.strip_suffix('\n').unwrap_or(line);
            quoted.line(&original, at..at + text.len(), places);
            at += line.len();
            if text.len() < line.len() {
                // The line break belongs to the line before it.
                quoted.piece(&original, at - 1..at);
                quoted.lines.push(quoted.cut.len());
            }
        }
        quoted.original = original;
        quoted
    }

    fn piece(&mut self, original: &str, from: Range<usize>) {
        let to = self.cut.len();
        self.cut.push_str(&original[from.clone()]);
        self.pieces.push(Piece { from, to });
    }

    fn line(&mut self, original: &str, line: Range<usize>, places: &[usize]) {
        if line.len() <= LONGEST_LINE {
            self.piece(original, line);
            return;
        }
        let inside = places.iter().copied().filter(|at| line.start <= *at && *at <= line.end);
        let mut places: Vec<usize> = inside.collect();
        if places.is_empty() {
            places.push(line.start);
        }
        places.sort_unstable();
        let mut windows: Vec<Range<usize>> = Vec::new();
        for at in places {
            let start = original.floor_char_boundary(at.saturating_sub(AROUND).max(line.start));
            let end = original.ceil_char_boundary((at + AROUND).min(line.end));
            match windows.last_mut() {
                Some(last) if start <= last.end => last.end = end,
                _ => windows.push(start..end),
            }
        }
        let mut at = line.start;
        for window in windows {
            if window.start > at {
                self.cut.push_str(LEFT_OUT);
            }
            at = window.end;
            self.piece(original, window);
        }
        if at < line.end {
            self.cut.push_str(LEFT_OUT);
        }
    }

    /// Range in the shortened text for a range of the original, as far as the line is quoted.
    pub fn span(&self, original: Range<usize>) -> Range<usize> {
        let at = self.pieces.partition_point(|piece| piece.from.start <= original.start).saturating_sub(1);
        let place = |position: usize, piece: &Piece| {
            piece.to + (position.clamp(piece.from.start, piece.from.end) - piece.from.start)
        };
        let Some(piece) = self.pieces.get(at) else { return 0..0 };
        let start = place(original.start, piece);
        let last = self.pieces.partition_point(|piece| piece.from.start <= original.end).saturating_sub(1);
        let is_one_line = !self.original[original.clone()].contains('\n');
        let end = match self.pieces.get(last) {
            Some(last) if !is_one_line => place(original.end, last),
            _ => place(original.end, piece),
        };
        start..end.max(start)
    }

    /// Position in the original for a position in the shortened text.
    fn original(&self, cut: usize) -> usize {
        let at = self.pieces.partition_point(|piece| piece.to <= cut).saturating_sub(1);
        self.pieces
            .get(at)
            .map_or(0, |piece| (piece.from.start + (cut - piece.to.min(cut))).min(piece.from.end))
    }
}

/// All texts of one error, each by its index.
pub(super) struct Texts(pub Vec<Quoted>);

impl Texts {
    fn text(&self, id: usize) -> Result<&Quoted, Error> {
        self.0.get(id).ok_or(Error::FileMissing)
    }
}

impl<'a> Files<'a> for Texts {
    type FileId = usize;
    type Name = &'a str;
    type Source = &'a str;

    fn name(&'a self, id: usize) -> Result<&'a str, Error> {
        self.text(id).map(|text| text.name.as_str())
    }

    fn source(&'a self, id: usize) -> Result<&'a str, Error> {
        self.text(id).map(|text| text.cut.as_str())
    }

    fn line_index(&'a self, id: usize, byte: usize) -> Result<usize, Error> {
        Ok(self.text(id)?.lines.partition_point(|start| *start <= byte).saturating_sub(1))
    }

    fn line_range(&'a self, id: usize, line: usize) -> Result<Range<usize>, Error> {
        let text = self.text(id)?;
        let max = text.lines.len() - 1;
        let start = *text.lines.get(line).ok_or(Error::LineTooLarge { given: line, max })?;
        Ok(start..text.lines.get(line + 1).copied().unwrap_or(text.cut.len()))
    }

    /// In the original, from 1.
    fn column_number(&'a self, id: usize, _: usize, byte: usize) -> Result<usize, Error> {
        let text = self.text(id)?;
        let at = text.original(byte);
        let start = text.original[..at].rfind('\n').map_or(0, |line_break| line_break + 1);
        Ok(text.original[start..at].chars().count() + 1)
    }
}
