//! The structural check of a scene file against the schema: keys, types, ranges, choices and lengths of lists.
//!
//! The rules are read from the schema itself, so that the reader, the shipped `scene.schema.json` and the words of a
//! message cannot part. What relates two values is judged by [`super::check`].

use super::document::Document;
use super::suggest;
use crate::error::Error;
use serde_json::Value;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Judge the whole document by `schema`; the first fault is told.
pub(super) fn check(document: &Document, schema: &Value) -> Result<(), Error> {
    let walk = Walk { document, whole: schema };
    walk.table(&At { path: "", span: 0..0 }, document.root.get_ref(), schema)
}

struct Walk<'a> {
    document: &'a Document<'a>,
    /// The schema of the whole file, in which misplaced keys are sought.
    whole: &'a Value,
}

/// A place in the file: its path of keys, and its bytes.
struct At<'a> {
    path: &'a str,
    span: Range<usize>,
}

impl Walk<'_> {
    fn value(&self, at: &At, value: &DeValue, schema: &Value) -> Result<(), Error> {
        if let Some(all) = schema["oneOf"].as_array() {
            return match all.iter().all(|alternative| tag(alternative).is_none()) {
                true => self.value(at, value, of_kind(value, all)),
                false => self.alternatives(at, value, schema),
            };
        }
        let wanted = schema["type"].as_str().unwrap_or_default();
        match (wanted, value) {
            ("object", DeValue::Table(table)) => self.table(at, table, schema),
            ("array", DeValue::Array(items)) => self.list(at, items, schema),
            ("string", DeValue::String(word)) => self.word(at, word, schema),
            ("boolean", DeValue::Boolean(_)) => Ok(()),
            ("integer", DeValue::Integer(_)) | ("number", DeValue::Integer(_) | DeValue::Float(_)) => {
                self.number(at, number(value), schema)
            }
            _ => Err(self.wrong_type(at, value, wanted, schema)),
        }
    }

    /// Keys of a table: none unknown, none missing, each value right.
    fn table(&self, at: &At, table: &DeTable, schema: &Value) -> Result<(), Error> {
        let known = schema["properties"].as_object().into_iter().flatten();
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        for (key, _) in &entries {
            let name: &str = key.get_ref();
            if !known.clone().any(|(k, _)| k == name) {
                let rule = match tag(schema) {
                    Some((tag, kind)) => {
                        format!("`{}` is not a key where `{tag}` is \"{kind}\"", joined(at.path, name))
                    }
                    None => format!("`{}` is not a key of a scene", joined(at.path, name)),
                };
                let help = suggest::for_key(at.path, name, known.clone().map(|(k, _)| k.as_str()), self.whole);
                return Err(self.document.problem(key.span(), rule, help).of_key(joined(at.path, name)));
            }
        }
        for required in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            if table.get(required).is_none() {
                let rule = format!("`{}` is missing", joined(at.path, required));
                let problem = self.document.problem(at.span.clone(), rule, missing_help(at.path, required, schema));
                return Err(problem.of_key(joined(at.path, required)));
            }
        }
        for (key, value) in entries {
            let path = joined(at.path, key.get_ref());
            // A table that dotted keys imply has no text of its own.
            let span = Some(value.span()).filter(|s| !s.is_empty()).unwrap_or(key.span());
            self.value(&At { path: &path, span }, value.get_ref(), &schema["properties"][&**key.get_ref()])?;
        }
        Ok(())
    }

    /// A table whose tag (`kind`) says which keys it has.
    fn alternatives(&self, at: &At, value: &DeValue, schema: &Value) -> Result<(), Error> {
        let DeValue::Table(table) = value else { return Err(self.wrong_type(at, value, "object", schema)) };
        let all = schema["oneOf"].as_array().into_iter().flatten();
        let tags: Vec<_> = all.clone().filter_map(tag).collect();
        let Some(&(key, _)) = tags.first() else { return Ok(()) };
        let kinds = tags.iter().map(|(_, kind)| *kind);
        let path = joined(at.path, key);
        let Some(given) = table.get(key) else {
            let help = format!("add `{key}` to `[{}]`: {}", at.path, one_of(kinds));
            return Err(self.document.problem(at.span.clone(), format!("`{path}` is missing"), help).of_key(path));
        };
        let place = At { path: &path, span: given.span() };
        let DeValue::String(word) = given.get_ref() else {
            let problem = self.wrong_type(&place, given.get_ref(), "string", schema);
            return Err(Error { help: format!("write {}", one_of(kinds)), ..problem });
        };
        match all.zip(&tags).find(|(_, (_, kind))| kind == word) {
            Some((alternative, _)) => self.table(at, table, alternative),
            None => Err(self.no_choice(&place, word, kinds)),
        }
    }

    fn list(&self, at: &At, items: &[Spanned<DeValue>], schema: &Value) -> Result<(), Error> {
        if let Some(wanted) = of_wrong_length(items.len(), schema) {
            let rule = format!("`{}` has {} values, and must have {wanted}", at.path, items.len());
            return Err(self.problem(at, rule, change(at.path, schema)));
        }
        for (i, item) in items.iter().enumerate() {
            let each = item_schema(schema, i);
            self.value(&At { path: &format!("{}[{i}]", at.path), span: item.span() }, item.get_ref(), each)
                .map_err(|problem| self.with_list_help(problem, each, at.path, schema))?;
        }
        Ok(())
    }

    fn word(&self, at: &At, word: &str, schema: &Value) -> Result<(), Error> {
        if let Some(choices) = schema["enum"].as_array() {
            let words = choices.iter().filter_map(Value::as_str);
            return if words.clone().any(|w| w == word) { Ok(()) } else { Err(self.no_choice(at, word, words)) };
        }
        let Some(found) = too_short_or_long(word, schema) else { return Ok(()) };
        let rule = format!("`{}` has {found}", at.path);
        Err(self.problem(at, rule, change(at.path, schema)))
    }

    fn number(&self, at: &At, number: f64, schema: &Value) -> Result<(), Error> {
        let Some(wanted) = out_of_range(number, schema) else { return Ok(()) };
        let rule = format!("`{}` is {}, and must be {wanted}", at.path, self.document.shown(at.span.clone()));
        Err(self.problem(at, rule, change(at.path, schema)))
    }

    fn no_choice<'k>(&self, at: &At, word: &str, choices: impl Iterator<Item = &'k str> + Clone) -> Error {
        let shown = self.document.shown(at.span.clone());
        let rule = format!("`{}` is {shown}, and must be {}", at.path, one_of(choices.clone()));
        // The end of a word, as in "BK7" for "N-BK7", stands for the whole one.
        let end = || choices.clone().find(|c| word.len() > 1 && c.to_lowercase().ends_with(&word.to_lowercase()));
        let help = match suggest::nearest(word, choices.clone()).or_else(end) {
            Some(meant) => format!("did you mean \"{meant}\"?"),
            None => format!("write {}", one_of(choices)),
        };
        self.problem(at, rule, help)
    }

    fn wrong_type(&self, at: &At, value: &DeValue, wanted: &str, schema: &Value) -> Error {
        let (given, shows_value) = match value {
            DeValue::String(_) => ("a string", true),
            DeValue::Integer(_) => ("a whole number", true),
            DeValue::Float(_) => ("a number with a fraction", true),
            DeValue::Boolean(_) => ("a truth value", true),
            DeValue::Datetime(_) => ("a date or time", true),
            DeValue::Array(_) => ("a list", false),
            DeValue::Table(_) => ("a table", false),
        };
        let wanted_words = match wanted {
            "object" => "a table",
            "array" => "a list",
            "string" => "a string",
            "integer" => "a whole number",
            "boolean" => "a truth value",
            _ => "a number",
        };
        let shown = if shows_value { format!(", {},", self.document.shown(at.span.clone())) } else { String::new() };
        let rule = format!("`{}` is {given}{shown} and must be {wanted_words}", at.path);
        let help = match (wanted, value) {
            ("object", _) => format!("give its keys under `[{}]`", at.path),
            ("array", _) => format!("give a list in brackets: {}", described(schema)),
            ("string", _) => match schema["enum"].as_array() {
                Some(choices) => format!("write {}", one_of(choices.iter().filter_map(Value::as_str))),
                None => format!("give it in quotes: {}", described(schema)),
            },
            ("boolean", _) => "write true or false, without quotes".to_owned(),
            ("integer", DeValue::Float(_)) => "write it without a decimal point".to_owned(),
            (_, DeValue::String(_)) => {
                "write the number alone: no quotes, and no unit, which the key states".to_owned()
            }
            _ => change(at.path, schema),
        };
        self.problem(at, rule, help)
    }

    fn problem(&self, at: &At, rule: String, help: String) -> Error {
        self.document.problem(at.span.clone(), rule, help).of_key(at.path)
    }

    /// An item of a list has no words of its own: the list's help serves.
    fn with_list_help(&self, problem: Error, item: &Value, path: &str, list: &Value) -> Error {
        let own = item.get("description").is_some() || item.get("properties").is_some();
        if own { problem } else { Error { help: change(path, list), ..problem } }
    }
}

