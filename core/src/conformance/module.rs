//! Snippets and passes in the real generator: parsed, checked against their contract, validated.

use cvr_shaders::{DUMP, DUMP_CELL, Template};

use crate::codec::{CodecInfo, Decoder, ShaderDecode, Site};
use crate::shader::{
    BindingLimits, DeferredShaders, Program, Request, ResourceSize, Source, generate, snippet_resources,
};
use crate::volume::{FrameIndex, Level};

/// The problem with a stream's snippet, if any.
pub fn problem(info: &CodecInfo, decoder: &dyn Decoder, shader: &dyn ShaderDecode) -> Option<String> {
    if let Err(problem) = dump_shader(info, decoder, shader, DUMP) {
        return Some(problem);
    }
    match (info.fetch_cell, dump_shader(info, decoder, shader, DUMP_CELL)) {
        (true, Err(problem)) => Some(problem),
        (false, Ok(())) => {
            Some("info says fetch_cell = false, but the snippet has a sound `fetch_cell`".to_owned())
        }
        _ => None,
    }
}

/// The problem with the shaders that the site *deferred* runs for a codec with passes, if any.
pub fn frame_problem(info: &CodecInfo, decoder: &dyn Decoder) -> Option<String> {
    if !info.offers(Site::Deferred) {
        return Some("it brings passes for whole frames, but info does not list site deferred".to_owned());
    }
    let (key, format) = ((FrameIndex::FIRST, Level::FULL), decoder.decoded_form().format);
    let shaders = DeferredShaders::generate(info.id, decoder, key, format, BindingLimits::default());
    shaders.err().map(|e| e.to_string())
}

fn dump_shader(
    info: &CodecInfo,
    decoder: &dyn Decoder,
    shader: &dyn ShaderDecode,
    template: Template,
) -> Result<(), String> {
    let key = (FrameIndex::FIRST, Level::FULL);
    let resources = snippet_resources(info.id, decoder, shader, key).map_err(|e| e.to_string())?;
    let request = Request {
        program: &Program::dump(template),
        layout: decoder.layout(),
        source: Source::Inline {
            codec: info.id,
            module: shader.module(),
            resources: resources.iter().map(ResourceSize::of).collect(),
            frame: FrameIndex::FIRST,
            level: Level::FULL,
        },
        filter: None,
        limits: BindingLimits::default(),
    };
    generate(&request).map(|_| ()).map_err(|e| e.to_string())
}
