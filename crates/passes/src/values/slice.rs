//! Finds the relevant cells (a program slice): words that give counts, units or indices, words from which these are
//! computed, and bits that control their writes.

use super::slots::Slots;
use rustc_hash::{FxHashMap, FxHashSet};
use scanbound_ir::meaning::{Address, ChoiceKind, Count, Meaning, OperationInput, Target, Term};
use scanbound_ir::{
    BitSource, Cell, ChoiceId, Join, Logic, Number, Program, Region, Source, Step, WordSource,
    WordTarget, Write, flow,
};

/// For an indexed read, only words among this many from the base on are relevant.
const NEXT: u32 = 32;

/// The relevant words in ascending order: those that give counts, units or indices or have a stated range, and those
/// from which these are computed. With `compared` also words in comparisons and those from which these are computed.
/// Cells in `changing`, which may change at any moment, are excluded.
pub fn slice(program: &Program, changing: &[Region], compared: bool) -> Vec<Cell> {
    let mut slice = Slice {
        program,
        changing,
        writers: writers(program),
        found: FxHashSet::default(),
        open: Vec::new(),
        choices: FxHashSet::default(),
        compared,
    };
    for instruction in &program.instructions {
        if let Some(fires) = instruction.step.fires() {
            slice.logic(fires);
        }
        match &instruction.step {
            Step::ForBegin { count, .. } => slice.word(*count),
            Step::Summary(summary) => {
                summary.iterations.iter().for_each(|(count, ..)| slice.word(*count))
            }
            _ => {}
        }
        if let Some(counted) = instruction.counted() {
            counted.words.iter().for_each(|word| slice.word(*word));
        }
        for effect in &instruction.effects {
            match &effect.write {
                Write::Havoc(_, choice) => {
                    if let Some(indexed) = program.indexed.get(choice) {
                        indexed.indices.iter().for_each(|words| slice.words(words));
                    }
                    slice.bits(*choice);
                }
                Write::Bit(_, value) => slice.logic(value),
                Write::Words(..) => {}
            }
        }
    }
    // A word with a stated range is relevant, because it is checked whether the program keeps the range.
    for range in &program.stated_ranges {
        if let [cell] = range.cells[..] {
            slice.word(WordSource::Cell(cell));
        }
    }
    while let Some(cell) = slice.open.pop() {
        for at in slice.writers.get(&cell).cloned().unwrap_or_default() {
            for effect in &program.instructions[at].effects {
                match &effect.write {
                    Write::Words(targets, number) => {
                        if targets.contains(&WordTarget::Cell(cell)) {
                            slice.number(number);
                        }
                    }
                    Write::Havoc(_, choice) => slice.choice(*choice),
                    Write::Bit(..) => {}
                }
            }
        }
    }
    let mut found: Vec<Cell> = slice.found.into_iter().collect();
    found.sort_unstable();
    found
}

/// The bits that are read in rungs that write a relevant word (`words`), use a count, call or jump, in ascending order.
/// Cells in `changing` are excluded.
pub fn contacts(program: &Program, changing: &[Region], words: &Slots) -> Vec<Cell> {
    let mut found: FxHashSet<Cell> = FxHashSet::default();
    // Of the current rung: its bits, and whether it is relevant.
    let (mut bits, mut matters) = (Vec::new(), false);
    for (at, instruction) in program.instructions.iter().enumerate() {
        if let Step::Logic { join: Join::Start, .. } = instruction.step {
            if matters {
                found.extend(&bits);
            }
            (bits, matters) = (Vec::new(), false);
        }
        instruction.each_read(&mut |source| {
            if let Source::Bit(BitSource::Cell(cell)) = source {
                bits.push(cell);
            }
        });
        matters |= instruction.counted().is_some()
            || matches!(instruction.step, Step::Call { .. } | Step::Jump { .. })
            || flow::written(program, at)
                .into_iter()
                .any(|region| !words.within(region).is_empty());
    }
    if matters {
        found.extend(&bits);
    }
    let steady = |cell: &Cell| !changing.iter().any(|region| region.contains(*cell));
    let mut found: Vec<Cell> = found.into_iter().filter(steady).collect();
    found.sort_unstable();
    found
}

/// The words to which an operation's results are written directly.
fn results(meaning: &Meaning) -> impl Iterator<Item = Cell> + '_ {
    let targets = meaning.outputs.iter().filter_map(|output| match output {
        Target::Words(targets) => Some(targets),
        _ => None,
    });
    targets.flatten().filter_map(|target| match target {
        WordTarget::Cell(cell) => Some(*cell),
        _ => None,
    })
}

