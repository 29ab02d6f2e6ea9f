//! Ladder and function block diagrams as graphs of their own, which write themselves as PLCopen XML and are run element
//! by element: by the standard alone, and by no line of what they are held against.
//!
//! An element that does something is carried out when its turn comes; what leads to it is looked at then, once. Some
//! controllers look at contacts again for each element behind them, with edges of their own. Generators of text always
//! do, and write coils and outputs before blocks, from what the file has or from rows. Of an element's signs they write
//! the first one alone, and those of variables not at all. A run is asked for one of these manners.

use super::machine::{Expr, Machine, Scope, Ty};
use std::collections::{BTreeMap, BTreeSet};

/// Which element, and which of its outputs.
pub type Pin = (usize, &'static str);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    None,
    Rising,
    Falling,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    Plain,
    Negated,
    Set,
    Reset,
}

/// An input of a block: its name, what leads there, and how it is taken.
#[derive(Debug, Clone)]
pub struct Input {
    pub name: &'static str,
    pub from: Vec<Pin>,
    pub negated: bool,
    pub edge: Edge,
}

#[derive(Debug, Clone)]
pub enum What {
    Rail,
    Contact(&'static str, bool, Edge, Vec<Pin>),
    Coil(&'static str, Mode, Edge, Vec<Pin>),
    In(Expr, bool),
    Out(&'static str, bool, Vec<Pin>),
    /// A function: its name, the type of its result, what enables it.
    Function(&'static str, Ty, Option<Vec<Pin>>, Vec<Input>),
    /// An instance of a standard block.
    Standard(&'static str, &'static str, Option<Vec<Pin>>, Vec<Input>),
    /// An instance of a unit: its inputs, and the two variables that it is handed in and out.
    Block(&'static str, usize, Option<Vec<Pin>>, Vec<Input>, [Pin; 2]),
    Jump(&'static str, Vec<Pin>),
    Label(&'static str),
    Return(Vec<Pin>),
}

/// Which elements come first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// From top to bottom and from left to right.
    Places,
    /// Coils and outputs as the file has them, then blocks.
    File,
    /// Coils and outputs from left to right in rows, then blocks.
    Rows,
}

/// What controllers do with drawings in different ways.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Manner {
    /// Whether contacts are looked at again, with an edge for each element that asks.
    pub again: bool,
    pub turn: Turn,
    /// Whether what leads through a coil is joined by AND, as some generators write it.
    pub joins_all: bool,
}

impl Manner {
    pub fn all() -> impl Iterator<Item = Manner> {
        let of = |again, turn, joins_all| Manner { again, turn, joins_all };
        let drawn = [false, true].map(|again| of(again, Turn::Places, false));
        let generated = [Turn::File, Turn::Rows].into_iter();
        let generated =
            generated.flat_map(move |turn| [false, true].map(|all| of(true, turn, all)));
        drawn.into_iter().chain(generated)
    }
}

/// A drawing: its elements in the order in which they are carried out.
#[derive(Debug, Clone, Default)]
pub struct Drawing {
    pub elements: Vec<What>,
    /// Whether the order is told by numbers, not by places.
    pub numbered: bool,
}

fn point(from: &[Pin]) -> String {
    let one = |(id, output): &Pin| match *output {
        "" => format!("<connection refLocalId=\"{id}\"/>"),
        output => format!("<connection refLocalId=\"{id}\" formalParameter=\"{output}\"/>"),
    };
    format!("<connectionPointIn>{}</connectionPointIn>", from.iter().map(one).collect::<String>())
}

fn edge(edge: Edge) -> &'static str {
    match edge {
        Edge::None => "",
        Edge::Rising => " edge=\"rising\"",
        Edge::Falling => " edge=\"falling\"",
    }
}

fn block(
    head: &str,
    enable: Option<&Vec<Pin>>,
    inputs: &[Input],
    both: &[Pin],
    outputs: &[&str],
) -> (String, String) {
    let mut list = String::new();
    if let Some(enable) = enable {
        list += &format!("<variable formalParameter=\"EN\">{}</variable>", point(enable));
    }
    for one in inputs {
        let negated = if one.negated { " negated=\"true\"" } else { "" };
        let (name, edge, from) = (one.name, edge(one.edge), point(&one.from));
        list += &format!("<variable formalParameter=\"{name}\"{negated}{edge}>{from}</variable>");
    }
    for (name, from) in ["r", "z"].iter().zip(both) {
        list += &format!("<variable formalParameter=\"{name}\">{}</variable>", point(&[*from]));
    }
    let all = enable.map(|_| "ENO").into_iter().chain(outputs.iter().copied());
    let all: String = all
        .map(|name| {
            format!("<variable formalParameter=\"{name}\"><connectionPointOut/></variable>")
        })
        .collect();
    (
        format!("block {head}"),
        format!(
            "<inputVariables>{list}</inputVariables><inOutVariables/>\
             <outputVariables>{all}</outputVariables>"
        ),
    )
}

/// What a standard block puts out.
pub fn outputs(kind: &str) -> &'static [&'static str] {
    match kind {
        "SR" | "RS" => &["Q1"],
        "CTU" | "CTD" => &["Q", "CV"],
        _ => &["Q"],
    }
}

impl Drawing {
    pub fn add(&mut self, what: What) -> usize {
        self.elements.push(what);
        self.elements.len() - 1
    }

    /// How far to the right and how far down an element stands: where numbers say the order, places say another one.
    fn place(&self, id: usize) -> (usize, usize) {
        let place = if self.numbered { 1000 - id } else { id };
        (place % 7, place / 7)
    }

    /// Whether it jumps or returns: generators know neither.
    fn has_jumps(&self) -> bool {
        let jumps = |one: &What| matches!(one, What::Jump(..) | What::Label(_) | What::Return(_));
        self.elements.iter().any(jumps)
    }

    /// Whether the instances that show one contact's edge may have seen different values in the scan before: a jump may
    /// leave one of them out, and what the contact reads may be written between them.
    pub fn remembers_apart(&self) -> bool {
        let mut elements = self.elements.iter().enumerate();
        self.has_jumps()
            || elements.any(|(id, what)| match what {
                What::Contact(_, _, edge, _) => *edge != Edge::None && self.askers(id) > 1,
                _ => false,
            })
    }

    /// How many coils, outputs and pins ask for what an element lets through.
    fn askers(&self, id: usize) -> usize {
        let leads = |from: &[Pin]| from.iter().filter(|pin| pin.0 == id).count();
        let of = |(user, what): (usize, &What)| match what {
            What::Contact(_, _, _, from) if leads(from) > 0 => leads(from) * self.askers(user),
            What::Coil(_, _, _, from) if leads(from) > 0 => leads(from) * (1 + self.askers(user)),
            What::Out(_, _, from) | What::Jump(_, from) | What::Return(from) => leads(from),
            What::Function(_, _, enable, inputs)
            | What::Standard(_, _, enable, inputs)
            | What::Block(_, _, enable, inputs, _) => {
                let pins = inputs.iter().map(|one| leads(&one.from)).sum::<usize>();
                pins + enable.as_ref().map_or(0, |from| leads(from))
            }
            _ => 0,
        };
        self.elements.iter().enumerate().map(of).sum()
    }

    /// Whether it is text that a generator has written.
    fn is_generated(&self, manner: Manner) -> bool {
        manner.turn != Turn::Places && !self.has_jumps()
    }

    /// The edge that is looked at, of an element or a pin that has another sign or not.
    fn edge_beside(&self, manner: Manner, edge: Edge, has_sign: bool) -> Edge {
        if has_sign && self.is_generated(manner) { Edge::None } else { edge }
    }

    /// The elements as they come.
    fn order(&self, turn: Turn) -> Vec<usize> {
        let mut all: Vec<usize> = (0..self.elements.len()).collect();
        if turn == Turn::Places || self.has_jumps() {
            return all;
        }
        if self.numbered {
            // The numbers of coils are not looked at.
            let is_coil = |id: usize| matches!(self.elements[id], What::Coil(..));
            let place = |id: usize| match turn {
                Turn::Rows => (self.place(id).1 / 10, self.place(id).0),
                _ => (0, 0),
            };
            all.sort_by_key(|&id| match is_coil(id) {
                true => (true, place(id), id),
                false => (false, (0, 0), id),
            });
            return all;
        }
        let is_block = |id: usize| {
            matches!(self.elements[id], What::Function(..) | What::Standard(..) | What::Block(..))
        };
        // Ten units make a row.
        let row = |id: usize| match turn {
            Turn::Rows => (self.place(id).1 / 10, self.place(id).0),
            _ => (0, 0),
        };
        all.sort_by_key(|&id| (is_block(id), row(id), id));
        all
    }

    /// The elements as XML.
    pub fn xml(&self) -> String {
        let mut text = String::new();
        for (id, what) in self.elements.iter().enumerate() {
            let (x, y) = self.place(id);
            let order = if self.numbered { id + 1 } else { 0 };
            let (head, inner) = match what {
                What::Rail => ("leftPowerRail".to_owned(), "<connectionPointOut/>".to_owned()),
                What::Contact(variable, negated, kind, from) => (
                    format!("contact negated=\"{negated}\"{}", edge(*kind)),
                    format!("{}<connectionPointOut/><variable>{variable}</variable>", point(from)),
                ),
                What::Coil(variable, mode, kind, from) => {
                    let mode = match mode {
                        Mode::Plain => "",
                        Mode::Negated => " negated=\"true\"",
                        Mode::Set => " storage=\"set\"",
                        Mode::Reset => " storage=\"reset\"",
                    };
                    (
                        format!("coil{mode}{}", edge(*kind)),
                        format!(
                            "{}<connectionPointOut/><variable>{variable}</variable>",
                            point(from)
                        ),
                    )
                }
                What::In(value, negated) => (
                    format!("inVariable negated=\"{negated}\""),
                    format!("<connectionPointOut/><expression>{}</expression>", value.text()),
                ),
                What::Out(variable, negated, from) => (
                    format!("outVariable negated=\"{negated}\""),
                    format!("{}<expression>{variable}</expression>", point(from)),
                ),
                What::Function(name, _, enable, inputs) => {
                    let head = format!("typeName=\"{name}\"");
                    block(&head, enable.as_ref(), inputs, &[], &["OUT"])
                }
                What::Standard(name, kind, enable, inputs) => {
                    let head = format!("typeName=\"{kind}\" instanceName=\"{name}\"");
                    block(&head, enable.as_ref(), inputs, &[], outputs(kind))
                }
                What::Block(name, unit, enable, inputs, both) => {
                    let head = format!("typeName=\"Block{unit}\" instanceName=\"{name}\"");
                    block(&head, enable.as_ref(), inputs, both, &["o"])
                }
                What::Jump(label, from) => (format!("jump label=\"{label}\""), point(from)),
                What::Label(label) => (format!("label label=\"{label}\""), String::new()),
                What::Return(from) => ("return".to_owned(), point(from)),
            };
            let name = head.split(' ').next().unwrap_or_default();
            text += &format!(
                "<{head} localId=\"{id}\" executionOrderId=\"{order}\"><position x=\"{x}\" y=\"{y}\"/>{inner}</{name}>"
            );
        }
        text
    }
}

/// One scan of a drawing. It takes 1 for each value that is stored or handed to a block, but 3 for a coil that sets and
/// 2 for one that resets, where they do.
pub struct Run<'d, 'm, 'u> {
    drawing: &'d Drawing,
    machine: &'m mut Machine<'u>,
    /// What stands before the names of memory that belongs to the drawing.
    name: &'d str,
    manner: Manner,
    /// The coil, output or pin that asks for a value.
    asks: String,
    /// What edges showed it.
    seen: BTreeMap<(usize, String), i64>,
    links: BTreeMap<Pin, i64>,
    done: BTreeSet<usize>,
    scope: Scope,
    cost: u64,
}

impl<'d, 'm, 'u> Run<'d, 'm, 'u> {
    pub fn scan(
        drawing: &'d Drawing,
        machine: &'m mut Machine<'u>,
        name: &'d str,
        manner: Manner,
    ) -> u64 {
        let mut run = Run {
            drawing,
            machine,
            name,
            manner,
            asks: String::new(),
            seen: BTreeMap::new(),
            links: BTreeMap::new(),
            done: BTreeSet::new(),
            scope: Scope::default(),
            cost: 0,
        };
        let order = drawing.order(manner.turn);
        let mut at = 0;
        while at < order.len() {
            let asks = order[at].to_string();
            match &drawing.elements[order[at]] {
                // With jumps, elements come in their places.
                What::Jump(label, from) if run.asked(asks.clone(), from) == 1 => {
                    let target = |one: &What| matches!(one, What::Label(own) if own == label);
                    at = drawing.elements.iter().position(target).expect("the label");
                }
                What::Return(from) if run.asked(asks, from) == 1 => return run.cost,
                _ => run.act(order[at]),
            }
            at += 1;
        }
        run.cost
    }

    /// The value that a coil, an output or a pin asks for.
    fn asked(&mut self, asks: String, from: &[Pin]) -> i64 {
        let before = std::mem::replace(&mut self.asks, asks);
        self.cost += self.edges_behind(from);
        let found = match from {
            [pin] => self.link(*pin),
            all => self.any(all),
        };
        self.asks = before;
        found
    }

    /// How many edges are looked at anew, one for each way that leads to them, as generators write them out: each of
    /// these takes 1, for all that is known of the controller.
    fn edges_behind(&self, from: &[Pin]) -> u64 {
        let of = |&(id, _): &Pin| match &self.drawing.elements[id] {
            What::Contact(_, negated, kind, from) => {
                let kind = self.drawing.edge_beside(self.manner, *kind, *negated);
                u64::from(kind != Edge::None) + self.edges_behind(from)
            }
            What::Coil(_, _, _, from) => self.edges_behind(from),
            _ => 0,
        };
        from.iter().map(of).sum()
    }

    /// What several ways bring.
    fn any(&mut self, from: &[Pin]) -> i64 {
        from.iter().map(|pin| self.link(*pin)).fold(0, |sum, one| sum | one)
    }

    fn edge(&mut self, name: &str, kind: Edge, value: i64) -> i64 {
        let key = format!("{}{name}", self.name);
        let trigger = match kind {
            Edge::None => return value,
            Edge::Rising => "R_TRIG",
            Edge::Falling => "F_TRIG",
        };
        // All edges of one contact have seen the same before.
        let first = key.split(" by ").next().unwrap_or_default();
        let seen = self.machine.get(&format!("{first}.m"));
        self.machine.state.entry(format!("{key}.m")).or_insert(seen);
        self.machine.state.insert(format!("{key}.CLK"), value);
        self.machine.standard(trigger, &format!("{key}."));
        self.machine.get(&format!("{key}.Q"))
    }

    fn link(&mut self, pin: Pin) -> i64 {
        let (id, output) = pin;
        if let Some(known) = self.links.get(&pin) {
            return *known;
        }
        let value = match &self.drawing.elements[id] {
            What::Rail => 1,
            What::Contact(variable, negated, kind, from) => {
                let kind = self.drawing.edge_beside(self.manner, *kind, *negated);
                // What a trigger has seen is seen once.
                let asks = if self.manner.again { self.asks.clone() } else { String::new() };
                let own = match self.seen.get(&(id, asks.clone())) {
                    Some(seen) => *seen,
                    None => {
                        let value = self.machine.get(&self.scope.key(variable));
                        let name = match self.manner.again {
                            true => format!("edge {id} by {asks}"),
                            false => format!("edge {id}"),
                        };
                        let value = self.edge(&name, kind, value);
                        if kind != Edge::None {
                            self.seen.insert((id, asks), value);
                        }
                        value
                    }
                };
                self.any(from) & (own ^ i64::from(*negated))
            }
            What::Coil(_, _, _, from) => {
                // A coil is carried out before what stands behind it; by generators in its own place.
                let is_generated = self.drawing.is_generated(self.manner);
                if is_generated && self.manner.joins_all {
                    from.iter().map(|pin| self.link(*pin)).fold(1, |all, one| all & one)
                } else if is_generated {
                    self.any(from)
                } else if self.manner.again {
                    self.act(id);
                    self.any(from)
                } else {
                    let before = self.any(from);
                    self.act(id);
                    before
                }
            }
            What::In(value, negated) => {
                let found = self.machine.value(&self.scope.clone(), value);
                let is_negated = *negated && !self.drawing.is_generated(self.manner);
                if is_negated { 1 - found } else { found }
            }
            What::Function(..) | What::Standard(..) | What::Block(..) => {
                self.act(id);
                return match &self.drawing.elements[id] {
                    _ if output == "ENO" => self.links[&(id, "ENO")],
                    What::Function(..) => self.links.get(&pin).copied().unwrap_or(0),
                    What::Standard(name, ..) | What::Block(name, ..) => {
                        self.machine.get(&format!("{name}.{output}"))
                    }
                    _ => unreachable!("a block"),
                };
            }
            other => unreachable!("{other:?} puts nothing out"),
        };
        // A variable that is wired up is read where it is used.
        let is_read = matches!(self.drawing.elements[id], What::In(..));
        if !self.manner.again && !is_read {
            self.links.insert(pin, value);
        }
        value
    }

    fn given(&mut self, id: usize, inputs: &[Input]) -> Vec<(&'static str, i64)> {
        inputs
            .iter()
            .map(|one| {
                let value = self.asked(format!("{id} {}", one.name), &one.from);
                let kind = self.drawing.edge_beside(self.manner, one.edge, one.negated);
                self.cost += u64::from(kind != Edge::None);
                let value = self.edge(&format!("edge {id} {}", one.name), kind, value);
                (one.name, if one.negated { 1 - value } else { value })
            })
            .collect()
    }

    /// Generators look at the edges of a block's pins whether it is enabled or not.
    fn look_at_edges(&mut self, id: usize, inputs: &[Input]) {
        if self.manner.again {
            self.given(id, inputs);
        }
    }

    /// Whether a block is enabled; it says so.
    fn enabled(&mut self, id: usize, enable: Option<&Vec<Pin>>) -> bool {
        let value = enable.map_or(1, |enable| self.asked(format!("{id} EN"), enable));
        self.links.insert((id, "ENO"), value);
        value == 1
    }

    fn act(&mut self, id: usize) {
        let drawing = self.drawing;
        let acts = !matches!(drawing.elements[id], What::Contact(..) | What::In(..) | What::Rail);
        if !acts || !self.done.insert(id) {
            return;
        }
        match &drawing.elements[id] {
            What::Coil(variable, mode, kind, from) => {
                let value = self.asked(id.to_string(), from);
                let kind = self.drawing.edge_beside(self.manner, *kind, *mode != Mode::Plain);
                let value = self.edge(&format!("edge {id}"), kind, value);
                self.cost += u64::from(kind != Edge::None);
                let key = self.scope.key(variable);
                self.cost += match mode {
                    Mode::Plain | Mode::Negated => 1,
                    Mode::Set => 3 * u64::from(value == 1),
                    Mode::Reset => 2 * u64::from(value == 1),
                };
                match mode {
                    Mode::Plain => self.machine.set(key, value),
                    Mode::Negated => self.machine.set(key, 1 - value),
                    Mode::Set if value == 1 => self.machine.set(key, 1),
                    Mode::Reset if value == 1 => self.machine.set(key, 0),
                    Mode::Set | Mode::Reset => {}
                }
            }
            What::Out(variable, negated, from) => {
                let value = self.asked(id.to_string(), from);
                // Of a block that is not enabled nothing is taken over; generators do not take over its ENO, either.
                let is_generated = drawing.is_generated(self.manner);
                if let [(block, output)] = from[..]
                    && (output == "ENO") <= is_generated
                    && self.links.get(&(block, "ENO")) == Some(&0)
                    && matches!(drawing.elements[block], What::Function(..))
                {
                    return;
                }
                let value = if *negated && !is_generated { 1 - value } else { value };
                let key = self.scope.key(variable);
                self.cost += 1;
                self.machine.set(key, value);
            }
            What::Function(name, ty, enable, inputs) => {
                // Its result is stored, whatever it is.
                self.cost += 1;
                if !self.enabled(id, enable.as_ref()) {
                    self.look_at_edges(id, inputs);
                    return;
                }
                // As the function counts its inputs, whatever order they are drawn in.
                let order = ["G", "MN", "IN0", "IN", "IN1", "IN2", "IN3", "MX"];
                let mut given = self.given(id, inputs);
                given.sort_by_key(|(name, _)| order.iter().position(|own| own == name));
                let given: Vec<i64> = given.into_iter().map(|(_, value)| value).collect();
                self.links.insert((id, "OUT"), ty.wrap(function(name, &given)));
            }
            What::Standard(name, kind, enable, inputs) => {
                if !self.enabled(id, enable.as_ref()) {
                    self.look_at_edges(id, inputs);
                    return;
                }
                for (input, value) in self.given(id, inputs) {
                    self.cost += 1;
                    self.machine.state.insert(format!("{name}.{input}"), value);
                }
                self.machine.standard(kind, &format!("{name}."));
            }
            What::Block(name, unit, enable, inputs, both) => {
                if !self.enabled(id, enable.as_ref()) {
                    self.look_at_edges(id, inputs);
                    return;
                }
                for (input, value) in self.given(id, inputs) {
                    self.cost += 1;
                    self.machine.state.insert(format!("{name}.{input}"), value);
                }
                let handed = both.map(|(from, _)| match &drawing.elements[from] {
                    What::In(value, _) => value.text(),
                    other => unreachable!("{other:?} is no variable"),
                });
                let units = self.machine.blocks;
                let names = ["r".to_owned(), "z".to_owned()];
                let inner = Scope::within(&format!("{name}."), names.into_iter().zip(handed));
                self.machine.run(&inner, &units[*unit].body);
            }
            _ => {}
        }
    }
}

/// What a function makes of whole numbers or truth values.
fn function(name: &str, given: &[i64]) -> i64 {
    let pairs = || given.windows(2).map(|pair| (pair[0], pair[1]));
    match name {
        "AND" => given.iter().fold(1, |all, one| all & one),
        "OR" => given.iter().fold(0, |all, one| all | one),
        "XOR" => given.iter().fold(0, |all, one| all ^ one),
        "NOT" => 1 - given[0],
        "MOVE" => given[0],
        "ADD" => given.iter().sum(),
        "SUB" => given[0] - given[1],
        "MUL" => given[0] * given[1],
        "DIV" => given[0] / given[1],
        "SEL" => given[if given[0] == 0 { 1 } else { 2 }],
        "MAX" => given.iter().copied().max().expect("some"),
        "MIN" => given.iter().copied().min().expect("some"),
        "LIMIT" => given[1].max(given[0]).min(given[2]),
        "GT" => i64::from(pairs().all(|(one, two)| one > two)),
        "GE" => i64::from(pairs().all(|(one, two)| one >= two)),
        "EQ" => i64::from(pairs().all(|(one, two)| one == two)),
        "NE" => i64::from(given[0] != given[1]),
        "LT" => i64::from(pairs().all(|(one, two)| one < two)),
        other => unreachable!("the function {other}"),
    }
}