/// The alternative for a value of this kind, a table, a list or a word; the first for any other kind, which none allows.
fn of_kind<'s>(value: &DeValue, alternatives: &'s [Value]) -> &'s Value {
    let kind = match value {
        DeValue::Table(_) => "object",
        DeValue::Array(_) => "array",
        _ => "",
    };
    let fits = |schema: &&Value| match schema["type"].as_str() {
        Some(own @ ("object" | "array")) => own == kind,
        _ => kind.is_empty(),
    };
    alternatives.iter().find(fits).unwrap_or(&alternatives[0])
}

/// What a number must be, in words, where it is not.
pub(super) fn out_of_range(number: f64, schema: &Value) -> Option<String> {
    let bound = |key: &str| schema[key].as_f64();
    let (min, above) = (bound("minimum"), bound("exclusiveMinimum"));
    let (max, below) = (bound("maximum"), bound("exclusiveMaximum"));
    // NaN breaks each of them; and every number of the schema has bounds on both sides.
    let holds = min.is_none_or(|m| number >= m)
        && above.is_none_or(|m| number > m)
        && max.is_none_or(|m| number <= m)
        && below.is_none_or(|m| number < m);
    if holds {
        return None;
    }
    let bounds = [("at least", min), ("above", above), ("at most", max), ("below", below)];
    let words = bounds.into_iter().filter_map(|(word, m)| m.map(|m| format!("{word} {}", short(m))));
    let finite = if number.is_finite() { "" } else { "a finite number, " };
    Some(format!("{finite}{}", words.collect::<Vec<_>>().join(" and ")))
}

