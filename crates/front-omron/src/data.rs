//! Instructions on words: what they write, exactly in simple cases, otherwise any value.

use super::builder::OmronBuilder;
use super::catalog::{Amount, Extent, OperandSpec, Role};
use super::extent::{MAX_WORDS, fits, length};
use super::memory::Memory;
use super::operand::Operand;
use super::resolve::Item;
use scanbound_ir::{
    AreaId, BitTarget, Cell, ChoiceId, Compare, Logic, Number, NumberFormat, Region, Relation,
    WordSource, WordTarget, Write,
};

/// Records as over-approximated each operand that the instruction reads and whose value is not modelled: it is read
/// through an unknown address, or is a present value that the system changes.
pub(super) fn note_indirect(builder: &mut OmronBuilder, item: &Item<'_>) {
    let Some(row) = item.row else { return };
    for ((operand, text), slot) in item.operands.iter().zip(&item.raw.operands).zip(&row.operands) {
        if slot.role != Role::Source || slot.extent == Extent::Words(Amount::Unknown) {
            continue;
        }
        if operand.is_indirect() {
            builder.approximate(format!(
                "{text} is read through an unknown address: any value is assumed for {text}"
            ));
        } else if *operand == Operand::Register {
            builder.approximate(format!("{text} is not modelled: any value is assumed for {text}"));
        }
    }
}

/// Records as over-approximated a comparison whose meaning is not modelled (both results are possible), and operands as
/// [`note_indirect`] does.
pub(super) fn note_unknown(builder: &mut OmronBuilder, item: &Item<'_>) {
    if item.meaning() == "compare-unknown" {
        builder.approximate("the meaning of this comparison is not modelled: both results, true and false, are assumed possible");
    }
    note_indirect(builder, item);
}

/// Havocs, with `choice`, of everything that the instruction may write besides its condition flags.
pub(super) fn havoc(builder: &OmronBuilder, item: &Item<'_>, choice: ChoiceId) -> Vec<Write> {
    let regions: Vec<Region> = match item.row {
        // A user-defined instruction may write the whole area of each operand.
        None => item.operands.iter().flat_map(|operand| whole(operand, builder.memory)).collect(),
        // The addresses of a unit's link words are set in the unit, not in the program.
        Some(row) if row.meaning == "refresh-units" => vec![Region::Everything],
        Some(row) => row
            .operands
            .iter()
            .zip(&item.operands)
            .filter_map(|(slot, operand)| match (slot.role, slot.extent) {
                (
                    Role::Destination | Role::ReadWrite | Role::ReadWriteIfDevice,
                    Extent::Words(amount),
                ) => Some(operand.regions(length(builder.memory, item, amount))),
                (Role::Extra(_), _) if operand.is_indirect() => {
                    Some(builder.memory.timing_areas().into_iter().map(Region::Area).collect())
                }
                _ => None,
            })
            .flatten()
            .chain(special_units(builder.memory, item))
            .chain(registers(builder.memory, item))
            .collect(),
    };
    regions
        .into_iter()
        .filter(|region| !matches!(region, Region::Range { count: 0, .. }))
        .map(|region| Write::Havoc(region, choice))
        .collect()
}

/// All cells of an operand's area; for timers and counters both the flags and the present values.
fn whole(operand: &Operand, memory: Memory) -> Vec<Region> {
    let regions = operand.regions(None).into_iter().map(|region| match region {
        Region::Range { first, .. } => Region::Area(first.area),
        other => other,
    });
    let timing = memory.timing_areas();
    let all = regions.flat_map(|region| match region {
        Region::Area(area) if timing.contains(&area) => {
            timing.iter().copied().map(Region::Area).collect()
        }
        other => vec![other],
    });
    all.collect()
}

/// The registers that an instruction writes implicitly: SRCH, MAX and MIN store the found address in IR0, SRCH the
/// number of matches in DR0. Empty for other instructions and on the C series.
fn registers(memory: Memory, item: &Item<'_>) -> Vec<Region> {
    let found = matches!(&*item.name, "SRCH" | "MAX" | "MIN");
    let index = memory.index_register(0).filter(|_| found);
    let index = index.map(|first| Region::Range { first, count: 2 });
    let times = memory.data_register(0).filter(|_| item.name == "SRCH");
    index.into_iter().chain(times.map(|first| Region::Range { first, count: 1 })).collect()
}

