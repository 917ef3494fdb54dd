//! The modules and variables that a program needs. They are found by the names that texts declare and use.

use std::borrow::Cow;
use std::collections::{BTreeSet, VecDeque};
use std::sync::LazyLock;

use cvr_shaders::Template;

use super::tokens::{Names, names};
use super::{Form, Module, Program, ShaderError, Variable};

/// The needs of a program.
pub struct Resolved {
    /// Shared modules in the order of their table, then offered modules, then the program's own.
    pub modules: Vec<Module>,
    /// In the order of the program.
    pub variables: Vec<Variable>,
}

impl Resolved {
    /// Whether a module contains `text`. `function(` matches a call or a declaration.
    pub fn mentions(&self, text: &str) -> bool {
        self.modules.iter().any(|module| module.source().contains(text))
    }
}

/// The modules and variables of a program in one of its forms.
///
/// The voxel source may still declare a name that no module declares. So only the parser knows which names are missing.
///
/// # Errors
/// When two of the offered modules declare a name that is used.
pub fn resolve(program: &Program, form: Form) -> Result<Resolved, ShaderError> {
    let in_form = |module: &Module| match module {
        Module::File(template) => Module::File(form.of(*template)),
        generated @ Module::Generated { .. } => generated.clone(),
    };
    let own: Vec<Module> = program.modules.iter().map(in_form).collect();
    let offered: Vec<Module> = program.offered.iter().map(in_form).collect();
    let offered: Vec<(&Module, Cow<'_, Names<'_>>)> = offered.iter().map(|m| (m, names_of(m))).collect();

    let mut needs =
        Needs { program, declared: BTreeSet::new(), variables: BTreeSet::new(), open: VecDeque::new() };
    own.iter().for_each(|module| needs.add(&names_of(module)));
    let mut used: Vec<((usize, usize), Module)> = Vec::new();
    while let Some(name) = needs.open.pop_front() {
        if needs.declared.contains(&name) {
            continue;
        }
        let declares =
            |(_, (_, names)): &(usize, &(&Module, Cow<'_, Names<'_>>))| names.declares.contains(&*name);
        let mut found = offered.iter().enumerate().filter(declares);
        match (found.next(), found.next()) {
            (Some((_, (first, _))), Some((_, (second, _)))) => {
                let (first, second) = (first.name(), second.name());
                return Err(ShaderError(format!("`{name}` is offered twice, by {first} and {second}")));
            }
            (Some((offer, (module, names))), None) => {
                needs.add(names);
                used.push((place(module).map_or((1, offer), |place| (0, place)), (*module).clone()));
            }
            (None, _) => {
                if let [(place, only, names)] = shared_modules(&name)[..] {
                    needs.add(names);
                    used.push(((0, place), Module::File(*only)));
                }
            }
        }
    }
    used.sort_by_key(|(place, _)| *place);
    let modules = used.into_iter().map(|(_, module)| module).chain(own).collect();
    let variables = needs.variables.into_iter().map(|i| program.variables[i]).collect();
    Ok(Resolved { modules, variables })
}

/// The declarations found so far, and the names still to find.
struct Needs<'p> {
    program: &'p Program,
    declared: BTreeSet<String>,
    variables: BTreeSet<usize>,
    open: VecDeque<String>,
}

impl Needs<'_> {
    fn add(&mut self, names: &Names<'_>) {
        self.declared.extend(names.declares.iter().map(|&name| name.to_owned()));
        self.open.extend(names.uses.iter().map(|&name| name.to_owned()));
        for (i, variable) in self.program.variables.iter().enumerate() {
            let (used, its_struct) = match variable {
                Variable::Uniform { name, wgsl_type } => (names.inputs.contains(name), Some(*wgsl_type)),
                Variable::Storage { name, .. } | Variable::Table { name, .. } => {
                    (names.uses.contains(name), None)
                }
            };
            if used && self.variables.insert(i) {
                self.open.extend(its_struct.map(str::to_owned));
            }
        }
    }
}

