//! Computes the results of operations whose operands are known, in place of any values. This matters most for indexed
//! devices whose index is known in the current call and iteration.

use super::operation;
use super::run::Run;
use super::settings::Purpose;
use super::word::{Word, Words};
use scanbound_base::word_interval::{WordInterval, signed_ranges};
use scanbound_ir::meaning::{
    Address, ChoiceKind, Count, IntegerFormat, Meaning, Operation, OperationInput, Shape, Target,
    Term, Unary,
};
use scanbound_ir::{
    BitSource, BitTarget, Cell, ChoiceId, IndexedWrite, Length, Logic, Number, Region, Resolution,
    WordSource, WordTarget,
};
use scanbound_model::Lit;
use std::sync::Arc;

/// The largest number of values that one term of a computed address may have.
const MAX_CASES: usize = 8;
/// The largest number of combinations of the possible values of two words or terms; with more, nothing is computed.
const MAX_PAIRS: usize = 64;
/// The largest number of elements of an array among which an access is followed; with more, it is not followed.
const MAX_ELEMENTS: usize = 256;
/// The largest number of words of a list that is followed word by word.
const MAX_WORDS: usize = 64;

/// Possible values, each with the condition under which it is the actual one; exactly one of the conditions is true.
type Cases<T> = Vec<(Lit, T)>;

/// The target of an operation's result: fixed cells or bits, or possible locations of a computed address.
enum ResolvedTarget<'p> {
    At(&'p Target),
    Cells(Vec<(Lit, Vec<WordLocation>)>),
}

/// The location of one word of a list: a cell, a bit of a word, or bit cells, least significant first.
enum WordLocation {
    Cell(Cell),
    WordBit(Cell, u8),
    Bits(Vec<Cell>),
}

impl<'p> Run<'p> {
    /// The first word of the result of a choice's operation if the choice is read now. `None` if it has no known
    /// operation, the operands are not known well enough, or the result is not defined in every case.
    pub(super) fn resolved_word(&mut self, choice: ChoiceId, at: usize) -> Option<Word> {
        let program = self.program;
        let Some(ChoiceKind::Exact(meaning)) = program.kinds.get(&choice) else { return None };
        let (results, settled) = self.execute_operation(choice, meaning, at)?;
        let word = *results.first()?.first().filter(|_| settled == Lit::TRUE)?;
        Arc::make_mut(&mut self.memory.model.resolutions).record(
            &self.frames,
            choice,
            Resolution::Exact,
        );
        Some(word)
    }

    /// Writes the results of a choice's operation under `guard`, where they are known. Returns the part of the guard
    /// under which the results are unknown; `None`, and nothing written, if they are always unknown.
    pub(super) fn write_resolved(
        &mut self,
        choice: ChoiceId,
        guard: Lit,
        at: usize,
    ) -> Option<Lit> {
        let program = self.program;
        let Some(ChoiceKind::Exact(meaning)) = program.kinds.get(&choice) else { return None };
        if meaning.outputs.is_empty() {
            return None;
        }
        let (results, mut settled) = self.execute_operation(choice, meaning, at)?;
        // An output without a result may have any value.
        let mut without_result = meaning.outputs.iter().skip(results.len());
        if without_result.any(|target| *target != Target::Nowhere) {
            return None;
        }
        let mut places: Vec<ResolvedTarget<'p>> = Vec::with_capacity(results.len());
        for (target, result) in meaning.outputs.iter().zip(&results) {
            let (place, known) =
                self.target_locations(target, result.len(), self.follows(choice), at)?;
            settled = self.memory.circuit().and(settled, known);
            places.push(place);
        }
        let rest = self.memory.circuit().and(guard, !settled);
        let guard = self.memory.circuit().and(guard, settled);
        Arc::make_mut(&mut self.memory.model.resolutions).record(
            &self.frames,
            choice,
            Resolution::Exact,
        );
        for (place, result) in places.into_iter().zip(results) {
            match place {
                ResolvedTarget::At(target) => self.write_target(target, guard, &result),
                ResolvedTarget::Cells(cases) => {
                    for (holds, spots) in cases {
                        let guard = self.memory.circuit().and(guard, holds);
                        for (spot, &word) in spots.iter().zip(&result) {
                            self.put_spot(spot, guard, word);
                        }
                    }
                }
            }
        }
        Some(rest)
    }

    /// Whether the operation of a choice is computed from symbolic operands even if these have no known values
    /// (`Program::always_followed`).
    fn follows(&self, choice: ChoiceId) -> bool {
        self.program.always_followed.contains(&choice)
    }

