//! What OMRON instructions really do where the effects say any value.

use super::assembly::Assembly;
use super::catalog::Amount;
use super::data;
use super::extent;
use super::operand::Operand;
use super::resolve::Item;
use super::source::Family;
use scanbound_front::builder::fired;
use scanbound_ir::meaning::{
    Address, Count, Meaning, Operand as Input, Operation, Shape, Target, Term, Unary,
};
use scanbound_ir::{
    AreaId, BitSource, BitTarget, Cell, Compare, Effect, Logic, Number, NumberFormat, Region,
    Relation, WordSource, WordTarget, Write,
};

/// What is known of an instruction whose written operands are taken as any value.
#[derive(Debug, Clone, PartialEq)]
struct Exactly {
    meaning: Meaning,
    /// Whether the last output is the carry flag.
    carries: bool,
}

/// What is known of an instruction's result, which the flags behind it tell of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Nothing.
    Unknown,
    /// An operation gives it, with the flags that it tells: where it ends in an error, these are left as they were.
    Worked,
    /// It is written whenever the instruction fires, so the flags can be read off what was written.
    Written,
}

/// The writes of an instruction that may leave any value, with what it really does where that is known; whether it is.
pub(super) fn writes(asm: &mut Assembly, item: &Item<'_>) -> (Vec<Write>, Outcome) {
    let exactly = match item.operands.iter().any(Operand::is_indirect) {
        true => None,
        false => meaning(asm, item),
    };
    let choice = asm.choice();
    let mut writes = data::havoc(asm, item, choice);
    let Some(Exactly { mut meaning, carries }) = exactly else {
        return (writes, Outcome::Unknown);
    };
    let mut flags: Vec<BitTarget> = asm.memory.flag("CY").filter(|_| carries).into_iter().collect();
    if let Some(result) = result(item).filter(|_| tells(item)) {
        let operation = Box::new(meaning.operation);
        meaning.operation = Operation::WithFlags { operation, words: result.len() as u8 };
        for flag in ["EQ", "N"] {
            let told = asm.memory.flag(flag).filter(|_| is_told(item, flag));
            meaning.outputs.push(told.map_or(Target::Nowhere, |flag| Target::Bits(vec![flag])));
            flags.extend(told);
        }
    }
    asm.exactly(choice, meaning);
    writes.extend(flags.into_iter().map(|flag| {
        let (BitTarget::Cell(first) | BitTarget::WordBit(first, _)) = flag;
        Write::Havoc(Region::Range { first, count: 1 }, choice)
    }));
    (writes, Outcome::Worked)
}

/// Whether the carry flag comes with the result.
fn carries(name: &str, family: Family) -> bool {
    match name {
        "INC" | "DEC" | "SLD" | "SRD" => false,
        "ADD" | "SUB" | "ADDL" | "SUBL" | "ADB" | "SBB" => family == Family::C,
        _ => true,
    }
}

/// Whether the instruction's flags tell of its result.
fn tells(item: &Item<'_>) -> bool {
    item.row.is_none_or(|row| row.extra.flags == "*")
}

/// Whether this flag is what the result says.
fn is_told(item: &Item<'_>, flag: &str) -> bool {
    match flag {
        // No manual says whether the remainder counts.
        "EQ" => !matches!(&*item.name, "DIV" | "DIVL" | "DVB" | "/B" | "/BL"),
        // Of decimal results the manuals name none.
        "N" => !item.name.contains('B'),
        _ => false,
    }
}

/// The condition flags behind an instruction: those that its result tells, and any value for the others.
pub(super) fn flags(asm: &mut Assembly, item: &Item<'_>, outcome: Outcome) -> Vec<Effect> {
    let told = outcome != Outcome::Unknown && tells(item);
    let Some(result) = result(item).filter(|_| told) else {
        return data::flags(asm, item).into_iter().map(fired).collect();
    };
    let carry = carry_of(asm, item);
    let mut effects = Vec::new();
    for flag in ["ER", "GT", "EQ", "LT", "GE", "NE", "LE", "N", "OF", "UF", "AER", "CY"] {
        let Some(target) = asm.memory.flag(flag) else { continue };
        let value = match (flag, &carry) {
            ("CY", Carried::Apart(_) | Carried::Within) => continue,
            (flag, _) if !is_told(item, flag) => None,
            _ if outcome == Outcome::Worked => continue,
            ("EQ", _) => Some(Meaning::of(Input::Truth(is_zero(&result)))),
            _ => {
                let last = result.last().copied();
                last.map(|cell| Meaning::of(Input::Bits(vec![BitSource::WordBit(cell, 15)])))
            }
        };
        let choice = asm.choice();
        if let Some(value) = value {
            asm.exactly(choice, value);
        }
        effects.push(fired(Write::Bit(target, Logic::Bit(BitSource::Free(choice)))));
    }
    effects
}

