//! The exact meanings of catalog instructions whose effects are "any value": operations on their operands, for the CPU
//! families whose manuals define them.
//!
//! In this file `None` means that the exact meaning is unknown or not modelled. Nothing is reported, because errors are
//! suppressed here.

use super::access::{BitPlace, WordPlace};
use super::state::Lowering;
use crate::catalog::Entry;
use crate::memory::{DeviceType, Family, area};
use crate::mnemonic::relation;
use crate::operand::Place;
use crate::source::RawInstruction;
use scanbound_ir::meaning::{
    Address, Arithmetic, Count, IntegerFormat, Meaning, Operation, OperationInput, Shape, Target,
    Term, Unary,
};
use scanbound_ir::{BitSource, BitTarget, Cell, Number, WordSource, WordTarget};

/// The largest number of elements of a block whose exact meaning is modelled on Q, L and iQ-R.
const MAX_ELEMENTS: u32 = 0x7FFF;
/// As [`MAX_ELEMENTS`], on the FX and FX5; on all families, the largest number of bytes that an instruction splits off
/// or combines.
const FX_MAX: u32 = 512;
/// The largest exponent of DECO and ENCO: 2^8 bits.
const MAX_EXPONENT: i64 = 8;

/// How the number of elements of a block is given.
#[derive(Clone, Copy)]
enum ElementCount {
    /// This constant number.
    Known(u32),
    /// The value of this word.
    By(WordSource),
}

