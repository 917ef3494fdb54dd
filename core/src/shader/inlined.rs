//! Length of a shader after every call is replaced by the body of the called function.

use naga::{Block, Expression, Function, Literal, Module, Statement};

/// Weight of an operation in a decoder's inner loop. Compilers unroll the short inner loops and branch around the
/// others. The outer loop goes over channels.
const IN_INNER_LOOPS: u64 = 8;

/// Operations by the number of loops around them: none, one, more.
#[derive(Copy, Clone, Default)]
struct Length([u64; 3]);

impl Length {
    fn add(&mut self, loops: usize, operations: u64) {
        let sum = &mut self.0[loops.min(2)];
        *sum = sum.saturating_add(operations);
    }

    /// Adds a length inside `loops` loops.
    fn add_within(&mut self, loops: usize, other: Self) {
        (loops..).zip(other.0).for_each(|(loops, operations)| self.add(loops, operations));
    }

    /// The length, weighted for a decoder.
    fn of_decoder(self) -> Self {
        let [straight, once, inner] = self.0;
        Self([straight.saturating_add(once).saturating_add(inner.saturating_mul(IN_INNER_LOOPS)), 0, 0])
    }
}

/// Number of statements and evaluated expressions of an entry point. Called functions count at every call. Of a branch
/// on a constant, only the reachable side counts: compilers remove the other. In functions named in `decoders`, inner
/// loops count more.
pub fn operations(module: &Module, entry: &str, decoders: &[String]) -> u64 {
    // A function stands behind all that it calls.
    let mut of_functions: Vec<Length> = Vec::with_capacity(module.functions.len());
    for (_, function) in module.functions.iter() {
        let mut length = Length::default();
        add_block(&mut length, 0, (function, &function.body), &of_functions);
        let decodes = function.name.as_ref().is_some_and(|name| decoders.contains(name));
        of_functions.push(if decodes { length.of_decoder() } else { length });
    }
    let mut length = Length::default();
    if let Some(found) = module.entry_points.iter().find(|e| e.name == entry) {
        add_block(&mut length, 0, (&found.function, &found.function.body), &of_functions);
    }
    length.0.into_iter().fold(0, u64::saturating_add)
}

/// Adds a block inside `loops` loops, up to its end or its exit. True if the code behind it is unreachable.
fn add_block(
    length: &mut Length,
    loops: usize,
    (function, block): (&Function, &Block),
    of_functions: &[Length],
) -> bool {
    let within =
        |length: &mut Length, loops, block| add_block(length, loops, (function, block), of_functions);
    for statement in block {
        let left = match statement {
            Statement::Emit(expressions) => {
                length.add(loops, expressions.clone().count() as u64);
                false
            }
            Statement::Block(inner) => within(length, loops, inner),
            Statement::If { condition, accept, reject } => match &function.expressions[*condition] {
                Expression::Literal(Literal::Bool(true)) => within(length, loops, accept),
                Expression::Literal(Literal::Bool(false)) => within(length, loops, reject),
                _ => {
                    length.add(loops, 1);
                    // Both are there, whether the first one is left or not.
                    let [accepted, rejected] = [accept, reject].map(|side| within(length, loops, side));
                    accepted && rejected
                }
            },
            Statement::Switch { cases, .. } => {
                length.add(loops, 1);
                for case in cases {
                    within(length, loops, &case.body);
                }
                false
            }
            Statement::Loop { body, continuing, .. } => {
                length.add(loops, 1);
                within(length, loops + 1, body);
                within(length, loops + 1, continuing);
                false
            }
            Statement::Call { function, .. } => {
                length.add(loops, 1);
                if let Some(of_function) = of_functions.get(function.index()) {
                    length.add_within(loops, *of_function);
                }
                false
            }
            Statement::Return { .. } | Statement::Break | Statement::Continue | Statement::Kill => {
                length.add(loops, 1);
                true
            }
            _ => {
                length.add(loops, 1);
                false
            }
        };
        if left {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Operations of an entry point with this body.
    fn length(body: &str, decoders: &[&str]) -> u64 {
        let text = format!(
            "@group(0) @binding(0) var<storage, read_write> out: array<u32>;
            const never = 3u;
            fn inner(i: u32) {{ out[i] = i * i + out[i + 1u]; }}
            fn outer(i: u32) {{ inner(i); inner(i + 1u); }}
            fn once(n: u32) {{ for (var i = 0u; i < n; i++) {{ inner(i); }} }}
            fn nested(n: u32) {{ for (var i = 0u; i < n; i++) {{ once(i); }} }}
            fn early(i: u32) {{ if never == 3u {{ inner(i); return; }} outer(i); }}
            @compute @workgroup_size(1) fn main() {{ {body} }}"
        );
        let decoders: Vec<String> = decoders.iter().map(|&name| name.to_owned()).collect();
        operations(&naga::front::wgsl::parse_str(&text).unwrap(), "main", &decoders)
    }

    #[test]
    fn a_call_counts_as_often_as_it_stands_and_a_loop_once() {
        let shader = |body| length(body, &[]);
        let [empty, inner, outer] = ["", "inner(1u);", "outer(1u);"].map(shader);
        assert!(empty <= 1 && inner > empty + 5, "{empty}, {inner}");
        assert!(outer > 2 * inner && outer < 2 * inner + 6, "{outer} of two {inner}");
        assert_eq!(shader("outer(1u); outer(2u);") - outer, outer - empty);
        let looped = shader("for (var i = 0u; i < 9u; i++) { outer(i); }");
        assert!(looped > outer && looped < outer + 20, "{looped} around {outer}");
    }

    #[test]
    fn what_a_constant_closes_does_not_count() {
        let shader = |body| length(body, &[]);
        let [empty, inner, outer] = ["", "inner(1u);", "outer(1u);"].map(shader);
        assert_eq!(shader("if never == 3u { inner(1u); } else { outer(1u); }"), inner);
        assert_eq!(shader("if never == 4u { inner(1u); } else { outer(1u); }"), outer);
        assert!(shader("if out[0] == 4u { inner(1u); } else { outer(1u); }") > inner + outer - empty);
        // Code behind a return does not count.
        let early = shader("early(1u);");
        assert!(early > inner && early < inner + 5, "{early}, {inner}");
    }

    #[test]
    fn inner_loops_of_a_decoder_count_more() {
        let [inner, once, nested] = ["inner(1u);", "once(1u);", "nested(1u);"].map(|body| length(body, &[]));
        assert_eq!(length("once(1u);", &["once"]), once, "its only loop goes over channels");
        let decoder = length("nested(1u);", &["nested"]);
        let more = decoder - nested;
        assert_eq!(more % (IN_INNER_LOOPS - 1), 0);
        let within = more / (IN_INNER_LOOPS - 1);
        assert!(within + 2 > inner && within < once, "{within} of {once} lie in the inner loop");
        // Loops of a template around a decoder do not count as the decoder's.
        let around = "for (var i = 0u; i < 9u; i++) { once(i); }";
        assert_eq!(length(around, &["once"]), length(around, &[]));
    }
}