/// How the carry flag is told.
enum Carried {
    /// With the result.
    Within,
    /// By an operation of its own.
    Apart(Meaning),
    /// Not at all.
    Unknown,
}

fn carry_of(asm: &mut Assembly, item: &Item<'_>) -> Carried {
    let wide = if item.name.contains('L') { 2 } else { 1 };
    match &*item.name {
        "+" | "+L" | "-" | "-L" => {
            let inputs = (0..2).map(|at| words(asm, item, at, wide)).collect::<Option<Vec<_>>>();
            let operation = Operation::Carry { subtract: item.name.starts_with('-') };
            inputs.map_or(Carried::Unknown, |inputs| {
                Carried::Apart(Meaning { operation, inputs, outputs: Vec::new() })
            })
        }
        "*" | "*L" | "*U" | "*UL" | "*B" | "*BL" | "/" | "/L" | "/U" | "/UL" | "/B" | "/BL"
        | "MUL" | "MULL" | "MLB" | "DIV" | "DIVL" | "DVB" | "BIN" | "BINL" | "BCD" | "BCDL"
        | "LMT" | "BAND" | "ZONE" | "MLPX" | "NEG" | "NEGL" | "SIGN" | "BCNT" | "COLL" | "DIST" | "INC" | "DEC" | "SLD" | "SRD"
        // Of these the manuals say that it tells of a digit that went over, not of the number.
        | "++" | "++L" | "--" | "--L" | "++B" | "++BL" | "--B" | "--BL" => Carried::Unknown,
        _ => Carried::Within,
    }
}

/// The carry flag of an instruction whose value is followed anyway, worked out before its operands change.
pub(super) fn carry_before(asm: &mut Assembly, item: &Item<'_>) -> Option<Effect> {
    if item.operands.iter().any(Operand::is_indirect) {
        return None;
    }
    let Carried::Apart(meaning) = carry_of(asm, item) else { return None };
    let choice = asm.choice();
    asm.exactly(choice, meaning);
    let target = asm.memory.flag("CY")?;
    Some(fired(Write::Bit(target, Logic::Bit(BitSource::Free(choice)))))
}

/// The words of an instruction's result.
fn result(item: &Item<'_>) -> Option<Vec<Cell>> {
    let wide = match &*item.name {
        "+L" | "-L" | "+CL" | "-CL" | "+BL" | "-BL" | "+BCL" | "-BCL" | "ADDL" | "SUBL"
        | "BINL" | "BCDL" | "NEGL" | "SIGN" | "*" | "*U" | "*B" | "MUL" | "MLB" | "ASLL"
        | "ASRL" | "NSLL" | "NSRL" | "ROLL" | "RORL" | "RLNL" | "RRNL" | "++L" | "--L" | "++BL"
        | "--BL" | "/L" | "/UL" | "/BL" | "DIVL" => 2,
        "*L" | "*UL" | "*BL" | "MULL" => 4,
        "SLD" | "SRD" | "XFER" | "BSET" | "XFRB" | "MLPX" | "DIST" => return None,
        _ => 1,
    };
    let at = item.row?.operands.iter().position(|slot| slot.written_words().is_some())?;
    let Operand::Word(first) = item.operands.get(at)? else { return None };
    Some((0..wide).map(|n| first.plus(n)).collect())
}

fn is_zero(cells: &[Cell]) -> Logic {
    let left = Number::Words(cells.iter().copied().map(WordSource::Cell).collect());
    let right = Number::Words(vec![WordSource::Const(0); cells.len()]);
    let (relation, format) = (Relation::Equal, NumberFormat::Unsigned);
    Logic::Compare(Box::new(Compare { relation, format, left, right }))
}

