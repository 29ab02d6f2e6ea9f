//! Ladder diagrams: reconstructs from the instruction list the contacts in series and in parallel of each rung, and
//! what they drive.

use super::{Instruction, Join, Logic, Program, Step};
use scanbound_base::location::Location;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// A rung of a ladder program, for drawing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rung {
    /// The number of the rung, counted from 1 through all files.
    pub number: u32,
    /// The index of the file that contains the rung.
    pub file: u32,
    /// The instructions of the rung in source order.
    pub elements: Vec<Element>,
    /// The paths of the rung from the left rail. A path comes after the path at whose end it starts.
    pub paths: Vec<Path>,
}

/// An instruction of the source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// The position of the instruction in the source.
    pub at: Location,
    /// The text of the instruction.
    pub text: Arc<str>,
    /// The symbol to draw.
    pub symbol: Symbol,
    /// The parts of the instruction in the program, indices into `Program::instructions`.
    pub parts: Range<usize>,
}

impl Element {
    /// The text to write at the symbol: the operand of a contact or coil (also of a set or reset coil), otherwise the
    /// whole instruction.
    #[must_use]
    pub fn label(&self) -> &str {
        match self.symbol {
            Symbol::Condition | Symbol::Box | Symbol::Link => &self.text,
            _ => self.text.split_once(' ').map_or(&self.text, |(_, operand)| operand),
        }
    }
}

/// The symbol of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Symbol {
    /// A normally open contact: conducts while its device is on.
    Contact,
    /// A normally closed contact: conducts while its device is off.
    Negated,
    /// A condition that is not a contact: an edge, a comparison, or a change of the result.
    Condition,
    /// A coil, which writes the condition to its device.
    Coil,
    /// A set coil (latch).
    Set,
    /// A reset coil (unlatch).
    Reset,
    /// A box that contains the instruction's text.
    Box,
    /// Not drawn: the instruction only connects others.
    Link,
}

/// A section of a rung between two branching points: conditions, then the elements that they drive. The end of a path
/// is a branching point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path {
    /// The path at whose end this path starts; `None` for the left rail.
    pub from: Option<usize>,
    /// The conditions in series along this path, before its end.
    pub conditions: Drawing,
    /// The coils and boxes that are connected to the end of the path, indices into [`Rung::elements`].
    pub driven: Vec<usize>,
}

/// How conditions are connected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Drawing {
    /// One condition, an index into [`Rung::elements`].
    One(usize),
    /// Drawings that are connected in series, from left to right; a plain wire if empty.
    Series(Vec<Drawing>),
    /// Drawings that are connected in parallel.
    Parallel(Vec<Drawing>),
}

/// All rungs of a program in source order.
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

/// An entry of the result stack: the conditions after a branching point.
#[derive(Default)]
struct Result {
    from: Option<usize>,
    conditions: Vec<Drawing>,
}

/// Builds the drawing of a rung instruction by instruction.
#[derive(Default)]
struct Drawer {
    stack: Vec<Result>,
    slots: BTreeMap<u32, Option<usize>>,
    paths: Vec<Path>,
}

impl Drawer {
    /// Adds one instruction, which is element number `element` of the rung, to the drawing. Returns its symbol.
    fn take(&mut self, parts: &[Instruction], element: usize) -> Symbol {
        let mut symbol = None;
        for part in parts {
            let own = match &part.step {
                Step::Logic { join, value } => {
                    // An instruction with several condition parts is drawn as one condition.
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
                    let point = self.branch_here();
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
        output_symbol(&parts[0].text)
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

    /// The conditions from the left rail to this result. Conditions before a branching point are repeated.
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

    /// Ends the path of the current result, so that it can branch there, and returns the path's index. `None` if the
    /// branch is at the left rail.
    fn branch_here(&mut self) -> Option<usize> {
        let top = self.stack.last_mut()?;
        if !top.conditions.is_empty() {
            let conditions = series(std::mem::take(&mut top.conditions));
            self.paths.push(Path { from: top.from, conditions, driven: Vec::new() });
            top.from = Some(self.paths.len() - 1);
        }
        top.from
    }

    /// Connects an element to the end of the current path. If the stack has more results, as for an instruction with
    /// several inputs, their conditions become paths of their own that drive nothing.
    fn drive(&mut self, element: usize) {
        while self.stack.len() > 1 {
            let below = self.stack.remove(0);
            let conditions = series(below.conditions);
            self.paths.push(Path { from: below.from, conditions, driven: Vec::new() });
        }
        let point = self.branch_here().unwrap_or_else(|| {
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

    /// Ends the rung or a part of it: the conditions that are left on the stack, to which no output is connected,
    /// become paths.
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

/// The symbol of a condition: a contact if the instruction has one operand and its value is a bit or a negated bit.
/// `LDP X0` tests more than a bit, so it is not a contact.
fn contact(value: &Logic, text: &str) -> Symbol {
    match value {
        _ if text.split(' ').count() != 2 => Symbol::Condition,
        Logic::Bit(_) => Symbol::Contact,
        Logic::Not(inner) if matches!(**inner, Logic::Bit(_)) => Symbol::Negated,
        _ => Symbol::Condition,
    }
}

/// The symbol of an output: `OUT`, `SET`, `RST` or `RSET` with one operand is a coil; every other instruction is a box.
fn output_symbol(text: &str) -> Symbol {
    let mut words = text.split(' ');
    let mnemonic = words.next().unwrap_or_default().trim_start_matches('@');
    match (mnemonic, words.count()) {
        ("OUT", 1) => Symbol::Coil,
        ("SET", 1) => Symbol::Set,
        ("RST" | "RSET", 1) => Symbol::Reset,
        _ => Symbol::Box,
    }
}
