//! The machine's words: what each of its eight instructions does, and its 32 devices.

use std::fmt;

/// The number of words that the eight-bit program counter can address. Each scan executes all of them.
pub const WORDS: usize = 256;

/// What a program word does with its device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Opcode {
    /// Loads the device's value into the accumulator.
    Ld,
    /// Loads the inverted value of the device into the accumulator.
    Ldi,
    /// ANDs the device's value to the accumulator.
    And,
    /// ANDs the inverted value of the device to the accumulator.
    Andi,
    /// ORs the device's value to the accumulator.
    Or,
    /// ORs the inverted value of the device to the accumulator.
    Ori,
    /// Stores the accumulator in the device.
    St,
    /// Stores the inverse of the accumulator's value in the device; the accumulator keeps its value.
    Sti,
}

impl Opcode {
    /// All opcodes in the order of their three bits.
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

    /// The opcode of a mnemonic, in upper or lower case. `None` if the text is not a mnemonic.
    #[must_use]
    pub fn from_mnemonic(text: &str) -> Option<Opcode> {
        Opcode::ALL.into_iter().find(|opcode| opcode.mnemonic().eq_ignore_ascii_case(text))
    }

    /// Whether the operation writes to its device: ST or STI.
    #[must_use]
    pub fn is_store(self) -> bool {
        matches!(self, Opcode::St | Opcode::Sti)
    }

    /// Whether the operation inverts the value that it reads or writes: LDI, ANDI, ORI or STI.
    #[must_use]
    pub fn inverts(self) -> bool {
        self as u8 & 1 == 1
    }
}

/// What a device is: an input, an output, a relay, a timer, the counter or its clear input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DeviceKind {
    /// Input: the value latched at the start of the scan. It cannot be written.
    Input,
    /// An output: a latch, whose value appears at the terminal at the end of the scan.
    Output,
    /// An internal relay, which is not connected to a terminal.
    Relay,
    /// On-delay timer: a write sets its coil, a read gives its delayed contact.
    Timer,
    /// A counter: a write sets its clock, a read tells whether its count equals the set value.
    Counter,
    /// Clear input of the counter: it can be written, and always reads 0.
    Clear,
}

/// The address of one of the 32 devices, 0 to 31.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Device(u8);

impl Device {
    /// The first timer.
    pub const T0: Device = Device(0b11100);
    /// The second timer.
    pub const T1: Device = Device(0b11101);
    /// The counter.
    pub const C0: Device = Device(0b11110);
    /// The clear input of the counter.
    pub const CLEAR: Device = Device(0b11111);

    /// The device with this address; only the low five bits of `address` matter.
    #[must_use]
    pub fn at(address: u8) -> Device {
        Device(address & 0b11111)
    }

    /// All devices in the order of their addresses.
    pub fn all() -> impl Iterator<Item = Device> {
        (0..32).map(Device)
    }

    /// The address of the device, 0 to 31.
    #[must_use]
    pub fn address(self) -> u8 {
        self.0
    }

    /// What the device is.
    #[must_use]
    pub fn kind(self) -> DeviceKind {
        match self.0 {
            0..=7 => DeviceKind::Input,
            8..=15 => DeviceKind::Output,
            16..=27 => DeviceKind::Relay,
            28..=29 => DeviceKind::Timer,
            30 => DeviceKind::Counter,
            _ => DeviceKind::Clear,
        }
    }

    /// Parses a device name, in upper or lower case: `X00` to `X07`, `Y00` to `Y07`, `M00` to `M07`, `M10` to `M13`,
    /// `T0`, `T1`, `C0` and the counter's clear input `C0CLR`. Timers and the counter may have two digits (`T00`), as
    /// in places of the description. `None` for other names.
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
            (DeviceKind::Input, _) => write!(f, "X0{low}"),
            (DeviceKind::Output, _) => write!(f, "Y0{low}"),
            (DeviceKind::Relay, 2) => write!(f, "M0{low}"),
            (DeviceKind::Relay, _) => write!(f, "M1{low}"),
            (DeviceKind::Timer, _) => write!(f, "T{}", self.0 & 1),
            (DeviceKind::Counter, _) => f.write_str("C0"),
            (DeviceKind::Clear, _) => f.write_str("C0CLR"),
        }
    }
}

/// One word of the program memory: the opcode in bits 7 to 5, the device's address in bits 4 to 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Word(pub u8);

impl Word {
    /// The program word of an instruction.
    #[must_use]
    pub fn new(opcode: Opcode, device: Device) -> Word {
        Word((opcode as u8) << 5 | device.0)
    }

    /// The operation of the word.
    #[must_use]
    pub fn opcode(self) -> Opcode {
        Opcode::ALL[usize::from(self.0 >> 5)]
    }

    /// The device of the word.
    #[must_use]
    pub fn device(self) -> Device {
        Device::at(self.0)
    }

    /// Whether the word writes to an input, which is not possible.
    #[must_use]
    pub fn stores_to_input(self) -> bool {
        self.opcode().is_store() && self.device().kind() == DeviceKind::Input
    }
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.opcode().mnemonic(), self.device())
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
        // The description writes this word in bits.
        assert_eq!(
            Word::new(Opcode::Or, Device::from_name("Y00").expect("a device")).0,
            0b100_01000
        );
    }

    #[test]
    fn devices_are_those_of_the_description() {
        let table = [
            ("X00", 0b00000, DeviceKind::Input),
            ("X07", 0b00111, DeviceKind::Input),
            ("Y00", 0b01000, DeviceKind::Output),
            ("Y07", 0b01111, DeviceKind::Output),
            ("M00", 0b10000, DeviceKind::Relay),
            ("M07", 0b10111, DeviceKind::Relay),
            ("M10", 0b11000, DeviceKind::Relay),
            ("M13", 0b11011, DeviceKind::Relay),
            ("T0", 0b11100, DeviceKind::Timer),
            ("T1", 0b11101, DeviceKind::Timer),
            ("C0", 0b11110, DeviceKind::Counter),
            ("C0CLR", 0b11111, DeviceKind::Clear),
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

    #[test]
    fn words_take_apart_as_they_are_put_together() {
        for byte in 0..=255 {
            let word = Word(byte);
            assert_eq!(Word::new(word.opcode(), word.device()), word);
        }
    }
}