/// The exact meaning of an instruction; its flags but the carry are apart.
fn meaning(asm: &mut Assembly, item: &Item<'_>) -> Option<Exactly> {
    let family = asm.memory.family;
    let name = item.name.as_str();
    let constant = |value: u16| Input::Words(vec![WordSource::Const(value)]);
    let carries = carries(name, family) && !matches!(carry_of(asm, item), Carried::Unknown);
    let with = |asm: &Assembly, operation, inputs, target: Target| {
        let mut outputs = vec![target];
        match (&operation, carries) {
            (_, true) => outputs.push(carry_target(asm)?),
            (
                Operation::Sum { .. }
                | Operation::DecimalSum { .. }
                | Operation::Rotate { .. }
                | Operation::Shift { .. },
                false,
            ) => outputs.push(Target::Nowhere),
            _ => {}
        }
        Some(Exactly { meaning: Meaning { operation, inputs, outputs }, carries })
    };
    // Of two operands to a third, all of so many words; the third may be longer.
    let two = |asm: &mut Assembly, operation, wide, to, carry: bool| {
        let mut inputs = vec![words(asm, item, 0, wide)?, words(asm, item, 1, wide)?];
        if carry {
            inputs.push(carry_bit(asm)?);
        }
        with(asm, operation, inputs, target(asm, item, 2, to)?)
    };
    let one = |asm: &mut Assembly, operation, wide, to| {
        let inputs = vec![words(asm, item, 0, wide)?];
        with(asm, operation, inputs, target(asm, item, 1, to)?)
    };
    let own = |asm: &mut Assembly, operation: Operation, wide, more: Vec<Input>| {
        let inputs = [vec![words(asm, item, 0, wide)?], more].concat();
        with(asm, operation, inputs, target(asm, item, 0, wide)?)
    };
    let decimal = |subtract| Operation::DecimalSum { subtract };
    let binary = |subtract| Operation::Sum { subtract };
    match name {
        "BCD" => one(asm, Operation::Each(Unary::ToBcd), 1, 1),
        "BCDL" => one(asm, Operation::Each(Unary::ToBcd), 2, 2),
        "BIN" => one(asm, Operation::Each(Unary::FromBcd), 1, 1),
        "BINL" => one(asm, Operation::Each(Unary::FromBcd), 2, 2),
        "NEG" if family == Family::Cs => one(asm, Operation::Each(Unary::Negate), 1, 1),
        "NEGL" if family == Family::Cs => one(asm, Operation::Each(Unary::Negate), 2, 2),
        "SIGN" => {
            let inputs = vec![words(asm, item, 0, 1)?, constant(1)];
            with(asm, Operation::Multiply { signed: true }, inputs, target(asm, item, 1, 2)?)
        }
        "ROL" | "ROR" | "ROLL" | "RORL" | "RLNC" | "RRNC" | "RLNL" | "RRNL" => {
            let left = name.starts_with("ROL") || name.starts_with("RL");
            let through = name.starts_with("RO");
            let wide = if name.ends_with('L') && name.len() == 4 { 2 } else { 1 };
            let more = vec![constant(1), carry_bit(asm)?];
            own(asm, Operation::Rotate { left, through }, wide, more)
        }
        "ASL" | "ASR" | "ASLL" | "ASRL" => {
            let wide = if name.len() == 4 { 2 } else { 1 };
            let left = name.starts_with("ASL");
            own(asm, Operation::Shift { left, signed: false }, wide, vec![constant(1)])
        }
        // Low byte: how many places; high digit: 0 for zeros, 8 for the end's own bit.
        "NASL" | "NASR" | "NSLL" | "NSRL" => {
            let wide = if name.starts_with("NS") { 2 } else { 1 };
            let left = matches!(name, "NASL" | "NSLL");
            let &Operand::Constant(control, _) = item.operands.get(1)? else { return None };
            let signed = match control >> 8 {
                0 => false,
                0x80 if !left => true,
                _ => return None,
            };
            let places = (control & 0xFF) as u16;
            if !(1..=16 * wide).contains(&u32::from(places)) {
                return None;
            }
            own(asm, Operation::Shift { left, signed }, wide, vec![constant(places)])
        }
        // The second operand's two words: for what is too small, then for what is too large.
        "LMT" | "BAND" | "ZONE" => {
            item.operands.get(1)?.word()?;
            let limits = data::sources(asm, item, 1, 2)?;
            let limits = limits.into_iter().map(|limit| Input::Words(vec![limit]));
            let value = words(asm, item, 0, 1)?;
            let operation = match name {
                "LMT" => Operation::Limit,
                "BAND" => Operation::Band,
                _ => Operation::Zone,
            };
            with(asm, operation, limits.chain([value]).collect(), target(asm, item, 2, 1)?)
        }
        "SLD" | "SRD" => {
            let count = extent::length(asm.memory, item, Amount::UpTo { operand: 1 })?;
            let count = Some(count).filter(|&count| count <= extent::MOST_WORDS)?;
            own(
                asm,
                Operation::Shift { left: name == "SLD", signed: false },
                count,
                vec![constant(4)],
            )
        }
        "++B" | "--B" | "INC" | "DEC" => {
            let subtract = matches!(name, "--B" | "DEC");
            own(asm, decimal(subtract), 1, vec![constant(1)])
        }
        "++BL" | "--BL" => {
            let step = Input::Words(vec![WordSource::Const(1), WordSource::Const(0)]);
            own(asm, decimal(name == "--BL"), 2, vec![step])
        }
        "+C" | "-C" | "+CL" | "-CL" => {
            let wide = if name.ends_with('L') { 2 } else { 1 };
            two(asm, binary(name.starts_with('-')), wide, wide, true)
        }
        "ADB" | "SBB" => two(asm, binary(name == "SBB"), 1, 1, true),
        "+B" | "-B" | "+BL" | "-BL" | "+BC" | "-BC" | "+BCL" | "-BCL" => {
            let wide = if name.ends_with('L') { 2 } else { 1 };
            two(asm, decimal(name.starts_with('-')), wide, wide, name.contains('C'))
        }
        "ADD" | "SUB" => two(asm, decimal(name == "SUB"), 1, 1, true),
        "ADDL" | "SUBL" => two(asm, decimal(name == "SUBL"), 2, 2, true),
        "*" | "*U" | "MLB" => two(asm, Operation::Multiply { signed: name == "*" }, 1, 2, false),
        "*L" | "*UL" => two(asm, Operation::Multiply { signed: name == "*L" }, 2, 4, false),
        "/" | "/U" | "DVB" => {
            two(asm, Operation::DivideJoined { signed: name == "/" }, 1, 2, false)
        }
        "/L" | "/UL" => two(asm, Operation::DivideJoined { signed: name == "/L" }, 2, 4, false),
        "*B" | "MUL" => two(asm, Operation::DecimalMultiply, 1, 2, false),
        "*BL" | "MULL" => two(asm, Operation::DecimalMultiply, 2, 4, false),
        "/B" | "DIV" => two(asm, Operation::DecimalDivide, 1, 2, false),
        "/BL" | "DIVL" => two(asm, Operation::DecimalDivide, 2, 4, false),
        _ => moved(asm, item),
    }
}

