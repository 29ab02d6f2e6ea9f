//! An application instruction: its condition, what it writes, exactly or as any value, and the flags behind it.

use super::assembly::Assembly;
use super::catalog::{Amount, Extent, Role, Slot};
use super::extent::length;
use super::memory::Memory;
use super::operand::Operand;
use super::resolve::Item;
use super::source::Family;
use super::{data, exact};
use scanbound_front::builder::fired;
use scanbound_ir::{AreaId, Counted, Region, Units, When, WordSource, Write};

/// An application instruction with one condition.
pub(super) fn act(asm: &mut Assembly, item: &Item<'_>) {
    let mut key = asm.key(item, false);
    key.units = units(asm, item);
    let exact =
        if item.operands.iter().any(Operand::is_indirect) { None } else { data::exact(asm, item) };
    let followed = exact.is_some();
    let carry = exact::carry_before(asm, item).filter(|_| followed);
    let (writes, outcome) = match exact {
        Some(writes) => (writes, exact::Outcome::Written),
        None => exact::writes(asm, item),
    };
    let widened = !followed && !writes.is_empty();
    let mut effects: Vec<_> = Vec::new();
    if item.raw.immediate {
        effects.extend(refreshed(asm, item).into_iter().map(fired));
    }
    effects.extend(carry);
    effects.extend(writes.into_iter().map(fired));
    effects.extend(exact::flags(asm, item, outcome));
    if item.meaning() == "out-bit" {
        // The one instruction here that also writes while its condition is off.
        for effect in &mut effects {
            effect.when = When::Always;
        }
    }
    let fires = asm.fires(item.raw.edge);
    asm.act(fires, effects, Some(key));
    if widened {
        let written = written(asm, item);
        asm.note(match written.is_empty() {
            true if item.name == "SRCH" => "IR0 and DR0 take any value".to_owned(),
            true => "what this changes takes any value".to_owned(),
            false => format!("{written} takes any value"),
        });
    }
    data::note_indirect(asm, item);
}

/// The operands that are written, as the source has them.
fn written(asm: &Assembly, item: &Item<'_>) -> String {
    let Some(row) = item.row else { return item.raw.operands.join(", ") };
    let slots = row.operands.iter().zip(&item.raw.operands).zip(&item.operands);
    let parts = slots.filter(|((slot, _), _)| is_written(slot)).map(|((slot, text), operand)| {
        let length = match slot.extent {
            Extent::Words(amount) => length(asm.memory, item, amount),
            _ => None,
        };
        match (length, operand) {
            (_, Operand::Within(_)) => format!("all that {text} may lead to"),
            (_, Operand::Anywhere) => "all memory".to_owned(),
            (Some(1), _) => text.clone(),
            (Some(2), _) => format!("{text} and the word behind it"),
            (Some(count), _) => {
                format!("{text} and the {} words behind it", count.saturating_sub(1))
            }
            (None, _) => format!("the whole area of {text}"),
        }
    });
    parts.collect::<Vec<_>>().join(", ")
}

fn is_written(slot: &Slot) -> bool {
    slot.written_words().is_some() || slot.role == Role::ReadWriteIfDevice
}

/// How many words the instruction handles, for times by the word.
fn units(asm: &Assembly, item: &Item<'_>) -> Units {
    let Some(row) = item.row else { return Units::None };
    // No manual of CS, CJ and CP says that a count is refused that leads past the end of an area.
    let most = match asm.memory.family {
        Family::C => u64::from(asm.memory.size(AreaId(4))),
        Family::Cs => u64::from(u16::MAX),
    };
    let of = |length: Option<u32>, (operand, unit): (usize, u32)| match length {
        Some(count) => Units::Exactly(u64::from(count)),
        None => counted(asm, item, operand, unit)
            .map_or(Units::AtMost(most), |words| Units::Counted(Counted { most, ..words })),
    };
    let amounts = row.operands.iter().filter_map(Slot::written_words);
    let ranged = amounts.clone().find(|amount| amount.counter().is_some());
    match (ranged, row.class, &*row.mnemonic) {
        // Bits, as many as the last operand says.
        (_, _, "SETA" | "RSTA" | "NSFL" | "NSFR") => {
            let count = item.operands.last().and_then(|bits| bits.count(asm.memory.family));
            count.map_or(Units::AtMost(65_535), |count| Units::Exactly(u64::from(count)))
        }
        (Some(amount @ Amount::Counted { unit, operand }), ..) => {
            of(length(asm.memory, item, amount), (operand, unit))
        }
        (Some(amount), ..) => length(asm.memory, item, amount)
            .map_or(Units::AtMost(most), |count| Units::Exactly(u64::from(count))),
        (None, "search", "TCMP" | "MCMP") => Units::Exactly(16),
        (None, "search", "BCMP") => Units::Exactly(32),
        (None, "search", "BCMP2") => Units::Exactly(512),
        (None, "search", _) => {
            let first = item.operands.first();
            of(first.and_then(|operand| operand.count(asm.memory.family)), (0, 1))
        }
        // Strings hold 4095 characters at most.
        (None, "string" | "compare-string", _) => Units::AtMost(4095),
        (None, "block" | "table" | "module", _) => Units::AtMost(most),
        (None, "conversion" | "shift" | "bit" | "special", _) => {
            let words: u32 = amounts.filter_map(|amount| length(asm.memory, item, amount)).sum();
            Units::Exactly(u64::from(words.max(1)))
        }
        _ => Units::None,
    }
}

/// A count that stands in a word, of which no more is said than where it is read. On the C series it is a decimal number,
/// of which words are not followed.
fn counted(asm: &Assembly, item: &Item<'_>, operand: usize, unit: u32) -> Option<Counted> {
    let Operand::Word(count) = *item.operands.get(operand)? else { return None };
    // `!` reads an input anew before; the system may change the word between what wrote it and this.
    if asm.memory.family == Family::C || item.raw.immediate || asm.memory.is_volatile(count) {
        return None;
    }
    // Surely carried out is what lies within its areas.
    let room = |(at, other): (usize, &Operand)| match *other {
        _ if at == operand => None,
        Operand::Word(first) => Some(asm.memory.size(first.area).saturating_sub(first.index)),
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

/// Input words that `!` reads anew before the instruction runs.
fn refreshed(asm: &mut Assembly, item: &Item<'_>) -> Vec<Write> {
    let Some(row) = item.row else { return Vec::new() };
    let mut writes = Vec::new();
    for (slot, operand) in row.operands.iter().zip(&item.operands) {
        if let (
            Slot {
                role: Role::Source | Role::ReadWriteIfDevice,
                extent: Extent::Words(Amount::Fixed(count)),
            },
            Operand::Word(first),
        ) = (slot, operand)
            && Memory::is_refreshed(*first)
        {
            writes.push(Write::Havoc(Region::Range { first: *first, count: *count }, asm.choice()));
        }
    }
    writes
}
