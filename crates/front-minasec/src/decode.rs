//! Lowers the 256 words of a MINASEC-U program.
//!
//! The accumulator is the top of the logic stack. It keeps its value from the last scan in a cell of its own; if the
//! first word needs it, an added instruction without a time reads this cell before that word.

use super::source::Source;
use super::word::{DeviceKind, Opcode, WORDS, Word};
use scanbound_base::location::Location;
use scanbound_ir::{
    AccessedDevices, Area, AreaId, AreaKind, BitSource, BitTarget, Cell, ChoiceId, ChoiceKind,
    Device, Effect, Instruction, Join, Logic, Operand, Program, Radix, Role, SourceFile, Step,
    TimingKey, Units, When, Write,
};
use std::sync::Arc;

/// The name of the only CPU.
pub(super) const CPU: &str = "MINASEC-U";
/// The areas. Their names and indices together give the PLC's device names: `X0` and 3 make X03.
const AREAS: [(&str, Role); 7] = [
    ("X0", Role::Input),
    ("Y0", Role::Output),
    ("M0", Role::Memory),
    ("M1", Role::Memory),
    ("T", Role::Memory),
    ("C", Role::Memory),
    ("ACC", Role::Memory),
];
/// The index of the area of the timers.
const TIMERS: u16 = 4;
/// The index of the area of the counter.
const COUNTER: u16 = 5;
/// The index of the area of the accumulator.
const ACCUMULATOR: u16 = 6;

/// Lowers a source. Each scan executes all 256 words, also those that are not in the file.
#[must_use]
pub fn decode(source: &Source) -> Program {
    let mut program = Program {
        dialect: source.dialect.to_owned(),
        cpu: Some(CPU.to_owned()),
        words_per_scan: Some(WORDS as u64),
        areas: AREAS
            .map(|(name, role)| Area { role, ..Area::new(name, AreaKind::Bit, Radix::Decimal) })
            .into(),
        ..Program::default()
    };
    if !matches!(source.words[0].opcode(), Opcode::Ld | Opcode::Ldi) {
        program.blocks = 1;
        program.instructions.push(Instruction {
            place: place(source, 0),
            block: 1,
            text: "ACC".into(),
            operands: Arc::default(),
            timing: None,
            effects: Vec::new(),
            step: Step::Logic {
                join: Join::Start,
                value: Logic::cell(Cell { area: AreaId(ACCUMULATOR), index: 0 }),
            },
        });
    }
    let used = source.used();
    let mut stored = true;
    for (address, &word) in source.words.iter().enumerate() {
        let starts = matches!(word.opcode(), Opcode::Ld | Opcode::Ldi);
        // A rung ends with its stores; the unused words at the end are one more rung.
        if (stored && starts && address <= used) || program.blocks == 0 {
            program.blocks += 1;
        }
        stored = word.opcode().is_store() || address + 1 == used;
        let mut instruction = instruction(source, address, word, &mut program);
        if address >= used {
            // The machine executes all words; this one is not in the file.
            instruction.text = format!("unused word ({word})").into();
        }
        program.instructions.push(instruction);
    }
    let all = 0..program.instructions.len();
    program.mains = vec![all.clone()];
    program.files = vec![SourceFile { name: source.name.clone(), instructions: all, count: WORDS }];
    program
}

/// The position of a word: its address as step number, and its source line or that of the last word before it that has
/// one.
fn place(source: &Source, address: usize) -> Location {
    let line = source.lines.range(..=address as u8).next_back().map_or(1, |(_, &line)| line);
    Location { file: 0, line, step: Some(address as u32) }
}

fn instruction(source: &Source, address: usize, word: Word, program: &mut Program) -> Instruction {
    let opcode = word.opcode();
    let (effects, step) = if opcode.is_store() {
        let value = if opcode.inverts() { Logic::Condition.not() } else { Logic::Condition };
        (store(word, value.clone()), Step::Act { fires: value })
    } else {
        let value = read(word, program);
        let value = if opcode.inverts() { value.not() } else { value };
        let join = match opcode {
            Opcode::And | Opcode::Andi => Join::And,
            Opcode::Or | Opcode::Ori => Join::Or,
            _ => Join::Start,
        };
        (Vec::new(), Step::Logic { join, value })
    };
    Instruction {
        place: place(source, address),
        block: program.blocks,
        text: word.to_string().into(),
        operands: operand(word).into_iter().collect(),
        timing: Some(Box::new(TimingKey {
            names: vec![opcode.mnemonic().to_owned()],
            class: if opcode.is_store() { "coil" } else { "contact" },
            units: Units::None,
            use_larger_time: false,
            optional: false,
            accessed: AccessedDevices::default(),
        })),
        effects,
        step,
    }
}

/// The device of a word, as the operand in the instruction's text. `None` for the counter's clear input.
fn operand(word: Word) -> Option<Operand> {
    let device = Device { cell: cell(word)?, bit: None };
    let start = word.opcode().mnemonic().len() + 1;
    Some(Operand { start: start as u32, end: word.to_string().len() as u32, device })
}

