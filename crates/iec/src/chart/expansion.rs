//! Replaces macro steps by their charts.
//!
//! A macro step stands for a chart with one entry step and one exit step (IEC 60848: expansion, input step, output
//! step). A transition into the macro step activates the entry step; a transition after it is enabled by the exit step
//! and clears that. The expanded chart therefore evolves like the drawn one, scan by scan. Since no transition inside
//! the macro step leaves the exit step, none competes with those after the macro step.

use super::draft::{Draft, DraftMacro, DraftTransition};
use super::{Block, Chart, Macro, Step, Target, Transition};
use crate::ast::{Expr, Part, Path, paths_of};
use crate::fault::Fault;
use crate::{Body, same};
use scanbound_base::code::Code;
use std::collections::{BTreeMap, BTreeSet};

/// The maximum nesting depth of macro steps, so that a deep file cannot exhaust the stack.
pub const DEEPEST: usize = 32;

fn fault(line: u32, message: String, help: &str) -> Fault {
    Fault::new(line, message).code(Code::Chart).help(help)
}

/// The name of an element for messages, with its `localId` if it has one.
fn numbered(what: &str, id: Option<&str>) -> String {
    id.map_or_else(|| what.to_owned(), |id| format!("{what} with localId {id}"))
}

/// The fault of a transition that names a step that does not exist.
fn no_step(one: &DraftTransition, name: &str) -> Fault {
    let what = numbered("a transition", one.id.as_deref());
    let message = format!("{what} names the step {name}, which does not exist");
    fault(one.line, message, "name a step of the chart")
}

/// The fault of two steps of one name, with their `localId`s if they have any.
fn twice(name: &str, line: u32, ids: [Option<&str>; 2]) -> Fault {
    let ids: Vec<&str> = ids.into_iter().flatten().collect();
    let told = if ids.is_empty() { String::new() } else { format!(": localId {}", ids.join(", ")) };
    let message = format!("there are two steps {name}{told}");
    fault(line, message, "give one of them another name")
}

impl Draft {
    /// Checks the chart, expands macro steps and resolves step names to indices.
    ///
    /// # Errors
    ///
    /// The first fault: a step that does not exist or exists twice, a transition without steps, no initial step, or a
    /// macro step whose entry or exit is ambiguous.
    pub fn finish(self) -> Result<Chart, Fault> {
        let (line, generated) = (self.line, self.generated.clone());
        let Flat { steps, mut transitions, macros } = flat(self)?;
        if !steps.iter().any(|step| step.initial) {
            let help = "mark the step that is active at first as the initial step";
            let first = steps.iter().find_map(|step| Some((&step.name, step.id.as_ref()?)));
            let first =
                first.map(|(name, id)| format!(": its first step is {name} with localId {id}"));
            let message = format!("the chart has no initial step{}", first.unwrap_or_default());
            return Err(fault(line, message, help));
        }
        // The sort is stable: transitions without a priority keep their order, after those with one.
        transitions.sort_by_key(|transition| transition.priority.unwrap_or(u32::MAX));
        let all = steps.iter().enumerate().map(|(at, step)| (key(&step.name), at));
        let known: BTreeMap<String, usize> = all.collect();
        let place = |name: &String, one: &DraftTransition| {
            let found = known.get(&key(name)).copied();
            found.ok_or_else(|| no_step(one, name))
        };
        let mut placed = Vec::new();
        for one in &transitions {
            let line = one.line;
            let places = |names: &[String]| -> Result<Vec<usize>, Fault> {
                let mut found =
                    names.iter().map(|name| place(name, one)).collect::<Result<Vec<_>, _>>()?;
                found.sort_unstable();
                found.dedup();
                Ok(found)
            };
            let (from, to) = (places(&one.from)?, places(&one.to)?);
            if from.is_empty() || to.is_empty() {
                let side = if from.is_empty() { "before" } else { "after" };
                let what = numbered("a transition", one.id.as_deref());
                let message = format!("there is no step {side} {what}");
                return Err(fault(line, message, "let steps and transitions follow each other"));
            }
            placed.push(Transition {
                name: one.name.clone(),
                from,
                to,
                condition: one.condition.clone(),
                priority: one.priority,
                line,
                id: one.id.clone(),
            });
        }
        let mut have_priorities = vec![None; steps.len()];
        for one in &placed {
            let unlike = |step: &&usize| {
                *have_priorities[**step].get_or_insert(one.has_priority()) != one.has_priority()
            };
            if let Some(&step) = one.from.iter().find(unlike) {
                let step = &steps[step].name;
                let message =
                    format!("only some of the transitions after step {step} have a priority");
                return Err(fault(one.line, message, "give each of them a priority, or none"));
            }
        }
        let (restart_flags, settings) = Default::default();
        Ok(Chart {
            steps,
            transitions: placed,
            macros,
            line,
            span: None,
            generated,
            restart_flags,
            settings,
        })
    }
}

