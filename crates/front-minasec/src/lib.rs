//! MINASEC-U, a PLC of 74HC logic: eight instructions over 32 one-bit devices, 256 words, all run in each scan.
//!
//! Facts are from the machine's description, 「PLCのつくりかた」 (Minagi Yū, first edition, August 2025): the
//! encoding from its chapter on the instruction set, the devices from its table of element names and the
//! counter's circuit. Where that table swaps the words input and output for X and Y, the text, the terminals
//! and the machine code of the test program do not; they are followed here.

pub mod assembly;
pub mod decode;
pub mod machine_code;

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{
    Dialect, Front, Input, MachineOptions, Options, Project, Sniff, SourceOptions, decoded,
};
use scanbound_ir::Program;
use std::collections::BTreeMap;
use std::fmt;

/// How many words the program counter of eight bits reaches. Each scan runs all of them.
pub const WORDS: usize = 256;

/// Assembly.
pub const ASSEMBLY: &str = "minasec-asm";
/// Machine code as Intel HEX.
pub const HEX: &str = "minasec-hex";
/// Machine code as bytes.
pub const BINARY: &str = "minasec-bin";

/// The dialects, and how each is recognised.
static DIALECTS: [Dialect; 3] = [
    Dialect {
        name: ASSEMBLY,
        what: "MINASEC-U assembly (LD X00, ST Y00)",
        sniff: Sniff::Text(assembly::sniff),
    },
    Dialect {
        name: HEX,
        what: "MINASEC-U machine code as Intel HEX",
        sniff: Sniff::Text(machine_code::sniff_hex),
    },
    Dialect {
        name: BINARY,
        what: "MINASEC-U machine code, 256 bytes",
        sniff: Sniff::Bytes(machine_code::is_image),
    },
];

/// The MINASEC-U.
pub struct Minasec;

/// The registry's entry.
pub const FRONT: Minasec = Minasec;

impl Front for Minasec {
    fn dialects(&self) -> &'static [Dialect] {
        &DIALECTS
    }

    fn read(
        &self,
        dialect: &Dialect,
        programs: &[&Input],
        _beside: &[&Input],
        _reading: SourceOptions,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
        Ok(Box::new(read(dialect, programs)?))
    }
}

impl Project for Source {
    fn cpu(&self) -> Option<&str> {
        Some(decode::CPU)
    }

    fn machine_options(&self) -> MachineOptions {
        MachineOptions { clock: true, ..MachineOptions::default() }
    }

    fn decode(&self, _options: &Options<'_>) -> Result<Program, Vec<Diagnostic>> {
        Ok(decode::decode(self))
    }
}

/// What a word does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Opcode {
    /// The accumulator takes the device's value.
    Ld,
    /// The accumulator takes the inverse of the device's value.
    Ldi,
    /// The accumulator and the device's value.
    And,
    /// The accumulator and the inverse of the device's value.
    Andi,
    /// The accumulator or the device's value.
    Or,
    /// The accumulator or the inverse of the device's value.
    Ori,
    /// The device takes the accumulator's value; the accumulator keeps it.
    St,
    /// The device takes the inverse of the accumulator's value; the accumulator keeps its own.
    Sti,
}

impl Opcode {
    /// All, by their three bits.
    pub const ALL: [Opcode; 8] = [
        Opcode::Ld,
        Opcode::Ldi,
        Opcode::And,
        Opcode::Andi,
        Opcode::Or,
        Opcode::Ori,
        Opcode::St,
        Opcode::Sti,
    ];

    /// The mnemonic.
    #[must_use]
    pub fn mnemonic(self) -> &'static str {
        ["LD", "LDI", "AND", "ANDI", "OR", "ORI", "ST", "STI"][self as usize]
    }

    /// The opcode of a mnemonic, in capitals or not.
    #[must_use]
    pub fn from_mnemonic(text: &str) -> Option<Opcode> {
        Opcode::ALL.into_iter().find(|opcode| opcode.mnemonic().eq_ignore_ascii_case(text))
    }

    /// Whether it writes to its device.
    #[must_use]
    pub fn is_store(self) -> bool {
        matches!(self, Opcode::St | Opcode::Sti)
    }

    /// Whether it inverts what it reads or writes.
    #[must_use]
    pub fn inverts(self) -> bool {
        self as u8 & 1 == 1
    }
}

/// What kind of device an address selects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Input: the value latched when the scan began. Cannot be written.
    Input,
    /// Output: a latch of its own, shown outside from the end of the scan.
    Output,
    /// Internal relay.
    Relay,
    /// On-delay timer: written, its coil; read, its delayed contact.
    Timer,
    /// Counter: written, its clock; read, whether the count equals the setting.
    Counter,
    /// Written, the counter's clear; read, always 0.
    Clear,
}

