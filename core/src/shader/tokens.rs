//! Words and braces of a WGSL text: enough to know what stands at module scope.

use std::ops::Range;

/// Names and places of the functions that a text declares at module scope.
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

/// Whether a text speaks of this name.
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

/// Bytes of identifiers; every byte of a multi-byte character counts as one.
const fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte >= 0x80
}
