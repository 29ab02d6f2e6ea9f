//! Reads and writes of choices about which something is known: observed results of operations, results computed here,
//! and the iterations of loops.

use super::expression::describe;
use super::number;
use super::run::Run;
use super::settings::Purpose;
use super::word::Word;
use scanbound_ir::meaning::{ChoiceKind, Observation, Operation, OperationInput, Outcome, Read};
use scanbound_ir::timers::Expiry;
use scanbound_ir::{
    AreaKind, BitTarget, Cell, ChoiceId, Logic, Region, Relation, Source, WordSource, WordTarget,
    Write,
};
use scanbound_model::Lit;

impl Run<'_> {
    /// What real runs observed of a choice in the current call context. An upper bound does not use what only PLCs
    /// with enough devices do.
    fn facts(&self, choice: ChoiceId) -> Vec<Observation> {
        if self.knowledge.is_empty() {
            return Vec::new();
        }
        let facts = self.knowledge.get(&(self.frames.clone(), choice)).into_iter().flatten();
        let is_used =
            |fact: &&Observation| self.purpose == Purpose::LowerBound || !fact.needs_devices;
        facts.filter(is_used).cloned().collect()
    }

    /// The value of a choice that is read, computed by executing its operation. A value that was computed under a guard
    /// is used again wherever that guard is true. `None` if the choice has no operation or the operands are unknown.
    fn computed_value(&mut self, choice: ChoiceId, at: usize) -> Option<Word> {
        let moment = (self.frames.clone(), choice);
        let before = self.known.settled.get(&moment).copied();
        if let Some((under, word)) = before {
            let (words, circuit) = (&self.memory.words, &self.memory.model.circuit);
            if self.known.implications(circuit, words).holds(circuit, words, under) {
                return Some(word);
            }
        }
        let mut word = self.resolved_word(choice, at)?;
        let mut under = self.known.reached;
        if let Some((first, value)) = before {
            word = self.memory.words.either(first, value, word);
            under = self.memory.circuit().or(first, under);
        }
        self.known.settled.insert(moment, (under, word));
        Some(word)
    }

    /// A literal that is equal to a bit cell's value wherever the guard `KnownChoices::reached` is true; simpler if
    /// possible.
    pub(super) fn simplified_bit(&mut self, cell: Cell) -> Lit {
        let bit = self.memory.read_bit(cell);
        let (words, circuit) = (&self.memory.words, &self.memory.model.circuit);
        self.known.implications(circuit, words).within(circuit, words, bit)
    }

    /// A word that is equal to a word cell's value wherever the guard `KnownChoices::reached` is true; simpler if
    /// possible.
    pub(super) fn simplified_word(&mut self, cell: Cell) -> Word {
        let word = self.memory.read_word(cell);
        let (words, circuit) = (&mut self.memory.words, &self.memory.model.circuit);
        let short = self.known.simplified(circuit, words, word);
        if short != word && words.as_constant(short).is_none() {
            self.known.before.insert(short, (word, self.known.reached));
        }
        short
    }

    /// The literal of a choice that instruction `at` reads as a bit: computed, or observed in a real run, where that is
    /// known; otherwise free. For lower bounds, a [`ChoiceKind::StableExternal`] is its source, and for timers see
    /// `expired`.
    pub(super) fn bit_choice(&mut self, choice: ChoiceId, at: usize) -> Lit {
        let program = self.program;
        if let Some(word) = self.computed_value(choice, at) {
            return self.memory.words.bits(&mut self.memory.model.circuit, word)[0];
        }
        if let (Some(&ChoiceKind::StableExternal(Source::Bit(bit))), Purpose::LowerBound) =
            (program.kinds.get(&choice), self.purpose)
        {
            return self.logic(&Logic::Bit(bit), Lit::TRUE, at);
        }
        if let (Some(expiry), Purpose::LowerBound) =
            (program.timekeeping.expiries.get(&choice), self.purpose)
        {
            return self.expired(choice, expiry, at);
        }
        let free = self.memory.bit_choice(&self.frames, choice, &|| describe(program, at));
        let facts = self.facts(choice);
        if facts.is_empty() {
            return free;
        }
        let moment = (self.frames.clone(), choice);
        if let Some(&known) = self.known.bits.get(&moment) {
            return known;
        }
        let mut bit = free;
        for fact in facts {
            let Outcome::Value(value) = fact.outcome else { continue };
            let matches = self.matches(&fact.reads, at);
            bit = self.memory.circuit().ite(matches, Lit::constant(value & 1 == 1), bit);
        }
        self.known.bits.insert(moment, bit);
        bit
    }

    /// The word of a choice that instruction `at` reads as a word: computed, or observed in a real run, where that is
    /// known; otherwise free. [`ChoiceKind::Iterations`] and [`ChoiceKind::ScanTicks`] have rules of their own, and for
    /// lower bounds the present values of timers and counters.
    pub(super) fn word_choice(&mut self, choice: ChoiceId, at: usize) -> Word {
        let program = self.program;
        let iterations = match program.kinds.get(&choice) {
            Some(ChoiceKind::Iterations(word)) => Some(*word),
            _ => None,
        };
        if let (Some(&ChoiceKind::StableExternal(Source::Word(word))), Purpose::LowerBound) =
            (program.kinds.get(&choice), self.purpose)
        {
            return self.word(word, at);
        }
        if let (Some(&ChoiceKind::PresentValue { contact, setting }), Purpose::LowerBound) =
            (program.kinds.get(&choice), self.purpose)
        {
            return self.present(choice, contact, setting, at);
        }
        if let (Some(ChoiceKind::Exact(meaning)), Purpose::LowerBound) =
            (program.kinds.get(&choice), self.purpose)
            && meaning.operation == Operation::Counted
            && let Some(word) = self.counted(choice, &meaning.inputs, at)
        {
            return word;
        }
        if let Some(&ChoiceKind::ScanTicks { goes_on, .. }) = program.kinds.get(&choice) {
            let most = program.timekeeping.most_ticks.get(&choice);
            match (self.purpose, most) {
                (Purpose::LowerBound, _) if !goes_on => return self.memory.words.constant(0),
                (Purpose::LowerBound, None) => return self.memory.words.constant(0x7FFF),
                (Purpose::LowerBound, Some(&most)) => return self.memory.words.constant(most),
                (Purpose::UpperBound, Some(&most)) => return self.memory.words.constant(most),
                (Purpose::UpperBound, None) => {}
            }
        }
        if let Some(word) = self.computed_value(choice, at) {
            return word;
        }
        let facts = self.facts(choice);
        let learned = !facts.is_empty();
        let free = match iterations {
            None => self.memory.word_choice(&self.frames, choice, &|| describe(program, at)),
            Some(_) => self.one_or_no_iteration(choice, at),
        };
        if iterations.is_none() && !learned {
            return free;
        }
        let moment = (self.frames.clone(), choice);
        if let Some(&known) = self.known.words.get(&moment) {
            return known;
        }
        let mut word = free;
        if let Some(count) = iterations {
            let count = self.word(count, at);
            let circuit = &mut self.memory.model.circuit;
            let some = self.memory.words.in_range(circuit, count, 1, 0x7FFF);
            word = self.memory.words.either(some, count, word);
        }
        for fact in facts {
            let Outcome::Value(value) = fact.outcome else { continue };
            let matches = self.matches(&fact.reads, at);
            let value = self.memory.words.constant(value);
            word = self.memory.words.either(matches, value, word);
        }
        self.known.words.insert(moment, word);
        word
    }

    /// The present value of a timer, for lower bounds: the set value if the timer's contact is on, otherwise any
    /// smaller value (0 if the set value is 0).
    fn present(&mut self, choice: ChoiceId, contact: Cell, setting: u16, at: usize) -> Word {
        let program = self.program;
        let free = self.memory.word_choice(&self.frames, choice, &|| describe(program, at));
        let contact = self.memory.read_bit(contact);
        let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
        let (zero, full) = (words.constant(0), words.constant(setting));
        let below = match setting.checked_sub(1) {
            Some(most) => words.in_range(circuit, free, 0, most),
            None => Lit::FALSE,
        };
        let below = words.either(below, free, zero);
        words.either(contact, full, below)
    }

    /// The literal of the choice that says whether a timer has run out, for lower bounds. A timer that was running when
    /// the scan began has run out if its flag is on, or if it has certainly been running for longer than its setting.
    /// Otherwise the choice is free; but a timer that `Timekeeping::are_kept` concerns has not run out.
    fn expired(&mut self, choice: ChoiceId, expiry: &Expiry, at: usize) -> Lit {
        let moment = (self.frames.clone(), choice);
        if let Some(&known) = self.known.bits.get(&moment) {
            return known;
        }
        let program = self.program;
        let free = self.memory.bit_choice(&self.frames, choice, &|| describe(program, at));
        let setting = expiry.setting.iter().rev().try_fold(0u64, |all, word| match *word {
            WordSource::Const(word) => Some(all << 16 | u64::from(word)),
            _ => None,
        });
        let gap = program.timekeeping.least_gaps.get(&expiry.memory);
        let is_short = gap.zip(setting).is_some_and(|(gap, setting)| {
            let longest =
                u128::from(expiry.unit.0) * u128::from(setting.saturating_add(expiry.tick));
            !expiry.is_decimal && self.frames.is_empty() && u128::from(gap.0) > longest
        });
        let is_kept = program.timekeeping.are_kept && expiry.can_be_kept();
        let flag = expiry.flag.filter(|_| is_kept || setting.is_some());
        let certain = match flag.map(|flag| self.memory.read_bit(flag)) {
            _ if is_short => Lit::TRUE,
            Some(flag) => flag,
            None if is_kept => Lit::FALSE,
            None => return free,
        };
        let rests = if self.is_bit(expiry.memory) {
            let memory = self.memory.read_bit(expiry.memory);
            if expiry.idle & 1 == 1 { memory } else { !memory }
        } else {
            let memory = self.memory.read_word(expiry.memory);
            self.equals(memory, u16::MAX, expiry.idle)
        };
        let circuit = self.memory.circuit();
        let certain = circuit.and(certain, !rests);
        let open = if is_kept { Lit::constant(expiry.while_running) } else { free };
        let over = circuit.ite(certain, Lit::constant(!expiry.while_running), open);
        self.known.bits.insert(moment, over);
        over
    }

    /// The present value of a counter after its instruction: one more than before if neither its coil nor its contact
    /// was on, otherwise as before. It is any value where manuals do not define it. `None` if the inputs are not a
    /// coil, a contact, a value before and a setting.
    fn counted(&mut self, choice: ChoiceId, inputs: &[OperationInput], at: usize) -> Option<Word> {
        let moment = (self.frames.clone(), choice);
        if let Some(&known) = self.known.words.get(&moment) {
            return Some(known);
        }
        let [OperationInput::Bits(coil), OperationInput::Bits(contact), before, setting] = inputs
        else {
            return None;
        };
        let (OperationInput::Words(before), OperationInput::Words(setting)) = (before, setting)
        else {
            return None;
        };
        let (&[coil], &[contact], &[before], &[setting]) =
            (&coil[..], &contact[..], &before[..], &setting[..])
        else {
            return None;
        };
        let [coil, contact] =
            [coil, contact].map(|bit| self.logic(&Logic::Bit(bit), Lit::TRUE, at));
        let [before, setting] = [before, setting].map(|word| self.word(word, at));
        let program = self.program;
        let free = self.memory.word_choice(&self.frames, choice, &|| describe(program, at));
        let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
        let mut is = |relation, one: Word, other: Word| {
            number::compare(words, circuit, relation, true, &[one], &[other])
        };
        let reached = is(Relation::Equal, before, setting);
        let is_above = is(Relation::Greater, before, setting);
        let is_negative = words.in_range(circuit, before, 0x8000, u16::MAX);
        let is_set = words.in_range(circuit, setting, 1, 0x7FFF);
        let differs = circuit.xor(reached, contact);
        let undefined = circuit.any([differs, is_above, is_negative, !is_set]);
        let counts = circuit.and(!coil, !contact);
        let more = words.plus(before, 1);
        let now = words.either(counts, more, before);
        let now = words.either(undefined, free, now);
        self.known.words.insert(moment, now);
        Some(now)
    }

    /// The word 1 or 0, for a loop of which manuals do not say whether it makes one iteration or none. A free bit of
    /// the choice decides; a lower bound uses 0.
    fn one_or_no_iteration(&mut self, choice: ChoiceId, at: usize) -> Word {
        if self.purpose == Purpose::LowerBound {
            return self.memory.words.constant(0);
        }
        let program = self.program;
        let free = self.memory.word_choice(&self.frames, choice, &|| describe(program, at));
        let circuit = &mut self.memory.model.circuit;
        let bit = self.memory.words.bits(circuit, free)[0];
        let mut bits = [Lit::FALSE; 16];
        bits[0] = bit;
        self.memory.words.of_bits(&self.memory.model.circuit, bits)
    }

    /// Writes the computed or observed results of a choice's operation in place of its havoc; for lower bounds also the
    /// number that stands for an address. Returns the part of `guard` under which nothing is known, so that the havoc
    /// remains necessary. An instruction's results are written only once.
    pub(super) fn write_observed(&mut self, choice: ChoiceId, guard: Lit, at: usize) -> Lit {
        if guard == Lit::FALSE {
            return guard;
        }
        if let (Some(&ChoiceKind::AddressOf { number, .. }), Purpose::LowerBound) =
            (self.program.kinds.get(&choice), self.purpose)
        {
            for effect in &self.program.instructions[at].effects {
                if let Write::Havoc(Region::Range { first, count: 2 }, own) = effect.write
                    && own == choice
                {
                    self.write_known(first, u16::MAX, number as u16, guard);
                    self.write_known(first.plus(1), u16::MAX, (number >> 16) as u16, guard);
                    return Lit::FALSE;
                }
            }
        }
        let same = |&&(own, under, _): &&(ChoiceId, Lit, Lit)| own == choice && under == guard;
        if let Some(&(_, _, rest)) = self.known.written.iter().find(same) {
            return rest;
        }
        if self.known.written.iter().any(|&(own, ..)| own == choice) {
            return guard;
        }
        if let Some(rest) = self.write_resolved(choice, guard, at) {
            self.known.written.push((choice, guard, rest));
            return rest;
        }
        let facts = self.facts(choice);
        if facts.is_empty() {
            return guard;
        }
        let known: Vec<Lit> = facts.iter().map(|fact| self.matches(&fact.reads, at)).collect();
        // The operation reads all inputs before it writes any result.
        let mut rest = guard;
        for (fact, matches) in facts.iter().zip(known) {
            let Outcome::Writes(writes) = &fact.outcome else { continue };
            let circuit = self.memory.circuit();
            let happens = circuit.and(rest, matches);
            rest = circuit.and(rest, !matches);
            for &(cell, mask, value) in writes {
                self.write_known(cell, mask, value, happens);
            }
        }
        self.known.written.push((choice, guard, rest));
        rest
    }

    fn write_known(&mut self, cell: Cell, mask: u16, value: u16, guard: Lit) {
        if self.is_bit(cell) {
            let value = Lit::constant(value & 1 == 1);
            self.memory.write_bit(BitTarget::Cell(cell), guard, value);
        } else if mask == u16::MAX {
            let value = self.memory.words.constant(value);
            self.memory.write_word(WordTarget::Cell(cell), guard, value);
        } else {
            for bit in (0..16).filter(|bit| mask >> bit & 1 == 1) {
                let value = Lit::constant(value >> bit & 1 == 1);
                self.memory.write_bit(BitTarget::WordBit(cell, bit), guard, value);
            }
        }
    }

    pub(super) fn is_bit(&self, cell: Cell) -> bool {
        self.program.areas[usize::from(cell.area.0)].kind == AreaKind::Bit
    }

    /// The literal that says whether an observation applies: all that was read then has the same values now. False if
    /// it read a choice of another call context, or the value of a havocked cell.
    fn matches(&mut self, reads: &[Read], at: usize) -> Lit {
        let mut all = Lit::TRUE;
        for read in reads {
            let one = match read {
                Read::Cell(cell, _, value) if self.is_bit(*cell) => {
                    let bit = self.memory.read_bit(*cell);
                    if value & 1 == 1 { bit } else { !bit }
                }
                Read::Cell(cell, mask, value) => {
                    let word = self.memory.read_word(*cell);
                    self.equals(word, *mask, *value)
                }
                Read::Condition(value) => {
                    if *value {
                        self.known.condition
                    } else {
                        !self.known.condition
                    }
                }
                Read::Choice(key, _) if key.frames != self.frames || key.cell.is_some() => {
                    Lit::FALSE
                }
                Read::Choice(key, value) => {
                    if self.memory.is_word_choice(key.choice) {
                        let word = self.word_choice(key.choice, at);
                        self.equals(word, u16::MAX, *value)
                    } else {
                        let bit = self.bit_choice(key.choice, at);
                        if value & 1 == 1 { bit } else { !bit }
                    }
                }
            };
            all = self.memory.circuit().and(all, one);
            if all == Lit::FALSE {
                break;
            }
        }
        all
    }

    fn equals(&mut self, word: Word, mask: u16, value: u16) -> Lit {
        let circuit = &mut self.memory.model.circuit;
        if mask == u16::MAX {
            return self.memory.words.in_range(circuit, word, value, value);
        }
        let bits = self.memory.words.bits(circuit, word);
        let asked = (0..16).filter(|bit| mask >> bit & 1 == 1);
        let bits = asked.map(|bit| if value >> bit & 1 == 1 { bits[bit] } else { !bits[bit] });
        circuit.all(bits.collect::<Vec<Lit>>())
    }
}
