//! Checks of a project's declarations before resolution: duplicate names, circular types and constants, and functions
//! that controllers call implicitly.

use super::types::is_elementary_name;
use crate::constants::Constants;
use scanbound_base::code::Code;
use scanbound_iec::ast::Expr;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Pou, PouKind, Project, Section, TypeRef, Variable, same};
use std::collections::{BTreeMap, BTreeSet};

/// The index of a file, and a line in it.
type Site = (usize, u32);

/// All faults of a project's declarations, each with its file's index. If types are circular, or extend each other in
/// too long a chain, only that is reported.
#[must_use]
pub fn faults(project: &Project) -> Vec<(usize, Fault)> {
    let mut found = Check { project, faults: Vec::new() };
    found.circles();
    if !found.faults.is_empty() {
        return found.faults;
    }
    found.global_names();
    found.programs();
    for (at, pou) in project.pous.iter().enumerate() {
        found.unit(pou);
        found.inherited(at);
        found.implicit_check(pou);
    }
    found.types();
    if found.faults.is_empty() {
        found.constants();
    }
    found.faults
}

struct Check<'p> {
    project: &'p Project,
    faults: Vec<(usize, Fault)>,
}

/// The kind of unit in words, for messages.
pub(super) fn kind(pou: &Pou) -> &'static str {
    match pou.kind {
        PouKind::Program => "program",
        PouKind::FunctionBlock => "function block",
        PouKind::Function => "function",
        PouKind::Interface => "interface",
    }
}

/// Whether a name was written by the user. Empty names and names with a dot belong to variables that the reader
/// created.
fn is_written(name: &str) -> bool {
    !name.is_empty() && !name.contains('.')
}

impl<'p> Check<'p> {
    fn push(&mut self, (file, line): Site, code: Code, what: String, help: &str) {
        self.faults.push((file, Fault::new(line, what).code(code).help(help)));
    }

    fn place(&self, (file, line): Site) -> String {
        format!("{}:{line}", self.project.files.get(file).map_or("", String::as_str))
    }

    fn twice(&mut self, what: &str, first: Site, second: Site) {
        let told =
            format!("{what} is declared a second time: the first is in {}", self.place(first));
        let help = "give one of them another name, or leave out the file that does not belong to the project: which one a \
            controller takes is not known";
        self.push(second, Code::DeclaredTwice, told, help);
    }

    /// Reports units, types and global variables of equal names. Identical copies in different files are accepted, but
    /// not of programs.
    fn global_names(&mut self) {
        let project = self.project;
        let mut units: BTreeMap<String, &Pou> = BTreeMap::new();
        for pou in &project.pous {
            let Some(first) = units.get(&pou.name.to_ascii_uppercase()) else {
                units.insert(pou.name.to_ascii_uppercase(), pou);
                continue;
            };
            if !is_copy(first, pou) {
                let what = format!("the {} {}", kind(pou), pou.name);
                self.twice(&what, (first.file, first.line), (pou.file, pou.line));
            }
        }
        let mut types = BTreeMap::new();
        for one in &project.types {
            let (key, what) = (one.name.to_ascii_uppercase(), format!("the type {}", one.name));
            if let Some(unit) = units.get(&key) {
                self.twice(&what, (unit.file, unit.line), (one.file, one.line));
            }
            let first = *types.entry(key).or_insert(one);
            let copy = scanbound_iec::TypeDeclaration { file: first.file, ..one.clone() };
            let is_same = std::ptr::eq(first, one) || (first.file != one.file && copy == *first);
            if !is_same {
                self.twice(&what, (first.file, first.line), (one.file, one.line));
            }
        }
        let mut globals: BTreeMap<(String, String), (usize, &Variable)> = BTreeMap::new();
        for (number, (list, all)) in project.globals.iter().enumerate() {
            let file = project.file_of_list(number);
            for one in all.iter().filter(|one| is_written(&one.name)) {
                let key = (list.to_ascii_uppercase(), one.name.to_ascii_uppercase());
                let (first_file, first) = *globals.entry(key).or_insert((file, one));
                if !std::ptr::eq(first, one) && (first_file == file || first != one) {
                    let what = format!("the global variable {}", one.name);
                    self.twice(&what, (first_file, first.line), (file, one.line));
                }
            }
        }
    }

