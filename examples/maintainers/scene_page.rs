//! Makes `docs/scene.md` from the schema of a scene: `cargo run --release --example scene_page`.
//!
//! Every table of the schema is a section, every key a row. `tests/documents.rs` holds the page against [`page`].

use biprism::scene;
use serde_json::{Map, Value};
use std::fmt::Write;
use std::path::Path;

/// What stands before the tables: words, and a scene that `tests/documents.rs` runs.
const INTRODUCTION: &str = r#"# A scene, key by key

Made by `cargo run --release --example scene_page` from the schema of a scene; do not edit. The same schema is
`schemas/scene.schema.json`, which makes an editor complete and check a scene.

A scene is a TOML file: a camera, the prism in front of it, and the board behind. It is read strictly: an unknown key, a
missing one and a value out of its range each end in an error that names file, line, key, rule and next step, and
`biprism check SCENE` looks for them without rendering. `scenes/paper.toml` is the scene to copy.

The frame is right-handed: +x is right, +y down, +z from the camera to the board. The unit of a value is the end of its
key's name. "Required" keys have no default; a dash says that nothing is there, or happens, when the key is left out, unless
its line says what then holds.

## A scene with a claim

<!-- file: claim.toml -->
```toml
name = "claim"

[camera]
focal_length_mm = 35.0
width_px = 480
height_px = 270
pixel_pitch_um = 22.0

[prism]
kind = "freeform"
index = 1.48
ridge_distance_mm = 78.472
thickness_mm = 8.545

[board]
columns = 21
rows = 21
square_mm = 20.0
position_mm = [0.0, 0.0, 1000.0]

# What the scene claims of its own result, by the path of a number in report.json: the design, and the keys down to it.
[[expect]]
value = "freeform/stereo/vertical_disparity_rms_px/true"
max = 0.003

[[expect]]
value = "flat/stereo/vertical_disparity_rms_px/measured"
min = 0.1
```

```sh
biprism check claim.toml
biprism compare claim.toml --out claim      # exit code 0: both claims hold; 1 and a line on stderr for one that does not
```
"#;

/// One row of a table.
#[derive(PartialEq)]
struct Row {
    key: String,
    range: String,
    default: String,
    meaning: String,
}

/// A table of the scene file.
struct Section {
    /// As the scene file writes it, `[camera]`.
    headings: Vec<String>,
    meaning: String,
    rows: Vec<Row>,
}

/// The whole page.
pub(crate) fn page() -> String {
    let schema: Value = serde_json::from_str(&scene::schema_json()).expect("the schema is JSON");
    let mut sections = Vec::new();
    table("", "", &schema, &mut sections);
    let mut text = INTRODUCTION.to_owned();
    for section in sections {
        write_section(&section, &mut text);
    }
    text
}

/// Lists the table `schema` that the scene file calls `path`, and then the tables in it, in the order of the schema. `kind`
/// says of which kind of the table above they are, in words, where there are several.
fn table(path: &str, kind: &str, schema: &Value, sections: &mut Vec<Section>) {
    // Tell the keys of this table from the tables in it.
    let (inner, own): (Vec<_>, Vec<_>) = properties(schema)
        .iter()
        .partition(|(_, value)| is_table(value) || is_choice_of_tables(value) || is_table(&value["items"]));
    let mut rows = Vec::new();
    for (key, value) in own {
        rows_of(key, value, is_required(schema, key), &mut rows);
    }
    let (heading, meaning) = match path {
        "" => ("Before the first table".to_owned(), "What belongs to no table."),
        _ => (format!("`[{path}]`{kind}"), meaning(schema)),
    };
    push(Section { headings: vec![heading], meaning: meaning.to_owned(), rows }, sections);

    // List the tables in it.
    for (key, value) in inner {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        if is_choice_of_tables(value) {
            kinds(&path, value, sections);
        } else if is_table(value) {
            table(&path, kind, value, sections);
        } else {
            let mut each = value["items"].clone();
            each["description"] = value["description"].clone();
            table(&format!("[{path}]"), kind, &each, sections);
        }
    }
}

