//! Does the shipped JSON Schema say what the reader does?

use crate::command::repository;
use biprism::scene;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// The schema, which `shipped_schema_is_current` holds equal to the shipped file.
fn schema() -> Value {
    serde_json::from_str(&scene::schema_json()).unwrap()
}

/// A scene as the JSON that an editor's validator sees.
fn as_json(text: &str) -> Value {
    toml::from_str(text).unwrap_or_else(|error| panic!("{error}"))
}

/// Every file below `folder` that ends in `.toml`.
fn scenes(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            found.extend(scenes(&entry));
        } else if entry.extension().is_some_and(|e| e == "toml") {
            found.push(entry);
        }
    }
    found.sort();
    found
}

/// `UPDATE_SCHEMA=1 cargo test --release --test suite shipped_schema` writes it anew.
#[test]
fn shipped_schema_is_current() {
    let path = repository("schemas/scene.schema.json");
    if std::env::var_os("UPDATE_SCHEMA").is_some() {
        fs::write(&path, scene::schema_json()).unwrap();
    }
    let text = fs::read_to_string(&path).unwrap_or_default();
    assert!(text == scene::schema_json(), "{} is old: run this test with UPDATE_SCHEMA=1", path.display());
}

#[test]
fn shipped_scenes_satisfy_the_schema() {
    let files = scenes(&repository("scenes"));
    assert!(!files.is_empty());
    for file in files {
        let judged = validate(&schema(), &as_json(&fs::read_to_string(&file).unwrap()));
        assert_eq!(judged, Ok(()), "{}", file.display());
        scene::load(&file).unwrap_or_else(|problem| panic!("{problem}"));
    }
}

#[test]
fn smallest_scene_of_every_kind_satisfies_schema_and_reader() {
    let patch = r#"centre_mm = [0, 0]
        scale_mm = [1, 1]
        domain_mm = [[0, 20], [-10, 10]]"#;
    let polynomial = format!(
        "kind = \"polynomial\"\nindex = 1.5\n[prism.front]\n{patch}\nterms = [[0, 0, 80], [1, 0, 0.15]]\n\
         [prism.back]\n{patch}\nterms = [[0, 0, 90]]"
    );
    let biprism = "index = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545";
    let cloud = "index = 1.5\nfront = { file = \"tests/fixtures/cloud.csv\", degree = 5 }\nback = { file = \"tests/fixtures/cloud.csv\", degree = 5 }";
    let kinds = [
        "kind = \"none\"".to_owned(),
        format!("kind = \"flat\"\n{biprism}"),
        format!("kind = \"freeform\"\n{biprism}"),
        format!("kind = \"freeform\"\n{biprism}\ndesign = {{ order = \"y-then-x\", method = \"euler\", step_px = 2 }}"),
        polynomial,
        format!("kind = \"point_cloud\"\n{cloud}"),
    ];
    for prism in kinds {
        let text = format!(
            "name = \"small\"\n[camera]\nfocal_length_mm = 35\nwidth_px = 64\nheight_px = 36\npixel_pitch_um = 165\n\
             [board]\ncolumns = 9\nrows = 7\nsquare_mm = 30\nposition_mm = [0, 0, 1000]\n[prism]\n{prism}\n"
        );
        assert_eq!(validate(&schema(), &as_json(&text)), Ok(()), "{text}");
        scene::parse(&text, "test.toml", Some(&repository(""))).unwrap_or_else(|problem| panic!("{problem}"));
    }
}

/// A bad scene's line `# schema` says whether the schema alone tells that it is bad.
#[test]
fn schema_rejects_the_bad_scenes_of_structure() {
    for file in scenes(&repository("tests/bad_scenes")) {
        let text = fs::read_to_string(&file).unwrap();
        let said = text.lines().find_map(|l| l.strip_prefix("# schema ")).unwrap();
        match said {
            "rejects" => assert!(validate(&schema(), &as_json(&text)).is_err(), "{}", file.display()),
            "accepts" => assert_eq!(validate(&schema(), &as_json(&text)), Ok(()), "{}", file.display()),
            "is not asked" => {}
            other => panic!("{} has `# schema {other}`", file.display()),
        }
    }
}

