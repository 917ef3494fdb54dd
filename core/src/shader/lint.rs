//! Checks the contract of a codec's text: snippet or pass.
//!
//! Declarations are read from the text's own tokens, because naga's module has no aliases and merges equal types.
//! Signatures and bodies are read from naga's IR, between parsing and validation. After validation, an error would
//! point at the template that calls the snippet.

use naga::{AddressSpace, Expression, Function, MathFunction, ScalarKind, TypeInner, VectorSize};

use super::ShaderError;
use super::origin::Mapped;
use super::tokens::{declared_functions, tokens};
use crate::diagnostic::{Diagnostic, Place, SourceText};

/// Signature of `<id>_fetch`.
const FETCH: &str = "(p: vec3<i32>) -> vec4<f32>";
/// Signature of `<id>_fetch_cell`.
const FETCH_CELL: &str = "(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8>";
/// Largest number of invocations of a workgroup along x, y and z, and in all. Every WebGPU device offers them.
const WORKGROUP: ([u32; 3], u32) = ([256, 256, 64], 256);
/// Largest number of bytes of a workgroup's variables. Every WebGPU device offers them.
const WORKGROUP_BYTES: u32 = 16 << 10;

/// A codec's text under test.
pub struct Snippet<'a> {
    pub codec: &'a str,
    pub file: &'a str,
    pub source: &'a str,
    pub role: Role<'a>,
}

/// The role of a text.
#[derive(Copy, Clone)]
pub enum Role<'a> {
    /// It decodes a voxel.
    Voxel {
        /// Whether something calls `<id>_fetch_cell`.
        cell: bool,
    },
    /// It is one of the passes that rebuild a frame.
    Pass {
        /// Its entry point, prefix included.
        entry: &'a str,
    },
}

impl Snippet<'_> {
    const fn noun(&self) -> &'static str {
        match self.role {
            Role::Voxel { .. } => "snippet",
            Role::Pass { .. } => "pass",
        }
    }

    fn error(&self, message: &str, at: std::ops::Range<usize>, label: &str, note: &str) -> ShaderError {
        let place = Place::new(SourceText::new(self.file, self.source), at);
        ShaderError(Diagnostic::new(message, place, label).with_note(note).to_string())
    }
}