/// For each word, the instructions that write it directly with a value that the program determines.
fn writers(program: &Program) -> FxHashMap<Cell, Vec<usize>> {
    let mut writers: FxHashMap<Cell, Vec<usize>> = FxHashMap::default();
    let mut note = |cell, at| writers.entry(cell).or_default().push(at);
    for (at, instruction) in program.instructions.iter().enumerate() {
        for effect in &instruction.effects {
            match &effect.write {
                Write::Words(targets, _) => {
                    for target in targets {
                        if let WordTarget::Cell(cell) = target {
                            note(*cell, at);
                        }
                    }
                }
                Write::Havoc(_, choice) => {
                    if let Some(ChoiceKind::Exact(meaning)) = program.kinds.get(choice) {
                        results(meaning).for_each(|cell| note(cell, at));
                    }
                }
                Write::Bit(..) => {}
            }
        }
    }
    writers
}

struct Slice<'p> {
    program: &'p Program,
    changing: &'p [Region],
    writers: FxHashMap<Cell, Vec<usize>>,
    found: FxHashSet<Cell>,
    open: Vec<Cell>,
    choices: FxHashSet<ChoiceId>,
    /// Whether words in comparisons are relevant.
    compared: bool,
}

impl Slice<'_> {
    fn word(&mut self, word: WordSource) {
        match word {
            WordSource::Cell(cell) => {
                let changes = self.changing.iter().any(|region| region.contains(cell));
                if !changes && self.found.insert(cell) {
                    self.open.push(cell);
                }
            }
            WordSource::Free(choice) => self.choice(choice),
            WordSource::Const(_) | WordSource::Bits { .. } => {}
        }
    }

    /// Collects the words that a Boolean expression compares, if such words are relevant.
    fn logic(&mut self, logic: &Logic) {
        if !self.compared {
            return;
        }
        match logic {
            Logic::Compare(compare) => {
                self.number(&compare.left);
                self.number(&compare.right);
            }
            Logic::Not(inner) => self.logic(inner),
            Logic::All(parts) | Logic::Any(parts) => {
                parts.iter().for_each(|part| self.logic(part));
            }
            Logic::Bit(BitSource::Free(choice)) => self.choice(*choice),
            Logic::Condition | Logic::Const(_) | Logic::Bit(_) => {}
        }
    }

    /// Collects the words that an operation with bits as results reads, if compared words are relevant.
    fn bits(&mut self, choice: ChoiceId) {
        if self.compared
            && let Some(ChoiceKind::Exact(meaning)) = self.program.kinds.get(&choice)
            && meaning.outputs.iter().any(|output| matches!(output, Target::Bits(_)))
        {
            self.choice(choice);
        }
    }

    fn words(&mut self, words: &[WordSource]) {
        words.iter().for_each(|word| self.word(*word));
    }

    fn number(&mut self, number: &Number) {
        number.words().for_each(|word| self.word(word));
    }

    fn choice(&mut self, choice: ChoiceId) {
        if !self.choices.insert(choice) {
            return;
        }
        let program = self.program;
        match program.kinds.get(&choice) {
            Some(ChoiceKind::Iterations(word) | ChoiceKind::UnsignedIterations(word)) => {
                self.word(*word)
            }
            Some(ChoiceKind::Exact(meaning)) => {
                for input in &meaning.inputs {
                    match input {
                        OperationInput::Words(words) => self.words(words),
                        OperationInput::Number(number) => self.number(number),
                        OperationInput::Run(address, _, count) => {
                            self.address(address);
                            if let Count::Of { term, .. } = count {
                                self.term(term);
                            }
                        }
                        OperationInput::Truth(logic) => self.logic(logic),
                        OperationInput::Bits(_) => {}
                    }
                }
            }
            _ => {}
        }
    }

    /// Collects the index of an address, and the next words after its base that the program writes.
    fn address(&mut self, address: &Address) {
        address.indices().for_each(|term| self.term(term));
        let stretch = address.ranges.iter().find(|stretch| {
            (stretch.from..stretch.from + i64::from(stretch.count)).contains(&address.base)
        });
        let Some(stretch) = stretch else { return };
        let Ok(from) = u32::try_from(address.base - stretch.from) else { return };
        for cell in (from..stretch.count.min(from + NEXT)).map(|n| stretch.first.plus(n)) {
            if self.writers.contains_key(&cell) {
                self.word(WordSource::Cell(cell));
            }
        }
    }

    fn term(&mut self, term: &Term) {
        self.words(&term.words);
    }
}
