//! Draws charts as the element SFC, in the forms that other tools follow.
//!
//! Tools that follow the drawings of the standard expect steps in front of a simultaneous convergence and transitions
//! in front of a selection's: a step that a selection and a join come behind leads to both itself, and where ways out
//! of parallels meet, all but one of them jump.

use super::kept::{Kept, number};
use super::node::{ACTIVE, ELEMENT, ENTRY, EXIT, child};
use crate::ast::{Kind, visit};
use crate::chart::{Block, COMPUTED, Chart, Step, Target, Transition};
use crate::{Body, show};
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

pub(super) const HTML: &str = "http://www.w3.org/1999/xhtml";

/// How wide a step is with its actions, a way out of it, and how high both are together.
const STEP: usize = 260;
const WAY: usize = 120;
const HEIGHT: usize = 160;

/// A text as XML has it.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            _ => out.push(c),
        }
    }
    out
}

/// What stands in the element of a chart. What the chart in whose place it is written has in common with it is kept.
///
/// # Errors
/// What of it cannot be written, in words.
pub(super) fn chart(chart: &Chart, kept: Option<&Kept<'_, '_>>) -> Result<String, String> {
    if let Some(own) = chart.macros.first() {
        return Err(format!("the macro step {} was not replaced before", own.name));
    }
    let taken = kept.map(Kept::numbers).unwrap_or_default();
    let mut writer = Writer {
        chart,
        kept,
        text: String::new(),
        next: 1,
        taken,
        steps: Vec::new(),
        drawn: BTreeSet::new(),
        told: BTreeSet::new(),
    };
    writer.chart()?;
    let mut text = String::new();
    for own in kept.map(|kept| kept.beside(&writer.drawn)).unwrap_or_default() {
        let _ = writeln!(text, "  {own}");
    }
    Ok(text + &writer.text)
}

/// Where a chart's elements stand, and how its transitions lead to steps.
struct Layout {
    steps: Vec<(usize, usize)>,
    transitions: Vec<(usize, usize)>,
    /// For each step the transitions that are drawn into it; all others jump.
    into: Vec<Vec<usize>>,
}

impl Layout {
    fn of(chart: &Chart) -> Layout {
        let levels = levels(chart);
        let mut into: Vec<Vec<usize>> = vec![Vec::new(); chart.steps.len()];
        for (at, one) in chart.transitions.iter().enumerate() {
            let last = one.from.iter().map(|&from| levels[from]).max().unwrap_or(0);
            for &step in one.to.iter().filter(|&&step| levels[step] > last) {
                if !chart.steps[step].initial {
                    into[step].push(at);
                }
            }
        }
        for ways in into.iter_mut().filter(|ways| ways.len() > 1) {
            let is_single = |way: &usize| chart.transitions[*way].to.len() == 1;
            if ways.iter().any(is_single) {
                ways.retain(is_single);
            } else {
                ways.truncate(1);
            }
        }
        let mut behind: Vec<Vec<usize>> = vec![Vec::new(); chart.steps.len()];
        chart.transitions.iter().enumerate().for_each(|(at, one)| behind[one.from[0]].push(at));
        let mut ends: BTreeMap<usize, usize> = BTreeMap::new();
        let mut steps = Vec::new();
        let mut transitions = vec![(0, 0); chart.transitions.len()];
        for (step, &level) in levels.iter().enumerate() {
            let end = ends.entry(level).or_insert(40);
            let (x, y) = (*end, 40 + level * HEIGHT);
            let mut wide = 0;
            for &way in &behind[step] {
                let to = &chart.transitions[way].to;
                let jumps = to.iter().filter(|&&step| !into[step].contains(&way)).count();
                transitions[way] = (x + wide, y + 80);
                wide += WAY * jumps.max(1);
            }
            *end += wide.max(STEP);
            steps.push((x, y));
        }
        Layout { steps, transitions, into }
    }
}

/// How far each step is from the start on the longest way on which none comes twice.
fn levels(chart: &Chart) -> Vec<usize> {
    let count = chart.steps.len();
    let mut behind: Vec<Vec<usize>> = vec![Vec::new(); count];
    for one in &chart.transitions {
        one.from.iter().for_each(|&from| behind[from].extend(&one.to));
    }
    // In which order steps are left for good, when each is followed to its end.
    let mut left = Vec::new();
    let mut seen = vec![false; count];
    let all = chart.initial().into_iter().chain(0..count);
    for start in all {
        let mut open = if seen[start] { Vec::new() } else { vec![(start, 0)] };
        seen[start] = true;
        while let Some((step, at)) = open.pop() {
            let Some(&next) = behind[step].get(at) else {
                left.push(step);
                continue;
            };
            open.push((step, at + 1));
            if !std::mem::replace(&mut seen[next], true) {
                open.push((next, 0));
            }
        }
    }
    let mut ranks = vec![0; count];
    left.iter().rev().enumerate().for_each(|(rank, &step)| ranks[step] = rank);
    let mut levels = vec![0; count];
    for &step in left.iter().rev() {
        for &next in behind[step].iter().filter(|&&next| ranks[next] > ranks[step]) {
            levels[next] = levels[next].max(levels[step] + 1);
        }
    }
    levels
}

