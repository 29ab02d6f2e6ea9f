//! Choices of the kind [`ChoiceKind::Exact`]: executes their operations exactly and records the results.

use super::free::Mode;
use super::operation::run;
use super::state::{Doubt, State, Truth};
use super::trace::TracedOperation;
use super::words::{bcd, number};
use scanbound_ir::meaning::{
    Address, ChoiceKind, Count, IntegerFormat, Meaning, Observation, Operation, OperationInput,
    Outcome, Read, Shape, Target, Term,
};
use scanbound_ir::{
    AreaKind, BitTarget, Cell, ChoiceId, Logic, Region, Resolution, WordSource, WordTarget, Write,
};
use std::collections::BTreeMap;

/// The bits that an operation writes in each cell (mask) and their values.
type Written = BTreeMap<Cell, (u16, u16)>;

/// An address with its value.
#[derive(Clone, Copy)]
struct Place {
    at: i64,
    /// The first cell of the range in which the address must lie. `None`: in any range.
    within: Option<Cell>,
}

impl Place {
    fn plus(self, offset: i64) -> Option<Place> {
        Some(Place { at: self.at.checked_add(offset)?, ..self })
    }
}

/// What an operation read, and whether it accessed a cell that not each PLC has, or a cell through an address. If the
/// run is traced, also what is recorded of the operation.
#[derive(Default)]
struct Accesses {
    reads: Vec<Read>,
    needs_devices: bool,
    operation: TracedOperation,
}

