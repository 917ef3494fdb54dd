//! Buffers behind functions. A buffer larger than one binding is split into parts. Callers do not see this.

use std::fmt::Write as _;

use super::{Binding, BindingKind, BindingLimits, ResourceSize, ShaderError};

/// Declarations of buffers in group 1, as they grow.
pub struct Accessors<'a> {
    /// Owner of the buffers, for errors: "codec `raw`".
    owner: &'a str,
    limits: BindingLimits,
    /// Text so far.
    pub text: String,
    /// Bindings so far.
    pub bindings: Vec<Binding>,
}

/// How a buffer is used.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Access {
    /// Through `<name>(i)`.
    pub read: bool,
    /// Through `<setter>(i, word)`, the setter being handed to [`Accessors::add`].
    pub write: bool,
}

impl<'a> Accessors<'a> {
    pub const fn new(owner: &'a str, limits: BindingLimits) -> Self {
        Self { owner, limits, text: String::new(), bindings: Vec::new() }
    }

    /// Adds a buffer of `words` words under `name`. `kind` makes the binding of a part from its first word and its
    /// length.
    ///
    /// # Errors
    /// When an index does not reach its end.
    pub fn add(
        &mut self,
        name: &str,
        setter: &str,
        words: u64,
        access: Access,
        kind: impl Fn(u64, u64) -> BindingKind,
    ) -> Result<(), ShaderError> {
        if words > 1 << 32 {
            return Err(ShaderError(format!(
                "buffer `{name}` of {} has {words} words; a shader's index reaches {}",
                self.owner,
                1_u64 << 32
            )));
        }
        let mode = if access.write { "read_write" } else { "read" };
        let mut parts = Vec::new();
        let mut first = 0;
        while first < words || parts.is_empty() {
            let count = (words - first).min(self.limits.storage_words);
            let (binding, part) = (self.bindings.len() as u32, parts.len());
            parts.push(first);
            let _ = writeln!(
                self.text,
                "@group(1) @binding({binding}) var<storage, {mode}> {name}_part{part}: array<u32>;"
            );
            self.bindings.push(Binding { group: 1, binding, kind: kind(first, count) });
            first += count;
        }
        if access.read {
            let _ = writeln!(self.text, "fn {name}(i: u32) -> u32 {{");
            self.branches(&parts, |part, offset, indent| {
                format!("{indent}return {name}_part{part}[i{offset}];\n")
            });
        }
        if access.write {
            let _ = writeln!(self.text, "fn {setter}(i: u32, word: u32) {{");
            self.branches(&parts, |part, offset, indent| {
                let end = if part + 1 == parts.len() { String::new() } else { format!("{indent}return;\n") };
                format!("{indent}{name}_part{part}[i{offset}] = word;\n{end}")
            });
        }
        Ok(())
    }

    /// The body of an accessor. `of` gives the code for each part: number of the part, offset to subtract from the
    /// index, and indentation.
    fn branches(&mut self, parts: &[u64], of: impl Fn(usize, &str, &str) -> String) {
        for (part, first) in parts.iter().enumerate() {
            let offset = if *first == 0 { String::new() } else { format!(" - {first}u") };
            let _ = match parts.get(part + 1) {
                Some(end) => {
                    writeln!(self.text, "    if i < {end}u {{\n{}    }}", of(part, &offset, "        "))
                }
                None => write!(self.text, "{}", of(part, &offset, "    ")),
            };
        }
        self.text.push_str("}\n");
    }

    /// Text and bindings, if the device can bind this many storage buffers. `others` counts the renderer's.
    ///
    /// # Errors
    /// When it cannot, with both numbers.
    pub fn finish(self, others: u32) -> Result<(String, Vec<Binding>), ShaderError> {
        let used = others + self.bindings.len() as u32;
        let BindingLimits { storage_words, storage_buffers } = self.limits;
        if used > storage_buffers {
            let with = if others > 0 { " with the renderer's own" } else { "" };
            let bytes = storage_words * 4;
            let parts = match bytes >> 20 {
                0 => format!("{bytes} bytes"),
                mebibytes => format!("{mebibytes} MiB"),
            };
            return Err(ShaderError(format!(
                "{} needs {used} storage buffers{with}, in parts of {parts}; the device binds {storage_buffers}",
                self.owner,
            )));
        }
        Ok((self.text, self.bindings))
    }
}

/// Bindings of buffers, and the accessors through which WGSL reads them. Their names begin with `prefix`. Errors name
/// the owner.
pub fn resource_accessors(
    (owner, prefix): (&str, &str),
    resources: &[ResourceSize],
    limits: BindingLimits,
    storage_used: u32,
) -> Result<(String, Vec<Binding>), ShaderError> {
    let mut accessors = Accessors::new(owner, limits);
    for (resource, ResourceSize { name, words }) in resources.iter().enumerate() {
        let read = Access { read: true, write: false };
        accessors.add(&format!("{prefix}_{name}"), "", *words, read, |first, words| BindingKind::Words {
            resource,
            first,
            words,
        })?;
    }
    accessors.finish(storage_used)
}
