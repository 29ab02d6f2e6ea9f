//! Parses addresses and constants of a family, and says what they stand for in a program of `ir`.

use std::collections::BTreeSet;

use super::memory::{AreaUse, BitBehavior, Memory};
use super::source::{Family, Symbol, Symbols};
use scanbound_ir::{AreaId, BitSource, BitTarget, Cell, ChoiceId, Region, WordSource};

/// The notation of a constant. It decides whether the constant is read as BCD or binary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Notation {
    /// `#1234`: hexadecimal digits, BCD where the instruction wants BCD.
    Digits,
    /// A decimal number with a prefix or sign: `&10`, `+10`, `-5`.
    Decimal,
    /// `000`: a plain number without prefix.
    Bare,
}

/// A parsed operand.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Operand {
    /// A constant and its notation.
    Constant(i64, Notation),
    /// A real number, such as `+1.5`.
    Real(f32),
    /// A string, such as `"text"`.
    Text,
    /// A word, or the first of several words.
    Word(Cell),
    /// A completion flag or a condition flag.
    Flag(Cell),
    /// A bit of a word, 0 to 15.
    Bit(Cell, u8),
    /// The present value of a timer or counter, which the system changes at any time. It is not modelled.
    Register,
    /// An unknown word of these areas: `*D6`, `@D80`, the current bank of E.
    Within(Vec<AreaId>),
    /// An unknown word of any area, which an index register selects.
    Anywhere,
}

