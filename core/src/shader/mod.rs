//! The shader generator: splices a codec's snippet into a renderer's template.
//!
//! Module scope in WGSL has no order, so texts can be concatenated. The generator writes constants, bindings and
//! accessors, parses the result with naga, checks the snippet's contract, validates, and maps every error to the
//! author's own file and line.

mod accessors;
mod deferred;
mod error;
mod form;
mod frame_pass;
mod generate;
mod inlined;
mod lint;
mod origin;
mod program;
mod request;
mod resolve;
mod resources;
mod segments;
#[cfg(test)]
mod tests;
mod text;
mod tokens;

pub use deferred::{DeferredError, DeferredShaders, generate_decode, voxels_per_invocation};
pub use error::ShaderError;
pub use form::{Form, MOST_INLINED_OPERATIONS};
pub use frame_pass::{PassShader, generate_passes};
pub use generate::{draft, generate};
pub use origin::{Origin, Segment};
pub use program::{Module, Program, Variable};
pub use request::{
    Binding, BindingKind, BindingLimits, Draft, GeneratedShader, Request, ResourceSize, Source,
    TextureSampling, UniformMember,
};
pub use resources::snippet_resources;
pub use segments::transfer_segments;
