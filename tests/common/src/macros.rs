//! Random charts with nested macro steps, as PLCopen XML, and a machine that runs them without expanding them: each
//! macro step keeps its own chart.

use super::chart_run::control::{Control, Input, Output};
use super::charts::Dice;
use scanbound::iec::chart::Qualifier;
use std::fmt::Write;

pub const MS: i64 = 1_000_000;

/// A block of a step or a macro step: its action's number, its qualifier, its time.
pub type Block = (usize, Qualifier, i64);

/// A step or a macro step.
pub struct Node {
    pub name: String,
    pub blocks: Vec<Block>,
    pub inside: Option<Drawn>,
}

/// What a condition reads.
pub enum Ask {
    Input(usize),
    /// The flag of a node in the chart this many levels further out, or whether it is active for less than 10 ms.
    Flag(usize, usize),
    Young(usize, usize),
    True,
}

pub struct Way {
    pub from: Vec<usize>,
    pub to: Vec<usize>,
    pub asks: Vec<(Ask, bool)>,
}

/// A drawn chart.
#[derive(Default)]
pub struct Drawn {
    pub nodes: Vec<Node>,
    pub ways: Vec<Way>,
    pub entry: usize,
    pub exit: usize,
}

/// What charts may contain.
pub struct Plan {
    pub actions: usize,
    pub qualifiers: Vec<Qualifier>,
    /// Whether each transition reads only its own input.
    pub own_inputs: bool,
    pub inputs: usize,
}

struct Maker<'d> {
    dice: &'d mut Dice,
    plan: &'d mut Plan,
    level: usize,
    /// The number of nodes so far of the charts around this one, the outermost first.
    around: Vec<usize>,
    drawn: Drawn,
}

impl Maker<'_> {
    fn node(&mut self, macros: u64) -> usize {
        let number = self.drawn.nodes.len();
        let is_macro = macros > 0 && self.dice.one_in(3);
        let mut blocks = Vec::new();
        if self.dice.one_in(3) {
            let qualifiers = &self.plan.qualifiers;
            let action = self.dice.below(self.plan.actions as u64) as usize;
            let qualifier = qualifiers[self.dice.below(qualifiers.len() as u64) as usize];
            blocks.push((action, qualifier, 5 * MS + 10 * MS * (action as i64 % 3)));
        }
        // The same names in every chart.
        let mut node = Node { name: format!("s{number}"), blocks, inside: None };
        if is_macro {
            node.name = format!("M{}_{number}", self.level);
            let mut around = self.around.clone();
            around.push(number + 1);
            let depth = self.dice.below(2);
            let inside = draw(self.dice, self.plan, depth, macros - 1, self.level + 1, around);
            node.inside = Some(inside);
        }
        self.drawn.nodes.push(node);
        number
    }

    fn join(&mut self, from: Vec<usize>, to: Vec<usize>) {
        let mut asks = Vec::new();
        if self.plan.own_inputs {
            asks.push((Ask::Input(self.plan.inputs), true));
            self.plan.inputs += 1;
        } else {
            let input = self.dice.below(self.plan.inputs as u64) as usize;
            let out = self.dice.below(self.around.len() as u64 + 1) as usize;
            let nodes = match out {
                0 => self.drawn.nodes.len(),
                out => self.around[self.around.len() - out],
            };
            let node = self.dice.below(nodes as u64) as usize;
            match self.dice.below(6) {
                // The macro step that is being drawn is the last of its chart; its flag may also be read.
                0 => asks.extend([(Ask::Input(input), true), (Ask::Flag(out, node), true)]),
                1 => asks.extend([(Ask::Input(input), true), (Ask::Flag(out, node), false)]),
                2 => asks.extend([(Ask::Input(input), true), (Ask::Young(out, node), true)]),
                3 => asks.push((Ask::True, true)),
                other => asks.push((Ask::Input(input), other == 4)),
            }
        }
        self.drawn.ways.push(Way { from, to, asks });
    }

    /// Draws nodes from one on; returns the first and the last ones.
    fn part(&mut self, depth: u64, macros: u64) -> (usize, usize) {
        let first = self.node(macros);
        let mut last = first;
        for _ in 0..self.dice.below(2) + u64::from(self.level == 0) {
            last = match if depth == 0 { 0 } else { self.dice.below(4) } {
                1 => {
                    let end = self.node(macros);
                    for _ in 0..2 {
                        let (begin, stop) = self.part(depth - 1, macros);
                        self.join(vec![last], vec![begin]);
                        self.join(vec![stop], vec![end]);
                    }
                    end
                }
                2 => {
                    let (one, two) = (self.part(depth - 1, macros), self.part(depth - 1, macros));
                    self.join(vec![last], vec![one.0, two.0]);
                    let end = self.node(macros);
                    self.join(vec![one.1, two.1], vec![end]);
                    end
                }
                3 => {
                    let (begin, stop) = self.part(depth - 1, macros);
                    self.join(vec![last], vec![begin]);
                    self.join(vec![stop], vec![last]);
                    let end = self.node(macros);
                    self.join(vec![stop], vec![end]);
                    end
                }
                _ => {
                    let end = self.node(macros);
                    self.join(vec![last], vec![end]);
                    end
                }
            };
        }
        (first, last)
    }
}

