//! Creates charges: for single executions, by number of units, and for summaries.

use super::number;
use super::run::Run;
use super::settings::{Purpose, ScanError};
use super::word::Word;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::{Counted, Relation, WordSource};
use scanbound_model::{ByUnits, Charge, Lit};
use std::sync::Arc;

impl Run<'_> {
    /// Adds the charge of an executed instruction to the model, unless both of its times are zero.
    pub(super) fn charge(&mut self, at: usize, reached: Lit, fires: Lit) {
        let times = self.times[at];
        if times == Times::default() {
            return;
        }
        let (on, counted) = self.by_units(at, fires);
        let frames = self.frames.clone();
        self.memory.model.charges.push(Charge {
            instruction: at,
            frames,
            reached,
            fires,
            on,
            off: times.off,
            counted,
        });
    }

    /// The largest on-time of an instruction, and its on-time by number of units if words that can be read give this
    /// number. For a lower bound with an unreadable number, the on-time for no units.
    fn by_units(&mut self, at: usize, fires: Lit) -> (Picos, Option<Box<ByUnits>>) {
        let times = self.times[at];
        let counted = self.program.instructions[at].counted();
        let Some(counted) = counted.filter(|_| times.per_unit > Picos::ZERO) else {
            return (times.on, None);
        };
        let number: Vec<Word> = counted.words.iter().map(|word| self.word(*word, at)).collect();
        if !Counted::is_read(&self.frames) {
            if number.iter().any(|&word| self.memory.words.as_constant(word).is_none()) {
                self.check_units(at, fires);
                let most = times.with(counted.most_units());
                return (if self.purpose == Purpose::UpperBound { most } else { times.on }, None);
            }
            Arc::make_mut(&mut self.memory.model.resolutions).record_count(&self.frames, at);
        }
        if let Some(&(low, high)) = self.program.stated_counts.get(&at) {
            let within = self.within(&number, false, low, high);
            self.exclude_unless(fires, within);
        }
        let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
        let mut above = |most: u64| {
            let places = number.iter().enumerate();
            let most = u32::try_from(most).unwrap_or(u32::MAX);
            let most: Vec<Word> =
                places.map(|(place, _)| words.constant((most >> (16 * place)) as u16)).collect();
            number::compare(words, circuit, Relation::Greater, false, &number, &most)
        };
        let largest = (1u64 << (16 * number.len())) - 1;
        let over = if counted.most < largest { above(counted.most) } else { Lit::FALSE };
        let sure = match self.purpose {
            Purpose::UpperBound => Lit::TRUE,
            Purpose::LowerBound if counted.executes_up_to < largest => {
                !above(counted.executes_up_to)
            }
            Purpose::LowerBound => Lit::TRUE,
        };
        let handled = circuit.and(fires, sure);
        let bits: Vec<Lit> = number.iter().flat_map(|&word| words.bits(circuit, word)).collect();
        let (mut base, mut units) = (times.on, Vec::new());
        for (holds, count) in number::in_parts(circuit, &bits, over, counted.most) {
            let more = times.per_unit.times(counted.each).times(count);
            match circuit.and(handled, holds) {
                Lit::FALSE => {}
                here if here == fires => base += more,
                here => units.push((here, more)),
            }
        }
        let beyond = circuit.and(fires, over);
        self.check_units(at, beyond);
        if units.is_empty() {
            return (base, None);
        }
        (times.with(counted.most_units()), Some(Box::new(ByUnits { base, units })))
    }

    /// The largest time that one execution of instruction `at` can take: on-time with most units, or off-time.
    fn largest_time(&self, at: usize) -> Picos {
        let times = self.times[at];
        let units = self.program.instructions[at].counted().map_or(0, Counted::most_units);
        times.with(units).max(times.off)
    }

    /// Charges a loop that is not followed, for lower bounds: the largest time of one iteration, times the number of
    /// iterations, as one charge for each bit of this number.
    pub(super) fn charge_by_count(
        &mut self,
        active: Lit,
        at: usize,
        charges: &[(usize, u64)],
        (count, _, most): (WordSource, u32, u32),
    ) -> Result<(), ScanError> {
        let mut iteration = Picos::ZERO;
        for &(instruction, times) in charges {
            iteration += self.largest_time(instruction).times(times / u64::from(most.max(1)));
        }
        let (count, is_signed) = self.count(count);
        let word = self.word(count, at);
        let bits = self.memory.words.bits(&mut self.memory.model.circuit, word);
        for (place, &bit) in bits.iter().enumerate().take(if is_signed { 15 } else { 16 }) {
            let fires = self.memory.circuit().and(active, bit);
            let cost = iteration.0.checked_mul(1 << place).map(Picos);
            let cost = cost.ok_or(ScanError::CostOverflow { instruction: at })?;
            self.charge_where(at, fires, cost);
        }
        Ok(())
    }

    /// Charges a loop or routine that is not followed: each instruction as often as `charges` says it can run at most,
    /// at its largest time.
    pub(super) fn charge_summary(
        &mut self,
        active: Lit,
        charges: &[(usize, u64)],
    ) -> Result<(), ScanError> {
        for &(instruction, times) in charges {
            let cost = self.largest_time(instruction).0.checked_mul(times).map(Picos);
            let cost = cost.ok_or(ScanError::CostOverflow { instruction })?;
            self.charge_where(instruction, active, cost);
        }
        Ok(())
    }

    /// Adds a charge of `cost` (ps) that occurs if `holds` is true.
    fn charge_where(&mut self, instruction: usize, holds: Lit, cost: Picos) {
        if holds == Lit::FALSE || cost == Picos::ZERO {
            return;
        }
        self.memory.model.charges.push(Charge {
            instruction,
            frames: self.frames.clone(),
            reached: holds,
            fires: holds,
            on: cost,
            off: cost,
            counted: None,
        });
    }
}
