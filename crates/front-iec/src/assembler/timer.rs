//! Lowers the timers TON, TOF and TP.

use super::memory::{all, any, set};
use super::time_range::{TICK, UNIT, is_between, is_edge};
use super::value::{constant, signed, sources, targets};
use super::{Assembler, OpenEnd};
use scanbound_front::builder::always;
use scanbound_iec_tree::blocks::{Pin, StandardBlock};
use scanbound_ir::timers::Expiry;
use scanbound_ir::{
    BitSource, BitTarget, Cell, Logic, Number, Region, Relation, Step, WordSource, Write,
};

/// The number in two words from this cell on.
pub(crate) fn double(first: Cell) -> Number {
    Number::Words(sources(first, 2))
}

/// A write of a number to two words from this cell on.
pub(crate) fn put(first: Cell, number: Number) -> Write {
    Write::Words(targets(first, 2), number)
}

impl Assembler {
    /// Lowers the execution of a timer. While its input keeps it running, it may expire in any scan; in the scan in
    /// which it starts, only if its time may be 0.
    pub(crate) fn timer(&mut self, block: StandardBlock, cell: &dyn Fn(Pin) -> Option<Cell>) {
        let (Some(input), Some(preset), Some(q), Some(elapsed), Some(was)) =
            (cell(Pin::In), cell(Pin::Pt), cell(Pin::Q), cell(Pin::Et), cell(Pin::Was))
        else {
            return;
        };
        let input = Logic::cell(input);
        // TON is at rest while its input is off, TOF while it is on, TP while its output is off.
        let (memory, rest, running) = match block {
            StandardBlock::Ton => (was, 0, false),
            StandardBlock::Tof => (was, 1, true),
            _ => (q, 0, true),
        };
        let runs_out = self.builder.external_choice();
        let setting = [preset, preset.plus(1)].map(WordSource::Cell).into();
        let on_delay = Expiry::of_on_delay(memory, WordSource::Const(0), UNIT);
        let expiry = Expiry {
            idle: rest,
            while_running: running,
            setting,
            tick: TICK,
            is_asked_again: true,
            ..on_delay
        };
        self.builder.program.timekeeping.expiries.insert(runs_out, expiry);
        let runs_out = Logic::Bit(BitSource::Free(runs_out));
        // A time of 0 may stand for a time below 1 ms. Controllers differ in whether a timer with a time of 0 expires
        // in the scan in which it starts.
        let short = self.left_open();
        let zero = || signed(Relation::LessOrEqual, double(preset), constant(0, 2));
        let q_before = self.keep_bit(Logic::cell(q));
        let was_on = self.keep_bit(Logic::cell(was));
        // If PT changes while the timer runs or after it has expired, some controllers test the expiry again and others
        // do not.
        let (changes, at) = self.unless_settled(Logic::Const(true));
        self.open_ends.push(OpenEnd::Preset { at, preset });
        let anew = self.differs("expired timers test a changed PT again");
        let anew = self.keep_bit(all([changes.clone(), anew]));
        let on = Logic::cell(q);
        let value = match block {
            StandardBlock::Ton => {
                let later = all([was_on.clone(), any([all([on, anew.clone().not()]), runs_out])]);
                all([input.clone(), any([later, all([zero(), short])])])
            }
            StandardBlock::Tof => {
                // The output stays on for a while after the input goes off.
                let first = all([was_on.clone(), any([zero().not(), short])]);
                let later = all([was_on.clone().not(), runs_out.clone()]);
                let again = all([anew.clone(), later.clone()]);
                any([input.clone(), all([on, any([first, later])]), again])
            }
            _ => {
                let begins = all([input.clone(), was_on.clone().not(), any([zero().not(), short])]);
                let again = all([anew.clone(), input.clone(), was_on.clone(), runs_out.clone()]);
                any([all([on.clone(), runs_out]), all([on.not(), any([begins, again])])])
            }
        };
        let effects = vec![always(set(q, value)), always(set(was, input.clone()))];
        let key = Some(Assembler::block_key(block));
        self.builder.add(key, effects, Step::Act { fires: Logic::cell(q) });
        self.elapsed(
            block,
            [input, was_on, q_before, Logic::cell(q)],
            changes,
            anew,
            preset,
            elapsed,
        );
    }
}

