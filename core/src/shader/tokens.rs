//! Words and braces of a WGSL text: enough to find the declarations at module scope.

use std::collections::BTreeSet;
use std::ops::Range;

/// The names that a text declares at module scope, and the foreign names that it uses.
#[derive(Clone, Debug, Default)]
pub struct Names<'a> {
    pub declares: BTreeSet<&'a str>,
    pub uses: BTreeSet<&'a str>,
    /// Members of `inputs`.
    pub inputs: BTreeSet<&'a str>,
}

/// The names that a text declares and uses. Members, parameters and local variables are neither.
pub fn names(source: &str) -> Names<'_> {
    let bytes = source.as_bytes();
    let before = |at: usize| bytes[..at].iter().rev().find(|b| !b.is_ascii_whitespace()).copied();
    let after = |at: usize| bytes[at..].iter().find(|b| !b.is_ascii_whitespace()).copied();
    let (mut declares, mut local, mut words) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    let mut inputs = BTreeSet::new();
    let (mut depth, mut last) = (0_usize, "");
    for (range, token) in tokens(source) {
        match token {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "@" => {}
            _ if matches!(last, "fn" | "struct" | "alias" | "const" | "override") && depth == 0 => {
                declares.insert(token);
            }
            _ if matches!(last, "let" | "var" | "const") || after(range.end) == Some(b':') => {
                local.insert(token);
            }
            _ if before(range.start) == Some(b'.') => {
                if last == "inputs" {
                    inputs.insert(token);
                }
            }
            _ => {
                words.insert(token);
            }
        }
        last = token;
    }
    let uses = words.into_iter().filter(|word| !declares.contains(word) && !local.contains(word)).collect();
    Names { declares, uses, inputs }
}

/// Position and name of each function that a text declares at module scope.
pub fn declared_functions(source: &str) -> Vec<(Range<usize>, &str)> {
    let mut functions = Vec::new();
    let mut depth = 0_usize;
    let mut tokens = tokens(source).into_iter().peekable();
    while let Some((_, token)) = tokens.next() {
        match token {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "fn" if depth == 0 => functions.extend(tokens.peek().cloned()),
            _ => {}
        }
    }
    functions
}

/// Whether a text contains this name.
pub fn mentions(source: &str, name: &str) -> bool {
    tokens(source).iter().any(|(_, token)| *token == name)
}

/// Words, braces and `@` with their places, comments left out.
pub fn tokens(source: &str) -> Vec<(Range<usize>, &str)> {
    let bytes = source.as_bytes();
    let mut tokens = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let rest = &bytes[at..];
        if rest.starts_with(b"//") {
            at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        } else if rest.starts_with(b"/*") {
            at += comment(rest);
        } else if is_word(bytes[at]) {
            let length = rest.iter().position(|&b| !is_word(b)).unwrap_or(rest.len());
            tokens.push((at..at + length, &source[at..at + length]));
            at += length;
        } else {
            if matches!(bytes[at], b'{' | b'}' | b'@') {
                tokens.push((at..at + 1, &source[at..=at]));
            }
            at += 1;
        }
    }
    tokens
}

/// Length of a block comment, which may nest.
fn comment(text: &[u8]) -> usize {
    let (mut depth, mut at) = (0_usize, 0);
    while at < text.len() {
        match &text[at..] {
            [b'/', b'*', ..] => (depth, at) = (depth + 1, at + 2),
            [b'*', b'/', ..] if depth == 1 => return at + 2,
            [b'*', b'/', ..] => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
    }
    text.len()
}

/// Whether a byte belongs to an identifier. All bytes of a multi-byte character do.
const fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte >= 0x80
}