impl State<'_> {
    /// The value of a choice of the kind [`ChoiceKind::Exact`] that is read: executes its operation, once in each call
    /// context. `None` if the manuals do not define the result, or if the operation reads a cell that may change at any
    /// moment.
    pub(super) fn value_of(&mut self, choice: ChoiceId, meaning: &Meaning) -> Option<u16> {
        let moment = (self.frames().clone(), choice);
        if let Some(&(value, doubt)) = self.known.get(&moment) {
            self.doubt = self.doubt.or(doubt);
            return Some(value);
        }
        let (mut reads, doubt, results) = self.execute_operation(meaning);
        self.trace_operation(choice, std::mem::take(&mut reads.operation));
        let value = results.and_then(|results| results.first()?.first().copied());
        match value {
            Some(value) => {
                self.learn(choice, reads, Outcome::Value(value));
                self.known.insert(moment, (value, doubt));
                self.doubt = self.doubt.or(doubt);
            }
            None => self.doubt = self.doubt.or(Some(self.at)),
        }
        value
    }

    /// Executes an operation and writes its results if `fired`; results of unknown operands are written as unknown.
    /// Returns false, and writes nothing, if the results are undefined, or the cells to which they go are unknown.
    pub(super) fn write_exactly(
        &mut self,
        choice: ChoiceId,
        meaning: &Meaning,
        fired: Truth,
    ) -> bool {
        let (reads, doubt, results) = self.execute_operation(meaning);
        let Some(results) = results else { return false };
        // The target cells may also depend on what the operation reads.
        let (more, place_doubt, written) = self.target_cells(meaning, &results);
        let operation = TracedOperation { to: more.operation.from, ..reads.operation };
        self.trace_operation(choice, operation);
        let Some(written) = written else { return false };
        // What is written may already be there while the rest of an operand is still read.
        let is_gradual = matches!(
            meaning.operation,
            Operation::CompareEach { .. }
                | Operation::Extreme { .. }
                | Operation::Find { .. }
                | Operation::ToDecimalText
        );
        let is_read =
            |read: &Read| matches!(read, Read::Cell(cell, ..) if written.contains_key(cell));
        if place_doubt.is_some() || is_gradual && reads.reads.iter().any(is_read) {
            return false;
        }
        let allowed = self.declared_regions(choice);
        let is_allowed = |cell: &Cell| allowed.iter().any(|region| region.contains(*cell));
        if let Some(&cell) = written.keys().find(|cell| !is_allowed(cell)) {
            match meaning.outputs.iter().any(is_indirect) {
                // The user states where such addresses lead.
                true => self.is_excluded |= fired.value || fired.doubt.is_some(),
                false => self.undeclared_writes.push((self.at, cell)),
            }
        }
        let writes = written.iter().map(|(&cell, &(mask, value))| (cell, mask, value)).collect();
        let all = Accesses {
            reads: [reads.reads, more.reads].concat(),
            needs_devices: reads.needs_devices || more.needs_devices,
            ..Accesses::default()
        };
        self.learn(choice, all, Outcome::Writes(writes));
        for (cell, (mask, value)) in written {
            self.write_bits(cell, mask, value, doubt, fired);
        }
        true
    }

    /// In a run of the model: the value of a choice that is read, if the analysis computed it or a real run observed it
    /// for the current values. `None` if the choice may have any value.
    pub(super) fn learned_value(&mut self, choice: ChoiceId) -> Option<u16> {
        let moment = (self.frames().clone(), choice);
        if let Some(&(value, _)) = self.known.get(&moment) {
            return Some(value);
        }
        if let (Some(Resolution::Exact), Some(ChoiceKind::Exact(meaning))) =
            (self.resolution(choice), self.program().kinds.get(&choice))
        {
            return self.value_of(choice, meaning);
        }
        match self.learned_now(choice)?.outcome {
            Outcome::Value(value) => {
                self.known.insert(moment, (value, None));
                Some(value)
            }
            Outcome::Writes(_) => None,
        }
    }

    /// In a run of the model: writes the result that a real run observed for the current values, for a choice that
    /// havocs cells. Returns false if there is none.
    pub(super) fn write_learned(&mut self, choice: ChoiceId) -> bool {
        let Some(Observation { outcome: Outcome::Writes(writes), .. }) = self.learned_now(choice)
        else {
            return false;
        };
        for (cell, mask, value) in writes {
            self.write_bits(cell, mask, value, None, Truth::TRUE);
        }
        true
    }

    /// What a real run observed about a choice in this call context, if all values that it read then are the current
    /// ones.
    fn learned_now(&mut self, choice: ChoiceId) -> Option<Observation> {
        if self.learned.is_empty() {
            return None;
        }
        let facts = self.learned.get(&(self.frames().to_vec(), choice))?.clone();
        facts.into_iter().filter(|fact| !fact.needs_devices).find(|fact| {
            fact.reads.iter().all(|read| match read {
                Read::Cell(cell, mask, value) => self.read(*cell) & mask == *value,
                Read::Condition(value) => self.condition.value == *value,
                Read::Choice(key, value) => {
                    key.frames == **self.frames()
                        && key.cell.is_none()
                        && self.choose(key.choice, AreaKind::Word) == *value
                }
            })
        })
    }

    /// The regions that the effects of the current instruction havoc with this choice.
    fn declared_regions(&self, choice: ChoiceId) -> Vec<Region> {
        let effects = self.program().instructions[self.at].effects.iter();
        effects
            .filter_map(|effect| match effect.write {
                Write::Havoc(region, own) if own == choice => Some(region),
                _ => None,
            })
            .collect()
    }

    fn learn(&mut self, choice: ChoiceId, accesses: Accesses, learned: Outcome) {
        // Unknown inputs do not matter here: the fact states the result for exactly these input values.
        let Accesses { mut reads, needs_devices, .. } = accesses;
        reads.sort();
        reads.dedup();
        let fact = Observation { reads, outcome: learned, needs_devices };
        let facts = self.learned.entry((self.frames().to_vec(), choice)).or_default();
        if !facts.contains(&fact) {
            facts.push(fact);
        }
    }

    /// Executes the operation. Returns what it read, the instruction because of which an input is unknown, and the
    /// results; `None` if the manuals do not define them.
    fn execute_operation(&mut self, meaning: &Meaning) -> (Accesses, Doubt, Option<Vec<Vec<u16>>>) {
        self.record_reads(|state| {
            let inputs: Option<Vec<Vec<u16>>> =
                meaning.inputs.iter().map(|operand| state.operand(operand)).collect();
            let inputs = inputs?;
            if let Some(trace) = &mut state.trace {
                trace.operation.inputs.clone_from(&inputs);
            }
            run(&meaning.operation, &inputs)
        })
    }

    fn trace_operation(&mut self, choice: ChoiceId, operation: TracedOperation) {
        if let Some(trace) = &mut self.trace {
            trace.operations.insert((trace.event, choice), operation);
        }
    }

    /// Records where an operand or a target begins that is a list at an address.
    fn trace_list(&mut self, address: Option<&Address>) {
        if self.trace.is_none() {
            return;
        }
        let first = address.and_then(|address| {
            let place = self.address(address)?;
            self.cell_at(address, place)
        });
        if let Some(trace) = &mut self.trace {
            trace.operation.from.push(first);
        }
    }

    /// Evaluates `work`. Also returns what it read, and the instruction because of which its result is unknown. The
    /// result is `None` if `work` read a cell that may change at any moment.
    fn record_reads<T>(
        &mut self,
        work: impl FnOnce(&mut Self) -> Option<T>,
    ) -> (Accesses, Doubt, Option<T>) {
        let outer = (self.reading.replace(Vec::new()), self.doubt.take());
        let traced = self.trace.as_mut().map(|trace| std::mem::take(&mut trace.operation));
        let flags = (self.changing, self.needs_devices);
        (self.changing, self.needs_devices) = (false, false);
        let done = work(self).filter(|_| !self.changing);
        let reads = self.reading.take().unwrap_or_default();
        let (doubt, needs_devices) = (self.doubt, self.needs_devices);
        (self.reading, self.doubt) = outer;
        (self.changing, self.needs_devices) = flags;
        let operation = match (&mut self.trace, traced) {
            (Some(trace), Some(outer)) => std::mem::replace(&mut trace.operation, outer),
            _ => TracedOperation::default(),
        };
        (Accesses { reads, needs_devices, operation }, doubt, done)
    }

    fn operand(&mut self, operand: &OperationInput) -> Option<Vec<u16>> {
        self.trace_list(match operand {
            OperationInput::Run(address, ..) => Some(address),
            _ => None,
        });
        match operand {
            OperationInput::Words(sources) => {
                Some(sources.iter().map(|&source| self.word(source)).collect())
            }
            OperationInput::Number(number) => Some(self.number(number)),
            OperationInput::Truth(logic) => {
                let condition = self.condition;
                if reads_condition(logic)
                    && let Some(reads) = &mut self.reading
                {
                    reads.push(Read::Condition(condition.value));
                }
                let truth = self.logic(logic, condition);
                self.doubt = self.doubt.or(truth.doubt);
                Some(vec![u16::from(truth.value)])
            }
            OperationInput::Bits(sources) => {
                Some(sources.iter().map(|&source| u16::from(self.bit(source))).collect())
            }
            OperationInput::Run(address, shape, count) => {
                let from = self.address(address)?;
                let most = self.count(count)?;
                let is_text = matches!(count, Count::Text(_));
                let mut list = Vec::new();
                for n in 0..most {
                    let word = self.element(address, from, *shape, n, most)?;
                    list.push(word);
                    if is_text && (word & 0xFF == 0 || word >> 8 == 0) {
                        return Some(list);
                    }
                }
                (!is_text).then_some(list)
            }
        }
    }

    fn count(&mut self, count: &Count) -> Option<u32> {
        match count {
            Count::Exactly(count) | Count::Text(count) => Some(*count),
            Count::Of { term, least, most } => {
                let count = u32::try_from(self.term(term)?).ok()?;
                (*least..=*most).contains(&count).then_some(count)
            }
        }
    }

    /// Whether the PLC certainly has all cells of a list of words at an address. What the address and the count depend
    /// on counts as read.
    pub(super) fn reaches(&mut self, address: &Address, count: &Count) -> bool {
        let needs_devices = self.needs_devices;
        let found = self.address(address).and_then(|from| {
            if let Some(last) = self.count(count)?.checked_sub(1) {
                self.cell_at(address, from)?;
                self.cell_at(address, from.plus(last.into())?)?;
            }
            Some(())
        });
        self.needs_devices = needs_devices;
        found.is_some()
    }

    /// The value of an address. `None` if a term is not valid BCD or certainly an address, or if the sum is too large.
    fn address(&mut self, address: &Address) -> Option<Place> {
        let mut place = Place { at: address.base, within: None };
        for term in &address.terms {
            place = place.plus(self.term(term)?)?;
            if term.format == IntegerFormat::Address {
                place.within = Some(self.addressed_range(term)?);
            }
        }
        Some(place)
    }

    /// The first cell of the range to which an address leads. `None` if it is not certain that the term is an address.
    fn addressed_range(&self, term: &Term) -> Option<Cell> {
        match (self.mode, &term.words[..]) {
            (Mode::Real, &[WordSource::Cell(low), WordSource::Cell(high)])
                if high == low.plus(1) =>
            {
                self.pointers.get(&low).copied()
            }
            _ => None,
        }
    }

    fn term(&mut self, term: &Term) -> Option<i64> {
        let doubt = self.doubt;
        let words: Vec<u16> = term.words.iter().map(|&word| self.word(word)).collect();
        let value = match term.format {
            IntegerFormat::Signed => number(&words, true)?,
            IntegerFormat::Unsigned => number(&words, false)?,
            IntegerFormat::Bcd => bcd(&words)?,
            IntegerFormat::Address => {
                self.addressed_range(term)?;
                // The number is unknown, but not the cell to which it leads.
                self.doubt = doubt;
                self.needs_devices = true;
                number(&words, false)?
            }
        };
        i64::try_from(value).ok()?.checked_mul(term.factor)
    }

    /// Word number `n` of a list of `count` words that starts at an address. `None` if it is not within the address's
    /// ranges.
    fn element(
        &mut self,
        address: &Address,
        from: Place,
        shape: Shape,
        n: u32,
        count: u32,
    ) -> Option<u16> {
        let cells = cells_of(shape, n, count);
        let mut word = 0;
        for (place, (offset, bit)) in cells.into_iter().enumerate() {
            let cell = self.cell_at(address, from.plus(offset)?)?;
            word |= match bit {
                None => self.read(cell),
                Some(bit) => (self.read_masked(cell, 1 << bit) >> bit & 1) << place,
            };
        }
        Some(word)
    }

    /// The bits that the results write in each cell, and the words that the target addresses read. `None` if an address
    /// is outside its ranges.
    fn target_cells(
        &mut self,
        meaning: &Meaning,
        results: &[Vec<u16>],
    ) -> (Accesses, Doubt, Option<Written>) {
        self.record_reads(|state| {
            let mut written = Written::new();
            for (target, result) in meaning.outputs.iter().zip(results) {
                state.place(target, result, &mut written)?;
            }
            Some(written)
        })
    }

    fn place(&mut self, target: &Target, result: &[u16], written: &mut Written) -> Option<()> {
        self.trace_list(match target {
            Target::Run(address, _) => Some(address),
            _ => None,
        });
        match target {
            Target::Nowhere => {}
            Target::Words(targets) => {
                for (target, &word) in targets.iter().zip(result) {
                    match *target {
                        WordTarget::Cell(cell) => add_bits(written, cell, u16::MAX, word),
                        WordTarget::Bits { first, count } => {
                            for n in 0..count {
                                let cell = first.plus(u32::from(n));
                                add_bits(written, cell, u16::MAX, word >> n & 1);
                            }
                        }
                        WordTarget::Discard => {}
                    }
                }
            }
            Target::Bits(targets) => {
                for (target, &bit) in targets.iter().zip(result) {
                    match *target {
                        BitTarget::Cell(cell) => add_bits(written, cell, u16::MAX, bit & 1),
                        BitTarget::WordBit(cell, n) => {
                            add_bits(written, cell, 1 << n, (bit & 1) << n)
                        }
                    }
                }
            }
            Target::Run(address, shape) => {
                let from = self.address(address)?;
                let count = u32::try_from(result.len()).ok()?;
                for (n, &word) in result.iter().enumerate() {
                    let cells = cells_of(*shape, n as u32, count);
                    for (place, (offset, bit)) in cells.into_iter().enumerate() {
                        let cell = self.cell_at(address, from.plus(offset)?)?;
                        match bit {
                            None => add_bits(written, cell, u16::MAX, word),
                            Some(_) if self.is_bit(cell) => {
                                add_bits(written, cell, u16::MAX, word >> place & 1);
                            }
                            Some(bit) => {
                                add_bits(written, cell, 1 << bit, (word >> place & 1) << bit)
                            }
                        }
                    }
                }
            }
        }
        Some(())
    }

    /// The cell at an address. `None` if the PLC does not have it; in a run of the model, if not each PLC has it.
    fn cell_at(&mut self, address: &Address, place: Place) -> Option<Cell> {
        let is_real = self.mode == Mode::Real;
        let (cell, is_certain) = address.ranges.iter().find_map(|range| {
            if place.within.is_some_and(|first| first != range.first) {
                return None;
            }
            let offset = u32::try_from(place.at.checked_sub(range.from)?).ok()?;
            let is_certain = offset < range.count;
            let exists = is_certain || is_real && offset < range.chosen;
            exists.then(|| (range.first.plus(offset), is_certain))
        })?;
        self.needs_devices |= !is_certain;
        Some(cell)
    }

    fn is_bit(&self, cell: Cell) -> bool {
        self.program().areas[usize::from(cell.area.0)].kind == AreaKind::Bit
    }
}

