//! Initial values of variables before the first scan, and values of constants in every scan.

use super::Lower;
use super::spots::Spot;
use crate::assembler::Assembler;
use crate::assembler::value::within;
use scanbound_front::builder::always;
use scanbound_iec_tree::declarations::Initial;
use scanbound_iec_tree::types::Type as Typed;
use scanbound_ir::{
    BitSource, BitTarget, Cell, Effect, Logic, Number, PowerUp, Region, RegionSet, Step, Tag, When,
    WordSource, WordTarget, Write, flow,
};

/// The name of the bit that is on only in the first scan.
pub(crate) const FIRST_SCAN: &str = "first scan";

/// The initial value of a variable or a part of one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum First {
    Zero,
    /// The bit in this cell is on.
    On(Cell),
    /// A number that is not 0, in the words from this cell on.
    Words(Cell, Number),
    /// A value that is not known.
    Unknown,
}

/// The initial value of a variable, or of several parts with the same value, with their cells.
pub(crate) struct FirstValue {
    pub(crate) regions: Vec<Region>,
    pub(crate) first: First,
}

impl Lower<'_> {
    /// Collects the initial values of a variable and its parts.
    pub(super) fn first_values(&self, begins: &Initial, spot: &Spot, found: &mut Vec<FirstValue>) {
        let tree = self.tree;
        let part = |tag: Option<Tag>, ty| Some(Spot { name: String::new(), tag: tag?, ty });
        let first = match begins {
            Initial::Nothing => return,
            Initial::Zero => First::Zero,
            Initial::Unknown => First::Unknown,
            Initial::Number(number) => match (tree.types.kind(spot.ty), spot.tag.cell()) {
                (None, Some(cell)) => First::On(cell),
                (Some(kind), Some(cell)) => First::Words(cell, within(kind, *number)),
                (_, None) => First::Unknown,
            },
            Initial::Parts(all) => {
                for (at, begins) in all.iter().enumerate() {
                    let ty = match tree.types.get(spot.ty) {
                        Typed::Struct(id) => tree.types.parts(*id)[at].1,
                        Typed::Standard(block) => match block.pins().nth(at) {
                            Some(pin) => tree.types.elementary(pin.of()),
                            None => continue,
                        },
                        _ => continue,
                    };
                    if let Some(part) = part(spot.tag.part_at(at), ty) {
                        self.first_values(begins, &part, found);
                    }
                }
                return;
            }
            Initial::Elements(all) => {
                let Typed::Array(dimensions, of) = tree.types.get(spot.ty) else { return };
                let mut numbers: Vec<i64> = dimensions.iter().map(|(low, _)| *low).collect();
                for begins in all {
                    let mut tags = numbers.iter();
                    let tag = tags.try_fold(spot.tag.clone(), |tag, at| tag.element(*at));
                    if let Some(one) = part(tag, *of) {
                        self.first_values(begins, &one, found);
                    }
                    for (number, (low, high)) in numbers.iter_mut().zip(dimensions).rev() {
                        *number += 1;
                        if *number <= *high {
                            break;
                        }
                        *number = *low;
                    }
                }
                return;
            }
        };
        found.push(FirstValue { regions: spot.tag.regions(), first });
    }
}

impl Assembler {
    /// Adds the instruction that gives constants their values when a scan begins, and returns its index. Its writes are
    /// added later.
    pub(crate) fn begin_constants(&mut self) -> usize {
        self.at(1, "constants");
        self.builder.add(None, Vec::new(), Step::Nothing)
    }

    /// Adds the writes of all constants' values: nothing else writes them, so they hold in every scan. An unknown value
    /// is any value, reported as over-approximated.
    pub(crate) fn give_constants(
        &mut self,
        at: Option<usize>,
        all: Vec<(String, Vec<FirstValue>)>,
    ) {
        let Some(at) = at else { return };
        let mut effects = Vec::new();
        for (name, found) in all {
            let is_unknown = found.iter().any(|one| one.first == First::Unknown);
            for FirstValue { regions, first } in found {
                match first {
                    First::Zero => effects.extend(regions.into_iter().flat_map(zeros)),
                    First::On(cell) => {
                        let on = Logic::Const(true);
                        effects.push(always(Write::Bit(BitTarget::Cell(cell), on)));
                    }
                    First::Words(cell, number) => effects.push(always(words(cell, number))),
                    First::Unknown => {
                        let choice = self.builder.choice();
                        let any = regions.into_iter().map(|region| Write::Havoc(region, choice));
                        effects.extend(any.map(always));
                    }
                }
            }
            if is_unknown {
                let why =
                    format!("the value of the constant {name} is not known: it may be any value");
                self.program().approximate(at, why);
            }
        }
        self.program().instructions[at].effects = effects;
    }

    /// Records the initial values of variables that the program writes and that share no memory. A variable that it
    /// only reads may be a parameter that somebody else sets.
    pub(crate) fn note_first_values(
        &mut self,
        at: Option<usize>,
        values: Vec<FirstValue>,
        shared: &RegionSet,
        known: &mut PowerUp,
    ) {
        let Some(at) = at else { return };
        let program = &self.builder.program;
        let Step::Act { fires: Logic::Bit(bit) } = &program.instructions[at].step else { return };
        let BitSource::Cell(first) = *bit else { return };
        let written: RegionSet =
            (0..program.instructions.len()).flat_map(|at| flow::written(program, at)).collect();
        let latched: RegionSet = known.latched.iter().copied().collect();
        let meets =
            |all: &RegionSet, one: &FirstValue| one.regions.iter().any(|own| all.overlaps(*own));
        for one in values {
            if meets(shared, &one) || !meets(&written, &one) {
                continue;
            }
            known.cleared.extend(&one.regions);
            match &one.first {
                // A retained bit is not set again at each power-up.
                First::On(cell) if meets(&latched, &one) => {
                    known.values.insert(*cell, 1);
                }
                First::On(cell) => {
                    let write = Write::Bit(BitTarget::Cell(*cell), Logic::Const(true));
                    let effect = Effect { when: When::Fired, write };
                    self.program().instructions[at].effects.push(effect);
                    known.first_scan = vec![first];
                    known.after_clear = Some(BitTarget::Cell(first));
                }
                First::Words(cell, Number::Words(words)) => {
                    for (cell, word) in (0..).map(|at| cell.plus(at)).zip(words) {
                        if let WordSource::Const(word) = word {
                            known.values.insert(cell, *word);
                        }
                    }
                }
                First::Words(..) | First::Zero | First::Unknown => {}
            }
        }
    }
}

/// Writes of 0 to all cells of a range.
fn zeros(region: Region) -> Vec<Effect> {
    let Region::Range { first, count } = region else { return Vec::new() };
    let zero = |cell: Cell| match Assembler::is_bit(cell) {
        true => Write::Bit(BitTarget::Cell(cell), Logic::Const(false)),
        false => words(cell, Number::Words(vec![WordSource::Const(0)])),
    };
    (0..count).map(|at| always(zero(first.plus(at)))).collect()
}

fn words(cell: Cell, number: Number) -> Write {
    let count = match &number {
        Number::Words(words) => words.len(),
        _ => 0,
    };
    Write::Words((0..).map(|at| WordTarget::Cell(cell.plus(at))).take(count).collect(), number)
}
