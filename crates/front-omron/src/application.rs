//! Lowers an application instruction: its condition, what it writes (exactly or as any value), and its condition flags.

use super::builder::OmronBuilder;
use super::catalog::{Amount, Extent, OperandSpec, Role};
use super::extent::length;
use super::memory::Memory;
use super::operand::Operand;
use super::resolve::Item;
use super::source::Family;
use super::{data, exact};
use scanbound_front::builder::fired;
use scanbound_ir::{AreaId, Counted, Region, Units, When, WordSource, Write};

/// Lowers an application instruction with one condition to a single instruction. What it writes is exact where
/// possible, otherwise any value, which is recorded as an over-approximation.
pub(super) fn lower_application(builder: &mut OmronBuilder, item: &Item<'_>) {
    let mut key = builder.key(item, false);
    key.units = units(builder, item);
    let exact = if item.operands.iter().any(Operand::is_indirect) {
        None
    } else {
        data::exact(builder, item)
    };
    let followed = exact.is_some();
    let carry = exact::carry_before(builder, item).filter(|_| followed);
    let (writes, outcome) = match exact {
        Some(writes) => (writes, exact::KnownResult::Written),
        None => exact::writes(builder, item),
    };
    let widened = !followed && !writes.is_empty();
    let mut effects: Vec<_> = Vec::new();
    if item.raw.immediate {
        effects.extend(refreshed(builder, item).into_iter().map(fired));
    }
    effects.extend(carry);
    effects.extend(writes.into_iter().map(fired));
    effects.extend(exact::flags(builder, item, outcome));
    if item.meaning() == "out-bit" {
        // This is the only instruction that also writes while its condition is off.
        for effect in &mut effects {
            effect.when = When::Always;
        }
    }
    let fires = builder.fires(item.raw.edge);
    builder.act(fires, effects, Some(key));
    if widened {
        let written = written(builder, item);
        builder.approximate(match written.is_empty() {
            true if item.name == "SRCH" => "IR0 and DR0 may have any value".to_owned(),
            true => "everything that this instruction writes may have any value".to_owned(),
            false => format!("{written} may have any value"),
        });
    }
    data::note_indirect(builder, item);
}

/// The operands that the instruction writes, as text for a message.
fn written(builder: &OmronBuilder, item: &Item<'_>) -> String {
    let Some(row) = item.row else { return item.raw.operands.join(", ") };
    let slots = row.operands.iter().zip(&item.raw.operands).zip(&item.operands);
    let parts = slots.filter(|((slot, _), _)| is_written(slot)).map(|((slot, text), operand)| {
        let length = match slot.extent {
            Extent::Words(amount) => length(builder.memory, item, amount),
            _ => None,
        };
        match (length, operand) {
            (_, Operand::Within(_)) => format!("everything that {text} may point to"),
            (_, Operand::Anywhere) => "all memory".to_owned(),
            (Some(1), _) => text.clone(),
            (Some(2), _) => format!("{text} and the word after it"),
            (Some(count), _) => {
                format!("{text} and the {} words after it", count.saturating_sub(1))
            }
            (None, _) => format!("the whole area of {text}"),
        }
    });
    parts.collect::<Vec<_>>().join(", ")
}

fn is_written(slot: &OperandSpec) -> bool {
    slot.written_words().is_some() || slot.role == Role::ReadWriteIfDevice
}

