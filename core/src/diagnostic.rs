//! Errors that point at a source text: file, line, column, caret. The configuration (TOML) and the shader generator
//! (WGSL) use them.

mod quoted;

use std::error::Error;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use codespan_reporting::diagnostic as codespan;
use codespan_reporting::term;
use quoted::{Quoted, Texts};

/// A text and the name under which its author knows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceText {
    /// Path, or a name for text without a file (`--set scene.size=…`).
    pub name: String,
    /// The whole text.
    pub text: String,
}

impl SourceText {
    /// A text to be shared by the places in it.
    #[must_use]
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Arc<Self> {
        Arc::new(Self { name: name.into(), text: text.into() })
    }
}

/// A place in a source text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The text.
    pub source: Arc<SourceText>,
    /// Byte range. When it is shown, a range beyond the end, or one that splits a character, is narrowed.
    pub span: Range<usize>,
}

impl Place {
    /// Bytes `span` of `source`.
    #[must_use]
    pub const fn new(source: Arc<SourceText>, span: Range<usize>) -> Self {
        Self { source, span }
    }

    /// The bytes inside the text, widened to whole characters.
    fn snapped(&self) -> Range<usize> {
        let text = &self.source.text;
        let start = text.floor_char_boundary(self.span.start.min(text.len()));
        let end = text.ceil_char_boundary(self.span.end.clamp(start, text.len()));
        start..end
    }

    /// Name of the text and line, from 1: `compare.toml:12`.
    #[must_use]
    pub fn line(&self) -> String {
        let before = &self.source.text[..self.snapped().start];
        format!("{}:{}", self.source.name, before.matches('\n').count() + 1)
    }

    /// The text at this place.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.source.text[self.snapped()]
    }
}

/// A place in a text, and a message about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Where.
    pub place: Place,
    /// Words next to the caret; may be empty.
    pub text: String,
}

/// An error with the places that it is about.
///
/// Its `Display` is plain text without colour, the same on every machine:
///
/// ```text
/// error: the scene has no key `stepp_voxels`
///   ┌─ compare.toml:12:1
///    │
/// 12 │ stepp_voxels = 0.5
///    │ ^^^^^^^^^^^^ unknown key
///    │
///    = did you mean `step_voxels`?
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// The problem in one sentence.
    pub message: String,
    /// The place of the problem. The heading names its file, line and column (both from 1, columns in characters).
    pub primary: Label,
    /// Further places, in this file or in others.
    pub secondary: Vec<Label>,
    /// The ways out, one `=` line each.
    pub notes: Vec<String>,
}

impl Diagnostic {
    /// An error at one place.
    #[must_use]
    pub fn new(message: impl Into<String>, place: Place, label: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            primary: Label { place, text: label.into() },
            secondary: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Adds a further place.
    #[must_use]
    pub fn with_secondary(mut self, place: Place, label: impl Into<String>) -> Self {
        self.secondary.push(Label { place, text: label.into() });
        self
    }

    /// Adds a note.
    #[must_use]
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }
}

impl Error for Diagnostic {}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let styles: Vec<(codespan::LabelStyle, &Label)> =
            std::iter::once((codespan::LabelStyle::Primary, &self.primary))
                .chain(self.secondary.iter().map(|label| (codespan::LabelStyle::Secondary, label)))
                .collect();
        let mut sources: Vec<&Arc<SourceText>> = Vec::new();
        for (_, label) in &styles {
            if !sources.contains(&&label.place.source) {
                sources.push(&label.place.source);
            }
        }
        let texts = sources.iter().map(|source| {
            let of_source = styles.iter().filter(|(_, label)| label.place.source == **source);
            let places: Vec<usize> = of_source.map(|(_, label)| label.place.snapped().start).collect();
            Quoted::new(printable(&source.name, LONGEST_NAME), printable_source(&source.text), &places)
        });
        let files = Texts(texts.collect());
        let labels = styles.iter().map(|(style, label)| {
            let file = sources.iter().position(|source| **source == label.place.source).unwrap_or(0);
            let span = files.0[file].span(label.place.snapped());
            codespan::Label::new(*style, file, span).with_message(printable(&label.text, LONGEST_LABEL))
        });
        let labels = labels.collect();
        let diagnostic = codespan::Diagnostic::error()
            .with_message(printable(&self.message, LONGEST_TEXT))
            .with_labels(labels)
            .with_notes(self.notes.iter().map(|note| printable(note, LONGEST_TEXT)).collect());
        let text =
            term::emit_into_string(&term::Config::default(), &files, &diagnostic).map_err(|_| fmt::Error)?;
        let lines: Vec<&str> = text.trim_end().lines().map(str::trim_end).collect();
        f.write_str(&lines.join("\n"))
    }
}