/// The address of one of the 32 devices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Device(u8);

impl Device {
    /// The first timer.
    pub const T0: Device = Device(0b11100);
    /// The second timer.
    pub const T1: Device = Device(0b11101);
    /// The counter.
    pub const C0: Device = Device(0b11110);
    /// The counter's clear.
    pub const CLEAR: Device = Device(0b11111);

    /// The device of the low five bits.
    #[must_use]
    pub fn at(address: u8) -> Device {
        Device(address & 0b11111)
    }

    /// All devices, by address.
    pub fn all() -> impl Iterator<Item = Device> {
        (0..32).map(Device)
    }

    /// Its address, 0 to 31.
    #[must_use]
    pub fn address(self) -> u8 {
        self.0
    }

    /// What it is.
    #[must_use]
    pub fn kind(self) -> Kind {
        match self.0 {
            0..=7 => Kind::Input,
            8..=15 => Kind::Output,
            16..=27 => Kind::Relay,
            28..=29 => Kind::Timer,
            30 => Kind::Counter,
            _ => Kind::Clear,
        }
    }

    /// The device of a name: `X00` to `X07`, `Y00` to `Y07`, `M00` to `M07`, `M10` to `M13`, `T0`, `T1`, `C0`
    /// and the counter's clear `C0CLR`; timers and counter also with two digits (`T00`), as the description
    /// has them in places. In capitals or not.
    #[must_use]
    pub fn from_name(text: &str) -> Option<Device> {
        let name = text.to_ascii_uppercase();
        let name = match name.as_str() {
            "T00" => "T0",
            "T01" => "T1",
            "C00" => "C0",
            "C00CLR" => "C0CLR",
            name => name,
        };
        Device::all().find(|device| device.to_string() == name)
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low, high) = (self.0 & 7, self.0 >> 3);
        match (self.kind(), high) {
            (Kind::Input, _) => write!(f, "X0{low}"),
            (Kind::Output, _) => write!(f, "Y0{low}"),
            (Kind::Relay, 2) => write!(f, "M0{low}"),
            (Kind::Relay, _) => write!(f, "M1{low}"),
            (Kind::Timer, _) => write!(f, "T{}", self.0 & 1),
            (Kind::Counter, _) => f.write_str("C0"),
            (Kind::Clear, _) => f.write_str("C0CLR"),
        }
    }
}

/// One word of the program memory: the opcode in bits 7 to 5, the device's address in bits 4 to 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Word(pub u8);

impl Word {
    /// The word of an instruction.
    #[must_use]
    pub fn new(opcode: Opcode, device: Device) -> Word {
        Word((opcode as u8) << 5 | device.0)
    }

    /// What it does.
    #[must_use]
    pub fn opcode(self) -> Opcode {
        Opcode::ALL[usize::from(self.0 >> 5)]
    }

    /// With which device.
    #[must_use]
    pub fn device(self) -> Device {
        Device::at(self.0)
    }

    /// Whether it writes to an input, which has nothing to write to.
    #[must_use]
    pub fn stores_to_input(self) -> bool {
        self.opcode().is_store() && self.device().kind() == Kind::Input
    }
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.opcode().mnemonic(), self.device())
    }
}

/// A program as read from a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The file's name as the user gave it.
    pub name: String,
    /// The dialect's name.
    pub dialect: &'static str,
    /// The program memory. Words that the file does not give are 0, `LD X00`, as the description clears them.
    pub words: [Word; WORDS],
    /// The line of each word that the file gives, by address; for machine code without lines, the address + 1.
    pub lines: BTreeMap<u8, u32>,
}

impl Source {
    /// An empty program.
    #[must_use]
    pub fn new(name: &str, dialect: &'static str) -> Source {
        Source {
            name: name.to_owned(),
            dialect,
            words: [Word::default(); WORDS],
            lines: BTreeMap::new(),
        }
    }

    /// The memory's bytes.
    #[must_use]
    pub fn bytes(&self) -> [u8; WORDS] {
        self.words.map(|word| word.0)
    }

    /// How many words there are up to the last that is not empty.
    #[must_use]
    pub fn used(&self) -> usize {
        self.words.iter().rposition(|&word| word != Word::default()).map_or(0, |last| last + 1)
    }
}