/// Why an operand is invalid, and what the user can do.
pub(super) type OperandError = (String, &'static str);

const FORMS: &str = "write addresses such as 00305, 100.00, W10.00, D100, DM 0100, T0010, and constants such as #1234, &10, +1.5";

/// What kind of operand is expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Expected {
    /// A word or a constant. A plain number is the number of a word.
    Word,
    /// A bit. In a plain number, the last two digits are the bit: `00305` is bit 5 of word 3.
    Bit,
    /// A plain number, such as that of a jump or a subroutine.
    Number,
    /// A timer or counter number. A number without letters belongs to the area that has these letters.
    Completion(&'static str),
}

/// What is needed to parse operands: the memory, and the visible symbols, local ones first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reader<'a> {
    pub(super) memory: Memory,
    pub(super) symbols: [&'a Symbols; 2],
    /// The completion flags of timers that may time out between instructions.
    pub(super) fast: &'a BTreeSet<Cell>,
}

impl Reader<'_> {
    /// Parses an operand: a text, a constant, a symbol or an address. `want` decides how numbers without an area are
    /// read.
    pub(super) fn read(&self, text: &str, want: Expected) -> Result<Operand, OperandError> {
        let text = text.trim();
        if text.starts_with('"') || text.starts_with('\'') {
            return Ok(Operand::Text);
        }
        if let Some(constant) = constant(text)? {
            return Ok(constant);
        }
        if let Expected::Number | Expected::Completion(_) = want
            && is_digits(text)
        {
            let value = text.parse().map_err(|_| too_large(text))?;
            return match want {
                Expected::Completion(letters) => self.completion(letters, value),
                _ => Ok(Operand::Constant(i64::from(value), Notation::Bare)),
            };
        }
        if let Some(resolved) = self.resolve(text, want, false)? {
            return Ok(resolved);
        }
        if let Some(address) = self.address(text, want) {
            return address;
        }
        // Symbols are not case-sensitive, but nearly all are written as they are defined, so that is tried first.
        self.resolve(text, want, true)?
            .ok_or_else(|| (format!("'{text}' is not an address or a known symbol"), FORMS))
    }

    fn completion(&self, letters: &str, index: u32) -> Result<Operand, OperandError> {
        let (area, _) = self.memory.area(letters).ok_or_else(|| no_area(letters))?;
        self.checked(area, index, letters).map(Operand::Flag)
    }

    /// Parses the name of a symbol, with or without an index in brackets, and gives the operand at its address. With
    /// `folded`, upper and lower case are equal. `None` if the text is not the name of a symbol.
    fn resolve(
        &self,
        text: &str,
        want: Expected,
        folded: bool,
    ) -> Result<Option<Operand>, OperandError> {
        let (name, index) = match text.strip_suffix(']').and_then(|rest| rest.split_once('[')) {
            Some((name, index)) => (name, Some(index)),
            None => (text, None),
        };
        if let Some(address) = self.memory.symbol(name) {
            if address.is_empty() {
                return Err((
                    format!("'{name}' does not exist on the C series"),
                    "write the address of the bit",
                ));
            }
            return self.address(address, want).transpose();
        }
        let found = self.symbols.iter().find_map(|symbols| {
            symbols.get(name).or_else(|| {
                if !folded {
                    return None;
                }
                symbols
                    .iter()
                    .find(|(known, _)| known.eq_ignore_ascii_case(name))
                    .map(|(_, symbol)| symbol)
            })
        });
        let Some(symbol) = found else { return Ok(None) };
        let address = symbol.address.trim();
        if address.is_empty() {
            return Err((
                format!("the symbol '{name}' has no address"),
                "CX-Programmer assigns it automatically: state an address, or export the project after compiling it",
            ));
        }
        if symbol.kind.eq_ignore_ascii_case("NUMBER") {
            let value = constant(address)?.or_else(|| {
                address.parse().ok().map(|value| Operand::Constant(value, Notation::Decimal))
            });
            return value.map(Some).ok_or_else(|| {
                (format!("the symbol '{name}' is not a number: '{address}'"), FORMS)
            });
        }
        let base = match self.address(address, want) {
            Some(base) => base?,
            None => {
                return Err((
                    format!("the symbol '{name}' has an invalid address '{address}'"),
                    FORMS,
                ));
            }
        };
        let Some(index) = index else { return Ok(Some(base)) };
        Ok(Some(element(base, symbol, index, self.memory)))
    }

    /// Parses an address; `None` if the text does not look like one.
    fn address(&self, text: &str, want: Expected) -> Option<Result<Operand, OperandError>> {
        let upper = text.to_ascii_uppercase();
        // Index registers: `,IR0`, `+5,IR0`, `DR0,IR0`, with increment or decrement: `,IR0+`, `,IR0++`, `,-IR0`,
        // `,--IR0`.
        if upper.split_once(',').is_some_and(|(_, register)| {
            register.trim_start().trim_start_matches('-').starts_with("IR")
        }) {
            return Some(Ok(Operand::Anywhere));
        }
        if self.memory.family == Family::Cs
            && (is_numbered(&upper, "IR") || is_numbered(&upper, "DR"))
        {
            let number = upper[2..].parse().unwrap_or(u32::MAX);
            let register = match upper.starts_with('I') {
                true => self.memory.index_register(number),
                false => self.memory.data_register(number),
            };
            let missing =
                || (format!("register {text} does not exist"), "use IR0 to IR15 or DR0 to DR15");
            return Some(register.map(Operand::Word).ok_or_else(missing));
        }
        if let Some(pointer) = upper.strip_prefix(['*', '@']) {
            if pointer.starts_with(['*', '@']) {
                return None;
            }
            return Some(self.address(pointer, Expected::Word)?.map(|place| match place {
                Operand::Word(cell) => Operand::Within(self.memory.reach(cell.area)),
                _ => Operand::Anywhere,
            }));
        }
        // Array elements: `D100[W0]`, `D100[5]`.
        if let Some((base, index)) = upper.strip_suffix(']').and_then(|rest| rest.split_once('[')) {
            let base = self.address(base, Expected::Word)?;
            return Some(base.map(|base| {
                match (base, index.trim_start_matches('&').parse::<u16>().map(u32::from)) {
                    (Operand::Word(cell), Ok(index)) => Operand::Word(cell.plus(index)),
                    (Operand::Word(cell), Err(_)) => Operand::Within(vec![cell.area]),
                    _ => Operand::Anywhere,
                }
            }));
        }
        let split = upper.find(|c: char| c.is_ascii_digit())?;
        let (mut letters, mut digits) = (upper[..split].trim(), &upper[split..]);
        let mut bank = None;
        if let Some((number, rest)) = upper.strip_prefix('E').and_then(|rest| rest.split_once('_'))
        {
            bank = Some(self.memory.bank(number)?);
            (letters, digits) = ("", rest);
        }
        let (number, bit) = match digits.split_once('.') {
            Some((number, bit)) => (number, Some(bit)),
            None => (digits, None),
        };
        if !is_digits(number) || bit.is_some_and(|bit| !is_digits(bit) || bit.len() > 2) {
            return None;
        }
        if letters == "E" || (letters == "EM" && self.memory.family == Family::C) {
            return Some(Ok(Operand::Within(self.memory.extended())));
        }
        let (area, role) = match bank {
            Some(area) => (area, AreaUse::Words),
            None => self.memory.area(letters)?,
        };
        Some(self.place(area, role, letters, number, bit, want))
    }

    fn place(
        &self,
        area: AreaId,
        role: AreaUse,
        letters: &str,
        number: &str,
        bit: Option<&str>,
        want: Expected,
    ) -> Result<Operand, OperandError> {
        let mut index: u32 = number.parse().map_err(|_| too_large(number))?;
        match role {
            AreaUse::Words | AreaUse::Values => {
                let mut place = bit.map(|bit| bit.parse::<u8>().unwrap_or(u8::MAX));
                let joined = self.memory.family == Family::C || letters.is_empty();
                if want == Expected::Bit
                    && place.is_none()
                    && joined
                    && letters != "DM"
                    && letters != "D"
                {
                    // In `00305`, the last two digits are the bit number.
                    place = Some((index % 100) as u8);
                    index /= 100;
                }
                let cell = self.checked(area, index, letters)?;
                match place {
                    Some(bit @ 0..16) => Ok(Operand::Bit(cell, bit)),
                    Some(bit) => Err((
                        format!("a word has no bit {bit}"),
                        "bits are 00 to 15; in 00305 the last two digits are the bit",
                    )),
                    None => Ok(Operand::Word(cell)),
                }
            }
            AreaUse::Flags(values) => {
                let cell = self.checked(area, index, letters)?;
                match want {
                    // A current value that the system changes is not modelled, like a register.
                    Expected::Word if self.fast.contains(&cell) => Ok(Operand::Register),
                    Expected::Word => {
                        Ok(Operand::Word(Cell { area: AreaId(values as u16), index: cell.index }))
                    }
                    _ => Ok(Operand::Flag(cell)),
                }
            }
            AreaUse::Conditions | AreaUse::Memories => {
                self.checked(area, index, letters).map(Operand::Flag)
            }
        }
    }

    fn checked(&self, area: AreaId, index: u32, letters: &str) -> Result<Cell, OperandError> {
        let size = self.memory.size(area);
        if index < size {
            return Ok(Cell { area, index });
        }
        let what = if letters.is_empty() { "word" } else { letters };
        Err((
            format!("{what} {index} does not exist"),
            "check the address, and check that the file's dialect was recognised correctly",
        ))
    }
}