/// The cell that holds the device's value. `None` for the counter's clear input, which holds no value.
fn cell(word: Word) -> Option<Cell> {
    let (high, low) = (word.device().address() >> 3, u32::from(word.device().address() & 7));
    match word.device().kind() {
        DeviceKind::Input | DeviceKind::Output | DeviceKind::Relay => {
            Some(Cell { area: AreaId(u16::from(high)), index: low })
        }
        DeviceKind::Timer => Some(Cell { area: AreaId(TIMERS), index: low & 1 }),
        DeviceKind::Counter => Some(Cell { area: AreaId(COUNTER), index: 0 }),
        DeviceKind::Clear => None,
    }
}

/// The expression for the value that a word reads from its device. Whether a timer has timed out, and whether the count
/// is reached, is a new external choice, recorded as an over-approximation.
fn read(word: Word, program: &mut Program) -> Logic {
    let mut free = |what: String| {
        let choice = ChoiceId(program.choices);
        program.choices += 1;
        program.kinds.insert(choice, ChoiceKind::External);
        program.approximate(program.instructions.len(), what);
        Logic::Bit(BitSource::Free(choice))
    };
    let device = word.device();
    match (device.kind(), cell(word)) {
        // The delay is independent of the scan: the contact may close at any time while the coil is on.
        (DeviceKind::Timer, Some(coil)) => {
            let elapsed =
                free(format!("{device} may or may not have timed out while its coil is on"));
            Logic::All(vec![Logic::cell(coil), elapsed])
        }
        // The count remains from earlier scans, and a button on the board clears it at any time.
        (DeviceKind::Counter, _) => {
            free(format!("the count of {device} may or may not equal its set value"))
        }
        (DeviceKind::Clear, _) | (_, None) => Logic::Const(false),
        (_, Some(cell)) => Logic::cell(cell),
    }
}

/// The effects of a store. A store to the counter's clear input has none: it only changes the count, which is not
/// modelled.
fn store(word: Word, value: Logic) -> Vec<Effect> {
    match word.device().kind() {
        DeviceKind::Input | DeviceKind::Clear => Vec::new(),
        DeviceKind::Output | DeviceKind::Relay | DeviceKind::Timer | DeviceKind::Counter => {
            cell(word)
                .map(|cell| Effect {
                    when: When::Always,
                    write: Write::Bit(BitTarget::Cell(cell), value),
                })
                .into_iter()
                .collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{assembly, machine_code};
    use scanbound_base::time::{Picos, Times};
    use scanbound_replay::replay;

    fn program(text: &str) -> Program {
        decode(&assembly::read("a.asm", text).expect("a program"))
    }

    #[test]
    fn all_words_are_run_and_the_empty_ones_are_a_rung_of_their_own() {
        let program = program("LD X00\nOR Y00\nST Y00\nLDI Y00\nST M10\nST M11\n");
        assert_eq!(program.instructions.len(), WORDS);
        assert_eq!(program.blocks, 3);
        let blocks: Vec<u32> = program.instructions.iter().take(8).map(|i| i.block).collect();
        assert_eq!(blocks, [1, 1, 1, 2, 2, 2, 3, 3]);
        assert_eq!(&*program.instructions[255].text, "unused word (LD X00)");
        assert_eq!(program.instructions[255].block, 3);
    }

    #[test]
    fn cells_are_named_as_the_devices_are() {
        for byte in 0..32_u8 {
            let word = Word(byte);
            if let Some(cell) = cell(word) {
                let program = program("LD X00");
                assert_eq!(program.cell_name(cell), word.device().to_string());
            }
        }
    }

    #[test]
    fn a_scan_costs_all_its_words_whatever_the_program() {
        let times = |n| vec![Times::new(Picos(33_000_000), Picos(33_000_000)); n];
        for text in ["LD X00", "ST Y00", "AND M00\nSTI Y01\nLD T0\nAND C0\nOR C0CLR\nST C0CLR"] {
            let program = program(text);
            let times: Vec<_> = times(program.instructions.len())
                .into_iter()
                .zip(&program.instructions)
                .map(|(time, one)| if one.timing.is_some() { time } else { Default::default() })
                .collect();
            let scan = replay(&program, &times, &Default::default());
            assert_eq!(scan.total, Picos(8_448_000_000), "{text}");
        }
    }

    #[test]
    fn a_scan_that_does_not_begin_with_a_load_begins_with_the_accumulator_as_it_was() {
        let program = program("ST Y00");
        assert_eq!(program.instructions.len(), WORDS + 1);
        assert!(program.instructions[0].timing.is_none());
        assert_eq!(program.files[0].count, WORDS);
    }

    #[test]
    fn whole_memories_of_machine_code_are_decoded() {
        let mut bytes = [0; WORDS];
        for (at, byte) in bytes.iter_mut().enumerate() {
            *byte = if Word(at as u8).stores_to_input() { 0 } else { at as u8 };
        }
        let program = decode(&machine_code::read_binary("a.bin", &bytes).expect("an image"));
        assert_eq!(program.instructions.len(), WORDS);
        assert!(scanbound_scan::scan_model(&program, &vec![Default::default(); WORDS]).is_ok());
    }
}
