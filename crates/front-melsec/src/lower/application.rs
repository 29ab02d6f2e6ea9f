//! Lowers application instructions by their catalog row, exactly or with any value as the result, and user
//! instructions.
//!
//! Methods that return `Option<Option<_>>` give `None` after an error that they have reported, and `Some(None)` where
//! the effects are not modelled exactly; the caller then lets everything that the instruction writes have any value.

use super::access::{BitPlace, WordPlace};
use super::state::{Lowering, timing};
use crate::catalog::{
    Amount, Axis, CatalogMatch, EVERYWHERE, Entry, Extent, InstructionEffect, Role,
};
use crate::memory::{DeviceType, Family, area};
use crate::operand::{Operand as Written, Place};
use crate::source::RawInstruction;
use scanbound_base::code::Code;
use scanbound_front::builder::fired;
use scanbound_ir::meaning::OperationInput;
use scanbound_ir::{
    AccessedDevices, BitSource, BitTarget, Cell, Effect, Logic, Number, Region, Step, TimingKey,
    Units, When, WordSource, WordTarget, Write,
};

/// The largest number of words of a block that is modelled exactly; a larger block is havocked.
const MAX_WORDS: u32 = 512;

impl Lowering<'_> {
    /// Lowers an instruction that only the timing table knows: when it fires, each device that an operand names may get
    /// any value.
    pub(super) fn user(&mut self, raw: &RawInstruction) {
        self.output_here(&raw.mnemonic);
        let mut effects = Vec::new();
        for text in &raw.operands {
            let Ok(Written::Device(_)) = self.parsed(text) else { continue };
            for region in self.regions(text, Some(1)).unwrap_or_default() {
                effects.push(fired(Write::Havoc(region, self.choice())));
            }
        }
        if !effects.is_empty() {
            self.approximate(format!(
                "{} is not an instruction of scanbound's catalog: any values are assumed for its operands after it",
                raw.mnemonic
            ));
        }
        let names = vec![raw.mnemonic.clone()];
        let key = TimingKey {
            names,
            class: "user",
            units: Units::None,
            use_larger_time: false,
            optional: false,
            accessed: AccessedDevices::default(),
        };
        self.add(Some(key), effects, Step::Act { fires: Logic::Condition });
    }

    /// Lowers an instruction that the catalog lists.
    pub(super) fn application(
        &mut self,
        mnemonic: &str,
        raw: &RawInstruction,
        found: &CatalogMatch,
    ) {
        let entry = &found.entry;
        let free = entry.meaning == InstructionEffect::Free;
        if !free {
            self.output_here(mnemonic);
        } else if self.rung.depth > 0 && !mnemonic.starts_with("NOP") {
            // The instruction is an output of the rung, even if contacts follow.
            self.rung.has_output = true;
        }
        if !self.sources_are_read(raw, entry) {
            return;
        }
        if self.modes.counts_in_d8164 && entry.class == "module" {
            self.fault(
                Code::NotModelled,
                &raw.mnemonic,
                format!(
                    "M8164 may be on, and then D8164 sets how many words `{}` moves: scanbound does not follow this",
                    raw.mnemonic
                ),
                "do not use M8164, and write the count as the last operand; if code that is not given may set M8164, state what that code writes ([calls])",
            );
        }
        let units = self.units(raw, entry);
        let key = timing(mnemonic, found.pulsed, None, entry.class, units, free);
        let Some(mut effects) = self.operation(raw, entry) else { return };
        self.note_indexed(raw, entry, &effects);
        self.note_errors(raw, entry);
        for &name in &entry.also {
            let everywhere = name == EVERYWHERE;
            let region = if everywhere { Region::Everything } else { Region::Area(area(name)) };
            effects.push(fired(Write::Havoc(region, self.choice())));
            // A module that writes to any device does so between scans. Operands may be written at any moment.
            match (entry.meaning, region) {
                (InstructionEffect::HavocAnytime, Region::Everything) => {
                    self.out.program.external.push(region);
                }
                (InstructionEffect::HavocAnytime, _) => {
                    self.out.program.volatile.push(region);
                    self.out.program.delivered.push(region);
                }
                _ => {}
            }
            self.approximate(format!(
                "{} may write any {}",
                raw.mnemonic,
                if everywhere { "device" } else { name }
            ));
        }
        let fires = if free { Logic::Const(true) } else { self.fires(found.pulsed, &mut effects) };
        self.add(Some(key), effects, Step::Act { fires });
        self.havoc_on_overflow();
    }

    /// Whether every source operand is valid and every destination is a device (in a dedicated instruction: is valid);
    /// reports an error if not. Addresses are not checked.
    fn sources_are_read(&mut self, raw: &RawInstruction, entry: &Entry) -> bool {
        let mut fine = true;
        for (text, operand) in raw.operands.iter().zip(&entry.operands) {
            fine &= match operand.role {
                Role::Address => true,
                Role::Source | Role::Number | Role::ReadWriteIfDevice | Role::Extra(Axis) => {
                    self.operand(text).is_some()
                }
                Role::Destination | Role::ReadWrite if entry.class == "dedicated" => {
                    self.operand(text).is_some()
                }
                Role::Destination | Role::ReadWrite => self.device(text).is_some(),
            };
        }
        fine
    }

    /// The effects of the instruction, exact if possible; otherwise everything that it writes may have any value.
    /// `None` after an error that was reported.
    fn operation(&mut self, raw: &RawInstruction, entry: &Entry) -> Option<Vec<Effect>> {
        let exact = match entry.meaning {
            InstructionEffect::Nothing | InstructionEffect::Free => return Some(Vec::new()),
            InstructionEffect::HavocAlways => {
                return Some(self.havoc_all(raw, entry, When::Always));
            }
            InstructionEffect::HavocAnytime => {
                let effects = self.havoc_all(raw, entry, When::Fired);
                for effect in &effects {
                    if let Write::Havoc(region, _) = effect.write {
                        self.out.program.volatile.push(region);
                        self.out.program.delivered.push(region);
                    }
                }
                return Some(effects);
            }
            InstructionEffect::Copy | InstructionEffect::Fill => self.copy(raw, entry)?,
            InstructionEffect::Exchange => self.exchange(raw, entry)?,
            InstructionEffect::Clear => self.clear(raw, entry)?,
            InstructionEffect::ClearRange => self.clear_range(raw)?,
            InstructionEffect::SetBit | InstructionEffect::ResetBit => {
                self.bit_of_word(raw, entry.meaning == InstructionEffect::SetBit)?
            }
            InstructionEffect::ShiftOne => self.shift(raw)?,
            InstructionEffect::Alternate => {
                let now = self.read_bit(&raw.operands[0])?;
                Some(self.bit_effects(&raw.operands[0], now.not(), false)?)
            }
            InstructionEffect::SlideUp | InstructionEffect::SlideDown => {
                self.slide(raw, entry, entry.meaning == InstructionEffect::SlideUp)?
            }
            InstructionEffect::Pairwise => self.pairwise(raw, entry)?,
            InstructionEffect::Text => self.constant_text(raw)?,
            InstructionEffect::Order => self.compare_to_bits(raw, entry)?,
            InstructionEffect::Havoc | InstructionEffect::Swap => None,
            _ => self.arithmetic(raw, entry)?,
        };
        Some(match exact {
            Some(effects) => effects,
            None => {
                let mut effects = self.havoc_all(raw, entry, When::Fired);
                self.add_carry(raw, entry, &mut effects);
                self.add_block_result(entry, &mut effects);
                self.set_exact_meaning(raw, entry, &mut effects);
                effects
            }
        })
    }

    /// Adds a bit to the effects of a shift or rotation by a constant: the carry flag SM700 as it is behind the
    /// instruction, until another instruction than a contact follows. If the instruction does not fire, or its exact
    /// meaning is not known, the bit has any value. (MELSEC-Q/L programming manual, common instructions, pages 330, 333
    /// and 339.)
    fn add_carry(&mut self, raw: &RawInstruction, entry: &Entry, effects: &mut Vec<Effect>) {
        let is_shift = matches!(&*entry.mnemonic, "SFR" | "SFL" | "ROR" | "ROL" | "DROR" | "DROL");
        let is_large = matches!(self.family, Family::Q | Family::L | Family::Iqr);
        let moves = raw.operands.get(1).and_then(|by| self.constant(by)).is_some_and(|by| by > 0);
        // Whether an interrupt program keeps the flag is unknown.
        if !(is_shift && is_large && moves) || self.modes.has_interrupts {
            return;
        }
        let cell = self.memory();
        self.out.program.names.insert(cell, format!("SM700 after `{}`", raw.text));
        let region = Region::Range { first: cell, count: 1 };
        let any = Effect { when: When::Always, write: Write::Havoc(region, self.choice()) };
        effects.insert(0, any);
        effects.push(Effect { when: When::Fired, write: Write::Havoc(region, self.choice()) });
        self.carry = Some(cell);
    }

    /// Adds SM704 to the effects of a block comparison.
    fn add_block_result(&mut self, entry: &Entry, effects: &mut Vec<Effect>) {
        let compares = entry.mnemonic.trim_start_matches('D').starts_with("BKCMP");
        if let Some(cell) = self.block_result.filter(|_| compares) {
            let region = Region::Range { first: cell, count: 1 };
            effects.push(fired(Write::Havoc(region, self.choice())));
        }
    }

    /// The effects of writing a number of `words` words to an operand when the instruction fires. If the cells are
    /// unknown, the whole region may have any value. `None` after an error that was reported.
    pub(super) fn write_number(
        &mut self,
        text: &str,
        words: usize,
        number: Number,
    ) -> Option<Vec<Effect>> {
        Some(match self.word_place(text, words)? {
            WordPlace::All(targets) => vec![fired(Write::Words(targets, number))],
            WordPlace::Somewhere(region) => {
                let choice = self.indexed_write(text, OperationInput::Number(number), words);
                vec![fired(Write::Havoc(region, choice))]
            }
            WordPlace::Nowhere => Vec::new(),
        })
    }

    fn arithmetic(&mut self, raw: &RawInstruction, entry: &Entry) -> Option<Option<Vec<Effect>>> {
        let last = raw.operands.len() - 1;
        let Extent::Words(Amount::Fixed(words)) = entry.operands[last].extent else {
            return Some(None);
        };
        let words = words as usize;
        let constant = |value: u16| {
            Number::Words(
                (0..words)
                    .map(|n| WordSource::Const(if n == 0 || value == u16::MAX { value } else { 0 }))
                    .collect(),
            )
        };
        let (a, b) = match (entry.meaning, last) {
            (InstructionEffect::Increment | InstructionEffect::Decrement, _) => {
                (self.number(&raw.operands[0], words)?, constant(1))
            }
            (InstructionEffect::Negate, _) => (constant(0), self.number(&raw.operands[0], words)?),
            (InstructionEffect::WordNot, _) => {
                (self.number(&raw.operands[0], words)?, constant(u16::MAX))
            }
            // With two operands, the second one is both a source and the destination.
            (_, 1) => {
                (self.number(&raw.operands[1], words)?, self.number(&raw.operands[0], words)?)
            }
            _ => (self.number(&raw.operands[0], words)?, self.number(&raw.operands[1], words)?),
        };
        if self.has_unknown_overflow(entry) {
            if words == 2 && self.modes.sums_reals {
                return Some(None);
            }
            return Some(Some(self.effects_with_overflow(
                &raw.operands[last],
                entry,
                (a, b),
                words,
            )?));
        }
        let (a, b) = (Box::new(a), Box::new(b));
        let number = match entry.meaning {
            InstructionEffect::Add | InstructionEffect::Increment => Number::Add(a, b),
            InstructionEffect::Subtract
            | InstructionEffect::Decrement
            | InstructionEffect::Negate => Number::Sub(a, b),
            InstructionEffect::WordAnd => Number::And(a, b),
            InstructionEffect::WordOr => Number::Or(a, b),
            InstructionEffect::WordXor | InstructionEffect::WordNot => Number::Xor(a, b),
            InstructionEffect::WordXnr => {
                Number::Xor(Box::new(Number::Xor(a, b)), Box::new(constant(u16::MAX)))
            }
            _ => return Some(None),
        };
        Some(Some(self.write_number(&raw.operands[last], words, number)?))
    }

    /// The number of words of an operand. `None` if it is unknown, too large to be modelled, or counts words of digit
    /// designations, which is not supported.
    fn block_words(&mut self, raw: &RawInstruction, extent: Extent) -> Option<usize> {
        let (unit, count) = match extent {
            Extent::Words(Amount::Fixed(words)) => return Some(words as usize),
            Extent::Words(Amount::Counted { unit, operand }) => {
                (unit, self.constant(&raw.operands[operand])?)
            }
            _ => return None,
        };
        let has_digits = raw.operands.iter().any(|text| match self.parsed(text) {
            Ok(Written::Device(device)) => {
                matches!(device.place, Place::Digits(..) | Place::IndexedDigits(..))
            }
            _ => false,
        });
        let words = u32::try_from(count).ok()?.checked_mul(unit)?;
        let fits = !has_digits && words <= MAX_WORDS && self.has_room(i64::from(words));
        fits.then_some(words as usize)
    }

    fn copy(&mut self, raw: &RawInstruction, entry: &Entry) -> Option<Option<Vec<Effect>>> {
        if self.modes.changes_moves && entry.mnemonic == "BMOV" {
            return self.havoc_both(raw, entry);
        }
        let Some(words) = self.block_words(raw, entry.operands[1].extent) else {
            return Some(None);
        };
        if words == 0 {
            return Some(Some(Vec::new()));
        }
        let sources = if entry.meaning == InstructionEffect::Fill {
            let unit = match entry.operands[1].extent {
                Extent::Words(Amount::Counted { unit, .. }) => unit as usize,
                _ => words,
            };
            let one = self.read_words(&raw.operands[0], unit)?;
            one.into_iter().cycle().take(words).collect()
        } else {
            self.read_words(&raw.operands[0], words)?
        };
        Some(Some(self.write_number(&raw.operands[1], words, Number::Words(sources))?))
    }

    /// The effects of a move whose direction or type depends on a special relay (M8024, M8160): both operands get any
    /// value.
    fn havoc_both(&mut self, raw: &RawInstruction, entry: &Entry) -> Option<Option<Vec<Effect>>> {
        let what = "any values are assumed for its operands";
        self.approximate(format!("what {} does depends on M8024 or M8160: {what}", raw.mnemonic));
        let mut effects = Vec::new();
        for text in &raw.operands[..2] {
            for region in self.reach(raw, entry, text, entry.operands[1].extent) {
                effects.push(fired(Write::Havoc(region, self.choice())));
            }
        }
        Some(Some(effects))
    }

    fn exchange(&mut self, raw: &RawInstruction, entry: &Entry) -> Option<Option<Vec<Effect>>> {
        if self.modes.changes_moves {
            return self.havoc_both(raw, entry);
        }
        let Some(words) = self.block_words(raw, entry.operands[0].extent) else {
            return Some(None);
        };
        let (first, second) =
            (self.word_place(&raw.operands[0], words)?, self.word_place(&raw.operands[1], words)?);
        let (WordPlace::All(mut targets), WordPlace::All(more)) = (first, second) else {
            return Some(None);
        };
        let mut sources = self.read_words(&raw.operands[1], words)?;
        sources.extend(self.read_words(&raw.operands[0], words)?);
        targets.extend(more);
        Some(Some(vec![fired(Write::Words(targets, Number::Words(sources)))]))
    }

    fn clear(&mut self, raw: &RawInstruction, entry: &Entry) -> Option<Option<Vec<Effect>>> {
        let count = match entry.operands[0].extent {
            Extent::Bits(Amount::Counted { unit, operand })
            | Extent::Words(Amount::Counted { unit, operand })
            | Extent::Devices(Amount::Counted { unit, operand }) => {
                self.constant(&raw.operands[operand]).map(|count| count * i64::from(unit))
            }
            _ => None,
        };
        let place = self.device(&raw.operands[0])?.place;
        // Whether ZRST clears whole words or single bits here is unknown, so the value is unknown.
        let is_word = matches!(place, Place::At(DeviceType::Word(_), _));
        let count = count.filter(|&count| !is_word && self.has_room(count));
        Some(count.and_then(|count| self.cleared(place, count)))
    }

    fn clear_range(&mut self, raw: &RawInstruction) -> Option<Option<Vec<Effect>>> {
        let (first, last) =
            (self.device(&raw.operands[0])?.place, self.device(&raw.operands[1])?.place);
        // Two types of timers can share the same areas. If the first device is above the last, the FX resets the first
        // one alone.
        let count = match (first, last) {
            (Place::At(kind, from), Place::At(other, to))
                if kind.cell(0).is_some() && kind.cell(0) == other.cell(0) =>
            {
                let alone = (self.family == Family::Fx).then_some(1);
                to.checked_sub(from).map(|more| more + 1).or(alone)
            }
            _ => None,
        };
        let spelled = count.map(i64::from).filter(|&count| self.has_room(count));
        if let Some(effects) = spelled.and_then(|count| self.cleared(first, count)) {
            return Some(Some(effects));
        }
        self.approximate(format!("everything that {} writes may have any value", raw.mnemonic));
        let mut regions = self.regions(&raw.operands[0], count)?;
        regions.extend(self.regions(&raw.operands[1], Some(1))?);
        let lost = |region| fired(Write::Havoc(region, self.choice()));
        Some(Some(regions.into_iter().map(lost).collect()))
    }

    fn bit_of_word(&mut self, raw: &RawInstruction, value: bool) -> Option<Option<Vec<Effect>>> {
        let Some(bit) = self.constant(&raw.operands[1]) else { return Some(None) };
        let bit = (bit & 15) as u8;
        let target = match self.device(&raw.operands[0])?.place {
            Place::At(DeviceType::Word(area), index) if !self.modes.switches_file_register => {
                BitTarget::WordBit(Cell { area, index }, bit)
            }
            _ => return Some(None),
        };
        Some(Some(vec![fired(Write::Bit(target, Logic::Const(value)))]))
    }

    fn shift(&mut self, raw: &RawInstruction) -> Option<Option<Vec<Effect>>> {
        let (to, from, from_target) = match self.bit_place(&raw.operands[0])? {
            BitPlace::One(to @ BitTarget::Cell(cell)) if cell.index > 0 => {
                let before = Cell { index: cell.index - 1, ..cell };
                (to, BitSource::Cell(before), BitTarget::Cell(before))
            }
            BitPlace::One(to @ BitTarget::WordBit(cell, bit)) if bit > 0 => {
                (to, BitSource::WordBit(cell, bit - 1), BitTarget::WordBit(cell, bit - 1))
            }
            _ => return Some(None),
        };
        Some(Some(vec![
            fired(Write::Bit(to, Logic::Bit(from))),
            fired(Write::Bit(from_target, Logic::Const(false))),
        ]))
    }

    /// The effects that let each written operand have any value over its whole extent. For an axis this is every Y.
    fn havoc_all(&mut self, raw: &RawInstruction, entry: &Entry, when: When) -> Vec<Effect> {
        let mut effects = Vec::new();
        for (text, operand) in raw.operands.iter().zip(&entry.operands) {
            match operand.role {
                Role::Destination | Role::ReadWrite | Role::ReadWriteIfDevice => {}
                Role::Extra(Axis) if self.is_bit(text) => {}
                Role::Extra(Axis) => {
                    let region = Region::Area(const { area("Y") });
                    effects.push(Effect { when, write: Write::Havoc(region, self.choice()) });
                    continue;
                }
                Role::Source | Role::Number | Role::Address => continue,
            }
            for region in self.reach(raw, entry, text, operand.extent) {
                effects.push(Effect { when, write: Write::Havoc(region, self.choice()) });
            }
        }
        if !effects.is_empty() {
            self.approximate(format!("everything that {} writes may have any value", raw.mnemonic));
        }
        effects
    }

    /// Whether an operand is a bit device.
    fn is_bit(&self, text: &str) -> bool {
        let Ok(Written::Device(device)) = self.parsed(text) else { return false };
        matches!(
            device.place,
            Place::At(DeviceType::Bit(_) | DeviceType::VolatileBit, _)
                | Place::Indexed(DeviceType::Bit(_) | DeviceType::VolatileBit, _)
                | Place::BitOf(..)
                | Place::Indexed(_, true)
                | Place::Fixed(_)
        )
    }

    /// The regions that an operand covers, up to the end of its area if its length is unknown. Empty for constants, for
    /// devices without cells, and after an error.
    fn reach(
        &mut self,
        raw: &RawInstruction,
        entry: &Entry,
        text: &str,
        extent: Extent,
    ) -> Vec<Region> {
        let mut count = match extent.amount() {
            Amount::Fixed(count) => Some(count),
            Amount::Counted { unit, operand } => {
                let (_, high, known) = self.block_count(raw, entry, operand);
                u32::try_from(high).ok().filter(|_| known).and_then(|high| high.checked_mul(unit))
            }
            Amount::Power { operand } => {
                let power = self.constant(&raw.operands[operand]);
                power.filter(|power| (0..=16).contains(power)).map(|power| 1 << power)
            }
            Amount::UpTo { .. } | Amount::Unknown => None,
        };
        if let Ok(Written::Device(device)) = self.parsed(text) {
            // A word in a bit area without a digit designation is sixteen bits.
            if matches!(
                (extent, device.place),
                (Extent::Words(_), Place::At(DeviceType::Bit(_), _))
            ) {
                count = count.and_then(|count| count.checked_mul(16));
            }
            // Each result fills the digits of the designation, one after another. Whether several words are one result
            // or several is unknown. No word fills more than sixteen bits.
            if let (Extent::Words(Amount::Fixed(words)), Place::Digits(_, _, digits)) =
                (extent, device.place)
            {
                count = Some(words.min((4 * words).div_ceil(u32::from(digits))));
            }
        }
        self.regions(text, count).unwrap_or_default()
    }

    /// Writes of zero to `count` devices from this one on; from a bit of a word on, to `count` bits. `None` if there
    /// are more than 512, or if devices of this form are not modelled.
    fn cleared(&mut self, place: Place, count: i64) -> Option<Vec<Effect>> {
        let count = u32::try_from(count).ok().filter(|&count| count <= MAX_WORDS)?;
        let bit = |area, n| {
            fired(Write::Bit(BitTarget::Cell(Cell { area, index: n }), Logic::Const(false)))
        };
        let word = |area, n| {
            let target = WordTarget::Cell(Cell { area, index: n });
            fired(Write::Words(vec![target], Number::Words(vec![WordSource::Const(0)])))
        };
        Some(match place {
            Place::At(DeviceType::Bit(area), index) => {
                (index..index + count).map(|n| bit(area, n)).collect()
            }
            Place::At(DeviceType::Word(area), index) => {
                (index..index + count).map(|n| word(area, n)).collect()
            }
            Place::At(DeviceType::Timed(timed), index) => {
                (index..index + count).flat_map(|n| self.reset(timed, n)).collect()
            }
            Place::BitOf(DeviceType::Word(area), index, from) => (u32::from(from)
                ..u32::from(from) + count)
                .map(|n| {
                    let cell = Cell { area, index: index + n / 16 };
                    fired(Write::Bit(BitTarget::WordBit(cell, (n % 16) as u8), Logic::Const(false)))
                })
                .collect(),
            _ => return None,
        })
    }
}