/// The index register that an operand increments or decrements: `,IR0+`, `,IR0++`, `,-IR0`, `,--IR0`. `None` if it does
/// neither, and on the C series.
pub(super) fn moved_register(text: &str, memory: Memory) -> Option<Cell> {
    let (_, register) = text.split_once(',')?;
    let plain = register.trim().trim_matches(['+', '-']);
    let number = plain.to_ascii_uppercase().strip_prefix("IR")?.parse().ok()?;
    (plain != register.trim()).then(|| memory.index_register(number)).flatten()
}

/// The element with number `index` of an array that begins at `base`. If the index is not a number, the result stands
/// for any element.
fn element(base: Operand, symbol: &Symbol, index: &str, memory: Memory) -> Operand {
    let kind = symbol.kind.to_ascii_uppercase();
    let size = match kind.split('[').next().unwrap_or_default().trim() {
        "DINT" | "UDINT" | "UDINT_BCD" | "DWORD" | "REAL" => 2,
        "LINT" | "ULINT" | "ULINT_BCD" | "LWORD" | "LREAL" => 4,
        _ => 1,
    };
    match (base, index.trim().trim_start_matches('&').parse::<u16>().map(u32::from)) {
        (Operand::Word(cell), Ok(index)) => Operand::Word(cell.plus(index.saturating_mul(size))),
        (Operand::Bit(cell, bit), Ok(index)) => {
            let bits = u32::from(bit) + index;
            Operand::Bit(cell.plus(bits / 16), (bits % 16) as u8)
        }
        (Operand::Word(cell) | Operand::Bit(cell, _), Err(_)) => {
            Operand::Within(memory.reach(cell.area))
        }
        (Operand::Flag(cell), Ok(index)) => Operand::Flag(cell.plus(index)),
        _ => Operand::Anywhere,
    }
}