/// A chart without macro steps, in which transitions name steps by their full names.
struct Flat {
    steps: Vec<Step>,
    transitions: Vec<DraftTransition>,
    macros: Vec<Macro>,
}

/// A step or macro step with its full name. `entry` and `exit` are the full names of its entry and exit step; of a
/// step, its own.
struct Node {
    full: String,
    entry: String,
    exit: String,
    is_macro: bool,
}

/// The key of a name in maps: names that differ only in case have the same key.
fn key(name: &str) -> String {
    name.to_ascii_lowercase()
}

/// The steps and macro steps of a chart, with the scope of the chart around it.
struct Scope<'s> {
    around: Option<&'s Scope<'s>>,
    nodes: BTreeMap<String, Node>,
}

impl Scope<'_> {
    fn own(&self, name: &str) -> Option<&Node> {
        self.nodes.get(&key(name))
    }

    /// The step or macro step of this name in the innermost chart that has one.
    fn find(&self, name: &str) -> Option<&Node> {
        self.own(name).or_else(|| self.around.and_then(|around| around.find(name)))
    }

    /// Changes a path to a step's flag or time to use the step's full name.
    fn complete(&self, path: &mut Path) {
        let Some((step, last)) = path.split_last() else { return };
        if !same(last, "X") && !same(last, "T") {
            return;
        }
        let Some(node) = self.find(&path.first) else { return };
        if (node.is_macro || step.rest.is_empty()) && !same(&node.full, &path.first) {
            let rest = std::mem::take(&mut path.rest);
            *path = named(&node.full);
            path.rest.extend(rest);
        }
    }

    fn complete_all(&self, expr: &mut Expr) {
        paths_of(expr, &mut |path| self.complete(path));
    }

    fn complete_block(&self, block: &mut Block, within: &str) {
        block.time.iter_mut().for_each(|time| self.complete_all(time));
        if let Target::Inline(name, body) = &mut block.target {
            *name = join(within, name);
            body.change(&mut |expr| self.complete_all(expr), &mut |_| {});
        }
    }
}

/// The path to a step, from its full name.
pub(super) fn named(full: &str) -> Path {
    let mut names = full.split('.');
    let first = Path::name(names.next().unwrap_or_default());
    Path { rest: names.map(|name| Part::Name(name.to_owned())).collect(), ..first }
}

fn join(within: &str, name: &str) -> String {
    if within.is_empty() { name.to_owned() } else { format!("{within}.{name}") }
}

/// Expands all macro steps.
fn flat(draft: Draft) -> Result<Flat, Fault> {
    let mut flat = Flat { steps: Vec::new(), transitions: Vec::new(), macros: Vec::new() };
    let first = initial_macro(&draft).map(str::to_owned);
    let mut draft = draft;
    for one in &mut draft.macros {
        one.initial |= first.as_ref() == Some(&one.name);
    }
    distinct(&draft, "")?;
    let ends = ends_in(&draft, "")?;
    put(draft, "", None, &ends, &mut flat)?;
    let names = flat.steps.iter().map(|step| (&step.name, step.line, step.id.as_deref()));
    let mut names: Vec<_> =
        names.chain(flat.macros.iter().map(|one| (&one.name, one.line, None))).collect();
    names.sort_by_key(|(name, ..)| name.to_ascii_lowercase());
    match names.windows(2).find(|pair| same(pair[0].0, pair[1].0)) {
        Some(pair) => Err(twice(pair[1].0, pair[1].1, [pair[0].2, pair[1].2])),
        None => Ok(flat),
    }
}

/// The macro step that is initial because nothing in the chart itself is marked as initial, and only in this one a step
/// is. `None` if that is not so.
fn initial_macro(draft: &Draft) -> Option<&str> {
    let is_marked =
        draft.steps.iter().any(|step| step.initial) || draft.macros.iter().any(|one| one.initial);
    let has_mark = |one: &&DraftMacro| has_mark(&one.inside);
    let mut own = draft.macros.iter().filter(has_mark);
    let first = own.next().filter(|_| !is_marked && own.next().is_none());
    first.map(|one| one.name.as_str())
}

fn has_mark(draft: &Draft) -> bool {
    draft.steps.iter().any(|step| step.initial)
        || draft.macros.iter().any(|one| one.initial || has_mark(&one.inside))
}

