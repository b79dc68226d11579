//! The values that a key of a scene takes, one after the other.

use super::overrides::Override;

/// The most values of a key.
const MOST_VALUES: usize = 1_000_000;

/// A key of a scene with the values that it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    values: Vec<Override>,
}

impl Sweep {
    /// Of the words `key=a:b:n`, n values from a to b with both ends among them, as far from each other; or of `key=v1,v2,...`, those
    /// values, with commas within brackets and quotes left alone. Whole ends give whole numbers where every value is one.
    ///
    /// # Errors
    /// A sentence that says what is wrong: no key, no value, the same value twice, more than a million.
    pub fn of_words(words: &str) -> Result<Self, String> {
        let form = || "give a key and its values, as in prism.index=1.46:1.5:6 or prism.glass=N-BK7,N-SF11";
        let (key, values) = words.split_once('=').ok_or_else(form)?;
        let texts = match range(values) {
            Some(texts) => texts?,
            None => items(values).into_iter().map(str::to_owned).collect(),
        };
        if texts.iter().any(|text| text.trim().is_empty()) {
            return Err(form().to_owned());
        }
        let values =
            texts.iter().map(|text| Override::of_words(&format!("{key}={text}"))).collect::<Result<Vec<_>, _>>()?;
        let mut seen: Vec<String> = values.iter().map(|value| value.json().to_string()).collect();
        seen.sort_unstable();
        match seen.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(format!("{} is there twice", pair[0])),
            None => Ok(Self { values }),
        }
    }

    /// The key.
    pub fn key(&self) -> &str {
        self.values.first().map_or("", Override::key)
    }

    /// Its values, in their order: at least one.
    pub fn values(&self) -> &[Override] {
        &self.values
    }
}

/// The values of `a:b:n` as texts; `None` where it is none.
fn range(text: &str) -> Option<Result<Vec<String>, String>> {
    let [a, b, n]: [&str; 3] = text.split(':').collect::<Vec<_>>().try_into().ok()?;
    let end = |text: &str| text.trim().parse().ok().filter(|end: &f64| end.is_finite());
    let Some((from, to)) = end(a).zip(end(b)) else {
        let ends = || format!("the ends of a range are numbers, not {a} and {b}");
        return n.trim().parse::<usize>().is_ok().then(|| Err(ends()));
    };
    let count = n.trim().parse::<usize>().ok().filter(|count| (1..=MOST_VALUES).contains(count));
    let Some(count) = count else {
        return Some(Err(format!("there are {n} values, and the number of values is from 1 to {MOST_VALUES}")));
    };
    if count == 1 && from != to {
        return Some(Err("one value cannot be both ends: give 2 or more, or that value alone".to_owned()));
    }
    let whole = [a, b].iter().all(|text| text.trim().parse::<i64>().is_ok());
    let values: Vec<f64> = (0..count).map(|k| between(from, to, k, count)).collect();
    let whole = whole && values.iter().all(|value| value.trunc() == *value);
    Some(Ok(values.into_iter().map(|v| if whole { format!("{v:.0}") } else { format!("{v:?}") }).collect()))
}

/// Value `k` of `count` from `from` to `to`, to 15 digits, so that 0.1 is not 0.09999999999999999; the ends as they are.
fn between(from: f64, to: f64, k: usize, count: usize) -> f64 {
    if k == 0 {
        return from;
    }
    if k + 1 == count {
        return to;
    }
    let value = from + (to - from) * k as f64 / (count - 1) as f64;
    format!("{value:.14e}").parse().unwrap_or(value)
}

/// The parts of a list between commas that are in no bracket and no quote.
fn items(text: &str) -> Vec<&str> {
    let (mut parts, mut from, mut depth, mut quote) = (Vec::new(), 0, 0usize, None);
    for (at, c) in text.char_indices() {
        match (c, quote) {
            (c, Some(open)) if c == open => quote = None,
            (_, Some(_)) => {}
            ('"' | '\'', None) => quote = Some(c),
            ('[' | '{', None) => depth += 1,
            (']' | '}', None) => depth = depth.saturating_sub(1),
            (',', None) if depth == 0 => {
                parts.push(&text[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[from..]);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn values(words: &str) -> Result<Vec<serde_json::Value>, String> {
        Sweep::of_words(words).map(|sweep| sweep.values().iter().map(Override::json).collect())
    }

    #[test]
    fn a_range_has_both_ends() {
        assert_eq!(values("a.b=1.46:1.5:5"), Ok(vec![json!(1.46), json!(1.47), json!(1.48), json!(1.49), json!(1.5)]));
        assert_eq!(values("a=0:0.3:4"), Ok(vec![json!(0.0), json!(0.1), json!(0.2), json!(0.3)]));
        assert_eq!(values("a[2]=-2:2:3"), Ok(vec![json!(-2), json!(0), json!(2)]));
        assert_eq!(values("a=1:2:3"), Ok(vec![json!(1.0), json!(1.5), json!(2.0)]));
        assert_eq!(values("a=7:7:1"), Ok(vec![json!(7)]));
        for wrong in [
            "a=1:2:0",
            "a=1:2:1",
            "a=1:2:x",
            "a=1:2:1000001",
            "a=1:1:2",
            "a",
            "=1",
            "a=",
            "a=1,,2",
            "a=1,2,1",
            "a=nan:2:3",
            "a=b:c:3",
        ] {
            assert!(values(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_list_keeps_brackets_and_quotes_together() {
        assert_eq!(values("a=N-BK7,N-SF11"), Ok(vec![json!("N-BK7"), json!("N-SF11")]));
        assert_eq!(values("a=[0,0,5],[0,0,8]"), Ok(vec![json!([0, 0, 5]), json!([0, 0, 8])]));
        assert_eq!(values("a=\"x,y\",z"), Ok(vec![json!("x,y"), json!("z")]));
        assert_eq!(Sweep::of_words("a.b=1,2").unwrap().key(), "a.b");
    }
}