    /// The parts of `region` that an indexed write may reach in the current call context; `region` itself if they are
    /// not fewer. A write beyond the end of its area reaches nothing (see README, what is not modelled).
    pub(super) fn reached(&mut self, choice: ChoiceId, region: Region, at: usize) -> Vec<Region> {
        let program = self.program;
        let indexed = program.indexed.get(&choice).filter(|indexed| indexed.shares_area(region));
        let Some(indexed) = indexed else { return vec![region] };
        // All regions are written with the value that the index has before the first write.
        let before = self.known.reach.take().filter(|(own, _)| *own == choice);
        let (_, stretches) = before.unwrap_or_else(|| (choice, self.reach(indexed, at)));
        self.known.reach = Some((choice, stretches.clone()));
        let Some(stretches) = stretches else { return vec![region] };
        let area = indexed.first.area;
        let closer: Vec<Region> = stretches
            .into_iter()
            .map(|(index, count)| Region::Range { first: Cell { area, index }, count })
            .collect();
        let parts = region.intersections(&closer);
        let cells = |part: &Region| match part {
            Region::Range { count, .. } => u64::from(*count),
            Region::Area(_) | Region::Everything => u64::MAX,
        };
        if parts.iter().map(cells).fold(0, u64::saturating_add) >= cells(&region) {
            return vec![region];
        }
        Arc::make_mut(&mut self.memory.model.resolutions).record(
            &self.frames,
            choice,
            Resolution::Within(closer),
        );
        parts
    }

    /// The ranges of cells that an indexed write may reach, each with its first index and its number of cells. `None`
    /// if the index or the length is unknown, if a cell would have a negative index or one that does not fit into 32
    /// bits, or in an interrupt routine.
    fn reach(&mut self, indexed: &IndexedWrite, at: usize) -> Option<Vec<(u32, u32)>> {
        if self.interrupts() {
            return None;
        }
        let mut may_be = Vec::new();
        for reading in &indexed.indices {
            let index = self.may_hold(reading, at)?;
            let found = signed_ranges(&index);
            if found.is_empty() {
                return None;
            }
            may_be.extend(found);
        }
        // If it is unknown how the index is interpreted, use the range from the least to the largest possible value.
        if let [_, _, ..] = indexed.indices[..] {
            let low = may_be.iter().map(|&(low, _)| low).min()?;
            let high = may_be.iter().map(|&(_, high)| high).max()?;
            may_be = vec![(low, high)];
        }
        if let Some((least, largest)) = indexed.stated {
            let within = |(low, high): (i64, i64)| (low.max(least), high.min(largest));
            may_be = may_be.into_iter().map(within).filter(|(low, high)| low <= high).collect();
            if may_be.is_empty() {
                // No scan reaches this with an index in the stated range.
                may_be.push((least, largest));
            }
        }
        let more = match indexed.length {
            Length::Exactly(count) => i64::from(count),
            Length::Counted(word, unit) => {
                self.may_hold(&[word], at)?[0].unsigned().1.checked_mul(unit.into())?
            }
            Length::Unknown => return None,
        };
        let first = i64::from(indexed.first.index);
        let cells = |(low, high): (i64, i64)| {
            let from = u32::try_from(first.checked_add(low)?).ok()?;
            let count = u32::try_from((high - low).checked_add(more.max(1))?).ok()?;
            from.checked_add(count)?;
            Some((from, count))
        };
        (!may_be.is_empty()).then(|| may_be.into_iter().map(cells).collect())?
    }

    /// Whether an interrupt routine is being executed. It may run at any moment, so what it reads is unknown.
    fn interrupts(&self) -> bool {
        self.frames.first().is_some_and(|frame| {
            self.program.interrupts.iter().any(|interrupt| interrupt.entry == frame.at)
        })
    }

