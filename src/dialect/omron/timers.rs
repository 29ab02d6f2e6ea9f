//! Timers, counters, KEEP and SFT: coils that take time or several branches.

use super::assembly::{Assembly, always, fired};
use super::data;
use super::operand::Operand;
use super::resolve::Item;
use super::source::RawInstruction;
use crate::program::{AreaId, BitTarget, Cell, ChoiceId, Effect, Logic, Region, Write};

/// The present value's word behind a completion flag: its area follows that of the flags.
fn present(flag: Cell) -> Cell {
    Cell { area: AreaId(flag.area.0 + 1), index: flag.index }
}

fn forget_present(flag: Cell, choice: ChoiceId) -> Write {
    Write::Forget(Region::Range { first: present(flag), count: 1 }, choice)
}

/// Whether the system counts the timer on between instructions: those of 10 ms and less.
pub(super) fn is_fast(raw: &RawInstruction) -> bool {
    let name = raw.mnemonic.to_ascii_uppercase();
    let named = ["TIMH", "TMHH", "TIMU", "TMUH"].iter().any(|kind| name.starts_with(kind));
    named || (name.is_empty() && raw.number.is_some_and(|number| number.value == 15))
}

/// A timer with one branch, or the instruction that resets timers.
pub(super) fn timer(asm: &mut Assembly, item: &Item<'_>) {
    let key = asm.key(item, false);
    let choice = asm.choice();
    let mut effects: Vec<Effect> = Vec::new();
    match (item.meaning(), item.operands.first()) {
        ("timer", Some(Operand::Flag(flag))) => {
            // Done only while the condition holds, and then at some time.
            let value = Logic::All(vec![Logic::Condition, asm.any()]);
            effects.push(always(Write::Bit(BitTarget::Cell(*flag), value)));
            effects.push(always(forget_present(*flag, choice)));
            if asm.fast.contains(flag) {
                let runs = BitTarget::Cell(asm.memory.runs(*flag));
                effects.push(always(Write::Bit(runs, Logic::Condition)));
            }
        }
        ("timer-unknown", Some(Operand::Flag(flag))) => {
            let value = asm.free();
            effects.push(always(Write::Bit(BitTarget::Cell(*flag), value)));
            effects.push(always(forget_present(*flag, choice)));
        }
        ("reset-timers", _) => {
            let reset = reset_range(&item.operands);
            match reset {
                Some(flags) => {
                    for flag in flags {
                        effects.push(fired(Write::Bit(BitTarget::Cell(flag), Logic::Const(false))));
                        effects.push(fired(forget_present(flag, choice)));
                    }
                }
                None => effects.push(fired(Write::Forget(Region::Everything, choice))),
            }
        }
        _ => {
            let writes = data::forget(asm, item, choice);
            effects.extend(writes.into_iter().map(always));
        }
    }
    let flags = data::flags(asm, item);
    effects.extend(flags.into_iter().map(always));
    let fires = asm.fires(item.raw.edge);
    asm.act(fires, effects, Some(key));
    match item.meaning() {
        "timer-unknown" => asm.note("this timer's completion flag is on or off at will"),
        "always-forget" => asm.note("this timer's flags and values take any value"),
        "timer" if !matches!(item.operands.first(), Some(Operand::Flag(_))) => {
            asm.note("which timer this is is not known: all timers take any value");
        }
        _ => {}
    }
    data::note_indirect(asm, item);
}

/// The flags from the first to the last that are reset; `None` if they are not known.
fn reset_range(operands: &[Operand]) -> Option<Vec<Cell>> {
    let (first, last) = match operands {
        [Operand::Flag(one)] => (one, one),
        [Operand::Flag(first), Operand::Flag(last)] => (first, last),
        _ => return None,
    };
    let in_order = first.area == last.area && first.index <= last.index;
    in_order.then(|| (0..=last.index - first.index).map(|n| first.plus(n)).collect())
}

