//! Writes charts as the element SFC, in forms that other tools understand.
//!
//! Tools that read the standard's drawings expect steps before a simultaneous convergence and transitions before a
//! selection's convergence. Therefore a step followed by both a selection and a convergence is connected to both
//! directly, and if the exits of parallels meet, all but one are drawn as jumps.

use super::kept::{Kept, number};
use super::node::{ACTIVE, ELEMENT, ENTRY, EXIT, child};
use crate::ast::{Kind, visit};
use crate::chart::{Block, COMPUTED, Chart, Step, Target, Transition};
use crate::{Body, show};
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

pub(super) const HTML: &str = "http://www.w3.org/1999/xhtml";

/// The width of a step with its actions, the width of a transition, and the height of both together.
const STEP: usize = 260;
const WAY: usize = 120;
const HEIGHT: usize = 160;

/// Escapes a text for XML.
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

/// Writes the contents of a chart's element. Parts that are unchanged from `kept`, the chart that it replaces, are
/// copied.
///
/// # Errors
/// The reason why a part of it cannot be written.
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

/// The positions of a chart's elements, and which transitions are drawn to their steps.
struct Layout {
    steps: Vec<(usize, usize)>,
    transitions: Vec<(usize, usize)>,
    /// For each step, the transitions connected to it; all others are drawn as jumps.
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

/// The level of each step: the length of the longest forward path from the initial steps.
fn levels(chart: &Chart) -> Vec<usize> {
    let count = chart.steps.len();
    let mut behind: Vec<Vec<usize>> = vec![Vec::new(); count];
    for one in &chart.transitions {
        one.from.iter().for_each(|&from| behind[from].extend(&one.to));
    }
    // The steps in depth-first postorder.
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
    /// The numbers of elements that are copied.
    taken: BTreeSet<u32>,
    /// The number of each step's element.
    steps: Vec<u32>,
    /// The elements of conditions that are copied.
    drawn: BTreeSet<usize>,
    /// The elements whose documentation and data have been written: if one element becomes two, only the first has
    /// them.
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

    /// Writes an input point for each source element.
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

    /// The attributes of the old element, except `besides`.
    fn attributes(&self, node: Option<Node<'a, 'i>>, besides: &[&str]) -> String {
        let node = node.filter(|node| !self.told.contains(&number(*node)));
        let all = node.and_then(|node| Some(self.kept?.attributes(node, besides)));
        all.unwrap_or_default()
    }

    /// Copies child elements of these names from the old element; whether there are any.
    fn parts(&mut self, level: usize, node: Option<Node<'a, 'i>>, names: &[&str]) -> bool {
        let (Some(node), Some(kept)) = (node, self.kept) else { return false };
        let parts = kept.written(node, names);
        parts.iter().for_each(|part| self.line(level, part));
        !parts.is_empty()
    }

    /// Writes a divergence or convergence bar and returns its number.
    fn bar(&mut self, name: &str, at: (usize, usize), from: &[u32], out: usize) -> u32 {
        let id = self.number();
        self.line(1, &format!("<{name} localId=\"{id}\">"));
        self.position(at);
        self.inputs(from);
        // The schema allows named output points only at divergences.
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
        // For each step, the element to which its transitions connect: the step itself or the bar of a selection.
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

    /// Whether the chart has the action that executes the blocks of drawn conditions. It is not written, because the
    /// conditions are drawn.
    fn computes(&self) -> bool {
        self.chart.steps.iter().flat_map(|step| &step.blocks).any(is_computed)
    }

    /// Copies the last child elements of the old element, once.
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
        // A macro step without a chart is written as a step.
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

    /// Writes the step's own actions, as CODESYS and TwinCAT do.
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

/// Whether an action block names the action that executes the blocks of drawn conditions.
fn is_computed(block: &Block) -> bool {
    matches!(&block.target, Target::Path(path) if path.as_name() == Some(COMPUTED))
}

/// Whether the condition is written in the transition's element.
fn is_inline(transition: Node<'_, '_>) -> bool {
    child(transition, "condition").is_some_and(|own| child(own, "inline").is_some())
}

/// A body as structured text; the reason if it cannot be written so.
pub(super) fn in_text(body: &Body) -> Result<String, String> {
    match body {
        Body::Code(_, statements) => {
            let mut keeps = false;
            visit(statements, &mut |one| keeps |= matches!(one.kind, Kind::Keep(..)));
            match keeps {
                true => {
                    Err("it uses a temporary result, which cannot be written as text".to_owned())
                }
                false => Ok(show::statements(statements, 0)),
            }
        }
        Body::Drawn(_, drawings) if drawings.is_empty() => Ok(String::new()),
        Body::Drawn(..) => Err("it is drawn, and cannot be written as text".to_owned()),
        Body::Unread(_, fault) => Err(format!("line {}: {}", fault.line, fault.message)),
        Body::Chart(_) => Err("a chart cannot be written in an action block".to_owned()),
    }
}

/// The place of a transition, for messages.
fn place_of(one: &Transition) -> String {
    match &one.id {
        Some(id) => format!("(line {}, localId {id})", one.line),
        None => format!("(line {})", one.line),
    }
}

/// The priority number of each competing transition, greater than those of all its competitors before it; `None` if it
/// does not compete. Competitors of one transition need not compete with each other.
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
