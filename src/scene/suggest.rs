//! Spelling suggestions for a word that the scene format does not know.

use serde_json::Value;

/// Units that the format uses, and how it says them.
const UNITS: [(&str, &str); 4] = [("mm", "mm"), ("um", "um"), ("deg", "degrees"), ("px", "px")];
/// Units that a user may have had in mind instead.
const OTHER_UNITS: [&str; 7] = ["m", "cm", "nm", "rad", "degrees", "pixel", "pixels"];

/// Help for the unknown `key` of the table at `path` that has the `known` ones; `schema` is that of the whole file.
pub(super) fn for_key<'k>(
    path: &str,
    key: &str,
    known: impl Iterator<Item = &'k str> + Clone,
    schema: &Value,
) -> String {
    let stem = without_unit(key);
    let with_unit = UNITS.iter().map(|(unit, words)| (format!("{stem}_{unit}"), words));
    if let Some((meant, words)) = with_unit.into_iter().find(|(meant, _)| known.clone().any(|k| k == meant)) {
        return format!("did you mean `{meant}`? the key carries its unit, here {words}");
    }
    let mut tables = Vec::new();
    tables_with(key, "", schema, &mut tables);
    match tables.first() {
        Some(table) if tables.iter().all(|t| t != path) => {
            let place = if table.is_empty() { "at the top of the file".to_owned() } else { format!("in `[{table}]`") };
            return format!("`{key}` has its place {place}");
        }
        Some(_) => return "take it out, or change the kind to one that has it".to_owned(),
        None => {}
    }
    if let Some(meant) = nearest(key, known.clone()) {
        return format!("did you mean `{meant}`?");
    }
    let list: Vec<String> = known.map(|k| format!("`{k}`")).collect();
    format!("take it out, or use one of {}", list.join(", "))
}

/// The candidate that `word` most likely stands for, when one is near enough; capitals do not matter.
pub(super) fn nearest<'k>(word: &str, candidates: impl Iterator<Item = &'k str>) -> Option<&'k str> {
    // One wrong, missing or swapped letter scores above 0.9; two unrelated keys of the format below 0.8.
    const NEAR: f64 = 0.8;
    let word = word.to_lowercase();
    let scored = candidates.map(|c| (strsim::jaro_winkler(&word, &c.to_lowercase()), c));
    scored.filter(|(score, _)| *score > NEAR).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, c)| c)
}

/// A key without the unit at its end, if there is one.
fn without_unit(key: &str) -> &str {
    let units = || UNITS.iter().map(|(unit, _)| *unit).chain(OTHER_UNITS);
    key.rsplit_once('_').filter(|(_, end)| units().any(|u| u == *end)).map_or(key, |(stem, _)| stem)
}

/// The path of every table at or under `path` whose schema has `key`.
fn tables_with(key: &str, path: &str, schema: &Value, found: &mut Vec<String>) {
    for alternative in schema["oneOf"].as_array().into_iter().flatten() {
        tables_with(key, path, alternative, found);
    }
    let Some(properties) = schema["properties"].as_object() else { return };
    if properties.contains_key(key) {
        found.push(path.to_owned());
    }
    for (name, inner) in properties {
        let below = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        tables_with(key, &below, inner, found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::schema::SCHEMA;

    fn help(path: &str, key: &str) -> String {
        let known = SCHEMA["properties"][path]["properties"].as_object().unwrap();
        for_key(path, key, known.keys().map(String::as_str), &SCHEMA)
    }

    #[test]
    fn key_without_its_unit_or_with_another_is_known() {
        for key in ["focal_length", "focal_length_m", "focal_length_um", "focal_length_pixels"] {
            assert_eq!(help("camera", key), "did you mean `focal_length_mm`? the key carries its unit, here mm");
        }
        assert!(help("camera", "pixel_pitch_mm").contains("`pixel_pitch_um`? the key carries its unit, here um"));
        assert!(help("board", "tilt_rad").contains("`tilt_deg`? the key carries its unit, here degrees"));
    }

    #[test]
    fn misspelt_key_is_known_and_a_strange_one_is_not() {
        assert_eq!(help("camera", "witdh_px"), "did you mean `width_px`?");
        assert_eq!(help("board", "collumns"), "did you mean `columns`?");
        assert!(help("board", "quux").starts_with("take it out"));
    }

    #[test]
    fn key_of_another_table_is_sent_there() {
        assert_eq!(help("camera", "grid"), "`grid` has its place in `[analysis]`");
        assert_eq!(help("camera", "accuracy"), "`accuracy` has its place at the top of the file");
        assert_eq!(help("camera", "order"), "`order` has its place in `[prism.design]`");
    }

    #[test]
    fn no_key_of_the_format_is_near_another_of_its_table() {
        let mut tables = vec![&*SCHEMA];
        while let Some(table) = tables.pop() {
            tables.extend(table["oneOf"].as_array().into_iter().flatten());
            let Some(properties) = table["properties"].as_object() else { continue };
            tables.extend(properties.values());
            for key in properties.keys() {
                // Alike on purpose: a table for each effect, and the word for all of them; two plain words of a design.
                let pairs = [["effect", "effects"], ["square", "surface"]];
                let alike = |k: &str| pairs.iter().any(|pair| pair.contains(&k) && pair.contains(&key.as_str()));
                let others = properties.keys().map(String::as_str).filter(|k| k != key && !alike(k));
                assert_eq!(nearest(key, others), None, "{key}");
            }
        }
    }
}