struct Writer<'c, 'k, 'a, 'i> {
    chart: &'c Chart,
    kept: Option<&'k Kept<'a, 'i>>,
    text: String,
    next: u32,
    /// Numbers of elements that are kept.
    taken: BTreeSet<u32>,
    /// The number of each step.
    steps: Vec<u32>,
    /// The elements that conditions are drawn with.
    drawn: BTreeSet<usize>,
    /// The elements of which documentation and data were written: what becomes two has them once.
    told: BTreeSet<usize>,
}

impl<'a, 'i> Writer<'_, '_, 'a, 'i> {
    fn number(&mut self) -> u32 {
        while self.taken.contains(&self.next) {
            self.next += 1;
        }
        self.next += 1;
        self.next - 1
    }

    fn line(&mut self, level: usize, text: &str) {
        let _ = writeln!(self.text, "{}{text}", "  ".repeat(level));
    }

    fn position(&mut self, (x, y): (usize, usize)) {
        self.line(2, &format!("<position x=\"{x}\" y=\"{y}\"/>"));
    }

    /// Points where an element is led into, each from one of these numbers.
    fn inputs(&mut self, from: &[u32]) {
        for id in from {
            self.line(2, "<connectionPointIn>");
            self.line(3, &format!("<connection refLocalId=\"{id}\"/>"));
            self.line(2, "</connectionPointIn>");
        }
    }

    fn outputs(&mut self, count: usize) {
        (0..count).for_each(|_| self.line(2, "<connectionPointOut formalParameter=\"\"/>"));
    }

    /// The attributes of an element's old form besides these.
    fn attributes(&self, node: Option<Node<'a, 'i>>, besides: &[&str]) -> String {
        let node = node.filter(|node| !self.told.contains(&number(*node)));
        let all = node.and_then(|node| Some(self.kept?.attributes(node, besides)));
        all.unwrap_or_default()
    }

    /// The parts of an element's old form that are kept; whether there are any.
    fn parts(&mut self, level: usize, node: Option<Node<'a, 'i>>, names: &[&str]) -> bool {
        let (Some(node), Some(kept)) = (node, self.kept) else { return false };
        let parts = kept.written(node, names);
        parts.iter().for_each(|part| self.line(level, part));
        !parts.is_empty()
    }

    /// A bar between steps and transitions; its number.
    fn bar(&mut self, name: &str, at: (usize, usize), from: &[u32], out: usize) -> u32 {
        let id = self.number();
        self.line(1, &format!("<{name} localId=\"{id}\">"));
        self.position(at);
        self.inputs(from);
        // The schema has names for the ways out of a bar that diverges alone.
        match name {
            "selectionConvergence" | "simultaneousConvergence" => {
                self.line(2, "<connectionPointOut/>")
            }
            _ => self.outputs(out),
        }
        self.line(1, &format!("</{name}>"));
        id
    }

    fn chart(&mut self) -> Result<(), String> {
        let chart = self.chart;
        let layout = Layout::of(chart);
        self.steps = chart.steps.iter().map(|_| self.number()).collect();
        let mut ways = vec![0; chart.steps.len()];
        let alone = chart.transitions.iter().filter(|one| one.from.len() == 1);
        alone.for_each(|one| ways[one.from[0]] += 1);
        // What leads out of each step to a transition behind it alone: itself, or the bar of a selection.
        let mut out: Vec<u32> = self.steps.clone();
        for (step, &ways) in ways.iter().enumerate().filter(|(_, ways)| **ways > 1) {
            let (x, y) = layout.steps[step];
            out[step] = self.bar("selectionDivergence", (x, y + 40), &[self.steps[step]], ways);
        }
        let ranks = ranks(chart);
        let mut ends: Vec<u32> = Vec::new();
        for (at, one) in chart.transitions.iter().enumerate() {
            let (x, y) = layout.transitions[at];
            let from = match one.from[..] {
                [step] => out[step],
                _ => {
                    let from: Vec<u32> = one.from.iter().map(|&step| self.steps[step]).collect();
                    self.bar("simultaneousConvergence", (x, y - 20), &from, 1)
                }
            };
            let id = self.transition(at, from, ranks[at], (x, y))?;
            let end = match one.to.len() {
                1 => id,
                many => self.bar("simultaneousDivergence", (x, y + 20), &[id], many),
            };
            ends.push(end);
            let jumps = one.to.iter().filter(|&&step| !layout.into[step].contains(&at));
            for (number, &step) in jumps.enumerate() {
                self.jump(&chart.steps[step].name, end, (x + number * WAY, y + 40));
            }
        }
        for (step, into) in layout.into.iter().enumerate() {
            let (x, y) = layout.steps[step];
            let from: Vec<u32> = into.iter().map(|&way| ends[way]).collect();
            let from = match from.len() {
                0 | 1 => from,
                _ => vec![self.bar("selectionConvergence", (x, y - 20), &from, 1)],
            };
            self.step(step, &from, (x, y))?;
        }
        Ok(())
    }

