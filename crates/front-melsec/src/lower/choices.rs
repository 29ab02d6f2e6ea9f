//! Makes "any value" more precise: where choices come from, which cells an index can reach, exact operations.

use super::devices::certain_points;
use super::state::Lowering;
use crate::catalog::{Amount, Entry, Extent, Role};
use crate::memory::{DeviceType, Family, area};
use crate::operand::{Device, Index, Operand as Written, Place, SFC_BLOCK};
use crate::source::RawInstruction;
use scanbound_base::time::Picos;
use scanbound_ir::meaning::{
    Address, ChoiceKind, Count, Meaning, Operation, OperationInput, Shape, Target, Term,
};
use scanbound_ir::timers::Expiry;
use scanbound_ir::{
    AreaId, BitSource, Cell, ChoiceId, Compare, Effect, IndexedWrite, Length, Logic, Number,
    NumberFormat, Relation, Source, When, WordSource, Write,
};

impl Lowering<'_> {
    /// A new bit, with any value at each read, that something outside the program determines.
    pub(super) fn external_bit(&mut self) -> Logic {
        Logic::Bit(BitSource::Free(self.out.external_choice()))
    }

    /// A new word, with any value at each read, that something outside the program determines.
    pub(super) fn external_word(&mut self) -> WordSource {
        WordSource::Free(self.out.external_choice())
    }

    /// Whether something outside the program determines the device at each read: direct inputs, module memory, links.
    /// Not included are special relays and registers that instructions set (carry, errors), and dates and times, which
    /// do not have arbitrary values.
    pub(super) fn is_external(&self, device: &Device) -> bool {
        match device.place {
            // A step of an SFC program is inside the PLC.
            Place::Foreign(_) => device.name != SFC_BLOCK,
            Place::At(DeviceType::VolatileBit, _) => device.name == "DX",
            _ => false,
        }
    }

    /// A new choice whose value the operation computes. If the CPU stops at operation errors, the condition under which
    /// the operation refuses its inputs is noted for the current instruction.
    pub(super) fn define(&mut self, meaning: Meaning) -> ChoiceId {
        let choice = self.choice();
        if self.stops_on_error() {
            self.note_error(meaning.operand_error());
        }
        self.out.define(choice, meaning);
        choice
    }

    /// Two new choices for a timer whose coil is on: whether its time has passed, and its present value. Something
    /// outside the program determines how much time has passed; `unit` is the time of one count. `ran` is the bit of
    /// [`Timed::ran`](crate::memory::Timed::ran), `None` for a retentive timer.
    pub(super) fn elapsed(
        &mut self,
        (ran, contact, value): (Option<Cell>, Cell, Cell),
        setting: WordSource,
        unit: Picos,
    ) -> (ChoiceId, ChoiceId) {
        let before = self.previous_present(value);
        let word = |source| OperationInput::Words(vec![source]);
        let (over, number) = (self.out.external_choice(), self.out.external_choice());
        let on_delay = Expiry::of_on_delay(ran.unwrap_or(value), setting, unit);
        let expiry = Expiry {
            previous: Some(before),
            flag: ran.map(|_| contact),
            is_reset: self.modes.may_reset(contact),
            ..on_delay
        };
        self.out.set_expiry([over, number], expiry);
        // A run tracks the time of a timer that restarts each time. It does not track retentive timers, nor current
        // values.
        let is_retentive = ran.is_none();
        let untracked = [Some(over).filter(|_| is_retentive), Some(number)];
        self.out.program.timekeeping.untracked.extend(untracked.into_iter().flatten());
        let inputs = vec![
            OperationInput::Bits(vec![BitSource::Free(over)]),
            word(WordSource::Cell(before)),
            word(setting),
            word(WordSource::Free(number)),
        ];
        let now = self.define(Meaning { operation: Operation::Elapsed, inputs, outputs: vec![] });
        (over, now)
    }

    /// Two new choices for a counter whose coil is on: whether its count has reached the set value, and its present
    /// value. Both are computed from contact, coil and present value before.
    pub(super) fn counted(
        &mut self,
        [contact, coil, value]: [Cell; 3],
        setting: WordSource,
    ) -> (ChoiceId, ChoiceId) {
        let was = |cell| OperationInput::Bits(vec![BitSource::Cell(cell)]);
        let word = |source| OperationInput::Words(vec![source]);
        let now = self.define(Meaning {
            operation: Operation::Counted,
            inputs: vec![was(coil), was(contact), word(WordSource::Cell(value)), word(setting)],
            outputs: Vec::new(),
        });
        let compare = Compare {
            relation: Relation::GreaterOrEqual,
            format: NumberFormat::Signed,
            left: Number::Words(vec![WordSource::Free(now)]),
            right: Number::Words(vec![setting]),
        };
        let through = Meaning::of(OperationInput::Truth(Logic::Compare(Box::new(compare))));
        (self.define(through), now)
    }

    /// The address of an indexed device, shifted by `offset` cells. `None` if it is not certain which cells it may be:
    /// the size of the area, or the meaning of the index, depends on the CPU or its parameters.
    pub(super) fn indexed(&self, device: &Device, offset: u32) -> Option<Address> {
        let Index { number, letters, register, .. } = device.index?;
        let cells = match device.place {
            Place::Indexed(kind, _) | Place::IndexedDigits(kind, _) => match kind {
                DeviceType::Bit(area) | DeviceType::Word(area) => area,
                DeviceType::Timed(timed) => timed.contact,
                DeviceType::VolatileBit | DeviceType::VolatileWord => return None,
            },
            _ => return None,
        };
        let at =
            |register| WordSource::Cell(Cell { area: const { self::area("Z") }, index: register });
        let term = match letters {
            // Whether an index of a file register has 16 or 32 bits is a CPU parameter.
            "Z" if self.is_extended(cells, device.name, number) => {
                match self.options.facts.index_bits? {
                    16 => Term::signed(at(register)),
                    _ if device.name != "ZR" => return None,
                    _ => Term {
                        words: vec![at(register), at(register + 1)],
                        ..Term::signed(at(register))
                    },
                }
            }
            "Z" => Term::signed(at(register)),
            "V" => Term::signed(WordSource::Cell(Cell {
                area: const { area("V index ") },
                index: register,
            })),
            _ => return None,
        };
        let base = i64::from(number) + i64::from(offset);
        self.device_address((cells, device.name), base, vec![term])
    }

    /// The words of an indexed device, whose addresses are computed where they are read. `None` if the address cannot
    /// be computed.
    pub(super) fn indexed_words(
        &mut self,
        device: &Device,
        words: usize,
    ) -> Option<Vec<WordSource>> {
        if self.family == Family::Fx && words > 1 {
            // On this CPU, the index of a double word has 32 bits.
            return None;
        }
        let (digits, shape) = match device.place {
            Place::Indexed(DeviceType::Word(_), false) => (None, Shape::Cells),
            Place::IndexedDigits(DeviceType::Bit(_), digits) => {
                (Some(u32::from(digits)), Shape::Packed(16))
            }
            _ => return None,
        };
        let mut found = Vec::new();
        for n in 0..words as u32 {
            let (offset, shape) = match digits.map(|digits| (4 * digits).saturating_sub(16 * n)) {
                None => (n, shape),
                Some(0) => {
                    found.push(WordSource::Const(0));
                    continue;
                }
                Some(bits) => (16 * n, Shape::Packed(bits.min(16) as u8)),
            };
            let run = OperationInput::Run(self.indexed(device, offset)?, shape, Count::Exactly(1));
            found.push(WordSource::Free(self.define(Meaning::of(run))));
        }
        Some(found)
    }

    /// A bit of an indexed device, whose address is computed where it is read. `None` if the address cannot be
    /// computed.
    pub(super) fn indexed_bit(&mut self, device: &Device) -> Option<Logic> {
        let address = self.indexed(device, 0)?;
        let shape = match device.index?.bit {
            Some(bit) => Shape::WordBits(bit),
            None => Shape::Cells,
        };
        let meaning = Meaning::of(OperationInput::Run(address, shape, Count::Exactly(1)));
        Some(Logic::Bit(BitSource::Free(self.define(meaning))))
    }

    /// The choice for a write to an indexed device, with the written value as its meaning if this is known.
    pub(super) fn indexed_write(
        &mut self,
        text: &str,
        input: OperationInput,
        words: usize,
    ) -> ChoiceId {
        let meaning = self.device(text).and_then(|device| {
            if self.family == Family::Fx && words > 1 {
                return None;
            }
            if let Some(address) = self.indirect_address(&device) {
                let outputs = vec![Target::Run(address, Shape::Cells)];
                return Some(Meaning { operation: Operation::Copy, inputs: vec![input], outputs });
            }
            let address = self.indexed(&device, 0)?;
            let shape = match (device.place, device.index?.bit) {
                (Place::IndexedDigits(DeviceType::Bit(_), digits), _)
                    if usize::from(digits).div_ceil(4) == words =>
                {
                    Shape::Packed(match digits % 4 {
                        0 => 16,
                        rest => 4 * rest,
                    })
                }
                (Place::IndexedDigits(..), _) => return None,
                (_, Some(bit)) => Shape::WordBits(bit),
                (_, None) => Shape::Cells,
            };
            let outputs = vec![Target::Run(address, shape)];
            Some(Meaning { operation: Operation::Copy, inputs: vec![input], outputs })
        });
        match meaning {
            Some(meaning) => self.define(meaning),
            None => self.choice(),
        }
    }

    /// Records the possible cells of a write to an indexed word device, or of a write whose length is in a word, so
    /// that later analysis can limit the havoc of the area to them. Does nothing if two writes of the instruction could
    /// be confused.
    pub(super) fn note_indexed(&mut self, raw: &RawInstruction, entry: &Entry, effects: &[Effect]) {
        let written = raw.operands.iter().zip(&entry.operands).filter(|(_, operand)| {
            !matches!(operand.role, Role::Source | Role::Number | Role::Address)
        });
        let mut found: Vec<(AreaId, Option<IndexedWrite>)> = Vec::new();
        for (text, operand) in written {
            let Ok(Written::Device(device)) = self.parsed(text) else { continue };
            let length = self.written_length(raw, entry, operand.extent);
            match device.place {
                Place::Indexed(DeviceType::Word(area), false) => {
                    found.push((area, self.indexed_cells(&device, area, length)));
                }
                Place::At(DeviceType::Word(area), number) => {
                    let is_counted = matches!(length, Length::Counted(..));
                    let indexed = IndexedWrite {
                        first: Cell { area, index: number },
                        indices: vec![vec![WordSource::Const(0)]],
                        length,
                        stated: None,
                        proved: Vec::new(),
                    };
                    let is_switched = self.is_switched(device.name);
                    found.push((area, Some(indexed).filter(|_| is_counted && !is_switched)));
                }
                _ => {}
            }
        }
        for (area, indexed) in &found {
            let alone = found.iter().filter(|(other, _)| other == area).count() == 1;
            let Some(indexed) = indexed else { continue };
            let lost = effects.iter().filter_map(|effect| match effect.write {
                Write::Havoc(region, choice) if indexed.may_reach(region) => Some(choice),
                _ => None,
            });
            let lost: Vec<ChoiceId> = lost.collect();
            // All writes in this area with this choice are limited to these cells later.
            let others = |choice: ChoiceId| {
                let is_one = |effect: &&Effect| match effect.write {
                    Write::Havoc(region, own) => own == choice && indexed.shares_area(region),
                    _ => false,
                };
                effects.iter().filter(is_one).count() > 1
            };
            if let (true, [choice]) = (alone, &lost[..])
                && !others(*choice)
            {
                self.out.program.indexed.insert(*choice, indexed.clone());
            }
        }
    }

    fn written_length(&mut self, raw: &RawInstruction, entry: &Entry, extent: Extent) -> Length {
        match extent {
            Extent::Words(Amount::Fixed(count)) => Length::Exactly(count),
            Extent::Words(Amount::Counted { unit, operand }) => {
                if let Some(count) = self.constant(&raw.operands[operand]) {
                    let count = u32::try_from(count).ok();
                    return count
                        .map_or(Length::Unknown, |n| Length::Exactly(n.saturating_mul(unit)));
                }
                match self.count_words(raw, entry, operand).as_deref() {
                    Some([word]) => Length::Counted(*word, unit),
                    _ => Length::Unknown,
                }
            }
            _ => Length::Unknown,
        }
    }

    /// The possible cells of a write to an indexed word device. `None` if the meaning of its index register is unknown.
    fn indexed_cells(&self, device: &Device, area: AreaId, length: Length) -> Option<IndexedWrite> {
        let Index { number, letters, register, .. } = device.index?;
        // On the FX, the index of a double word has 32 bits. R depends on the file register block.
        let is_wide = self.family == Family::Fx && length != Length::Exactly(1);
        if letters != "Z" || is_wide || self.is_switched(device.name) {
            return None;
        }
        let at =
            |register| WordSource::Cell(Cell { area: const { self::area("Z") }, index: register });
        let mut readings = vec![vec![at(register)]];
        // Whether an index of file registers and extended D and W has 16 or 32 bits is a CPU parameter.
        let is_extended =
            certain_points(self.family, area, device.name).is_none_or(|points| number >= points);
        if is_extended && matches!(self.family, Family::Q | Family::L) {
            let wide = vec![at(register), at(register + 1)];
            match self.options.facts.index_bits {
                Some(16) => {}
                // High numbers of D and W may be extended registers or not, so both meanings are possible.
                Some(_) if device.name == "ZR" => readings = vec![wide],
                _ => readings.push(wide),
            }
        }
        Some(IndexedWrite {
            first: Cell { area, index: number },
            indices: readings,
            length,
            stated: None,
            proved: Vec::new(),
        })
    }

    /// The value of a special relay that is known in real runs: a clock or the state of a battery or network, which
    /// something outside the program switches, but not twice in a scan; or the result of a block comparison. `None` for
    /// other devices.
    pub(super) fn known_in_runs(&mut self, device: &Device) -> Option<Logic> {
        let Place::At(DeviceType::VolatileBit, index) = device.place else { return None };
        let is_switched = match device.name {
            "SM" => (409..=415).contains(&index) || self.modes.switched_outside.contains(&index),
            "M" => (8011..=8014).contains(&index),
            _ => false,
        };
        let result = self.block_result.filter(|_| device.name == "SM" && index == 704);
        let own = is_switched.then(|| Cell { area: area(device.name), index });
        result.or(own).map(|cell| self.unchanging_bit(cell))
    }

    /// The value of a bit cell in a real run; the bound takes any value at each read.
    fn unchanging_bit(&mut self, cell: Cell) -> Logic {
        let choice = self.choice();
        let source = Source::Bit(BitSource::Cell(cell));
        self.out.program.kinds.insert(choice, ChoiceKind::StableExternal(source));
        Logic::Bit(BitSource::Free(choice))
    }

    /// The value of a cell that something outside the program determines, the same in the whole scan.
    pub(super) fn unchanging_word(&mut self, cell: Cell) -> WordSource {
        let choice = self.choice();
        let source = Source::Word(WordSource::Cell(cell));
        self.out.program.kinds.insert(choice, ChoiceKind::StableExternal(source));
        WordSource::Free(choice)
    }

    /// Whether an instruction (FROM and similar) reads a constant number of words from a module to a plain word device,
    /// or to bits of which each word fills 16. The words may be values that the program wrote to the module before.
    fn reads_module(&self, raw: &RawInstruction, entry: &Entry) -> bool {
        let is_read = matches!(&*entry.mnemonic, "FROM" | "DFRO" | "DFROM" | "FROMD");
        let (Some(to), Some(count)) = (raw.operands.get(2), raw.operands.get(3)) else {
            return false;
        };
        let is_whole = match self.parsed(to) {
            Ok(Written::Device(device)) => matches!(
                device.place,
                Place::At(DeviceType::Word(_), _) | Place::Digits(DeviceType::Bit(_), _, 4)
            ),
            _ => false,
        };
        is_read && is_whole && self.constant(count).is_some()
    }

    /// Gives those effects of an instruction that write any value when it fires its exact meaning, if it has one. Words
    /// read from a module are marked as external.
    pub(super) fn set_exact_meaning(
        &mut self,
        raw: &RawInstruction,
        entry: &Entry,
        effects: &mut [Effect],
    ) {
        // An instruction without an exact meaning is not an error.
        self.current.quiet = true;
        let meaning = self.meaning(raw, entry);
        self.current.quiet = false;
        if let ("ADRSET", [Effect { write: Write::Havoc(_, choice), .. }]) =
            (&*entry.mnemonic, &*effects)
            && let Some(address) = self.address_of(&raw.operands[0])
        {
            self.out.program.kinds.insert(*choice, address);
        }
        if entry.class == "module" && self.reads_module(raw, entry) {
            for effect in effects.iter() {
                if let Write::Havoc(_, choice) = effect.write {
                    self.out.program.kinds.insert(choice, ChoiceKind::External);
                }
            }
        }
        let Some(meaning) = meaning else { return };
        let choice = self.define(meaning);
        for effect in effects {
            if let (When::Fired, Write::Havoc(_, own)) = (effect.when, &mut effect.write) {
                *own = choice;
            }
        }
    }

    /// The target for the result of an operation that has this many words. `None` if the cells are unknown or an error
    /// was reported.
    pub(super) fn target(&mut self, text: &str, words: usize) -> Option<Target> {
        let device = self.device(text)?;
        if let Place::Indexed(DeviceType::Word(_), false) = device.place {
            let is_wide = self.family == Family::Fx && words > 1;
            return Some(Target::Run(self.indexed(&device, 0).filter(|_| !is_wide)?, Shape::Cells));
        }
        if let Some(address) = self.indirect_address(&device) {
            return Some(Target::Run(address, Shape::Cells));
        }
        match self.word_place(text, words)? {
            super::access::WordPlace::All(targets) => Some(Target::Words(targets)),
            _ => None,
        }
    }
}