    /// Reports program instances whose names equal those of other instances or of global variables.
    fn programs(&mut self) {
        let project = self.project;
        let all: Vec<&(String, String)> =
            project.tasks.iter().flat_map(|task| &task.instances).collect();
        let site = |of: &str| {
            let pou = project.pou(of);
            pou.map_or((0, 1), |pou| (pou.file, pou.line))
        };
        let mut seen: BTreeMap<String, &str> = BTreeMap::new();
        for (name, of) in &all {
            let first = seen.insert(name.to_ascii_uppercase(), of);
            // A program listed under its own name is one instance, which is called each time (CODESYS, TwinCAT).
            if let Some(first) = first.filter(|first| !same(first, of) || !same(name, of)) {
                let what = format!("the program instance {name}");
                self.twice(&what, site(first), site(of));
            }
        }
        for pou in project.pous.iter().filter(|pou| pou.kind == PouKind::Program) {
            seen.entry(pou.name.to_ascii_uppercase()).or_insert(&pou.name);
        }
        for (number, (list, all)) in project.globals.iter().enumerate() {
            let file = project.file_of_list(number);
            if let (Some(of), Some(first)) = (seen.get(&list.to_ascii_uppercase()), all.first()) {
                self.twice(&format!("the name {list}"), site(of), (file, first.line));
            }
            for one in all.iter().filter(|one| list.is_empty() && is_written(&one.name)) {
                if let Some(of) = seen.get(&one.name.to_ascii_uppercase()) {
                    self.twice(&format!("the name {}", one.name), site(of), (file, one.line));
                }
            }
        }
    }

    /// Reports duplicate names within a unit.
    fn unit(&mut self, pou: &Pou) {
        self.once(pou, members(pou));
        let transitions = pou.transitions.iter();
        let transitions = transitions.map(|one| ("transition", one.name.clone(), one.line));
        self.once(pou, transitions.collect());
        let mut all: Vec<&Variable> = pou.variables.iter().collect();
        for method in &pou.methods {
            self.once(pou, members(method));
            all.extend(&method.variables);
        }
        for one in all {
            self.inner_names(&one.of, (pou.file, one.line));
        }
    }

    fn once(&mut self, pou: &Pou, all: Vec<Member>) {
        let mut seen: BTreeMap<String, (&str, u32)> = BTreeMap::new();
        for (what, name, line) in all {
            let key = name.to_ascii_uppercase();
            let Some(&(first, first_line)) = seen.get(&key) else {
                seen.insert(key, (what, line));
                continue;
            };
            // `VAR_EXTERNAL` may name the same global variable more than once.
            if (first, what) != (EXTERNAL, EXTERNAL) {
                let told = format!("{}: the {what} {name}", pou.name);
                self.twice(&told, (pou.file, first_line), (pou.file, line));
            }
        }
    }

    /// Reports duplicate fields of a structure and duplicate values of an enumeration.
    fn inner_names(&mut self, of: &TypeRef, (file, line): Site) {
        match of {
            TypeRef::Struct(parts) => {
                let mut seen: BTreeMap<String, u32> = BTreeMap::new();
                for one in parts {
                    self.inner_names(&one.of, (file, one.line));
                    if let Some(first) = seen.insert(one.name.to_ascii_uppercase(), one.line) {
                        self.twice(
                            &format!("the part {}", one.name),
                            (file, first),
                            (file, one.line),
                        );
                    }
                }
            }
            TypeRef::Enumeration(values, _) => {
                let mut seen = BTreeSet::new();
                for (name, _) in values {
                    if !seen.insert(name.to_ascii_uppercase()) {
                        self.twice(&format!("the value {name}"), (file, line), (file, line));
                    }
                }
            }
            TypeRef::Array(_, of) | TypeRef::Pointer(of) | TypeRef::Reference(of) => {
                self.inner_names(of, (file, line));
            }
            _ => {}
        }
    }

    fn types(&mut self) {
        let project = self.project;
        for one in &project.types {
            self.inner_names(&one.of, (one.file, one.line));
        }
        for (number, (_, all)) in project.globals.iter().enumerate() {
            let file = project.file_of_list(number);
            all.iter().for_each(|one| self.inner_names(&one.of, (file, one.line)));
        }
    }

    /// Reports names that a base unit also declares. Overrides of the same kind, such as a method by a method, are
    /// accepted.
    fn inherited(&mut self, at: usize) {
        let all = lineage(self.project, at);
        let mut bases: BTreeMap<String, (&str, Site)> = BTreeMap::new();
        for base in &all[1..] {
            for (what, name, line) in members(base) {
                bases.insert(name.to_ascii_uppercase(), (what, (base.file, line)));
            }
        }
        let pou = all[0];
        for (what, name, line) in members(pou) {
            let Some(&(first, site)) = bases.get(&name.to_ascii_uppercase()) else { continue };
            if first != what || what == VARIABLE {
                let told = format!("{}: the {what} {name}, which it inherits,", pou.name);
                self.twice(&told, site, (pou.file, line));
            }
        }
    }