/// The words that IORF changes on the C series besides its operands: if its operands include words 40 to 49, which
/// stand for special I/O units, the words of all these units (100 to 199). `None` for other instructions.
fn special_units(memory: Memory, item: &Item<'_>) -> Option<Region> {
    if memory.family != super::source::Family::C || item.name != "IORF" {
        return None;
    }
    let (first, last) = (item.operands.first()?.word()?, item.operands.get(1)?.word()?);
    let named = first.area.0 == 0 && first.index < 50 && last.index >= 40;
    named.then_some(Region::Range { first: Cell { area: first.area, index: 100 }, count: 100 })
}

/// Writes of any value to the condition flags that the catalog lists for the instruction. To all flags, if the catalog
/// has `*` or no row for it, if an operand has an unknown address, or if ZCP may find its limits invalid.
pub(super) fn flags(builder: &mut OmronBuilder, item: &Item<'_>) -> Vec<Write> {
    let named = item.row.map_or("*", |row| row.extra.flags);
    let indirect = item.operands.iter().any(Operand::is_indirect);
    let refused = item.meaning().starts_with("flags-zone") && !limits_in_order(item);
    if named == "*" || indirect || refused {
        let (first, count) = builder.memory.flags();
        return vec![Write::Havoc(Region::Range { first, count }, builder.choice())];
    }
    let left: &[&str] = match builder.memory.family {
        super::source::Family::Cs => &["EQ", "NE", "GE", "LE", "N"],
        super::source::Family::C => &[],
    };
    let named =
        named.split(' ').flat_map(|flag| if flag == "~" { left.to_vec() } else { vec![flag] });
    let targets: Vec<BitTarget> = named.filter_map(|flag| builder.memory.flag(flag)).collect();
    targets.into_iter().map(|target| Write::Bit(target, builder.free_bit())).collect()
}

/// The sources of `count` words of operand `at`, the lowest first. A word that the system or a timer may change is a
/// new choice. `None` if the operand cannot be read as words, or if the words exceed the area.
pub(super) fn sources(
    builder: &mut OmronBuilder,
    item: &Item<'_>,
    at: usize,
    count: u32,
) -> Option<Vec<WordSource>> {
    let memory = builder.memory;
    let operand = item.operands.get(at)?;
    if operand.word().is_some_and(|first| !fits(memory, first, count)) {
        return None;
    }
    let mut sources = operand.sources(count, memory, &mut || builder.choice())?;
    if let Some(first) = operand.word() {
        for (source, n) in sources.iter().zip(0..) {
            if let WordSource::Free(choice) = *source {
                let register = (memory.name_of(first).to_owned(), first.index + n);
                builder.out.program.registers.insert(choice, register);
            }
        }
    }
    // A block may extend to the current value of a timer that counts at any time.
    for source in &mut sources {
        if let WordSource::Cell(cell) = *source
            && let Some(area) = cell.area.0.checked_sub(1)
            && builder.fast.contains(&Cell { area: AreaId(area), ..cell })
        {
            let between = builder.choice();
            builder.out.program.timekeeping.between_instructions.insert(between, Some(cell));
            *source = WordSource::Free(between);
        }
    }
    Some(sources)
}

fn number(builder: &mut OmronBuilder, item: &Item<'_>, at: usize, count: u32) -> Option<Number> {
    sources(builder, item, at, count).map(Number::Words)
}

/// The write targets for `count` words of operand `at`. What is written to a present value that is not modelled is
/// discarded. `None` if the address is unknown.
fn targets(item: &Item<'_>, at: usize, count: u32) -> Option<Vec<WordTarget>> {
    match item.operands.get(at)? {
        Operand::Word(first) => Some((0..count).map(|n| WordTarget::Cell(first.plus(n))).collect()),
        Operand::Register => Some((0..count).map(|_| WordTarget::Discard).collect()),
        _ => None,
    }
}

/// The number of words of operand `at` according to the catalog; 1 if the catalog gives no fixed number.
fn width(item: &Item<'_>, at: usize) -> u32 {
    let slot = item.row.and_then(|row| row.operands.get(at));
    match slot.and_then(|slot| slot.read_words().or(slot.written_words())) {
        Some(Amount::Fixed(count)) => count,
        _ => 1,
    }
}