    fn transition(
        &mut self,
        at: usize,
        from: u32,
        rank: Option<usize>,
        place: (usize, usize),
    ) -> Result<u32, String> {
        let one = &self.chart.transitions[at];
        let old = self.kept.and_then(|kept| kept.transition(one));
        let id = self.number();
        let priority = rank.map(|rank| format!(" priority=\"{rank}\"")).unwrap_or_default();
        let more = self.attributes(old, &["localId", "priority"]);
        self.line(1, &format!("<transition localId=\"{id}\"{priority}{more}>"));
        self.position(place);
        self.inputs(&[from]);
        self.line(2, "<connectionPointOut/>");
        match self.kept.and_then(|kept| kept.condition(one)) {
            Some((written, with)) => {
                self.drawn.extend(with.into_iter().map(number));
                self.line(2, written);
            }
            None => {
                let name = || self.chart.transition_name(at);
                if self.computes() && !old.is_some_and(is_inline) {
                    let why = "the blocks that its condition is drawn with would be left out";
                    return Err(format!("transition {} {}: {why}", name(), place_of(one)));
                }
                if let Some(why) = show::formless(&one.condition) {
                    return Err(format!("transition {} {}: {why}", name(), place_of(one)));
                }
                self.line(2, "<condition>");
                let condition = escaped(&show::expr(&one.condition));
                self.line(
                    3,
                    &format!(
                        "<inline name=\"\"><ST><p xmlns=\"{HTML}\">{condition}</p></ST></inline>"
                    ),
                );
                self.line(2, "</condition>");
            }
        }
        self.last(2, old, &["addData", "documentation"]);
        self.line(1, "</transition>");
        Ok(id)
    }

    /// Whether blocks of drawn conditions are executed by an action that is not written: they are drawn.
    fn computes(&self) -> bool {
        self.chart.steps.iter().flat_map(|step| &step.blocks).any(is_computed)
    }

    /// The parts at the end of an element's old form, which are written once.
    fn last(&mut self, level: usize, old: Option<Node<'a, 'i>>, names: &[&str]) {
        let old = old.filter(|node| self.told.insert(number(*node)));
        self.parts(level, old, names);
    }

    fn jump(&mut self, name: &str, from: u32, place: (usize, usize)) {
        let id = self.number();
        self.line(1, &format!("<jumpStep localId=\"{id}\" targetName=\"{}\">", escaped(name)));
        self.position(place);
        self.inputs(&[from]);
        self.line(1, "</jumpStep>");
    }

    fn step(&mut self, at: usize, from: &[u32], place: (usize, usize)) -> Result<(), String> {
        let step = &self.chart.steps[at];
        // A macro step without a chart of its own is written as a step.
        let old = self.kept.and_then(|kept| kept.step(step));
        let (id, name) = (self.steps[at], escaped(&step.name));
        let initial = if step.initial { " initialStep=\"true\"" } else { "" };
        let more = self.attributes(old, &["localId", "name", "initialStep"]);
        self.line(1, &format!("<step localId=\"{id}\" name=\"{name}\"{initial}{more}>"));
        self.position(place);
        self.inputs(from);
        self.outputs(1);
        let blocks: Vec<&Block> = step.blocks.iter().filter(|one| !is_computed(one)).collect();
        if !blocks.is_empty() {
            self.line(2, "<connectionPointOutAction formalParameter=\"\"/>");
        }
        if !self.parts(2, old, &["addData"]) {
            self.own_actions(step);
        }
        self.parts(2, old, &["documentation"]);
        self.line(1, "</step>");
        if blocks.is_empty() {
            return Ok(());
        }
        let block = self.number();
        self.line(1, &format!("<actionBlock localId=\"{block}\">"));
        self.position((place.0 + 100, place.1));
        self.inputs(&[id]);
        for block in blocks {
            self.block(step, block)?;
        }
        self.line(1, "</actionBlock>");
        Ok(())
    }

