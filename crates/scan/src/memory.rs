//! The symbolic memory: the latest version of every cell, guarded writes, and havocked regions.

use super::violation_log::ViolationLog;
use super::word::{Word, Words};
use rustc_hash::FxHashMap;
use scanbound_ir::{
    AreaId, BitTarget, Cell, ChoiceId, ChoiceKey, Frame, Program, Region, WordTarget,
};
use scanbound_model::{
    Atom, Circuit, Coverage, Havoc, Havocs, Lit, Origin, ScanModel, VarId, VarKind, Variable,
};

/// The latest value of a cell, and how many of the first havocs of its area this value already includes.
#[derive(Debug, Clone, Copy)]
struct Version<T> {
    value: T,
    seen: usize,
}

/// The memory during symbolic execution, and the model under construction.
pub struct Memory<'p> {
    program: &'p Program,
    /// The model under construction.
    pub model: ScanModel,
    /// All symbolic words, and the answers to queries on them.
    pub words: Words,
    bit_cells: FxHashMap<Cell, Version<Lit>>,
    word_cells: FxHashMap<Cell, Version<Word>>,
    /// The literal that at least one havoc of a block is executed, for blocks of which all havocs concern the same
    /// cells: by area, block size and block number.
    happened: FxHashMap<(AreaId, u32, usize), Lit>,
    choices: FxHashMap<ChoiceKey, VarId>,
    word_choices: Vec<bool>,
    /// Records of writes for the checks of [`super::violations`], if requested.
    pub watch: Option<Box<ViolationLog>>,
}

impl<'p> Memory<'p> {
    /// A memory in which every cell has its free start value. `word_choices` says for each choice whether it is ever
    /// read as a word.
    pub fn new(program: &'p Program, word_choices: Vec<bool>) -> Self {
        Memory {
            program,
            model: ScanModel {
                havocs: Havocs::of_areas(program.areas.len()),
                ..ScanModel::default()
            },
            words: Words::default(),
            bit_cells: FxHashMap::default(),
            word_cells: FxHashMap::default(),
            happened: FxHashMap::default(),
            choices: FxHashMap::default(),
            word_choices,
            watch: None,
        }
    }

    /// The circuit of the model under construction.
    pub fn circuit(&mut self) -> &mut Circuit {
        &mut self.model.circuit
    }

    fn variable(&mut self, kind: VarKind, origin: Origin, name: String) -> VarId {
        let id = VarId(u32::try_from(self.model.variables.len()).expect("too many variables"));
        self.model.variables.push(Variable { kind, origin, name });
        id
    }

    fn free_bit(&mut self, origin: Origin, name: String) -> Lit {
        let variable = self.variable(VarKind::Bit, origin, name);
        self.model.circuit.atom(Atom::Bit(variable))
    }

    fn free_word(&mut self, origin: Origin, name: String) -> Word {
        let variable = self.variable(VarKind::Word, origin, name);
        self.words.free(variable)
    }

    fn choice(
        &mut self,
        frames: &[Frame],
        choice: ChoiceId,
        place: &dyn Fn() -> String,
    ) -> (VarId, VarKind) {
        let kind = if self.word_choices[choice.0 as usize] { VarKind::Word } else { VarKind::Bit };
        let key = ChoiceKey { frames: frames.to_vec(), choice, cell: None };
        if let Some(&variable) = self.choices.get(&key) {
            return (variable, kind);
        }
        let variable = self.variable(kind, Origin::Choice(key.clone()), place());
        self.choices.insert(key, variable);
        (variable, kind)
    }

    /// Whether an instruction, an operation or an error condition reads the choice as a word, and not only as a bit.
    pub fn is_word_choice(&self, choice: ChoiceId) -> bool {
        self.word_choices[choice.0 as usize]
    }

    /// The free literal of a choice that is read as a bit in the call context `frames`; bit 0 of its word if it is also
    /// read as a word. `place` names a new variable.
    pub fn bit_choice(
        &mut self,
        frames: &[Frame],
        choice: ChoiceId,
        place: &dyn Fn() -> String,
    ) -> Lit {
        let (variable, kind) = self.choice(frames, choice, place);
        self.model.circuit.atom(match kind {
            VarKind::Bit => Atom::Bit(variable),
            VarKind::Word => Atom::WordBit(variable, 0),
        })
    }

    /// The free word of a choice that is read as a word in the call context `frames`. `place` names a new variable.
    pub fn word_choice(
        &mut self,
        frames: &[Frame],
        choice: ChoiceId,
        place: &dyn Fn() -> String,
    ) -> Word {
        let (variable, _) = self.choice(frames, choice, place);
        self.words.free(variable)
    }

    /// The current value of a bit cell. The first read makes a free variable for the start value; a read after havocs
    /// makes one for the value that they wrote.
    pub fn read_bit(&mut self, cell: Cell) -> Lit {
        let old = match self.bit_cells.get(&cell) {
            Some(&version) => version,
            None => {
                let name = self.program.cell_name(cell);
                Version { value: self.free_bit(Origin::Start(cell), name), seen: 0 }
            }
        };
        let value = match self.havocked_since(cell, old.seen) {
            None => old.value,
            Some((happened, origin)) => {
                let name =
                    format!("{} after a write of an unknown value", self.program.cell_name(cell));
                let fresh = self.free_bit(origin, name);
                self.model.circuit.ite(happened, fresh, old.value)
            }
        };
        self.bit_cells.insert(cell, self.newest(cell, value));
        value
    }

