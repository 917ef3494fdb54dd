//! That schema and parser are one truth.

use std::collections::BTreeSet;

use serde_json::Value as Json;

use super::super::document::{Document, Node, Value};
use super::super::tests::{EXAMPLE, known, registry};
use super::{json_schema, markdown};
use crate::diagnostic::Diagnostic;

/// Errors of the parser that no schema can express contain these words.
const BEYOND: [&str; 11] = [
    " are allowed",
    "a range of frames runs forwards",
    "control points are out of order",
    "all control points lie at one value",
    "the clip box is empty along",
    "light comes from no direction",
    "no scene applies to volume",
    "two volumes are called",
    "more than 2^40 voxels",
    "each axis 1 to ",
    "no volume is called",
];

/// The document as an editor's validator sees it. Numbers that JSON lacks become null.
fn json(node: &Node) -> Json {
    match &node.value {
        Value::Boolean(b) => (*b).into(),
        Value::Integer(i) => (*i).into(),
        Value::Float(x) => (*x).into(),
        Value::Text(text) => text.as_str().into(),
        Value::DateTime => "1979-05-27".into(),
        Value::List(items) => items.iter().map(json).collect(),
        Value::Table(entries) => entries.iter().map(|e| (e.key.clone(), json(&e.node))).collect(),
    }
}

fn schema() -> Json {
    serde_json::from_str(&json_schema(&known(&registry()))).unwrap()
}

/// The schema's errors for a document. Empty if it is valid.
fn complaints(document: &Document) -> Vec<String> {
    let validator = jsonschema::draft7::new(&schema()).unwrap();
    validator.iter_errors(&json(&document.root)).map(|e| format!("{}: {e}", e.instance_path())).collect()
}

/// Compares the schema with the parser's result. Called for every text that a test parses.
pub(in crate::pipeline) fn agrees(document: &Document, refused: Option<&[Diagnostic]>) {
    let complaints = complaints(document);
    match refused {
        None => assert!(complaints.is_empty(), "the parser accepts what the schema refuses: {complaints:#?}"),
        Some(errors) => {
            let beyond = |error: &Diagnostic| BEYOND.iter().any(|words| error.to_string().contains(words));
            if !errors.iter().all(beyond) {
                let all: Vec<String> = errors.iter().map(ToString::to_string).collect();
                assert!(
                    !complaints.is_empty(),
                    "the schema accepts what the parser refuses: {}",
                    all.join("\n")
                );
            }
        }
    }
}

#[test]
#[should_panic(expected = "the schema accepts what the parser refuses")]
fn a_schema_that_is_too_wide_is_noticed() {
    let document = Document::parse("x.toml", EXAMPLE).unwrap();
    let error = document.root.error("expected something else", "here");
    agrees(&document, Some(&[error]));
}

#[test]
#[should_panic(expected = "the parser accepts what the schema refuses")]
fn a_schema_that_is_too_narrow_is_noticed() {
    agrees(&Document::parse("x.toml", &EXAMPLE.replace("seed = 1", "sed = 1")).unwrap(), None);
}

/// The keys that the parser lists when it meets an unknown one.
fn known_to_parser(text: &str) -> BTreeSet<String> {
    let registry = registry();
    let document = Document::parse("x.toml", text).unwrap();
    let error = document.experiment(&known(&registry)).unwrap_err().to_string();
    assert!(error.contains("zzz"), "{error}");
    let list = |what: &str| {
        let line = error.lines().find_map(|line| line.trim().strip_prefix(what).map(str::to_owned));
        line.map(|line| line.split(", ").map(str::to_owned).collect())
    };
    list("= known keys: ").or_else(|| list("= known settings: ")).unwrap_or_default()
}

/// The keys of the table at this place of the schema.
fn in_schema(pointer: &str) -> BTreeSet<String> {
    let schema = schema();
    let table = schema.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is missing"));
    assert_eq!(table["additionalProperties"], Json::Bool(false), "{pointer}");
    table["properties"].as_object().unwrap().keys().cloned().collect()
}

#[test]
fn both_know_the_same_keys() {
    let with = |from: &str, to: &str| known_to_parser(&EXAMPLE.replacen(from, to, 1));
    let scene = "/properties/scene/items";
    let step = "step_voxels = 0.5";
    assert_eq!(with("[pipeline]", "[zzz]\n[pipeline]"), in_schema(""));
    assert_eq!(with("seed = 1", "zzz = 1"), in_schema("/properties/experiment"));
    assert_eq!(with(step, "zzz = 1"), in_schema(scene));
    assert_eq!(with("azimuth", "zzz"), in_schema(&format!("{scene}/properties/camera")));
    assert_eq!(
        with(step, "shading = { zzz = 1 }"),
        in_schema(&format!("{scene}/properties/shading/anyOf/1"))
    );
    let volumes: BTreeSet<String> =
        (0..3).flat_map(|i| in_schema(&format!("/properties/volume/items/oneOf/{i}"))).collect();
    assert_eq!(with("name = \"bonsai\"", "zzz = 1"), volumes);

    let renderers = "renderer = [\"raycasting\", \"slicing\"]\nzzz = 1";
    let told = in_schema("/properties/pipeline");
    let parsed = with("renderer = [\"raycasting\"]", renderers);
    assert_eq!(parsed, told);

    for (i, codec) in registry().iter().enumerate() {
        let mut keys = in_schema(&format!("/properties/codec/items/oneOf/{i}"));
        assert!(keys.remove("id"));
        let id = codec.info().id;
        assert_eq!(with("id = \"raw\"", &format!("id = \"{id}\"\nzzz = 1")), keys, "{id}");
    }
}

