//! Two records of numbers, leaf by leaf, each leaf with its own tolerance.

use serde::Serialize;
use serde_json::Value;

/// How far a leaf of a record may move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tolerance {
    /// Not at all: counts, names, flags.
    Exact,
    /// A number may move by this much, in its own unit.
    Number(f64),
    /// A coordinate of a point in the image may move by this much, in px. The coordinates that stand together in one
    /// array or object are one point, whose shift is their common length.
    Px(f64),
    /// As far as it likes: it follows from what may move.
    Any,
}

/// How far one record is from another.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct RecordDifference {
    /// What is out of tolerance, one sentence a leaf.
    pub mismatches: Vec<String>,
    /// The point that moved most; none when no point moved.
    pub largest_shift: Option<Shift>,
}

/// How far a point moved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shift {
    /// JSON pointer to the point: `/corners/3`.
    pub path: String,
    /// Distance, in px.
    pub px: f64,
}

/// Compares two records; `tolerance` gives that of each leaf by its JSON pointer: `/corners/3/x_px`.
///
/// The order of keys does not matter. A missing or added key and an array of another length are mismatches of their
/// own, and nothing below them is compared.
pub fn compare(expected: &Value, actual: &Value, tolerance: &dyn Fn(&str) -> Tolerance) -> RecordDifference {
    let mut found = RecordDifference::default();
    node("", expected, actual, tolerance, &mut found);
    found
}

/// Compares two nodes and returns by how much a coordinate moved, in px; 0 for what is no coordinate.
fn node(
    path: &str,
    expected: &Value,
    actual: &Value,
    tolerance: &dyn Fn(&str) -> Tolerance,
    found: &mut RecordDifference,
) -> f64 {
    let moves: Vec<f64> = match (expected, actual) {
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let child = |(k, (a, b))| node(&format!("{path}/{k}"), a, b, tolerance, found);
            a.iter().zip(b).enumerate().map(child).collect()
        }
        (Value::Array(a), Value::Array(b)) => {
            found.mismatches.push(format!("{path} had {} entries and has {}", a.len(), b.len()));
            return 0.0;
        }
        (Value::Object(a), Value::Object(b)) => {
            let missing = a.keys().filter(|key| !b.contains_key(*key)).map(|key| format!("{path}/{key} is missing"));
            let added = b.keys().filter(|key| !a.contains_key(*key)).map(|key| format!("{path}/{key} is new"));
            found.mismatches.extend(missing.chain(added));
            a.iter()
                .filter_map(|(key, a)| Some((key, a, b.get(key)?)))
                .map(|(key, a, b)| node(&format!("{path}/{key}"), a, b, tolerance, found))
                .collect()
        }
        _ => return leaf(path, expected, actual, tolerance(path), found),
    };
    let px = moves.iter().map(|v| v * v).sum::<f64>().sqrt();
    if px > found.largest_shift.as_ref().map_or(0.0, |shift| shift.px) {
        found.largest_shift = Some(Shift { path: path.to_owned(), px });
    }
    0.0
}

fn leaf(path: &str, expected: &Value, actual: &Value, tolerance: Tolerance, found: &mut RecordDifference) -> f64 {
    let difference = match (expected.as_f64(), actual.as_f64()) {
        (Some(a), Some(b)) => Some(b - a),
        _ => None,
    };
    let (allowed, unit, moved) = match (tolerance, difference) {
        (Tolerance::Any, _) => return 0.0,
        (Tolerance::Number(allowed), Some(_)) => (allowed, "", 0.0),
        (Tolerance::Px(allowed), Some(difference)) => (allowed, " px", difference),
        _ => {
            if expected != actual {
                found.mismatches.push(format!("{path} was {expected} and is {actual}"));
            }
            return 0.0;
        }
    };
    let difference = difference.unwrap_or_default();
    if difference.abs() > allowed {
        let change = format!("{path} was {expected} and is {actual}, {difference:+.3e}{unit}, of {allowed:e} allowed");
        found.mismatches.push(change);
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn by_name(path: &str) -> Tolerance {
        match path.rsplit('/').next() {
            Some("x" | "y" | "0" | "1") => Tolerance::Px(1e-9),
            Some("rms") => Tolerance::Number(1e-3),
            _ => Tolerance::Exact,
        }
    }

    fn mismatches(expected: &Value, actual: &Value) -> Vec<String> {
        compare(expected, actual, &by_name).mismatches
    }

    #[test]
    fn a_point_moves_by_the_length_of_its_coordinates() {
        let at =
            |x: f64, y: f64| json!({"corners": [{"x": 10.0, "y": 20.0}, {"x": x, "y": y, "id": 7}], "b": [[x, 0.0]]});
        let found = compare(&at(5.0, 5.0), &at(5.03, 5.04), &by_name);
        let shift = found.largest_shift.unwrap();
        assert_eq!(shift.path, "/corners/1");
        assert!((shift.px - 0.05).abs() < 1e-15);
        assert_eq!(found.mismatches.len(), 3);
        let within = compare(&at(5.0, 5.0), &at(5.0 + 5e-10, 5.0), &by_name);
        assert!(within.mismatches.is_empty() && within.largest_shift.unwrap().px < 1e-9);
        assert_eq!(compare(&at(5.0, 5.0), &at(5.0, 5.0), &by_name), RecordDifference::default());
    }

    #[test]
    fn every_kind_of_change_is_one_sentence() {
        let expected = json!({"count": 3, "rms": 0.5, "name": "flat", "list": [1, 2], "none": null});
        let change = |key: &str, value: Value| {
            let mut actual = expected.clone();
            actual[key] = value;
            mismatches(&expected, &actual)
        };
        assert_eq!(change("count", json!(4)), ["/count was 3 and is 4"]);
        assert_eq!(change("rms", json!(0.5005)), [] as [&str; 0]);
        assert_eq!(change("rms", json!(0.6)).len(), 1);
        assert_eq!(change("rms", json!(null)), ["/rms was 0.5 and is null"]);
        assert_eq!(change("name", json!("freeform")), ["/name was \"flat\" and is \"freeform\""]);
        assert_eq!(change("list", json!([1])), ["/list had 2 entries and has 1"]);
        assert_eq!(change("list", json!({})), ["/list was [1,2] and is {}"]);
        assert_eq!(change("none", json!(0)), ["/none was null and is 0"]);
        assert_eq!(change("extra", json!(0)), ["/extra is new"]);
        assert_eq!(mismatches(&expected, &json!({"rms": 0.5, "name": "flat", "list": [1, 2], "none": null})).len(), 1);
    }

    #[test]
    fn the_order_of_keys_does_not_matter() {
        assert!(mismatches(&json!({"a": 1, "b": 2}), &json!({"b": 2, "a": 1})).is_empty());
    }
}