/// Parses a constant; `None` if the text is not one.
fn constant(text: &str) -> Result<Option<Operand>, OperandError> {
    if let Some(digits) = text.strip_prefix('#') {
        let fits = !digits.is_empty()
            && digits.len() <= 16
            && digits.bytes().all(|b| b.is_ascii_hexdigit());
        return match u64::from_str_radix(digits, 16) {
            Ok(value) if fits => Ok(Some(Operand::Constant(value.cast_signed(), Notation::Digits))),
            _ => Err((
                format!("'{text}' is not a constant"),
                "write BCD or hexadecimal digits after #",
            )),
        };
    }
    let Some(sign) = text.chars().next().filter(|c| ['&', '+', '-'].contains(c)) else {
        return Ok(None);
    };
    let digits = &text[1..];
    if text.contains(',') {
        return Ok(None);
    }
    let real = digits.contains('.') || digits.bytes().any(|b| b.eq_ignore_ascii_case(&b'e'));
    if real && sign != '&' {
        return match text.parse::<f32>() {
            Ok(value) if value.is_finite() => Ok(Some(Operand::Real(value))),
            _ => Err((format!("'{text}' is not a number"), FORMS)),
        };
    }
    let value: Option<i64> = is_digits(digits).then(|| digits.parse().ok()).flatten();
    match value {
        Some(value) => {
            let value = if sign == '-' { -value } else { value };
            Ok(Some(Operand::Constant(value, Notation::Decimal)))
        }
        None => Err((format!("'{text}' is not a number"), FORMS)),
    }
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

fn is_numbered(text: &str, letters: &str) -> bool {
    // At most two digits: `IR 00001` of the C series is a bit.
    text.strip_prefix(letters).is_some_and(|rest| is_digits(rest) && rest.len() <= 2)
}

fn too_large(text: &str) -> OperandError {
    (format!("the number {text} is too large"), FORMS)
}

fn no_area(letters: &str) -> OperandError {
    (format!("area {letters} does not exist"), FORMS)
}

/// A function that makes a new choice (nondeterministic value) for an unknown value.
pub(super) type NewChoice<'a> = &'a mut dyn FnMut() -> ChoiceId;

impl Operand {
    /// The sources of `count` words of the operand, the lowest first. A word that the system may change, that is not
    /// modelled or whose address is unknown is a new choice. `None` if the operand cannot be read as words.
    pub(super) fn sources(
        &self,
        count: u32,
        memory: Memory,
        choice: NewChoice<'_>,
    ) -> Option<Vec<WordSource>> {
        let constant = |bits: i64| {
            (0..count).map(|i| WordSource::Const((bits >> (16 * i.min(3))) as u16)).collect()
        };
        Some(match self {
            Operand::Constant(value, _) => constant(*value),
            Operand::Real(value) => constant(i64::from(value.to_bits())),
            Operand::Word(first) => (0..count)
                .map(|i| first.plus(i))
                .map(|cell| {
                    if memory.is_volatile(cell) {
                        WordSource::Free(choice())
                    } else {
                        WordSource::Cell(cell)
                    }
                })
                .collect(),
            Operand::Register | Operand::Within(_) | Operand::Anywhere => {
                (0..count).map(|_| WordSource::Free(choice())).collect()
            }
            Operand::Flag(_) | Operand::Bit(..) | Operand::Text => return None,
        })
    }

    /// The source of the operand as a bit. A bit that the system may change, or whose address is unknown, is a new
    /// choice. `None` if the operand is not a bit.
    pub(super) fn bit_source(&self, memory: Memory, choice: NewChoice<'_>) -> Option<BitSource> {
        let (nature, held) = match self {
            Operand::Flag(cell) => (memory.cell_behavior(*cell), BitSource::Cell(*cell)),
            Operand::Bit(cell, bit) => {
                (memory.bit_behavior(*cell, *bit), BitSource::WordBit(*cell, *bit))
            }
            Operand::Within(_) | Operand::Anywhere => return Some(BitSource::Free(choice())),
            _ => return None,
        };
        Some(match nature {
            BitBehavior::Held => held,
            BitBehavior::Fixed(value) => BitSource::Const(value),
            BitBehavior::Volatile => BitSource::Free(choice()),
        })
    }

    /// The write target for a bit. `None` if the operand is not a bit, or its address is unknown.
    pub(super) fn bit_target(&self) -> Option<BitTarget> {
        match self {
            Operand::Flag(cell) => Some(BitTarget::Cell(*cell)),
            Operand::Bit(cell, bit) => Some(BitTarget::WordBit(*cell, *bit)),
            _ => None,
        }
    }

    /// The regions that a write of `count` words to the operand may change. If `count` is `None`: the whole area of a
    /// word or bit. A flag is always its one cell; an operand whose address is unknown is always all areas that it may
    /// be in. Empty for constants, texts and present values that are not modelled.
    pub(super) fn regions(&self, count: Option<u32>) -> Vec<Region> {
        match (self, count) {
            (Operand::Word(first) | Operand::Bit(first, _), Some(count)) => {
                vec![Region::Range { first: *first, count }]
            }
            (Operand::Word(cell) | Operand::Bit(cell, _), None) => vec![Region::Area(cell.area)],
            (Operand::Flag(cell), _) => vec![Region::Range { first: *cell, count: 1 }],
            (Operand::Within(areas), _) => areas.iter().map(|&area| Region::Area(area)).collect(),
            (Operand::Anywhere, _) => vec![Region::Everything],
            (Operand::Constant(..) | Operand::Real(_) | Operand::Text | Operand::Register, _) => {
                vec![]
            }
        }
    }

    /// The value of a constant as a number of words or iterations. After `#`, its digits are decimal on the C series
    /// and hexadecimal on CS, CJ and CP. `None` if the operand is not a valid constant.
    pub(super) fn count(&self, family: Family) -> Option<u32> {
        let &Operand::Constant(value, notation) = self else { return None };
        let value = u32::try_from(value).ok()?;
        match (family, notation) {
            (Family::C, Notation::Digits) => {
                let text = format!("{value:X}");
                is_digits(&text).then(|| text.parse().ok()).flatten()
            }
            _ => Some(value),
        }
    }

    /// The address of the word. `None` if the operand is not a word.
    pub(super) fn word(&self) -> Option<Cell> {
        match self {
            Operand::Word(cell) => Some(*cell),
            _ => None,
        }
    }

    /// Whether the address is known only at run time, so that an invalid one may be an error.
    pub(super) fn is_indirect(&self) -> bool {
        matches!(self, Operand::Within(_) | Operand::Anywhere)
    }
}