fn put(
    draft: Draft,
    within: &str,
    around: Option<&Scope<'_>>,
    ends: &[Ends],
    flat: &mut Flat,
) -> Result<(), Fault> {
    let mut scope = Scope { around, nodes: BTreeMap::new() };
    for step in &draft.steps {
        let full = join(within, &step.name);
        let [entry, exit] = [&full, &full].map(String::clone);
        scope.nodes.insert(key(&step.name), Node { full, entry, exit, is_macro: false });
    }
    for (one, own) in draft.macros.iter().zip(ends) {
        let full = join(within, &one.name);
        let [entry, exit] = [&own.entry, &own.exit].map(String::clone);
        scope.nodes.insert(key(&one.name), Node { full, entry, exit, is_macro: true });
    }
    let mut macros = draft.macros.into_iter().zip(ends).peekable();
    let mut steps = draft.steps.into_iter();
    let mut at = 0;
    loop {
        // The chart of a macro step is inserted at the position of the macro step.
        while let Some((one, own)) = macros.next_if(|(one, _)| one.at <= at) {
            replace(one, within, &scope, own, flat)?;
        }
        let Some(mut step) = steps.next() else { break };
        at += 1;
        step.name = join(within, &step.name);
        step.initial &= within.is_empty();
        step.blocks.iter_mut().for_each(|block| scope.complete_block(block, within));
        flat.steps.push(step);
    }
    for mut one in draft.transitions {
        let as_read = one.clone();
        let full = |name: &String, is_entered: bool| {
            // A preceding step must be in the same chart; a jump may also lead out of a macro step.
            let node = if is_entered { scope.find(name) } else { scope.own(name) };
            let node = node.ok_or_else(|| no_step(&as_read, name))?;
            Ok(if is_entered { node.entry.clone() } else { node.exit.clone() })
        };
        one.from = one.from.iter().map(|name| full(name, false)).collect::<Result<_, Fault>>()?;
        one.to = one.to.iter().map(|name| full(name, true)).collect::<Result<_, Fault>>()?;
        scope.complete_all(&mut one.condition);
        flat.transitions.push(one);
    }
    Ok(())
}

/// A fault if two steps or macro steps of a chart have the same name.
fn distinct(draft: &Draft, within: &str) -> Result<(), Fault> {
    let steps = draft.steps.iter().map(|step| (&step.name, step.line, step.id.as_deref()));
    let macros = draft.macros.iter().map(|one| (&one.name, one.line, None));
    let mut known = BTreeMap::new();
    for (name, line, id) in steps.chain(macros) {
        if let Some(other) = known.insert(key(name), id) {
            return Err(twice(&join(within, name), line, [other, id]));
        }
    }
    Ok(())
}

fn replace(
    mut one: DraftMacro,
    within: &str,
    scope: &Scope<'_>,
    ends: &Ends,
    flat: &mut Flat,
) -> Result<(), Fault> {
    let full = join(within, &one.name);
    // A mark in a macro step's chart shows its entry, not that it is initially active.
    let initial = one.initial && within.is_empty();
    let (place, first) = (flat.macros.len(), flat.steps.len());
    flat.macros.push(Macro { name: full.clone(), steps: Vec::new(), line: one.line });
    one.blocks.iter_mut().for_each(|block| scope.complete_block(block, within));
    put(one.inside, &full, Some(scope), &ends.inside, flat)?;
    for step in &mut flat.steps[first..] {
        // The macro step's own blocks apply to each of its steps, since one of these is active while it is.
        step.blocks.splice(0..0, one.blocks.iter().cloned());
        step.initial |= initial && step.name == ends.entry;
    }
    flat.macros[place].steps = (first..flat.steps.len()).collect();
    Ok(())
}

/// The full names of a macro step's entry and exit step, and the same for macro steps nested in it, so that each is
/// computed once.
struct Ends {
    entry: String,
    exit: String,
    inside: Vec<Ends>,
}

fn ends_in(draft: &Draft, within: &str) -> Result<Vec<Ends>, Fault> {
    draft.macros.iter().map(|one| ends(one, &join(within, &one.name))).collect()
}

