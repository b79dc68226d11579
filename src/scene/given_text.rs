//! The text of a value that was given besides a document, and how it is put into its tree.

use crate::error::Error;
use std::borrow::Cow;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// What a value is called while it is read by itself.
pub(super) const ALONE: &str = "v = ";

/// A value that was given besides a document, and the texts that it is read from.
pub(super) struct GivenText {
    pub(super) key: String,
    /// How it was given, in messages.
    pub(super) place: String,
    pub(super) from: usize,
    /// Key and value, with `=` between them.
    pub(super) text: String,
    pub(super) value: GivenValue,
    /// For each step of the key that goes into a list, the list that holds where the scene says nothing, as TOML.
    pub(super) defaults: Vec<Option<String>>,
}

/// How the text of a value is read.
pub(super) enum GivenValue {
    /// Its key is taken out.
    Nothing,
    /// It is a word.
    Word,
    /// By this text, in which it stands where its span has it.
    Toml(String),
}

/// A step of a key: its name, and places in lists.
pub(super) struct Step<'k> {
    pub(super) name: &'k str,
    pub(super) items: Vec<usize>,
}

/// What breaks a rule, and the next step.
pub(super) type Fault = (String, String);

impl GivenText {
    /// Puts the value into `table`.
    pub(super) fn put_into<'t>(&'t self, table: &mut DeTable<'t>) -> Result<(), Error> {
        let value_from = self.from + self.key.len() + 1;
        let value = match &self.value {
            GivenValue::Nothing => None,
            GivenValue::Word => {
                let word = &self.text[self.key.len() + 1..];
                Some(Spanned::new(value_from..self.span().end, DeValue::String(Cow::Borrowed(word))))
            }
            GivenValue::Toml(text) => alone(text),
        };
        let refused = |(rule, help): Fault| Error::new(&self.place, rule, help).of_key(&self.key);
        let steps = steps(&self.key).map_err(|rule| refused((rule, "correct the key".to_owned())))?;
        put(table, &steps, value, &Whole { span: self.span(), defaults: &self.defaults }).map_err(refused)
    }

    /// Its bytes in the document.
    pub(super) fn span(&self) -> Range<usize> {
        self.from..self.from + self.text.len()
    }

    /// What it says at `span` of the document.
    pub(super) fn words(&self, span: Range<usize>) -> &str {
        self.text.get(span.start - self.from..span.end - self.from).unwrap_or(&self.text)
    }
}

/// The steps of a key.
pub(super) fn steps(key: &str) -> Result<Vec<Step<'_>>, String> {
    let wrong = || format!("{key:?} is no key of a scene; one is like prism.index or board.position_mm[2]");
    let step = |word: &'_ str| {
        let (name, items) = word.split_once('[').map_or((word, None), |(name, items)| (name, Some(items)));
        let named = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
        let items = match items {
            None => Some(Vec::new()),
            Some(items) => items.strip_suffix(']')?.split("][").map(|digits| digits.parse().ok()).collect(),
        };
        items.filter(|_| named).map(|items: Vec<usize>| (name.len(), items))
    };
    let named = |word| step(word).map(|(end, items)| Step { name: &word[..end], items }).ok_or_else(wrong);
    key.split('.').map(named).collect()
}

/// The one value of a text that gives it to [`ALONE`].
pub(super) fn alone(text: &str) -> Option<Spanned<DeValue<'_>>> {
    let mut table = DeTable::parse(text).ok()?.into_inner();
    table.remove("v").filter(|_| table.is_empty())
}

/// What a value is put into place by.
struct Whole<'t> {
    /// The bytes of key and value.
    span: Range<usize>,
    /// Lists of the steps that are left.
    defaults: &'t [Option<String>],
}

/// Puts `value` at `steps` below `table`; none takes the key out.
fn put<'t>(
    table: &mut DeTable<'t>,
    steps: &[Step],
    value: Option<Spanned<DeValue<'t>>>,
    whole: &Whole<'t>,
) -> Result<(), Fault> {
    let (Some((step, rest)), Some((default, defaults))) = (steps.split_first(), whole.defaults.split_first()) else {
        return Ok(());
    };
    let named = || Spanned::new(whole.span.clone(), Cow::Owned(step.name.to_owned()));
    if rest.is_empty() && step.items.is_empty() {
        table.remove(step.name);
        if let Some(value) = value {
            table.insert(named(), value);
        }
        return Ok(());
    }
    if table.get(step.name).is_none() {
        let begun = match default {
            None if step.items.is_empty() => Some(DeValue::Table(DeTable::new())),
            default => default.as_deref().and_then(|text| list(text, &whole.span)),
        };
        let Some(begun) = begun else {
            let rule = format!("the scene gives no list `{}`, and an item of it has no place", step.name);
            return Err((rule, "give the whole list, as in board.tilt_deg=[0,5,0]".to_owned()));
        };
        table.insert(named(), Spanned::new(whole.span.clone(), begun));
    }
    // A list with an item that was given is no longer as its text has it: what is wrong with the whole is told of what was given.
    if !step.items.is_empty()
        && let Some(list) = table.remove(step.name)
    {
        table.insert(named(), Spanned::new(whole.span.clone(), list.into_inner()));
    }
    let mut inner = table.get_mut(step.name);
    for &item in &step.items {
        let Some(DeValue::Array(items)) = inner.map(Spanned::get_mut) else {
            return Err((format!("`{}` is no list", step.name), "leave the number in brackets out".to_owned()));
        };
        let count = items.len();
        let Some(found) = items.get_mut(item) else {
            let rule = format!("`{}` has {count} values, and none of number {item}: the first is 0", step.name);
            return Err((rule, "correct the number in brackets".to_owned()));
        };
        inner = Some(found);
    }
    match (inner, rest.first(), value) {
        (Some(inner), None, Some(value)) => {
            *inner = value;
            Ok(())
        }
        (_, None, _) => {
            Err((format!("an item of `{}` cannot be taken out", step.name), "give the whole list".to_owned()))
        }
        (inner, Some(next), value) => match inner.map(Spanned::get_mut) {
            Some(DeValue::Table(inner)) => put(inner, rest, value, &Whole { span: whole.span.clone(), defaults }),
            _ => {
                let rule = format!("`{}` is no table, and `{}` has no place in it", step.name, next.name);
                Err((rule, "correct the key".to_owned()))
            }
        },
    }
}

/// The list in a text that gives it to [`ALONE`], with `span` for each of its items.
fn list<'t>(text: &'t str, span: &Range<usize>) -> Option<DeValue<'t>> {
    let DeValue::Array(items) = alone(text)?.into_inner() else { return None };
    let mut list = DeArray::new();
    items.into_iter().for_each(|item| list.push(Spanned::new(span.clone(), item.into_inner())));
    Some(DeValue::Array(list))
}
