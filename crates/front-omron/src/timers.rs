//! Timers, counters, KEEP and SFT: coils that take time or several branches.

use super::assembly::{Assembly, BRANCHES};
use super::data;
use super::extent;
use super::operand::{Notation, Operand};
use super::resolve::Item;
use super::source::RawInstruction;
use scanbound_base::time::Picos;
use scanbound_front::builder::{always, fired};
use scanbound_ir::timers::{Expiry, TimerKind, TimerOrCounter};
use scanbound_ir::{
    AreaId, BitSource, BitTarget, Cell, ChoiceId, Compare, Effect, Logic, Number, NumberFormat,
    Region, Relation, WordSource, Write,
};

/// The present value's word behind a completion flag: its area follows that of the flags.
fn present(flag: Cell) -> Cell {
    Cell { area: AreaId(flag.area.0 + 1), index: flag.index }
}

fn havoc_present(flag: Cell, choice: ChoiceId) -> Write {
    Write::Havoc(Region::Range { first: present(flag), count: 1 }, choice)
}

/// Whether the system counts the timer on between instructions: those of 10 ms and less.
pub(super) fn is_fast(raw: &RawInstruction) -> bool {
    let name = raw.mnemonic.to_ascii_uppercase();
    let named = ["TIMH", "TMHH", "TIMU", "TMUH"].iter().any(|kind| name.starts_with(kind));
    named || (name.is_empty() && raw.number.is_some_and(|number| number.value == 15))
}

/// What a timer's or counter's setting may be.
struct Setting {
    /// Where it stands, if that is known.
    source: Option<WordSource>,
    /// Whether it is decimal digits.
    is_decimal: bool,
    /// It is no decimal number where one is asked for: the instruction may end in an error, which leaves the flag.
    wrong: Logic,
    /// That, or it is 0: what becomes of the flag then is not the outside's.
    odd: Logic,
}

fn setting(asm: &mut Assembly, item: &Item<'_>) -> Setting {
    let binary = item.row.is_some_and(|row| row.mnemonic.ends_with('X'));
    let source = data::sources(asm, item, 1, 1).map(|sources| sources[0]);
    let (wrong, zero) = match (source, item.operands.get(1)) {
        (Some(WordSource::Const(value)), Some(&Operand::Constant(_, notation))) => {
            let digits = (0..4).any(|place| value >> (4 * place) & 15 > 9);
            (Logic::Const(notation == Notation::Digits && digits), Logic::Const(value == 0))
        }
        (Some(WordSource::Cell(word)), _) => {
            let bit = |bit| Logic::Bit(BitSource::WordBit(word, bit));
            let above = |place: u8| {
                let more = Logic::Any(vec![bit(4 * place + 1), bit(4 * place + 2)]);
                Logic::All(vec![bit(4 * place + 3), more])
            };
            let any = Logic::Any((0..16).map(bit).collect());
            (Logic::Any((0..4).map(above).collect()), any.not())
        }
        _ => (asm.free(), Logic::Const(false)),
    };
    let wrong = if binary { Logic::Const(false) } else { wrong };
    let odd = Logic::Any(vec![wrong.clone(), zero]);
    Setting { source, is_decimal: !binary, wrong, odd }
}

impl Setting {
    /// Whether the time or count is over, which the outside says.
    fn over(&self, asm: &mut Assembly) -> Logic {
        let over = asm.world();
        self.over_by(asm, over)
    }

    /// The same by this choice.
    fn over_by(&self, asm: &mut Assembly, over: ChoiceId) -> Logic {
        let over = Logic::Bit(BitSource::Free(over));
        match self.odd {
            Logic::Any(ref parts) if parts.iter().all(|part| *part == Logic::Const(false)) => over,
            ref odd => Logic::Any(vec![
                Logic::All(vec![over, odd.clone().not()]),
                Logic::All(vec![asm.free(), odd.clone()]),
            ]),
        }
    }

    /// Whether a timer is over that runs: not in the scan that starts it, unless it is set to no more than what one scan
    /// can take.
    fn elapsed(&self, asm: &mut Assembly, item: &Item<'_>, flag: Cell) -> Logic {
        let (Some(unit), Some(setting)) = (step(item), self.source) else { return self.over(asm) };
        let runs = asm.memory.runs(flag);
        let over = asm.world();
        if !asm.repeated {
            let on_delay = Expiry::of_on_delay(runs, setting, unit);
            let expiry = Expiry { is_decimal: self.is_decimal, ..on_delay };
            asm.out.program.timekeeping.expiries.insert(over, expiry);
        }
        let ticks = asm.out.scan_ticks(unit, self.is_decimal);
        let number = |word| Number::Words(vec![word]);
        let at_once = Logic::Compare(Box::new(Compare {
            relation: Relation::LessOrEqual,
            format: NumberFormat::Unsigned,
            left: number(setting),
            right: number(WordSource::Free(ticks)),
        }));
        let has_started = Logic::Any(vec![Logic::cell(runs), at_once, self.odd.clone()]);
        Logic::All(vec![self.over_by(asm, over), has_started])
    }

