//! Which files of a crate use definitions of others.
//!
//! A file depends on the file that defines an item it names. For a re-export (`pub use`), the definition counts. A
//! module is part of its parent and may use the parent's definitions. Tests are left out: they may use anything.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemMod, ItemUse, Macro, UseTree};

/// Names from the root of the crate down.
type Names = Vec<String>;

/// A module: its definitions, its imports, and the paths that it names.
#[derive(Default)]
struct Module {
    file: PathBuf,
    children: BTreeSet<String>,
    /// Name in this module → the path that was imported.
    imports: BTreeMap<String, Names>,
    /// Modules with all names imported.
    globs: Vec<Names>,
    defined: BTreeSet<String>,
    paths: BTreeSet<Names>,
}

/// The modules of a crate by their path.
pub struct Crate(BTreeMap<Names, Module>);

/// Reads `lib.rs` or `main.rs` and all modules below it. `read` returns the text of a file, if it exists.
pub fn read_crate(root: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Crate {
    let mut modules = Crate(BTreeMap::new());
    let folder = root.parent().unwrap_or(Path::new(""));
    modules.read_file(Vec::new(), root, folder, read);
    modules
}

impl Crate {
    fn read_file(&mut self, at: Names, file: &Path, below: &Path, read: &dyn Fn(&Path) -> Option<String>) {
        let text = read(file).unwrap_or_else(|| panic!("{} is missing", file.display()));
        let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        self.read_items(at, file, below, &parsed.items, read);
    }

    fn read_items(
        &mut self,
        at: Names,
        file: &Path,
        below: &Path,
        items: &[Item],
        read: &dyn Fn(&Path) -> Option<String>,
    ) {
        let mut reader = Reader { at: &at, module: Module { file: file.to_owned(), ..Module::default() } };
        for item in items {
            reader.item(item);
        }
        self.0.insert(at.clone(), reader.module);
        for child in items.iter().filter_map(|item| match item {
            Item::Mod(child) if !is_test(&child.attrs) => Some(child),
            _ => None,
        }) {
            let name = child.ident.to_string();
            let mut path = at.clone();
            path.push(name.clone());
            let below = below.join(&name);
            match &child.content {
                Some((_, items)) => self.read_items(path, file, &below, items, read),
                None => {
                    let flat = below.with_extension("rs");
                    let file = if read(&flat).is_some() { flat } else { below.join("mod.rs") };
                    self.read_file(path, &file, &below, read);
                }
            }
        }
    }

    /// The module that defines the last name of a path. `None` for a module itself, and for items of other crates.
    fn definer(&self, path: &[String], budget: u32) -> Option<Names> {
        let mut at: Names = Vec::new();
        for (i, name) in path.iter().enumerate() {
            let module = self.0.get(&at)?;
            // What stands last is a module only where nothing else has its name.
            let names_item =
                i + 1 == path.len() && (module.defined.contains(name) || module.imports.contains_key(name));
            if module.children.contains(name) && !names_item {
                at.push(name.clone());
                continue;
            }
            if module.defined.contains(name) {
                return Some(at);
            }
            if budget == 0 {
                return None;
            }
            if let Some(import) = module.imports.get(name) {
                let whole: Names = import.iter().chain(&path[i + 1..]).cloned().collect();
                return self.definer(&whole, budget - 1);
            }
            return module.globs.iter().find_map(|glob| {
                let whole: Names = glob.iter().chain(&path[i..]).cloned().collect();
                self.definer(&whole, budget - 1)
            });
        }
        None
    }

    /// File → the files that it depends on.
    pub fn dependencies(&self) -> BTreeMap<&Path, BTreeSet<&Path>> {
        let mut all: BTreeMap<&Path, BTreeSet<&Path>> = BTreeMap::new();
        for (at, module) in &self.0 {
            let targets = all.entry(&module.file).or_default();
            for path in &module.paths {
                // A path begins at the root, or with a name of this module.
                let whole: Names = match path[0].as_str() {
                    "crate" => path[1..].to_vec(),
                    _ => at.iter().chain(path).cloned().collect(),
                };
                let definer = self.definer(&whole, 16).filter(|definer| !at.starts_with(definer));
                let definer = definer.and_then(|definer| self.0.get(&definer));
                targets.extend(definer.map(|d| d.file.as_path()).filter(|file| *file != module.file));
            }
        }
        all
    }
}

/// Collects what one module defines and names.
struct Reader<'a> {
    at: &'a Names,
    module: Module,
}

