//! Where a page comes from: the words of the command, and the scenes that it has read.

use crate::report::page::origin::{PageOrigin, SceneText};
use std::sync::{Mutex, PoisonError};

/// The scenes that were read, in their order.
static SCENES: Mutex<Vec<SceneText>> = Mutex::new(Vec::new());

/// Notes the text of a scene for the pages of this command.
pub(super) fn note(name: &str, text: &str) {
    let scene = SceneText { name: name.to_owned(), text: text.to_owned() };
    let mut scenes = SCENES.lock().unwrap_or_else(PoisonError::into_inner);
    if !scenes.contains(&scene) {
        scenes.push(scene);
    }
}

/// Where a page of this command comes from.
pub(super) fn origin() -> PageOrigin {
    let arguments = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let words: Vec<String> = std::iter::once("biprism".to_owned()).chain(arguments).collect();
    let scenes = SCENES.lock().unwrap_or_else(PoisonError::into_inner).clone();
    PageOrigin::new(&words, scenes)
}
