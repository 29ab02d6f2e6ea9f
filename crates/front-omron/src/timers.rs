//! Lowers timers, counters, KEEP and SFT: coils that depend on time or on several branches.

use super::builder::{BRANCHES, OmronBuilder};
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

/// The present value that belongs to a completion flag; its area directly follows that of the flags.
fn present(flag: Cell) -> Cell {
    Cell { area: AreaId(flag.area.0 + 1), index: flag.index }
}

fn havoc_present(flag: Cell, choice: ChoiceId) -> Write {
    Write::Havoc(Region::Range { first: present(flag), count: 1 }, choice)
}

/// Whether the instruction is a timer that may time out between two instructions: its time base is 10 ms or less.
pub(super) fn is_fast(raw: &RawInstruction) -> bool {
    let name = raw.mnemonic.to_ascii_uppercase();
    let named = ["TIMH", "TMHH", "TIMU", "TMUH"].iter().any(|kind| name.starts_with(kind));
    named || (name.is_empty() && raw.number.is_some_and(|number| number.value == 15))
}

/// The set value of a timer or counter.
struct Setting {
    /// The word or constant of the set value. `None` if unknown.
    source: Option<WordSource>,
    /// Whether the set value is in BCD.
    is_decimal: bool,
    /// The condition under which the set value is not valid BCD. The instruction may then be an error and leave the
    /// flag unchanged.
    wrong: Logic,
    /// The condition under which the set value is 0 or not valid BCD. The flag then does not depend on elapsed time.
    odd: Logic,
}

fn setting(builder: &mut OmronBuilder, item: &Item<'_>) -> Setting {
    let binary = item.row.is_some_and(|row| row.mnemonic.ends_with('X'));
    let source = data::sources(builder, item, 1, 1).map(|sources| sources[0]);
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
        _ => (builder.free_bit(), Logic::Const(false)),
    };
    let wrong = if binary { Logic::Const(false) } else { wrong };
    let odd = Logic::Any(vec![wrong.clone(), zero]);
    Setting { source, is_decimal: !binary, wrong, odd }
}

impl Setting {
    /// Whether the timer has timed out, or the counter has reached its set value. Earlier scans decide this, so it is a
    /// new choice, of which nothing is known if the set value is 0 or invalid.
    fn has_elapsed(&self, builder: &mut OmronBuilder) -> Logic {
        let over = match self.source {
            // A counter of 1 reaches it with the first count, unless its present value was written.
            Some(WordSource::Const(1)) => builder.choice(),
            _ => builder.earlier_choice(),
        };
        self.has_elapsed_by(builder, over)
    }

    /// As [`Setting::has_elapsed`], with the given choice for whether the timer has timed out.
    fn has_elapsed_by(&self, builder: &mut OmronBuilder, over: ChoiceId) -> Logic {
        let over = Logic::Bit(BitSource::Free(over));
        match self.odd {
            Logic::Any(ref parts) if parts.iter().all(|part| *part == Logic::Const(false)) => over,
            ref odd => Logic::Any(vec![
                Logic::All(vec![over, odd.clone().not()]),
                Logic::All(vec![builder.free_bit(), odd.clone()]),
            ]),
        }
    }

    /// Whether a running timer has timed out. In the scan in which it starts it has not, unless its set value may be
    /// shorter than one scan.
    fn elapsed(&self, builder: &mut OmronBuilder, item: &Item<'_>, flag: Cell) -> Logic {
        let (Some(unit), Some(setting)) = (time_base(item), self.source) else {
            return self.has_elapsed(builder);
        };
        let runs = builder.memory.runs(flag);
        let over = builder.earlier_choice();
        if !builder.repeated {
            let on_delay = Expiry::of_on_delay(runs, setting, unit);
            let flag = Some(flag).filter(|_| item.meaning() == "timer");
            let expiry = Expiry { is_decimal: self.is_decimal, flag, ..on_delay };
            let timekeeping = &mut builder.out.program.timekeeping;
            timekeeping.expiries.insert(over, expiry);
            // A run tracks the time of a timer that restarts each time, not that of an accumulative timer.
            if item.meaning() == "timer" {
                timekeeping.untracked.remove(&over);
            }
        }
        let ticks = builder.out.scan_ticks(unit, self.is_decimal, false);
        let number = |word| Number::Words(vec![word]);
        let at_once = Logic::Compare(Box::new(Compare {
            relation: Relation::LessOrEqual,
            format: NumberFormat::Unsigned,
            left: number(setting),
            right: number(WordSource::Free(ticks)),
        }));
        let has_started = Logic::Any(vec![Logic::cell(runs), at_once, self.odd.clone()]);
        Logic::All(vec![self.has_elapsed_by(builder, over), has_started])
    }