impl Reader<'_> {
    fn item(&mut self, item: &Item) {
        let name = match item {
            Item::Const(i) => Some(&i.ident),
            Item::Enum(i) => Some(&i.ident),
            Item::Fn(i) => Some(&i.sig.ident),
            Item::Static(i) => Some(&i.ident),
            Item::Struct(i) => Some(&i.ident),
            Item::Trait(i) => Some(&i.ident),
            Item::Type(i) => Some(&i.ident),
            Item::Union(i) => Some(&i.ident),
            Item::Macro(i) => i.ident.as_ref(),
            Item::Mod(i) if !is_test(&i.attrs) => {
                self.module.children.insert(i.ident.to_string());
                None
            }
            _ => None,
        };
        self.module.defined.extend(name.map(ToString::to_string));
        self.visit_item(item);
    }

    /// A path from the root of the crate. `None` if it begins neither at the root nor in a parent module.
    fn absolute(&self, path: &[String]) -> Option<Names> {
        let mut at = self.at.clone();
        let mut rest = path;
        match rest.first()?.as_str() {
            "crate" => return Some(rest[1..].to_vec()),
            "self" => rest = &rest[1..],
            "super" => {
                while rest.first().is_some_and(|name| name == "super") {
                    at.pop();
                    rest = &rest[1..];
                }
            }
            _ => {}
        }
        at.extend_from_slice(rest);
        Some(at)
    }

    fn path(&mut self, names: Names) {
        let relative = !["crate", "self", "super"].contains(&names[0].as_str());
        // A value, or how far an item is seen: no item's name.
        if !relative && names.len() == 1 {
            return;
        }
        if relative {
            self.module.paths.insert(names);
        } else if let Some(path) = self.absolute(&names) {
            self.module.paths.insert(std::iter::once("crate".to_owned()).chain(path).collect());
        }
    }

    fn import(&mut self, tree: &UseTree, before: &Names, handed_on: bool) {
        let with = |name: &syn::Ident| before.iter().cloned().chain([name.to_string()]).collect::<Names>();
        match tree {
            UseTree::Path(path) => self.import(&path.tree, &with(&path.ident), handed_on),
            UseTree::Group(group) => group.items.iter().for_each(|t| self.import(t, before, handed_on)),
            UseTree::Glob(_) => {
                let path = self.absolute(before).unwrap_or_default();
                self.module.globs.push(path);
            }
            UseTree::Name(name) if name.ident == "self" => {
                self.imported(before.last().cloned().unwrap_or_default(), before.clone(), handed_on);
            }
            UseTree::Name(name) => self.imported(name.ident.to_string(), with(&name.ident), handed_on),
            UseTree::Rename(rename) if rename.ident == "self" => {
                self.imported(rename.rename.to_string(), before.clone(), handed_on);
            }
            UseTree::Rename(rename) => {
                self.imported(rename.rename.to_string(), with(&rename.ident), handed_on);
            }
        }
    }

    fn imported(&mut self, name: String, path: Names, handed_on: bool) {
        let absolute = self.absolute(&path).unwrap_or_default();
        self.module.imports.insert(name, absolute.clone());
        if !handed_on {
            self.module.paths.insert(std::iter::once("crate".to_owned()).chain(absolute).collect());
        }
    }

    /// Paths in the arguments of a macro, which have no syntax of their own.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Names = Vec::new();
        let mut colons = 0;
        let finish = |path: &mut Names, reader: &mut Self| {
            if path.len() > 1 {
                reader.path(std::mem::take(path));
            }
            path.clear();
        };
        for token in tokens {
            match token {
                TokenTree::Ident(name) => {
                    if colons != 2 {
                        finish(&mut path, self);
                    }
                    path.push(name.to_string());
                    colons = 0;
                }
                TokenTree::Punct(p) if p.as_char() == ':' => colons += 1,
                TokenTree::Group(group) => {
                    finish(&mut path, self);
                    colons = 0;
                    self.tokens(group.stream());
                }
                _ => {
                    finish(&mut path, self);
                    colons = 0;
                }
            }
        }
        finish(&mut path, self);
    }
}

impl<'a> Visit<'a> for Reader<'_> {
    fn visit_item(&mut self, item: &'a Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, _: &'a ItemMod) {}

    fn visit_item_use(&mut self, item: &'a ItemUse) {
        let handed_on = !matches!(item.vis, syn::Visibility::Inherited);
        self.import(&item.tree, &Vec::new(), handed_on);
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        if path.leading_colon.is_none() {
            self.path(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, mac: &'a Macro) {
        self.tokens(mac.tokens.clone());
        visit::visit_macro(self, mac);
    }
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(i) => &i.attrs,
        Item::Enum(i) => &i.attrs,
        Item::Fn(i) => &i.attrs,
        Item::Impl(i) => &i.attrs,
        Item::Macro(i) => &i.attrs,
        Item::Mod(i) => &i.attrs,
        Item::Static(i) => &i.attrs,
        Item::Struct(i) => &i.attrs,
        Item::Trait(i) => &i.attrs,
        Item::Type(i) => &i.attrs,
        Item::Use(i) => &i.attrs,
        _ => &[],
    }
}

/// Whether `#[cfg(test)]` stands before an item.
fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| {
        a.path().is_ident("cfg") && a.parse_args::<syn::Path>().is_ok_and(|path| path.is_ident("test"))
    })
}