    /// Reports functions that CODESYS and TwinCAT call implicitly, for example at each array access or division.
    fn implicit_check(&mut self, pou: &Pou) {
        let upper = pou.name.to_ascii_uppercase();
        let is_division = upper.strip_prefix("CHECKDIV").is_some_and(is_elementary_name);
        if pou.kind != PouKind::Function || !(is_division || IMPLICIT.contains(&upper.as_str())) {
            return;
        }
        let told = format!(
            "{} is a function for implicit checks: CODESYS and TwinCAT call it wherever it can apply, which is not followed",
            pou.name
        );
        let help = "leave it out if the controller's project does not have it; rename it if only the program's own calls call it";
        self.push((pou.file, pou.line), Code::NotModelled, told, help);
    }

    /// Reports units and structures that extend themselves, and types that contain themselves.
    fn circles(&mut self) {
        let project = self.project;
        let mut nodes: Vec<(&str, Site)> = Vec::new();
        nodes.extend(project.pous.iter().map(|pou| (pou.name.as_str(), (pou.file, pou.line))));
        nodes.extend(project.types.iter().map(|one| (one.name.as_str(), (one.file, one.line))));
        let numbers: BTreeMap<String, usize> = { nodes.iter().enumerate() }
            .rev()
            .map(|(at, (name, _))| (name.to_ascii_uppercase(), at))
            .collect();
        let number = |name: &str| numbers.get(&name.to_ascii_uppercase()).copied();
        let mut bases: Vec<Vec<usize>> = Vec::new();
        let mut parts: Vec<Vec<usize>> = Vec::new();
        for pou in &project.pous {
            let extended = pou.extends.iter().chain(&pou.implements);
            bases.push(extended.filter_map(|name| number(name)).collect());
            let mut held = Vec::new();
            let is_block = pou.kind == PouKind::FunctionBlock;
            let kept = pou.variables.iter().filter(|one| one.section != Section::External);
            kept.filter(|_| is_block).for_each(|one| named_types(&one.of, &mut held));
            parts.push(held.into_iter().filter_map(number).collect());
        }
        for one in &project.types {
            bases.push(one.extends.iter().filter_map(|name| number(name)).collect());
            let mut held = Vec::new();
            named_types(&one.of, &mut held);
            parts.push(held.into_iter().filter_map(number).collect());
        }
        if let Some(deep) = deep(&bases) {
            let (name, site) = nodes[deep];
            let told = format!(
                "{name} extends more than {MAX_BASES} units, each of which extends the next"
            );
            let help = "no controller's project does so: let it extend fewer";
            self.push(site, Code::TooMany, told, help);
        }
        for (edges, does) in [(bases, "extends"), (parts, "holds")] {
            if let Some(circle) = circle(&edges) {
                let names: Vec<&str> =
                    circle.iter().chain(&circle[..1]).map(|&at| nodes[at].0).collect();
                let told =
                    format!("{} {does} itself: {}", names[0], names.join(&format!(" {does} ")));
                let help = "end the circle: no controller compiles it";
                self.push(nodes[circle[0]].1, Code::UnknownType, told, help);
            }
        }
    }

    /// Reports the first constant or enumeration value whose definition is circular or too deep.
    fn constants(&mut self) {
        let project = self.project;
        let constants = Constants::new(project);
        let mut all: Vec<(&str, &Expr, Vec<&[Variable]>, Site)> = Vec::new();
        let own = |all: &'p [Variable]| all.iter().filter(|one| one.constant);
        for (at, pou) in project.pous.iter().enumerate() {
            let units = lineage(project, at);
            let around: Vec<&[Variable]> = units.iter().map(|pou| &pou.variables[..]).collect();
            let inner = pou.methods.iter().map(|method| {
                (method, std::iter::once(&method.variables[..]).chain(around.clone()).collect())
            });
            for (unit, scope) in std::iter::once((pou, around.clone())).chain(inner) {
                let named =
                    own(&unit.variables).filter_map(|one| Some((one, one.initial.as_ref()?))).map(
                        |(one, initial)| (&*one.name, initial, scope.clone(), (pou.file, one.line)),
                    );
                all.extend(named);
            }
        }
        for (number, (list, variables)) in project.globals.iter().enumerate() {
            let file = project.file_of_list(number);
            let scope = if list.is_empty() { Vec::new() } else { vec![&variables[..]] };
            let named = own(variables)
                .filter_map(|one| Some((one, one.initial.as_ref()?)))
                .map(|(one, initial)| (&*one.name, initial, scope.clone(), (file, one.line)));
            all.extend(named);
        }
        for one in &project.types {
            let TypeRef::Enumeration(values, _) = &one.of else { continue };
            let numbers = values.iter().filter_map(|(name, number)| Some((name, number.as_ref()?)));
            all.extend(
                numbers.map(|(name, number)| (&**name, number, Vec::new(), (one.file, one.line))),
            );
        }
        for (name, initial, scope, site) in all {
            if !matches!(initial, Expr::Literal(_)) && constants.is_endless(initial, &scope) {
                let told = format!(
                    "the constant {name} has no value: it depends on itself, or on too many others"
                );
                let help = "give it a number";
                self.push(site, Code::UnknownName, told, help);
                return;
            }
        }
    }
}

