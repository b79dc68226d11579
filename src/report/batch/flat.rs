//! JSON with tables in tables as one table of numbers by their paths.

use crate::report::json::AccuracyEntry;
use serde_json::{Map, Value};

/// Keys that are no figures: seconds are those of the line, and how a figure is defined is told in `docs/metrics.md`.
const LEFT_OUT: [&str; 5] = ["timing_s", "timing", "settings", "meanings", "columns"];

/// Keys whose details are left out where no path is asked for: those of each half and each depth, lists of candidates and of effects.
const DETAILS: [&str; 6] = ["halves", "depths", "cameras", "rejected", "error_budget", "surface_fits"];

/// The numbers and truth values of `value` by their paths, as in `flat/stereo/vertical_disparity_rms_px`. A figure with what was
/// measured and what is exactly so is two: the measured one at its own path, the exact one at `/true` below. Entries of a list go
/// by their `name`, or their `prism` and `half`, or where others have the same, by their number from 0; `null` is kept. With `wanted` paths only those, and what lies below them; without
/// them all but details.
pub fn flat(value: &Value, wanted: &[String]) -> Map<String, Value> {
    let mut found = Map::new();
    walk("", value, if wanted.is_empty() { &DETAILS } else { &[] }, &mut found);
    if !wanted.is_empty() {
        let below = |path: &str, top: &String| {
            path.strip_prefix(top.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        found.retain(|path, _| wanted.iter().any(|top| below(path, top)));
    }
    found
}

fn walk(path: &str, value: &Value, without: &[&str], found: &mut Map<String, Value>) {
    let joined = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}/{key}") };
    match value {
        Value::Object(map) if map.contains_key("measured") && map.contains_key("true") => {
            found.insert(path.to_owned(), map["measured"].clone());
            found.insert(joined("true"), map["true"].clone());
        }
        Value::Object(map) => {
            let kept = |key: &str| !LEFT_OUT.contains(&key) && !without.contains(&key);
            for (key, inner) in map.iter().filter(|(key, _)| kept(key)) {
                walk(&joined(key), inner, without, found);
            }
        }
        Value::Array(items) => {
            let names: Vec<Option<String>> = items.iter().map(name).collect();
            for (k, item) in items.iter().enumerate() {
                let alone = |name: &&String| names.iter().flatten().filter(|other| other == name).count() == 1;
                let name = names[k].as_ref().filter(alone).map_or_else(|| k.to_string(), String::to_owned);
                walk(&joined(&name), item, without, found);
            }
        }
        Value::Number(_) | Value::Bool(_) | Value::Null => {
            found.insert(path.to_owned(), value.clone());
        }
        Value::String(_) => {}
    }
}

/// What an entry of a list is called: by its `name`, or the prism and half that it is of.
fn name(item: &Value) -> Option<String> {
    let word = |key: &str| item.get(key).and_then(Value::as_str);
    match (word("name"), word("prism"), word("half")) {
        (Some(name), ..) => Some(name.to_owned()),
        (None, Some(prism), Some(half)) => Some(format!("{prism}-{half}")),
        (None, prism, _) => prism.map(str::to_owned),
    }
}

/// What pictures in `figures` say that they do not keep of what was asked for.
pub fn unmet(figures: &Value) -> Vec<String> {
    match figures {
        Value::Object(map) if map.contains_key("promise_px") => {
            serde_json::from_value::<AccuracyEntry>(figures.clone()).map_or(Vec::new(), |account| account.unmet())
        }
        Value::Object(map) => {
            let of_key = |(key, value): (&String, &Value)| {
                let named = |words| if key == "accuracy" { words } else { format!("{key}: {words}") };
                unmet(value).into_iter().map(named).collect::<Vec<_>>()
            };
            map.iter().flat_map(of_key).collect()
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn figures_have_their_paths() {
        let value = json!({
            "halves": { "left": 1 },
            "designs": [
                { "name": "flat", "stereo": { "rms_px": { "measured": 1.5, "true": null, "unit": "px", "n": 4 } } },
                { "name": "own", "solid": true, "timing_s": { "render": 2.0 } },
            ],
            "points": [1, [2]],
            "rows": [{ "prism": "flat", "half": "left", "x": 1 }, { "prism": "flat", "half": "right", "x": 2 }],
            "more": [{ "prism": "flat", "x": 3 }, { "prism": "flat", "x": 4 }],
        });
        let all = flat(&value, &[]);
        let wanted = json!({
            "designs/flat/stereo/rms_px": 1.5, "designs/flat/stereo/rms_px/true": null, "designs/own/solid": true,
            "points/0": 1, "points/1/0": 2, "rows/flat-left/x": 1, "rows/flat-right/x": 2, "more/0/x": 3, "more/1/x": 4,
        });
        assert_eq!(Value::Object(all), wanted);
        let some = flat(&value, &["designs/flat/stereo/rms_px".to_owned(), "point".to_owned()]);
        assert_eq!(some.keys().collect::<Vec<_>>(), ["designs/flat/stereo/rms_px", "designs/flat/stereo/rms_px/true"]);
        // Details are there where they are asked for.
        assert_eq!(Value::Object(flat(&value, &["halves".to_owned()])), json!({ "halves/left": 1 }));
    }
}