/// The exact writes of the instruction, if the analysis can compute them: such as moves, sums, logic, comparisons,
/// single bits, and blocks of at most 256 words. `None` otherwise.
pub(super) fn exact(builder: &mut OmronBuilder, item: &Item<'_>) -> Option<Vec<Write>> {
    let wide = width(item, 0);
    let ones = || Number::Words(vec![WordSource::Const(u16::MAX); wide as usize]);
    let one = || {
        let words = (0..wide).map(|n| WordSource::Const(u16::from(n == 0)));
        Number::Words(words.collect())
    };
    let two = |builder: &mut OmronBuilder, join: fn(Box<Number>, Box<Number>) -> Number| {
        let (a, b) = (number(builder, item, 0, wide)?, number(builder, item, 1, wide)?);
        Some(join(Box::new(a), Box::new(b)))
    };
    let (target, value) = match item.meaning() {
        "move" => (1, number(builder, item, 0, wide)?),
        "move-not" => (1, Number::Xor(Box::new(number(builder, item, 0, wide)?), Box::new(ones()))),
        "complement" => {
            (0, Number::Xor(Box::new(number(builder, item, 0, wide)?), Box::new(ones())))
        }
        "increment" => (0, Number::Add(Box::new(number(builder, item, 0, wide)?), Box::new(one()))),
        "decrement" => (0, Number::Sub(Box::new(number(builder, item, 0, wide)?), Box::new(one()))),
        "add" => (2, two(builder, Number::Add)?),
        "subtract" => (2, two(builder, Number::Sub)?),
        "word-and" => (2, two(builder, Number::And)?),
        "word-or" => (2, two(builder, Number::Or)?),
        "word-xor" => (2, two(builder, Number::Xor)?),
        "word-xnr" => (2, Number::Xor(Box::new(two(builder, Number::Xor)?), Box::new(ones()))),
        "flags-compare" | "flags-compare-signed" | "flags-zone" | "flags-zone-signed" => {
            return compare_flags(builder, item);
        }
        "copy" | "fill" | "shift-words" | "exchange" => return block(builder, item),
        carry @ ("set-carry" | "clear-carry") => {
            let set = Logic::Const(carry == "set-carry");
            return Some(vec![Write::Bit(builder.memory.flag("CY")?, set)]);
        }
        "move-bit" | "set-bit" | "reset-bit" | "out-bit" | "set-bits" | "reset-bits" => {
            return bits(builder, item);
        }
        _ => return None,
    };
    Some(vec![Write::Words(targets(item, target, wide)?, value)])
}

fn block(builder: &mut OmronBuilder, item: &Item<'_>) -> Option<Vec<Write>> {
    if item.meaning() == "exchange" {
        let wide = width(item, 0);
        let (mut from, second) =
            (sources(builder, item, 1, wide)?, sources(builder, item, 0, wide)?);
        let (mut to, last) = (targets(item, 0, wide)?, targets(item, 1, wide)?);
        from.extend(second);
        to.extend(last);
        return Some(vec![Write::Words(to, Number::Words(from))]);
    }
    let mut amounts = item.row?.operands.iter().filter_map(OperandSpec::written_words);
    let amount = amounts.find(|amount| amount.counter().is_some())?;
    let count = length(builder.memory, item, amount).filter(|&count| count <= MAX_WORDS)?;
    if !builder.out.has_room(2 * count as usize) {
        return None;
    }
    if count == 0 {
        return Some(Vec::new());
    }
    let (first, from) = match item.meaning() {
        "copy" => {
            let (from, to) = (item.operands.get(1)?.word()?, item.operands.get(2)?.word()?);
            let apart = from.area != to.area || from.index.abs_diff(to.index) >= count;
            (to, if apart { sources(builder, item, 1, count)? } else { return None })
        }
        "fill" => {
            (item.operands.get(1)?.word()?, vec![sources(builder, item, 0, 1)?[0]; count as usize])
        }
        // A shift by one word; with two operands zero comes in.
        _ => {
            let with = item.operands.len() == 3;
            let first = item.operands.get(usize::from(with))?.word()?;
            if builder.memory.is_volatile(first) {
                return None;
            }
            let mut from =
                if with { sources(builder, item, 0, 1)? } else { vec![WordSource::Const(0)] };
            from.extend((0..count - 1).map(|n| WordSource::Cell(first.plus(n))));
            (first, from)
        }
    };
    if !fits(builder.memory, first, count) {
        return None;
    }
    let to = (0..count).map(|n| WordTarget::Cell(first.plus(n))).collect();
    Some(vec![Write::Words(to, Number::Words(from))])
}