    /// The current value of a word cell; as [`Memory::read_bit`].
    pub fn read_word(&mut self, cell: Cell) -> Word {
        let old = match self.word_cells.get(&cell) {
            Some(&version) => version,
            None => {
                let name = self.program.cell_name(cell);
                Version { value: self.free_word(Origin::Start(cell), name), seen: 0 }
            }
        };
        let value = match self.havocked_since(cell, old.seen) {
            None => old.value,
            Some((happened, origin)) => {
                let name =
                    format!("{} after a write of an unknown value", self.program.cell_name(cell));
                let fresh = self.free_word(origin, name);
                self.words.either(happened, fresh, old.value)
            }
        };
        self.word_cells.insert(cell, self.newest(cell, value));
        value
    }

    /// A value of a cell that includes all havocs so far.
    fn newest<T>(&self, cell: Cell, value: T) -> Version<T> {
        Version { value, seen: self.model.havocs.count(cell.area) }
    }

    /// The literal that says whether a havoc after the first `seen` havocs of the cell's area wrote the cell, and the
    /// origin of the value that it wrote. `None` if no such havoc can have written the cell.
    fn havocked_since(&mut self, cell: Cell, seen: usize) -> Option<(Lit, Origin)> {
        let count = self.model.havocs.count(cell.area);
        if count == seen {
            return None;
        }
        // An unconditional havoc makes everything before it irrelevant.
        let since = self.model.havocs.newest_certain(cell, seen).unwrap_or(seen);
        self.words.spent += (count - seen) / 64;
        let happened = self.one_happened(cell, since);
        let moments = |number: usize| u32::try_from(number).expect("too many havocked regions");
        let origin = || Origin::Havocked { cell, since: moments(since), until: moments(count) };
        (happened != Lit::FALSE).then(|| (happened, origin()))
    }

    /// A literal that is true if at least one havoc that may write the cell, from number `from` on, is executed.
    ///
    /// Each cell was last read at another moment, so each needs a different range of the list. The ranges are composed
    /// of aligned blocks whose sizes are powers of two, so that cells share the gates of these blocks.
    fn one_happened(&mut self, cell: Cell, from: usize) -> Lit {
        let count = self.model.havocs.count(cell.area);
        let (mut from, mut any) = (from, Lit::FALSE);
        while from < count {
            let level = from.trailing_zeros().min((count - from).ilog2());
            let happened = self.one_of_block(cell, level, from >> level);
            any = self.model.circuit.or(any, happened);
            from += 1 << level;
        }
        any
    }

    /// The literal that says whether at least one havoc of a block that may write the cell is executed.
    fn one_of_block(&mut self, cell: Cell, level: u32, number: usize) -> Lit {
        let concerned = self.model.havocs.block(cell, level, number);
        if concerned == Coverage::None {
            return Lit::FALSE;
        }
        if level == 0 {
            return self.model.havocs.happened(cell.area, number);
        }
        let block = (cell.area, level, number);
        if concerned == Coverage::All
            && let Some(&happened) = self.happened.get(&block)
        {
            return happened;
        }
        let first = self.one_of_block(cell, level - 1, 2 * number);
        let second = self.one_of_block(cell, level - 1, 2 * number + 1);
        let happened = self.model.circuit.or(first, second);
        if concerned == Coverage::All {
            self.happened.insert(block, happened);
        }
        happened
    }

    /// Writes a bit if `guard` is true.
    pub fn write_bit(&mut self, target: BitTarget, guard: Lit, value: Lit) {
        match target {
            BitTarget::Cell(cell) => {
                let old = if guard == Lit::TRUE { value } else { self.read_bit(cell) };
                let value = self.model.circuit.ite(guard, value, old);
                self.bit_cells.insert(cell, self.newest(cell, value));
            }
            BitTarget::WordBit(cell, bit) => {
                let word = self.read_word(cell);
                let mut bits = self.words.bits(&mut self.model.circuit, word);
                bits[usize::from(bit)] = value;
                let new = self.words.of_bits(&self.model.circuit, bits);
                self.write_word(WordTarget::Cell(cell), guard, new);
            }
        }
    }

    /// Writes a word if `guard` is true.
    pub fn write_word(&mut self, target: WordTarget, guard: Lit, value: Word) {
        match target {
            WordTarget::Cell(cell) => {
                if let Some(watch) = &mut self.watch {
                    watch.written(&mut self.words, &mut self.model.circuit, cell, guard, value);
                }
                let old = if guard == Lit::TRUE { value } else { self.read_word(cell) };
                let value = self.words.either(guard, value, old);
                self.word_cells.insert(cell, self.newest(cell, value));
            }
            WordTarget::Bits { first, count } => {
                let bits = self.words.bits(&mut self.model.circuit, value);
                for (i, &bit) in bits.iter().enumerate().take(usize::from(count)) {
                    self.write_bit(BitTarget::Cell(first.plus(i as u32)), guard, bit);
                }
            }
            WordTarget::Discard => {}
        }
    }

    /// Havocs a region if `guard` is true. The cells get their new values when they are next read.
    pub fn havoc(&mut self, region: Region, guard: Lit, frames: &[Frame], choice: ChoiceId) {
        if guard == Lit::FALSE {
            return;
        }
        if let Some(watch) = &mut self.watch {
            watch.note_havoc(&mut self.model.circuit, region, guard);
        }
        self.model.havocs.push(Havoc { region, executed: guard, frames: frames.to_vec(), choice });
    }
}
