//! The contract of a snippet, proven.
//!
//! What it may declare is read off its own tokens, since naga's module keeps no aliases and merges equal types.
//! What its functions are and do is read off naga's IR, between parsing and validation: later, an error would
//! point at the template that calls the snippet.

use naga::{Expression, Function, MathFunction, ScalarKind, TypeInner, VectorSize};

use super::ShaderError;
use super::origin::Mapped;
use crate::diagnostic::{Diagnostic, Place, SourceText};

/// Signature of `<id>_fetch`.
const FETCH: &str = "(p: vec3<i32>) -> vec4<f32>";
/// Signature of `<id>_fetch_cell`.
const FETCH_CELL: &str = "(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8>";

/// A codec's snippet under test.
pub struct Snippet<'a> {
    pub codec: &'a str,
    pub file: &'a str,
    pub source: &'a str,
    /// Whether something calls `<id>_fetch_cell`.
    pub cell: bool,
}

impl Snippet<'_> {
    fn error(&self, message: &str, at: std::ops::Range<usize>, label: &str, note: &str) -> ShaderError {
        let place = Place::new(SourceText::new(self.file, self.source), at);
        ShaderError(Diagnostic::new(message, place, label).with_note(note).to_string())
    }
}

/// Module-scope declarations: names under the codec's prefix, no variables, no attributes, no directives.
pub fn declarations(snippet: &Snippet<'_>) -> Result<(), ShaderError> {
    let prefix = format!("{}_", snippet.codec);
    let mut depth = 0_usize;
    let mut tokens = tokens(snippet.source).into_iter().peekable();
    while let Some((at, token)) = tokens.next() {
        match token {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "@" => {
                // Attributes on members and parameters are harmless; on declarations they make bindings and
                // entry points.
                let name = tokens.peek().map_or("", |t| t.1);
                if matches!(name, "group" | "binding" | "compute" | "vertex" | "fragment" | "workgroup_size")
                {
                    let end = tokens.peek().map_or(at.end, |t| t.0.end);
                    return Err(snippet.error(
                        &format!("a snippet has no `@{name}`"),
                        at.start..end,
                        "bindings and entry points belong to the generator",
                        &format!(
                            "declare a resource in the codec and read it through `{prefix}<resource>(i)`"
                        ),
                    ));
                }
            }
            "enable" | "requires" | "diagnostic" if depth == 0 => {
                return Err(snippet.error(
                    &format!("a snippet has no `{token}` directive"),
                    at,
                    "directives must stand at the head of the whole shader",
                    "write the snippet in core WGSL",
                ));
            }
            "var" if depth == 0 => {
                return Err(snippet.error(
                    "a snippet has no variables at module scope",
                    at,
                    "state or binding declared here",
                    "pass values as parameters; declare buffers as resources of the codec",
                ));
            }
            "fn" | "const" | "override" | "struct" | "alias" if depth == 0 => {
                if let Some((name_at, name)) = tokens.peek()
                    && !name.starts_with(&prefix)
                {
                    return Err(snippet.error(
                        &format!("`{name}` does not begin with `{prefix}`"),
                        name_at.clone(),
                        "declared by the snippet",
                        &format!(
                            "a snippet declares only names that begin with its codec's id: `{prefix}{name}`"
                        ),
                    ));
                }
            }
            _ => {}
        }
    }
    // Before naga sees the text: it would blame the template that calls what is missing.
    let declared = declared_functions(snippet.source);
    let wanted = [("fetch", FETCH, true), ("fetch_cell", FETCH_CELL, snippet.cell)];
    for (name, signature, wanted) in wanted {
        let name = format!("{prefix}{name}");
        if wanted && !declared.iter().any(|(_, n)| *n == name) {
            let message = format!("the snippet declares no function `{name}`");
            let note = format!("the contract is `fn {name}{signature}`");
            return Err(snippet.error(&message, 0..0, "nowhere in this file", &note));
        }
    }
    Ok(())
}

