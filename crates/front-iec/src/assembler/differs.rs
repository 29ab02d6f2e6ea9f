//! Readings: points on which controllers differ. The upper bound allows both ways at each place; a real run follows one
//! way throughout.

use super::{Assembler, OpenEnd};
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{
    BitSource, BitTarget, Cell, Logic, Number, Region, RegionSet, Step, WordSource, WordTarget,
    Write,
};
use std::collections::{BTreeMap, BTreeSet};

/// A writer of a cell: the instruction, and the word that it writes there if this is constant.
type Writer = (usize, Option<u16>);

impl Assembler {
    /// A bit that is true if the controller deviates from the standard in the way that `what` describes. It is constant
    /// if the user states this, else free: the bound allows both values at each place, and a real run uses one value
    /// throughout.
    pub(crate) fn differs(&mut self, what: &'static str) -> Logic {
        if let Some((is_met, holds)) = self.stated_readings.get_mut(what) {
            *is_met = true;
            return Logic::Const(*holds);
        }
        let number =
            self.program().readings.iter().position(|known| known == what).unwrap_or_else(|| {
                self.program().readings.push(what.to_owned());
                self.program().readings.len() - 1
            });
        let number = u32::try_from(number).expect("a few");
        let choice = self.builder.choice();
        self.program().kinds.insert(choice, ChoiceKind::Reading(number));
        self.keep_bit(Logic::Bit(BitSource::Free(choice)))
    }

    /// As [`Self::differs`], but if the user does not state it, `known` says whether the controller deviates so.
    /// `None`: that is not known.
    pub(crate) fn differs_unless_known(
        &mut self,
        what: &'static str,
        known: Option<bool>,
    ) -> Logic {
        match known {
            Some(holds) if !self.stated_readings.contains_key(what) => Logic::Const(holds),
            _ => self.differs(what),
        }
    }

    /// Whether the user states that the controller does not deviate so.
    pub(crate) fn never_differs(&self, what: &'static str) -> bool {
        matches!(self.stated_readings.get(what), Some((_, false)))
    }

    /// Copies `value` to a bit that [`Assembler::settle`] may later replace by a constant, where it finds that the
    /// question makes no difference. Also returns the instruction that writes the bit.
    pub(crate) fn unless_settled(&mut self, value: Logic) -> (Logic, usize) {
        let cell = self.bit_between();
        let at = self.write(vec![Write::Bit(BitTarget::Cell(cell), value)]);
        (Logic::cell(cell), at)
    }

    /// Resolves all deferred decisions when the whole program is lowered. `own`: memory that is initialised at every
    /// call. `begins_off`: whether a cell is certainly 0 after power-up.
    pub(crate) fn settle(&mut self, own: &RegionSet, begins_off: &dyn Fn(Cell) -> bool) {
        let open = std::mem::take(&mut self.open_ends);
        let mut asked = BTreeSet::new();
        for one in &open {
            match one {
                OpenEnd::Preset { preset, .. } => asked.extend([*preset, preset.plus(1)]),
                OpenEnd::Variable { cell, .. } => _ = asked.insert(*cell),
                OpenEnd::StepTime { .. } | OpenEnd::Turns { .. } => {}
            }
        }
        let writers = self.writers(&asked);
        let none = Vec::new();
        let of = |cell: Cell| writers.get(&cell).unwrap_or(&none);
        // A time is never negative.
        let sign = |cell: &Cell| Logic::Bit(BitSource::WordBit(cell.plus(1), 15)).not();
        let signs: Vec<Logic> = self.times_read.iter().map(sign).collect();
        self.program().invariants.extend(signs);
        for one in open {
            match one {
                OpenEnd::Turns { actions, memory } => {
                    // If the chart itself begins anew with every call, its actions share that memory.
                    let is_within = memory.iter().any(|region| own.overlaps(*region));
                    let none = RegionSet::default();
                    self.settle_turns(&actions, if is_within { &none } else { own });
                }
                OpenEnd::Preset { at, preset } => {
                    let is_one = |cell: Cell| {
                        let mut values = of(cell).iter().map(|writer| writer.1);
                        let first = values.next().flatten();
                        first.is_some() && values.all(|value| value == first)
                    };
                    let is_given = !self.presets_left.contains(&preset);
                    if is_given && is_one(preset) && is_one(preset.plus(1)) {
                        self.set_to(at, false);
                    }
                }
                OpenEnd::Variable { at, cell, own } => {
                    let is_own = of(cell).iter().all(|(writer, _)| own.contains(writer));
                    if is_own && begins_off(cell) {
                        self.set_to(at, false);
                    }
                }
                OpenEnd::StepTime { cell, own } => {
                    if self.times_read.contains(&cell) {
                        continue;
                    }
                    for at in own {
                        // Its condition would read the times.
                        let one = &mut self.program().instructions[at];
                        one.effects.clear();
                        one.step = Step::Nothing;
                    }
                }
            }
        }
    }

    /// Makes an instruction write this constant to its bit.
    pub(crate) fn set_to(&mut self, at: usize, bit: bool) {
        for effect in &mut self.program().instructions[at].effects {
            if let Write::Bit(_, value) = &mut effect.write {
                *value = Logic::Const(bit);
            }
        }
    }

    fn writers(&mut self, asked: &BTreeSet<Cell>) -> BTreeMap<Cell, Vec<Writer>> {
        let mut found: BTreeMap<Cell, Vec<Writer>> = BTreeMap::new();
        let mut add = |cell: Cell, writer: Writer| {
            if asked.contains(&cell) {
                found.entry(cell).or_default().push(writer);
            }
        };
        for (at, instruction) in self.program().instructions.iter().enumerate() {
            for effect in &instruction.effects {
                match &effect.write {
                    Write::Bit(target, _) => add(target.cell(), (at, None)),
                    Write::Words(targets, number) => {
                        for (place, target) in targets.iter().enumerate() {
                            let value = match number {
                                Number::Words(words) => words.get(place),
                                _ => None,
                            };
                            let value = match value {
                                Some(WordSource::Const(value)) => Some(*value),
                                _ => None,
                            };
                            match *target {
                                WordTarget::Cell(cell) => add(cell, (at, value)),
                                WordTarget::Bits { first, count } => (0..count)
                                    .for_each(|bit| add(first.plus(bit.into()), (at, None))),
                                WordTarget::Discard => {}
                            }
                        }
                    }
                    Write::Havoc(region, _) => {
                        let within: Vec<Cell> = match *region {
                            Region::Range { first, count } => {
                                asked.range(first..first.plus(count)).copied().collect()
                            }
                            whole => {
                                asked.iter().copied().filter(|&cell| whole.contains(cell)).collect()
                            }
                        };
                        within.into_iter().for_each(|cell| add(cell, (at, None)));
                    }
                }
            }
        }
        found
    }
}
