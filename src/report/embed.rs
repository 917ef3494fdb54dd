//! Pictures inside the page.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use minijinja::Value;

/// Bytes of picture files that a report embeds; later ones are linked.
pub const EMBEDDED_BYTES: usize = 48 << 20;

const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Reads pictures below a folder and hands out what an `<img>` needs.
#[derive(Debug)]
pub(super) struct Pictures {
    folder: PathBuf,
    left: usize,
    linked: usize,
    known: HashMap<String, Option<Value>>,
}

impl Pictures {
    pub(super) fn new(folder: &Path, budget: usize) -> Self {
        Self { folder: folder.to_owned(), left: budget, linked: 0, known: HashMap::new() }
    }

    /// The `src` of a picture. `None` if there is no such PNG.
    ///
    /// Only paths that stay below the folder are read: a record is data, and must not pull other files into a page
    /// that is then passed on.
    pub(super) fn source(&mut self, path: &str) -> Option<Value> {
        if let Some(known) = self.known.get(path) {
            return known.clone();
        }
        let source = self.read(path);
        self.known.insert(path.to_owned(), source.clone());
        source
    }

    /// How many pictures did not fit.
    pub(super) const fn linked(&self) -> usize {
        self.linked
    }

    fn read(&mut self, path: &str) -> Option<Value> {
        let below = Path::new(path).components().all(|c| matches!(c, Component::Normal(_)));
        let bytes = std::fs::read(below.then(|| self.folder.join(path))?).ok()?;
        if !bytes.starts_with(PNG_SIGNATURE) {
            return None;
        }
        let Some(left) = self.left.checked_sub(bytes.len()) else {
            self.linked += 1;
            return Some(Value::from(link(path)));
        };
        self.left = left;
        // Base64 has no character that HTML would read as its own, so it needs no pass through the escaper.
        Some(Value::from_safe_string(format!("data:image/png;base64,{}", base64(&bytes))))
    }
}

/// A relative address: what has a meaning in one is written in percent.
pub(super) fn link(path: &str) -> String {
    path.bytes().fold(String::new(), |mut out, b| {
        match b {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                out.push(char::from(b));
            }
            _ => out.push_str(&format!("%{b:02X}")),
        }
        out
    })
}

/// RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let group = (0..3).fold(0u32, |g, i| g << 8 | u32::from(chunk.get(i).copied().unwrap_or(0)));
        for i in 0..4 {
            let digit = DIGITS[(group >> (18 - 6 * i) & 63) as usize];
            out.push(if i <= chunk.len() { char::from(digit) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        for (plain, coded) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
        assert_eq!(base64(&[0xff, 0xef, 0xfe]), "/+/+");
    }

    #[test]
    fn embeds_while_there_is_room_and_then_links() {
        let folder = tempfile::tempdir().unwrap();
        let png = [PNG_SIGNATURE, b"rest"].concat();
        std::fs::write(folder.path().join("a.png"), &png).unwrap();
        std::fs::write(folder.path().join("b c.png"), &png).unwrap();
        let mut pictures = Pictures::new(folder.path(), png.len());
        assert!(
            pictures.source("a.png").unwrap().to_string().starts_with("data:image/png;base64,iVBORw0KGgpy")
        );
        assert!(pictures.source("a.png").unwrap().to_string().starts_with("data:"), "embedded once");
        assert_eq!(pictures.source("b c.png").unwrap().to_string(), "b%20c.png");
        assert_eq!(pictures.linked(), 1);
    }

    #[test]
    fn nothing_outside_and_nothing_but_pictures() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(folder.path().join("secret.png"), PNG_SIGNATURE).unwrap();
        std::fs::write(inner.join("text.png"), "no picture").unwrap();
        let mut pictures = Pictures::new(&inner, 1000);
        let absolute = folder.path().join("secret.png").display().to_string();
        for path in ["../secret.png", &absolute, "text.png", "missing.png", ""] {
            assert!(pictures.source(path).is_none(), "{path}");
        }
    }
}
