//! Which files of a crate use which others, read off their text, and the circles among these.
//!
//! A file uses another where it names an item that the other defines, however the name came about: imports and
//! re-exports are followed. Declaring a module, re-exporting, importing a module alone and calling a method are no
//! uses.

use petgraph::algo::tarjan_scc;
use petgraph::graphmap::DiGraphMap;
use proc_macro2::{Ident, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, UseTree, Visibility};

type Path = Vec<String>;

/// A module: a file, or a module written within one.
#[derive(Default)]
struct Module {
    file: String,
    /// What its imports call by which name, those that the code uses first.
    imports: BTreeMap<String, Path>,
    /// Imports of everything, and whether they are re-exports.
    globs: Vec<(Path, bool)>,
    /// Names of imports that are no re-exports.
    private: BTreeSet<String>,
    /// The paths in its code, of one word or more.
    paths: BTreeSet<Path>,
    /// What it defines.
    items: BTreeSet<String>,
    /// The modules within it.
    inner: Vec<(String, Module)>,
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
        let mut modules = Self(BTreeMap::new());
        for (file, text) in files {
            let mut path: Path =
                file.trim_end_matches(".rs").split('/').map(String::from).collect();
            if path.last().is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str())) {
                path.pop();
            }
            let parsed = syn::parse_file(text).unwrap_or_else(|why| panic!("{file}: {why}"));
            let mut module = Module { file: file.to_owned(), ..Module::default() };
            module.visit_file(&parsed);
            modules.insert(path, module);
        }
        modules
    }

    fn insert(&mut self, path: Path, mut module: Module) {
        for (name, inner) in std::mem::take(&mut module.inner) {
            self.insert([path.clone(), vec![name]].concat(), inner);
        }
        self.0.insert(path, module);
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

    /// The pairs of files of which the first uses the second.
    fn uses(&self) -> BTreeSet<(&str, String)> {
        let mut uses = BTreeSet::new();
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
            uses.extend(others.map(|other| (module.file.as_str(), other)));
        }
        uses
    }

    /// The sets of files that use each other in circles (the strongly connected components of more than one file).
    pub fn circles(&self) -> BTreeSet<Vec<String>> {
        let uses = self.uses();
        let graph: DiGraphMap<&str, ()> =
            uses.iter().map(|(file, other)| (*file, other.as_str())).collect();
        let circles = tarjan_scc(&graph).into_iter().filter(|files| files.len() > 1);
        circles
            .map(|mut files| {
                files.sort_unstable();
                files.into_iter().map(str::to_owned).collect()
            })
            .collect()
    }
}