/// The number of units of the instruction: the words, or for some instructions bits or characters, that it processes.
fn units(builder: &OmronBuilder, item: &Item<'_>) -> Units {
    let Some(row) = item.row else { return Units::None };
    // No manual of CS, CJ and CP says that a count beyond the end of an area is an error.
    let most = match builder.memory.family {
        Family::C => u64::from(builder.memory.size(AreaId(4))),
        Family::Cs => u64::from(u16::MAX),
    };
    let of = |length: Option<u32>, (operand, unit): (usize, u32)| match length {
        Some(count) => Units::Exactly(u64::from(count)),
        None => counted(builder, item, operand, unit)
            .map_or(Units::AtMost(most), |words| Units::Counted(Counted { most, ..words })),
    };
    let amounts = row.operands.iter().filter_map(OperandSpec::written_words);
    let ranged = amounts.clone().find(|amount| amount.counter().is_some());
    match (ranged, row.class, &*row.mnemonic) {
        // Bits; the last operand gives their number.
        (_, _, "SETA" | "RSTA" | "NSFL" | "NSFR") => {
            let count = item.operands.last().and_then(|bits| bits.count(builder.memory.family));
            count.map_or(Units::AtMost(65_535), |count| Units::Exactly(u64::from(count)))
        }
        (Some(amount @ Amount::Counted { unit, operand }), ..) => {
            of(length(builder.memory, item, amount), (operand, unit))
        }
        (Some(amount), ..) => length(builder.memory, item, amount)
            .map_or(Units::AtMost(most), |count| Units::Exactly(u64::from(count))),
        (None, "search", "TCMP" | "MCMP") => Units::Exactly(16),
        (None, "search", "BCMP") => Units::Exactly(32),
        (None, "search", "BCMP2") => Units::Exactly(512),
        (None, "search", _) => {
            let first = item.operands.first();
            of(first.and_then(|operand| operand.count(builder.memory.family)), (0, 1))
        }
        // The longest string has 4095 characters.
        (None, "string" | "compare-string", _) => Units::AtMost(4095),
        (None, "block" | "table" | "module", _) => Units::AtMost(most),
        (None, "conversion" | "shift" | "bit" | "special", _) => {
            let words: u32 =
                amounts.filter_map(|amount| length(builder.memory, item, amount)).sum();
            Units::Exactly(u64::from(words.max(1)))
        }
        _ => Units::None,
    }
}

/// The word that counts an instruction's units at run time. `None` if the operand is not a word, if the instruction has
/// the prefix `!`, if the system may change the word, or on the C series (where the count is BCD, which the analysis of
/// word values does not support).
fn counted(builder: &OmronBuilder, item: &Item<'_>, operand: usize, unit: u32) -> Option<Counted> {
    let Operand::Word(count) = *item.operands.get(operand)? else { return None };
    // With `!`, the input is read again before, so the word may differ from what the program saw or wrote.
    if builder.memory.family == Family::C || item.raw.immediate || builder.memory.is_volatile(count)
    {
        return None;
    }
    // The instruction surely executes if its blocks do not exceed their areas.
    let room = |(at, other): (usize, &Operand)| match *other {
        _ if at == operand => None,
        Operand::Word(first) => Some(builder.memory.size(first.area).saturating_sub(first.index)),
        _ => Some(0),
    };
    let room = item.operands.iter().enumerate().filter_map(room).min().unwrap_or(0);
    Some(Counted {
        words: vec![WordSource::Cell(count)],
        each: u64::from(unit),
        most: u64::MAX,
        executes_up_to: u64::from(room / unit.max(1)),
    })
}

/// Writes of any value to the words in the I/O area that the instruction reads, which its prefix `!` refreshes before
/// it.
fn refreshed(builder: &mut OmronBuilder, item: &Item<'_>) -> Vec<Write> {
    let Some(row) = item.row else { return Vec::new() };
    let mut writes = Vec::new();
    for (slot, operand) in row.operands.iter().zip(&item.operands) {
        if let (
            OperandSpec {
                role: Role::Source | Role::ReadWriteIfDevice,
                extent: Extent::Words(Amount::Fixed(count)),
            },
            Operand::Word(first),
        ) = (slot, operand)
            && Memory::is_refreshed(*first)
        {
            writes.push(Write::Havoc(
                Region::Range { first: *first, count: *count },
                builder.choice(),
            ));
        }
    }
    writes
}
