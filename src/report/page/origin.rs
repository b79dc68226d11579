//! Where a page comes from: the command, the program and the scenes.

use serde::Serialize;

/// What repeats a result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PageOrigin {
    /// The command, as a shell takes it.
    pub command: String,
    /// The machine's system and architecture.
    pub system: String,
    /// The scenes, each once.
    pub scenes: Vec<SceneText>,
}

/// A scene as it was read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SceneText {
    /// How its file is called.
    pub name: String,
    /// Its text.
    pub text: String,
}

impl PageOrigin {
    /// Of the command with these words.
    pub fn new(words: &[String], scenes: Vec<SceneText>) -> Self {
        let command = words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ");
        let system = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
        Self { command, system, scenes }
    }
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_can_be_given_to_a_shell_again() {
        let words = ["biprism", "compare", "my scene.toml", "it's", "--out=x", ""].map(str::to_owned);
        let origin = PageOrigin::new(&words, Vec::new());
        assert_eq!(origin.command, "biprism compare 'my scene.toml' 'it'\\''s' --out=x ''");
    }
}
