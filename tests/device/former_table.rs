//! The former transfer function, for tests that must detect it and for measurements: 1024 equal entries over its
//! domain, linear in between.

use cvr_core::render::{Contents, Plan, TransferFunction};
use cvr_core::shader::{Module, Variable};

const ENTRIES: usize = 1024;

/// The same plan, with passes that read such a table.
pub fn with_table(plan: &Plan, function: &TransferFunction) -> Plan {
    let domain = function.domain();
    let entry = |i: usize| {
        let t = i as f64 / (ENTRIES - 1) as f64;
        function.classify((f64::from(domain.min) + t * domain.span()) as f32)
    };
    let table: Vec<[f32; 4]> = (0..ENTRIES).map(entry).collect();
    let mut plan = plan.clone();
    let scale = ((ENTRIES - 1) as f64 / domain.span()) as f32;
    for pass in &mut plan.passes {
        let pipeline = &mut pass.pipeline;
        pipeline.modules.push(module(domain.min, scale));
        pipeline.variables.push(Variable::read("former_table", "array<vec4<f32>>"));
        let bytes = bytemuck::cast_slice(&table).to_vec();
        pass.inputs.contents.push(Contents { name: "former_table", bytes });
    }
    plan
}

/// It declares `transfer`, so the shared module of this function is not added.
fn module(offset: f32, scale: f32) -> Module {
    let source = format!(
        "fn transfer(value: f32) -> vec4<f32> {{
    let at = clamp((value - f32({offset:?})) * f32({scale:?}), 0.0, 1023.0);
    let low = min(floor(at), 1022.0);
    let a = former_table[u32(low)];
    let b = former_table[u32(low) + 1u];
    return a + (b - a) * (at - low);
}}
"
    );
    Module::Generated { purpose: "a table of 1024 entries", source }
}