impl Assembler {
    /// A new time that may be any value not below the one at `before`. Returns its first cell and the two instructions
    /// that set it.
    pub(crate) fn later_than(&mut self, before: Cell) -> (Cell, [usize; 2]) {
        let time = self.words_between(2);
        let choice = self.builder.external_choice();
        // A run from power-up does not track this time.
        let timekeeping = &mut self.builder.program.timekeeping;
        timekeeping.untracked.insert(choice);
        timekeeping.continued.insert(choice, [time, before]);
        // A time is never negative.
        let sign = BitTarget::WordBit(time.plus(1), 15);
        let any_time = Write::Havoc(Region::Range { first: time, count: 2 }, choice);
        let found = self.write(vec![any_time, Write::Bit(sign, Logic::Const(false))]);
        let earlier = signed(Relation::Less, double(time), double(before));
        let least = self.write_if(earlier, vec![put(time, double(before))], None);
        (time, [found, least])
    }

    /// Lowers the elapsed time ET of a timer: from 0 up to PT, which it has once the timer has expired.
    fn elapsed(
        &mut self,
        block: StandardBlock,
        [input, was_on, q_before, q]: [Logic; 4],
        changes: Logic,
        anew: Logic,
        preset: Cell,
        elapsed: Cell,
    ) {
        let (time, _) = self.later_than(elapsed);
        // The largest PT stands for all longer times, too.
        let is_longer = is_edge(&double(preset)).not();
        let over = signed(Relation::GreaterOrEqual, double(time), double(preset));
        let over = self.keep_bit(all([over, is_longer]));
        let below = Number::Sub(Box::new(double(preset)), Box::new(constant(1, 2)));
        self.write_if(over.clone(), vec![put(time, below)], None);
        // A PT between two milliseconds has other times between the same two below it.
        let between = is_between(&double(preset)).unwrap_or(Logic::Const(false));
        self.write_if(all([over, between]), vec![put(time, double(preset))], None);
        let none = signed(Relation::LessOrEqual, double(preset), constant(0, 2));
        self.write_if(none, vec![put(time, constant(0, 2))], None);
        // Controllers differ in ET of an expired timer whose PT changes.
        let other = self.differs("ET of an expired timer stays the same when PT changes");
        let stays = all([changes, any([anew.not(), other])]);
        let no = Logic::not;
        // Controllers differ in ET of a timer at rest.
        let rest = self.differs("a timer at rest has another ET than in the standard");
        let (zero, running, ended) = match block {
            StandardBlock::Ton => (
                any([no(input.clone()), no(was_on.clone())]),
                all([input, was_on, no(q.clone())]),
                all([q, all([q_before, stays]).not()]),
            ),
            StandardBlock::Tof => (
                any([
                    input.clone(),
                    all([was_on.clone(), q.clone()]),
                    all([no(input.clone()), no(q.clone()), rest.clone()]),
                ]),
                all([no(input.clone()), no(was_on.clone()), q.clone()]),
                all([no(input), no(q), any([q_before, was_on]), no(rest)]),
            ),
            _ => (
                any([
                    all([q.clone(), no(q_before.clone()), no(was_on.clone())]),
                    all([no(q.clone()), no(input.clone()), no(rest.clone())]),
                ]),
                all([q.clone(), any([q_before.clone(), was_on])]),
                all([no(q), q_before, any([input, rest])]),
            ),
        };
        self.write_if(zero, vec![put(elapsed, constant(0, 2))], None);
        self.write_if(running, vec![put(elapsed, double(time))], None);
        self.write_if(ended, vec![put(elapsed, double(preset))], None);
    }
}
