//! Integer values of constant expressions: constants and enumeration values are looked up by the names visible where
//! the expression stands.

use scanbound_iec::ast::{Expr, Literal};
use scanbound_iec::{Project, Section, TypeRef, Variable, same};
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};

/// The variables that hide global names: one slice for each enclosing unit, the innermost first.
pub type Scope<'s> = [&'s [Variable]];

/// The maximum depth of constants that refer to each other.
const DEPTH: u32 = 100;

/// The maximum number of constants looked up for one expression.
const MAX_LOOKUPS: u32 = 10_000;

/// A declaration that a global name may refer to.
#[derive(Clone, Copy)]
enum Source<'p> {
    /// An enumeration value: the type's name (`None` for an anonymous type), all values of the type, and the index of
    /// this one.
    Listed { of: Option<&'p str>, values: &'p [(String, Option<Expr>)], at: usize },
    /// A global variable: its list's name (empty if it has none), all variables of the list, and the index of this one.
    Global { list: &'p str, all: &'p [Variable], at: usize },
}

/// The global constants and enumerations of a project.
#[derive(Default)]
pub struct Constants<'p> {
    sources: Vec<Source<'p>>,
    /// The indices in `sources` of each name, in capitals.
    named: BTreeMap<String, Vec<usize>>,
    /// The names, in capitals, of global variable lists, of types, and of units and global variables.
    lists: BTreeSet<String>,
    types: BTreeSet<String>,
    others: BTreeSet<String>,
    known: RefCell<BTreeMap<usize, Option<i64>>>,
    lookups: Cell<u32>,
    endless: Cell<bool>,
}