/// So that no accepted number can be infinite or NaN, and no list or word without end.
#[test]
fn every_number_list_and_word_of_the_schema_is_bounded() {
    fn walk(schema: &Value) -> usize {
        let has = |words: [&str; 2]| words.iter().any(|word| schema.get(word).is_some());
        let number = schema["type"] == "number" || schema["type"] == "integer";
        if number {
            assert!(has(["minimum", "exclusiveMinimum"]) && has(["maximum", "exclusiveMaximum"]), "{schema}");
        }
        assert!(schema["type"] != "array" || schema["maxItems"].is_u64(), "{schema}");
        assert!(schema["type"] != "string" || has(["const", "enum"]) || schema["maxLength"].is_u64(), "{schema}");
        let inner = [&schema["properties"], &schema["items"], &schema["oneOf"]];
        let below = inner.into_iter().flat_map(|s| s.as_object().into_iter().flat_map(|o| o.values()));
        let items = inner.into_iter().flat_map(|s| s.as_array().into_iter().flatten());
        let own = schema["items"].is_object().then_some(&schema["items"]);
        usize::from(number) + below.chain(items).chain(own).filter(|s| s.is_object()).map(walk).sum::<usize>()
    }
    assert!(walk(&schema()) > 30);
}

/// Does `value` satisfy `schema`? Knows the words of JSON Schema that the shipped one uses, and no others.
fn validate(schema: &Value, value: &Value) -> Result<(), String> {
    let words = schema.as_object().ok_or("a schema is an object")?;
    words.iter().try_for_each(|(word, rule)| {
        let holds = match word.as_str() {
            "$schema" | "title" | "description" | "default" | "format" => true,
            "type" => is_a(rule, value),
            "const" => value == rule,
            "enum" => rule.as_array().is_some_and(|choices| choices.contains(value)),
            "minimum" => value.as_f64().is_none_or(|v| v >= float(rule)),
            "maximum" => value.as_f64().is_none_or(|v| v <= float(rule)),
            "exclusiveMinimum" => value.as_f64().is_none_or(|v| v > float(rule)),
            "exclusiveMaximum" => value.as_f64().is_none_or(|v| v < float(rule)),
            "minLength" => value.as_str().is_none_or(|s| s.chars().count() >= size(rule)),
            "maxLength" => value.as_str().is_none_or(|s| s.chars().count() <= size(rule)),
            "pattern" => {
                assert_eq!(rule, &json!("^[a-z0-9_][a-z0-9_-]*$"));
                let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || c == '-';
                value.as_str().is_none_or(|s| !s.is_empty() && !s.starts_with('-') && s.chars().all(allowed))
            }
            "minItems" => value.as_array().is_none_or(|a| a.len() >= size(rule)),
            "maxItems" => value.as_array().is_none_or(|a| a.len() <= size(rule)),
            "items" => {
                let each = |i: usize| rule.as_array().map_or(rule, |positions| &positions[i]);
                value.as_array().is_none_or(|a| a.iter().enumerate().all(|(i, v)| validate(each(i), v).is_ok()))
            }
            "required" => {
                let mut keys = rule.as_array().into_iter().flatten().filter_map(Value::as_str);
                value.as_object().is_none_or(|o| keys.all(|key| o.contains_key(key)))
            }
            "properties" => {
                let mut known = rule.as_object().into_iter().flatten();
                value.as_object().is_none_or(|o| known.all(|(k, s)| o.get(k).is_none_or(|v| validate(s, v).is_ok())))
            }
            "additionalProperties" => {
                assert_eq!(rule, &Value::Bool(false));
                value.as_object().is_none_or(|o| o.keys().all(|k| schema["properties"].get(k).is_some()))
            }
            "oneOf" => {
                let alternatives = rule.as_array().into_iter().flatten();
                alternatives.filter(|s| validate(s, value).is_ok()).count() == 1
            }
            other => panic!("the validator of this test does not know `{other}`"),
        };
        if holds { Ok(()) } else { Err(format!("{value} breaks {word}: {rule}")) }
    })
}

fn is_a(kind: &Value, value: &Value) -> bool {
    match kind.as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("number") => value.is_number(),
        Some("boolean") => value.is_boolean(),
        Some("integer") => value.as_f64().is_some_and(|v| v.fract() == 0.0),
        other => panic!("the validator of this test does not know the type {other:?}"),
    }
}

fn float(rule: &Value) -> f64 {
    rule.as_f64().unwrap()
}

fn size(rule: &Value) -> usize {
    rule.as_u64().unwrap() as usize
}