/// A kind of declaration, its name and its line.
type Member = (&'static str, String, u32);

/// The maximum length of a chain of units that extend each other.
const MAX_BASES: usize = 100;

const VARIABLE: &str = "variable";
const EXTERNAL: &str = "external variable";

/// Functions for implicit checks of CODESYS and TwinCAT, without those for divisions.
const IMPLICIT: &[&str] = &[
    "CHECKBOUNDS",
    "CHECKRANGESIGNED",
    "CHECKRANGEUNSIGNED",
    "CHECKLRANGESIGNED",
    "CHECKLRANGEUNSIGNED",
    "CHECKPOINTER",
    "CHECKPOINTERALIGNED",
];

/// The names that a unit or method declares.
fn members(pou: &Pou) -> Vec<Member> {
    let variables =
        pou.variables.iter().filter(|one| is_written(&one.name) && !one.is_internal).map(|one| {
            let what = if one.section == Section::External { EXTERNAL } else { VARIABLE };
            (what, one.name.clone(), one.line)
        });
    let mut found: Vec<Member> = variables.collect();
    if pou.result.is_some() {
        found.push(("result", pou.result_name().to_owned(), pou.line));
    }
    let mut properties = BTreeSet::new();
    for method in &pou.methods {
        let Some(property) = method.property() else {
            found.push(("method", method.name.clone(), method.line));
            continue;
        };
        found.push(("accessor", method.name.clone(), method.line));
        if properties.insert(property.to_ascii_uppercase()) {
            found.push(("property", property.to_owned(), method.line));
        }
    }
    found.extend(pou.actions.iter().map(|one| ("action", one.name.clone(), one.line)));
    found
}

/// Whether a unit is an identical copy from another file. Never for programs, because both would run.
fn is_copy(first: &Pou, pou: &Pou) -> bool {
    if first.file == pou.file || pou.kind == PouKind::Program {
        return false;
    }
    let mut copy = pou.clone();
    copy.file = first.file;
    copy.methods.iter_mut().for_each(|method| method.file = first.file);
    copy == *first
}

/// Collects the names of the types that a variable contains; targets of references are not included.
fn named_types<'t>(of: &'t TypeRef, found: &mut Vec<&'t str>) {
    match of {
        TypeRef::Named(name) => found.push(name),
        TypeRef::Array(_, of) | TypeRef::Subrange(of, _) => named_types(of, found),
        TypeRef::Enumeration(_, Some(of)) => named_types(of, found),
        TypeRef::Struct(parts) => parts.iter().for_each(|one| named_types(&one.of, found)),
        TypeRef::Text(_)
        | TypeRef::Enumeration(_, None)
        | TypeRef::Pointer(_)
        | TypeRef::Reference(_) => {}
    }
}

/// A node from which the path along first edges is longer than `MAX_BASES`; `None` if there is none.
fn deep(edges: &[Vec<usize>]) -> Option<usize> {
    (0..edges.len()).find(|&start| {
        let mut node = start;
        (0..=MAX_BASES).all(|_| {
            let next = edges[node].first().copied();
            node = next.unwrap_or(node);
            next.is_some()
        })
    })
}

/// The nodes of a cycle in the graph, if it has one.
fn circle(edges: &[Vec<usize>]) -> Option<Vec<usize>> {
    let mut is_done = vec![false; edges.len()];
    for start in 0..edges.len() {
        // The path from the start: each node with the index of its next edge.
        let mut way: Vec<(usize, usize)> = vec![(start, 0)];
        let mut is_on_way = BTreeSet::from([start]);
        while let Some((node, edge)) = way.last_mut() {
            let Some(&next) = edges[*node].get(*edge).filter(|_| !is_done[*node]) else {
                is_done[*node] = true;
                is_on_way.remove(node);
                way.pop();
                continue;
            };
            *edge += 1;
            if is_on_way.contains(&next) {
                let nodes = way.iter().map(|(node, _)| *node);
                return Some(nodes.skip_while(|node| *node != next).collect());
            }
            if !is_done[next] {
                is_on_way.insert(next);
                way.push((next, 0));
            }
        }
    }
    None
}

/// The unit and its base units, each followed by the unit that it extends.
fn lineage(project: &Project, unit: usize) -> Vec<&Pou> {
    let mut found = vec![&project.pous[unit]];
    while let Some(base) = found.last().and_then(|pou| project.pou(pou.extends.as_ref()?))
        && !found.iter().any(|own| std::ptr::eq(*own, base))
    {
        found.push(base);
    }
    found
}
