//! Rungs as they are drawn: from the instruction list back to contacts in series and in parallel, and what they drive.

use super::{Instruction, Join, Logic, Program, Step};
use scanbound_base::location::Location;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// One rung.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rung {
    /// Its number, from 1 through all files.
    pub number: u32,
    /// The file, an index.
    pub file: u32,
    /// What stands in it, as the source has it, in its order.
    pub elements: Vec<Element>,
    /// Its paths from the left, each behind those that it starts from.
    pub paths: Vec<Path>,
}

/// An instruction of the source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// Where it stands.
    pub at: Location,
    /// Its text.
    pub text: Arc<str>,
    /// How it is drawn.
    pub symbol: Symbol,
    /// Its parts in the program, indices into `Program::instructions`.
    pub parts: Range<usize>,
}

impl Element {
    /// What stands at its symbol: a contact's or a coil's device, else all of its text.
    #[must_use]
    pub fn label(&self) -> &str {
        match self.symbol {
            Symbol::Condition | Symbol::Box | Symbol::Link => &self.text,
            _ => self.text.split_once(' ').map_or(&self.text, |(_, operand)| operand),
        }
    }
}

/// How an instruction is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Symbol {
    /// A contact that conducts when its device is on.
    Contact,
    /// A contact that conducts when its device is off.
    Negated,
    /// A condition of another kind: an edge, a comparison, a change of the result.
    Condition,
    /// A coil.
    Coil,
    /// A coil that switches its device on to stay.
    Set,
    /// A coil that switches its device off.
    Reset,
    /// An instruction in a box.
    Box,
    /// Nothing: it only says how the others are connected.
    Link,
}

/// A stretch of a rung from a point on: conditions, and what is driven behind them. The end of a path is a point, too.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path {
    /// The path at whose end it starts; else the left rail.
    pub from: Option<usize>,
    /// Its conditions.
    pub conditions: Drawing,
    /// What is driven at its end, indices into [`Rung::elements`].
    pub driven: Vec<usize>,
}

/// How conditions are connected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Drawing {
    /// One of them, an index into [`Rung::elements`].
    One(usize),
    /// From left to right; without any a wire.
    Series(Vec<Drawing>),
    /// One above the other.
    Parallel(Vec<Drawing>),
}

/// All rungs of a program, in the order of the source.
#[must_use]
pub fn rungs(program: &Program) -> Vec<Rung> {
    let mut rungs = Vec::new();
    for file in &program.files {
        let mut at = file.instructions.start;
        while at < file.instructions.end {
            let block = program.instructions[at].block;
            let rest = &program.instructions[at..file.instructions.end];
            let end = at + rest.iter().take_while(|one| one.block == block).count();
            rungs.push(rung(program, at..end));
            at = end;
        }
    }
    rungs
}

fn rung(program: &Program, instructions: Range<usize>) -> Rung {
    let first = &program.instructions[instructions.start];
    let mut drawer = Drawer::default();
    let mut elements: Vec<Element> = Vec::new();
    let mut at = instructions.start;
    while at < instructions.end {
        let one = &program.instructions[at];
        let rest = &program.instructions[at..instructions.end];
        let is_part = |other: &&Instruction| other.place == one.place && other.text == one.text;
        let parts = at..at + rest.iter().take_while(is_part).count();
        let symbol = drawer.take(&program.instructions[parts.clone()], elements.len());
        let (at_place, text) = (one.place, one.text.clone());
        at = parts.end;
        elements.push(Element { at: at_place, text, symbol, parts });
    }
    drawer.finish();
    Rung { number: first.block, file: first.place.file, elements, paths: drawer.paths }
}

/// A result of the list on its way: conditions behind a point.
#[derive(Default)]
struct Result {
    from: Option<usize>,
    conditions: Vec<Drawing>,
}

/// Draws a rung as its instructions come.
#[derive(Default)]
struct Drawer {
    stack: Vec<Result>,
    slots: BTreeMap<u32, Option<usize>>,
    paths: Vec<Path>,
}

impl Drawer {
    /// Draws the parts of an instruction, which is the rung's element of this number.
    fn take(&mut self, parts: &[Instruction], element: usize) -> Symbol {
        let mut symbol = None;
        for part in parts {
            let own = match &part.step {
                Step::Logic { join, value } => {
                    // What an instruction asks in several parts is one condition.
                    if !matches!(
                        symbol,
                        Some(Symbol::Contact | Symbol::Negated | Symbol::Condition)
                    ) {
                        self.condition(*join, element);
                    }
                    Some(contact(value, &part.text))
                }
                Step::AndBlock => {
                    self.and_block();
                    Some(Symbol::Link)
                }
                Step::OrBlock => {
                    self.or_block();
                    Some(Symbol::Link)
                }
                Step::Save(slot) => {
                    let point = self.point();
                    self.slots.insert(*slot, point);
                    Some(Symbol::Link)
                }
                Step::Fetch(slot) => {
                    let from = self.slots.get(slot).copied().flatten();
                    self.stack.pop();
                    self.stack.push(Result { from, conditions: Vec::new() });
                    Some(Symbol::Link)
                }
                Step::Nothing if parts.len() > 1 => None,
                _ => Some(Symbol::Box),
            };
            symbol = match (symbol, own) {
                (None | Some(Symbol::Link), Some(own)) => Some(own),
                (
                    Some(Symbol::Contact | Symbol::Negated),
                    Some(Symbol::Contact | Symbol::Negated),
                ) => Some(Symbol::Condition),
                (Some(before), Some(Symbol::Box)) if is_condition(before) => Some(before),
                (before, _) => before,
            };
        }
        let symbol = symbol.unwrap_or(Symbol::Box);
        if symbol != Symbol::Box {
            return symbol;
        }
        self.drive(element);
        driven(&parts[0].text)
    }

