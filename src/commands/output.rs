//! Files that commands write. The extension decides the format, with one table for all commands and the help.

use std::path::Path;

use crate::exit::BadInput;

/// A format that some command writes.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// An encoded volume.
    Container,
    /// A volume as NRRD.
    Nrrd,
    /// A volume as NPY.
    Npy,
    /// Samples without a header.
    Raw,
    /// A picture.
    Png,
    /// A table.
    Csv,
    /// A page.
    Html,
    /// A schema.
    Json,
    /// A page as text.
    Markdown,
}

impl Output {
    /// All formats of unencoded volumes. The first is used for files without an extension.
    pub const VOLUMES: &'static [Self] = &[Self::Nrrd, Self::Npy, Self::Raw];

    /// Extensions, without the dot; the first is the usual one.
    const fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Container => &["cvr"],
            Self::Nrrd => &["nrrd"],
            Self::Npy => &["npy"],
            Self::Raw => &["raw"],
            Self::Png => &["png"],
            Self::Csv => &["csv"],
            Self::Html => &["html", "htm"],
            Self::Json => &["json"],
            Self::Markdown => &["md"],
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::Container => "an encoded volume",
            Self::Nrrd => "NRRD",
            Self::Npy => "a NumPy array",
            Self::Raw => "samples without a header",
            Self::Png => "a picture",
            Self::Csv => "a table",
            Self::Html => "a page",
            Self::Json => "a JSON Schema",
            Self::Markdown => "a page of Markdown",
        }
    }

    /// A list of the possible formats: ".nrrd (NRRD), .npy (a NumPy array) or .raw (samples without a header)".
    fn list(possible: &[Self]) -> String {
        let words: Vec<String> =
            possible.iter().map(|o| format!(".{} ({})", o.extensions()[0], o.words())).collect();
        match &words[..] {
            [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
            _ => words.concat(),
        }
    }

    /// The help of an argument.
    pub fn help(possible: &[Self]) -> String {
        let decides = if possible.len() > 1 { "; the extension decides the format" } else { "" };
        format!("The file to write: {}{decides}", Self::list(possible))
    }

    /// The format of an output file, one of `possible`. A pipe or a device gets the first.
    ///
    /// # Errors
    /// When its extension is that of none of them.
    pub fn of(path: &Path, possible: &[Self]) -> Result<Self, BadInput> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let named = possible.iter().find(|o| o.extensions().contains(&extension.as_str()));
        if let Some(output) = named {
            return Ok(*output);
        }
        let is_stream = std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir());
        match possible {
            [first, ..] if is_stream => Ok(*first),
            _ => {
                let (path, list) = (path.display(), Self::list(possible));
                let found = if extension.is_empty() { "none".to_owned() } else { format!(".{extension}") };
                Err(BadInput(format!(
                    "{path}: the extension decides the format, and it is {found}; what can be written here: {list}"
                )))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_decides() {
        let of = |name: &str, possible: &[Output]| Output::of(Path::new(name), possible).map_err(|e| e.0);
        assert_eq!(of("a/b.NRRD", Output::VOLUMES), Ok(Output::Nrrd));
        assert_eq!(of("b.x.npy", Output::VOLUMES), Ok(Output::Npy));
        assert_eq!(of("x.htm", &[Output::Html]), Ok(Output::Html));
        let message = of("b.jpg", &[Output::Png]).unwrap_err();
        assert_eq!(
            message,
            "b.jpg: the extension decides the format, and it is .jpg; what can be written here: .png (a picture)"
        );
        let message = of("b", Output::VOLUMES).unwrap_err();
        assert!(message.contains("it is none"), "{message}");
        let all = ".nrrd (NRRD), .npy (a NumPy array) or .raw (samples without a header)";
        assert!(message.ends_with(all) && Output::help(Output::VOLUMES).contains(all), "{message}");
        assert_eq!(of("/dev/null", Output::VOLUMES), Ok(Output::Nrrd));
    }
}