impl<'p> Constants<'p> {
    /// Collects the global constants and enumerations of a project.
    #[must_use]
    pub fn new(project: &'p Project) -> Constants<'p> {
        let mut found = Constants::default();
        for one in &project.types {
            found.types.insert(one.name.to_ascii_uppercase());
            found.add_values(Some(&one.name), &one.of);
        }
        let methods = project.pous.iter().flat_map(|pou| &pou.methods);
        for pou in project.pous.iter().chain(methods) {
            found.others.insert(pou.name.to_ascii_uppercase());
            pou.variables.iter().for_each(|one| found.add_values(None, &one.of));
        }
        for (list, all) in &project.globals {
            for (at, one) in all.iter().enumerate() {
                found.others.insert(one.name.to_ascii_uppercase());
                found.add(&one.name, Source::Global { list, all, at });
                found.add_values(None, &one.of);
            }
        }
        found.lists = project.globals.iter().map(|(list, _)| list.to_ascii_uppercase()).collect();
        found
    }

    fn add(&mut self, name: &str, source: Source<'p>) {
        self.named.entry(name.to_ascii_uppercase()).or_default().push(self.sources.len());
        self.sources.push(source);
    }

    fn add_values(&mut self, of: Option<&'p str>, ty: &'p TypeRef) {
        let TypeRef::Enumeration(values, _) = ty else { return };
        for (at, (name, _)) in values.iter().enumerate() {
            self.add(name, Source::Listed { of, values, at });
        }
    }

    /// The value of an integer constant expression whose names are hidden by `scope`. `None` if it is not constant, if
    /// a name is ambiguous, on overflow, or if constants refer to each other endlessly.
    pub fn number(&self, one: &Expr, scope: &Scope<'_>) -> Option<i64> {
        self.lookups.set(0);
        self.within(one, scope, 0)
    }

    /// The value of a global constant or enumeration value: `Value` or `Type#Value`. `None` as for
    /// [`Constants::number`].
    pub fn named(&self, name: &str) -> Option<i64> {
        self.lookups.set(0);
        self.global_name(name, 0)
    }

    /// Whether evaluating the expression exceeds the limits on depth or number of lookups, as constants do that refer
    /// to themselves.
    pub fn is_endless(&self, one: &Expr, scope: &Scope<'_>) -> bool {
        self.endless.set(false);
        self.number(one, scope);
        self.endless.get()
    }

    fn within(&self, one: &Expr, scope: &Scope<'_>, depth: u32) -> Option<i64> {
        match one {
            Expr::Literal(Literal::Int(value, _)) => i64::try_from(*value).ok(),
            Expr::Negate(inner) => self.within(inner, scope, depth)?.checked_neg(),
            Expr::Binary(operator, left, right) => operator
                .of_constants(self.within(left, scope, depth)?, self.within(right, scope, depth)?),
            Expr::Variable(path) => {
                let Some(name) = path.as_name() else {
                    let (owner, last) = path.split_last()?;
                    return self.owned(owner.as_name()?, last, scope, depth);
                };
                let mut around = scope.iter().enumerate();
                match around.find_map(|(at, all)| Some((at, declared(all, name)?))) {
                    // Names in the initial value are looked up from the scope of its declaration outwards.
                    Some((at, own)) => self.held(own, &scope[at..], depth),
                    None => self.global_name(name, depth),
                }
            }
            _ => None,
        }
    }

    /// The value of `list.constant` or `Type.value`; `None` if a variable in scope has the name in front of the dot.
    fn owned(&self, of: &str, name: &str, scope: &Scope<'_>, depth: u32) -> Option<i64> {
        if scope.iter().any(|all| declared(all, of).is_some()) {
            return None;
        }
        let is_it = |source: Source<'_>| match source {
            Source::Listed { of: own, .. } => own.is_some_and(|own| same(own, of)),
            Source::Global { list, .. } => same(list, of),
        };
        match self.global(name, &is_it, depth) {
            None if !self.is_declared(of) => {
                // The name may be that of a list that the file leaves unnamed.
                let is_unnamed = |source: Source<'_>| match source {
                    Source::Listed { .. } => false,
                    Source::Global { list, .. } => list.is_empty(),
                };
                self.global(name, &is_unnamed, depth)
            }
            found => found,
        }
    }

    /// Whether a global variable list or a type has this name.
    pub fn is_list_or_type(&self, name: &str) -> bool {
        let key = name.to_ascii_uppercase();
        self.lists.contains(&key) || self.types.contains(&key)
    }

    fn is_declared(&self, name: &str) -> bool {
        self.is_list_or_type(name) || self.others.contains(&name.to_ascii_uppercase())
    }

    /// The global variables of this name: for each, its list's name, all variables of the list, and the variable.
    pub fn globals(
        &self,
        name: &str,
    ) -> impl Iterator<Item = (&'p str, &'p [Variable], &'p Variable)> {
        let all = self.named.get(&name.to_ascii_uppercase()).map(Vec::as_slice);
        all.unwrap_or_default().iter().filter_map(|&which| match self.sources[which] {
            Source::Global { list, all, at } => Some((list, all, &all[at])),
            Source::Listed { .. } => None,
        })
    }

    fn global_name(&self, name: &str, depth: u32) -> Option<i64> {
        match name.split_once('#') {
            None => self.global(name, &|_| true, depth),
            Some((of, value)) => {
                let is_it = |source: Source<'_>| match source {
                    Source::Listed { of: own, .. } => own.is_some_and(|own| same(own, of)),
                    Source::Global { .. } => false,
                };
                self.global(value, &is_it, depth)
            }
        }
    }

    /// The value of a global name, among the sources that satisfy `is_it`. `None` if constants of this name have
    /// different values, or if one has no known value.
    fn global(&self, name: &str, is_it: &dyn Fn(Source<'_>) -> bool, depth: u32) -> Option<i64> {
        let all = self.named.get(&name.to_ascii_uppercase())?;
        let mut found = None;
        for &at in all.iter().filter(|&&at| is_it(self.sources[at])) {
            // A variable that is not constant has no fixed value, so it does not make the name ambiguous.
            if let Source::Global { all, at, .. } = self.sources[at]
                && !all[at].constant
            {
                continue;
            }
            let own = self.of_source(at, depth)?;
            if found.is_some_and(|found| found != own) {
                return None;
            }
            found = Some(own);
        }
        found
    }

    fn of_source(&self, which: usize, depth: u32) -> Option<i64> {
        if let Some(known) = self.known.borrow().get(&which) {
            return *known;
        }
        let found = match self.sources[which] {
            Source::Global { list, all, at } => {
                // A constant of a named list refers to constants of the same list first.
                let scope: &Scope<'_> = if list.is_empty() { &[] } else { &[all] };
                self.held(&all[at], scope, depth)
            }
            Source::Listed { values, at, .. } => {
                let told = values[..=at].iter().rposition(|(_, number)| number.is_some());
                let first = match told.and_then(|told| values[told].1.as_ref()) {
                    Some(number) => self.deeper(number, &[], depth),
                    None => Some(0),
                };
                let further = i64::try_from(at - told.unwrap_or(0)).ok();
                first.zip(further).and_then(|(first, further)| first.checked_add(further))
            }
        };
        self.known.borrow_mut().insert(which, found);
        found
    }

    /// The value of a variable declared `CONSTANT`; `None` for other variables.
    fn held(&self, one: &Variable, scope: &Scope<'_>, depth: u32) -> Option<i64> {
        let initial = one.initial.as_ref().filter(|_| one.constant)?;
        self.deeper(initial, scope, depth)
    }

    fn deeper(&self, one: &Expr, scope: &Scope<'_>, depth: u32) -> Option<i64> {
        self.lookups.set(self.lookups.get() + 1);
        if depth >= DEPTH || self.lookups.get() > MAX_LOOKUPS {
            self.endless.set(true);
            return None;
        }
        self.within(one, scope, depth + 1)
    }
}

