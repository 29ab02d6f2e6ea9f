//! The operations of those OMRON instructions whose results the analysis may take as any value.

use super::builder::OmronBuilder;
use super::catalog::Amount;
use super::data;
use super::extent;
use super::operand::Operand;
use super::resolve::Item;
use super::source::Family;
use scanbound_front::builder::fired;
use scanbound_ir::meaning::{
    Address, Count, Meaning, Operation, OperationInput as Input, Shape, Target, Term, Unary,
};
use scanbound_ir::{
    AreaId, BitSource, BitTarget, Cell, Compare, Effect, Logic, Number, NumberFormat, Region,
    Relation, WordSource, WordTarget, Write,
};

/// The operation of an instruction. A real run executes it, while the analysis may let the written operands have any
/// value.
#[derive(Debug, Clone, PartialEq)]
struct ExactMeaning {
    meaning: Meaning,
    /// Whether the last result of the operation is the carry flag.
    carries: bool,
}

/// What is known about an instruction's result, from which the condition flags follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum KnownResult {
    /// Nothing is known about the result.
    Unknown,
    /// An operation computes the result together with the flags. On an error both stay unchanged.
    Worked,
    /// The result is written whenever the instruction fires, so the flags can be computed from the written words.
    Written,
}

/// The havocs of everything that an instruction may write, with the operation of the instruction if it is known, and
/// what is known about the result.
pub(super) fn writes(builder: &mut OmronBuilder, item: &Item<'_>) -> (Vec<Write>, KnownResult) {
    let exactly = match item.operands.iter().any(Operand::is_indirect) {
        true => None,
        false => meaning(builder, item),
    };
    let choice = builder.choice();
    let mut writes = data::havoc(builder, item, choice);
    let Some(ExactMeaning { mut meaning, carries }) = exactly else {
        return (writes, KnownResult::Unknown);
    };
    let mut flags: Vec<BitTarget> =
        builder.memory.flag("CY").filter(|_| carries).into_iter().collect();
    if let Some(result) = result(item).filter(|_| flags_follow_result(item)) {
        let operation = Box::new(meaning.operation);
        meaning.operation = Operation::WithFlags { operation, words: result.len() as u8 };
        for flag in ["EQ", "N"] {
            let result_flag = builder.memory.flag(flag).filter(|_| follows_result(item, flag));
            meaning
                .outputs
                .push(result_flag.map_or(Target::Nowhere, |flag| Target::Bits(vec![flag])));
            flags.extend(result_flag);
        }
    }
    builder.define(choice, meaning);
    writes.extend(flags.into_iter().map(|flag| {
        let (BitTarget::Cell(first) | BitTarget::WordBit(first, _)) = flag;
        Write::Havoc(Region::Range { first, count: 1 }, choice)
    }));
    (writes, KnownResult::Worked)
}

/// Whether the operation of the instruction with this name also computes the carry flag.
fn carries(name: &str, family: Family) -> bool {
    match name {
        "INC" | "DEC" | "SLD" | "SRD" => false,
        "ADD" | "SUB" | "ADDL" | "SUBL" | "ADB" | "SBB" => family == Family::C,
        _ => true,
    }
}

/// Whether the instruction's condition flags depend on its result: the catalog lists all flags for it.
fn flags_follow_result(item: &Item<'_>) -> bool {
    item.row.is_none_or(|row| row.extra.flags == "*")
}

/// Whether this flag (EQ or N) of the instruction follows from its result, as far as the manuals say; false for all
/// other flags.
fn follows_result(item: &Item<'_>, flag: &str) -> bool {
    match flag {
        // The manuals do not say whether the remainder counts.
        "EQ" => !matches!(&*item.name, "DIV" | "DIVL" | "DVB" | "/B" | "/BL"),
        // For BCD results the manuals do not mention this flag.
        "N" => !item.name.contains('B'),
        _ => false,
    }
}