    /// `value`; if the set value is not valid BCD, possibly the old value of `bit`.
    fn unless_wrong(&self, builder: &mut OmronBuilder, value: Logic, bit: Cell) -> Logic {
        match &self.wrong {
            Logic::Const(false) => value,
            wrong => {
                let kept = Logic::All(vec![Logic::cell(bit), wrong.clone(), builder.free_bit()]);
                Logic::Any(vec![value, kept])
            }
        }
    }

    fn note(&self, builder: &mut OmronBuilder) {
        if self.wrong != Logic::Const(false) {
            builder.approximate(
                "while the set value is not a valid BCD number, the completion flag may keep its value",
            );
        }
    }
}

/// Lowers a timer with one branch, or the instruction that resets timers.
pub(super) fn timer(builder: &mut OmronBuilder, item: &Item<'_>) {
    let key = builder.key(item, false);
    let choice = builder.choice();
    let mut effects: Vec<Effect> = Vec::new();
    let mut set = None;
    let reset = match item.meaning() {
        "reset-timers" => reset_range(&item.operands),
        _ => None,
    };
    match (item.meaning(), item.operands.first()) {
        ("timer", Some(Operand::Flag(flag))) => {
            let setting = setting(builder, item);
            // A timer can have timed out only while its condition is on.
            let done = Logic::All(vec![Logic::Condition, setting.elapsed(builder, item, *flag)]);
            let value = setting.unless_wrong(builder, done, *flag);
            effects.push(always(Write::Bit(BitTarget::Cell(*flag), value)));
            effects.push(always(havoc_present(*flag, choice)));
            let runs = builder.memory.runs(*flag);
            let value = setting.unless_wrong(builder, Logic::Condition, runs);
            effects.push(always(Write::Bit(BitTarget::Cell(runs), value)));
            set = Some(setting);
        }
        ("timer-unknown", Some(Operand::Flag(flag))) => {
            let value = builder.free_bit();
            effects.push(always(Write::Bit(BitTarget::Cell(*flag), value)));
            effects.push(always(havoc_present(*flag, choice)));
        }
        ("reset-timers", _) => {
            match &reset {
                Some(flags) => {
                    for &flag in flags {
                        let bit = |cell, value| fired(Write::Bit(BitTarget::Cell(cell), value));
                        effects.push(bit(flag, Logic::Const(false)));
                        effects.push(fired(havoc_present(flag, choice)));
                        // Whether a timer restarts while its condition stays on is unknown, and so is where an
                        // accumulative timer continues.
                        let value = builder.reading();
                        effects.push(bit(builder.memory.runs(flag), value));
                    }
                }
                None => effects.push(fired(Write::Havoc(Region::Everything, choice))),
            }
        }
        _ => {
            let writes = data::havoc(builder, item, choice);
            effects.extend(writes.into_iter().map(always));
        }
    }
    let flags = data::flags(builder, item);
    effects.extend(flags.into_iter().map(always));
    let fires = builder.fires(item.raw.edge);
    let at = builder.act(fires, effects, Some(key));
    builder.counter_resets.extend(reset.map(|flags| (at, flags)));
    if let ("timer", Some(Operand::Flag(flag))) = (item.meaning(), item.operands.first()) {
        note_timer(builder, item, at, *flag, (0, Vec::new()));
    }
    if let Some(setting) = set {
        setting.note(builder);
    }
    match item.meaning() {
        "timer-unknown" => builder.approximate("this timer's completion flag may be on or off"),
        "havoc-always" => builder.approximate("this timer's flags and values may have any value"),
        "timer" if !matches!(item.operands.first(), Some(Operand::Flag(_))) => {
            builder.approximate("the timer number is unknown: all timers may have any value");
        }
        _ => {}
    }
    data::note_indirect(builder, item);
}