    /// The value, or what the bit held where the instruction may end in an error.
    fn unless_wrong(&self, asm: &mut Assembly, value: Logic, bit: Cell) -> Logic {
        match &self.wrong {
            Logic::Const(false) => value,
            wrong => {
                let kept = Logic::All(vec![Logic::cell(bit), wrong.clone(), asm.free()]);
                Logic::Any(vec![value, kept])
            }
        }
    }

    fn note(&self, asm: &mut Assembly) {
        if self.wrong != Logic::Const(false) {
            asm.note("its flag may stay as it is while its setting is no decimal number");
        }
    }
}

/// A timer with one branch, or the instruction that resets timers.
pub(super) fn timer(asm: &mut Assembly, item: &Item<'_>) {
    let key = asm.key(item, false);
    let choice = asm.choice();
    let mut effects: Vec<Effect> = Vec::new();
    let mut set = None;
    match (item.meaning(), item.operands.first()) {
        ("timer", Some(Operand::Flag(flag))) => {
            let setting = setting(asm, item);
            // Done only while the condition holds, and then at some time.
            let done = Logic::All(vec![Logic::Condition, setting.elapsed(asm, item, *flag)]);
            let value = setting.unless_wrong(asm, done, *flag);
            effects.push(always(Write::Bit(BitTarget::Cell(*flag), value)));
            effects.push(always(havoc_present(*flag, choice)));
            let runs = asm.memory.runs(*flag);
            let value = setting.unless_wrong(asm, Logic::Condition, runs);
            effects.push(always(Write::Bit(BitTarget::Cell(runs), value)));
            set = Some(setting);
        }
        ("timer-unknown", Some(Operand::Flag(flag))) => {
            let value = asm.free();
            effects.push(always(Write::Bit(BitTarget::Cell(*flag), value)));
            effects.push(always(havoc_present(*flag, choice)));
        }
        ("reset-timers", _) => {
            let reset = reset_range(&item.operands);
            match reset {
                Some(flags) => {
                    for flag in flags {
                        let bit = |cell, value| fired(Write::Bit(BitTarget::Cell(cell), value));
                        effects.push(bit(flag, Logic::Const(false)));
                        effects.push(fired(havoc_present(flag, choice)));
                        // Whether a timer whose condition stays on begins anew is not known.
                        let runs = asm.memory.runs(flag);
                        let value = Logic::All(vec![Logic::cell(runs), asm.free()]);
                        effects.push(bit(runs, value));
                    }
                }
                None => effects.push(fired(Write::Havoc(Region::Everything, choice))),
            }
        }
        _ => {
            let writes = data::havoc(asm, item, choice);
            effects.extend(writes.into_iter().map(always));
        }
    }
    let flags = data::flags(asm, item);
    effects.extend(flags.into_iter().map(always));
    let fires = asm.fires(item.raw.edge);
    let at = asm.act(fires, effects, Some(key));
    if let ("timer", Some(Operand::Flag(flag))) = (item.meaning(), item.operands.first()) {
        keep_time(asm, item, at, *flag, 0);
    }
    if let Some(setting) = set {
        setting.note(asm);
    }
    match item.meaning() {
        "timer-unknown" => asm.note("this timer's completion flag is on or off at will"),
        "havoc-always" => asm.note("this timer's flags and values take any value"),
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
    let whole = asm.act(Logic::Condition, flags, Some(key));
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
            let setting = setting(asm, item);
            let done = Logic::Any(vec![Logic::cell(*flag), setting.over(asm)]);
            asm.product(&[(0, true), (reset, false)]);
            let effects =
                vec![fired(Write::Bit(target, done)), fired(havoc_present(*flag, choice))];
            asm.act(Logic::Condition, effects, None);
            reset_flag(asm, reset, *flag, &setting);
        }
        ("counter-reversible", Some(target), Some(Operand::Flag(flag))) => {
            let setting = setting(asm, item);
            for counting in [0, 1] {
                asm.product(&[(counting, true), (reset, false)]);
                let value = setting.over(asm);
                let choice = asm.choice();
                let effects =
                    vec![fired(Write::Bit(target, value)), fired(havoc_present(*flag, choice))];
                asm.act(Logic::Condition, effects, None);
            }
            reset_flag(asm, reset, *flag, &setting);
        }
        ("shift-register", ..) => shift_register(asm, item, reset),
        _ => {
            let regions =
                item.operands.first().map(|operand| operand.regions(Some(1))).unwrap_or_default();
            let effects =
                regions.into_iter().map(|region| always(Write::Havoc(region, choice))).collect();
            asm.act(Logic::Condition, effects, None);
            asm.note("what this writes is not known: all it may be takes any value");
        }
    }
    if let ("counter" | "timer-holding" | "counter-reversible", Some(Operand::Flag(flag))) =
        (item.meaning(), item.operands.first())
    {
        keep_time(asm, item, whole, *flag, branches);
    }
}