    /// The results of an operation, each a list of words, and the literal that says whether they are defined. `None` if
    /// the inputs are not known well enough, if the operation is not supported, or in an interrupt routine.
    fn execute_operation(
        &mut self,
        choice: ChoiceId,
        meaning: &Meaning,
        at: usize,
    ) -> Option<(Vec<Vec<Word>>, Lit)> {
        let follows = self.follows(choice);
        if self.interrupts() || !(follows || is_supported(&meaning.operation)) {
            return None;
        }
        let mut inputs: Vec<Vec<Word>> = Vec::with_capacity(meaning.inputs.len());
        let mut settled = Lit::TRUE;
        for operand in &meaning.inputs {
            let (words, known) = self.operand(operand, follows, at)?;
            settled = self.memory.circuit().and(settled, known);
            inputs.push(words);
        }
        if !follows || meaning.operation == Operation::Copy {
            return Some((self.operate(&meaning.operation, inputs)?, settled));
        }
        if let Some(results) = self.operate(&meaning.operation, inputs.clone()) {
            return Some((results, settled));
        }
        let wanted = match meaning.outputs.first() {
            Some(Target::Words(targets)) => {
                targets.iter().rposition(|target| *target != WordTarget::Discard)? + 1
            }
            _ => inputs.first()?.len(),
        };
        let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
        let (result, known) =
            operation::results(words, circuit, &meaning.operation, &inputs, wanted)?;
        settled = circuit.and(settled, known);
        Some((vec![result], settled))
    }

    fn operate(&mut self, operation: &Operation, inputs: Vec<Vec<Word>>) -> Option<Vec<Vec<Word>>> {
        let numbers = |words: &Words, input: &[Word]| -> Option<i64> {
            let known = input.iter().map(|&word| words.as_constant(word));
            signed(&known.collect::<Option<Vec<u16>>>()?)
        };
        let words = &mut self.memory.words;
        match (operation, &inputs[..]) {
            (Operation::Copy, _) => Some(inputs),
            (Operation::Repeat, [list, count]) => {
                let count = usize::try_from(numbers(words, count)?).ok().filter(|&n| n > 0)?;
                let all = count.checked_mul(list.len()).filter(|&all| all <= MAX_WORDS)?;
                Some(vec![list.iter().copied().cycle().take(all).collect()])
            }
            (Operation::Multiply { signed: true }, [a, b])
                if a.len() == b.len() && a.len() <= 2 =>
            {
                let product = i128::from(numbers(words, a)?) * i128::from(numbers(words, b)?);
                let word = |place| words.constant((product >> (16 * place)) as u16);
                Some(vec![(0..2 * a.len()).map(word).collect()])
            }
            (Operation::Divide { signed: true }, [a, b]) if a.len() == b.len() && a.len() <= 2 => {
                let (of, by) = (numbers(words, a)?, numbers(words, b)?);
                let least = -(1i64 << (16 * a.len() - 1));
                if by == 0 || (of == least && by == -1) {
                    return None;
                }
                let mut split = |number: i64| -> Vec<Word> {
                    (0..a.len()).map(|n| words.constant((number >> (16 * n)) as u16)).collect()
                };
                Some(vec![split(of / by), split(of % by)])
            }
            (Operation::Resize(to), [from]) => {
                let (number, bits) = (numbers(words, from)?, 16 * u32::from(*to));
                let fits =
                    bits >= 64 || (-(1i64 << (bits - 1))..1i64 << (bits - 1)).contains(&number);
                let word = |n: u8| words.constant((number >> (16 * n.min(3))) as u16);
                fits.then(|| vec![(0..*to).map(word).collect()])
            }
            (Operation::Each(Unary::Negate), [a]) if a.len() <= 2 => {
                let number = numbers(words, a)?.wrapping_neg();
                let word = |n| words.constant((number >> (16 * n)) as u16);
                Some(vec![(0..a.len()).map(word).collect()])
            }
            _ => None,
        }
    }