fn ends(one: &DraftMacro, full: &str) -> Result<Ends, Fault> {
    let inside = &one.inside;
    distinct(inside, full)?;
    let marks = inside.steps.iter().map(|step| (step.name.as_str(), step.initial));
    let macros = inside.macros.iter().map(|one| (one.name.as_str(), one.initial));
    let nodes: Vec<(&str, bool)> = marks.chain(macros).collect();
    if nodes.is_empty() {
        let message = format!("the chart of the macro step {full} has no step");
        return Err(fault(one.line, message, "draw its steps, or draw a step in its place"));
    }
    let led = |side: fn(&DraftTransition) -> &Vec<String>| {
        let named: BTreeSet<String> =
            inside.transitions.iter().flat_map(side).map(|own| key(own)).collect();
        let names = nodes.iter().map(|(name, _)| *name);
        names.filter(|name| !named.contains(&key(name))).collect::<Vec<_>>()
    };
    let listed = |names: &[&str]| names.join(", ");
    let marked = nodes.iter().filter(|(_, mark)| *mark).map(|(name, _)| *name);
    let mut marked: Vec<&str> = marked.collect();
    let begins = led(|way| &way.to);
    if marked.is_empty() && begins.len() != 1 {
        // If exactly one nested macro step contains a mark, it is the entry.
        marked.extend(initial_macro(inside));
    }
    let help = "mark its entry step as its initial step";
    let entry = match (&marked[..], &begins[..]) {
        ([one], begins) if begins.iter().all(|name| name == one) => *one,
        ([], [one]) => *one,
        ([], []) => {
            let message = format!(
                "the macro step {full} has no entry step: a transition leads into each of its steps"
            );
            return Err(fault(one.line, message, help));
        }
        ([], many) => {
            let message = format!(
                "the macro step {full} has several possible entry steps: no transition leads into {}",
                listed(many)
            );
            return Err(fault(one.line, message, help));
        }
        ([mark], begins) => {
            let message = format!(
                "the entry step of the macro step {full} is not clear: its step {mark} is marked as an initial step, and no transition leads into {}",
                listed(begins)
            );
            let help = "mark its entry step, and let transitions lead into all others";
            return Err(fault(one.line, message, help));
        }
        (marks, _) => {
            let message =
                format!("the macro step {full} has several initial steps: {}", listed(marks));
            return Err(fault(one.line, message, help));
        }
    };
    let ends = led(|way| &way.from);
    let help = "let exactly one of its steps, the exit step, have no transition after it";
    let exit = match &ends[..] {
        [one] => *one,
        [] => {
            let message = format!(
                "the macro step {full} has no exit step: a transition follows each of its steps"
            );
            return Err(fault(one.line, message, help));
        }
        many => {
            let message = format!(
                "the macro step {full} has several possible exit steps: no transition follows {}",
                listed(many)
            );
            return Err(fault(one.line, message, help));
        }
    };
    let own = ends_in(inside, full)?;
    let place = |name: &str| inside.macros.iter().position(|one| same(&one.name, name));
    let within = |name: &str, side: fn(&Ends) -> &String| match place(name) {
        Some(at) => side(&own[at]).clone(),
        None => join(full, name),
    };
    let (entry, exit) = (within(entry, |one| &one.entry), within(exit, |one| &one.exit));
    Ok(Ends { entry, exit, inside: own })
}

/// In all bodies of a unit, changes references to a step inside a macro step to its full name, if only one step has
/// that name. Some tools refer to such steps by the short name.
pub fn complete(pou: &mut crate::Pou) {
    let charts = pou.charts();
    if charts.iter().all(|(_, chart)| chart.macros.is_empty()) {
        return;
    }
    let mut inner: Vec<(String, String)> = Vec::new();
    let mut known: Vec<String> = pou.variables.iter().map(|one| one.name.clone()).collect();
    for (_, chart) in charts {
        let names = chart.steps.iter().map(|step| &step.name);
        for full in names.chain(chart.macros.iter().map(|one| &one.name)) {
            match full.rsplit_once('.') {
                Some((_, last)) => inner.push((last.to_owned(), full.clone())),
                None => known.push(full.clone()),
            }
        }
    }
    let unique = |name: &str| {
        let mut own = inner.iter().filter(|(last, _)| same(last, name));
        let first = own.next().filter(|_| own.next().is_none());
        first.filter(|_| !known.iter().any(|own| same(own, name))).map(|(_, full)| full)
    };
    let mut see = |path: &mut Path| {
        let [Part::Name(last)] = &path.rest[..] else { return };
        if (same(last, "X") || same(last, "T"))
            && let Some(full) = unique(&path.first)
        {
            let rest = std::mem::take(&mut path.rest);
            *path = named(full);
            path.rest.extend(rest);
        }
    };
    let mut expr = |one: &mut Expr| paths_of(one, &mut see);
    bodies(pou, &mut |body| body.change(&mut expr, &mut |_| {}));
}

/// Calls `see` for all bodies of a unit: its own and those of actions, transitions and methods.
pub(super) fn bodies(pou: &mut crate::Pou, see: &mut dyn FnMut(&mut Body)) {
    see(&mut pou.body);
    pou.actions.iter_mut().chain(&mut pou.transitions).for_each(|one| see(&mut one.body));
    pou.methods.iter_mut().for_each(|method| bodies(method, see));
}