fn draw(
    dice: &mut Dice,
    plan: &mut Plan,
    depth: u64,
    macros: u64,
    level: usize,
    around: Vec<usize>,
) -> Drawn {
    let mut maker = Maker { dice, plan, level, around, drawn: Drawn::default() };
    if level == 0 {
        let start = maker.node(0);
        let (first, last) = maker.part(depth, macros);
        maker.join(vec![start], vec![first]);
        maker.join(vec![last], vec![start]);
    } else {
        (maker.drawn.entry, maker.drawn.exit) = maker.part(depth, macros);
    }
    maker.drawn
}

/// A random chart that returns to its initial step.
pub fn drawn(dice: &mut Dice, plan: &mut Plan, depth: u64, macros: u64) -> Drawn {
    draw(dice, plan, depth, macros, 0, Vec::new())
}

impl Drawn {
    /// Whether it contains a macro step.
    pub fn has_macros(&self) -> bool {
        self.nodes.iter().any(|node| node.inside.is_some())
    }

    fn condition(&self, way: &Way, around: &[&Drawn]) -> String {
        let name = |out: usize, node: usize| match out {
            0 => &self.nodes[node].name,
            out => &around[around.len() - out].nodes[node].name,
        };
        let one = |(ask, is): &(Ask, bool)| {
            let text = match ask {
                Ask::Input(input) => format!("i{input}"),
                Ask::Flag(out, node) => format!("{}.X", name(*out, *node)),
                Ask::Young(out, node) => format!("({}.T &lt; T#10ms)", name(*out, *node)),
                Ask::True => "TRUE".to_owned(),
            };
            if *is { text } else { format!("NOT {text}") }
        };
        way.asks.iter().map(one).collect::<Vec<_>>().join(" AND ")
    }

    /// The element SFC.
    pub fn xml(&self, dice: &mut Dice, around: &[&Drawn]) -> String {
        let point = |from: &[usize]| {
            let one = |id: &usize| format!("<connection refLocalId=\"{id}\"/>");
            let all: String = from.iter().map(one).collect();
            format!("<connectionPointIn>{all}</connectionPointIn>")
        };
        let id_of = |node: usize| 1 + node;
        let mut next = 1000;
        let mut text = "<SFC>".to_owned();
        let mut into: Vec<Vec<usize>> = vec![Vec::new(); self.nodes.len()];
        let mut after = String::new();
        for (at, way) in self.ways.iter().enumerate() {
            let mut from: Vec<usize> = way.from.iter().map(|&node| id_of(node)).collect();
            let id = 100 + 10 * at;
            if from.len() > 1 {
                let bar = point(&from);
                let _ = write!(
                    after,
                    "<simultaneousConvergence localId=\"{}\">{bar}</simultaneousConvergence>",
                    id + 1
                );
                from = vec![id + 1];
            }
            let condition = self.condition(way, around);
            let _ = write!(
                after,
                "<transition localId=\"{id}\">{}<condition><inline name=\"\"><ST><p>{condition}</p></ST></inline></condition></transition>",
                point(&from)
            );
            let mut end = id;
            if way.to.len() > 1 {
                let bar = point(&[id]);
                let _ = write!(
                    after,
                    "<simultaneousDivergence localId=\"{}\">{bar}</simultaneousDivergence>",
                    id + 2
                );
                end = id + 2;
            }
            for &node in &way.to {
                if dice.one_in(3) {
                    next += 1;
                    let name = &self.nodes[node].name;
                    let _ = write!(
                        after,
                        "<jumpStep localId=\"{next}\" targetName=\"{name}\">{}</jumpStep>",
                        point(&[end])
                    );
                } else {
                    into[node].push(end);
                }
            }
        }
        for (at, node) in self.nodes.iter().enumerate() {
            let (id, name) = (id_of(at), &node.name);
            let begins = self.ways.iter().all(|way| !way.to.contains(&at));
            let from = if into[at].is_empty() { String::new() } else { point(&into[at]) };
            let is_entry = at == self.entry;
            let mark = is_entry && (around.is_empty() || !begins || dice.one_in(2));
            let mark = if mark { " initialStep=\"true\"" } else { "" };
            let _ = match &node.inside {
                None => write!(text, "<step localId=\"{id}\" name=\"{name}\"{mark}>{from}</step>"),
                Some(inside) => {
                    let around = [around, &[self]].concat();
                    let inner = inside.xml(dice, &around);
                    write!(
                        text,
                        "<macroStep localId=\"{id}\" name=\"{name}\"{mark}>{from}<body>{inner}</body></macroStep>"
                    )
                }
            };
            for (action, qualifier, time) in &node.blocks {
                next += 1;
                let time = time / MS;
                let _ = write!(
                    after,
                    "<actionBlock localId=\"{next}\">{}<action qualifier=\"{}\" duration=\"T#{time}ms\"><reference name=\"m{action}\"/></action></actionBlock>",
                    point(&[id]),
                    qualifier.name()
                );
            }
        }
        text + &after + "</SFC>"
    }
}