/// The completion flags that a reset instruction resets: one timer, or all from the first to the last operand. `None`
/// if a timer number is unknown.
fn reset_range(operands: &[Operand]) -> Option<Vec<Cell>> {
    let (first, last) = match operands {
        [Operand::Flag(one)] => (one, one),
        [Operand::Flag(first), Operand::Flag(last)] => (first, last),
        _ => return None,
    };
    let in_order = first.area == last.area && first.index <= last.index;
    in_order.then(|| (0..=last.index - first.index).map(|n| first.plus(n)).collect())
}

/// Lowers KEEP, SFT, a counter or an accumulative timer, which have two or three branches. The last branch resets, and
/// has priority.
pub(super) fn branched(builder: &mut OmronBuilder, item: &Item<'_>) {
    let key = builder.key(item, true);
    let branches =
        if matches!(item.meaning(), "counter-reversible" | "shift-register") { 3 } else { 2 };
    let reset = branches - 1;
    builder.split(branches);
    // The instruction has one time, whichever branches are on.
    builder.always();
    let flags: Vec<Effect> = data::flags(builder, item).into_iter().map(always).collect();
    let whole = builder.act(Logic::Condition, flags, Some(key));
    let choice = builder.choice();
    let target = match item.operands.first() {
        Some(Operand::Flag(flag)) => Some(BitTarget::Cell(*flag)),
        Some(operand) => operand.bit_target(),
        None => None,
    };
    // The instruction stores its inputs after all other effects.
    let mut remembered: Option<Inputs> = None;
    match (item.meaning(), target, item.operands.first()) {
        ("keep", Some(target), _) => {
            builder.product(&[(0, true), (reset, false)]);
            builder.act(
                Logic::Condition,
                vec![fired(Write::Bit(target, Logic::Const(true)))],
                None,
            );
            builder.product(&[(reset, true)]);
            builder.act(
                Logic::Condition,
                vec![fired(Write::Bit(target, Logic::Const(false)))],
                None,
            );
        }
        ("timer-holding", Some(target), Some(Operand::Flag(flag))) => {
            // Without a reset the flag can only come on.
            let setting = setting(builder, item);
            let over = setting.elapsed(builder, item, *flag);
            let done = Logic::Any(vec![Logic::cell(*flag), over]);
            builder.product(&[(0, true), (reset, false)]);
            let runs = builder.memory.runs(*flag);
            let effects = vec![
                fired(Write::Bit(target, done)),
                fired(havoc_present(*flag, choice)),
                fired(Write::Bit(BitTarget::Cell(runs), Logic::Const(true))),
            ];
            builder.act(Logic::Condition, effects, None);
            reset_flag(builder, reset, *flag, &setting);
            let value = setting.unless_wrong(builder, Logic::Const(false), runs);
            let stops = fired(Write::Bit(BitTarget::Cell(runs), value));
            builder.act(Logic::Condition, vec![stops], None);
        }
        ("counter", Some(target), Some(Operand::Flag(flag))) => {
            // Without a reset the flag can only come on.
            let setting = setting(builder, item);
            let inputs = Inputs::of_counter(builder, *flag, &[0]);
            let done = Logic::Any(vec![Logic::cell(*flag), setting.has_elapsed(builder)]);
            builder.product(&[(0, true), (reset, false)]);
            let effects =
                vec![fired(Write::Bit(target, done)), fired(havoc_present(*flag, choice))];
            let counts = inputs.rises(builder, 0);
            builder.act(counts, effects, None);
            reset_flag(builder, reset, *flag, &setting);
            remembered = Some(inputs);
        }
        ("counter-reversible", Some(target), Some(Operand::Flag(flag))) => {
            let setting = setting(builder, item);
            let inputs = Inputs::of_counter(builder, *flag, &[0, 1]);
            // If both inputs rise, nothing is counted.
            for (counting, other, is_on) in
                [(0, 1, false), (0, 1, true), (1, 0, false), (1, 0, true)]
            {
                builder.product(&[(counting, true), (other, is_on), (reset, false)]);
                let value = setting.has_elapsed(builder);
                let choice = builder.choice();
                let effects =
                    vec![fired(Write::Bit(target, value)), fired(havoc_present(*flag, choice))];
                let rises = inputs.rises(builder, counting);
                let counts = match is_on {
                    true => Logic::All(vec![rises, inputs.rises(builder, other).not()]),
                    false => rises,
                };
                builder.act(counts, effects, None);
            }
            reset_flag(builder, reset, *flag, &setting);
            remembered = Some(inputs);
        }
        ("shift-register", ..) => {
            let inputs = Inputs::of(builder, &[1]);
            let moves = inputs.rises(builder, 1);
            shift_register(builder, item, moves, reset);
            remembered = Some(inputs);
        }
        _ => {
            let regions =
                item.operands.first().map(|operand| operand.regions(Some(1))).unwrap_or_default();
            let effects =
                regions.into_iter().map(|region| always(Write::Havoc(region, choice))).collect();
            builder.act(Logic::Condition, effects, None);
            builder.approximate(
                "the address that this instruction writes is unknown: every device that it may write may have any value",
            );
        }
    }
    if let ("counter" | "timer-holding" | "counter-reversible", Some(Operand::Flag(flag))) =
        (item.meaning(), item.operands.first())
    {
        let counting = remembered.iter().flat_map(|inputs| &inputs.0);
        let seen = counting.map(|&(_, memory)| memory).collect();
        note_timer(builder, item, whole, *flag, (branches, seen));
    }
    if let Some(inputs) = remembered {
        inputs.remember(builder, reset);
    }
}

