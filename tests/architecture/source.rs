//! The sources as the rules see them: bare of comments and literals, the product apart from its tests, paths resolved to
//! the files that they name.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A file of `src`.
#[derive(Debug, Clone)]
pub(super) struct Source {
    /// Its place below `src`, with `/`.
    pub(super) path: String,
    /// The module that it is: `["design", "march"]`; of a file of tests, with `"tests"` at the end.
    pub(super) module: Vec<String>,
    /// What is built into the product, without comments and literals.
    pub(super) product: String,
    /// What is built into tests only, likewise.
    pub(super) tests: String,
}

impl Source {
    /// The room: the first part of the module.
    pub(super) fn room(&self) -> &str {
        self.module.first().map_or("", String::as_str)
    }
}

/// Every file below `folder` that ends in `.rs`.
pub(super) fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The sources of this crate but for `lib.rs` and `main.rs`.
pub(super) fn sources() -> Vec<Source> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let read = |path: PathBuf| {
        let place = path.strip_prefix(&src).expect("inside src").to_string_lossy().replace('\\', "/");
        (place, fs::read_to_string(&path).expect("a source file"))
    };
    let all: Vec<(String, String)> = files(&src).into_iter().map(read).collect();
    let texts: Vec<(&str, &str)> = all.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
    of_texts(&texts)
}

/// Sources of paths and texts.
pub(super) fn of_texts(texts: &[(&str, &str)]) -> Vec<Source> {
    let texts = texts.iter().filter(|(path, _)| !["lib.rs", "main.rs"].contains(path));
    let mut sources: Vec<Source> = texts
        .map(|(path, text)| {
            let (product, tests) = apart(&bare(text));
            let (product, tests) = if is_of_tests(path) { (String::new(), product + &tests) } else { (product, tests) };
            Source { path: (*path).to_owned(), module: module(path), product, tests }
        })
        .collect();
    // What a module declares for tests only is test, whatever its name.
    let helpers: BTreeSet<Vec<String>> = sources.iter().flat_map(declared_for_tests).collect();
    for source in sources.iter_mut().filter(|source| helpers.contains(&source.module)) {
        let product = std::mem::take(&mut source.product);
        source.tests.push_str(&product);
    }
    sources
}

fn is_of_tests(path: &str) -> bool {
    path.ends_with("_tests.rs") || path.ends_with("/tests.rs")
}

fn module(path: &str) -> Vec<String> {
    let mut parts: Vec<String> = path.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    let last = parts.pop().expect("a path has a name");
    match last.strip_suffix("_tests") {
        Some(tested) => parts.extend([tested.to_owned(), "tests".to_owned()]),
        None if last == "mod" => {}
        None => parts.push(last),
    }
    parts
}

/// The modules that `#[cfg(test)] mod name;` declares.
fn declared_for_tests(source: &Source) -> Vec<Vec<String>> {
    let places = source.product.match_indices("#[cfg(test)]");
    places
        .filter_map(|(at, mark)| {
            let (name, rest) = declared(&source.product[at + mark.len()..])?;
            rest.starts_with(';').then(|| [&source.module[..], &[name.to_owned()]].concat())
        })
        .collect()
}

