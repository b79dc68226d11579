//! Values that take the place of those in a scene's text, as `--set prism.index=1.5` gives them.

use super::given_text::{ALONE, Fault, GivenText, GivenValue, Step, alone, steps};
use super::schema::SCHEMA;
use super::structure::item_schema;
use crate::error::Error;
use serde_json::Value;
use std::borrow::Cow;
use std::fmt;
use toml::Spanned;
use toml::de::DeValue;

/// A value that takes the place of one in a scene's text.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    /// Where it belongs: `prism.index`, `board.position_mm[2]`.
    key: String,
    value: OverrideValue,
}

#[derive(Debug, Clone, PartialEq)]
enum OverrideValue {
    /// As a person writes it; empty to take the key out.
    Words(String),
    /// As a program has it; null to take the key out.
    Value(Value),
}

/// The texts of `values`, whose spans begin at the byte `from`, one behind the other. `place` is what the scene is called.
pub(super) fn given(values: &[Override], from: usize, place: &str) -> Result<Vec<GivenText>, Error> {
    let mut all: Vec<GivenText> = Vec::new();
    for value in values {
        let from = all.last().map_or(from, |last| last.span().end);
        all.push(value.given(from, place)?);
    }
    Ok(all)
}

impl Override {
    /// Of the words `key=value`, as in `prism.index=1.5`: the value as in scene text, but that words need no quotes; nothing behind
    /// the `=` takes the key out, so that its default holds.
    ///
    /// # Errors
    /// A sentence that says what is no key.
    pub fn of_words(words: &str) -> Result<Self, String> {
        let (key, value) = words.split_once('=').ok_or("give a key and its value, as in prism.index=1.5")?;
        let key = key.trim();
        steps(key)?;
        Ok(Self { key: key.to_owned(), value: OverrideValue::Words(value.trim().to_owned()) })
    }

    /// Of a `value` by itself; null takes the key out, so that its default holds.
    ///
    /// # Errors
    /// A sentence that says what is no key.
    pub fn of_value(key: &str, value: Value) -> Result<Self, String> {
        steps(key)?;
        Ok(Self { key: key.to_owned(), value: OverrideValue::Value(value) })
    }

    /// Where it belongs.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The value as JSON: a number or a truth value where its words are one, `null` where it takes the key out.
    pub fn json(&self) -> Value {
        let as_toml = |words: &str| alone(&format!("{ALONE}{words}")).and_then(|v| plain(v.get_ref()));
        match &self.value {
            OverrideValue::Value(value) => value.clone(),
            OverrideValue::Words(words) if words.is_empty() => Value::Null,
            OverrideValue::Words(words) => as_toml(words).unwrap_or_else(|| Value::String(words.clone())),
        }
    }

    /// Its text, with spans from `from` on. `place` is what the scene is called.
    fn given(&self, from: usize, place: &str) -> Result<GivenText, Error> {
        // The name of a value that is read by itself is shorter than what stands in front of it here.
        let from = from + ALONE.len();
        let place = match &self.value {
            OverrideValue::Words(_) => format!("--set {self}, for {place}"),
            OverrideValue::Value(_) => format!("{place}: {}", self.key),
        };
        let refused = |(rule, help): Fault| Error::new(&place, rule, help).of_key(&self.key);
        let steps = steps(&self.key).map_err(|rule| refused((rule, "correct the key".to_owned())))?;
        let mut schemas = vec![&*SCHEMA];
        let mut defaults = Vec::new();
        for step in &steps {
            defaults.push(default(step, &schemas));
            schemas = below(&schemas, step);
        }
        let (text, value) = self.read(from + self.key.len() + 1, &schemas).map_err(refused)?;
        Ok(GivenText { key: self.key.clone(), place, from, text: format!("{}={text}", self.key), value, defaults })
    }

