//! Which words matter: those that count loops, units or indices, and those that they are worked out from.

use crate::program::meaning::{Address, ChoiceKind, Count, Meaning, Operand, Target, Term};
use crate::program::{
    Cell, ChoiceId, Number, Program, Region, Step, WordSource, WordTarget, Write,
};
use rustc_hash::FxHashSet;
use std::collections::BTreeMap;

/// The words that matter. What may change at any moment is none of them.
pub fn slice(program: &Program, changing: &[Region]) -> Vec<Cell> {
    let mut slice = Slice {
        program,
        changing,
        found: FxHashSet::default(),
        open: Vec::new(),
        choices: FxHashSet::default(),
    };
    let mut writers: BTreeMap<Cell, Vec<usize>> = BTreeMap::new();
    for (at, instruction) in program.instructions.iter().enumerate() {
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
                Write::Words(targets, _) => {
                    for target in targets {
                        if let WordTarget::Cell(cell) = target {
                            writers.entry(*cell).or_default().push(at);
                        }
                    }
                }
                Write::Havoc(_, choice) => {
                    if let Some(indexed) = program.indexed.get(choice) {
                        indexed.readings.iter().for_each(|words| slice.words(words));
                    }
                    if let Some(ChoiceKind::Exact(meaning)) = program.kinds.get(choice) {
                        for cell in results(meaning) {
                            writers.entry(cell).or_default().push(at);
                        }
                    }
                }
                Write::Bit(..) => {}
            }
        }
    }
    while let Some(cell) = slice.open.pop() {
        for &at in writers.get(&cell).into_iter().flatten() {
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

/// The plain words that an operation's results go to.
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

struct Slice<'p> {
    program: &'p Program,
    changing: &'p [Region],
    found: FxHashSet<Cell>,
    open: Vec<Cell>,
    choices: FxHashSet<ChoiceId>,
}

impl Slice<'_> {
    fn word(&mut self, word: WordSource) {
        match word {
            WordSource::Cell(cell) => {
                let changes = self.changing.iter().any(|region| region.holds(cell));
                if !changes && self.found.insert(cell) {
                    self.open.push(cell);
                }
            }
            WordSource::Free(choice) => self.choice(choice),
            WordSource::Const(_) | WordSource::Bits { .. } => {}
        }
    }

    fn words(&mut self, words: &[WordSource]) {
        words.iter().for_each(|word| self.word(*word));
    }

    fn number(&mut self, number: &Number) {
        match number {
            Number::Words(words) => self.words(words),
            Number::Add(a, b)
            | Number::Sub(a, b)
            | Number::And(a, b)
            | Number::Or(a, b)
            | Number::Xor(a, b) => {
                self.number(a);
                self.number(b);
            }
        }
    }

    fn choice(&mut self, choice: ChoiceId) {
        if !self.choices.insert(choice) {
            return;
        }
        let program = self.program;
        match program.kinds.get(&choice) {
            Some(ChoiceKind::Iterations(word)) => self.word(*word),
            Some(ChoiceKind::Exact(meaning)) => {
                for input in &meaning.inputs {
                    match input {
                        Operand::Words(words) => self.words(words),
                        Operand::Number(number) => self.number(number),
                        Operand::Run(address, _, count) => {
                            self.address(address);
                            if let Count::Of { term, .. } = count {
                                self.term(term);
                            }
                        }
                        Operand::Bits(_) | Operand::Truth(_) => {}
                    }
                }
            }
            _ => {}
        }
    }

    fn address(&mut self, address: &Address) {
        address.terms.iter().for_each(|term| self.term(term));
    }

    fn term(&mut self, term: &Term) {
        self.words(&term.words);
    }
}