    /// The actions of a step itself, as CODESYS and TwinCAT write them.
    fn own_actions(&mut self, step: &Step) {
        let all = [(ENTRY, &step.entry), (ACTIVE, &step.active), (EXIT, &step.exit)];
        if all.iter().all(|(_, path)| path.is_none()) {
            return;
        }
        self.line(2, "<addData>");
        self.line(3, &format!("<data name=\"{ELEMENT}\" handleUnknown=\"implementation\">"));
        self.line(4, "<attributes xmlns=\"\">");
        for (guid, path) in all {
            if let Some(path) = path {
                self.line(
                    5,
                    &format!(
                        "<attribute guid=\"{guid}\">{}</attribute>",
                        escaped(&show::path(path))
                    ),
                );
            }
        }
        self.line(4, "</attributes>");
        self.line(3, "</data>");
        self.line(2, "</addData>");
    }

    fn block(&mut self, step: &Step, block: &Block) -> Result<(), String> {
        let old = self.kept.and_then(|kept| kept.action(block));
        let id = self.number();
        let duration =
            block.time.as_ref().map(|time| format!(" duration=\"{}\"", escaped(&show::expr(time))));
        let (qualifier, duration) = (block.qualifier.name(), duration.unwrap_or_default());
        let more = self.attributes(old, &["localId", "qualifier", "duration"]);
        self.line(
            2,
            &format!("<action localId=\"{id}\" qualifier=\"{qualifier}\"{duration}{more}>"),
        );
        self.line(3, "<relPosition x=\"0\" y=\"0\"/>");
        match &block.target {
            Target::Path(path) => {
                self.line(3, &format!("<reference name=\"{}\"/>", escaped(&show::path(path))));
            }
            Target::Inline(..) if self.parts(3, old, &["inline"]) => {}
            Target::Inline(_, body) => {
                let text = in_text(body).map_err(|why| {
                    format!("an action of step {} (line {}): {why}", step.name, block.line)
                })?;
                self.line(
                    3,
                    &format!(
                        "<inline><ST><p xmlns=\"{HTML}\">{}</p></ST></inline>",
                        escaped(&text)
                    ),
                );
            }
        }
        self.last(3, old, &["connectionPointOut", "addData", "documentation"]);
        self.line(2, "</action>");
        Ok(())
    }
}

/// Whether a block is that of the action for drawn conditions.
fn is_computed(block: &Block) -> bool {
    matches!(&block.target, Target::Path(path) if path.as_name() == Some(COMPUTED))
}

/// Whether a transition's condition is written in it.
fn is_inline(transition: Node<'_, '_>) -> bool {
    child(transition, "condition").is_some_and(|own| child(own, "inline").is_some())
}

/// A body as structured text.
pub(super) fn in_text(body: &Body) -> Result<String, String> {
    match body {
        Body::Code(_, statements) => {
            let mut keeps = false;
            visit(statements, &mut |one| keeps |= matches!(one.kind, Kind::Keep(..)));
            match keeps {
                true => Err("it keeps a result for itself, and has no form in text".to_owned()),
                false => Ok(show::statements(statements, 0)),
            }
        }
        Body::Drawn(_, drawings) if drawings.is_empty() => Ok(String::new()),
        Body::Drawn(..) => Err("it is drawn, and has no form in text".to_owned()),
        Body::Unread(_, fault) => Err(format!("line {}: {}", fault.line, fault.message)),
        Body::Chart(_) => Err("a chart has no form in an action block".to_owned()),
    }
}

/// Where a transition stands.
fn place_of(one: &Transition) -> String {
    match &one.id {
        Some(id) => format!("(line {}, localId {id})", one.line),
        None => format!("(line {})", one.line),
    }
}

/// The number of each transition that competes: above those of all its rivals in front of it, which need not be each
/// other's.
fn ranks(chart: &Chart) -> Vec<Option<usize>> {
    let mut behind: Vec<Vec<usize>> = vec![Vec::new(); chart.steps.len()];
    for (at, one) in chart.transitions.iter().enumerate() {
        one.from.iter().for_each(|&step| behind[step].push(at));
    }
    let mut ranks: Vec<usize> = Vec::new();
    for (at, one) in chart.transitions.iter().enumerate() {
        let rivals = one.from.iter().flat_map(|&step| &behind[step]);
        let first = rivals.filter(|&&other| other < at).map(|&other| ranks[other]).max();
        ranks.push(first.unwrap_or(0) + 1);
    }
    let competes = |one: &Transition| one.from.iter().any(|&step| behind[step].len() > 1);
    let all = chart.transitions.iter().zip(ranks);
    all.map(|(one, rank)| competes(one).then_some(rank)).collect()
}