    /// The value's text, which begins at the byte `at`, and how it is read. `schemas` may hold for it.
    fn read(&self, at: usize, schemas: &[&Value]) -> Result<(String, GivenValue), Fault> {
        let words = match &self.value {
            OverrideValue::Value(Value::Null) => return Ok((String::new(), GivenValue::Nothing)),
            OverrideValue::Words(words) if words.is_empty() => return Ok((String::new(), GivenValue::Nothing)),
            OverrideValue::Words(words) => words.clone(),
            OverrideValue::Value(value) => toml::Value::try_from(value)
                .map_err(|error| (format!("`{}` cannot be given: {error}", self.key), "correct the value".to_owned()))?
                .to_string(),
        };
        let of_type = |kind: &str| !schemas.is_empty() && schemas.iter().all(|schema| schema["type"] == kind);
        if of_type("string") && !words.starts_with(['"', '\'']) {
            return Ok((words, GivenValue::Word));
        }
        // Blanks in front put its spans where its text stands.
        let padded = |words: &str| format!("{}{ALONE}{words}", " ".repeat(at - ALONE.len()));
        if let Some(text) = Some(padded(&words)).filter(|text| alone(text).is_some()) {
            return Ok((words, GivenValue::Toml(text)));
        }
        let number = words.parse().ok().filter(|n: &f64| n.is_finite() && of_type("number"));
        if let Some(number) = number {
            return Ok((words, GivenValue::Toml(padded(&format!("{number:?}")))));
        }
        if words.starts_with(['"', '\'', '[', '{']) {
            let rule = format!("`{}` is {words}, which is no value of TOML", self.key);
            return Err((rule, "close every quote and bracket, as in [0, 0, 1000]".to_owned()));
        }
        Ok((words, GivenValue::Word))
    }
}

impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.value {
            OverrideValue::Words(words) => write!(f, "{}={words}", self.key),
            OverrideValue::Value(value) => write!(f, "{}={value}", self.key),
        }
    }
}

/// A value of TOML as JSON; `None` of a date and of a number that JSON has not.
fn plain(value: &DeValue) -> Option<Value> {
    Some(match value {
        DeValue::String(word) => Value::String(word.to_string()),
        DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix()).ok()?.into(),
        DeValue::Float(number) => serde_json::Number::from_f64(number.as_str().parse().ok()?)?.into(),
        DeValue::Boolean(truth) => Value::Bool(*truth),
        DeValue::Datetime(_) => return None,
        DeValue::Array(items) => items.iter().map(|item| plain(item.get_ref())).collect::<Option<Vec<_>>>()?.into(),
        DeValue::Table(table) => {
            let pair = |(key, value): (&Spanned<Cow<'_, str>>, &Spanned<DeValue>)| {
                Some((key.get_ref().to_string(), plain(value.get_ref())?))
            };
            Value::Object(table.iter().map(pair).collect::<Option<_>>()?)
        }
    })
}

/// What the value one step below may be, in any alternative.
fn below<'s>(schemas: &[&'s Value], step: &Step) -> Vec<&'s Value> {
    fn tables<'s>(schema: &'s Value, found: &mut Vec<&'s Value>) {
        schema["oneOf"].as_array().into_iter().flatten().for_each(|alternative| tables(alternative, found));
        found.push(schema);
    }
    let mut all = Vec::new();
    schemas.iter().for_each(|schema| tables(schema, &mut all));
    let named = all.iter().filter_map(|schema| schema["properties"].get(step.name));
    let mut found = Vec::new();
    named.for_each(|schema| tables(schema, &mut found));
    for &item in &step.items {
        found = found.into_iter().map(|list| item_schema(list, item)).collect();
    }
    found.retain(|schema| schema.get("type").is_some());
    found
}

/// The list that holds where a scene says nothing of `step`, as TOML; none where it goes into no list.
fn default(step: &Step, schemas: &[&Value]) -> Option<String> {
    if step.items.is_empty() {
        return None;
    }
    let whole = Step { name: step.name, items: Vec::new() };
    let list = below(schemas, &whole).into_iter().find_map(|schema| schema.get("default").filter(|d| d.is_array()))?;
    Some(format!("{ALONE}{}", toml::Value::try_from(list).ok()?))
}

#[cfg(test)]
#[path = "overrides_tests.rs"]
mod tests;