/// In what steps a timer goes; none for what is no timer of known steps.
fn step(item: &Item<'_>) -> Option<Picos> {
    const MS: u64 = 1_000_000_000;
    let name = item.row.map_or("", |row| &*row.mnemonic);
    Some(Picos(match name.strip_suffix('X').unwrap_or(name) {
        "TIM" | "TTIM" => 100 * MS,
        "TIMH" => 10 * MS,
        "TMHH" => MS,
        "TIMU" => MS / 10,
        "TMUH" => MS / 100,
        _ => return None,
    }))
}

/// Says how an emulated CPU runs the timer or counter that begins at an instruction.
fn keep_time(asm: &mut Assembly, item: &Item<'_>, at: usize, flag: Cell, branches: u32) {
    let manner = match (item.meaning(), step(item)) {
        ("timer", Some(step)) => TimerKind::DownTimer(step),
        ("timer-holding", Some(step)) => TimerKind::RetentiveTimer(step),
        ("counter", _) => TimerKind::DownCounter,
        ("counter-reversible", _) => TimerKind::RingCounter,
        _ => return,
    };
    // Where an index or another address says where the setting stands, the timer is not followed.
    let plain = matches!(item.operands.get(1), Some(Operand::Constant(..) | Operand::Word(_)));
    let setting = if plain { data::sources(asm, item, 1, 1) } else { None };
    let Some(&[setting]) = setting.as_deref() else { return };
    let timed = TimerOrCounter {
        kind: manner,
        flag,
        present: present(flag),
        setting,
        is_decimal: !item.row.is_some_and(|row| row.mnemonic.ends_with('X')),
        inputs: (0..branches).map(|branch| BRANCHES + branch).collect(),
        parts: at + 1..asm.next(),
    };
    asm.out.program.timekeeping.instructions.insert(at, timed);
}

fn reset_flag(asm: &mut Assembly, reset: u32, flag: Cell, setting: &Setting) {
    let choice = asm.choice();
    asm.product(&[(reset, true)]);
    let value = setting.unless_wrong(asm, Logic::Const(false), flag);
    let effects =
        vec![fired(Write::Bit(BitTarget::Cell(flag), value)), fired(havoc_present(flag, choice))];
    asm.act(Logic::Condition, effects, None);
    setting.note(asm);
}

/// SFT: on the second branch's rising edge all bits go one place up and the first branch comes in.
fn shift_register(asm: &mut Assembly, item: &Item<'_>, reset: u32) {
    let words = match (item.operands.first(), item.operands.get(1)) {
        (Some(Operand::Word(first)), Some(Operand::Word(last)))
            if first.area == last.area
                && first.index <= last.index
                && last.index - first.index < extent::MOST_WORDS =>
        {
            Some((*first, last.index - first.index + 1))
        }
        _ => None,
    };
    let edge = asm.world();
    let moves = Logic::All(vec![Logic::Condition, Logic::Bit(scanbound_ir::BitSource::Free(edge))]);
    asm.product(&[(1, true), (reset, false)]);
    let Some((first, count)) = words else {
        let choice = asm.choice();
        let effects = data::havoc(asm, item, choice).into_iter().map(always).collect();
        asm.act(moves, effects, None);
        asm.note("which words are shifted is not known: all they may be take any value");
        return;
    };
    let place = |bit: u32| (first.plus(bit / 16), (bit % 16) as u8);
    let mut effects = Vec::new();
    for bit in (1..16 * count).rev() {
        let (from, to) = (place(bit - 1), place(bit));
        let value = Logic::Bit(scanbound_ir::BitSource::WordBit(from.0, from.1));
        effects.push(fired(Write::Bit(BitTarget::WordBit(to.0, to.1), value)));
    }
    effects.push(fired(Write::Bit(BitTarget::WordBit(first, 0), Logic::Const(false))));
    asm.act(moves.clone(), effects, None);
    asm.product(&[(0, true), (1, true), (reset, false)]);
    asm.act(moves, vec![fired(Write::Bit(BitTarget::WordBit(first, 0), Logic::Const(true)))], None);
    asm.product(&[(reset, true)]);
    let words = (0..count).map(|n| scanbound_ir::WordTarget::Cell(first.plus(n))).collect();
    let zeros =
        scanbound_ir::Number::Words(vec![scanbound_ir::WordSource::Const(0); count as usize]);
    asm.act(Logic::Condition, vec![fired(Write::Words(words, zeros))], None);
}
