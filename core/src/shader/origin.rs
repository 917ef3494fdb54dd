//! The origin of each part of a generated shader, and errors that name it.

use std::ops::Range;

use naga::WithSpan;
use naga::front::wgsl::ParseError;
use naga::valid::ValidationError;

use super::ShaderError;
use super::resolve::shared_modules;
use crate::diagnostic::{Diagnostic, Place, SourceText};

/// The author of a part of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A file: a template, or a codec's snippet.
    File {
        /// Path as its author knows it.
        file: String,
        /// Whether it is the codec's.
        snippet: bool,
    },
    /// The generator.
    Generated {
        /// What for.
        purpose: String,
    },
}

/// A part of the generated text, copied from one origin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Bytes in the generated text.
    pub range: Range<usize>,
    /// Where they come from.
    pub origin: Origin,
}

/// A generated text with its origins.
pub struct Mapped<'a> {
    pub wgsl: &'a str,
    pub segments: &'a [Segment],
    /// A list of the generator's declarations for the snippet.
    pub provided: &'a str,
}

impl Mapped<'_> {
    /// A place in the snippet's own text, if it lies there.
    pub fn in_snippet(&self, range: Range<usize>) -> Option<Range<usize>> {
        let segment = self.segment(&range)?;
        let snippet = matches!(segment.origin, Origin::File { snippet: true, .. });
        snippet.then(|| local(segment, range))
    }

    /// An error of naga's parser, at the author's own place.
    pub fn parse_error(&self, error: &ParseError) -> ShaderError {
        let labels =
            error.labels().map(|(span, text)| (span.to_range(), text.to_owned())).collect::<Vec<_>>();
        let mut notes: Vec<_> = error.notes().map(ToOwned::to_owned).collect();
        let in_snippet = labels.iter().any(|(r, _)| r.clone().is_some_and(|r| self.in_snippet(r).is_some()));
        if in_snippet && error.message().starts_with("no definition in scope") {
            notes.push(format!("beside its own functions a snippet sees {}", self.provided));
        } else if let Some((_, name)) = error.message().split_once("no definition in scope for identifier: `")
        {
            notes.push(missing(name.trim_end_matches('`')));
        }
        self.report(error.message(), labels, notes)
    }

    /// An error of naga's validator. Its messages are terse, so the chain of causes follows.
    pub fn validation_error(&self, error: &WithSpan<ValidationError>) -> ShaderError {
        let mut labels =
            error.spans().map(|(span, text)| (span.to_range(), text.clone())).collect::<Vec<_>>();
        // The narrowest place helps the author most. naga lists the whole function first.
        labels.sort_by_key(|(range, _)| range.as_ref().map_or(usize::MAX, ExactSizeIterator::len));
        let mut notes = Vec::new();
        let mut cause = std::error::Error::source(error.as_inner());
        while let Some(inner) = cause {
            notes.push(inner.to_string());
            cause = inner.source();
        }
        notes.push("the text parses, but breaks a rule of WGSL: compare the types on both sides".to_owned());
        self.report(&error.as_inner().to_string(), labels, notes)
    }

    fn report(
        &self,
        message: &str,
        labels: Vec<(Option<Range<usize>>, String)>,
        notes: Vec<String>,
    ) -> ShaderError {
        let place = |range: Range<usize>| match self.segment(&range) {
            Some(segment) => {
                let name = match &segment.origin {
                    Origin::File { file, .. } => file.clone(),
                    Origin::Generated { purpose } => format!("generated: {purpose}"),
                };
                let source = SourceText::new(name, &self.wgsl[segment.range.clone()]);
                Place::new(source, local(segment, range))
            }
            None => Place::new(SourceText::new("generated shader", self.wgsl), range),
        };
        let mut labels = labels.into_iter().filter_map(|(range, text)| Some((place(range?), text)));
        let Some((primary, text)) = labels.next() else {
            return ShaderError(
                [message.to_owned()].into_iter().chain(notes).collect::<Vec<_>>().join("\n  = "),
            );
        };
        let diagnostic = labels.fold(Diagnostic::new(message, primary, text), |diagnostic, (place, text)| {
            diagnostic.with_secondary(place, text)
        });
        ShaderError(notes.into_iter().fold(diagnostic, Diagnostic::with_note).to_string())
    }

    fn segment(&self, range: &Range<usize>) -> Option<&Segment> {
        self.segments.iter().find(|s| s.range.start <= range.start && range.start <= s.range.end)
    }
}

/// Advice for the renderer's author about a name that no module declares.
fn missing(name: &str) -> String {
    let files: Vec<_> = shared_modules(name).iter().map(|(_, template, _)| template.file).collect();
    match files[..] {
        [] => format!("neither this program's modules nor the shared ones declare `{name}`"),
        _ => format!("`{name}` is declared by {}: the program is to offer one of them", files.join(", ")),
    }
}

/// A range of the generated text, converted to the text of the segment in which it begins.
fn local(segment: &Segment, range: Range<usize>) -> Range<usize> {
    let base = segment.range.start;
    range.start - base..range.end.min(segment.range.end) - base
}