/// Adds a section; one with the rows of another becomes a further heading of it.
fn push(section: Section, sections: &mut Vec<Section>) {
    let same = sections.iter_mut().find(|known| !section.rows.is_empty() && known.rows == section.rows);
    let Some(known) = same else {
        return sections.push(section);
    };
    known.headings.extend(section.headings);
    if known.meaning != section.meaning {
        write!(known.meaning, " {}", section.meaning).expect("writing to a string cannot fail");
    }
}

/// A table of which a key `kind` chooses what it holds: the keys that all kinds but an empty one share, then each kind.
fn kinds(path: &str, schema: &Value, sections: &mut Vec<Section>) {
    let alternatives = schema["oneOf"].as_array().expect("a choice");
    let full: Vec<&Value> = alternatives.iter().filter(|a| properties(a).len() > 1).collect();
    let shared = |key: &str| key != "kind" && full.iter().all(|a| a["properties"][key] == full[0]["properties"][key]);

    // List what the kinds have in common once.
    let mut rows = vec![Row {
        key: "kind".to_owned(),
        range: alternatives.iter().map(|a| code(&a["properties"]["kind"]["const"])).collect::<Vec<_>>().join(", "),
        default: "required".to_owned(),
        meaning: "What the glass is given by: a section each.".to_owned(),
    }];
    let (tables, keys): (Vec<_>, Vec<_>) =
        properties(full[0]).iter().filter(|(key, _)| shared(key)).partition(|(_, value)| is_table(value));
    for (key, value) in keys {
        rows_of(key, value, is_required(full[0], key), &mut rows);
    }
    let meaning = format!("{} Every kind but `\"none\"` has these keys.", meaning(schema));
    push(Section { headings: vec![format!("`[{path}]`")], meaning, rows }, sections);
    for (key, value) in tables {
        table(&format!("{path}.{key}"), "", value, sections);
    }

    // List what each kind has besides.
    for alternative in &full {
        let kind = format!(" of kind {}", code(&alternative["properties"]["kind"]["const"]));
        let mut own = (*alternative).clone();
        own["properties"].as_object_mut().expect("a table").retain(|key, _| key != "kind" && !shared(key));
        table(path, &kind, &own, sections);
    }
}

fn is_required(schema: &Value, key: &str) -> bool {
    schema["required"].as_array().is_some_and(|keys| keys.iter().any(|required| required == key))
}

/// The rows of one key: itself, and where it may hold a table in line, the keys of that, dotted.
fn rows_of(key: &str, value: &Value, required: bool, rows: &mut Vec<Row>) {
    let default = match &value["default"] {
        _ if required => "required".to_owned(),
        Value::Null => "-".to_owned(),
        default => code(default),
    };
    rows.push(Row { key: key.to_owned(), range: range(value), default, meaning: meaning(value).to_owned() });
    for alternative in value["oneOf"].as_array().into_iter().flatten().filter(|a| is_table(a)) {
        inline(key, alternative, rows);
    }
}

/// The keys of a table that is written in line, `key = { .. }`.
fn inline(key: &str, schema: &Value, rows: &mut Vec<Row>) {
    for (name, value) in properties(schema) {
        let key = format!("{key}.{name}");
        if is_table(value) {
            inline(&key, value, rows);
        } else {
            rows_of(&key, value, is_required(schema, name), rows);
        }
    }
}

fn properties(schema: &Value) -> &Map<String, Value> {
    schema["properties"].as_object().expect("a table")
}

fn is_table(schema: &Value) -> bool {
    schema["properties"].is_object()
}

fn is_choice_of_tables(schema: &Value) -> bool {
    schema["oneOf"].as_array().is_some_and(|all| all.iter().all(is_table))
}

fn meaning(schema: &Value) -> &str {
    schema["description"].as_str().unwrap_or_default()
}

fn code(value: &Value) -> String {
    format!("`{}`", serde_json::to_string(value).expect("a value has a text").replace(',', ", "))
}

