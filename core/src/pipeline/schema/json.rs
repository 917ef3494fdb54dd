//! The table of keys as JSON Schema, draft 07.

mod value;

use crate::codec::SettingKind;
use crate::pipeline::keys::shape::{Bounds, Key, Presence, Relation, Shape, Table};
use value::Json;

/// A name is not blank and holds no control characters.
const NAME: &str = r"^[^\x00-\x1f\x7f]*[^\s\x00-\x1f\x7f][^\x00-\x1f\x7f]*$";
/// A path is not empty. If it begins with `${`, the name of a variable and a brace follow.
const PATH: &str = r"^([^$]|\$[^{]|\$\{[A-Za-z0-9_]+\})+\$?$|^\$$";
const COLOUR: &str = "^#[0-9a-fA-F]{6}$";
const COLOUR_AND_OPACITY: &str = "^#([0-9a-fA-F]{6}|[0-9a-fA-F]{8})$";
/// A block: one edge, or three. The pattern does not check the upper bound. One line.
const LINE: &str = r"^[^\u0000-\u001f\u007f-\u009f]*$";
const BLOCK: &str = r"^\s*0*[1-9][0-9]*\s*(x\s*0*[1-9][0-9]*\s*x\s*0*[1-9][0-9]*\s*)?$";

/// The schema of a whole configuration.
pub(super) fn document(configuration: &Table) -> String {
    let head = Json::object()
        .with("$schema", "http://json-schema.org/draft-07/schema#")
        .with("title", "Experiment of cvr");
    let mut text = head.merged(table(configuration)).text();
    text.push('\n');
    text
}

fn table(table: &Table) -> Json {
    let required = table.keys.iter().filter(|key| matches!(key.presence, Presence::Required));
    let required: Vec<Json> = required.map(|key| key.name.as_str().into()).collect();
    let mut properties = Json::object();
    for key in &table.keys {
        properties = properties.with(&key.name, property(key));
    }
    let mut schema = Json::object()
        .with("description", table.doc.as_str())
        .with("type", "object")
        .with("properties", properties);
    if !required.is_empty() {
        schema = schema.with("required", Json::List(required));
    }
    schema = schema.with("additionalProperties", false);
    let mut dependencies = Json::object();
    for (key, others) in &table.needs {
        dependencies = dependencies.with(key, Json::List(others.iter().map(|&key| key.into()).collect()));
    }
    match &table.relation {
        Some(Relation::RendererSettings(settings)) => {
            for (key, renderers) in settings {
                dependencies = dependencies.with(key, names_one_of(renderers));
            }
        }
        Some(Relation::TransferDomain) => schema = schema.merged(transfer_domain()),
        None => {}
    }
    if !table.needs.is_empty() || matches!(table.relation, Some(Relation::RendererSettings(_))) {
        schema = schema.with("dependencies", dependencies);
    }
    schema
}

/// A pipeline whose `renderer` names one of these renderers.
fn names_one_of(renderers: &[String]) -> Json {
    let renderers =
        Json::object().with("enum", Json::List(renderers.iter().map(|r| r.as_str().into()).collect()));
    let listed = Json::object().with("type", "array").with("contains", renderers.clone());
    let either = Json::object().with("anyOf", Json::List(vec![renderers, listed]));
    Json::object().with("properties", Json::object().with("renderer", either))
}

/// A named transfer function lies over the range. For control points over the range, the values do.
fn transfer_domain() -> Json {
    let only = |key: &str, schema: Json| {
        Json::object()
            .with("properties", Json::object().with(key, schema))
            .with("required", Json::List(vec![key.into()]))
    };
    let range = || Json::object().with("const", "range");
    let share = Json::object().with("minimum", 0_i64).with("maximum", 1_i64);
    let point = Json::object().with("items", Json::List(vec![share]));
    let points = Json::object().with("items", point);
    let control_points = Json::object()
        .with("if", only("transfer_function_domain", range()))
        .with("then", Json::object().with("properties", Json::object().with("transfer_function", points)));
    Json::object()
        .with("if", only("transfer_function", Json::object().with("type", "string")))
        .with(
            "then",
            Json::object().with("properties", Json::object().with("transfer_function_domain", range())),
        )
        .with("else", control_points)
}

