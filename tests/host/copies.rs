//! Number of copies of a codec's decoder in a shader after inlining of all calls, as software rasterisers compile it.

use std::collections::HashMap;
use std::sync::Mutex;

use cvr_core::shader::{GeneratedShader, MOST_INLINED_OPERATIONS};

/// The functions that a block calls, itself or in inner blocks.
pub fn calls_of(block: &naga::Block, callees: &mut Vec<naga::Handle<naga::Function>>) {
    for statement in block {
        match statement {
            naga::Statement::Call { function, .. } => callees.push(*function),
            naga::Statement::Block(inner) => calls_of(inner, callees),
            naga::Statement::If { accept, reject, .. } => {
                [accept, reject].into_iter().for_each(|b| calls_of(b, callees));
            }
            naga::Statement::Loop { body, continuing, .. } => {
                [body, continuing].into_iter().for_each(|b| calls_of(b, callees));
            }
            naga::Statement::Switch { cases, .. } => {
                cases.iter().for_each(|case| calls_of(&case.body, callees));
            }
            _ => {}
        }
    }
}

/// Copies of functions in the entry point of a text, over all call paths. Loops count once, and so does one of these functions
/// that calls another.
pub fn copies(text: &str, entry: &str, names: &[&str]) -> u64 {
    let module = naga::front::wgsl::parse_str(text).unwrap();
    // A function stands behind all that it calls.
    let mut of_functions: Vec<u64> = Vec::new();
    let called = |function: &naga::Function, of_functions: &[u64]| {
        let mut callees = Vec::new();
        calls_of(&function.body, &mut callees);
        callees.iter().map(|callee| of_functions[callee.index()]).sum::<u64>()
    };
    for (_, function) in module.functions.iter() {
        let is_one = function.name.as_deref().is_some_and(|name| names.contains(&name));
        of_functions.push(if is_one { 1 } else { called(function, &of_functions) });
    }
    let entry = module.entry_points.iter().find(|e| e.name == entry).unwrap();
    called(&entry.function, &of_functions)
}

/// Copies of a codec's `fetch` and `fetch_cell`. Texts are analysed once.
pub fn decoders(codec: &str, shader: &GeneratedShader) -> u64 {
    static COUNTED: Mutex<Option<HashMap<blake3::Hash, u64>>> = Mutex::new(None);
    let asked = format!("{codec} {} {}", shader.entry, shader.wgsl);
    let key = blake3::hash(asked.as_bytes());
    if let Some(copies) = COUNTED.lock().unwrap().get_or_insert_default().get(&key) {
        return *copies;
    }
    let [fetch, cell] = ["fetch", "fetch_cell"].map(|function| format!("{codec}_{function}"));
    let copies = copies(&shader.wgsl, &shader.entry, &[&fetch, &cell]);
    COUNTED.lock().unwrap().get_or_insert_default().insert(key, copies);
    copies
}

/// The guarantee of the generator: a shader contains one copy of a decoder, or else the whole shader is short.
pub fn held(codec: &str, shader: &GeneratedShader) -> Result<(), String> {
    let operations = shader.inlined_operations;
    if operations <= MOST_INLINED_OPERATIONS {
        return Ok(());
    }
    let copies = decoders(codec, shader);
    if copies > 1 { Err(format!("{copies} copies of `{codec}` in {operations} operations")) } else { Ok(()) }
}