impl Lowering<'_> {
    /// The exact meaning of a catalog instruction. `None` if this file does not model it, if blocks overlap so that the
    /// order of moves matters, or if a special relay may change what the instruction does.
    pub(super) fn meaning(&mut self, raw: &RawInstruction, entry: &Entry) -> Option<Meaning> {
        // With M8023 on, the FX exchanges the meaning of integer and real instructions.
        if self.modes.sums_reals {
            return None;
        }
        let name = &*entry.mnemonic;
        let texts: Vec<&str> = raw.operands.iter().map(String::as_str).collect();
        let meaning = match texts[..] {
            [a] => self.of_one(name, a),
            [a, b] => self.of_two(name, a, b),
            [a, b, c] => self.of_three(name, a, b, c),
            [a, b, c, d] => self.of_four(name, a, b, c, d),
            _ => None,
        }?;
        (name == "BMOV" || !overlaps(&meaning)).then_some(meaning)
    }

    fn is_large(&self) -> bool {
        matches!(self.family, Family::Q | Family::L | Family::Iqr)
    }

    fn of_one(&mut self, name: &str, text: &str) -> Option<Meaning> {
        match name {
            "SWAP" if self.is_whole(text, 1) => {
                let from = self.value(text, 1)?;
                self.single_result(Operation::Each(Unary::SwapBytes), vec![from], text, 1)
            }
            "DATERD" if self.is_large() => {
                let output = Target::Words(self.places(text, 7)?);
                // Programs never read the cells of these clock registers: each read is a choice of its own. They hold
                // the chosen day, minute and second, which all DATERD of a scan then share.
                let registers = (210..213).map(|index| Cell { area: area("SD"), index });
                let chosen = registers.map(|cell| self.unchanging_word(cell)).collect();
                Some(meaning(Operation::Date, vec![OperationInput::Words(chosen)], output))
            }
            _ => None,
        }
    }

    fn of_two(&mut self, name: &str, from: &str, to: &str) -> Option<Meaning> {
        let (words, plain) = match name.strip_prefix('D') {
            Some(plain) if !matches!(name, "DBL" | "DEC") => (2, plain),
            _ => (1, name),
        };
        let one = |emitter: &mut Self, operation| {
            let value = emitter.value(from, words)?;
            emitter.single_result(operation, vec![value], to, words)
        };
        match plain {
            // The FX manuals do not say what happens to digits beyond the designation.
            "BCD" if self.is_large() || self.is_whole(to, words) => {
                one(self, Operation::Each(Unary::ToBcd))
            }
            "BIN" => one(self, Operation::Each(Unary::FromBcd)),
            "GRY" => one(self, Operation::Each(Unary::ToGray)),
            "GBIN" => one(self, Operation::Each(Unary::FromGray)),
            // The number of words that DSUM writes differs between families.
            "SUM" if words == 1 => one(self, Operation::CountBits(1)),
            "DBL" => {
                let value = self.value(from, 1)?;
                self.single_result(Operation::Resize(2), vec![value], to, 2)
            }
            "WORD" if words == 1 => {
                let value = self.value(from, 2)?;
                self.single_result(Operation::Resize(1), vec![value], to, 1)
            }
            "ROL" | "ROR" | "SFL" | "SFR" => self.moved(plain, from, to, words),
            "BSET" | "BRST" if words == 1 && self.is_bit_number(to, 16) => {
                let inputs = vec![self.value(from, 1)?, self.value(to, 1)?];
                self.single_result(Operation::PutBit(plain == "BSET"), inputs, from, 1)
            }
            "FLT" => {
                let value = self.value(from, words)?;
                self.single_result(Operation::ToReal, vec![value], to, 2)
            }
            "INT" => {
                let value = self.value(from, 2)?;
                self.single_result(Operation::FromReal(words as u8), vec![value], to, words)
            }
            "BINDA" if words == 1 && self.is_large() && !self.modes.uses_text_forms => {
                let value = self.value(from, 1)?;
                let output = Target::Words(self.places(to, 4)?);
                Some(meaning(Operation::ToDecimalText, vec![value], output))
            }
            "SECOND" => {
                let time = OperationInput::Words(self.cells(from, 3)?);
                self.single_result(Operation::ToSeconds, vec![time], to, 2)
            }
            "HOUR" if self.is_large() => {
                let seconds = self.value(from, 2)?;
                let output = Target::Words(self.places(to, 3)?);
                Some(meaning(Operation::FromSeconds, vec![seconds], output))
            }
            "FIFW" if words == 1 => self.appended(from, to),
            "E+" | "E-" if self.is_large() => {
                // With two operands, the second one is both the left operand and the destination.
                self.real(plain, to, from, to)
            }
            _ => None,
        }
    }

    /// Whether an operand is certainly a valid bit number below `bits`. Q and L use only its lowest bits, so that every
    /// number is valid; on the others another number may be an operation error.
    fn is_bit_number(&self, text: &str, bits: i64) -> bool {
        matches!(self.family, Family::Q | Family::L)
            || self.constant(text).is_some_and(|bit| (0..bits).contains(&bit))
    }

    /// Whether an operand is a device that covers all bits of this many words, and not only some digits.
    fn is_whole(&mut self, text: &str, words: usize) -> bool {
        match self.device(text).map(|device| device.place) {
            Some(Place::Digits(_, _, digits) | Place::IndexedDigits(_, digits)) => {
                usize::from(digits) == 4 * words
            }
            place => place.is_some(),
        }
    }

    /// The meaning of a rotation or shift of a number by a constant from 1 (0 on Q, L and iQ-R) to its number of bits
    /// minus 1. `None` for other counts, for which the families differ.
    fn moved(&mut self, name: &str, text: &str, by: &str, words: usize) -> Option<Meaning> {
        // A digit designation rotates within its own bits.
        if !self.is_whole(text, words) {
            return None;
        }
        let least = i64::from(!self.is_large());
        let places = self.constant(by).filter(|n| (least..16 * words as i64).contains(n))?;
        let left = name.ends_with('L');
        let operation = match name.starts_with("RO") {
            true => Operation::Rotate { left, through: false },
            // The FX uses these names for other instructions.
            false if !self.is_large() || words == 2 => return None,
            false => Operation::Shift { left, signed: false },
        };
        let constant = |value| OperationInput::Words(vec![WordSource::Const(value)]);
        let inputs = vec![self.value(text, words)?, constant(places as u16), constant(0)];
        let carry = match self.carry {
            Some(cell) => Target::Bits(vec![BitTarget::Cell(cell)]),
            None => Target::Nowhere,
        };
        let outputs = vec![self.target(text, words)?, carry];
        Some(Meaning { operation, inputs, outputs })
    }

    /// The meaning of an instruction that appends a value to a table and increments the table's count. `None` if an
    /// operand is not of a form that can be computed.
    fn appended(&mut self, from: &str, table: &str) -> Option<Meaning> {
        let value = self.value(from, 1)?;
        let &[WordSource::Cell(count)] = &self.cells(table, 1)?[..] else { return None };
        let letters = self.device(table)?.name;
        let term = Term::unsigned(WordSource::Cell(count));
        let base = i64::from(count.index) + 1;
        let behind = self.device_address((count.area, letters), base, vec![term])?;
        let words = |word| Box::new(Number::Words(vec![word]));
        let counted = Number::Add(words(WordSource::Cell(count)), words(WordSource::Const(1)));
        Some(Meaning {
            operation: Operation::Copy,
            inputs: vec![value, OperationInput::Number(counted)],
            outputs: vec![
                Target::Run(behind, Shape::Cells),
                Target::Words(vec![WordTarget::Cell(count)]),
            ],
        })
    }

    fn of_three(&mut self, name: &str, a: &str, b: &str, c: &str) -> Option<Meaning> {
        let (words, plain) = match name.strip_prefix('D') {
            Some(plain) if !matches!(name, "DIS" | "DIV" | "DECO") => (2, plain),
            _ => (1, name),
        };
        let size = words as u8;
        match plain {
            "*" | "MUL" => {
                let inputs = vec![self.value(a, words)?, self.value(b, words)?];
                if words == 2 {
                    let output = Target::Words(self.places(c, 4)?);
                    return Some(meaning(Operation::Multiply { signed: true }, inputs, output));
                }
                self.single_result(Operation::Multiply { signed: true }, inputs, c, 2)
            }
            "/" | "DIV" => {
                let inputs = vec![self.value(a, words)?, self.value(b, words)?];
                if let Place::Indexed(DeviceType::Word(_), false) = self.device(c)?.place {
                    let operation = Operation::DivideJoined { signed: true };
                    return self.single_result(operation, inputs, c, 2 * words);
                }
                let mut places = self.places(c, 2 * words)?;
                let rest = places.split_off(words);
                let operation = Operation::Divide { signed: true };
                let outputs = vec![Target::Words(places), Target::Words(rest)];
                Some(Meaning { operation, inputs, outputs })
            }
            "TEST" if self.is_bit_number(b, 16 * words as i64) => {
                let inputs = vec![self.value(a, words)?, self.value(b, 1)?];
                let output = self.bit_target(c)?;
                Some(meaning(Operation::PickBit, inputs, output))
            }
            "BON" => {
                let in_number = 0..16 * words as i64;
                self.constant(c).filter(|n| in_number.contains(n))?;
                let inputs = vec![self.value(a, words)?, self.value(c, 1)?];
                let output = self.bit_target(b)?;
                Some(meaning(Operation::PickBit, inputs, output))
            }
            "DECO" => self.decoded(a, b, c),
            "ENCO" if words == 1 => {
                let bits = self.bits(a, self.power(c)?)?;
                self.single_result(Operation::Encode, vec![bits], b, 1)
            }
            "BMOV" => {
                let many = self.element_count(c)?;
                let (from, to) = (self.run_of(a, 1, many)?, self.run_to(b, 1, many)?);
                Some(meaning(Operation::Copy, vec![from], to))
            }
            "FMOV" => {
                let many = self.element_count(c)?;
                let value = self.value(a, words)?;
                let to = self.run_to(b, words as u32, many)?;
                let times = match many {
                    ElementCount::Known(count) => WordSource::Const(u16::try_from(count).ok()?),
                    ElementCount::By(_) if self.family == Family::Fx => return None,
                    ElementCount::By(word) => word,
                };
                let inputs = vec![value, OperationInput::Words(vec![times])];
                Some(meaning(Operation::Repeat, inputs, to))
            }
            "BKBCD" | "BKBIN" => {
                let many = self.element_count(c)?;
                let (from, to) = (self.run_of(a, 1, many)?, self.run_to(b, 1, many)?);
                let unary = if plain == "BKBCD" { Unary::ToBcd } else { Unary::FromBcd };
                Some(meaning(Operation::EachWord(unary), vec![from], to))
            }
            "DIS" | "WTOB" | "UNI" | "BTOW" => self.parts(plain, a, b, c),
            "MAX" | "MIN" if self.is_large() => {
                let many = self.element_count(c)?;
                let from = self.run_of(a, words as u32, many)?;
                let output = Target::Words(self.places(b, words + 2)?);
                let operation = Operation::Extreme { words: size, greatest: plain == "MAX" };
                Some(meaning(operation, vec![from], output))
            }
            "WSUM" if self.is_large() => {
                let many = self.element_count(c)?;
                let from = self.run_of(a, words as u32, many)?;
                let output = Target::Words(self.places(b, 2 * words)?);
                Some(meaning(Operation::Total(size), vec![from], output))
            }
            "MEAN" => {
                // On the FX there are at most 64.
                let many = self.element_count(c)?;
                let is_few = matches!(many, ElementCount::Known(1..=64));
                if !is_few && !self.is_large() {
                    return None;
                }
                let from = self.run_of(a, words as u32, many)?;
                let output = Target::Words(self.places(b, words)?);
                Some(meaning(Operation::Mean(size), vec![from], output))
            }
            "E+" | "E-" | "E*" | "E/" | "EADD" | "ESUB" | "EMUL" | "EDIV" => {
                self.real(plain, a, b, c)
            }
            _ => None,
        }
    }

    fn of_four(&mut self, name: &str, a: &str, b: &str, c: &str, d: &str) -> Option<Meaning> {
        let (words, plain) = match name.strip_prefix('D') {
            Some(plain) => (2, plain),
            None => (1, name),
        };
        let control = match plain {
            "LIMIT" => Some(Operation::Limit),
            "BAND" => Some(Operation::Band),
            "ZONE" => Some(Operation::Zone),
            _ => None,
        };
        if let Some(symbol) = plain.strip_prefix("BKCMP") {
            return self.blocks_compared(symbol, words, [a, b, c, d]);
        }
        if let Some(operation) = control {
            let inputs = vec![self.value(a, words)?, self.value(b, words)?, self.value(c, words)?];
            return self.single_result(operation, inputs, d, words);
        }
        match plain {
            // The FX instruction has its operands in another order, and more results.
            "SER" if matches!(self.family, Family::Q | Family::L) => {
                let wanted = self.value(a, words)?;
                let many = self.element_count(d)?;
                let list = self.run_of(b, words as u32, many)?;
                let output = Target::Words(self.places(c, 2)?);
                let halving = self.modes.uses_binary_search;
                Some(meaning(Operation::Find { halving }, vec![wanted, list], output))
            }
            _ => None,
        }
    }

    /// The meaning of a comparison of two blocks, of which the first may be a constant, with numbers of `words` words.
    fn blocks_compared(
        &mut self,
        symbol: &str,
        words: usize,
        [a, b, to, count]: [&str; 4],
    ) -> Option<Meaning> {
        let unsigned = symbol.strip_suffix("_U");
        let relation = relation(unsigned.unwrap_or(symbol))?;
        let many = self.element_count(count)?;
        let ElementCount::Known(count) = many else { return None };
        let first = match self.constant(a) {
            Some(_) => {
                let one = self.read_words(a, words)?;
                OperationInput::Words(one.repeat(count as usize))
            }
            None => self.run_of(a, words as u32, many)?,
        };
        let inputs = vec![first, self.run_of(b, words as u32, many)?];
        let holds: Vec<BitTarget> = match self.device(to)?.place {
            Place::At(DeviceType::Bit(area), index) => {
                (index..index + count).map(|index| BitTarget::Cell(Cell { area, index })).collect()
            }
            Place::BitOf(DeviceType::Word(area), index, bit) if u32::from(bit) + count <= 16 => {
                let bits = bit..bit + count as u8;
                bits.map(|bit| BitTarget::WordBit(Cell { area, index }, bit)).collect()
            }
            _ => return None,
        };
        let all = self.block_result.map(BitTarget::Cell).into_iter().collect();
        Some(Meaning {
            operation: Operation::CompareEach {
                relation,
                signed: unsigned.is_none(),
                words: words as u8,
            },
            inputs,
            outputs: vec![Target::Bits(holds), Target::Bits(all)],
        })
    }

    /// The meaning of DECO: sets one of 2^n bits, whose number is the value of `from`, and clears the others. `None`
    /// for bits that only fill a part of a word.
    fn decoded(&mut self, from: &str, to: &str, power: &str) -> Option<Meaning> {
        let power = self.power(power)?;
        let number = match self.device(from).map(|device| device.place) {
            Some(Place::At(DeviceType::Bit(area), index)) => {
                let first = Cell { area, index };
                OperationInput::Words(vec![WordSource::Bits { first, count: power as u8 }])
            }
            _ => self.value(from, 1)?,
        };
        let output = match self.device(to)?.place {
            Place::At(DeviceType::Bit(area), index) => {
                let cells = (index..index + (1 << power)).map(|index| Cell { area, index });
                Target::Bits(cells.map(BitTarget::Cell).collect())
            }
            // Whether the other bits of the word change is not documented.
            Place::At(DeviceType::Word(_), _) if power >= 4 && self.codes_in_words(power) => {
                let cells = self.places(to, 1 << (power - 4))?;
                let bits = cells.into_iter().filter_map(|target| match target {
                    WordTarget::Cell(cell) => {
                        Some((0..16).map(move |n| BitTarget::WordBit(cell, n)))
                    }
                    _ => None,
                });
                Target::Bits(bits.flatten().collect())
            }
            _ => return None,
        };
        let bits = OperationInput::Words(vec![WordSource::Const(power as u16)]);
        Some(meaning(Operation::Decode, vec![number, bits], output))
    }

    fn power(&self, text: &str) -> Option<i64> {
        self.constant(text).filter(|power| (1..=MAX_EXPONENT).contains(power))
    }

    /// Whether DECO and ENCO accept the exponent `power` for word operands. On the FX and FX5 the bits must fit in one
    /// word.
    fn codes_in_words(&self, power: i64) -> bool {
        self.is_large() || power <= 4
    }

    /// The 2^`power` bits from an operand on, as the input of an operation. `None` if their cells are unknown.
    fn bits(&mut self, text: &str, power: i64) -> Option<OperationInput> {
        match self.device(text)?.place {
            Place::At(DeviceType::Bit(area), index) => {
                let cells = (index..index + (1 << power)).map(|index| Cell { area, index });
                Some(OperationInput::Bits(cells.map(BitSource::Cell).collect()))
            }
            Place::At(DeviceType::Word(_), _) if self.codes_in_words(power) => {
                let cells = self.cells(text, (1usize << power).div_ceil(16))?;
                let bits = (0..1usize << power).map(|n| match cells[n / 16] {
                    WordSource::Cell(cell) => Some(BitSource::WordBit(cell, (n % 16) as u8)),
                    _ => None,
                });
                Some(OperationInput::Bits(bits.collect::<Option<_>>()?))
            }
            _ => None,
        }
    }

    /// The meaning of an instruction that splits words into digits or bytes, or combines them. `None` if the count is
    /// unknown or too large, or an operand is not of a form that can be computed.
    fn parts(&mut self, name: &str, from: &str, to: &str, count: &str) -> Option<Meaning> {
        let by_digit = matches!(name, "DIS" | "UNI");
        let most = if by_digit { 4 } else { i64::from(FX_MAX) };
        let count = self.constant(count).filter(|count| (1..=most).contains(count))? as usize;
        let bits = if by_digit { 4 } else { 8 };
        let wide = count.div_ceil(16 / bits);
        if matches!(name, "DIS" | "WTOB") {
            let counted = OperationInput::Words(vec![WordSource::Const(count as u16)]);
            let inputs = vec![OperationInput::Words(self.cells(from, wide)?), counted];
            let output = Target::Words(self.places(to, count)?);
            return Some(meaning(Operation::Split(bits as u8), inputs, output));
        }
        // The high byte of the last word is not documented for an odd count.
        if name == "BTOW" && count % 2 == 1 {
            return None;
        }
        let inputs = vec![OperationInput::Words(self.cells(from, count)?)];
        let output = Target::Words(self.places(to, wide)?);
        Some(meaning(Operation::Combine(bits as u8), inputs, output))
    }

    fn real(&mut self, name: &str, a: &str, b: &str, to: &str) -> Option<Meaning> {
        // The FX converts integer constants to real numbers.
        if self.constant(a).or(self.constant(b)).is_some() {
            return None;
        }
        let arithmetic = match &name[1..] {
            "+" | "ADD" => Arithmetic::Add,
            "-" | "SUB" => Arithmetic::Sub,
            "*" | "MUL" => Arithmetic::Multiply,
            _ => Arithmetic::Divide,
        };
        let inputs = vec![self.value(a, 2)?, self.value(b, 2)?];
        self.single_result(Operation::Real(arithmetic), inputs, to, 2)
    }

    /// The meaning of an operation whose result is one number of `words` words, written to `to`. `None` if the cells of
    /// `to` are unknown.
    fn single_result(
        &mut self,
        operation: Operation,
        inputs: Vec<OperationInput>,
        to: &str,
        words: usize,
    ) -> Option<Meaning> {
        Some(meaning(operation, inputs, self.target(to, words)?))
    }

    fn value(&mut self, text: &str, words: usize) -> Option<OperationInput> {
        self.number(text, words).map(OperationInput::Number)
    }

    /// The words from a plain word device, timer or counter on, as sources. `None` if a cell is unknown, or for other
    /// operands.
    fn cells(&mut self, text: &str, count: usize) -> Option<Vec<WordSource>> {
        let Place::At(DeviceType::Word(_) | DeviceType::Timed(_), _) = self.device(text)?.place
        else {
            return None;
        };
        let words = self.read_words(text, count)?;
        words.iter().all(|word| matches!(word, WordSource::Cell(_))).then_some(words)
    }

    /// The words from a plain word device on, as targets of a write. `None` if a cell is unknown, or for other
    /// operands.
    fn places(&mut self, text: &str, count: usize) -> Option<Vec<WordTarget>> {
        let Place::At(DeviceType::Word(_), _) = self.device(text)?.place else { return None };
        match self.word_place(text, count)? {
            WordPlace::All(targets) => Some(targets),
            _ => None,
        }
    }

    fn bit_target(&mut self, text: &str) -> Option<Target> {
        match self.bit_place(text)? {
            BitPlace::One(target) => Some(Target::Bits(vec![target])),
            _ => None,
        }
    }

    /// The largest number of elements of a block that is modelled for this family.
    pub(super) fn most_elements(&self) -> u32 {
        if self.is_large() { MAX_ELEMENTS } else { FX_MAX }
    }

    /// The number of elements of a block, which a constant or a word gives. `None` for other operands, and for
    /// constants that are not modelled.
    fn element_count(&mut self, text: &str) -> Option<ElementCount> {
        let most = self.most_elements();
        match self.constant(text) {
            Some(count) => {
                let count = u32::try_from(count).ok()?;
                (1..=most).contains(&count).then_some(ElementCount::Known(count))
            }
            None => Some(ElementCount::By(self.cells(text, 1)?[0])),
        }
    }

    /// `many` elements of `unit` words from an operand on, as the input of an operation. `None` if their addresses are
    /// unknown.
    fn run_of(&mut self, text: &str, unit: u32, many: ElementCount) -> Option<OperationInput> {
        let address = match (many, self.device(text)?.place) {
            (ElementCount::Known(count), Place::At(..)) => {
                return Some(OperationInput::Words(self.cells(text, (count * unit) as usize)?));
            }
            (ElementCount::Known(count), Place::Digits(DeviceType::Bit(area), first, 4))
                if unit == 1 && self.is_large() =>
            {
                let part =
                    |n| WordSource::Bits { first: Cell { area, index: first + 16 * n }, count: 16 };
                return Some(OperationInput::Words((0..count).map(part).collect()));
            }
            _ => self.from(text, unit)?,
        };
        let count = match many {
            ElementCount::Known(count) => Count::Exactly(count * unit),
            ElementCount::By(word) => {
                let most = self.most_elements();
                let term = Term {
                    words: vec![word],
                    format: IntegerFormat::Signed,
                    factor: i64::from(unit),
                };
                Count::Of { term, least: unit, most: most * unit }
            }
        };
        Some(OperationInput::Run(address, Shape::Cells, count))
    }

    /// `many` elements of `unit` words from an operand on, as the target of an operation. `None` if their addresses are
    /// unknown.
    fn run_to(&mut self, text: &str, unit: u32, many: ElementCount) -> Option<Target> {
        match (many, self.device(text)?.place) {
            (ElementCount::Known(count), Place::At(..)) => {
                Some(Target::Words(self.places(text, (count * unit) as usize)?))
            }
            (ElementCount::Known(count), Place::Digits(DeviceType::Bit(area), first, 4))
                if unit == 1 && self.is_large() =>
            {
                let part =
                    |n| WordTarget::Bits { first: Cell { area, index: first + 16 * n }, count: 16 };
                Some(Target::Words((0..count).map(part).collect()))
            }
            _ => Some(Target::Run(self.from(text, unit)?, Shape::Cells)),
        }
    }

    /// The address of a block with elements of `unit` words that begins at a word device, plain or indexed. `None` if
    /// it is unknown.
    fn from(&mut self, text: &str, unit: u32) -> Option<Address> {
        let device = self.device(text)?;
        if let Place::Indexed(DeviceType::Word(_), false) = device.place {
            // On the FX, the index of a double word has 32 bits.
            let is_wide = self.family == Family::Fx && unit > 1;
            return self.indexed(&device, 0).filter(|_| !is_wide);
        }
        if let Some(address) = self.indirect_address(&device) {
            return Some(address);
        }
        let &[WordSource::Cell(cell)] = &self.cells(text, 1)?[..] else { return None };
        self.device_address((cell.area, device.name), i64::from(cell.index), Vec::new())
    }
}

