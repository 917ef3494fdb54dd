//! The snippet with hand-written accessors, so that a codec's own tests hold it to naga without a generator.

use std::fmt::Write as _;

use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::codec::{CodecInfo, ConstantValue, ShaderDecode};
use crate::volume::FrameIndex;

/// What is wrong with the snippet of a stream, if anything.
pub fn problem(info: &CodecInfo, shader: &dyn ShaderDecode) -> Option<String> {
    let id = info.id;
    let module = shader.module();
    if module.source.contains("@group") {
        return Some("the snippet declares a binding".to_owned());
    }
    let text = match with_accessors(id, shader) {
        Ok(text) => text,
        Err(e) => return Some(e),
    };
    let parsed = match naga::front::wgsl::parse_str(&text) {
        Ok(parsed) => parsed,
        Err(e) => return Some(e.emit_to_string(&text)),
    };
    if let Err(e) = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&parsed) {
        return Some(e.emit_to_string(&text));
    }
    let prefix = format!("{id}_");
    let names = parsed.functions.iter().filter_map(|(_, f)| f.name.as_deref());
    let names = names.chain(parsed.types.iter().filter_map(|(_, t)| t.name.as_deref()));
    let names = names.chain(parsed.constants.iter().filter_map(|(_, c)| c.name.as_deref()));
    let foreign: Vec<&str> = names.filter(|n| !n.starts_with(&prefix)).collect();
    if !foreign.is_empty() {
        return Some(format!("names that do not begin with `{prefix}`: {}", foreign.join(", ")));
    }
    let has = |name: &str| parsed.functions.iter().any(|(_, f)| f.name.as_deref() == Some(name));
    let cell = format!("{id}_fetch_cell");
    (has(&cell) != info.fetch_cell)
        .then(|| format!("info says fetch_cell = {}, the snippet differs", info.fetch_cell))
}

/// Constants, one binding and one accessor per resource, the snippet, and a caller that fixes the signatures.
fn with_accessors(id: &str, shader: &dyn ShaderDecode) -> Result<String, String> {
    let mut text = String::new();
    let mut line = |s: String| writeln!(text, "{s}").map_err(|e| e.to_string());
    let module = shader.module();
    for constant in &module.constants {
        let value = match constant.value {
            ConstantValue::U32(v) => format!("u32 = {v}u"),
            ConstantValue::F32(v) if v.is_finite() => format!("f32 = {v:e}f"),
            ConstantValue::F32(v) => return Err(format!("constant `{}` is {v}", constant.name)),
            ConstantValue::Vec3U32([x, y, z]) => format!("vec3<u32> = vec3<u32>({x}u, {y}u, {z}u)"),
        };
        line(format!("const {id}_{}: {value};", constant.name))?;
    }
    let resources = shader.resources(FrameIndex::FIRST).map_err(|e| e.to_string())?;
    for (i, resource) in resources.iter().enumerate() {
        let name = resource.name;
        line(format!("@group(0) @binding({i}) var<storage, read> {id}_words_{name}: array<u32>;"))?;
        line(format!("fn {id}_{name}(i: u32) -> u32 {{ return {id}_words_{name}[i]; }}"))?;
    }
    line(module.source.to_owned())?;
    line(format!("fn {id}_probe(p: vec3<i32>) -> vec4<f32> {{ return {id}_fetch(p); }}"))?;
    if module.source.contains(&format!("fn {id}_fetch_cell(")) {
        let call = format!("return {id}_fetch_cell(p, q);");
        line(format!("fn {id}_probe_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {{ {call} }}"))?;
    }
    Ok(text)
}
