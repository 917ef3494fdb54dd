//! What a transfer function was before it was exact, for tests that must notice and for measurements beside it: 1024 equal
//! entries over its domain, and straight lines between these.

use cvr_core::render::{Input, Pass, Plan, Template, TransferFunction};
use cvr_core::shader::BindingKind;

const ENTRIES: usize = 1024;

/// The same plan, whose passes read such a table.
pub fn with_table(plan: &Plan, function: &TransferFunction) -> Plan {
    let domain = function.domain();
    let entry = |i: usize| {
        let t = i as f64 / (ENTRIES - 1) as f64;
        function.classify((f64::from(domain.min) + t * domain.span()) as f32)
    };
    let table: Vec<[f32; 4]> = (0..ENTRIES).map(entry).collect();
    let mut plan = plan.clone();
    for pass in &mut plan.passes {
        let (templates, inputs) = match pass {
            Pass::Compute(pass) => (&mut pass.templates, &mut pass.inputs),
            Pass::Raster(pass) => (&mut pass.templates, &mut pass.inputs),
            _ => panic!("a pass without a transfer function"),
        };
        let of_function = |kind: &BindingKind| {
            matches!(kind, BindingKind::TransferTable | BindingKind::TransferSegments(_))
        };
        inputs.retain(|input| !of_function(&input.kind));
        // Inputs are bound in their order.
        let module = module(inputs.len(), domain.min, ((ENTRIES - 1) as f64 / domain.span()) as f32);
        let contents = bytemuck::cast_slice(&table).to_vec();
        inputs.push(Input { kind: BindingKind::OpacityTable, contents });
        let replaced = templates.iter_mut().find(|t| **t == cvr_shaders::TRANSFER);
        *replaced.expect("the template has a transfer function") = module;
    }
    plan
}

/// Its entries are bound in fours, as they were, over the binding of another table that the shader does not use.
fn module(binding: usize, offset: f32, scale: f32) -> Template {
    let text = format!(
        "@group(0) @binding({binding}) var<storage, read> former_table: array<vec4<f32>>;

fn transfer(value: f32) -> vec4<f32> {{
    let at = clamp((value - f32({offset:?})) * f32({scale:?}), 0.0, 1023.0);
    let low = min(floor(at), 1022.0);
    let a = former_table[u32(low)];
    let b = former_table[u32(low) + 1u];
    return a + (b - a) * (at - low);
}}
"
    );
    // A template lives as long as the program; the few of a test may stay.
    Template { file: "former/transfer.wgsl", source: text.leak() }
}