fn meaning(operation: Operation, inputs: Vec<OperationInput>, output: Target) -> Meaning {
    Meaning { operation, inputs, outputs: vec![output] }
}

/// Whether the written block may overlap with a block that is read, so that the order of the moves matters.
fn overlaps(meaning: &Meaning) -> bool {
    let reads: Vec<Cell> = meaning
        .inputs
        .iter()
        .filter_map(|input| match input {
            OperationInput::Words(words) => Some(words),
            OperationInput::Number(Number::Words(words)) => Some(words),
            _ => None,
        })
        .flatten()
        .filter_map(|word| match word {
            WordSource::Cell(cell) => Some(*cell),
            _ => None,
        })
        .collect();
    let writes: Vec<Cell> = meaning
        .outputs
        .iter()
        .filter_map(|output| match output {
            Target::Words(words) => Some(words),
            _ => None,
        })
        .flatten()
        .filter_map(|word| match word {
            WordTarget::Cell(cell) => Some(*cell),
            _ => None,
        })
        .collect();
    let is_block = matches!(
        meaning.operation,
        Operation::EachWord(_) | Operation::Split(_) | Operation::Combine(_) | Operation::Repeat
    );
    let runs = |meaning: &Meaning| {
        meaning.inputs.iter().any(|input| matches!(input, OperationInput::Run(..)))
            || meaning.outputs.iter().any(|output| matches!(output, Target::Run(..)))
    };
    is_block
        && (writes.iter().any(|cell| reads.contains(cell))
            || (runs(meaning) && !matches!(meaning.operation, Operation::Repeat)))
}