/// The branches whose edges an instruction detects, each with its hidden bit. `None` if that bit is not modelled.
struct Inputs(Vec<(u32, Option<Cell>)>);

impl Inputs {
    fn of(builder: &mut OmronBuilder, branches: &[u32]) -> Inputs {
        Inputs(branches.iter().map(|&branch| (branch, builder.edge_memory())).collect())
    }

    /// The branches of an instruction that counts the counter with the completion flag `flag`. Records their hidden
    /// bits for this counter.
    fn of_counter(builder: &mut OmronBuilder, flag: Cell, branches: &[u32]) -> Inputs {
        let inputs = Inputs::of(builder, branches);
        let memories = inputs.0.iter().filter_map(|(_, memory)| *memory).collect();
        builder.counters.entry(flag).or_default().push(memories);
        inputs
    }

    /// Whether the condition is true, and this branch was off at the last execution. Used while the branch is on.
    fn rises(&self, builder: &mut OmronBuilder, branch: u32) -> Logic {
        let memory = self.0.iter().find_map(|(one, memory)| memory.filter(|_| *one == branch));
        let rises = match memory {
            Some(memory) => Logic::cell(memory).not(),
            None => builder.changed(),
        };
        Logic::All(vec![Logic::Condition, rises])
    }

    /// Adds the instructions that store the values of the branches in their hidden bits. Manuals do not say whether a
    /// branch that is on during a reset counts as seen, so its bit may then be on or off.
    fn remember(self, builder: &mut OmronBuilder, reset: u32) {
        for (branch, memory) in self.0 {
            let Some(memory) = memory.map(BitTarget::Cell) else { continue };
            builder.product(&[(branch, true), (reset, false)]);
            let seen = always(Write::Bit(memory, Logic::Condition));
            builder.act(Logic::Condition, vec![seen], None);
            builder.product(&[(branch, true), (reset, true)]);
            let perhaps_seen = fired(Write::Bit(memory, builder.reading()));
            builder.act(Logic::Condition, vec![perhaps_seen], None);
        }
    }
}