/// The meaning of instructions that only bring words, digits or bits elsewhere, which leaves the carry alone.
fn moved(asm: &mut Assembly, item: &Item<'_>) -> Option<Exactly> {
    let family = asm.memory.family;
    let simple = |operation, input, output| {
        let (inputs, outputs) = (vec![input], vec![output]);
        Some(Exactly { meaning: Meaning { operation, inputs, outputs }, carries: false })
    };
    let digit = |at: u32, place: u32| -> Option<u32> {
        let &Operand::Constant(value, _) = item.operands.get(at as usize)? else { return None };
        Some((value >> (4 * place)) as u32 & 15)
    };
    match item.name.as_str() {
        // What is read is read before anything is written, so areas may overlap.
        "XFER" if family == Family::Cs => {
            let count = item.operands.first()?.count(family).filter(|&count| count <= 4_096)?;
            simple(Operation::Copy, words(asm, item, 1, count)?, target(asm, item, 2, count)?)
        }
        // Low digit: the source's first; next: how many less one; next: the target's first.
        "MOVD" => {
            let (from, more, to) = (digit(1, 0)?, digit(1, 1)?, digit(1, 2)?);
            if from > 3 || more > 3 || to > 3 || digit(1, 3)? > 0 {
                return None;
            }
            let Operand::Word(target) = *item.operands.get(2)? else { return None };
            let (mut bits, mut places) = (Vec::new(), Vec::new());
            for bit in 0..4 * (more + 1) {
                // Digits go round from the last to the first.
                bits.push(bit_of(asm, item, 0, (4 * from + bit) % 16)?);
                places.push(BitTarget::WordBit(target, ((4 * to + bit) % 16) as u8));
            }
            simple(Operation::Copy, Input::Bits(bits), Target::Bits(places))
        }
        // One digit, the lowest, to the sixteen bits of a word.
        "MLPX" => {
            let &Operand::Constant(0, _) = item.operands.get(1)? else { return None };
            let &Operand::Word(target) = item.operands.get(2)? else { return None };
            let inputs = vec![words(asm, item, 0, 1)?, Input::Words(vec![WordSource::Const(4)])];
            let outputs =
                vec![Target::Bits((0..16).map(|bit| BitTarget::WordBit(target, bit)).collect())];
            let meaning = Meaning { operation: Operation::Decode, inputs, outputs };
            Some(Exactly { meaning, carries: false })
        }
        "BCNT" if family == Family::Cs => {
            let count = item.operands.first()?.count(family);
            let count = count.filter(|count| (1..=extent::MOST_WORDS).contains(count))?;
            simple(Operation::CountBits(1), words(asm, item, 1, count)?, target(asm, item, 2, 1)?)
        }
        "COLL" if family == Family::Cs => {
            let address = offset(asm, item, 0, 1)?;
            let run = Input::Run(address, Shape::Cells, Count::Exactly(1));
            simple(Operation::Copy, run, target(asm, item, 2, 1)?)
        }
        "DIST" if family == Family::Cs => {
            let address = offset(asm, item, 1, 2)?;
            let source = words(asm, item, 0, 1)?;
            simple(Operation::Copy, source, Target::Run(address, Shape::Cells))
        }
        _ => None,
    }
}