/// The effects on the condition flags when the instruction fires: computed ones where the result decides them,
/// otherwise any value. `outcome` says what is known about the result.
pub(super) fn flags(
    builder: &mut OmronBuilder,
    item: &Item<'_>,
    outcome: KnownResult,
) -> Vec<Effect> {
    let is_computed = outcome != KnownResult::Unknown && flags_follow_result(item);
    let Some(result) = result(item).filter(|_| is_computed) else {
        return data::flags(builder, item).into_iter().map(fired).collect();
    };
    let carry = carry_of(builder, item);
    let mut effects = Vec::new();
    for flag in ["ER", "GT", "EQ", "LT", "GE", "NE", "LE", "N", "OF", "UF", "AER", "CY"] {
        let Some(target) = builder.memory.flag(flag) else { continue };
        let value = match (flag, &carry) {
            ("CY", CarrySource::SeparateOperation(_) | CarrySource::WithResult) => continue,
            (flag, _) if !follows_result(item, flag) => None,
            _ if outcome == KnownResult::Worked => continue,
            ("EQ", _) => Some(Meaning::of(Input::Truth(is_zero(&result)))),
            _ => {
                let last = result.last().copied();
                last.map(|cell| Meaning::of(Input::Bits(vec![BitSource::WordBit(cell, 15)])))
            }
        };
        let choice = builder.choice();
        if let Some(value) = value {
            builder.define(choice, value);
        }
        effects.push(fired(Write::Bit(target, Logic::Bit(BitSource::Free(choice)))));
    }
    effects
}

/// Where the value of the carry flag comes from.
enum CarrySource {
    /// The operation that computes the result also computes the carry flag.
    WithResult,
    /// A separate operation computes the carry flag.
    SeparateOperation(Meaning),
    /// The carry flag may have any value.
    Unknown,
}

fn carry_of(builder: &mut OmronBuilder, item: &Item<'_>) -> CarrySource {
    let wide = if item.name.contains('L') { 2 } else { 1 };
    match &*item.name {
        "+" | "+L" | "-" | "-L" => {
            let inputs = (0..2).map(|at| words(builder, item, at, wide)).collect::<Option<Vec<_>>>();
            let operation = Operation::Carry { subtract: item.name.starts_with('-') };
            inputs.map_or(CarrySource::Unknown, |inputs| {
                CarrySource::SeparateOperation(Meaning { operation, inputs, outputs: Vec::new() })
            })
        }
        "*" | "*L" | "*U" | "*UL" | "*B" | "*BL" | "/" | "/L" | "/U" | "/UL" | "/B" | "/BL"
        | "MUL" | "MULL" | "MLB" | "DIV" | "DIVL" | "DVB" | "BIN" | "BINL" | "BCD" | "BCDL"
        | "LMT" | "BAND" | "ZONE" | "MLPX" | "NEG" | "NEGL" | "SIGN" | "BCNT" | "COLL" | "DIST" | "INC" | "DEC" | "SLD" | "SRD"
        // For these, the manuals define the carry by a digit's overflow, not by the number.
        | "++" | "++L" | "--" | "--L" | "++B" | "++BL" | "--B" | "--BL" => CarrySource::Unknown,
        _ => CarrySource::WithResult,
    }
}

/// The effect on the carry flag of an instruction with exact writes. It must come before these, because it reads the
/// operands. `None` if the carry may have any value, or is not computed separately.
pub(super) fn carry_before(builder: &mut OmronBuilder, item: &Item<'_>) -> Option<Effect> {
    if item.operands.iter().any(Operand::is_indirect) {
        return None;
    }
    let CarrySource::SeparateOperation(meaning) = carry_of(builder, item) else { return None };
    let choice = builder.choice();
    builder.define(choice, meaning);
    let target = builder.memory.flag("CY")?;
    Some(fired(Write::Bit(target, Logic::Bit(BitSource::Free(choice)))))
}

/// The cells of an instruction's result. `None` if they are unknown, or if the flags do not depend on the result.
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