/// The active nodes of a chart, and since when.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Active {
    /// For each step: whether it is active. For each macro step: what is active in it.
    nodes: Vec<Part>,
    since: Vec<i64>,
}

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Step(bool),
    Macro(Active),
}

impl Part {
    fn is_active(&self) -> bool {
        match self {
            Part::Step(active) => *active,
            Part::Macro(inside) => inside.is_active(),
        }
    }
}

impl Active {
    fn none(drawn: &Drawn) -> Active {
        let part = |node: &Node| match &node.inside {
            None => Part::Step(false),
            Some(inside) => Part::Macro(Active::none(inside)),
        };
        Active { nodes: drawn.nodes.iter().map(part).collect(), since: vec![0; drawn.nodes.len()] }
    }

    fn is_active(&self) -> bool {
        self.nodes.iter().any(Part::is_active)
    }

    /// Whether a node has reached its end, so that the transition after it may fire.
    fn is_done(&self, node: usize, drawn: &Drawn) -> bool {
        match (&self.nodes[node], &drawn.nodes[node].inside) {
            (Part::Macro(own), Some(inside)) => own.is_done(inside.exit, inside),
            (part, _) => part.is_active(),
        }
    }

    /// Leaves a node where it ends, or enters it where it begins.
    fn put(&mut self, node: usize, value: bool, drawn: &Drawn) {
        match (&mut self.nodes[node], &drawn.nodes[node].inside) {
            (Part::Macro(own), Some(inside)) => {
                own.put(if value { inside.entry } else { inside.exit }, value, inside);
            }
            (part, _) => *part = Part::Step(value),
        }
    }

    fn note(&mut self, before: &Active, now: i64) {
        for (node, since) in self.since.iter_mut().enumerate() {
            if self.nodes[node].is_active() && !before.nodes[node].is_active() {
                *since = now;
            }
            if let (Part::Macro(own), Part::Macro(was)) =
                (&mut self.nodes[node], &before.nodes[node])
            {
                own.note(was, now);
            }
        }
    }
}

/// A machine that runs a drawn chart.
#[derive(Clone)]
pub struct Machine<'d> {
    drawn: &'d Drawn,
    pub active: Active,
    controls: Vec<Control>,
    started: bool,
    /// In the last scan: enabled transitions of which no rival fired before; those that fired.
    pub enabled: u64,
    pub cleared: u64,
}

/// The transitions that fire in a chart, and in those of its macro steps.
struct Clears {
    own: Vec<usize>,
    inside: Vec<(usize, Clears)>,
}