/// The shared modules and their names, in the order of their table.
static SHARED: LazyLock<Vec<(Template, Names<'static>)>> =
    LazyLock::new(|| cvr_shaders::ALL.iter().map(|template| (*template, names(template.source))).collect());

/// A module's place among the shared ones.
fn place(module: &Module) -> Option<usize> {
    SHARED.iter().position(|(shared, _)| matches!(module, Module::File(template) if template == shared))
}

fn names_of(module: &Module) -> Cow<'_, Names<'_>> {
    match place(module) {
        Some(place) => Cow::Borrowed(&SHARED[place].1),
        None => Cow::Owned(names(module.source())),
    }
}

/// The shared modules that declare a name, with their places.
pub fn shared_modules(name: &str) -> Vec<(usize, &'static Template, &'static Names<'static>)> {
    let all = SHARED.iter().enumerate();
    let declare = all.filter(|(_, (_, names))| names.declares.contains(name));
    declare.map(|(place, (template, names))| (place, template, names)).collect()
}

#[cfg(test)]
mod tests {
    use cvr_shaders as shaders;

    use super::*;

    fn module(purpose: &'static str, source: &str) -> Module {
        Module::Generated { purpose, source: source.to_owned() }
    }

    fn program(modules: &[Module], offered: &[Module]) -> Program {
        let variables = vec![
            Variable::Uniform { name: "view", wgsl_type: "View" },
            Variable::read("heights", "array<f32>"),
        ];
        Program { modules: modules.to_vec(), offered: offered.to_vec(), entry: "main", variables }
    }

    fn names_of(program: &Program) -> Vec<String> {
        let resolved = resolve(program, Form::Unrolled).unwrap();
        resolved.modules.iter().map(|module| module.name().to_owned()).collect()
    }

    #[test]
    fn what_is_used_comes_and_nothing_else() {
        let main = module("main", "fn main() -> f32 { return slope(1.0) + opacity_over(0.5, 1.0); }");
        let slope = module("slope", "fn slope(x: f32) -> f32 { return x * steep; }");
        let steep = module("steep", "const steep = 2.0;");
        let idle = module("idle", "fn idle() -> f32 { return heights[0]; }");
        let whole = program(&[main], &[idle, slope, steep]);
        assert_eq!(names_of(&whole), ["shaders/classify/opacity.wgsl", "slope", "steep", "main"]);
        assert!(resolve(&whole, Form::Unrolled).unwrap().variables.is_empty());
    }

    #[test]
    fn a_uniform_brings_its_struct_and_what_that_needs() {
        let main = module("main", "fn main() -> f32 { let view = 1.0; return inputs.view.step; }");
        let offered = [shaders::CAMERA_PERSPECTIVE, shaders::BOUNDS_WHOLE].map(Module::from);
        let program = program(&[main], &offered);
        let resolved = resolve(&program, Form::Unrolled).unwrap();
        assert_eq!(resolved.variables, [Variable::Uniform { name: "view", wgsl_type: "View" }]);
        let files = ["view/view", "camera/perspective", "bounds/whole"].map(|f| format!("shaders/{f}.wgsl"));
        assert_eq!(names_of(&program)[..3], files);
    }

    /// Names of parameters, members and locals are not needs.
    #[test]
    fn only_what_is_not_the_modules_own_is_needed() {
        let text = "
            struct Pair { light: f32, transfer: f32 }
            fn main(opacity_over: f32) -> f32 { let trilinear = 1.0; return x.gradient + trilinear + opacity_over; }";
        assert_eq!(names_of(&program(&[module("main", text)], &[])), ["main"]);
    }

    #[test]
    fn what_is_offered_twice_is_an_error_where_it_is_used() {
        let main = module("main", "fn main() -> bool { return may_show(x); }");
        let both = [shaders::MACROCELLS, shaders::EVERY_POINT].map(Module::from);
        let error = resolve(&program(&[main], &both), Form::Unrolled).err().unwrap().to_string();
        assert!(
            error.contains("`may_show` is offered twice") && error.contains("macrocells.wgsl"),
            "{error}"
        );
        assert_eq!(names_of(&program(&[module("main", "fn main() {}")], &both)), ["main"]);
    }
}