/// The operation of an instruction with its operands and results, and of its condition flags only the carry. `None` if
/// the manuals do not define it exactly or the operands are unknown.
fn meaning(builder: &mut OmronBuilder, item: &Item<'_>) -> Option<ExactMeaning> {
    let family = builder.memory.family;
    let name = item.name.as_str();
    let constant = |value: u16| Input::Words(vec![WordSource::Const(value)]);
    let carries = carries(name, family) && !matches!(carry_of(builder, item), CarrySource::Unknown);
    let with = |builder: &OmronBuilder, operation, inputs, target: Target| {
        let mut outputs = vec![target];
        match (&operation, carries) {
            (_, true) => outputs.push(carry_target(builder)?),
            (
                Operation::Sum { .. }
                | Operation::DecimalSum { .. }
                | Operation::Rotate { .. }
                | Operation::Shift { .. },
                false,
            ) => outputs.push(Target::Nowhere),
            _ => {}
        }
        Some(ExactMeaning { meaning: Meaning { operation, inputs, outputs }, carries })
    };
    // An operation of two operands with `wide` words each; the result may be longer.
    let two = |builder: &mut OmronBuilder, operation, wide, to, carry: bool| {
        let mut inputs = vec![words(builder, item, 0, wide)?, words(builder, item, 1, wide)?];
        if carry {
            inputs.push(carry_bit(builder)?);
        }
        with(builder, operation, inputs, target(builder, item, 2, to)?)
    };
    let one = |builder: &mut OmronBuilder, operation, wide, to| {
        let inputs = vec![words(builder, item, 0, wide)?];
        with(builder, operation, inputs, target(builder, item, 1, to)?)
    };
    let own = |builder: &mut OmronBuilder, operation: Operation, wide, more: Vec<Input>| {
        let inputs = [vec![words(builder, item, 0, wide)?], more].concat();
        with(builder, operation, inputs, target(builder, item, 0, wide)?)
    };
    let decimal = |subtract| Operation::DecimalSum { subtract };
    let binary = |subtract| Operation::Sum { subtract };
    match name {
        "BCD" => one(builder, Operation::Each(Unary::ToBcd), 1, 1),
        "BCDL" => one(builder, Operation::Each(Unary::ToBcd), 2, 2),
        "BIN" => one(builder, Operation::Each(Unary::FromBcd), 1, 1),
        "BINL" => one(builder, Operation::Each(Unary::FromBcd), 2, 2),
        "NEG" if family == Family::Cs => one(builder, Operation::Each(Unary::Negate), 1, 1),
        "NEGL" if family == Family::Cs => one(builder, Operation::Each(Unary::Negate), 2, 2),
        "SIGN" => {
            let inputs = vec![words(builder, item, 0, 1)?, constant(1)];
            with(
                builder,
                Operation::Multiply { signed: true },
                inputs,
                target(builder, item, 1, 2)?,
            )
        }
        "ROL" | "ROR" | "ROLL" | "RORL" | "RLNC" | "RRNC" | "RLNL" | "RRNL" => {
            let left = name.starts_with("ROL") || name.starts_with("RL");
            let through = name.starts_with("RO");
            let wide = if name.ends_with('L') && name.len() == 4 { 2 } else { 1 };
            let more = vec![constant(1), carry_bit(builder)?];
            own(builder, Operation::Rotate { left, through }, wide, more)
        }
        "ASL" | "ASR" | "ASLL" | "ASRL" => {
            let wide = if name.len() == 4 { 2 } else { 1 };
            let left = name.starts_with("ASL");
            own(builder, Operation::Shift { left, signed: false }, wide, vec![constant(1)])
        }
        // The control word: the low byte is the number of places; the high digit is 0 to shift in zeros, 8 to shift in
        // the end bit.
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
            own(builder, Operation::Shift { left, signed }, wide, vec![constant(places)])
        }
        // The second operand has two words: one for values below, one for values above.
        "LMT" | "BAND" | "ZONE" => {
            item.operands.get(1)?.word()?;
            let limits = data::sources(builder, item, 1, 2)?;
            let limits = limits.into_iter().map(|limit| Input::Words(vec![limit]));
            let value = words(builder, item, 0, 1)?;
            let operation = match name {
                "LMT" => Operation::Limit,
                "BAND" => Operation::Band,
                _ => Operation::Zone,
            };
            with(builder, operation, limits.chain([value]).collect(), target(builder, item, 2, 1)?)
        }
        "SLD" | "SRD" => {
            let count = extent::length(builder.memory, item, Amount::UpTo { operand: 1 })?;
            let count = Some(count).filter(|&count| count <= extent::MAX_WORDS)?;
            own(
                builder,
                Operation::Shift { left: name == "SLD", signed: false },
                count,
                vec![constant(4)],
            )
        }
        "++B" | "--B" | "INC" | "DEC" => {
            let subtract = matches!(name, "--B" | "DEC");
            own(builder, decimal(subtract), 1, vec![constant(1)])
        }
        "++BL" | "--BL" => {
            let step = Input::Words(vec![WordSource::Const(1), WordSource::Const(0)]);
            own(builder, decimal(name == "--BL"), 2, vec![step])
        }
        "+C" | "-C" | "+CL" | "-CL" => {
            let wide = if name.ends_with('L') { 2 } else { 1 };
            two(builder, binary(name.starts_with('-')), wide, wide, true)
        }
        "ADB" | "SBB" => two(builder, binary(name == "SBB"), 1, 1, true),
        "+B" | "-B" | "+BL" | "-BL" | "+BC" | "-BC" | "+BCL" | "-BCL" => {
            let wide = if name.ends_with('L') { 2 } else { 1 };
            two(builder, decimal(name.starts_with('-')), wide, wide, name.contains('C'))
        }
        "ADD" | "SUB" => two(builder, decimal(name == "SUB"), 1, 1, true),
        "ADDL" | "SUBL" => two(builder, decimal(name == "SUBL"), 2, 2, true),
        "*" | "*U" | "MLB" => {
            two(builder, Operation::Multiply { signed: name == "*" }, 1, 2, false)
        }
        "*L" | "*UL" => two(builder, Operation::Multiply { signed: name == "*L" }, 2, 4, false),
        "/" | "/U" | "DVB" => {
            two(builder, Operation::DivideJoined { signed: name == "/" }, 1, 2, false)
        }
        "/L" | "/UL" => two(builder, Operation::DivideJoined { signed: name == "/L" }, 2, 4, false),
        "*B" | "MUL" => two(builder, Operation::DecimalMultiply, 1, 2, false),
        "*BL" | "MULL" => two(builder, Operation::DecimalMultiply, 2, 4, false),
        "/B" | "DIV" => two(builder, Operation::DecimalDivide, 1, 2, false),
        "/BL" | "DIVL" => two(builder, Operation::DecimalDivide, 2, 4, false),
        _ => moved(builder, item),
    }
}