/// The name of the module that a text begins with, and what follows it.
fn declared(text: &str) -> Option<(&str, &str)> {
    let mut rest = text.trim_start();
    while let Some(attribute) = rest.strip_prefix("#[") {
        rest = attribute[attribute.find(']')? + 1..].trim_start();
    }
    if let Some(visible) = rest.strip_prefix("pub") {
        rest = visible.trim_start();
        if rest.starts_with('(') {
            rest = rest[rest.find(')')? + 1..].trim_start();
        }
    }
    let rest = rest.strip_prefix("mod ")?;
    let end = rest.find(|c: char| !is_name(c))?;
    Some((&rest[..end], rest[end..].trim_start()))
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The text without comments, and without what strings and character literals hold.
pub(super) fn bare(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let at = |k: usize| chars.get(k).copied().unwrap_or('\0');
    let (mut out, mut k) = (String::with_capacity(text.len()), 0);
    while k < chars.len() {
        match at(k) {
            '/' if at(k + 1) == '/' => {
                while k < chars.len() && at(k) != '\n' {
                    k += 1;
                }
                continue;
            }
            'r' if (at(k + 1) == '"' || at(k + 1) == '#') && !is_name(at(k.wrapping_sub(1))) => {
                let hashes = (k + 1..).take_while(|&i| at(i) == '#').count();
                if at(k + 1 + hashes) == '"' {
                    k += 2 + hashes;
                    while k < chars.len() && !(at(k) == '"' && (1..=hashes).all(|h| at(k + h) == '#')) {
                        k += 1;
                    }
                    k += 1 + hashes;
                    out.push_str("\"\"");
                    continue;
                }
            }
            '"' => {
                k += 1;
                while k < chars.len() && at(k) != '"' {
                    k += if at(k) == '\\' { 2 } else { 1 };
                }
                k += 1;
                out.push_str("\"\"");
                continue;
            }
            '\'' if at(k + 1) == '\\' || at(k + 2) == '\'' => {
                k += if at(k + 1) == '\\' { 3 } else { 2 };
                while k < chars.len() && at(k) != '\'' {
                    k += 1;
                }
                k += 1;
                out.push_str("' '");
                continue;
            }
            _ => {}
        }
        out.push(at(k));
        k += 1;
    }
    out
}

/// A bare text with its `#[cfg(test)] mod name { ... }` taken out, and those.
fn apart(bare: &str) -> (String, String) {
    let (mut product, mut tests, mut rest) = (String::new(), String::new(), bare);
    while let Some(at) = rest.find("#[cfg(test)]") {
        let (before, from) = rest.split_at(at);
        product.push_str(before);
        let inside = declared(&from["#[cfg(test)]".len()..]).and_then(|(_, rest)| rest.strip_prefix('{'));
        let Some(inside) = inside else {
            let (mark, after) = from.split_at("#[cfg(test)]".len());
            product.push_str(mark);
            rest = after;
            continue;
        };
        let mut depth = 1;
        let end = inside.find(|c| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            depth == 0
        });
        let end = end.unwrap_or(inside.len());
        tests.push_str(&inside[..end]);
        rest = inside.get(end + 1..).unwrap_or_default();
    }
    product.push_str(rest);
    (product, tests)
}

/// The paths of a bare text that begin with `crate`, `super` or `self`, groups spelled out; `*` is not part of one.
pub(super) fn paths(bare: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    for start in ["crate", "super", "self"] {
        for (at, word) in bare.match_indices(start) {
            let before = bare[..at].chars().next_back().unwrap_or(' ');
            let rest = &bare[at + word.len()..];
            // `super::super` is one path; `pub(super)` and `pub(in crate::room)` are none.
            if !is_name(before)
                && before != ':'
                && before != '$'
                && !bare[..at].ends_with("(in ")
                && rest.starts_with("::")
            {
                follow(rest, vec![start.to_owned()], &mut found);
            }
        }
    }
    found
}

/// Adds the paths that go on from `so_far` in a text that begins with `::`, or nothing of a path; returns what is left.
fn follow<'a>(text: &'a str, so_far: Vec<String>, found: &mut Vec<Vec<String>>) -> &'a str {
    let Some(next) = text.strip_prefix("::") else {
        found.push(so_far);
        return text;
    };
    if let Some(group) = next.strip_prefix('{') {
        let mut rest = group.trim_start();
        while !rest.is_empty() && !rest.starts_with('}') {
            let end = rest.find(|c: char| !is_name(c)).unwrap_or(rest.len());
            let mut longer = so_far.clone();
            // The group's own `self` and `*` are what it stands on.
            if end > 0 && &rest[..end] != "self" {
                longer.push(rest[..end].to_owned());
            }
            let after = follow(&rest[end..], longer, found);
            rest = after.trim_start_matches(|c: char| c != ',' && c != '}');
            rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
        }
        return rest.strip_prefix('}').unwrap_or(rest);
    }
    let end = next.find(|c: char| !is_name(c)).unwrap_or(next.len());
    if end == 0 {
        found.push(so_far);
        return next;
    }
    let mut longer = so_far;
    longer.push(next[..end].to_owned());
    follow(&next[end..], longer, found)
}

/// The module of `known` that a path names, or lies in, as seen from module `here`; none for the crate's own root.
pub(super) fn resolved(path: &[String], here: &[String], known: &BTreeSet<Vec<String>>) -> Option<Vec<String>> {
    let mut base = if path[0] == "crate" { Vec::new() } else { here.to_vec() };
    let mut names = path;
    while let Some((first, rest)) =
        names.split_first().filter(|(f, _)| ["crate", "super", "self"].contains(&f.as_str()))
    {
        if first == "super" {
            base.pop();
        }
        names = rest;
    }
    base.extend_from_slice(names);
    while !base.is_empty() && !known.contains(&base) {
        base.pop();
    }
    (!base.is_empty()).then_some(base)
}