/// The variable of this name declared in `all`. `VAR_EXTERNAL` does not count, because it only refers to a global
/// variable.
fn declared<'s>(all: &'s [Variable], name: &str) -> Option<&'s Variable> {
    all.iter().find(|one| one.section != Section::External && same(&one.name, name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_iec::{parse, read};

    fn number(project: &Project, text: &str, scope: &Scope<'_>) -> Option<i64> {
        let one = parse::expression(text, 1).expect("an expression");
        Constants::new(project).number(&one, scope)
    }

    #[test]
    fn the_nearest_declaration_counts() {
        let text = "TYPE e : (a, b := 5, c); f : (a := 9, d); END_TYPE
            VAR_GLOBAL CONSTANT n : INT := 3; m : INT := n + 1; END_VAR
            FUNCTION_BLOCK h VAR CONSTANT n : INT := 7; k : INT := n + m; END_VAR VAR v : INT; END_VAR
            END_FUNCTION_BLOCK";
        let project = read("a.st", text).expect("a project");
        let own: &Scope<'_> = &[&project.pous[0].variables];
        assert_eq!(number(&project, "n", &[]), Some(3));
        assert_eq!(number(&project, "n", own), Some(7));
        assert_eq!(number(&project, "k - 1", own), Some(10));
        assert_eq!(number(&project, "v", own), None);
        assert_eq!(number(&project, "c", own), Some(6));
        assert_eq!(number(&project, "a", own), None, "two enumerations differ");
        assert_eq!(number(&project, "f#a", own), Some(9));
        assert_eq!(number(&project, "e.a", own), Some(0));
        assert_eq!(number(&project, "k.n", own), None, "a part of a variable");
        assert_eq!(number(&project, "list.n", own), Some(3), "a list whose name is not told");
    }

    #[test]
    fn a_circle_ends() {
        let text = "VAR_GLOBAL CONSTANT a : INT := b + b; b : INT := a + a; c : INT := 1; END_VAR";
        let project = read("a.st", text).expect("a project");
        assert_eq!(number(&project, "a", &[]), None);
        let one = parse::expression("b", 1).expect("an expression");
        assert!(Constants::new(&project).is_endless(&one, &[]));
        let plain = parse::expression("c", 1).expect("an expression");
        assert!(!Constants::new(&project).is_endless(&plain, &[]));
    }
}