/// How many items a list must have, in words, where `count` is something else.
pub(super) fn of_wrong_length(count: usize, schema: &Value) -> Option<String> {
    let bound = |key: &str| schema[key].as_u64().map(|n| n as usize);
    let (least, most) = (bound("minItems").unwrap_or(0), bound("maxItems").unwrap_or(usize::MAX));
    let wanted = || if least == most { least.to_string() } else { format!("{least} to {most}") };
    (count < least || count > most).then(wanted)
}

/// How many characters a word has and must have, where these differ.
pub(super) fn too_short_or_long(word: &str, schema: &Value) -> Option<String> {
    let length = word.chars().count() as u64;
    let (least, most) = (schema["minLength"].as_u64().unwrap_or(0), schema["maxLength"].as_u64().unwrap_or(u64::MAX));
    let told = || format!("{length} characters, and must have {least} to {most}");
    (!(least..=most).contains(&length)).then(told)
}

/// The schema of item `i` of a list.
pub(super) fn item_schema(list: &Value, i: usize) -> &Value {
    match &list["items"] {
        Value::Array(positions) => positions.get(i).unwrap_or(&Value::Null),
        each => each,
    }
}

/// The tag of one alternative: its key and its word.
pub(super) fn tag(schema: &Value) -> Option<(&str, &str)> {
    schema["properties"].as_object()?.iter().find_map(|(key, s)| Some((key.as_str(), s.get("const")?.as_str()?)))
}

fn number(value: &DeValue) -> f64 {
    match value {
        // An integer beyond i64 is beyond every limit too.
        DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).map_or(f64::MAX, |i| i as f64),
        DeValue::Float(f) => f.as_str().parse().unwrap_or(f64::NAN),
        _ => f64::NAN,
    }
}

fn missing_help(table: &str, key: &str, schema: &Value) -> String {
    let inner = &schema["properties"][key];
    let is_table = inner.get("oneOf").is_some() || inner["type"] == "object";
    let description = described(inner);
    match (is_table, table) {
        (true, _) => format!("add a table `[{}]`: {description}", joined(table, key)),
        (false, "") => format!("add `{key} = ...` above the first table: {description}"),
        (false, _) => format!("add `{key} = ...` to `[{table}]`: {description}"),
    }
}

pub(super) fn change(path: &str, schema: &Value) -> String {
    let key = path.rsplit('.').next().unwrap_or(path);
    match described(schema) {
        words if words.is_empty() => format!("change `{key}`"),
        words => format!("change `{key}`: {words}"),
    }
}