    /// The words of an operand, and the literal that says whether they are valid. `None` if something besides the
    /// program may change it in mid-scan, it is longer than [`MAX_WORDS`], or its address or length is unknown.
    fn operand(
        &mut self,
        operand: &OperationInput,
        follows: bool,
        at: usize,
    ) -> Option<(Vec<Word>, Lit)> {
        let words = match operand {
            OperationInput::Words(sources) => {
                if sources.len() > MAX_WORDS || !sources.iter().all(|&one| self.is_stable_word(one))
                {
                    return None;
                }
                sources.iter().map(|&source| self.word(source, at)).collect()
            }
            OperationInput::Bits(sources) => {
                if sources.len() > MAX_WORDS || !sources.iter().all(|&one| self.is_steady_bit(one))
                {
                    return None;
                }
                let bit = |run: &mut Self, source| run.logic(&Logic::Bit(source), Lit::TRUE, at);
                sources
                    .iter()
                    .map(|&source| {
                        let lit = bit(self, source);
                        self.bit_word(lit)
                    })
                    .collect()
            }
            OperationInput::Number(number) => {
                self.is_steady_number(number).then(|| self.number(number, at))?
            }
            OperationInput::Truth(logic) => {
                if !self.program.volatile.is_empty() {
                    return None;
                }
                let condition = self.known.condition();
                let truth = self.logic(logic, condition, at);
                vec![self.bit_word(truth)]
            }
            OperationInput::Run(address, shape, count) => {
                let count = match count {
                    Count::Exactly(count) => *count,
                    Count::Of { term, least, most } => match self.term(term, MAX_CASES, at)?[..] {
                        [(_, count)] => u32::try_from(count)
                            .ok()
                            .filter(|count| (*least..=*most).contains(count))?,
                        _ => return None,
                    },
                    Count::Text(_) => return None,
                };
                let mut found: Option<Vec<Word>> = None;
                let (cases, known) =
                    self.locations(address, *shape, count as usize, follows, at)?;
                for (holds, spots) in cases {
                    let words: Option<Vec<Word>> =
                        spots.iter().map(|spot| self.read_spot(spot)).collect();
                    let words = words?;
                    found = Some(match found {
                        None => words,
                        Some(before) => {
                            let both = words.into_iter().zip(before);
                            both.map(|(now, before)| self.memory.words.either(holds, now, before))
                                .collect()
                        }
                    });
                }
                return Some((found?, known));
            }
        };
        Some((words, Lit::TRUE))
    }

    /// The possible locations of a list of `count` words at an address, each with the literal that says whether it is
    /// the actual one; and the literal that says whether one of them is. `None` if the address is unknown, or has a
    /// value outside its ranges, or `count` is more than [`MAX_WORDS`].
    fn locations(
        &mut self,
        address: &Address,
        shape: Shape,
        count: usize,
        follows: bool,
        at: usize,
    ) -> Option<(Cases<Vec<WordLocation>>, Lit)> {
        if count > MAX_WORDS {
            return None;
        }
        let sums = self.address(address, at);
        let is_partial = sums.is_none();
        let sums = match sums {
            Some(sums) => sums,
            None if follows && shape == Shape::Cells => self.elements(address, count, at)?,
            None => return None,
        };
        let is_lower = self.purpose == Purpose::LowerBound;
        let place = |(holds, from): (Lit, i64)| {
            let cell = |offset: usize| {
                let at = from.checked_add(i64::try_from(offset).ok()?)?;
                address.ranges.iter().find_map(|stretch| {
                    let offset = u32::try_from(at.checked_sub(stretch.from)?).ok()?;
                    let count = if is_lower { stretch.chosen } else { stretch.count };
                    (offset < count).then(|| stretch.first.plus(offset))
                })
            };
            let spot = |n: usize| match shape {
                Shape::Cells => cell(n).map(WordLocation::Cell),
                Shape::WordBits(first) => {
                    let bit = usize::from(first) + n;
                    Some(WordLocation::WordBit(cell(bit / 16)?, (bit % 16) as u8))
                }
                Shape::Packed(last) => {
                    let bits = if n + 1 == count { usize::from(last) } else { 16 };
                    let cells: Option<Vec<Cell>> =
                        (0..bits).map(|bit| cell(16 * n + bit)).collect();
                    Some(WordLocation::Bits(cells?))
                }
            };
            Some((holds, (0..count).map(spot).collect::<Option<Vec<WordLocation>>>()?))
        };
        let found: Option<Cases<Vec<WordLocation>>> = sums.into_iter().map(place).collect();
        let found = found?;
        let known = match is_partial {
            true => self.memory.circuit().any(found.iter().map(|(holds, _)| *holds)),
            false => Lit::TRUE,
        };
        Some((found, known))
    }

    /// The addresses at which an element of `count` cells lies completely inside the address ranges, each with the
    /// literal that says whether it is the actual one. `None` if the address is not one positive multiple of a signed
    /// index, or there are more than [`MAX_ELEMENTS`].
    fn elements(&mut self, address: &Address, count: usize, at: usize) -> Option<Cases<i64>> {
        let [term] = &address.terms[..] else { return None };
        if term.format != IntegerFormat::Signed
            || term.factor <= 0
            || !term.words.iter().all(|&word| self.is_stable_word(word))
        {
            return None;
        }
        let index: Vec<Word> = term.words.iter().map(|&word| self.word(word, at)).collect();
        let mut found = Vec::new();
        for stretch in &address.ranges {
            let last = i64::from(stretch.count).checked_sub(i64::try_from(count).ok()?)?;
            for from in stretch.from..=stretch.from.checked_add(last)? {
                let above = from.checked_sub(address.base)?;
                if above % term.factor != 0 {
                    continue;
                }
                if found.len() >= MAX_ELEMENTS {
                    return None;
                }
                let number = above / term.factor;
                let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
                let parts: Vec<Lit> = index
                    .iter()
                    .enumerate()
                    .map(|(place, &word)| {
                        let value = (number >> (16 * place)) as u16;
                        words.in_range(circuit, word, value, value)
                    })
                    .collect();
                let fits = index.len() > 1 || i16::try_from(number).is_ok();
                if fits {
                    found.push((circuit.all(parts), from));
                }
            }
        }
        Some(found)
    }