/// Signatures, no bindings read directly, no built-ins whose precision the contract does not allow.
pub fn contract(
    snippet: &Snippet<'_>,
    module: &naga::Module,
    mapped: &Mapped<'_>,
) -> Result<(), ShaderError> {
    let fetch = format!("{}_fetch", snippet.codec);
    let cell = format!("{}_fetch_cell", snippet.codec);
    require(snippet, module, &fetch, FETCH, |f| {
        parameters(module, f, 1) && f.result.as_ref().is_some_and(|r| is_vec4f(module, r.ty))
    })?;
    if snippet.cell {
        require(snippet, module, &cell, FETCH_CELL, |f| {
            parameters(module, f, 2) && f.result.as_ref().is_some_and(|r| is_cell(module, r.ty))
        })?;
    }
    let own = declared_functions(snippet.source);
    for (_, function) in module.functions.iter() {
        if !function.name.as_deref().is_some_and(|n| own.iter().any(|(_, own)| *own == n)) {
            continue;
        }
        for (handle, expression) in function.expressions.iter() {
            let problem = match expression {
                Expression::GlobalVariable(variable) => {
                    let name = module.global_variables[*variable].name.as_deref().unwrap_or("?");
                    Some((
                        format!("a snippet does not touch the binding `{name}`"),
                        "read directly",
                        "read resources through their accessors, which may split a buffer",
                    ))
                }
                Expression::Math { fun, .. } if forbidden(*fun) => Some((
                    format!("a snippet does not use `{}`", wgsl_name(*fun)),
                    "its precision differs from device to device",
                    "use shifts, masks and `bitcast` for packed values, and multiplication for powers",
                )),
                _ => None,
            };
            if let Some((message, label, note)) = problem {
                let span = function.expressions.get_span(handle).to_range();
                return Err(match span.and_then(|r| mapped.in_snippet(r)) {
                    Some(range) => snippet.error(&message, range, label, note),
                    None => ShaderError(format!("{}: {message} ({note})", snippet.file)),
                });
            }
        }
    }
    Ok(())
}

/// The function, which [`declarations`] has found, must have this signature.
fn require(
    snippet: &Snippet<'_>,
    module: &naga::Module,
    name: &str,
    signature: &str,
    fits: impl Fn(&Function) -> bool,
) -> Result<(), ShaderError> {
    let note = format!("the contract is `fn {name}{signature}`");
    let mut functions = module.functions.iter();
    if functions.any(|(_, f)| f.name.as_deref() == Some(name) && fits(f)) {
        return Ok(());
    }
    let declared = declared_functions(snippet.source);
    let at = declared.into_iter().find(|(_, n)| *n == name).map_or(0..0, |(at, _)| at);
    Err(snippet.error(&format!("`{name}` has another signature"), at, "declared here", &note))
}

fn parameters(module: &naga::Module, function: &Function, count: usize) -> bool {
    function.arguments.len() == count && function.arguments.iter().all(|a| is_vec3i(module, a.ty))
}

fn is_vec3i(module: &naga::Module, ty: naga::Handle<naga::Type>) -> bool {
    matches!(module.types[ty].inner, TypeInner::Vector { size: VectorSize::Tri, scalar }
        if scalar.kind == ScalarKind::Sint && scalar.width == 4)
}

fn is_vec4f(module: &naga::Module, ty: naga::Handle<naga::Type>) -> bool {
    matches!(module.types[ty].inner, TypeInner::Vector { size: VectorSize::Quad, scalar }
        if scalar.kind == ScalarKind::Float && scalar.width == 4)
}

fn is_cell(module: &naga::Module, ty: naga::Handle<naga::Type>) -> bool {
    matches!(module.types[ty].inner, TypeInner::Array { base, size: naga::ArraySize::Constant(n), .. }
        if n.get() == 8 && is_vec4f(module, base))
}

fn forbidden(function: MathFunction) -> bool {
    let name = format!("{function:?}");
    function == MathFunction::Pow || name.starts_with("Pack") || name.starts_with("Unpack")
}

fn wgsl_name(function: MathFunction) -> String {
    let name = format!("{function:?}");
    name[..1].to_lowercase() + &name[1..]
}

/// Names and places of the functions that a text declares at module scope.
fn declared_functions(source: &str) -> Vec<(std::ops::Range<usize>, &str)> {
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

/// Words and braces of a WGSL text, comments left out: enough to know what stands at module scope.
fn tokens(source: &str) -> Vec<(std::ops::Range<usize>, &str)> {
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