/// A key's description as the end of a sentence.
fn described(schema: &Value) -> String {
    let words = schema["description"].as_str().unwrap_or_default().trim_end_matches('.');
    let mut letters = words.chars();
    match (letters.next(), letters.clone().next()) {
        (Some(first), Some(second)) if !second.is_uppercase() => first.to_lowercase().chain(letters).collect(),
        _ => words.to_owned(),
    }
}

fn one_of<'k>(words: impl Iterator<Item = &'k str>) -> String {
    let quoted: Vec<String> = words.map(|w| format!("\"{w}\"")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => quoted.concat(),
    }
}

fn joined(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// A limit as one would write it.
fn short(number: f64) -> String {
    let (plain, power) = (format!("{number}"), format!("{number:e}"));
    let long = number != 0.0 && !(1e-3..1e6).contains(&number.abs());
    if long && power.len() < plain.len() { power } else { plain }
}

#[cfg(test)]
mod tests {
    use super::super::schema::{SCHEMA, SceneFile};
    use super::*;

    /// A value that `schema` allows, as TOML: of a table all its keys, of `n` the choice where there are several.
    fn sample(schema: &Value, n: usize) -> String {
        if let Some(all) = schema["oneOf"].as_array() {
            return sample(&all[n % all.len()], n);
        }
        let choices = schema["enum"].as_array();
        let number = |fallback: f64| schema["minimum"].as_f64().or(schema["maximum"].as_f64()).unwrap_or(fallback);
        match schema["type"].as_str() {
            Some("object") => {
                let keys = schema["properties"].as_object().into_iter().flatten();
                let pairs: Vec<String> = keys.map(|(key, inner)| format!("{key} = {}", sample(inner, n))).collect();
                format!("{{ {} }}", pairs.join(", "))
            }
            Some("array") => {
                let count = schema["minItems"].as_u64().unwrap_or(0).max(1) as usize;
                let item = |i: usize| schema["items"].as_array().map_or(&schema["items"], |items| &items[i]);
                format!("[{}]", (0..count).map(|i| sample(item(i), n)).collect::<Vec<_>>().join(", "))
            }
            Some("string") => match (schema.get("const"), choices) {
                (Some(word), _) => word.to_string(),
                (None, Some(words)) => words[n % words.len()].to_string(),
                (None, None) => format!("\"{}\"", "a".repeat(schema["minLength"].as_u64().unwrap_or(1) as usize)),
            },
            Some("boolean") => n.is_multiple_of(2).to_string(),
            Some("integer") => format!("{}", number(0.0)),
            Some("number") => format!("{:?}", number(0.0)),
            other => panic!("no value of type {other:?} is known here: {schema}"),
        }
    }

    /// Every key of every table can be given with a value of its own type, and every choice be taken.
    #[test]
    fn every_key_of_the_schema_can_be_given() {
        let mut booleans = 0;
        for n in 0..60 {
            let keys = SCHEMA["properties"].as_object().expect("the schema has keys");
            let text: String = keys.iter().map(|(key, inner)| format!("{key} = {}\n", sample(inner, n))).collect();
            let document = Document::parse(&text, "test").unwrap_or_else(|problem| panic!("{problem}\n{text}"));
            check(&document, &SCHEMA).unwrap_or_else(|problem| panic!("{problem}\n{text}"));
            document.values::<SceneFile>().unwrap_or_else(|problem| panic!("{problem}\n{text}"));
            booleans += text.matches("shot_noise = true").count() + text.matches("shot_noise = false").count();
        }
        assert_eq!(booleans, 60);
    }

    #[test]
    fn limits_are_shown_short() {
        let shown = [0.0, 0.001, 1e-9, 89.0, 65536.0, 1e12, f64::from(u32::MAX)].map(short);
        assert_eq!(shown, ["0", "0.001", "1e-9", "89", "65536", "1e12", "4294967295"]);
    }

    #[test]
    fn what_is_no_truth_value_is_told() {
        let text = include_str!("../../scenes/paper.toml").to_owned() + "\n[effect.sensor]\nshot_noise = 0\n";
        let problem = check(&Document::parse(&text, "test").expect("it is TOML"), &SCHEMA).expect_err("0 is a number");
        assert_eq!(problem.rule, "`effect.sensor.shot_noise` is a whole number, 0, and must be a truth value");
        assert_eq!(problem.help, "write true or false, without quotes");
    }
}