/// Checks declarations at module scope: names with the codec's prefix; no variables, attributes or directives. A pass
/// may have an entry point and workgroup variables.
pub fn declarations(snippet: &Snippet<'_>) -> Result<(), ShaderError> {
    let prefix = format!("{}_", snippet.codec);
    let (noun, pass) = (snippet.noun(), matches!(snippet.role, Role::Pass { .. }));
    let foreign = |at, name: &str| {
        snippet.error(
            &format!("`{name}` does not begin with `{prefix}`"),
            at,
            &format!("declared by the {noun}"),
            &format!("a {noun} declares only names that begin with its codec's id: `{prefix}{name}`"),
        )
    };
    let mut depth = 0_usize;
    let mut tokens = tokens(snippet.source).into_iter().peekable();
    while let Some((at, token)) = tokens.next() {
        match token {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "@" => {
                // Attributes on members and parameters are harmless. On declarations they make bindings and entry
                // points.
                let name = tokens.peek().map_or("", |t| t.1);
                let refused = match name {
                    "group" | "binding" | "vertex" | "fragment" => true,
                    "compute" | "workgroup_size" => !pass,
                    _ => false,
                };
                if refused {
                    let end = tokens.peek().map_or(at.end, |t| t.0.end);
                    return Err(snippet.error(
                        &format!("a {noun} has no `@{name}`"),
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
                    &format!("a {noun} has no `{token}` directive"),
                    at,
                    "directives must stand at the head of the whole shader",
                    "write it in core WGSL",
                ));
            }
            "override" if depth == 0 => {
                return Err(snippet.error(
                    &format!("a {noun} has no `override`"),
                    at,
                    "nobody gives it a value",
                    "declare a constant in the codec, or a `const` here",
                ));
            }
            "var" if depth == 0 => {
                if pass && tokens.next_if(|(_, token)| *token == "workgroup").is_some() {
                    match tokens.peek() {
                        Some((at, name)) if !name.starts_with(&prefix) => {
                            return Err(foreign(at.clone(), name));
                        }
                        _ => continue,
                    }
                }
                let but = if pass { " but those of its workgroup" } else { "" };
                return Err(snippet.error(
                    &format!("a {noun} has no variables at module scope{but}"),
                    at,
                    "state or binding declared here",
                    "pass values as parameters; declare buffers in the codec",
                ));
            }
            "fn" | "const" | "struct" | "alias" if depth == 0 => {
                if let Some((name_at, name)) = tokens.peek()
                    && !name.starts_with(&prefix)
                {
                    return Err(foreign(name_at.clone(), name));
                }
            }
            _ => {}
        }
    }
    // Before naga parses the text: it would blame the template that calls the missing function.
    let wanted = match snippet.role {
        Role::Voxel { cell } => {
            let fetch_cell = cell.then(|| (format!("{prefix}fetch_cell"), FETCH_CELL));
            [Some((format!("{prefix}fetch"), FETCH)), fetch_cell]
        }
        Role::Pass { entry } => [Some((entry.to_owned(), "(..)")), None],
    };
    let declared = declared_functions(snippet.source);
    for (name, signature) in wanted.into_iter().flatten() {
        if !declared.iter().any(|(_, n)| *n == name) {
            let message = format!("the {noun} declares no function `{name}`");
            let attributes = if pass { "@compute @workgroup_size(..) " } else { "" };
            let note = format!("the contract is `{attributes}fn {name}{signature}`");
            return Err(snippet.error(&message, 0..0, "nowhere in this file", &note));
        }
    }
    Ok(())
}

/// Checks signatures. Bindings must not be read directly. Built-ins must have the precision that the contract requires.
pub fn contract(
    snippet: &Snippet<'_>,
    module: &naga::Module,
    mapped: &Mapped<'_>,
) -> Result<(), ShaderError> {
    match snippet.role {
        Role::Voxel { cell } => {
            let name = format!("{}_fetch", snippet.codec);
            require(snippet, module, &name, FETCH, |f| {
                parameters(module, f, 1) && f.result.as_ref().is_some_and(|r| is_vec4f(module, r.ty))
            })?;
            if cell {
                let name = format!("{}_fetch_cell", snippet.codec);
                require(snippet, module, &name, FETCH_CELL, |f| {
                    parameters(module, f, 2) && f.result.as_ref().is_some_and(|r| is_cell(module, r.ty))
                })?;
            }
        }
        Role::Pass { entry } => workgroup(snippet, module, entry)?,
    }
    let own = declared_functions(snippet.source);
    let functions = module.functions.iter().map(|(_, f)| (f.name.as_deref(), f));
    let entries = module.entry_points.iter().map(|e| (Some(e.name.as_str()), &e.function));
    for (name, function) in functions.chain(entries) {
        if !name.is_some_and(|n| own.iter().any(|(_, own)| *own == n)) {
            continue;
        }
        for (handle, expression) in function.expressions.iter() {
            let problem = match expression {
                // [`declarations`] let only workgroup variables pass.
                Expression::GlobalVariable(variable)
                    if module.global_variables[*variable].space != AddressSpace::WorkGroup =>
                {
                    let name = module.global_variables[*variable].name.as_deref().unwrap_or("?");
                    Some((
                        format!("a {} does not touch the binding `{name}`", snippet.noun()),
                        "used directly",
                        "use buffers through their accessors, which may split a buffer",
                    ))
                }
                Expression::Math { fun, .. } if forbidden(*fun) => Some((
                    format!("a {} does not use `{}`", snippet.noun(), wgsl_name(*fun)),
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

/// A pass has one entry point, whose workgroup every device can run.
fn workgroup(snippet: &Snippet<'_>, module: &naga::Module, entry: &str) -> Result<(), ShaderError> {
    let declared = declared_functions(snippet.source);
    let error = |name: &str, message: &str, note: &str| {
        let at = declared.iter().find(|(_, n)| *n == name).map_or(0..0, |(at, _)| at.clone());
        Err(snippet.error(message, at, "declared here", note))
    };
    if let Some(other) = module.entry_points.iter().find(|e| e.name != entry) {
        let message = format!("a pass has one entry point, and `{}` is another", other.name);
        return error(&other.name, &message, &format!("the codec says that this one begins at `{entry}`"));
    }
    let Some(found) = module.entry_points.first() else {
        let note = format!("the contract is `@compute @workgroup_size(..) fn {entry}(..)`");
        return error(entry, &format!("`{entry}` is no entry point"), &note);
    };
    let ([x, y, z], (most, invocations)) = (found.workgroup_size, WORKGROUP);
    let all = u64::from(x) * u64::from(y) * u64::from(z);
    if x > most[0] || y > most[1] || z > most[2] || all > u64::from(invocations) {
        let message = format!("a workgroup of {x}×{y}×{z} is {all} invocations");
        let [x, y, z] = most;
        let note =
            format!("every device runs {invocations}, of at most {x}×{y}×{z}; no other number may be used");
        return error(entry, &message, &note);
    }
    let variables = module.global_variables.iter().map(|(_, v)| v);
    let of_workgroup = variables.filter(|v| v.space == AddressSpace::WorkGroup);
    // No type has the size `None`.
    let size = |v: &naga::GlobalVariable| module.types[v.ty].inner.try_size(module.to_ctx());
    let bytes: u64 = of_workgroup.map(|v| u64::from(size(v).unwrap_or(u32::MAX))).sum();
    if bytes > u64::from(WORKGROUP_BYTES) {
        let message = format!("the variables of this workgroup take {bytes} bytes");
        return error(entry, &message, &format!("every device has {WORKGROUP_BYTES}"));
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
