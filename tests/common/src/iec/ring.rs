//! A ring of steps whose actions and transitions are drawings and lists, as PLCopen XML.

use super::control::{QUALIFIERS, is_timed};
use super::drawn::{Drawing, Edge, Input, Mode, What};
use super::generate::{Code, Dice, bit, instructions, variable};
use super::list::{self, Instruction};
use super::machine::{BOOL, Machine};
use std::fmt::Write;

/// A ring of steps with a way past the second: each has an action, and a transition behind it.
#[derive(Debug, Clone)]
pub struct Ring {
    /// The blocks of each step: an action, which may be that of another step, and its qualifier.
    pub blocks: Vec<Vec<(usize, &'static str)>>,
    /// The time of each action in milliseconds.
    pub times: Vec<i64>,
    pub actions: Vec<Code>,
    /// From, to, condition.
    pub transitions: Vec<(usize, usize, Condition)>,
}

#[derive(Debug, Clone)]
pub enum Condition {
    List(Vec<Instruction>),
    /// Contacts in series, each with what negates it.
    Ladder(Vec<(&'static str, bool)>),
    /// AND or OR of two.
    Blocks(&'static str, [(&'static str, bool); 2]),
}

impl Condition {
    fn new(dice: &mut Dice) -> Condition {
        let mut one = || (bit(dice, false), dice.chance(2));
        let pair = [one(), one()];
        match dice.below(3) {
            0 => Condition::List(instructions(dice, false, true)),
            1 => Condition::Ladder(pair[..1 + dice.below(2)].to_vec()),
            _ => Condition::Blocks(dice.one(&["AND", "OR", "XOR"]), pair),
        }
    }

    pub fn holds(&self, machine: &mut Machine<'_>) -> bool {
        let of = |machine: &Machine<'_>, (name, negated): (&str, bool)| {
            (machine.get(name) == 1) != negated
        };
        match self {
            Condition::List(list) => list::scan(list, machine).1 == Some(1),
            Condition::Ladder(all) => all.iter().all(|one| of(machine, *one)),
            Condition::Blocks(name, [one, two]) => {
                let (one, two) = (of(machine, *one), of(machine, *two));
                match *name {
                    "AND" => one && two,
                    "OR" => one || two,
                    _ => one != two,
                }
            }
        }
    }

    fn xml(&self) -> String {
        match self {
            Condition::List(list) => format!("<IL><p>{}</p></IL>", list::text(list)),
            Condition::Ladder(all) => {
                let mut drawing = Drawing::default();
                let mut from = drawing.add(What::Rail);
                for (name, negated) in all {
                    from = drawing.add(What::Contact(name, *negated, Edge::None, vec![(from, "")]));
                }
                let coil = What::Coil("result", Mode::Plain, Edge::None, vec![(from, "")]);
                drawing.add(coil);
                format!("<LD>{}</LD>", drawing.xml())
            }
            Condition::Blocks(name, both) => {
                let mut drawing = Drawing::default();
                let inputs = [("IN1", both[0]), ("IN2", both[1])].map(|(name, (of, negated))| {
                    let from = drawing.add(What::In(variable(of, BOOL), false));
                    Input { name, from: vec![(from, "")], negated, edge: Edge::None }
                });
                let id = drawing.add(What::Function(name, BOOL, None, inputs.to_vec()));
                drawing.add(What::Out("result", false, vec![(id, "OUT")]));
                format!("<FBD>{}</FBD>", drawing.xml())
            }
        }
    }
}

impl Ring {
    pub fn new(dice: &mut Dice) -> Ring {
        let actions: Vec<Code> = (0..3)
            .map(|_| {
                let which = dice.below(4);
                Code::new(dice, which, false, true)
            })
            .collect();
        let mut blocks: Vec<Vec<(usize, &'static str)>> = Vec::new();
        for step in 0..3 {
            let own = (0..1 + dice.below(2)).map(|_| {
                let action = if dice.chance(3) { dice.below(3) } else { step };
                let qualifier = if dice.chance(2) { "N" } else { dice.one(QUALIFIERS) };
                (action, qualifier)
            });
            blocks.push(own.collect());
        }
        let times = (0..3).map(|_| dice.one(&[0, 10, 20])).collect();
        let ways = [(0, 1), (0, 2), (1, 2), (2, 0)];
        let transitions = ways.map(|(from, to)| (from, to, Condition::new(dice)));
        Ring { blocks, times, actions, transitions: transitions.to_vec() }
    }

    pub fn xml(&self) -> (String, String) {
        let mut text = String::new();
        for step in 0..3 {
            let before: Vec<usize> = (0..self.transitions.len())
                .filter(|way| self.transitions[*way].1 == step && step > 0)
                .collect();
            let from = match before[..] {
                [] => String::new(),
                [one] => format!(
                    "<connectionPointIn><connection refLocalId=\"{}\"/></connectionPointIn>",
                    10 + one
                ),
                _ => {
                    let all: String = before
                        .iter()
                        .map(|one| {
                            format!(
                                "<connectionPointIn><connection refLocalId=\"{}\"/></connectionPointIn>",
                                10 + one
                            )
                        })
                        .collect();
                    let _ = write!(
                        text,
                        "<selectionConvergence localId=\"50\">{all}</selectionConvergence>"
                    );
                    "<connectionPointIn><connection refLocalId=\"50\"/></connectionPointIn>"
                        .to_owned()
                }
            };
            let initial = if step == 0 { " initialStep=\"true\"" } else { "" };
            let _ = write!(
                text,
                "<step localId=\"{}\" name=\"s{step}\"{initial}>{from}</step>",
                step + 1
            );
            let mut own = String::new();
            for (action, qualifier) in &self.blocks[step] {
                let time = match is_timed(qualifier) {
                    true => format!(" duration=\"T#{}ms\"", self.times[*action]),
                    false => String::new(),
                };
                let _ = write!(
                    own,
                    "<action qualifier=\"{qualifier}\"{time}><reference name=\"act{action}\"/></action>"
                );
            }
            let _ = write!(
                text,
                "<actionBlock localId=\"{}\"><connectionPointIn><connection refLocalId=\"{}\"/></connectionPointIn>{own}</actionBlock>",
                step + 20,
                step + 1
            );
        }
        text += "<selectionDivergence localId=\"40\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn></selectionDivergence>";
        for (way, (from, _, condition)) in self.transitions.iter().enumerate() {
            let from = if *from == 0 { 40 } else { from + 1 };
            let _ = write!(
                text,
                "<transition localId=\"{}\"><connectionPointIn><connection refLocalId=\"{from}\"/></connectionPointIn>\
                 <condition><inline name=\"\">{}</inline></condition></transition>",
                way + 10,
                condition.xml()
            );
        }
        text += "<jumpStep localId=\"60\" targetName=\"s0\"><connectionPointIn><connection refLocalId=\"13\"/></connectionPointIn></jumpStep>";
        let action = |(at, code): (usize, &Code)| {
            format!("<action name=\"act{at}\"><body>{}</body></action>", code.xml())
        };
        let actions: String = self.actions.iter().enumerate().map(action).collect();
        (format!("<SFC>{text}</SFC>"), actions)
    }
}