impl<'d> Machine<'d> {
    pub fn new(drawn: &'d Drawn, actions: usize) -> Machine<'d> {
        let active = Active::none(drawn);
        let controls = vec![Control::default(); actions];
        Machine { drawn, active, controls, started: false, enabled: 0, cleared: 0 }
    }

    /// The state on which the next scans depend if nothing has a time.
    pub fn state(&self) -> (Active, Vec<Control>) {
        let mut active = self.active.clone();
        forget(&mut active);
        (active, self.controls.clone())
    }

    /// Each node's full name, whether it is active and for how long, and whether it is a macro step.
    pub fn flags(&self, now: i64) -> Vec<(String, bool, i64, bool)> {
        let mut found = Vec::new();
        list(self.drawn, &self.active, "", now, &mut found);
        found
    }

    pub fn scan(&mut self, now: i64, inputs: &dyn Fn(usize) -> bool) -> Vec<Output> {
        (self.enabled, self.cleared) = (0, 0);
        let before = self.active.clone();
        if self.started {
            let levels = [(self.drawn, &before)];
            let clears = self.clears(&levels, now, inputs);
            for value in [false, true] {
                move_all(self.drawn, &mut self.active, &clears, value);
            }
        } else {
            self.started = true;
            self.active.put(self.drawn.entry, true, self.drawn);
        }
        self.active.note(&before, now);
        let mut feeds: Vec<Vec<Input>> = vec![Vec::new(); self.controls.len()];
        feed(self.drawn, &self.active, &mut feeds);
        let both = self.controls.iter_mut().zip(feeds);
        both.map(|(control, inputs)| control.scan(&inputs, now, true)).collect()
    }

    fn clears(
        &mut self,
        levels: &[(&Drawn, &Active)],
        now: i64,
        inputs: &dyn Fn(usize) -> bool,
    ) -> Clears {
        let (drawn, active) = levels[levels.len() - 1];
        let mut taken = vec![false; drawn.nodes.len()];
        let mut found = Clears { own: Vec::new(), inside: Vec::new() };
        for (at, way) in drawn.ways.iter().enumerate() {
            if !way.from.iter().all(|&node| active.is_done(node, drawn) && !taken[node]) {
                continue;
            }
            self.enabled += 1;
            let holds = |(ask, is): &(Ask, bool)| {
                // A name means the node of the innermost chart that has it.
                let node = |out: usize, node: usize| {
                    let name = &levels[levels.len() - 1 - out].0.nodes[node].name;
                    let found = levels.iter().rev().find_map(|(drawn, active)| {
                        let own = drawn.nodes.iter().position(|one| one.name == *name)?;
                        let is = active.nodes[own].is_active();
                        Some((is, if is { now - active.since[own] } else { 0 }))
                    });
                    found.expect("a node of this name")
                };
                let value = match ask {
                    Ask::Input(input) => inputs(*input),
                    Ask::Flag(out, at) => node(*out, *at).0,
                    Ask::Young(out, at) => node(*out, *at).1 < 10 * MS,
                    Ask::True => true,
                };
                value == *is
            };
            if way.asks.iter().all(holds) {
                self.cleared += 1;
                way.from.iter().for_each(|&node| taken[node] = true);
                found.own.push(at);
            }
        }
        for (at, node) in drawn.nodes.iter().enumerate() {
            if let (Some(inside), Part::Macro(own)) = (&node.inside, &active.nodes[at]) {
                let inner = [levels, &[(inside, own)]].concat();
                found.inside.push((at, self.clears(&inner, now, inputs)));
            }
        }
        found
    }
}

fn forget(active: &mut Active) {
    active.since.fill(0);
    for part in &mut active.nodes {
        if let Part::Macro(own) = part {
            forget(own);
        }
    }
}

fn move_all(drawn: &Drawn, active: &mut Active, clears: &Clears, value: bool) {
    for &at in &clears.own {
        let way = &drawn.ways[at];
        let side = if value { &way.to } else { &way.from };
        side.iter().for_each(|&node| active.put(node, value, drawn));
    }
    for (node, inner) in &clears.inside {
        if let (Some(inside), Part::Macro(own)) =
            (&drawn.nodes[*node].inside, &mut active.nodes[*node])
        {
            move_all(inside, own, inner, value);
        }
    }
}

fn feed(drawn: &Drawn, active: &Active, feeds: &mut [Vec<Input>]) {
    for (node, part) in drawn.nodes.iter().zip(&active.nodes) {
        for &(action, qualifier, time) in &node.blocks {
            let time = if qualifier.is_timed() { time } else { 0 };
            let own = &mut feeds[action];
            let like = own.iter_mut().find(|one| one.qualifier == qualifier && one.time == time);
            match like {
                Some(one) => one.active |= part.is_active(),
                None => own.push(Input { qualifier, time, active: part.is_active() }),
            }
        }
        if let (Some(inside), Part::Macro(own)) = (&node.inside, part) {
            feed(inside, own, feeds);
        }
    }
}

fn list(
    drawn: &Drawn,
    active: &Active,
    within: &str,
    now: i64,
    found: &mut Vec<(String, bool, i64, bool)>,
) {
    for (at, node) in drawn.nodes.iter().enumerate() {
        let name = format!("{within}{}", node.name);
        let is = active.nodes[at].is_active();
        let time = if is { now - active.since[at] } else { 0 };
        found.push((name.clone(), is, time, node.inside.is_some()));
        if let (Some(inside), Part::Macro(own)) = (&node.inside, &active.nodes[at]) {
            list(inside, own, &format!("{name}."), now, found);
        }
    }
}