/// A configuration into which a line is put.
type WithLine = Box<dyn Fn(&str) -> String>;

/// The tables of the schema. Each has a configuration with that table, into which a line can be inserted.
fn tables() -> Vec<(&'static str, WithLine)> {
    let replaced = |from: &'static str, before: &'static str, after: &'static str| -> WithLine {
        Box::new(move |line| EXAMPLE.replacen(from, &format!("{before}{line}{after}"), 1))
    };
    let camera = EXAMPLE.lines().find(|line| line.starts_with("camera")).unwrap();
    let file = "file = \"$CVR_DATA/bonsai.nrrd\"";
    vec![
        ("/properties/experiment", replaced("seed = 1\n", "", "\n")),
        (
            "/properties/scene/items",
            Box::new(move |line| {
                let text = EXAMPLE.lines().filter(|l| !l.starts_with("size") && !l.starts_with("camera"));
                let text: Vec<&str> = text.filter(|l| !l.starts_with("step")).collect();
                format!("{}\n{line}\n", text.join("\n"))
            }),
        ),
        ("/properties/scene/items/properties/camera", replaced(camera, "camera = { ", " }")),
        (
            "/properties/scene/items/properties/shading/anyOf/1",
            replaced("step_voxels = 0.5", "shading = { ", " }"),
        ),
        ("/properties/volume/items/oneOf/2", replaced(file, "generate = \"shepp-logan\"\n", "\n")),
        (
            "/properties/volume/items/oneOf/0",
            replaced(file, "file = \"a\"\ndims = [1, 2, 3]\ndtype = \"u8\"\n", "\n"),
        ),
        ("/properties/codec/items/oneOf/0", replaced("id = \"raw\"", "id = \"raw\"\n", "")),
    ]
}

/// Writing a default changes nothing. The default of every key is checked here or in the codec's schema.
#[test]
fn defaults_are_those_of_the_parser() {
    let registry = registry();
    let read = |text: &str| {
        let document = Document::parse("x.toml", text).unwrap();
        agrees(&document, None);
        document.experiment(&known(&registry)).unwrap_or_else(|e| panic!("{e}"))
    };
    let schema = schema();
    let mut checked = 0;
    for (pointer, text) in tables() {
        for (key, property) in schema.pointer(pointer).unwrap()["properties"].as_object().unwrap() {
            let Some(default) = property.get("default") else { continue };
            let (mut plain, mut written) = (read(&text("")), read(&text(&format!("{key} = {default}"))));
            // A written setting is listed even if it has its default. So completed settings are compared.
            for sweep in plain.codecs.iter_mut().chain(&mut written.codecs) {
                let info = registry.get(&sweep.id).unwrap().info().clone();
                sweep.sweeps.retain(|s| s.values != [default_of(&info, &s.name)]);
            }
            assert_eq!(plain, written, "{pointer}: {key} = {default}");
            checked += 1;
        }
    }
    assert!(checked > 25, "{checked} defaults");
}

fn default_of(info: &crate::codec::CodecInfo, name: &str) -> crate::codec::SettingValue {
    let setting = info.setting(name).unwrap();
    setting.kind.canonical(&setting.default.into()).unwrap()
}

/// Every `properties` below a value, at any depth.
fn all_keys(schema: &Json, keys: &mut BTreeSet<String>) {
    match schema {
        Json::Object(members) => {
            if let Some(Json::Object(properties)) = members.get("properties") {
                keys.extend(properties.keys().cloned());
            }
            members.values().for_each(|value| all_keys(value, keys));
        }
        Json::Array(items) => items.iter().for_each(|item| all_keys(item, keys)),
        _ => {}
    }
}

#[test]
fn the_page_has_a_row_for_every_key_of_the_schema() {
    let page = markdown(&known(&registry()));
    let mut keys = BTreeSet::new();
    all_keys(&schema(), &mut keys);
    assert!(keys.len() > 40, "{keys:?}");
    for key in keys {
        let is_told =
            ["| `", "## `[", "## `[["].iter().any(|before| page.contains(&format!("{before}{key}")));
        assert!(is_told, "{key} is missing");
    }
    assert!(!page.contains("| `zzz` |"));
}

#[test]
fn the_schema_is_one_and_editors_find_help_in_it() {
    let schema = schema();
    assert!(jsonschema::draft7::meta::is_valid(&schema));
    fn described(schema: &Json, at: &str) {
        if let Some(properties) = schema.get("properties").and_then(Json::as_object)
            && schema.get("additionalProperties").is_some()
        {
            for (key, property) in properties {
                assert!(property["description"].as_str().is_some_and(|d| d.len() > 8), "{at}/{key}");
            }
        }
        match schema {
            Json::Object(members) => members.iter().for_each(|(k, v)| described(v, &format!("{at}/{k}"))),
            Json::Array(items) => items.iter().for_each(|item| described(item, at)),
            _ => {}
        }
    }
    described(&schema, "");
}