/// The meaning of instructions that only move words, digits or bits. They do not change the carry. `None` for other
/// instructions, and if an operand is not of a form that can be computed.
fn moved(builder: &mut OmronBuilder, item: &Item<'_>) -> Option<ExactMeaning> {
    let family = builder.memory.family;
    let simple = |operation, input, output| {
        let (inputs, outputs) = (vec![input], vec![output]);
        Some(ExactMeaning { meaning: Meaning { operation, inputs, outputs }, carries: false })
    };
    let digit = |at: u32, place: u32| -> Option<u32> {
        let &Operand::Constant(value, _) = item.operands.get(at as usize)? else { return None };
        Some((value >> (4 * place)) as u32 & 15)
    };
    match item.name.as_str() {
        // All words are read before any is written, so the blocks may overlap.
        "XFER" if family == Family::Cs => {
            let count = item.operands.first()?.count(family).filter(|&count| count <= 4_096)?;
            simple(
                Operation::Copy,
                words(builder, item, 1, count)?,
                target(builder, item, 2, count)?,
            )
        }
        // The control word: low digit is the first source digit, the next is the number of digits minus 1, then the
        // first target digit.
        "MOVD" => {
            let (from, more, to) = (digit(1, 0)?, digit(1, 1)?, digit(1, 2)?);
            if from > 3 || more > 3 || to > 3 || digit(1, 3)? > 0 {
                return None;
            }
            let Operand::Word(target) = *item.operands.get(2)? else { return None };
            let (mut bits, mut places) = (Vec::new(), Vec::new());
            for bit in 0..4 * (more + 1) {
                // After the last digit follows the first one.
                bits.push(bit_of(builder, item, 0, (4 * from + bit) % 16)?);
                places.push(BitTarget::WordBit(target, ((4 * to + bit) % 16) as u8));
            }
            simple(Operation::Copy, Input::Bits(bits), Target::Bits(places))
        }
        // The lowest digit selects one of the sixteen bits of a word.
        "MLPX" => {
            let &Operand::Constant(0, _) = item.operands.get(1)? else { return None };
            let &Operand::Word(target) = item.operands.get(2)? else { return None };
            let inputs =
                vec![words(builder, item, 0, 1)?, Input::Words(vec![WordSource::Const(4)])];
            let outputs =
                vec![Target::Bits((0..16).map(|bit| BitTarget::WordBit(target, bit)).collect())];
            let meaning = Meaning { operation: Operation::Decode, inputs, outputs };
            Some(ExactMeaning { meaning, carries: false })
        }
        "BCNT" if family == Family::Cs => {
            let count = item.operands.first()?.count(family);
            let count = count.filter(|count| (1..=extent::MAX_WORDS).contains(count))?;
            simple(
                Operation::CountBits(1),
                words(builder, item, 1, count)?,
                target(builder, item, 2, 1)?,
            )
        }
        "COLL" if family == Family::Cs => {
            let address = offset(builder, item, 0, 1)?;
            let run = Input::Run(address, Shape::Cells, Count::Exactly(1));
            simple(Operation::Copy, run, target(builder, item, 2, 1)?)
        }
        "DIST" if family == Family::Cs => {
            let address = offset(builder, item, 1, 2)?;
            let source = words(builder, item, 0, 1)?;
            simple(Operation::Copy, source, Target::Run(address, Shape::Cells))
        }
        _ => None,
    }
}

