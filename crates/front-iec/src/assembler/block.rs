//! Lowers the function blocks of the standard: edge detection, bistables and counters.

use super::Assembler;
use super::memory::{all, any, set};
use super::mixed::below_zero;
use super::open::opened;
use super::types::INT;
use super::value::{Value, constant, signed, unsigned};
use scanbound_iec_tree::blocks::{Pin, StandardBlock};
use scanbound_ir::{Cell, Logic, Number, Relation, Step, TimingKey, WordSource, WordTarget, Write};

/// Text of a reading: how some controllers differ from the standard here.
const COUNTS_WORDS: &str = "counters count unsigned words";

impl Assembler {
    /// The timing key of a standard block: its name, or else the class `counter` for counters and `timer` for all
    /// others.
    pub(crate) fn block_key(block: StandardBlock) -> TimingKey {
        let class = if block.is_counter() { "counter" } else { "timer" };
        Assembler::key(&[block.name()], class)
    }

    /// Lowers the execution of a standard block whose inputs are set already. `cell` gives the cell of a pin, or None
    /// if the block has no such pin.
    pub(crate) fn standard_block(
        &mut self,
        block: StandardBlock,
        cell: &dyn Fn(Pin) -> Option<Cell>,
    ) {
        let bit = |pin: Pin| cell(pin).map_or(Logic::Const(false), Logic::cell);
        let (q, was) = (cell(Pin::Q), cell(Pin::Was));
        let mut writes = Vec::new();
        match block {
            StandardBlock::Ton | StandardBlock::Tof | StandardBlock::Tp => {
                return self.timer(block, cell);
            }
            StandardBlock::RTrig | StandardBlock::FTrig => {
                let (Some(q), Some(was)) = (q, was) else { return };
                let clock = bit(Pin::Clk);
                let edge = match block {
                    StandardBlock::RTrig => all([clock.clone(), Logic::cell(was).not()]),
                    _ => all([clock.clone().not(), Logic::cell(was)]),
                };
                writes.extend([set(q, edge), set(was, clock)]);
            }
            StandardBlock::Sr => {
                let Some(q) = cell(Pin::Q1) else { return };
                writes.push(set(q, any([bit(Pin::S1), all([bit(Pin::R).not(), Logic::cell(q)])])));
            }
            StandardBlock::Rs => {
                let Some(q) = cell(Pin::Q1) else { return };
                writes.push(set(q, all([bit(Pin::R1).not(), any([bit(Pin::S), Logic::cell(q)])])));
            }
            _ => return self.counter(block, cell),
        }
        let effects = writes.into_iter().map(scanbound_front::builder::always).collect();
        let fires = match q {
            Some(q) => Logic::cell(q),
            None => cell(Pin::Q1).map_or(Logic::Const(true), Logic::cell),
        };
        self.builder.add(Some(Assembler::block_key(block)), effects, Step::Act { fires });
    }

