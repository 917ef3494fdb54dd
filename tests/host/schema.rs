//! `cvr schema`: the committed files equal the program's output, and every shipped configuration is valid.

use std::path::Path;

use serde_json::Value;

use super::folder::Folder;

const SCHEMA: &str = "docs/experiment.schema.json";
const PAGE: &str = "docs/user/configs.md";
/// The line by which editors find the schema.
const DIRECTIVE: &str = "#:schema ../docs/experiment.schema.json";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// The errors of a configuration by the committed schema.
fn complaints(toml: &str) -> Vec<String> {
    let schema: Value = serde_json::from_str(&text(SCHEMA)).unwrap();
    let instance: Value = toml::from_str(toml).unwrap();
    let validator = jsonschema::draft7::new(&schema).unwrap();
    validator.iter_errors(&instance).map(|e| format!("{}: {e}", e.instance_path())).collect()
}

/// `CVR_BLESS=1` writes the program's output.
fn committed(name: &str, arguments: &[&str]) {
    let printed = Folder::new().cvr(arguments).exits(0).stdout;
    if std::env::var_os("CVR_BLESS").is_some() {
        std::fs::write(root().join(name), &printed).unwrap();
    }
    let differs = text(name).lines().zip(printed.lines()).position(|(a, b)| a != b);
    assert!(
        text(name) == printed,
        "{name} is not what `cvr {}` prints (line {differs:?}); CVR_BLESS=1 writes it anew",
        arguments.join(" ")
    );
}

#[test]
fn the_committed_schema_is_what_the_program_prints() {
    committed(SCHEMA, &["schema"]);
}

#[test]
fn the_committed_page_is_what_the_program_prints() {
    committed(PAGE, &["schema", "--markdown"]);
}

#[test]
fn a_file_holds_what_is_printed() {
    let folder = Folder::new();
    let ran = folder.cvr(&["schema", "--out", "a.json"]).exits(0);
    assert_eq!(ran.stdout, "");
    assert_eq!(folder.text("a.json"), folder.cvr(&["schema"]).exits(0).stdout);
    assert!(folder.cvr(&["schema", "--out", "missing/a.json"]).refused().contains("missing/a.json"));
    assert_eq!(folder.names(), ["a.json"]);
}

#[test]
fn shipped_configurations_name_the_schema_and_fulfil_it() {
    let mut count = 0;
    for entry in std::fs::read_dir(root().join("configs")).unwrap() {
        let path = entry.unwrap().path();
        if path.file_stem().unwrap() == super::configs::NO_EXPERIMENT {
            continue;
        }
        let toml = std::fs::read_to_string(&path).unwrap();
        assert_eq!(toml.lines().next(), Some(DIRECTIVE), "{}: its first line", path.display());
        let complaints = complaints(&toml);
        assert!(complaints.is_empty(), "{}: {complaints:#?}", path.display());
        count += 1;
    }
    assert!(count >= 4);
    assert_eq!(complaints(&text("docs/example.toml")), [""; 0]);
}

/// The twin that must fail: one letter is enough.
#[test]
fn a_configuration_with_one_wrong_letter_does_not_fulfil_it() {
    let example = text("docs/example.toml");
    for (right, wrong) in [
        ("step_voxels", "step_voxel"),
        ("s3dc", "s3bc"),
        ("\"8x8x4\"", "\"8x8\""),
        ("host", "hots"),
        ("index_bits = [2, 4]", "index_bits = [2, 3]"),
        ("projection", "projektion"),
        ("\"#c8a060c0\"", "\"#c8a060c\""),
    ] {
        assert!(example.contains(right));
        assert!(!complaints(&example.replace(right, wrong)).is_empty(), "{wrong} is accepted");
    }
}

#[test]
fn every_codec_renderer_generator_and_preset_stands_in_it() {
    let schema = text(SCHEMA);
    let names = cvr::registry::Names::new().unwrap();
    let known = names.known();
    let codecs =
        known.codecs.iter().flat_map(|c| c.info().settings.iter().map(|s| s.name).chain([c.info().id]));
    let renderers = known.renderers.iter().flat_map(|r| r.settings.iter().map(|s| s.name).chain([r.id]));
    let presets = cvr_core::render::Preset::ALL.iter().map(|p| p.name);
    for name in codecs.chain(renderers).chain(known.generators.iter().copied()).chain(presets) {
        assert!(schema.contains(&format!("\"{name}\"")), "{name} is missing");
    }
}