    fn address(&mut self, address: &Address, at: usize) -> Option<Cases<i64>> {
        let mut sums = vec![(Lit::TRUE, address.base)];
        for term in &address.terms {
            let more = self.term(term, MAX_CASES, at)?;
            sums = self.all_pairs(&sums, &more, |sum, more| sum.checked_add(more))?;
        }
        Some(sums)
    }

    fn all_pairs(
        &mut self,
        first: &Cases<i64>,
        second: &Cases<i64>,
        join: impl Fn(i64, i64) -> Option<i64>,
    ) -> Option<Cases<i64>> {
        if first.len() * second.len() > MAX_PAIRS {
            return None;
        }
        let mut all = Vec::with_capacity(first.len() * second.len());
        for &(one, a) in first {
            for &(other, b) in second {
                all.push((self.memory.circuit().and(one, other), join(a, b)?));
            }
        }
        Some(all)
    }

    fn term(&mut self, term: &Term, most: usize, at: usize) -> Option<Cases<i64>> {
        let is_signed = match term.format {
            IntegerFormat::Signed => true,
            IntegerFormat::Unsigned => false,
            IntegerFormat::Address if self.purpose == Purpose::LowerBound => false,
            IntegerFormat::Bcd | IntegerFormat::Address => return None,
        };
        let numbers = self.numbers(&term.words, is_signed, most, at)?;
        numbers.into_iter().map(|(holds, n)| Some((holds, n.checked_mul(term.factor)?))).collect()
    }

    /// For each of these words, an interval that contains its values where the current instruction is executed. `None`
    /// if something besides the program may change a word in mid-scan.
    pub(super) fn may_hold(
        &mut self,
        sources: &[WordSource],
        at: usize,
    ) -> Option<Vec<WordInterval>> {
        let mut found = Vec::with_capacity(sources.len());
        for &source in sources {
            if !self.is_stable_word(source) {
                return None;
            }
            let word = self.word(source, at);
            let (words, circuit) = (&self.memory.words, &self.memory.model.circuit);
            found.push(self.known.span(circuit, words, word));
        }
        Some(found)
    }

    /// The possible values of a number in words, low word first. `None` if there are more than `most`, or a word is
    /// unknown.
    fn numbers(
        &mut self,
        sources: &[WordSource],
        is_signed: bool,
        most: usize,
        at: usize,
    ) -> Option<Cases<i64>> {
        if !sources.iter().all(|&source| self.is_stable_word(source)) {
            return None;
        }
        let mut all = vec![(Lit::TRUE, 0i64)];
        for (place, &source) in sources.iter().enumerate() {
            let word = self.word(source, at);
            let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
            let given = self.known.implications(circuit, words);
            let cases = given.possible_values(circuit, words, word, most)?;
            let is_top = place + 1 == sources.len();
            let cases = cases.into_iter().map(|(holds, value)| {
                let value =
                    if is_top && is_signed { i64::from(value.cast_signed()) } else { value.into() };
                (holds, value << (16 * place))
            });
            let cases = cases.collect();
            all = self.all_pairs(&all, &cases, i64::checked_add)?;
        }
        (all.len() <= most).then_some(all)
    }

    fn read_spot(&mut self, spot: &WordLocation) -> Option<Word> {
        let is_stable = match spot {
            WordLocation::Cell(cell) | WordLocation::WordBit(cell, _) => self.is_stable(*cell),
            WordLocation::Bits(cells) => cells.iter().all(|&cell| self.is_stable(cell)),
        };
        if !is_stable {
            return None;
        }
        Some(match spot {
            WordLocation::Cell(cell) if self.is_bit(*cell) => {
                let bit = self.simplified_bit(*cell);
                self.bit_word(bit)
            }
            WordLocation::Cell(cell) => self.simplified_word(*cell),
            WordLocation::WordBit(cell, bit) => {
                let word = self.simplified_word(*cell);
                let bit =
                    self.memory.words.bits(&mut self.memory.model.circuit, word)[usize::from(*bit)];
                self.bit_word(bit)
            }
            WordLocation::Bits(cells) => {
                let mut bits = [Lit::FALSE; 16];
                for (bit, &cell) in bits.iter_mut().zip(cells) {
                    *bit = self.simplified_bit(cell);
                }
                self.memory.words.of_bits(&self.memory.model.circuit, bits)
            }
        })
    }

