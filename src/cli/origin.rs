//! Where a page comes from: the words of the command, and the scenes that it has read.

use crate::report::page::origin::{PageOrigin, SceneText};
use std::ffi::OsString;
use std::sync::{Mutex, OnceLock, PoisonError};

/// The words of the command behind its own name.
static WORDS: OnceLock<Vec<String>> = OnceLock::new();

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

/// Notes the words of the command, of which the first is its own name.
pub(super) fn note_words(words: &[OsString]) {
    let words = words.iter().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    // The first command of a process is the one.
    let _ = WORDS.set(words);
}

/// Where a page of this command comes from.
pub(super) fn origin() -> PageOrigin {
    let words = std::iter::once("biprism".to_owned()).chain(WORDS.get().into_iter().flatten().cloned());
    let words: Vec<String> = words.collect();
    let scenes = SCENES.lock().unwrap_or_else(PoisonError::into_inner).clone();
    PageOrigin::new(&words, scenes)
}
