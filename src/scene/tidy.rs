//! The JSON Schema that the derive macros make, in the few words that the reader and editors need.

use schemars::Schema;
use serde_json::Value;

/// TOML has no null (an optional key is left out), JSON Schema no format "double", and a description is one line.
pub(super) fn tidy(schema: &mut Schema) {
    let Some(object) = schema.as_object_mut() else { return };
    object.shift_remove("format");
    if object.get("default") == Some(&Value::Null) {
        object.shift_remove("default");
    }
    // The alternatives of a value exclude each other; an optional table has only the one.
    while let Some(Value::Array(alternatives)) = object.shift_remove("anyOf") {
        let mut kept: Vec<Value> = alternatives.into_iter().filter(|a| a["type"] != "null").collect();
        match (kept.len(), kept.pop()) {
            (1, Some(Value::Object(only))) => {
                // What is said of the key goes before what is said of its type.
                let own = std::mem::take(object);
                object.extend(only);
                object.extend(own);
            }
            (_, last) => {
                kept.extend(last);
                object.insert("oneOf".to_owned(), Value::Array(kept));
            }
        }
    }
    if let Some(Value::Array(types)) = object.get("type") {
        let kept = types.iter().find(|t| *t != "null").cloned();
        object.insert("type".to_owned(), kept.unwrap_or(Value::Null));
    }
    if let Some(Value::Array(choices)) = object.get_mut("enum") {
        choices.retain(|choice| !choice.is_null());
    }
    if let Some(Value::String(words)) = object.get_mut("description") {
        *words = words.replace('\n', " ");
    }
}