/// The exact writes of an instruction on single bits of words. `None` if a word is not a plain word operand, or if a
/// bit number or count is not a constant in its range.
fn bits(builder: &mut OmronBuilder, item: &Item<'_>) -> Option<Vec<Write>> {
    let family = builder.memory.family;
    let value = |set: &str| Logic::Const(item.meaning().starts_with(set));
    let place = |first: Cell, bit: u32| BitTarget::WordBit(first.plus(bit / 16), (bit % 16) as u8);
    match item.meaning() {
        "move-bit" => {
            // The control word: the low two digits are the source bit, the high two digits the destination bit.
            let &Operand::Constant(control, _) = item.operands.get(1)? else { return None };
            let digits = |byte: i64| {
                let byte = u32::try_from(byte & 0xFF).ok()?;
                let bit = match family {
                    super::source::Family::C => (byte >> 4) * 10 + (byte & 15),
                    super::source::Family::Cs => byte,
                };
                (bit < 16).then_some(bit)
            };
            let (from, to) = (digits(control)?, digits(control >> 8)?);
            let target = place(item.operands.get(2)?.word()?, to);
            let source = match item.operands.first()? {
                Operand::Constant(value, _) => Logic::Const(value >> from & 1 == 1),
                Operand::Word(cell) => {
                    let memory = builder.memory;
                    let bit = Operand::Bit(*cell, from as u8)
                        .bit_source(memory, &mut || builder.choice())?;
                    Logic::Bit(bit)
                }
                _ => builder.free_bit(),
            };
            Some(vec![Write::Bit(target, source)])
        }
        "set-bits" | "reset-bits" => {
            let first = item.operands.first()?.word()?;
            let start = item.operands.get(1)?.count(family).filter(|&bit| bit < 16)?;
            let count =
                item.operands.get(2)?.count(family).filter(|&count| count <= 16 * MAX_WORDS)?;
            if !builder.out.has_room(2 * count as usize) {
                return None;
            }
            if !fits(builder.memory, first, (start + count).div_ceil(16)) {
                return None;
            }
            let write = |bit| Write::Bit(place(first, bit), value("set"));
            Some((start..start + count).map(write).collect())
        }
        meaning => {
            let first = item.operands.first()?.word()?;
            let bit = item.operands.get(1)?.count(family).filter(|&bit| bit < 16)?;
            let value = if meaning == "out-bit" { Logic::Condition } else { value("set") };
            Some(vec![Write::Bit(place(first, bit), value)])
        }
    }
}

fn relation(item: &Item<'_>) -> Relation {
    let name = item.row.map_or("", |row| &*row.mnemonic);
    match name.trim_end_matches(|c: char| c.is_ascii_alphabetic() || c == '$') {
        "=" => Relation::Equal,
        "<>" => Relation::NotEqual,
        "<" => Relation::Less,
        "<=" => Relation::LessOrEqual,
        ">" => Relation::Greater,
        _ => Relation::GreaterOrEqual,
    }
}

/// The value of a contact that is a comparison or bit test, with its edge prefix. If the comparison is not modelled, it
/// may be true or false.
pub(super) fn condition(builder: &mut OmronBuilder, item: &Item<'_>) -> Logic {
    let wide = width(item, 0);
    let value = match item.meaning() {
        "test" | "test-not" => test(builder, item),
        "compare" | "compare-signed" | "compare-real" => {
            let format = match item.meaning() {
                "compare" => NumberFormat::Unsigned,
                "compare-signed" => NumberFormat::Signed,
                _ => NumberFormat::Real(builder.choice()),
            };
            comparison(builder, item, (0, 1), wide, relation(item), format)
        }
        _ => None,
    };
    let value = value.unwrap_or_else(|| builder.free_bit());
    match item.raw.edge {
        // With an edge prefix, the result can be true only while the comparison is true (or false).
        None => value,
        Some(edge) => builder.edge(value, edge),
    }
}

