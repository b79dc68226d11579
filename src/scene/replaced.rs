//! The text of a scene with other values.

use crate::error::Error;
use serde_json::{Map, Value};
use toml::Table;

/// The scene `text`, which `place` names in messages, with other values: each by its key (`board.tilt_deg`), whose tables are made
/// where they are missing; null takes a key out. Its comments are not kept.
///
/// # Errors
/// A text that is not TOML, and a key within what is no table.
pub fn replaced(text: &str, place: &str, values: &Map<String, Value>) -> Result<String, Error> {
    let mut root = table(text, place)?;
    for (key, value) in values {
        let refused = |why: String| Error::new(place, format!("`{key}` cannot be given: {why}"), "correct the scene");
        let (path, name) = key.rsplit_once('.').unwrap_or(("", key));
        let mut inner = &mut root;
        for step in path.split('.').filter(|step| !step.is_empty()) {
            let next = inner.entry(step).or_insert_with(|| Table::new().into());
            inner = next.as_table_mut().ok_or_else(|| refused(format!("`{step}` is no table")))?;
        }
        match value {
            Value::Null => drop(inner.remove(name)),
            value => {
                let value = toml::Value::try_from(value).map_err(|error| refused(error.to_string()))?;
                inner.insert(name.to_owned(), value);
            }
        }
    }
    toml::to_string(&root).map_err(|error| Error::new(place, format!("no text: {error}"), "correct the scene"))
}

/// The values of the scene `text` as JSON with sorted keys: the same of two texts that differ in comments, blanks and order alone.
///
/// # Errors
/// A text that is not TOML.
pub fn sorted_values(text: &str, place: &str) -> Result<Value, Error> {
    let root = table(text, place)?;
    serde_json::to_value(root).map_err(|error| Error::new(place, format!("no values: {error}"), "correct the scene"))
}

/// Whether the scene `text` says `effects = "none"`, so that none of its effects counts.
///
/// # Errors
/// A text that is not TOML.
pub fn has_no_effects(text: &str, place: &str) -> Result<bool, Error> {
    Ok(table(text, place)?.get("effects").and_then(toml::Value::as_str) == Some("none"))
}

fn table(text: &str, place: &str) -> Result<Table, Error> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    text.parse().map_err(|error| Error::new(place, format!("the scene is not TOML: {error}"), "mend the marked place"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const TEXT: &str = "# said\nname = \"a\"\n[board]\ncolumns = 3\nposition_mm = [0, 0, 1.5]\ntexture = \"noise\"\n";

    fn with(values: Value) -> Result<Table, Error> {
        let Value::Object(values) = values else { panic!("no table") };
        replaced(TEXT, "test", &values).map(|text| text.parse().unwrap())
    }

    /// Every bit of a number survives, other values stay, and tables are made.
    #[test]
    fn values_are_put_in_place_of_others() {
        let third = 1000.0 / 3.0;
        let found = with(json!({
            "board.position_mm": [third, -0.0, 1e-300], "board.texture": null, "effect.sensor.frame": 4_000_000_000u32,
            "effect.sensor.shot_noise": false, "name": "b",
        }))
        .unwrap();
        let board = &found["board"];
        let number = |k: usize| board["position_mm"][k].as_float().unwrap().to_bits();
        assert_eq!([0, 1, 2].map(number), [third, -0.0, 1e-300].map(f64::to_bits));
        assert_eq!(board["columns"].as_integer(), Some(3));
        assert!(board.get("texture").is_none());
        assert_eq!(found["effect"]["sensor"]["frame"].as_integer(), Some(4_000_000_000));
        assert_eq!(found["effect"]["sensor"]["shot_noise"].as_bool(), Some(false));
        assert_eq!(found["name"].as_str(), Some("b"));
    }

    #[test]
    fn values_are_sorted() {
        let [one, other] = ["b = 1.0\n[t]\nd = 2\nc = [1]", "# said\nt = { c = [ 1 ], d = 2 }\nb = 1.0"]
            .map(|text| sorted_values(text, "test").unwrap().to_string());
        assert_eq!((one.as_str(), other.as_str()), ("{\"b\":1.0,\"t\":{\"c\":[1],\"d\":2}}", one.as_str()));
    }

    #[test]
    fn a_value_is_no_table() {
        let problem = with(json!({ "board.columns.more": 1 })).unwrap_err();
        assert!(problem.rule.contains("`columns` is no table"), "{problem}");
        assert!(replaced("a = ", "test", &Map::new()).is_err());
    }

    #[test]
    fn effects_may_be_none() {
        assert!(has_no_effects("effects = \"none\"\n", "test").unwrap());
        assert!(!has_no_effects("effects = \"auto\"\n", "test").unwrap() && !has_no_effects("", "test").unwrap());
    }
}
