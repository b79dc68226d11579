//! Tests of values that take the place of others.

use super::super::{from_values, parse_with, sorted_values, text_with};
use super::*;
use crate::scene::{PrismSpec, Scene};
use serde_json::json;

const PAPER: &str = include_str!("../../scenes/paper.toml");

fn with(words: &[&str]) -> Result<Scene, Error> {
    let values: Vec<Override> = words.iter().map(|words| Override::of_words(words).unwrap()).collect();
    parse_with(PAPER, "paper.toml", None, &values)
}

#[test]
fn values_take_the_place_of_those_in_the_text() {
    let scene = with(&["board.position_mm[2]=800", "prism.index = .15e1", "name=123", "board.tilt_deg[1]=5"]).unwrap();
    assert_eq!(scene.name, "123");
    assert_eq!(scene.board.world_from_board.translation_mm.z, 800.0);
    let PrismSpec::Freeform(flat, _) = scene.prism else { panic!("the paper's prism is freeform") };
    assert_eq!(flat.body.index, 1.5);
    let turned = with(&["board.tilt_deg=[0, 5, 0]"]).unwrap();
    assert_eq!(scene.board.world_from_board.rotation, turned.board.world_from_board.rotation);
    // A key is taken out, and a table is made; the last one of a key holds.
    let scene = with(&["accuracy=exact", "accuracy=", "effect.cos4.exponent=3", "effect.cos4.exponent=2"]).unwrap();
    assert_eq!(scene.accuracy, with(&[]).unwrap().accuracy);
    assert_eq!(scene.effects.cos4.map(|cos4| cos4.exponent), Some(2.0));
    assert_eq!(with(&["accuracy={ target_px = 0.01 }"]).unwrap().accuracy.target_px, Some(0.01));
}

/// An error names what was given, the value, the rule and the next step, as for scene text.
#[test]
fn what_is_wrong_with_a_value_is_told_as_for_scene_text() {
    let cases = [
        ("prism.index=abc", "`prism.index` is a string, abc, and must be a number", "write the number alone"),
        ("prism.index=-1", "`prism.index` is -1, and must be", "change `index`"),
        ("prism.indx=1.5", "`prism.indx` is not a key where `kind` is \"freeform\"", "did you mean `index`?"),
        ("camera.width_px=1920.5", "`camera.width_px` is a number with a fraction, 1920.5, and", "decimal point"),
        ("board.position_mm=[0,0,x]", "`board.position_mm` is [0,0,x], which is no value of TOML", "close every"),
        ("board.position_mm[3]=1", "`position_mm` has 3 values, and none of number 3", "correct the number"),
        ("board.position_mm[2]=far", "`board.position_mm[2]` is a string, far, and must be a number", "change"),
        ("board.columns.more=1", "`columns` is no table, and `more` has no place in it", "correct the key"),
        ("name[0]=a", "`name` is no list", "leave the number"),
        ("board.position_mm[2]=", "an item of `position_mm` cannot be taken out", "give the whole list"),
        ("prism.glass=BK7", "`prism.glass` is BK7, and must be", "did you mean \"N-BK7\"?"),
        ("board.position_mm[2]=70", "", ""),
    ];
    for (words, rule, help) in cases {
        let problem = with(&[words]).expect_err(words);
        assert_eq!(problem.place, format!("--set {words}, for paper.toml"), "{problem}");
        assert!(problem.rule.contains(rule) && problem.help.contains(help), "{words}: {problem}");
        assert!(problem.key.is_some() && problem.line().is_none(), "{words}: {problem:?}");
    }
    // What the text has wrong is told with its line there.
    let problem = with(&["prism.kind=flat"]).unwrap_err();
    assert!(problem.key.as_deref() == Some("prism.design") && problem.line().is_some(), "{problem:?}");
    for words in ["", "prism.index", "=1", "a..b=1", "a[x]=1", "a]=1", "a b=1"] {
        assert!(Override::of_words(words).is_err(), "{words}");
    }
}

/// A text with its values is the text with overrides: the same scene, to the last bit.
#[test]
fn a_scene_is_the_same_from_values_and_from_text() {
    let values = [Override::of_words("prism.index=1.5").unwrap(), Override::of_words("board.square_mm=9").unwrap()];
    let whole = parse_with(PAPER, "paper.toml", None, &values).unwrap();
    let text = text_with(PAPER, "paper.toml", &values).unwrap();
    assert_eq!(super::super::parse(&text, "text", None).unwrap(), whole);
    let Value::Object(map) = sorted_values(&text, "text").unwrap() else { panic!("no table") };
    assert_eq!(from_values(&map, "values", None).unwrap(), whole);
    let wrong = json!({ "name": "a", "camera": { "width_px": 5 } });
    let problem = from_values(wrong.as_object().unwrap(), "values", None).unwrap_err();
    assert!(problem.key.is_some() && problem.line().is_none() && problem.place.starts_with("values"), "{problem:?}");
}

#[test]
fn a_value_has_its_json() {
    let of = |words: &str| Override::of_words(words).unwrap().json();
    let found = ["a=1", "a=1.5", "a=true", "a=N-BK7", "a=[1, 2]", "a={ b = \"c\" }", "a="].map(of);
    let wanted = [json!(1), json!(1.5), json!(true), json!("N-BK7"), json!([1, 2]), json!({ "b": "c" }), Value::Null];
    assert_eq!(found, wanted);
}
