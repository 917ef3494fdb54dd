//! Links between pages, and mentions of pages in any text of the project, must name existing files.

use std::path::{Path, PathBuf};

use super::folder::Folder;

/// Folders without texts of this project.
const SKIPPED: [&str; 4] = [".git", "target", "results", "shared"];
/// Extensions of files that may mention a page.
const TEXTS: [&str; 8] = ["rs", "md", "toml", "wgsl", "py", "sh", "json", "html"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All texts below a folder, by their paths.
fn texts(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let entry = entry.unwrap();
            let (path, kind) = (entry.path(), entry.file_type().unwrap());
            let name = entry.file_name().into_string().unwrap_or_default();
            let is_text = path.extension().and_then(|e| e.to_str()).is_some_and(|e| TEXTS.contains(&e));
            if kind.is_dir() && !SKIPPED.contains(&name.as_str()) {
                open.push(path);
            } else if kind.is_file() && is_text {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Markdown without fenced code and code spans, which contain no links.
fn prose(markdown: &str) -> String {
    let mut fenced = false;
    let mut prose = String::new();
    for line in markdown.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            prose.extend(line.split('`').step_by(2));
        }
        prose.push('\n');
    }
    prose
}

/// The targets of `[text](target)` and `![text](target)`, each with the number of its line.
fn links(markdown: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (line, text) in prose(markdown).lines().enumerate() {
        let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
        found.extend(targets.map(|(target, _)| (line + 1, target.to_owned())));
    }
    found
}

/// The anchors of a page's headings, as GitHub makes them.
fn anchors(markdown: &str) -> Vec<String> {
    let mut fenced = false;
    let mut found = Vec::new();
    for line in markdown.lines() {
        fenced ^= line.starts_with("```");
        if let Some((hashes, title)) = line.split_once(' ')
            && !fenced
            && !hashes.is_empty()
            && hashes.chars().all(|c| c == '#')
        {
            let kept = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
            found.push(kept.collect::<String>().trim().to_lowercase().replace(' ', "-"));
        }
    }
    found
}

/// Broken links in the pages below a folder, one line for each.
fn broken_links(folder: &Path) -> Vec<String> {
    let mut broken = Vec::new();
    for page in texts(folder).into_iter().filter(|p| p.extension().is_some_and(|e| e == "md")) {
        let text = std::fs::read_to_string(&page).unwrap();
        for (line, target) in links(&text) {
            if ["http://", "https://", "mailto:"].iter().any(|scheme| target.starts_with(scheme)) {
                continue;
            }
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let path = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            let whole = if anchor.is_empty() {
                path.exists()
            } else {
                std::fs::read_to_string(&path).is_ok_and(|text| anchors(&text).iter().any(|a| a == anchor))
            };
            if !whole {
                let name = page.strip_prefix(folder).unwrap().display();
                broken.push(format!("{name}:{line}: `{target}` leads nowhere"));
            }
        }
    }
    broken
}

/// Paths of missing files in `docs/` that a text below a folder mentions.
fn missing_pages(folder: &Path) -> Vec<String> {
    let mut missing = Vec::new();
    for file in texts(folder) {
        let Ok(text) = std::fs::read_to_string(&file) else { continue };
        for (line, text) in text.lines().enumerate() {
            for (at, _) in text.match_indices("docs/") {
                // Pages of other projects have a path before them: `https://docs.rs/docs/…`.
                let before = text[..at].trim_end_matches("../").chars().next_back();
                let path: String = text[at..]
                    .chars()
                    .take_while(|c| c.is_ascii_alphanumeric() || "/._-".contains(*c))
                    .collect();
                let path = path.trim_end_matches(['.', '/']);
                let ours = !before.is_some_and(|c| c.is_ascii_alphanumeric() || "/.".contains(c));
                if ours && path.contains('.') && !folder.join(path).exists() {
                    let name = file.strip_prefix(folder).unwrap().display();
                    missing.push(format!("{name}:{}: `{path}` is not there", line + 1));
                }
            }
        }
    }
    missing
}

#[test]
fn every_link_of_a_page_leads_somewhere() {
    let broken = broken_links(root());
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn every_page_that_is_mentioned_is_there() {
    let missing = missing_pages(root());
    // This file itself contains examples of missing paths.
    let missing: Vec<_> = missing.into_iter().filter(|m| !m.starts_with("tests/host/links.rs")).collect();
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

/// Every page is reached from the index by links.
#[test]
fn every_page_is_reached_from_the_index() {
    let mut reached = vec![root().join("docs/README.md").canonicalize().unwrap()];
    let mut next = 0;
    while let Some(page) = reached.get(next).cloned() {
        next += 1;
        for (_, target) in links(&std::fs::read_to_string(&page).unwrap()) {
            let file = target.split('#').next().unwrap_or_default();
            let path = page.parent().unwrap().join(file).canonicalize();
            if let Ok(path) = path
                && path.extension().is_some_and(|e| e == "md")
                && !reached.contains(&path)
            {
                reached.push(path);
            }
        }
    }
    let docs = texts(&root().join("docs"));
    let lost: Vec<_> = docs
        .iter()
        .filter(|p| p.extension().is_some_and(|e| e == "md") && !reached.contains(&p.canonicalize().unwrap()))
        .collect();
    assert!(lost.is_empty(), "no link leads to {lost:?}");
    assert!(reached.len() > 40);
}

/// The architecture stays a page that is read in one sitting.
#[test]
fn the_architecture_has_1500_words_at_most() {
    let text = std::fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let words = text.split_whitespace().count();
    assert!(words <= 1500, "docs/architecture.md has {words} words: give a decision a page of its own");
}

/// The twin that must fail.
#[test]
fn links_that_lead_nowhere_are_found() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("docs")).unwrap();
    folder.write("docs/there.md", "# A heading, and more\n\n```text\n[no link](nowhere.md)\n```\n");
    folder.write(
        "page.md",
        "[a](docs/there.md) [b](docs/there.md#a-heading-and-more) `[c](gone.md)` [d](https://example.org/x)\n\
         [e](docs/gone.md)\n[f](docs/there.md#another) [g](#here)\n",
    );
    folder
        .write("code.rs", "//! See `docs/there.md`, `docs/gone.md` and https://example.org/docs/other.md.\n");
    let broken = broken_links(folder.root());
    assert_eq!(
        broken,
        [
            "page.md:2: `docs/gone.md` leads nowhere",
            "page.md:3: `docs/there.md#another` leads nowhere",
            "page.md:3: `#here` leads nowhere",
        ]
    );
    assert_eq!(
        missing_pages(folder.root()),
        ["code.rs:1: `docs/gone.md` is not there", "page.md:2: `docs/gone.md` is not there"]
    );
}
