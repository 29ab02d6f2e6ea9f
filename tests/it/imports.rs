//! Which files of a crate use which others, read off their text, and the circles among these.
//!
//! A file uses another where it names an item that the other defines, however the name came about: imports and
//! re-exports are followed. Declaring a module, re-exporting and importing a module alone are no uses.

use std::collections::{BTreeMap, BTreeSet};

type Path = Vec<String>;

/// A module: a file, or a module written within one.
#[derive(Default)]
struct Module {
    file: String,
    /// What its imports call by which name, those that the code uses first.
    imports: BTreeMap<String, Path>,
    /// Imports of everything.
    globs: Vec<(Path, bool)>,
    /// Names of imports that are no re-exports.
    private: BTreeSet<String>,
    /// The paths in its code, of one word or more.
    paths: BTreeSet<Path>,
    /// What it defines.
    items: BTreeSet<String>,
}

/// The modules of a crate by their paths.
pub struct Crate(BTreeMap<Path, Module>);

enum Target {
    Module(Path),
    Item(String),
}

impl Crate {
    /// Reads a crate from its files: each by its path below the directory of the root file, and its text.
    pub fn new<'a>(files: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        let mut modules = BTreeMap::new();
        for (file, text) in files {
            let mut path: Path =
                file.trim_end_matches(".rs").split('/').map(String::from).collect();
            if path.last().is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str())) {
                path.pop();
            }
            read(file, path, &tokens(text), &mut modules);
        }
        Self(modules)
    }

    fn resolve(&self, from: &Path, path: &[String], depth: usize) -> Option<Target> {
        let (mut at, mut rest) = (from.clone(), path);
        while let Some((word, more)) = rest.split_first() {
            let (first, last) = (rest.len() == path.len(), more.is_empty());
            let child = [at.clone(), vec![word.clone()]].concat();
            match word.as_str() {
                "crate" => at.clear(),
                "self" => {}
                "super" => drop(at.pop()),
                _ if self.0.contains_key(&child) => at = child,
                _ => {
                    let module = self.0.get(&at)?;
                    if module.items.contains(word) {
                        return Some(Target::Item(module.file.clone()));
                    }
                    if depth > 20 {
                        return None;
                    }
                    let Some(import) = module.imports.get(word) else {
                        let globs = module.globs.iter().filter_map(|(glob, _)| {
                            match self.resolve(&at, glob, depth + 1)? {
                                Target::Module(path) => {
                                    let known = self.0.get(&path)?;
                                    let names = known.items.contains(word)
                                        || known.imports.contains_key(word);
                                    names.then(|| self.resolve(&path, rest, depth + 1))?
                                }
                                Target::Item(file) => Some(Target::Item(file)),
                            }
                        });
                        let found = globs.into_iter().next();
                        let own = || (!first).then(|| Target::Item(module.file.clone()));
                        return found.or_else(own);
                    };
                    match self.resolve(&at, import, depth + 1)? {
                        Target::Module(path) if !last => at = path,
                        target => return Some(target),
                    }
                }
            }
            rest = more;
        }
        Some(Target::Module(at))
    }

    /// The files that each file uses.
    pub fn uses(&self) -> BTreeMap<String, BTreeSet<String>> {
        let mut uses: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (at, module) in &self.0 {
            let private = module.private.iter().map(|name| vec![name.clone()]);
            let named = private.chain(module.paths.iter().cloned());
            let items = named.filter_map(|path| match self.resolve(at, &path, 0)? {
                Target::Item(file) => Some(file),
                Target::Module(_) => None,
            });
            let globs = module.globs.iter().filter(|(_, public)| !public).filter_map(
                |(glob, _)| match self.resolve(at, glob, 0)? {
                    Target::Module(path) => Some(self.0.get(&path)?.file.clone()),
                    Target::Item(file) => Some(file),
                },
            );
            let others = items.chain(globs).filter(|other| *other != module.file);
            uses.entry(module.file.clone()).or_default().extend(others);
        }
        uses
    }
}