/// Whether a character would move the cursor, be invisible, or change the direction of text.
fn is_unprintable(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

/// Largest number of characters shown of a message or note. Both may quote the text.
const LONGEST_TEXT: usize = 1000;
/// Largest number of characters shown of a label.
const LONGEST_LABEL: usize = 300;
/// Largest number of characters shown of a text's name.
const LONGEST_NAME: usize = 300;

/// The message without control characters that a terminal would obey, cut after `longest` characters. Line breaks stay.
fn printable(text: &str, longest: usize) -> String {
    let mut shown: String = text
        .chars()
        .take(longest)
        .map(|c| if is_unprintable(c) && c != '\n' { char::REPLACEMENT_CHARACTER } else { c })
        .collect();
    if text.chars().nth(longest).is_some() {
        shown.push('…');
    }
    shown
}

/// A source text without control characters that a terminal would obey. Each is replaced by a character of as many
/// bytes, so spans stay valid.
fn printable_source(text: &str) -> String {
    let replace = |c: char| match (c, c.len_utf8()) {
        ('\n' | '\t', _) => c,
        ('\r', _) => ' ',
        _ if !is_unprintable(c) => c,
        (_, 1) => '?',
        (_, 2) => '¿',
        _ => char::REPLACEMENT_CHARACTER,
    };
    text.chars().map(replace).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(source: &Arc<SourceText>, needle: &str) -> Place {
        let start = source.text.find(needle).unwrap();
        Place::new(source.clone(), start..start + needle.len())
    }

    #[test]
    fn points_into_several_files() {
        let snippet = SourceText::new("codecs/s3dc/src/decode.wgsl", "fn a() {}\nfn s3dc_fetch() {}\n");
        let template = SourceText::new("raycasting.wgsl", "let v = s3dc_fetch(p);\n");
        let error = Diagnostic::new("wrong signature", place(&snippet, "s3dc_fetch"), "takes no argument")
            .with_secondary(place(&template, "s3dc_fetch(p)"), "called here")
            .with_note("declare `fn s3dc_fetch(p: vec3<i32>) -> vec4<f32>`");
        insta::assert_snapshot!(error, @r"
        error: wrong signature
          ┌─ codecs/s3dc/src/decode.wgsl:2:4
          │
        2 │ fn s3dc_fetch() {}
          │    ^^^^^^^^^^ takes no argument
          │
          ┌─ raycasting.wgsl:1:9
          │
        1 │ let v = s3dc_fetch(p);
          │         ------------- called here
          │
          = declare `fn s3dc_fetch(p: vec3<i32>) -> vec4<f32>`
        ");
    }

    #[test]
    fn control_characters_are_neither_obeyed_nor_fatal() {
        let text = "a\u{1b}[31m = \"\u{85}\u{202e}é\"\r\n\tbad\0\r\n";
        let source = SourceText::new("x\u{7}.toml", text);
        let error = Diagnostic::new("bell \u{7}", place(&source, "bad"), "\u{1b}here");
        insta::assert_snapshot!(error, @r"
        error: bell �
          ┌─ x�.toml:2:2
          │
        2 │     bad?
          │     ^^^ �here
        ");
        let error = Diagnostic::new("first", place(&source, "é"), "");
        assert!(!error.to_string().contains(|c: char| c.is_control() && c != '\n'), "{error}");
    }

    /// Lines of megabytes are cut around the places in question. The column stays that of the original.
    #[test]
    fn long_lines_are_quoted_around_their_places() {
        let text = format!(
            "a = 1\nx = \"{}\", bad, {}, worse, {}\nz = 2\n",
            "é".repeat(900),
            "y".repeat(900),
            "z".repeat(900)
        );
        let source = SourceText::new("x.toml", text.clone());
        let error = Diagnostic::new("m".repeat(5000), place(&source, "bad"), "here")
            .with_secondary(place(&source, "worse"), "and here")
            .with_note("n".repeat(5000));
        let error = error.to_string();
        assert!(error.contains("x.toml:2:909"), "{error}");
        let quoted = error.lines().find(|l| l.contains("bad")).unwrap();
        assert!(quoted.contains("éé\", bad, yy") && quoted.contains("yy, worse, zz"), "{quoted}");
        assert_eq!(quoted.matches('…').count(), 3, "{quoted}");
        let column = |line: &str, part: &str| line[..line.find(part).unwrap()].chars().count();
        let carets = error.lines().find(|l| l.contains("^^^")).unwrap();
        assert_eq!(column(carets, "^^^"), column(quoted, "bad"), "{error}");
        assert_eq!(carets.matches('^').count(), 3, "{error}");
        assert!(error.len() < 4000, "{}", error.len());

        let whole =
            Diagnostic::new("all of it", Place::new(source.clone(), 0..text.len()), "this").to_string();
        assert!(whole.contains("x.toml:1:1") && whole.len() < 1500, "{whole}");
        let line = text.find("x =").unwrap()..text.find("\nz").unwrap();
        let one = Diagnostic::new("a line", Place::new(source, line), "this").to_string();
        assert!(one.contains("x.toml:2:1") && one.contains("^ this") && one.len() < 500, "{one}");
    }

    #[test]
    fn spans_beyond_the_text_and_within_characters_are_narrowed() {
        let source = SourceText::new("x", "é");
        for span in [0..0, 1..1, 0..1, 1..9, 7..9, 2..2] {
            let error = Diagnostic::new("m", Place::new(source.clone(), span.clone()), "l");
            assert!(error.to_string().contains("x:1:"), "{span:?}: {error}");
        }
        for text in ["", "\n", "a\n\n", "\r\n"] {
            let end = Place::new(SourceText::new("x", text), text.len()..text.len());
            assert!(Diagnostic::new("m", end, "l").to_string().starts_with("error: m\n"), "{text:?}");
        }
    }
}