impl<'ast> Visit<'ast> for Module {
    fn visit_item(&mut self, item: &'ast Item) {
        let (attributes, name) = head(item);
        let is_test = |one: &Attribute| {
            one.path().is_ident("cfg") && one.parse_args::<Ident>().is_ok_and(|word| word == "test")
        };
        if attributes.iter().any(is_test) {
            return;
        }
        match item {
            Item::Mod(module) => {
                let mut inner = Module { file: self.file.clone(), ..Module::default() };
                for item in module.content.iter().flat_map(|(_, items)| items) {
                    inner.visit_item(item);
                }
                if module.content.is_some() {
                    self.inner.push((module.ident.to_string(), inner));
                }
            }
            Item::Use(import) => {
                let is_public = !matches!(import.vis, Visibility::Inherited);
                self.import(&import.tree, Path::new(), is_public);
            }
            _ => {
                self.items.extend(name.map(Ident::to_string));
                visit::visit_item(self, item);
            }
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.paths.insert(path.segments.iter().map(|word| word.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.visit_path(&call.path);
        self.paths_in(call.tokens.clone());
    }
}

impl Module {
    /// Notes what an import calls by which name.
    fn import(&mut self, tree: &UseTree, mut path: Path, is_public: bool) {
        let (last, name) = match tree {
            UseTree::Path(step) => {
                path.push(step.ident.to_string());
                return self.import(&step.tree, path, is_public);
            }
            UseTree::Group(group) => {
                return group
                    .items
                    .iter()
                    .for_each(|tree| self.import(tree, path.clone(), is_public));
            }
            UseTree::Glob(_) => return self.globs.push((path, is_public)),
            UseTree::Name(name) => (&name.ident, &name.ident),
            UseTree::Rename(name) => (&name.ident, &name.rename),
        };
        if last != "self" {
            path.push(last.to_string());
        }
        let name = if name == "self" { path.last().cloned() } else { Some(name.to_string()) };
        let Some(name) = name else { return };
        if !is_public {
            self.private.insert(name.clone());
        }
        self.imports.insert(name, path);
    }

    /// Notes the paths among the tokens of a macro.
    fn paths_in(&mut self, tokens: TokenStream) {
        let (mut path, mut colons) = (Path::new(), 0);
        for token in tokens {
            match token {
                TokenTree::Punct(sign) if sign.as_char() == ':' => colons += 1,
                TokenTree::Ident(word) => {
                    if colons != 2 {
                        self.paths.insert(std::mem::take(&mut path));
                    }
                    path.push(word.to_string());
                    colons = 0;
                }
                other => {
                    self.paths.insert(std::mem::take(&mut path));
                    if let TokenTree::Group(group) = other {
                        self.paths_in(group.stream());
                    }
                }
            }
        }
        self.paths.insert(path);
    }
}

/// The attributes of an item, and the name that it defines.
fn head(item: &Item) -> (&[Attribute], Option<&Ident>) {
    match item {
        Item::Const(item) => (&item.attrs, Some(&item.ident)),
        Item::Enum(item) => (&item.attrs, Some(&item.ident)),
        Item::Fn(item) => (&item.attrs, Some(&item.sig.ident)),
        Item::Impl(item) => (&item.attrs, None),
        Item::Macro(item) => (&item.attrs, item.ident.as_ref()),
        Item::Mod(item) => (&item.attrs, None),
        Item::Static(item) => (&item.attrs, Some(&item.ident)),
        Item::Struct(item) => (&item.attrs, Some(&item.ident)),
        Item::Trait(item) => (&item.attrs, Some(&item.ident)),
        Item::Type(item) => (&item.attrs, Some(&item.ident)),
        Item::Union(item) => (&item.attrs, Some(&item.ident)),
        Item::Use(item) => (&item.attrs, None),
        _ => (&[], None),
    }
}

#[test]
fn circles_are_seen_through_imports_and_re_exports() {
    let circles = |files: &[(&str, &str)]| Crate::new(files.iter().copied()).circles();
    let lib = ("lib.rs", "mod a; mod b; pub use a::A; pub use b::*;");
    let a = ("a.rs", "use crate::B; pub struct A; fn f(_: &'static str) -> B { B('\\'') }");
    assert_eq!(circles(&[lib, a, ("b.rs", "pub struct B(pub char);")]), BTreeSet::new());
    let circle = BTreeSet::from([["a.rs", "b.rs"].map(str::to_owned).to_vec()]);
    for b in [
        "pub struct B(pub char); fn f(_: super::A) {}",
        "use crate::a; pub struct B(pub char); const A: a::A = a::A;",
        "pub use crate::a::{self, A as C}; pub struct B(C);",
        "pub struct B; mod c { use super::super::A; }",
        "pub struct B; fn f() { assert!(matches!(B, super::a::A)) }",
    ] {
        assert_eq!(circles(&[lib, a, ("b.rs", b)]), circle, "{b}");
    }
    for b in [
        "pub struct B; // super::A\n #[cfg(test)] mod tests { use crate::A; }",
        "pub use crate::a::A as C; pub const B: &str = \"super::A\";",
        "use crate::a; pub struct B; /* a::A */",
    ] {
        assert_eq!(circles(&[lib, a, ("b.rs", b)]), BTreeSet::new(), "{b}");
    }
}