    /// The possible locations of a target, and the literal that says whether one of them is the actual one. `None` if
    /// the target has a computed address whose locations are not followed.
    fn target_locations(
        &mut self,
        target: &'p Target,
        count: usize,
        follows: bool,
        at: usize,
    ) -> Option<(ResolvedTarget<'p>, Lit)> {
        match target {
            Target::Run(address, shape) => {
                let (cases, known) = self.locations(address, *shape, count, follows, at)?;
                Some((ResolvedTarget::Cells(cases), known))
            }
            target => Some((ResolvedTarget::At(target), Lit::TRUE)),
        }
    }

    fn write_target(&mut self, target: &Target, guard: Lit, result: &[Word]) {
        match target {
            Target::Words(targets) => {
                for (&target, &word) in targets.iter().zip(result) {
                    self.memory.write_word(target, guard, word);
                }
            }
            Target::Bits(targets) => {
                for (&target, &word) in targets.iter().zip(result) {
                    let bit = self.memory.words.bits(&mut self.memory.model.circuit, word)[0];
                    self.memory.write_bit(target, guard, bit);
                }
            }
            Target::Run(..) | Target::Nowhere => {}
        }
    }

    fn put_spot(&mut self, spot: &WordLocation, guard: Lit, word: Word) {
        match spot {
            WordLocation::Cell(cell) if !self.is_bit(*cell) => {
                self.memory.write_word(WordTarget::Cell(*cell), guard, word);
                return;
            }
            _ => {}
        }
        let bits = self.memory.words.bits(&mut self.memory.model.circuit, word);
        match spot {
            WordLocation::Cell(cell) => {
                self.memory.write_bit(BitTarget::Cell(*cell), guard, bits[0])
            }
            WordLocation::WordBit(cell, bit) => {
                self.memory.write_bit(BitTarget::WordBit(*cell, *bit), guard, bits[0]);
            }
            WordLocation::Bits(cells) => {
                for (&cell, bit) in cells.iter().zip(bits) {
                    self.memory.write_bit(BitTarget::Cell(cell), guard, bit);
                }
            }
        }
    }

    /// A word that is 1 if the bit is on, else 0.
    fn bit_word(&mut self, bit: Lit) -> Word {
        let mut bits = [Lit::FALSE; 16];
        bits[0] = bit;
        self.memory.words.of_bits(&self.memory.model.circuit, bits)
    }

    /// Whether nothing but the program changes the cell during a scan.
    fn is_stable(&self, cell: Cell) -> bool {
        !self.program.volatile.iter().any(|region| region.contains(cell))
    }

    fn is_steady_bit(&self, source: BitSource) -> bool {
        match source {
            BitSource::Cell(cell) | BitSource::WordBit(cell, _) => self.is_stable(cell),
            BitSource::Const(_) | BitSource::Free(_) => true,
        }
    }

    fn is_stable_word(&self, source: WordSource) -> bool {
        match source {
            WordSource::Cell(cell) => self.is_stable(cell),
            WordSource::Bits { first, count } => {
                (0..count).all(|n| self.is_stable(first.plus(n.into())))
            }
            WordSource::Const(_) | WordSource::Free(_) => true,
        }
    }

    fn is_steady_number(&self, number: &Number) -> bool {
        number.words().all(|word| self.is_stable_word(word))
    }
}

/// Whether `operate` can compute the operation from constant operands. If not, its operands need not be examined.
fn is_supported(operation: &Operation) -> bool {
    matches!(
        operation,
        Operation::Copy
            | Operation::Repeat
            | Operation::Multiply { signed: true }
            | Operation::Divide { signed: true }
            | Operation::Resize(_)
            | Operation::Each(Unary::Negate)
    )
}

/// One or two words, low word first, as a signed number; `None` for any other count of words.
fn signed(words: &[u16]) -> Option<i64> {
    match *words {
        [word] => Some(word.cast_signed().into()),
        [low, high] => Some((u32::from(high) << 16 | u32::from(low)).cast_signed().into()),
        _ => None,
    }
}