/// The time of one unit of a timer's set value. `None` if the instruction is not a timer or its time base is unknown.
fn time_base(item: &Item<'_>) -> Option<Picos> {
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

/// Records how the simulation runs the timer or counter that begins at instruction `at` of the program, if its set
/// value is a constant or a word. `branches` is the number of its conditions that were saved ([`OmronBuilder::split`]);
/// `seen` has the hidden bits of those that it counts.
fn note_timer(
    builder: &mut OmronBuilder,
    item: &Item<'_>,
    at: usize,
    flag: Cell,
    (branches, seen): (u32, Vec<Option<Cell>>),
) {
    let manner = match (item.meaning(), time_base(item)) {
        ("timer", Some(step)) => TimerKind::DownTimer(step),
        ("timer-holding", Some(step)) => TimerKind::RetentiveTimer(step),
        ("counter", _) => TimerKind::DownCounter,
        ("counter-reversible", _) => TimerKind::RingCounter,
        _ => return,
    };
    // With an indirect address, the set value is unknown.
    let plain = matches!(item.operands.get(1), Some(Operand::Constant(..) | Operand::Word(_)));
    let setting = if plain { data::sources(builder, item, 1, 1) } else { None };
    let Some(&[setting]) = setting.as_deref() else { return };
    let timed = TimerOrCounter {
        kind: manner,
        flag,
        present: present(flag),
        setting,
        is_decimal: !item.row.is_some_and(|row| row.mnemonic.ends_with('X')),
        inputs: (0..branches).map(|branch| BRANCHES + branch).collect(),
        seen,
        // A reset makes the present value unknown.
        running: None,
        parts: at + 1..builder.next(),
    };
    let keeping = &mut builder.out.program.timekeeping;
    keeping.note_consistency(timed.present, consistency(&timed));
    keeping.instructions.insert(at, timed);
}

/// A condition on the present value and the flag that is true after each execution, and before the first one. The word
/// with the set value may have changed since.
fn consistency(timed: &TimerOrCounter) -> Logic {
    let number = |word| Number::Words(vec![word]);
    let present = |relation, right| {
        let left = number(WordSource::Cell(timed.present));
        let (format, right) = (NumberFormat::Unsigned, number(right));
        Logic::Compare(Box::new(Compare { relation, format, left, right }))
    };
    let is_constant = matches!(timed.setting, WordSource::Const(_));
    let limit = if is_constant { timed.setting } else { WordSource::Const(u16::MAX) };
    let within = present(Relation::LessOrEqual, limit);
    let on = Logic::cell(timed.flag);
    match timed.kind {
        TimerKind::DownTimer(_) | TimerKind::DownCounter => {
            let is_over = present(Relation::Equal, WordSource::Const(0));
            Logic::All(vec![within, Logic::Any(vec![on.not(), is_over])])
        }
        TimerKind::UpTimer(..) | TimerKind::RetentiveTimer(_) | TimerKind::RingCounter => within,
    }
}

fn reset_flag(builder: &mut OmronBuilder, reset: u32, flag: Cell, setting: &Setting) {
    let choice = builder.choice();
    builder.product(&[(reset, true)]);
    let value = setting.unless_wrong(builder, Logic::Const(false), flag);
    let effects =
        vec![fired(Write::Bit(BitTarget::Cell(flag), value)), fired(havoc_present(flag, choice))];
    builder.act(Logic::Condition, effects, None);
    setting.note(builder);
}

/// Lowers SFT: on the rising edge of the second branch, all bits move one place up, and the first branch comes in.
fn shift_register(builder: &mut OmronBuilder, item: &Item<'_>, moves: Logic, reset: u32) {
    let words = match (item.operands.first(), item.operands.get(1)) {
        (Some(Operand::Word(first)), Some(Operand::Word(last)))
            if first.area == last.area
                && first.index <= last.index
                && last.index - first.index < extent::MAX_WORDS =>
        {
            Some((*first, last.index - first.index + 1))
        }
        _ => None,
    };
    builder.product(&[(1, true), (reset, false)]);
    let Some((first, count)) = words else {
        let choice = builder.choice();
        let effects = data::havoc(builder, item, choice).into_iter().map(always).collect();
        builder.act(moves, effects, None);
        builder
            .approximate("it is unknown which words this instruction shifts: every word that it may shift may have any value");
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
    builder.act(moves.clone(), effects, None);
    builder.product(&[(0, true), (1, true), (reset, false)]);
    builder.act(
        moves,
        vec![fired(Write::Bit(BitTarget::WordBit(first, 0), Logic::Const(true)))],
        None,
    );
    builder.product(&[(reset, true)]);
    let words = (0..count).map(|n| scanbound_ir::WordTarget::Cell(first.plus(n))).collect();
    let zeros =
        scanbound_ir::Number::Words(vec![scanbound_ir::WordSource::Const(0); count as usize]);
    builder.act(Logic::Condition, vec![fired(Write::Words(words, zeros))], None);
}