/// One circle of each set of files that use each other, a shortest one, by the first of its files.
pub fn circles(uses: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<String>> {
    let way = |from: &str| -> Option<Vec<String>> {
        let mut ways = vec![vec![from.to_owned()]];
        let mut seen = BTreeSet::new();
        for next in 0.. {
            let way = ways.get(next)?.clone();
            for other in uses.get(way.last()?).into_iter().flatten() {
                if other == from {
                    return Some(way);
                }
                if seen.insert(other.clone()) {
                    ways.push([way.clone(), vec![other.clone()]].concat());
                }
            }
        }
        None
    };
    let mut found: Vec<Vec<String>> = Vec::new();
    for file in uses.keys() {
        if let Some(circle) = way(file)
            && !found.iter().any(|one| one.iter().any(|known| circle.contains(known)))
        {
            found.push(circle);
        }
    }
    found
}

/// Reads a module's tokens, and those of the modules within it.
fn read(file: &str, path: Path, tokens: &[String], into: &mut BTreeMap<Path, Module>) {
    let mut module = Module { file: file.to_owned(), ..Module::default() };
    let mut at = 0;
    let is = |at: usize, text: &str| tokens.get(at).is_some_and(|token| token == text);
    while at < tokens.len() {
        let token = tokens[at].as_str();
        let name = tokens.get(at + 1).cloned().unwrap_or_default();
        match token {
            "mod" if is(at + 2, "{") => {
                let mut depth = 0;
                let length = tokens[at + 2..].iter().take_while(|token| {
                    depth += i32::from(*token == "{") - i32::from(*token == "}");
                    depth > 0
                });
                let end = at + 2 + length.count();
                if name != "tests" {
                    let inner = [path.clone(), vec![name]].concat();
                    read(file, inner, &tokens[at + 3..end], into);
                }
                at = end;
            }
            "mod" => at += 1,
            "use" => {
                let end = at + tokens[at..].iter().take_while(|token| *token != ";").count();
                let public = at > 0 && (is(at - 1, "pub") || is(at - 1, ")"));
                tree(&tokens[at + 1..end], &Path::new(), &mut |path, alias| match alias {
                    Some(alias) => {
                        if !public {
                            module.private.insert(alias.clone());
                        }
                        module.imports.insert(alias, path);
                    }
                    None => module.globs.push((path, public)),
                });
                at = end;
            }
            _ if is_word(token) => {
                if [
                    "fn",
                    "struct",
                    "enum",
                    "trait",
                    "const",
                    "static",
                    "type",
                    "union",
                    "macro_rules",
                ]
                .contains(&token)
                {
                    let name = if name == "!" { tokens.get(at + 2).cloned() } else { Some(name) };
                    module.items.extend(name);
                } else {
                    let member = at > 0 && is(at - 1, ".");
                    let mut words = vec![token.to_owned()];
                    while is(at + 1, "::") && tokens.get(at + 2).is_some_and(|token| is_word(token))
                    {
                        at += 2;
                        words.push(tokens[at].clone());
                    }
                    if !member {
                        module.paths.insert(words);
                    }
                }
            }
            _ => {}
        }
        at += 1;
    }
    into.insert(path, module);
}

/// Each path of an import with the name that it gets; no name for `*`.
fn tree(tokens: &[String], before: &Path, into: &mut dyn FnMut(Path, Option<String>)) {
    let mut path = before.clone();
    let mut at = 0;
    while at < tokens.len() {
        match tokens[at].as_str() {
            "{" => {
                let (mut depth, mut start) = (0, at + 1);
                for (end, token) in tokens.iter().enumerate().skip(at) {
                    depth += i32::from(token == "{") - i32::from(token == "}");
                    if depth == 0 || (depth == 1 && token == ",") {
                        if start < end {
                            tree(&tokens[start..end], &path, into);
                        }
                        start = end + 1;
                    }
                    if depth == 0 {
                        break;
                    }
                }
                return;
            }
            "*" => return into(path, None),
            "as" => return into(path, tokens.get(at + 1).cloned()),
            "self" if !path.is_empty() => {}
            "::" => {}
            word => path.push(word.to_owned()),
        }
        at += 1;
    }
    let name = path.last().cloned();
    into(path, name);
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The words and signs of a text, without comments, strings and characters.
fn tokens(text: &str) -> Vec<String> {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let mut tokens: Vec<String> = Vec::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |at| at + 2)
        } else if let Some((opening, hashes)) = raw_string(rest) {
            let close = format!("\"{}", "#".repeat(hashes));
            rest[opening..].find(&close).map_or(rest.len(), |at| opening + at + close.len())
        } else if c == '"' {
            let mut escaped = false;
            let ends = |&(_, c): &(usize, char)| {
                let ends = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                ends
            };
            rest.char_indices().skip(1).find(ends).map_or(rest.len(), |(at, _)| at + 1)
        } else if c == '\'' {
            // A character, else a lifetime.
            let mut chars = rest.char_indices().skip(1);
            let (_, first) = chars.next().unwrap_or_default();
            if first == '\\' {
                chars.next();
                chars.find(|(_, c)| *c == '\'').map_or(rest.len(), |(at, _)| at + 1)
            } else {
                chars.next().filter(|(_, c)| *c == '\'').map_or(1, |(at, _)| at + 1)
            }
        } else if part(c) {
            let length = rest.find(|c| !part(c)).unwrap_or(rest.len());
            tokens.push(rest[..length].to_owned());
            length
        } else if rest.starts_with("::") {
            tokens.push("::".to_owned());
            2
        } else {
            if !c.is_whitespace() {
                tokens.push(c.to_string());
            }
            c.len_utf8()
        };
        rest = &rest[length..];
    }
    tokens
}

/// The length of a raw string's opening, and its number signs.
fn raw_string(text: &str) -> Option<(usize, usize)> {
    let rest = text.strip_prefix("br").or_else(|| text.strip_prefix('r'))?;
    let hashes = rest.len() - rest.trim_start_matches('#').len();
    rest[hashes..].starts_with('"').then(|| (text.len() - rest.len() + hashes + 1, hashes))
}

#[test]
fn circles_are_seen_through_imports_and_re_exports() {
    let circles = |files: &[(&str, &str)]| circles(&Crate::new(files.iter().copied()).uses());
    let lib = ("lib.rs", "mod a; mod b; pub use a::A; pub use b::*;");
    let a = ("a.rs", "use crate::B; pub struct A; fn f(_: &'static str) -> B { B('\\'') }");
    assert_eq!(circles(&[lib, a, ("b.rs", "pub struct B(pub char);")]), [[""; 0]; 0]);
    let circle = [["a.rs", "b.rs"].map(str::to_owned).to_vec()];
    for b in [
        "pub struct B(pub char); fn f(_: super::A) {}",
        "use crate::a; pub struct B(pub char); const A: a::A = a::A;",
        "pub use crate::a::{self, A as C}; pub struct B(C);",
        "pub struct B; mod c { use super::super::A; }",
    ] {
        assert_eq!(circles(&[lib, a, ("b.rs", b)]), circle, "{b}");
    }
    for b in [
        "pub struct B; // super::A\n #[cfg(test)] mod tests { use crate::A; }",
        "pub use crate::a::A as C; pub struct B(&'static str = \"super::A\");",
        "use crate::a; pub struct B; /* a::A */",
    ] {
        assert_eq!(circles(&[lib, a, ("b.rs", b)]), [[""; 0]; 0], "{b}");
    }
}