/// Reads the program of the one file in it.
///
/// # Errors
/// The faults of the file, or of the files if there are more than one.
fn read(dialect: &Dialect, files: &[&Input]) -> Result<Source, Vec<Diagnostic>> {
    let Some((input, rest)) = files.split_first() else { return Err(Vec::new()) };
    if let Some(second) = rest.first() {
        return Err(vec![Diagnostic::file(
            Code::TwoPrograms,
            &second.name,
            format!("a MINASEC-U runs one program, and {} is one already", input.name),
            "give one file",
        )]);
    }
    match dialect.name {
        BINARY => machine_code::read_binary(&input.name, &input.bytes),
        HEX => {
            machine_code::read_hex(&input.name, &decoded(input, &[]).map_err(|fault| vec![fault])?)
        }
        _ => assembly::read(&input.name, &decoded(input, &[]).map_err(|fault| vec![fault])?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opcodes_are_those_of_the_description() {
        let table = ["LD", "LDI", "AND", "ANDI", "OR", "ORI", "ST", "STI"];
        for (bits, name) in table.into_iter().enumerate() {
            let word = Word((bits as u8) << 5);
            assert_eq!(word.opcode().mnemonic(), name);
            assert_eq!(Opcode::from_mnemonic(name), Some(word.opcode()));
        }
        // The one word that the description spells out in bits.
        assert_eq!(
            Word::new(Opcode::Or, Device::from_name("Y00").expect("a device")).0,
            0b100_01000
        );
    }

    #[test]
    fn devices_are_those_of_the_description() {
        let table = [
            ("X00", 0b00000, Kind::Input),
            ("X07", 0b00111, Kind::Input),
            ("Y00", 0b01000, Kind::Output),
            ("Y07", 0b01111, Kind::Output),
            ("M00", 0b10000, Kind::Relay),
            ("M07", 0b10111, Kind::Relay),
            ("M10", 0b11000, Kind::Relay),
            ("M13", 0b11011, Kind::Relay),
            ("T0", 0b11100, Kind::Timer),
            ("T1", 0b11101, Kind::Timer),
            ("C0", 0b11110, Kind::Counter),
            ("C0CLR", 0b11111, Kind::Clear),
        ];
        for (name, address, kind) in table {
            let device = Device::from_name(name).expect(name);
            assert_eq!((device.address(), device.kind()), (address, kind), "{name}");
            assert_eq!(Device::from_name(&name.to_lowercase()), Some(device));
        }
        for device in Device::all() {
            assert_eq!(Device::from_name(&device.to_string()), Some(device));
        }
        for name in ["X08", "X0", "X10", "Y08", "M08", "M14", "M20", "T2", "C1", "D0", "", "X"] {
            assert_eq!(Device::from_name(name), None, "{name}");
        }
    }

    fn found(bytes: &[u8]) -> Result<&'static str, &'static str> {
        let input = Input { name: "a".to_owned(), bytes: bytes.to_vec() };
        match scanbound_fronts::detect(&input) {
            Ok(scanbound_front::FileKind::Program(dialect)) => Ok(dialect.name),
            Ok(scanbound_front::FileKind::Comments) => Err("comments"),
            Err(fault) => Err(fault.code.name()),
        }
    }

    #[test]
    fn files_are_told_by_their_content() {
        assert_eq!(found(b"LD X00\nOR Y00\nANDI X01\nST Y00\n"), Ok(ASSEMBLY));
        assert_eq!(found(b"0 LD X00\n1 ST Y00 ; lamp\n"), Ok(ASSEMBLY));
        assert_eq!(found(b"LD X00\nOUT Y00\nEND\n"), Ok("melsec-list"));
        assert_eq!(found(b":00000001FF\n"), Ok(HEX));
        assert_eq!(found(&[0; WORDS]), Ok(BINARY));
        assert_eq!(found(&[0; WORDS - 1]), Err("binary-file"));
        assert_eq!(found(b"LD X00\nAND X01\n"), Err("two-dialects"), "no store, no coil");
    }

    #[test]
    fn a_named_dialect_takes_a_shorter_image() {
        let input = |bytes: &[u8]| [Input { name: "a".to_owned(), bytes: bytes.to_vec() }];
        let fronts = scanbound_front::Fronts(&[&FRONT]);
        let read =
            |bytes: &[u8]| fronts.read(&input(bytes), Some(BINARY), SourceOptions::default());
        let source: Source = read(&[0x01, 0xC8]).expect("an image").downcast().expect("its own");
        assert_eq!(source.words[1].to_string(), "ST Y00");
        assert!(read(&[]).is_err());
    }

    #[test]
    fn words_take_apart_as_they_are_put_together() {
        for byte in 0..=255 {
            let word = Word(byte);
            assert_eq!(Word::new(word.opcode(), word.device()), word);
        }
    }
}
