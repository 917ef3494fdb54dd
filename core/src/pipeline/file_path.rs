//! Paths with environment variables in them.

use std::ffi::OsString;
use std::path::PathBuf;

/// The path of a volume as a configuration writes it: `$NAME` and `${NAME}` are environment variables, `$$` is a dollar
/// sign. A dollar sign without a name behind it stays.
///
/// It is expanded when the file is opened. So a configuration can be checked on a machine without its volumes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilePath {
    written: String,
    parts: Vec<Part>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Part {
    Text(String),
    Variable(String),
}

/// Why a text is not a path.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FilePathError {
    /// Nothing was written.
    #[error("the path is empty")]
    Empty,
    /// `${` without a name and a closing brace.
    #[error("`${{` needs a variable name and a closing `}}`")]
    Braces,
}

/// An environment variable that a path needs is not set.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{path}`: the environment variable {name} is not set")]
pub struct UnsetVariable {
    /// The variable.
    pub name: String,
    /// The path as written.
    pub path: String,
}

const fn is_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

impl FilePath {
    /// A path as a configuration writes it.
    ///
    /// # Errors
    /// When it is empty, or `${` is not closed.
    pub fn new(written: &str) -> Result<Self, FilePathError> {
        if written.is_empty() {
            return Err(FilePathError::Empty);
        }
        let mut parts = Vec::new();
        let mut text = String::new();
        let mut rest = written;
        while let Some(at) = rest.find('$') {
            text.push_str(&rest[..at]);
            let after = &rest[at + 1..];
            let (name, length) = if let Some(inner) = after.strip_prefix('{') {
                let end = inner.find(|c| !is_name(c)).unwrap_or(inner.len());
                if end == 0 || !inner[end..].starts_with('}') {
                    return Err(FilePathError::Braces);
                }
                (&inner[..end], end + 2)
            } else {
                let end = after.find(|c| !is_name(c)).unwrap_or(after.len());
                (&after[..end], end)
            };
            if name.is_empty() {
                text.push('$');
                rest = after.strip_prefix('$').unwrap_or(after);
                continue;
            }
            parts.push(Part::Text(std::mem::take(&mut text)));
            parts.push(Part::Variable(name.to_owned()));
            rest = &after[length..];
        }
        text.push_str(rest);
        parts.push(Part::Text(text));
        Ok(Self { written: written.to_owned(), parts })
    }

    /// A path without variables, such as one from the command line.
    ///
    /// # Errors
    /// When it is empty.
    pub fn literal(path: &str) -> Result<Self, FilePathError> {
        Self::new(&path.replace('$', "$$"))
    }

    /// The path as written.
    #[must_use]
    pub fn written(&self) -> &str {
        &self.written
    }

    /// The variables that it needs, in order.
    pub fn variables(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().filter_map(|part| match part {
            Part::Variable(name) => Some(name.as_str()),
            Part::Text(_) => None,
        })
    }

    /// The path with its variables replaced by the results of `lookup` (`&|name| std::env::var_os(name)`).
    ///
    /// # Errors
    /// When `lookup` does not know a variable.
    pub fn expand(&self, lookup: &dyn Fn(&str) -> Option<OsString>) -> Result<PathBuf, UnsetVariable> {
        let mut path = OsString::new();
        for part in &self.parts {
            match part {
                Part::Text(text) => path.push(text),
                Part::Variable(name) => path.push(
                    lookup(name)
                        .ok_or_else(|| UnsetVariable { name: name.clone(), path: self.written.clone() })?,
                ),
            }
        }
        Ok(path.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expand(written: &str) -> Result<String, String> {
        let lookup = |name: &str| (name == "DATA").then(|| "/d".into());
        let path = FilePath::new(written).map_err(|e| e.to_string())?;
        path.expand(&lookup).map(|p| p.display().to_string()).map_err(|e| e.to_string())
    }

    #[test]
    fn expands_variables_anywhere() {
        assert_eq!(expand("$DATA/a.nrrd").unwrap(), "/d/a.nrrd");
        assert_eq!(expand("x${DATA}y/$DATA").unwrap(), "x/dy//d");
        assert_eq!(expand("a$.raw$$DATA$").unwrap(), "a$.raw$DATA$");
        assert_eq!(FilePath::literal("$DATA/x").unwrap().variables().count(), 0);
    }

    #[test]
    fn names_the_variable_that_is_not_set() {
        assert_eq!(
            expand("$DATA/${OTHER}").unwrap_err(),
            "`$DATA/${OTHER}`: the environment variable OTHER is not set"
        );
        assert_eq!(expand("${DATA").unwrap_err(), "`${` needs a variable name and a closing `}`");
        assert_eq!(expand("${}").unwrap_err(), "`${` needs a variable name and a closing `}`");
        assert_eq!(expand("").unwrap_err(), "the path is empty");
    }
}