    fn condition(&mut self, join: Join, element: usize) {
        let one = Drawing::One(element);
        if join == Join::Start {
            self.finish();
        }
        match join {
            Join::Start | Join::Load => {
                self.stack.push(Result { from: None, conditions: vec![one] });
            }
            Join::And | Join::Replace => match self.stack.last_mut() {
                Some(top) => top.conditions.push(one),
                None => self.stack.push(Result { from: None, conditions: vec![one] }),
            },
            Join::Or => {
                let conditions = match self.stack.pop() {
                    Some(top) => vec![parallel(series(self.whole(top)), one)],
                    None => vec![one],
                };
                self.stack.push(Result { from: None, conditions });
            }
        }
    }

    fn and_block(&mut self) {
        let Some(last) = self.stack.pop() else { return };
        let conditions = self.whole(last);
        match self.stack.last_mut() {
            Some(top) => top.conditions.extend(conditions),
            None => self.stack.push(Result { from: None, conditions }),
        }
    }

    /// All conditions of a result from the left rail on: what stands before a point is drawn once more.
    fn whole(&self, result: Result) -> Vec<Drawing> {
        let mut paths = Vec::new();
        let mut from = result.from;
        while let Some(path) = from {
            paths.push(self.paths[path].conditions.clone());
            from = self.paths[path].from;
        }
        paths.into_iter().rev().chain(result.conditions).collect()
    }

    fn or_block(&mut self) {
        let Some(last) = self.stack.pop() else { return };
        let last = self.whole(last);
        let conditions = match self.stack.pop() {
            Some(top) => vec![parallel(series(self.whole(top)), series(last))],
            None => last,
        };
        self.stack.push(Result { from: None, conditions });
    }

    /// The point that the result has come to, as a path's end.
    fn point(&mut self) -> Option<usize> {
        let top = self.stack.last_mut()?;
        if !top.conditions.is_empty() {
            let conditions = series(std::mem::take(&mut top.conditions));
            self.paths.push(Path { from: top.from, conditions, driven: Vec::new() });
            top.from = Some(self.paths.len() - 1);
        }
        top.from
    }

    /// Drives an element by the result, and by those below it where it has several inputs.
    fn drive(&mut self, element: usize) {
        while self.stack.len() > 1 {
            let below = self.stack.remove(0);
            let conditions = series(below.conditions);
            self.paths.push(Path { from: below.from, conditions, driven: Vec::new() });
        }
        let point = self.point().unwrap_or_else(|| {
            self.paths.push(Path {
                from: None,
                conditions: series(Vec::new()),
                driven: Vec::new(),
            });
            let point = self.paths.len() - 1;
            self.stack = vec![Result { from: Some(point), conditions: Vec::new() }];
            point
        });
        self.paths[point].driven.push(element);
    }

    /// Draws what drives nothing.
    fn finish(&mut self) {
        for Result { from, conditions } in std::mem::take(&mut self.stack) {
            if !conditions.is_empty() {
                self.paths.push(Path { from, conditions: series(conditions), driven: Vec::new() });
            }
        }
    }
}

fn is_condition(symbol: Symbol) -> bool {
    matches!(symbol, Symbol::Contact | Symbol::Negated | Symbol::Condition)
}

fn series(mut drawn: Vec<Drawing>) -> Drawing {
    match (drawn.len(), drawn.pop()) {
        (1, Some(one)) => one,
        (_, Some(last)) => {
            drawn.push(last);
            Drawing::Series(drawn)
        }
        (_, None) => Drawing::Series(Vec::new()),
    }
}

fn parallel(first: Drawing, second: Drawing) -> Drawing {
    let branches = |drawn| match drawn {
        Drawing::Parallel(branches) => branches,
        one => vec![one],
    };
    let mut all = branches(first);
    all.extend(branches(second));
    Drawing::Parallel(all)
}

/// What a condition looks like. `LDP X0` asks for a bit and more, and is no plain contact.
fn contact(value: &Logic, text: &str) -> Symbol {
    match value {
        _ if text.split(' ').count() != 2 => Symbol::Condition,
        Logic::Bit(_) => Symbol::Contact,
        Logic::Not(inner) if matches!(**inner, Logic::Bit(_)) => Symbol::Negated,
        _ => Symbol::Condition,
    }
}

/// What an instruction looks like that is driven.
fn driven(text: &str) -> Symbol {
    let mut words = text.split(' ');
    let mnemonic = words.next().unwrap_or_default().trim_start_matches('@');
    match (mnemonic, words.count()) {
        ("OUT", 1) => Symbol::Coil,
        ("SET", 1) => Symbol::Set,
        ("RST" | "RSET", 1) => Symbol::Reset,
        _ => Symbol::Box,
    }
}