/// The address of the word that is as many words after operand `base` as the value of operand `by` says. `None` if the
/// system may change these words, or they belong to timers and counters.
fn offset(builder: &mut OmronBuilder, item: &Item<'_>, base: usize, by: usize) -> Option<Address> {
    let &Operand::Word(first) = item.operands.get(base)? else { return None };
    let memory = builder.memory;
    // A word that the system changes has any value at each read, which a search does not support.
    if memory.is_volatile(first) || memory.timing_areas().contains(&first.area) {
        return None;
    }
    let size = memory.size(first.area);
    let by = item.operands.get(by)?.sources(1, memory, &mut || builder.choice())?[0];
    let start = Cell { area: AreaId(first.area.0), index: 0 };
    Some(Address::within(start, size, i64::from(first.index), vec![Term::unsigned(by)]))
}

/// The bit with number `bit` of operand `at`. `None` if the operand is neither a constant nor a word.
fn bit_of(builder: &mut OmronBuilder, item: &Item<'_>, at: usize, bit: u32) -> Option<BitSource> {
    let memory = builder.memory;
    match item.operands.get(at)? {
        Operand::Constant(value, _) => Some(BitSource::Const(value >> bit & 1 == 1)),
        Operand::Word(cell) => {
            Operand::Bit(*cell, bit as u8).bit_source(memory, &mut || builder.choice())
        }
        _ => None,
    }
}

/// `count` words of operand `at`, as the input of an operation. `None` if the operand cannot be read as words.
fn words(builder: &mut OmronBuilder, item: &Item<'_>, at: usize, count: u32) -> Option<Input> {
    data::sources(builder, item, at, count).map(Input::Words)
}

/// The carry flag, as the input of an operation. `None` if the family has no such flag.
fn carry_bit(builder: &OmronBuilder) -> Option<Input> {
    let flag = match builder.memory.flag("CY")? {
        BitTarget::Cell(cell) => BitSource::Cell(cell),
        BitTarget::WordBit(cell, bit) => BitSource::WordBit(cell, bit),
    };
    Some(Input::Bits(vec![flag]))
}

fn carry_target(builder: &OmronBuilder) -> Option<Target> {
    Some(Target::Bits(vec![builder.memory.flag("CY")?]))
}

/// `count` words of operand `at`, as the output of an operation. `None` if it is not a word, or if the words exceed the
/// area.
fn target(builder: &OmronBuilder, item: &Item<'_>, at: usize, count: u32) -> Option<Target> {
    let &Operand::Word(first) = item.operands.get(at)? else { return None };
    if !extent::fits(builder.memory, first, count) {
        return None;
    }
    Some(Target::Words((0..count).map(|n| WordTarget::Cell(first.plus(n))).collect()))
}
