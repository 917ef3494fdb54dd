//! No circles of imports: no two files of a crate use each other, directly or through others.

mod modules;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use modules::read_crate;

/// The circles: sets of files in which each file depends, directly or indirectly, on all others.
fn circles<'a>(of: &BTreeMap<&'a Path, BTreeSet<&'a Path>>) -> Vec<BTreeSet<&'a Path>> {
    let reach = |from: &'a Path| {
        let mut seen: BTreeSet<&Path> = BTreeSet::new();
        let mut open = vec![from];
        while let Some(file) = open.pop() {
            open.extend(of.get(file).into_iter().flatten().copied().filter(|next| seen.insert(next)));
        }
        seen
    };
    let reached: BTreeMap<&Path, BTreeSet<&Path>> = of.keys().map(|file| (*file, reach(file))).collect();
    let mut found: Vec<BTreeSet<&Path>> = Vec::new();
    for (file, below) in reached.iter().filter(|(file, below)| below.contains(*file)) {
        if !found.iter().any(|circle| circle.contains(file)) {
            found.push(below.iter().copied().filter(|other| reached[other].contains(file)).collect());
        }
    }
    found
}

/// The crates of the workspace, each by its root file.
fn crates() -> Vec<String> {
    let pattern = |pattern: &str| glob::glob(&format!("{}/{pattern}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let all = [
        "src/lib.rs",
        "core/src/lib.rs",
        "codecs/*/src/lib.rs",
        "renderers/*/src/lib.rs",
        "shaders/src/lib.rs",
    ];
    let found = all.into_iter().flat_map(pattern).map(|path| path.unwrap().to_str().unwrap().to_owned());
    found.collect()
}

/// A circle as a message: each file, and the files of the circle that it uses.
fn described(circle: &BTreeSet<&Path>, of: &BTreeMap<&Path, BTreeSet<&Path>>) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let short = |path: &Path| path.strip_prefix(root).unwrap_or(path).display().to_string();
    let line = |file: &&Path| {
        let used: Vec<String> = of[file].intersection(circle).map(|other| short(other)).collect();
        format!("  {} uses {}", short(file), used.join(", "))
    };
    circle.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn no_files_use_each_other() {
    let mut files = 0;
    let mut problems = Vec::new();
    for root in crates() {
        let all = read_crate(Path::new(&root), &|path| std::fs::read_to_string(path).ok());
        let of = all.dependencies();
        files += of.len();
        problems.extend(circles(&of).iter().map(|circle| described(circle, &of)));
    }
    assert!(files > 300, "{files} files were found");
    assert!(problems.is_empty(), "circles of imports:\n{}", problems.join("\n\n"));
}

/// The circles of a crate that consists of these files.
fn circles_of(files: &[(&str, &str)]) -> Vec<Vec<String>> {
    let text = |path: &Path| {
        let found = files.iter().find(|(name, _)| Path::new(name) == path);
        found.map(|(_, text)| (*text).to_owned())
    };
    let all = read_crate(Path::new("lib.rs"), &text);
    let of = all.dependencies();
    let names = |circle: &BTreeSet<&Path>| circle.iter().map(|file| file.display().to_string()).collect();
    circles(&of).iter().map(names).collect()
}

#[test]
fn a_circle_is_found_however_it_is_written() {
    let root = "pub use b::B; mod a; mod b; mod c;";
    let rest = [("b.rs", "use super::c::C; pub struct B;"), ("lib.rs", root)];
    let c = "pub struct C; fn f() { crate::a::A; }";
    for a in [
        "use crate::b::B; pub struct A;",
        // Handed on by the root.
        "use crate::B; pub struct A;",
        "use super::*; pub struct A(B);",
        "use crate::b; pub struct A(b::B);",
        "use super::b::{self as other}; pub struct A; fn f() { println!(\"{}\", other::B); }",
        "pub struct A; mod inner { use crate::b::B as Renamed; }",
    ] {
        let mut files = rest.to_vec();
        files.extend([("a.rs", a), ("c.rs", c)]);
        assert_eq!(circles_of(&files), [["a.rs", "b.rs", "c.rs"]], "{a}");
    }
}

#[test]
fn a_function_may_have_the_name_of_its_module() {
    let root = "pub use b::b; mod a; mod b;";
    let b = "pub fn b(_: super::a::A) {}";
    for a in ["pub struct A; fn f() { crate::b(); }", "use crate::b; pub struct A;"] {
        assert_eq!(circles_of(&[("lib.rs", root), ("a.rs", a), ("b.rs", b)]), [["a.rs", "b.rs"]], "{a}");
    }
    // In a module of such a name, `self` is a value and not the function.
    let root = "pub use b::a; mod a; mod b;";
    let a = "pub struct A; impl A { fn f(&self) -> &Self { self } }";
    let b = "pub fn a(_: super::a::A) {}";
    assert_eq!(circles_of(&[("lib.rs", root), ("a.rs", a), ("b.rs", b)]), Vec::<Vec<String>>::new());
}

#[test]
fn what_is_no_circle_is_none() {
    let root = "mod a; mod b; pub struct Root;";
    for (a, b) in [
        ("use super::b::B; use super::Root; pub struct A;", "pub struct B;"),
        // Tests may use anything.
        ("use super::b::B; pub struct A;", "pub struct B; #[cfg(test)] mod tests { use crate::a::A; }"),
        // A name of another crate, and one of a module within the file.
        ("use super::b::B; pub struct A;", "use std::a::A; mod a { pub struct A; } pub struct B(a::A);"),
    ] {
        assert_eq!(
            circles_of(&[("lib.rs", root), ("a.rs", a), ("b.rs", b)]),
            Vec::<Vec<String>>::new(),
            "{b}"
        );
    }
}