fn property(key: &Key) -> Json {
    let mut description = format!("{}.", key.doc);
    for (word, doc) in key.shape.words().iter().filter(|(_, doc)| !doc.is_empty()) {
        description.push_str(&format!("\n- {word}: {doc}"));
    }
    let unit = if key.unit.is_empty() { String::new() } else { format!(" Unit: {}.", key.unit) };
    let presence = match &key.presence {
        Presence::Required => " Required.".to_owned(),
        Presence::Default(value) => format!(" Default: {value}."),
        Presence::Absent(meaning) => format!(" Absent: {meaning}."),
    };
    let gap = if description.contains('\n') { "\n" } else { "" };
    description.push_str(&format!("{gap}{unit}{presence}"));
    let described = Json::object().with("description", description.replace("\n ", "\n"));
    let described = described.merged(shape(&key.shape));
    match &key.presence {
        Presence::Default(value) => match serde_json::from_str::<serde_json::Value>(value) {
            Ok(value) => described.with("default", value),
            Err(_) => described,
        },
        _ => described,
    }
}

fn array(item: Json, least: usize) -> Json {
    Json::object().with("type", "array").with("items", item).with("minItems", least as i64)
}

fn text(pattern: &str) -> Json {
    Json::object().with("type", "string").with("pattern", pattern)
}

fn any(schemas: Vec<Json>) -> Json {
    Json::object().with("anyOf", Json::List(schemas))
}

fn shape(of: &Shape) -> Json {
    match of {
        Shape::Name => text(NAME),
        Shape::Path => text(PATH),
        Shape::Text => Json::object().with("type", "string"),
        Shape::Boolean => Json::object().with("type", "boolean"),
        Shape::Integer { min, max } => integer(*min, *max),
        Shape::Number(bounds) => number(*bounds),
        Shape::Words(words) => Json::object()
            .with("enum", Json::List(words.iter().map(|(word, _)| word.as_str().into()).collect())),
        Shape::Colour { opacity: false } => text(COLOUR),
        Shape::Colour { opacity: true } => text(COLOUR_AND_OPACITY),
        Shape::Setting(kind) => setting(*kind),
        Shape::Tuple(items) => Json::object()
            .with("type", "array")
            .with("items", Json::List(items.iter().map(shape).collect()))
            .with("additionalItems", false)
            .with("minItems", items.len() as i64),
        Shape::List { item, least, most } => {
            let list = array(shape(item), *least);
            most.iter().fold(list, |list, most| list.with("maxItems", *most as i64))
        }
        Shape::Axis(item) => any(vec![shape(item), array(shape(item), 1).with("uniqueItems", true)]),
        Shape::Sweep(item) => any(vec![shape(item), array(shape(item), 1)]),
        Shape::Any(shapes) => any(shapes.iter().map(shape).collect()),
        Shape::Table(keys) => table(keys),
        Shape::Tables(kinds) => match &kinds[..] {
            [(_, one)] => array(table(one), 1),
            _ => {
                let kinds = kinds
                    .iter()
                    .map(|(name, kind)| Json::object().with("title", name.as_str()).merged(table(kind)));
                array(Json::object().with("oneOf", Json::List(kinds.collect())), 1)
            }
        },
    }
}

/// A bound at the end of 64 bits adds nothing to the type, and readers that use doubles would round it.
fn integer(min: i64, max: i64) -> Json {
    let schema = Json::object().with("type", "integer").with("minimum", min);
    if max == i64::MAX { schema } else { schema.with("maximum", max) }
}

fn number(bounds: Bounds) -> Json {
    let limits = [
        ("minimum", bounds.min),
        ("exclusiveMinimum", bounds.above),
        ("maximum", bounds.max),
        ("exclusiveMaximum", bounds.below),
    ];
    limits.into_iter().fold(Json::object().with("type", "number"), |schema, (name, limit)| match limit {
        Some(limit) => schema.with(name, limit),
        None => schema,
    })
}

fn setting(kind: SettingKind) -> Json {
    match kind {
        SettingKind::Integer { min, max } => integer(min, max),
        SettingKind::OneOf(numbers) => Json::object()
            .with("type", "integer")
            .with("enum", Json::List(numbers.iter().map(|&n| n.into()).collect())),
        SettingKind::Float { min, max } => number(Bounds::range(min, max)),
        // A number whose text is a word counts as the word.
        SettingKind::Choice(words) => {
            let numbers = words.iter().filter_map(|word| word.parse::<i64>().ok()).map(Json::from);
            let words = words.iter().map(|&word| Json::from(word));
            Json::object().with("enum", Json::List(words.chain(numbers).collect()))
        }
        SettingKind::Boolean => Json::object().with("type", "boolean"),
        SettingKind::Block { max } => any(vec![integer(1, i64::from(max)), text(BLOCK)]),
        SettingKind::Text { .. } => {
            any(vec![text(LINE), number(Bounds::ANY), Json::object().with("type", "boolean")])
        }
    }
}