/// An instruction with two or three branches, the last of which resets and wins.
pub(super) fn branched(asm: &mut Assembly, item: &Item<'_>) {
    let key = asm.key(item, true);
    let branches =
        if matches!(item.meaning(), "counter-reversible" | "shift-register") { 3 } else { 2 };
    let reset = branches - 1;
    asm.split(branches);
    // The price is one for the instruction, whichever of its branches hold.
    asm.always();
    let flags: Vec<Effect> = data::flags(asm, item).into_iter().map(always).collect();
    asm.act(Logic::Condition, flags, Some(key));
    let choice = asm.choice();
    let target = match item.operands.first() {
        Some(Operand::Flag(flag)) => Some(BitTarget::Cell(*flag)),
        Some(operand) => operand.bit_target(),
        None => None,
    };
    match (item.meaning(), target, item.operands.first()) {
        ("keep", Some(target), _) => {
            asm.product(&[(0, true), (reset, false)]);
            asm.act(Logic::Condition, vec![fired(Write::Bit(target, Logic::Const(true)))], None);
            asm.product(&[(reset, true)]);
            asm.act(Logic::Condition, vec![fired(Write::Bit(target, Logic::Const(false)))], None);
        }
        ("counter" | "timer-holding", Some(target), Some(Operand::Flag(flag))) => {
            // On its way the flag can only come on; the reset takes it off.
            let done = Logic::Any(vec![Logic::cell(*flag), asm.any()]);
            asm.product(&[(0, true), (reset, false)]);
            let effects =
                vec![fired(Write::Bit(target, done)), fired(forget_present(*flag, choice))];
            asm.act(Logic::Condition, effects, None);
            reset_flag(asm, reset, *flag);
        }
        ("counter-reversible", Some(target), Some(Operand::Flag(flag))) => {
            for counting in [0, 1] {
                asm.product(&[(counting, true), (reset, false)]);
                let value = asm.any();
                let choice = asm.choice();
                let effects =
                    vec![fired(Write::Bit(target, value)), fired(forget_present(*flag, choice))];
                asm.act(Logic::Condition, effects, None);
            }
            reset_flag(asm, reset, *flag);
        }
        ("shift-register", ..) => shift_register(asm, item, reset),
        _ => {
            let regions =
                item.operands.first().map(|operand| operand.regions(Some(1))).unwrap_or_default();
            let effects =
                regions.into_iter().map(|region| always(Write::Forget(region, choice))).collect();
            asm.act(Logic::Condition, effects, None);
            asm.note("what this writes is not known: all it may be takes any value");
        }
    }
}

fn reset_flag(asm: &mut Assembly, reset: u32, flag: Cell) {
    let choice = asm.choice();
    asm.product(&[(reset, true)]);
    let effects = vec![
        fired(Write::Bit(BitTarget::Cell(flag), Logic::Const(false))),
        fired(forget_present(flag, choice)),
    ];
    asm.act(Logic::Condition, effects, None);
}

/// SFT: on the second branch's rising edge all bits go one place up and the first branch comes in.
fn shift_register(asm: &mut Assembly, item: &Item<'_>, reset: u32) {
    let words = match (item.operands.first(), item.operands.get(1)) {
        (Some(Operand::Word(first)), Some(Operand::Word(last)))
            if first.area == last.area
                && first.index <= last.index
                && last.index - first.index < data::MOST_WORDS =>
        {
            Some((*first, last.index - first.index + 1))
        }
        _ => None,
    };
    let edge = asm.world();
    let moves =
        Logic::All(vec![Logic::Condition, Logic::Bit(crate::program::BitSource::Free(edge))]);
    asm.product(&[(1, true), (reset, false)]);
    let Some((first, count)) = words else {
        let choice = asm.choice();
        let effects = data::forget(asm, item, choice).into_iter().map(always).collect();
        asm.act(moves, effects, None);
        asm.note("which words are shifted is not known: all they may be take any value");
        return;
    };
    let place = |bit: u32| (first.plus(bit / 16), (bit % 16) as u8);
    let mut effects = Vec::new();
    for bit in (1..16 * count).rev() {
        let (from, to) = (place(bit - 1), place(bit));
        let value = Logic::Bit(crate::program::BitSource::WordBit(from.0, from.1));
        effects.push(fired(Write::Bit(BitTarget::WordBit(to.0, to.1), value)));
    }
    effects.push(fired(Write::Bit(BitTarget::WordBit(first, 0), Logic::Const(false))));
    asm.act(moves.clone(), effects, None);
    asm.product(&[(0, true), (1, true), (reset, false)]);
    asm.act(moves, vec![fired(Write::Bit(BitTarget::WordBit(first, 0), Logic::Const(true)))], None);
    asm.product(&[(reset, true)]);
    let words = (0..count).map(|n| crate::program::WordTarget::Cell(first.plus(n))).collect();
    let zeros =
        crate::program::Number::Words(vec![crate::program::WordSource::Const(0); count as usize]);
    asm.act(Logic::Condition, vec![fired(Write::Words(words, zeros))], None);
}