fn test(builder: &mut OmronBuilder, item: &Item<'_>) -> Option<Logic> {
    let family = builder.memory.family;
    let bit = item.operands.get(1)?.count(family)? & 15;
    let memory = builder.memory;
    let value = match item.operands.first()? {
        Operand::Constant(value, _) => Logic::Const(value >> bit & 1 == 1),
        Operand::Word(cell) => {
            Logic::Bit(Operand::Bit(*cell, bit as u8).bit_source(memory, &mut || builder.choice())?)
        }
        _ => return None,
    };
    Some(if item.meaning() == "test" { value } else { value.not() })
}

fn comparison(
    builder: &mut OmronBuilder,
    item: &Item<'_>,
    (left, right): (usize, usize),
    wide: u32,
    relation: Relation,
    format: NumberFormat,
) -> Option<Logic> {
    let (left, right) = (number(builder, item, left, wide)?, number(builder, item, right, wide)?);
    Some(Logic::Compare(Box::new(Compare { relation, format, left, right })))
}

/// Whether the limits of ZCP are constants, of which the lower limit is not above the upper one. Otherwise ZCP may be
/// an error that leaves the flags unchanged.
fn limits_in_order(item: &Item<'_>) -> bool {
    let limit = |at: usize| match item.operands.get(at) {
        Some(&Operand::Constant(value, _)) => Some(value),
        _ => None,
    };
    let signed = item.meaning().ends_with("signed");
    let bits = 16 * width(item, 0);
    let read = |value: i64| {
        let value = value & ((1 << bits) - 1);
        if signed && value >> (bits - 1) == 1 { value - (1 << bits) } else { value }
    };
    matches!((limit(1), limit(2)), (Some(low), Some(high)) if read(low) <= read(high))
}

/// The writes of CMP and ZCP: the exact results of the comparison to its flags, any value to the error and negative
/// flags. No writes if the limits of ZCP may be invalid, because [`flags`] then writes any value. `None` if an operand
/// cannot be read.
fn compare_flags(builder: &mut OmronBuilder, item: &Item<'_>) -> Option<Vec<Write>> {
    if item.meaning().starts_with("flags-zone") && !limits_in_order(item) {
        return Some(Vec::new());
    }
    let signed = item.meaning().ends_with("signed");
    let format = if signed { NumberFormat::Signed } else { NumberFormat::Unsigned };
    let wide = width(item, 0);
    let numbers: Option<Vec<Number>> =
        (0..2 + usize::from(item.meaning().starts_with("flags-zone")))
            .map(|at| number(builder, item, at, wide))
            .collect();
    let numbers = numbers?;
    let holds = |relation: Relation, right: usize| {
        let (left, right) = (numbers[0].clone(), numbers[right].clone());
        Logic::Compare(Box::new(Compare { relation, format, left, right }))
    };
    let zone = numbers.len() == 3;
    // ZCP: below the lower limit, above the upper limit, within.
    let values: Vec<(&str, Logic)> = if zone {
        let (below, above) = (holds(Relation::Less, 1), holds(Relation::Greater, 2));
        let within = Logic::Any(vec![below.clone(), above.clone()]).not();
        vec![("GT", above), ("LT", below), ("EQ", within)]
    } else {
        vec![
            ("GT", holds(Relation::Greater, 1)),
            ("EQ", holds(Relation::Equal, 1)),
            ("LT", holds(Relation::Less, 1)),
            ("GE", holds(Relation::GreaterOrEqual, 1)),
            ("NE", holds(Relation::NotEqual, 1)),
            ("LE", holds(Relation::LessOrEqual, 1)),
        ]
    };
    let mut writes: Vec<Write> = values
        .into_iter()
        .filter_map(|(flag, value)| {
            builder.memory.flag(flag).map(|target| Write::Bit(target, value))
        })
        .collect();
    let others: &[&str] =
        if zone { &["ER", "AER", "N", "GE", "NE", "LE"] } else { &["ER", "AER", "N"] };
    let others: Vec<BitTarget> =
        others.iter().filter_map(|flag| builder.memory.flag(flag)).collect();
    writes.extend(
        others.into_iter().map(|target| Write::Bit(target, builder.free_bit())).collect::<Vec<_>>(),
    );
    Some(writes)
}
