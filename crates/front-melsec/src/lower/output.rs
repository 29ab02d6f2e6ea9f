//! Lowers coils: OUT on bits, timers and counters, SET, RST, PLS, PLF, FF.

use super::access::BitPlace;
use super::rungs::{letters, remember};
use super::state::{Lowering, edge, timing};
use crate::memory::{DeviceType, Family, Timed, area};
use crate::operand::{Device, Operand, Place};
use crate::source::RawInstruction;
use scanbound_base::time::Picos;
use scanbound_front::builder::{always, fired};
use scanbound_ir::meaning;
use scanbound_ir::timers::TimerKind;
use scanbound_ir::{
    BitSource, BitTarget, Cell, Compare, Effect, Logic, Number, NumberFormat, Region, Relation,
    Step, TimingKey, Units, When, WordSource, WordTarget, Write,
};

impl Lowering<'_> {
    pub(super) fn coil(&mut self, mnemonic: &str, raw: &RawInstruction) {
        match mnemonic {
            "OUT" | "OUTH" => self.out(mnemonic, raw),
            "SET" | "RST" => self.set(mnemonic, raw),
            _ => self.pulse(mnemonic, raw),
        }
    }

    /// The effects of writing `value` to the bit operand `text`: in every execution if `is_always`, otherwise when the
    /// instruction fires. If it is unknown which bit the operand is, the effect is a havoc of the region in which it
    /// is. `None` after an error that was reported.
    pub(super) fn bit_effects(
        &mut self,
        text: &str,
        value: Logic,
        is_always: bool,
    ) -> Option<Vec<Effect>> {
        let when = if is_always { When::Always } else { When::Fired };
        let write = match self.bit_place(text)? {
            BitPlace::One(target) => Write::Bit(target, value),
            BitPlace::Somewhere(region) => {
                let choice = self.indexed_write(text, meaning::OperationInput::Truth(value), 1);
                Write::Havoc(region, choice)
            }
            BitPlace::Nowhere => return Some(Vec::new()),
        };
        Some(vec![Effect { when, write }])
    }

    fn out(&mut self, mnemonic: &str, raw: &RawInstruction) {
        self.output_here(mnemonic);
        let variant = letters(raw.operands.first());
        let is_timed = matches!(&*variant, "T" | "ST" | "SS" | "C" | "LT" | "LST" | "LC");
        if !self.takes(raw, if is_timed { 2 } else { 1 }) {
            return;
        }
        let target = &raw.operands[0];
        let mut times = None;
        let effects = if is_timed {
            let Some(device) = self.device(target) else { return };
            let is_long =
                variant.starts_with('L') || (self.family == Family::Fx && is_long_counter(&device));
            let words = if is_long { 2 } else { 1 };
            let Some(setting) = self.read_words(&raw.operands[1], words) else { return };
            let setting = Some(setting[0]).filter(|_| !is_long);
            times = setting;
            self.timed_effects(target, &device, setting, mnemonic)
        } else {
            let value = match self.parsed(target) {
                // In a step ladder, OUT activates another state, as SET does. Whether it can also clear that state is
                // unknown.
                Ok(Operand::Device(device)) if self.state.is_some() && device.name == "S" => {
                    let (Some(now), free) = (self.read_bit(target), self.free_bit()) else {
                        return;
                    };
                    let moves = self.may_move_on(Logic::Condition);
                    Logic::Any(vec![moves, Logic::All(vec![now, free])])
                }
                _ => Logic::Condition,
            };
            let Some(effects) = self.bit_effects(target, value, true) else { return };
            effects
        };
        self.state_transfer(target);
        let class = match &*variant {
            "T" | "ST" | "SS" | "LT" | "LST" => "timer",
            "C" | "LC" => "counter",
            _ => "coil",
        };
        let mut key = timing(mnemonic, false, Some(&variant), class, Units::None, false);
        self.add_special_row(&mut key, target);
        let at = self.out.next();
        self.add(Some(key), effects, Step::Act { fires: Logic::Condition });
        if is_timed {
            self.note_timer(mnemonic, &raw.operands[0], times, at);
        }
    }

    /// Records how the simulation counts the timer at instruction `at`, if the set value has one word and the timer
    /// does not count in interrupts. Counters need no record: they count executions.
    fn note_timer(&mut self, mnemonic: &str, text: &str, setting: Option<WordSource>, at: usize) {
        let (Some(device), Some(setting)) = (self.device(text), setting) else { return };
        let Place::At(DeviceType::Timed(timed), index) = device.place else { return };
        if !matches!(device.name, "T" | "ST") || self.runs_in_interrupts(&device) {
            return;
        }
        let step = self.time_base(mnemonic, index);
        let cell = |area| Cell { area, index };
        let keeps = scanbound_ir::timers::TimerOrCounter {
            kind: TimerKind::UpTimer(step, timed.retentive),
            flag: cell(timed.contact),
            present: cell(timed.value),
            setting,
            is_decimal: false,
            inputs: Vec::new(),
            seen: Vec::new(),
            running: Some(cell(timed.coil)),
            parts: at + 1..at + 1,
        };
        let timekeeping = &mut self.out.program.timekeeping;
        timekeeping.scratch.insert(const { area("stood at ") });
        timekeeping.instructions.insert(at, keeps);
    }

    /// The time of one count of a timer, in ps, with the default parameters of the CPU.
    fn time_base(&self, mnemonic: &str, index: u32) -> Picos {
        const MS: u64 = 1_000_000_000;
        Picos(match (self.family, mnemonic) {
            (Family::Fx, _) if index >= 200 => 10 * MS,
            (_, "OUTH") => 10 * MS,
            _ => 100 * MS,
        })
    }

    /// For special relays of the FX (`M8000` and above), which take longer than ordinary relays: adds the name of their
    /// timing table row (`OUT:special`), which is tried first.
    fn add_special_row(&self, key: &mut TimingKey, text: &str) {
        let number = text.strip_prefix(['M', 'm']).and_then(|digits| digits.parse::<u32>().ok());
        if self.family == Family::Fx && number.is_some_and(|number| number >= 8000) {
            let name = key.names.last().map_or("", String::as_str);
            key.names.insert(0, format!("{name}:special"));
        }
    }

    /// The effects of OUT on a timer or counter. The contact can come on only while the coil is on; a retentive one
    /// keeps its contact and present value while the coil is off. `setting` is the set value, `None` if it is a double
    /// word.
    fn timed_effects(
        &mut self,
        text: &str,
        device: &Device,
        setting: Option<WordSource>,
        mnemonic: &str,
    ) -> Vec<Effect> {
        let (timed, index) = match device.place {
            Place::At(DeviceType::Timed(timed), index) => (timed, index),
            Place::Indexed(DeviceType::Timed(timed), _) => {
                self.approximate(format!(
                    "it is unknown which device {text} is: any {} may have changed",
                    device.name
                ));
                let choice = self.choice();
                let havoc = |area| always(Write::Havoc(Region::Area(area), choice));
                return timed.areas().map(havoc).collect();
            }
            _ => return Vec::new(),
        };
        let cell = |area| Cell { area, index };
        let (contact, value) = (cell(timed.contact), cell(timed.value));
        let is_counter = device.name == "C";
        let ran = timed.ran(index);
        let setting = setting.filter(|_| !self.runs_in_interrupts(device));
        let (through, now) = match setting {
            Some(setting) if is_counter => {
                self.counted([timed.contact, timed.coil, timed.value].map(cell), setting)
            }
            Some(setting) => {
                let unit = self.time_base(mnemonic, index);
                self.elapsed((ran, contact, value), setting, unit)
            }
            None => (self.choice(), self.choice()),
        };
        let mut done = vec![Logic::Condition, Logic::Bit(BitSource::Free(through))];
        if let Some(setting) = setting.filter(|_| !is_counter) {
            let present_before = self.previous_present(value);
            let unit = self.time_base(mnemonic, index);
            done.push(self.has_started((contact, ran), present_before, setting, unit));
        }
        if let Some(setting @ WordSource::Const(1..=0x7FFF)) = setting {
            let over = is_at_least(value, setting);
            let on = Logic::cell(contact);
            let holds = Logic::Any(vec![
                Logic::All(vec![on.clone(), over.clone()]),
                Logic::All(vec![on.not(), over.not()]),
            ]);
            self.out.program.timekeeping.note_consistency(value, holds);
        }
        let done = Logic::All(done);
        let coil = always(Write::Bit(BitTarget::Cell(cell(timed.coil)), Logic::Condition));
        let mut effects = Vec::new();
        if setting.is_some() && !is_counter {
            let now = Number::Words(vec![WordSource::Cell(value)]);
            effects.push(always(Write::Words(
                vec![WordTarget::Cell(self.previous_present(value))],
                now,
            )));
        }
        let present =
            Write::Words(vec![WordTarget::Cell(value)], Number::Words(vec![WordSource::Free(now)]));
        if timed.retentive {
            // A counter that has counted up stays so until it is reset. Only up-down counters can go back.
            let old = Logic::cell(contact);
            let falls_back = self.family == Family::Fx && device.name == "C" && index >= 200;
            let held = if falls_back { Logic::All(vec![Logic::Condition.not(), old]) } else { old };
            effects
                .push(always(Write::Bit(BitTarget::Cell(contact), Logic::Any(vec![done, held]))));
        } else {
            effects.push(always(Write::Bit(BitTarget::Cell(contact), done)));
            effects.push(always(Write::Words(vec![WordTarget::Cell(value)], zero())));
        }
        if let Some(ran) = ran {
            effects.push(always(Write::Bit(BitTarget::Cell(ran), Logic::Condition)));
        }
        effects.push(fired(present));
        // The counter counts rising edges of its coil, so the coil is written last.
        effects.push(coil);
        effects
    }

    /// The condition under which a timer whose coil is on can have reached its set value: its coil was also on when it
    /// was last executed, or the set value is not longer than one scan. For a retentive timer (without `ran`), a
    /// present value other than 0 takes the place of the coil.
    fn has_started(
        &mut self,
        (contact, ran): (Cell, Option<Cell>),
        present_before: Cell,
        setting: WordSource,
        unit: Picos,
    ) -> Logic {
        let compared = |relation, left, right| {
            let [left, right] = [left, right].map(|word| Number::Words(vec![word]));
            Logic::Compare(Box::new(Compare {
                relation,
                format: NumberFormat::Signed,
                left,
                right,
            }))
        };
        let is_reset = self.modes.may_reset(contact);
        let ticks = WordSource::Free(self.out.scan_ticks(unit, false, is_reset));
        let mut at_once = compared(Relation::LessOrEqual, setting, ticks);
        if is_reset {
            // Whether a timer goes on that was reset while its coil was on is unknown.
            at_once = Logic::All(vec![at_once, self.reading()]);
        }
        let stands = WordSource::Cell(present_before);
        let ran = match ran {
            Some(ran) => Logic::cell(ran),
            None => compared(Relation::NotEqual, stands, WordSource::Const(0)),
        };
        Logic::Any(vec![ran, at_once])
    }

    /// A new bit with any value, for a point that the manuals leave open: it says which of two readings is right.
    fn reading(&mut self) -> Logic {
        let choice = self.choice();
        self.out.program.timekeeping.readings.insert(choice);
        Logic::Bit(BitSource::Free(choice))
    }

    /// The hidden word that keeps the present value, which is in the cell `value`, as it was before the current
    /// instruction.
    pub(super) fn previous_present(&self, value: Cell) -> Cell {
        Cell { area: const { area("stood at ") }, index: value.index }
    }

    /// The effects of an instruction that resets a timer or counter when it fires.
    pub(super) fn reset(&mut self, timed: Timed, index: u32) -> Vec<Effect> {
        let bit =
            |area| fired(Write::Bit(BitTarget::Cell(Cell { area, index }), Logic::Const(false)));
        let ran = timed.ran(index).map(|ran| bit(ran.area));
        // Whether the counter counts again while its input stays on after the reset is unknown.
        let coil = BitTarget::Cell(Cell { area: timed.coil, index });
        let coil_stays = Logic::All(vec![Logic::Bit(coil.source()), self.reading()]);
        let value = WordTarget::Cell(Cell { area: timed.value, index });
        let reset = [
            bit(timed.contact),
            fired(Write::Bit(coil, coil_stays)),
            fired(Write::Words(vec![value], zero())),
        ];
        reset.into_iter().chain(ran).collect()
    }

    fn set(&mut self, mnemonic: &str, raw: &RawInstruction) {
        self.output_here(mnemonic);
        if !self.takes(raw, 1) {
            return;
        }
        let text = &raw.operands[0];
        let Some(device) = self.device(text) else { return };
        let effects = match device.place {
            Place::At(DeviceType::Timed(timed), index) if mnemonic == "RST" => {
                self.reset(timed, index)
            }
            Place::Indexed(DeviceType::Timed(timed), false) if mnemonic == "RST" => {
                self.approximate(format!(
                    "it is unknown which device {text} is: any {} may have been reset",
                    device.name
                ));
                let choice = self.choice();
                let havoc = |area| fired(Write::Havoc(Region::Area(area), choice));
                timed.areas().map(havoc).collect()
            }
            Place::At(DeviceType::Word(_) | DeviceType::VolatileWord, _)
            | Place::Indexed(DeviceType::Word(_) | DeviceType::VolatileWord, false)
            | Place::Indirect
            | Place::Foreign(false)
                if mnemonic == "RST" =>
            {
                match self.write_number(text, 1, zero()) {
                    Some(effects) => effects,
                    None => return,
                }
            }
            _ if mnemonic == "SET" && self.state.is_some() && device.name == "S" => {
                let Some(now) = self.read_bit(text) else { return };
                let moves = self.may_move_on(Logic::Const(true));
                let value = Logic::Any(vec![now, moves]);
                match self.bit_effects(text, value, false) {
                    Some(effects) => effects,
                    None => return,
                }
            }
            _ => match self.bit_effects(text, Logic::Const(mnemonic == "SET"), false) {
                Some(effects) => effects,
                None => return,
            },
        };
        if mnemonic == "SET" {
            self.state_transfer(text);
        }
        let mut key = timing(
            mnemonic,
            false,
            Some(&letters(raw.operands.first())),
            "set",
            Units::None,
            false,
        );
        self.add_special_row(&mut key, text);
        self.add(Some(key), effects, Step::Act { fires: Logic::Condition });
    }

    fn pulse(&mut self, mnemonic: &str, raw: &RawInstruction) {
        self.output_here(mnemonic);
        if !self.takes(raw, 1) {
            return;
        }
        let text = &raw.operands[0];
        let memory = self.edge_memory(false);
        let fires = edge(mnemonic != "PLF", Logic::Condition, memory);
        let effects = if mnemonic == "FF" {
            let Some(now) = self.read_bit(text) else { return };
            self.bit_effects(text, now.not(), false)
        } else {
            self.bit_effects(text, fires.clone(), true)
        };
        let Some(mut effects) = effects else { return };
        effects.push(remember(memory, Logic::Condition));
        let key = timing(
            mnemonic,
            false,
            Some(&letters(raw.operands.first())),
            "pulse",
            Units::None,
            false,
        );
        self.add(Some(key), effects, Step::Act { fires });
    }

    /// The condition of a state transition. If M8040 or IST may inhibit the transition, a free bit is part of it.
    fn may_move_on(&mut self, moves: Logic) -> Logic {
        if !self.modes.states_may_stay {
            return moves;
        }
        self.approximate(
            "M8040 or IST may inhibit state transitions: the bound covers both cases, with and without this transition",
        );
        Logic::All(vec![moves, self.free_bit()])
    }

    /// If `text` begins with `S`, as a step relay does, and a step ladder state is open: records that setting it resets
    /// the relays of the open state at an unknown moment, so that they may have any value at each read from now on.
    fn state_transfer(&mut self, text: &str) {
        let is_state = text.trim().to_ascii_uppercase().starts_with('S');
        let Some(state) = self.state.as_ref().filter(|_| is_state) else { return };
        let one = |&first: &Cell| Region::Range { first, count: 1 };
        self.out.program.volatile.extend(state.relays.iter().map(one));
        self.approximate(format!(
            "when this instruction sets {text}, the state that was active may be reset at once, or later in the scan"
        ));
    }
}

/// The condition that a word is at least the set value, as signed numbers.
fn is_at_least(word: Cell, setting: WordSource) -> Logic {
    let [left, right] = [WordSource::Cell(word), setting].map(|word| Number::Words(vec![word]));
    let relation = Relation::GreaterOrEqual;
    Logic::Compare(Box::new(Compare { relation, format: NumberFormat::Signed, left, right }))
}

/// Whether this is a 32-bit counter of the FX (C200 and above).
fn is_long_counter(device: &Device) -> bool {
    device.name == "C" && matches!(device.place, Place::At(_, 200..))
}

/// The number zero, as one word.
fn zero() -> Number {
    Number::Words(vec![WordSource::Const(0)])
}