/// Where word `n` of a list of `count` words is stored: the offset from the address, and the bit of that cell. A word
/// packed from bits has one entry per bit.
fn cells_of(shape: Shape, n: u32, count: u32) -> Vec<(i64, Option<u8>)> {
    match shape {
        Shape::Cells => vec![(i64::from(n), None)],
        Shape::WordBits(first) => {
            let bit = u32::from(first) + n;
            vec![(i64::from(bit / 16), Some((bit % 16) as u8))]
        }
        Shape::Packed(last) => {
            let bits = if n + 1 == count { u32::from(last) } else { 16 };
            (0..bits).map(|bit| (i64::from(16 * n + bit), Some(0))).collect()
        }
    }
}

/// Whether a result is written through an address that words hold.
fn is_indirect(target: &Target) -> bool {
    match target {
        Target::Run(address, _) => {
            address.terms.iter().any(|term| term.format == IntegerFormat::Address)
        }
        Target::Words(_) | Target::Bits(_) | Target::Nowhere => false,
    }
}

fn reads_condition(logic: &Logic) -> bool {
    match logic {
        Logic::Condition => true,
        Logic::Not(inner) => reads_condition(inner),
        Logic::All(parts) | Logic::Any(parts) => parts.iter().any(reads_condition),
        Logic::Const(_) | Logic::Bit(_) | Logic::Compare(_) => false,
    }
}

fn add_bits(written: &mut Written, cell: Cell, mask: u16, value: u16) {
    let held = written.entry(cell).or_default();
    *held = (held.0 | mask, held.1 & !mask | value & mask);
}