/// What a value may be.
fn range(schema: &Value) -> String {
    if let Some(choices) = schema["enum"].as_array() {
        return choices.iter().map(code).collect::<Vec<_>>().join(", ");
    }
    if let Some(alternatives) = schema["oneOf"].as_array() {
        let of = |a: &Value| if is_table(a) { "a table".to_owned() } else { range(a) };
        return alternatives.iter().map(of).collect::<Vec<_>>().join(", or ");
    }
    match schema["type"].as_str() {
        Some("boolean") => "`true`, `false`".to_owned(),
        Some("string") => format!("text of {} to {} characters", schema["minLength"], schema["maxLength"]),
        Some("array") => list(schema),
        Some(kind @ ("number" | "integer")) => {
            let low = match (&schema["minimum"], &schema["exclusiveMinimum"]) {
                (Value::Null, low) => format!("above {}", short(low)),
                (low, _) => short(low),
            };
            let high = match (&schema["maximum"], &schema["exclusiveMaximum"]) {
                (Value::Null, high) => format!("below {}", short(high)),
                (high, _) => short(high),
            };
            format!("{}{low} to {high}", if kind == "integer" { "whole, " } else { "" })
        }
        other => panic!("the page does not know the type {other:?}"),
    }
}

/// What a list may be: how many, and what each is.
fn list(schema: &Value) -> String {
    let count = match (schema["minItems"].as_u64(), schema["maxItems"].as_u64()) {
        (Some(least), Some(most)) if least == most => format!("{most}"),
        (Some(least), Some(most)) => format!("{least} to {most}"),
        (None, Some(most)) => format!("up to {most}"),
        (_, None) => panic!("a list without end: {schema}"),
    };
    match &schema["items"] {
        Value::Array(each) => format!("[{}]", each.iter().map(range).collect::<Vec<_>>().join("; ")),
        each if each["type"] == "array" || each["type"] == "string" => format!("{count} of {}", range(each)),
        each => format!("{count} numbers, {}", range(each)),
    }
}

/// A bound in few characters: 1e12 instead of 1000000000000.0.
fn short(bound: &Value) -> String {
    let number = bound.as_f64().expect("a bound is a number");
    if number != 0.0 && !(1e-3..1e5).contains(&number.abs()) && libm::log10(number.abs()).fract() == 0.0 {
        format!("{number:e}")
    } else {
        format!("{number}")
    }
}

/// The unit of a key, which its name ends with.
fn unit(key: &str) -> &'static str {
    const UNITS: [(&str, &str); 11] = [
        ("_dn_per_e", "DN/electron"),
        ("per_mm", "1/mm"),
        ("_10mm", "-"),
        ("_mm", "mm"),
        ("_um", "um"),
        ("_nm", "nm"),
        ("_deg", "deg"),
        ("_px", "px"),
        (".px", "px"),
        ("_dn", "DN"),
        ("_e", "electrons"),
    ];
    UNITS.iter().find(|(end, _)| key.ends_with(end)).map_or("-", |(_, unit)| unit)
}

fn write_section(section: &Section, text: &mut String) {
    write!(text, "\n## {}\n\n", section.headings.join(", ")).expect("writing to a string cannot fail");
    if !section.meaning.is_empty() {
        writeln!(text, "{}", section.meaning).expect("writing to a string cannot fail");
    }
    if section.rows.is_empty() {
        return;
    }
    text.push_str("\n| key | unit | range | default | meaning |\n|---|---|---|---|---|\n");
    for Row { key, range, default, meaning } in &section.rows {
        writeln!(text, "| `{key}` | {} | {range} | {default} | {} |", unit(key), meaning.replace('|', "\\|"))
            .expect("writing to a string cannot fail");
    }
}

#[allow(dead_code, reason = "the test that holds the page against the schema takes `page` alone")]
fn main() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scene.md");
    std::fs::write(&path, page()).expect("the page can be written");
    println!("wrote {}", path.display());
}