/// The word so far behind an operand as another says.
fn offset(asm: &mut Assembly, item: &Item<'_>, base: usize, by: usize) -> Option<Address> {
    let &Operand::Word(first) = item.operands.get(base)? else { return None };
    let memory = asm.memory;
    // What the system changes by itself is read as any value, which a word that is searched for is not.
    if memory.is_volatile(first) || memory.timing_areas().contains(&first.area) {
        return None;
    }
    let size = memory.size(first.area);
    let by = item.operands.get(by)?.sources(1, memory, &mut || asm.choice())?[0];
    let start = Cell { area: AreaId(first.area.0), index: 0 };
    Some(Address::within(start, size, i64::from(first.index), vec![Term::unsigned(by)]))
}

/// A bit of a word operand.
fn bit_of(asm: &mut Assembly, item: &Item<'_>, at: usize, bit: u32) -> Option<BitSource> {
    let memory = asm.memory;
    match item.operands.get(at)? {
        Operand::Constant(value, _) => Some(BitSource::Const(value >> bit & 1 == 1)),
        Operand::Word(cell) => {
            Operand::Bit(*cell, bit as u8).bit_source(memory, &mut || asm.choice())
        }
        _ => None,
    }
}

/// So many words from an operand on, as they are read.
fn words(asm: &mut Assembly, item: &Item<'_>, at: usize, count: u32) -> Option<Input> {
    data::sources(asm, item, at, count).map(Input::Words)
}

/// The carry flag as it is read.
fn carry_bit(asm: &Assembly) -> Option<Input> {
    let flag = match asm.memory.flag("CY")? {
        BitTarget::Cell(cell) => BitSource::Cell(cell),
        BitTarget::WordBit(cell, bit) => BitSource::WordBit(cell, bit),
    };
    Some(Input::Bits(vec![flag]))
}

fn carry_target(asm: &Assembly) -> Option<Target> {
    Some(Target::Bits(vec![asm.memory.flag("CY")?]))
}

/// Where so many words from an operand on are written.
fn target(asm: &Assembly, item: &Item<'_>, at: usize, count: u32) -> Option<Target> {
    let &Operand::Word(first) = item.operands.get(at)? else { return None };
    if !extent::fits(asm.memory, first, count) {
        return None;
    }
    Some(Target::Words((0..count).map(|n| WordTarget::Cell(first.plus(n))).collect()))
}