    fn counter(&mut self, block: StandardBlock, cell: &dyn Fn(Pin) -> Option<Cell>) {
        let bit = |pin: Pin| cell(pin).map_or(Logic::Const(false), Logic::cell);
        let (Some(count), Some(preset), Some(was)) = (cell(Pin::Cv), cell(Pin::Pv), cell(Pin::Was))
        else {
            return;
        };
        let word = |cell| Number::Words(vec![WordSource::Cell(cell)]);
        let write = |value| Write::Words(vec![WordTarget::Cell(count)], value);
        let one = || Box::new(constant(1, 1));
        let up = || Number::Add(Box::new(word(count)), one());
        let down = || Number::Sub(Box::new(word(count)), one());
        let (reset, load) = (bit(Pin::R), bit(Pin::Ld));
        // The standard declares PV and CV as INT; some controllers use WORD.
        let is_word = self.differs(COUNTS_WORDS);
        let either = |as_int: Logic, as_word: Logic| {
            let other = all([is_word.clone(), as_word]);
            any([all([is_word.clone().not(), as_int]), other])
        };
        let full = || {
            either(
                signed(Relation::GreaterOrEqual, word(count), word(preset)),
                unsigned(Relation::GreaterOrEqual, word(count), word(preset)),
            )
        };
        let empty = || {
            either(
                signed(Relation::LessOrEqual, word(count), constant(0, 1)),
                signed(Relation::Equal, word(count), constant(0, 1)),
            )
        };
        let below = either(
            signed(Relation::Less, word(count), constant(i64::from(i16::MAX), 1)),
            signed(Relation::NotEqual, word(count), constant(-1, 1)),
        );
        let above = either(
            signed(Relation::Greater, word(count), constant(i64::from(i16::MIN), 1)),
            signed(Relation::NotEqual, word(count), constant(0, 1)),
        );
        // In the standard, counters continue beyond the preset and below 0; on some controllers they stop there.
        let stops = self.differs("counters stop at their preset and at 0");
        let below = all([below, all([full(), stops.clone()]).not()]);
        let above = all([above, all([empty(), stops]).not()]);
        let rises = |input: Pin, was: Cell| all([bit(input), Logic::cell(was).not()]);
        match block {
            StandardBlock::Ctu => {
                let counts = all([rises(Pin::Cu, was), reset.clone().not(), below]);
                self.write_if(counts, vec![write(up())], None);
                self.write_if(reset, vec![write(constant(0, 1))], None);
                self.write(vec![set(was, bit(Pin::Cu))]);
                self.finish(block, cell(Pin::Q), full(), None);
            }
            StandardBlock::Ctd => {
                let counts = all([rises(Pin::Cd, was), load.clone().not(), above]);
                self.write_if(counts, vec![write(down())], None);
                self.write_if(load, vec![write(word(preset))], None);
                self.write(vec![set(was, bit(Pin::Cd))]);
                self.finish(block, cell(Pin::Q), empty(), None);
            }
            _ => {
                let Some(was_down) = cell(Pin::WasDown) else { return };
                let (rise, fall) = (rises(Pin::Cu, was), rises(Pin::Cd, was_down));
                let free = all([reset.clone().not(), load.clone().not()]);
                let only_up =
                    self.keep_bit(all([free.clone(), rise.clone(), fall.clone().not(), below]));
                let only_down = self.keep_bit(all([free, fall, rise.not(), above]));
                self.write_if(only_up, vec![write(up())], None);
                self.write_if(only_down, vec![write(down())], None);
                self.write_if(all([load, reset.clone().not()]), vec![write(word(preset))], None);
                self.write_if(reset, vec![write(constant(0, 1))], None);
                self.write(vec![set(was, bit(Pin::Cu)), set(was_down, bit(Pin::Cd))]);
                self.finish(
                    block,
                    cell(Pin::Qu),
                    full(),
                    cell(Pin::Qd).map(|cell| (cell, empty())),
                );
            }
        }
    }

    /// A value that was read from a cell. If the cell is CV or PV of a counter that counts unsigned on some
    /// controllers, a negative value does not fit its type.
    pub(crate) fn as_count(&mut self, cell: Option<Cell>, value: Value) -> Value {
        match value {
            Value::Number(kind, number) if cell.is_some_and(|cell| self.counts.contains(&cell)) => {
                let below = below_zero(INT, &number);
                opened(Value::Number(kind, number), Some(below))
            }
            value => value,
        }
    }

    fn finish(
        &mut self,
        block: StandardBlock,
        q: Option<Cell>,
        value: Logic,
        other: Option<(Cell, Logic)>,
    ) {
        let Some(q) = q else { return };
        let mut writes = vec![set(q, value)];
        writes.extend(other.map(|(cell, value)| set(cell, value)));
        let effects = writes.into_iter().map(scanbound_front::builder::always).collect();
        self.builder.add(
            Some(Assembler::block_key(block)),
            effects,
            Step::Act { fires: Logic::cell(q) },
        );
    }
}
